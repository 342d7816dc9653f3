//! The content of a spectral file of any format.

use std::str::FromStr;

use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

use super::crop::Crop;
use super::upsampling::Upsampling;
use crate::Limits;
use crate::file::Negative;

/// How files are read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Bounds on memory.
    pub limits: Limits,
    /// Take negative values (noise of a renderer or of a measurement) as zero: otherwise an error in
    /// spectra, kept in RGB.
    pub clamp_negative: bool,
    /// Wavelengths of a file that states none (PBRT layout, folders of bands, bare arrays).
    pub grid: Option<WavelengthGrid>,
    /// What the values are in a file that does not state it; each format documents what it assumes otherwise.
    pub quantity: Option<Quantity>,
    /// Which variable or dataset holds the cube, in a file that has several.
    pub variable: Option<String>,
    /// The part of the image that is wanted; formats that can read no more than it.
    pub crop: Option<Crop>,
    /// How a picture becomes spectra; smooth if not stated.
    pub upsampling: Option<Upsampling>,
}

impl ReadOptions {
    /// How negative samples are treated unless the options require zeros.
    pub(crate) fn negative_or(&self, otherwise: Negative) -> Negative {
        if self.clamp_negative { Negative::Clamp } else { otherwise }
    }
}

/// What the values of a spectral image are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Spectral radiance, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹.
    Photons,
    /// Spectral radiance, W m⁻² sr⁻¹ nm⁻¹.
    Energy,
    /// Spectral radiance in energy units, up to an unknown factor.
    RelativeEnergy,
    /// Reflectance or transmittance, 0 to 1.
    Reflectance,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Photons, Self::Energy, Self::RelativeEnergy, Self::Reflectance];

    /// How files call it: its unit, where it has one.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Photons => "photons s^-1 m^-2 sr^-1 nm^-1",
            Self::Energy => "W m^-2 sr^-1 nm^-1",
            Self::RelativeEnergy => "relative energy",
            Self::Reflectance => "reflectance",
        }
    }
}

impl FromStr for Quantity {
    type Err = ();

    /// From its [name](Self::name).
    fn from_str(name: &str) -> Result<Self, ()> {
        Self::ALL.into_iter().find(|q| q.name() == name).ok_or(())
    }
}

/// The content of a spectral file.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralFile {
    /// What the image is called: as stated, or the name of the file.
    pub name: String,
    /// The values as in the file. Where its wavelengths are not equidistant they are resampled linearly on a grid
    /// from the first to the last, with the smallest distance (rounded down to fit) as step and at most twice as
    /// many samples as the file has.
    pub cube: SpectralCube,
    /// What they are.
    pub quantity: Quantity,
    /// Radiance of a perfect white diffuser, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹ (relative photons where
    /// the values are relative or reflectances), on the grid of the cube.
    pub illuminant: Option<Spectrum>,
    /// Distance from the camera, m.
    pub distance_m: Option<f64>,
    /// Full horizontal field of view, degrees.
    pub horizontal_fov_deg: Option<f64>,
}
