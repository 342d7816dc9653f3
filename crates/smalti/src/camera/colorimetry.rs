//! How well the spectral sensitivities of a camera tell colours apart as the standard observer does. Nothing is rendered.

use serde::Serialize;

use super::{Camera, CameraError};
use crate::isp::BLIND;
use crate::metrics::iso17321::MetamerismIndex;
use crate::metrics::logvinenko2014::MetamerMismatch;
use crate::metrics::vora1993::vora_value;
use crate::spectrum::Spectrum;

/// The colorimetry of a sensor: of the response of its channels through lens, infrared cut, filter and photodiode.
///
/// Crosstalk between pixels mixes the channels, which changes none of the three figures, and is left out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SensorColorimetry {
    /// Vora value, 0 to 1: 1 for a sensor that fulfils the Luther condition.
    pub vora_value: f64,
    /// Sensitivity metamerism index of ISO 17321-1 under the light of the evaluation, at most 100.
    pub sensitivity_metamerism_index: f64,
    /// Range of X, Y, Z of the reflectances that the sensor cannot tell from a mid grey, percent of the range of all objects, mean
    /// of the three.
    pub metamer_mismatch_percent: f64,
}

/// The standard observer under one light, with which the colorimetry of any sensor is compared.
#[derive(Debug, Clone)]
pub struct ColorimetricObserver {
    light: Spectrum,
    index: MetamerismIndex,
    mismatch: MetamerMismatch,
}

impl ColorimetricObserver {
    /// The observer under a light (photons).
    ///
    /// # Errors
    /// When the light is dark to the observer.
    pub fn new(light: &Spectrum) -> Result<Self, CameraError> {
        Ok(Self {
            light: light.clone(),
            index: MetamerismIndex::new(light)?,
            mismatch: MetamerMismatch::new(light)?,
        })
    }

    /// The light (photons).
    #[must_use]
    pub fn light(&self) -> &Spectrum {
        &self.light
    }

    /// The colorimetry of the sensor of a camera on the grid of the light. As in the colour matrix, a channel whose response to
    /// white is below a thousandth of the brightest is left out.
    ///
    /// # Errors
    /// When the grids differ or no channel responds to the light.
    pub fn colorimetry(&self, camera: &Camera) -> Result<SensorColorimetry, CameraError> {
        let channels = camera.responsivities()?;
        let white = |c: &Spectrum| Ok(c.times(&self.light)?.integral());
        let whites = channels.iter().map(white).collect::<Result<Vec<f64>, CameraError>>()?;
        let brightest = whites.iter().copied().fold(0.0, f64::max);
        let sees = |(c, white): (Spectrum, &f64)| (*white >= BLIND * brightest).then_some(c);
        let channels: Vec<Spectrum> = channels.into_iter().zip(&whites).filter_map(sees).collect();
        Ok(SensorColorimetry {
            vora_value: vora_value(&channels)?,
            sensitivity_metamerism_index: self.index.of(&channels)?,
            metamer_mismatch_percent: self.mismatch.mean_percent(&channels)?,
        })
    }
}
