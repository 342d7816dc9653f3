//! The scene: a flat image of spectral radiance at a distance.

use thiserror::Error;

use crate::spectrum::{Observer, SpectralCube, Spectrum, SpectrumError};

/// What can be wrong with a scene.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A parameter is out of its range.
    #[error("{name} is {value}; expected {expected}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range.
        expected: &'static str,
    },
    /// Spectral data do not fit.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}

/// Spectral radiance of a plane that faces the camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    name: String,
    radiance: SpectralCube,
    illuminant: Spectrum,
    distance_m: f64,
    horizontal_fov_deg: f64,
}

impl Scene {
    /// A scene from its parts. `radiance` and `illuminant` (the radiance of a perfect white diffuser under the
    /// scene's light) are photons s⁻¹ m⁻² sr⁻¹ nm⁻¹ on one grid.
    ///
    /// # Errors
    /// When the grids differ, the distance is not positive, or the field of view is not within 0–180°.
    pub fn new(
        name: impl Into<String>,
        radiance: SpectralCube,
        illuminant: Spectrum,
        distance_m: f64,
        horizontal_fov_deg: f64,
    ) -> Result<Self, SceneError> {
        if radiance.grid() != illuminant.grid() {
            return Err(
                SpectrumError::GridMismatch { left: radiance.grid(), right: illuminant.grid() }.into()
            );
        }
        if !(distance_m.is_finite() && distance_m > 0.0) {
            return Err(SceneError::Parameter {
                name: "distance_m",
                value: distance_m,
                expected: "more than 0",
            });
        }
        if !(horizontal_fov_deg > 0.0 && horizontal_fov_deg < 180.0) {
            return Err(SceneError::Parameter {
                name: "horizontal_fov_deg",
                value: horizontal_fov_deg,
                expected: "between 0 and 180",
            });
        }
        Ok(Self { name: name.into(), radiance, illuminant, distance_m, horizontal_fov_deg })
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Photons s⁻¹ m⁻² sr⁻¹ nm⁻¹.
    #[must_use]
    pub fn radiance(&self) -> &SpectralCube {
        &self.radiance
    }

    /// Radiance of a perfect white diffuser under the scene's light, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹.
    #[must_use]
    pub fn illuminant(&self) -> &Spectrum {
        &self.illuminant
    }

    /// Distance from the lens, m.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        self.distance_m
    }

    /// Full horizontal field of view, degrees.
    #[must_use]
    pub fn horizontal_fov_deg(&self) -> f64 {
        self.horizontal_fov_deg
    }

    /// Mean luminance, cd/m² (CIE 1931).
    ///
    /// # Errors
    /// Never for a valid scene.
    pub fn mean_luminance_cd_m2(&self) -> Result<f64, SceneError> {
        let y = &Observer::Cie1931.photon_weights(self.radiance.grid())?[1];
        let planes = self.radiance.planes();
        let sum: f64 = planes
            .planes()
            .zip(y.values())
            .map(|(p, w)| w * p.iter().map(|&v| f64::from(v)).sum::<f64>())
            .sum();
        Ok(sum / planes.plane_len() as f64)
    }
}
