//! The optical image: irradiance on the sensor plane.

use rayon::prelude::*;

use crate::numeric::{Planes, require};
use crate::spectrum::{Observer, SpectralCube, SpectrumError};

/// Revision of the optical computation and of the spectra of built-in scenes. Increase it with every change that alters an optical image;
/// caches of older revisions are then invalid.
pub const OPTICAL_IMAGE_REVISION: u32 = 2;

/// Spectral irradiance on the sensor plane, photons s⁻¹ m⁻² nm⁻¹, centred on the optical axis. Sample `(r,
/// c)` is the mean over a square with a side of `sample_spacing_m`.
#[derive(Debug, Clone, PartialEq)]
pub struct OpticalImage {
    irradiance: SpectralCube,
    sample_spacing_m: f64,
}

impl OpticalImage {
    /// An optical image from its parts.
    ///
    /// # Errors
    /// When the spacing is not positive and finite.
    pub fn new(irradiance: SpectralCube, sample_spacing_m: f64) -> Result<Self, SpectrumError> {
        require(sample_spacing_m > 0.0, "sample_spacing_m", sample_spacing_m, "more than 0")?;
        Ok(Self { irradiance, sample_spacing_m })
    }

    /// The image with its irradiance multiplied by a factor.
    ///
    /// # Errors
    /// When the factor is negative or not finite, or a product exceeds the range of single precision.
    pub fn scaled(&self, factor: f64) -> Result<Self, SpectrumError> {
        require(factor >= 0.0, "factor", factor, "0 or more, finite")?;
        let planes = self.irradiance.planes();
        let data = planes.data().par_iter().map(|&v| (f64::from(v) * factor) as f32).collect();
        let (rows, cols, count) = (planes.rows(), planes.cols(), planes.count());
        let planes = Planes::new(rows, cols, count, data).map_err(SpectrumError::from)?;
        Self::new(SpectralCube::new(self.irradiance.grid(), planes)?, self.sample_spacing_m)
    }

    /// Spectral irradiance, photons s⁻¹ m⁻² nm⁻¹.
    #[must_use]
    pub fn irradiance(&self) -> &SpectralCube {
        &self.irradiance
    }

    /// Distance between neighbouring samples on the sensor, m, equal in both directions.
    #[must_use]
    pub fn sample_spacing_m(&self) -> f64 {
        self.sample_spacing_m
    }

    /// Illuminance of every sample, lux (CIE 1931), in row order.
    ///
    /// # Errors
    /// Never for a valid image.
    pub fn illuminance_lux(&self) -> Result<Vec<f32>, SpectrumError> {
        Observer::Cie1931.luminance_from_photons(&self.irradiance)
    }
}
