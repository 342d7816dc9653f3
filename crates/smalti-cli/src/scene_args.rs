//! What is said of a scene on the command line.

use clap::{Args, ValueEnum};
use smalti_io::Quantity;
use smalti_io::scene_file::Crop;

use crate::args::number;

/// What a scene is when its file or name does not say.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct SceneOptions {
    /// Mean luminance, cd/m² [default: what the scene states, else 100]
    #[arg(long, value_name = "CD_M2", value_parser = number, allow_negative_numbers = true)]
    pub(crate) luminance: Option<f64>,
    /// Distance from the lens, m
    #[arg(long, value_name = "M", value_parser = number, allow_negative_numbers = true)]
    pub(crate) distance: Option<f64>,
    /// Horizontal field of view, degrees [default: the scene fills the sensor]
    #[arg(long, value_name = "DEGREES", value_parser = number, allow_negative_numbers = true)]
    pub(crate) fov: Option<f64>,
    /// Light of the scene: a name (smalti list illuminants) or a CSV of wavelength_nm and relative power; files are re-lit
    #[arg(long, value_name = "NAME")]
    pub(crate) illuminant: Option<String>,
    /// Wavelengths, nm; of a file that states none, those of its bands [default: those of the file, else 400:10:700]
    #[arg(long, value_name = "START:STEP:END")]
    pub(crate) wavelengths: Option<String>,
    /// What the values of a file are that does not state it
    #[arg(long, value_enum)]
    pub(crate) quantity: Option<FileQuantity>,
    /// Which variable, array or dataset of a file is the cube
    #[arg(long, value_name = "NAME")]
    pub(crate) variable: Option<String>,
    /// The part of a file to read: first row and column, from 0, then how many
    #[arg(long, value_name = "ROW,COL,ROWS,COLS")]
    pub(crate) crop: Option<Crop>,
    /// Take negative values of a spectral file, and those that say that nothing was measured, as 0
    #[arg(long)]
    pub(crate) clamp_negative: bool,
}

impl SceneOptions {
    /// The first option that was typed and has a meaning for files alone.
    pub(crate) fn of_files(&self) -> Option<&'static str> {
        [
            (self.quantity.is_some(), "--quantity"),
            (self.variable.is_some(), "--variable"),
            (self.crop.is_some(), "--crop"),
            (self.clamp_negative, "--clamp-negative"),
        ]
        .into_iter()
        .find_map(|(typed, name)| typed.then_some(name))
    }
}

/// What the values of a spectral file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FileQuantity {
    /// Radiance, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹
    Photons,
    /// Radiance, W m⁻² sr⁻¹ nm⁻¹
    Energy,
    /// Radiance in energy units up to a factor
    Relative,
    /// Reflectance, 0 to 1
    Reflectance,
}

impl From<FileQuantity> for Quantity {
    fn from(quantity: FileQuantity) -> Self {
        match quantity {
            FileQuantity::Photons => Self::Photons,
            FileQuantity::Energy => Self::Energy,
            FileQuantity::Relative => Self::RelativeEnergy,
            FileQuantity::Reflectance => Self::Reflectance,
        }
    }
}
