//! OpenEXR: spectral images (two layouts) and RGB pictures.
//!
//! A spectral file seldom says everything a scene needs. [`read`] returns what the file does say, unchanged;
//! [`SpectralFile::into_scene`] adds the rest from [`SceneDefaults`].

mod layout;
mod read;
mod rgb;
mod scene;
mod write;

use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

pub use layout::Layout;
pub use read::{from_bytes, is_spectral, read};
pub(crate) use rgb::rgb_from_bytes;
pub use scene::SceneDefaults;
pub use write::write;

use crate::Limits;

/// How files are read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Bounds on memory.
    pub limits: Limits,
    /// Take negative values (noise of a renderer or of a measurement) as zero: otherwise an error in
    /// spectra, kept in RGB.
    pub clamp_negative: bool,
    /// Wavelengths of a file that does not state them (PBRT layout).
    pub grid: Option<WavelengthGrid>,
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

/// What a spectral file says.
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

/// Facts that have no place in the layouts, kept as JSON in the attribute `comments`.
#[derive(Debug, Default, serde::Serialize, serde::Deserialize)]
struct Facts {
    name: String,
    quantity: String,
    start_nm: f64,
    step_nm: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    illuminant_photons: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    distance_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    horizontal_fov_deg: Option<f64>,
}

/// The JSON object in `comments`.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Comment {
    smalti: Facts,
}

const QUANTITIES: [(Quantity, &str); 4] = [
    (Quantity::Photons, "photons s^-1 m^-2 sr^-1 nm^-1"),
    (Quantity::Energy, "W m^-2 sr^-1 nm^-1"),
    (Quantity::RelativeEnergy, "relative energy"),
    (Quantity::Reflectance, "reflectance"),
];

#[cfg(test)]
mod tests;
