//! Metamer mismatching between a sensor and the standard observer.
//!
//! Reflectances that the sensor cannot tell from a grey have many colours for the observer. Their X, Y, Z fill the metamer mismatch body
//! (A. D. Logvinenko, B. Funt and C. Godau (2014), "Metamer mismatching", *IEEE Transactions on Image Processing* 23(1), 34–43,
//! [logvinenko2014]). This module computes the extents of the body of the grey of reflectance 1/2 along X, Y and Z, as shares
//! of the extents that the colours of all objects have.
//!
//! With φ_k the channels and ψ one of the colour matching functions, all under the light, the largest difference of ψ · (1/2 + s/2) from
//! grey over all s with |s_λ| ≤ 1 and φ_k · s = 0 is, by the duality of linear programmes,
//!
//! ½ min_μ Σ_λ |ψ_λ − Σ_k μ_k φ_kλ|,
//!
//! half the least sum of absolute deviations of ψ from a combination of the channels. Without the condition on φ_k it
//! is ½ Σ_λ |ψ_λ|. Their ratio is 0 when the channels span ψ, and 1 for a sensor that says nothing about ψ. Reflectances
//! take any value from 0 to 1 at each wavelength, as in the definition of the body. It is therefore a bound: reflectances of real surfaces are
//! smoother, and mismatch less.
//!
//! [logvinenko2014]: https://doi.org/10.1109/TIP.2013.2283148

use super::MetricError;
use super::channels::{on_grid, weighted_basis};
use crate::numeric::bloomfield_steiger1980::least_absolute_sum;
use crate::spectrum::{Observer, Spectrum};

/// The colour matching functions under one light, for the mismatch of any sensor.
#[derive(Debug, Clone)]
pub struct MetamerMismatch {
    light: Spectrum,
    observer: [Spectrum; 3],
}

impl MetamerMismatch {
    /// The CIE 1931 observer under a light (photons per nm, in any unit).
    ///
    /// # Errors
    /// When the light is dark to the observer.
    pub fn new(light: &Spectrum) -> Result<Self, MetricError> {
        let [x, y, z] = Observer::Cie1931.photon_weights(light.grid())?.map(|w| w.times(light));
        let observer = [x?, y?, z?];
        if observer.iter().any(|f| f.integral() <= 0.0) {
            let reason = "the light is dark to the observer";
            return Err(MetricError::Undefined { quantity: "the metamer mismatch", reason });
        }
        Ok(Self { light: light.clone(), observer })
    }

    /// The extents of the metamer mismatch body of grey along X, Y and Z, percent of those of all object colours. Channels
    /// are given as response per photon up to a factor.
    ///
    /// # Errors
    /// When there is no channel, a grid is not that of the light, or no channel responds.
    pub fn percent(&self, channels: &[Spectrum]) -> Result<[f64; 3], MetricError> {
        on_grid(channels, self.light.grid())?;
        let basis = weighted_basis("channels", channels, &self.light)?;
        let mut percent = [0.0; 3];
        for (share, function) in percent.iter_mut().zip(&self.observer) {
            let whole: f64 = function.values().iter().sum();
            let rest = least_absolute_sum(&basis, function.values()).ok_or(MetricError::Undefined {
                quantity: "the metamer mismatch",
                reason: "the channels are linearly dependent",
            })?;
            *share = 100.0 * rest / whole;
        }
        Ok(percent)
    }

    /// The mean of the three extents, percent.
    ///
    /// # Errors
    /// As [`MetamerMismatch::percent`].
    pub fn mean_percent(&self, channels: &[Spectrum]) -> Result<f64, MetricError> {
        Ok(self.percent(channels)?.iter().sum::<f64>() / 3.0)
    }
}
