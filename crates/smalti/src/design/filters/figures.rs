//! Centre, width and peak of a filter.

use crate::sensor::{CfaError, Filter};
use crate::spectrum::{Extrapolation, Spectrum, WavelengthGrid};

/// Full width at half maximum of a Gaussian, standard deviations: 2 √(2 ln 2).
pub(super) const FWHM_PER_SIGMA: f64 = 2.354_820_045_030_949_3;

/// Centre, width and peak of a filter, for tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterFigures {
    /// Centre of a filter that is defined by one, otherwise the mean wavelength, nm; infinite for a filter that passes nothing
    /// between 400 and 700 nm.
    pub center_nm: f64,
    /// Width in which the transmittance is at least half of its peak, nm.
    pub fwhm_nm: f64,
    /// Largest transmittance.
    pub peak: f64,
}

impl FilterFigures {
    /// The figures from the formula of the filter, or from samples at every nanometre from 400 to 700.
    ///
    /// # Errors
    /// When the filter cannot be sampled there.
    pub fn new(filter: &Filter) -> Result<Self, CfaError> {
        match *filter {
            Filter::Gaussian { center_nm, sigma_nm, peak } => {
                Ok(Self { center_nm, fwhm_nm: FWHM_PER_SIGMA * sigma_nm, peak })
            }
            Filter::RaisedCosine { center_nm, fwhm_nm, peak }
            | Filter::Butterworth { center_nm, fwhm_nm, peak, .. } => Ok(Self { center_nm, fwhm_nm, peak }),
            ref other => {
                let curve = other.spectrum(WavelengthGrid::new(400.0, 1.0, 301)?)?;
                let peak = curve.max();
                let fwhm_nm = curve.values().iter().filter(|v| **v >= 0.5 * peak).count() as f64;
                Ok(Self { center_nm: mean_wavelength_nm(other)?, fwhm_nm, peak })
            }
        }
    }
}

/// Mean wavelength of the transmittance between 400 and 700 nm, per photon. It is infinite when the filter passes nothing
/// there, so that infrared filters come last.
pub(in crate::design) fn mean_wavelength_nm(filter: &Filter) -> Result<f64, CfaError> {
    let grid = WavelengthGrid::VISIBLE;
    let curve = match filter {
        // A measured curve may end within the range; it counts as 0 beyond its end.
        Filter::Samples { start_nm, step_nm, values } => {
            let own = WavelengthGrid::new(*start_nm, *step_nm, values.len())?;
            Spectrum::new(own, values.clone())?.resampled(grid, Extrapolation::Zero)?
        }
        other => other.spectrum(grid)?,
    };
    let sum = curve.integral();
    Ok(if sum > 0.0 { curve.map(|nm, v| nm * v)?.integral() / sum } else { f64::INFINITY })
}
