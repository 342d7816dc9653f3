//! What every built-in scene is given: its light, its luminance and where it stands.

use serde::Serialize;

use super::SceneError;
use crate::numeric::{OutOfRange, require};
use crate::spectrum::{Illuminant, Spectrum, SpectrumError, WavelengthGrid};

/// Light, luminance, distance and size of a built-in scene.
///
/// The defaults are those with which ISETCam creates its charts: a mean luminance of 100 cd/m² (a well-lit
/// office), 1.2 m away, 10° wide, D65 on 400–700 nm in steps of 10.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setting {
    /// Mean luminance over all pixels, cd/m² (CIE 1931), 10⁻⁶ to 10¹².
    pub luminance_cd_m2: f64,
    /// Distance from the lens, m, more than 0.
    pub distance_m: f64,
    /// Full horizontal field of view, degrees, 10⁻⁶ to 170.
    pub horizontal_fov_deg: f64,
    /// The light on the scene.
    pub illuminant: Illuminant,
    /// The wavelengths to sample.
    pub grid: WavelengthGrid,
}

impl Default for Setting {
    fn default() -> Self {
        Self {
            luminance_cd_m2: 100.0,
            distance_m: 1.2,
            horizontal_fov_deg: 10.0,
            illuminant: Illuminant::D65,
            grid: WavelengthGrid::VISIBLE,
        }
    }
}

impl Setting {
    /// Relative photons of the light.
    pub(super) fn light(&self) -> Result<Spectrum, SceneError> {
        Ok(self.illuminant.photons(self.grid)?)
    }

    /// An error when a number is out of its range. Done first, before anything large is computed.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        require_luminance(self.luminance_cd_m2)?;
        require_distance(self.distance_m)?;
        require_fov(self.horizontal_fov_deg)
    }
}

/// The night sky between the stars is above 10⁻⁴ cd/m² and ten times the sun's disc is 2·10¹⁰ cd/m²; far beyond them single precision
/// would underflow or overflow.
pub(super) fn require_luminance(cd_m2: f64) -> Result<(), OutOfRange> {
    require((1e-6..=1e12).contains(&cd_m2), "luminance_cd_m2", cd_m2, "1e-6 to 1e12")
}

pub(super) fn require_distance(m: f64) -> Result<(), OutOfRange> {
    require((1e-6..=1e12).contains(&m), "distance_m", m, "1e-6 to 1e12")
}

/// A reflectance of a scene is on its grid and not negative.
pub(super) fn require_reflectance(reflectance: &Spectrum, grid: WavelengthGrid) -> Result<(), SpectrumError> {
    if reflectance.grid() != grid {
        return Err(SpectrumError::GridMismatch { left: reflectance.grid(), right: grid });
    }
    reflectance.check("a reflectance", |v| v >= 0.0, "reflectances are not negative")
}

/// A flat scene of 170° is 23 times as wide as it is far, and a lens images it on 23 focal lengths. Towards 180° both are infinite.
pub(crate) const MAX_FOV_DEG: f64 = 170.0;

pub(super) fn require_fov(deg: f64) -> Result<(), OutOfRange> {
    require((1e-6..=MAX_FOV_DEG).contains(&deg), "horizontal_fov_deg", deg, "1e-6 to 170")
}
