//! What every built-in scene is given: its light, its luminance and where it stands.

use serde::Serialize;

use super::SceneError;
use crate::numeric::{OutOfRange, require};
use crate::spectrum::{Illuminant, Spectrum, WavelengthGrid};

/// Light, luminance, distance and size of a built-in scene.
///
/// The defaults are those with which ISETCam creates its charts: a mean luminance of 100 cd/m² (a well-lit
/// office), 1.2 m away, 10° wide, D65 on 400–700 nm in steps of 10.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setting {
    /// Mean luminance over all pixels, cd/m² (CIE 1931), more than 0 and at most 10¹².
    pub luminance_cd_m2: f64,
    /// Distance from the lens, m, more than 0.
    pub distance_m: f64,
    /// Full horizontal field of view, degrees, between 0 and 180.
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

/// Ten times the sun's disc is 2·10¹⁰ cd/m²; far above it single precision would overflow.
pub(super) fn require_luminance(cd_m2: f64) -> Result<(), OutOfRange> {
    require(cd_m2 > 0.0 && cd_m2 <= 1e12, "luminance_cd_m2", cd_m2, "more than 0 and at most 1e12")
}

pub(super) fn require_distance(m: f64) -> Result<(), OutOfRange> {
    require(m > 0.0, "distance_m", m, "more than 0")
}

pub(super) fn require_fov(deg: f64) -> Result<(), OutOfRange> {
    require(deg > 0.0 && deg < 180.0, "horizontal_fov_deg", deg, "between 0 and 180")
}
