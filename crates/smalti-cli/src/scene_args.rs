//! Options of scenes.

use clap::Args;
use smalti_io::Quantity;
use smalti_io::scene_file::{Crop, Upsampling};

use crate::args::{Choice, choice};
use crate::numbers::number;

/// Properties of a scene that its file or name does not state.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct SceneOptions {
    /// Mean luminance, cd/m² [default: that of the scene, else 100]
    #[arg(long, value_name = "CD_M2", value_parser = number, allow_negative_numbers = true)]
    pub(crate) luminance: Option<f64>,
    /// Distance from the lens, m
    #[arg(long, value_name = "M", value_parser = number, allow_negative_numbers = true)]
    pub(crate) distance: Option<f64>,
    /// Horizontal field of view, degrees [default: the scene fills the sensor]
    #[arg(long, value_name = "DEGREES", value_parser = number, allow_negative_numbers = true)]
    pub(crate) fov: Option<f64>,
    /// Illuminant of the scene: a name (smalti list illuminants) or a CSV of wavelength_nm and relative power. Files are relit
    #[arg(long, value_name = "NAME")]
    pub(crate) illuminant: Option<String>,
    /// Wavelengths, nm; for a file that states none, those of its bands [default: those of the file, else 400:10:700]
    #[arg(long, value_name = "START:STEP:END")]
    pub(crate) wavelengths: Option<String>,
    /// Quantity of the values of a file that does not state it
    #[arg(long, value_parser = choice(&QUANTITIES))]
    pub(crate) quantity: Option<Quantity>,
    /// Variable, array or dataset of a file that holds the spectral cube
    #[arg(long, value_name = "NAME")]
    pub(crate) variable: Option<String>,
    /// Part of a file to read: first row and column, counted from 0, then the number of rows and columns
    #[arg(long, value_name = "ROW,COL,ROWS,COLS")]
    pub(crate) crop: Option<Crop>,
    /// Replace negative values of a spectral file and its no-data values by 0
    #[arg(long)]
    pub(crate) clamp_negative: bool,
    /// Spectra of a picture [default: smooth]
    #[arg(long, value_parser = choice(&UPSAMPLINGS))]
    pub(crate) upsampling: Option<Upsampling>,
}

impl SceneOptions {
    /// Whether the option or a parameter of the scene states the field of view.
    pub(crate) fn states_fov(&self, scene: &str) -> bool {
        self.fov.is_some() || scene.contains("fov=")
    }

    /// The first given option that applies to files only.
    pub(crate) fn of_files(&self) -> Option<&'static str> {
        [
            (self.quantity.is_some(), "--quantity"),
            (self.variable.is_some(), "--variable"),
            (self.crop.is_some(), "--crop"),
            (self.clamp_negative, "--clamp-negative"),
            (self.upsampling.is_some(), "--upsampling"),
        ]
        .into_iter()
        .find_map(|(given, name)| given.then_some(name))
    }
}

const UPSAMPLINGS: [Choice<Upsampling>; 2] = [
    (
        "smooth",
        "Smooth reflectances of three coefficients, by the colour of the pixel alone",
        Upsampling::Smooth,
    ),
    (
        "measured",
        "Mixtures of measured reflectances that are near in colour within a segment",
        Upsampling::Measured,
    ),
];

const QUANTITIES: [Choice<Quantity>; 4] = [
    ("photons", "Radiance, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹", Quantity::Photons),
    ("energy", "Radiance, W m⁻² sr⁻¹ nm⁻¹", Quantity::Energy),
    ("relative", "Radiance in energy units, up to a constant factor", Quantity::RelativeEnergy),
    ("reflectance", "Reflectance, 0 to 1", Quantity::Reflectance),
];
