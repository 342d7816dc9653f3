//! What families of filters have in common.

use std::fmt::Debug;

use crate::design::error::DesignError;
use crate::numeric::philox::Stream;
use crate::sensor::Filter;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// A family of curves on some wavelengths.
pub(super) trait Curves: Debug + Send + Sync {
    /// Number of parameters of a filter.
    fn parameters(&self) -> usize;

    /// Random parameters of a filter.
    fn random(&self, random: &mut Stream) -> Vec<f64>;

    /// The transmittance at each wavelength.
    fn transmittance(&self, parameters: &[f64]) -> Vec<f64>;

    /// The derivative with respect to the parameters from that with respect to the transmittance at each wavelength.
    fn by_parameters(&self, parameters: &[f64], by_transmittance: &[f64]) -> Vec<f64>;

    /// Removes what a factory cannot make of the filters of an array. Returns whether it removed anything.
    fn prune(&self, _filters: &mut [Vec<f64>]) -> bool {
        false
    }

    /// The thickness of each pigment of a filter; `None` for other families.
    fn thicknesses(&self, _parameters: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// The thickness of each pigment of the fewest that make a filter of a transmittance; `None` for other families and other filters.
    fn layers(&self, _transmittance: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// Whether the divergence from any curve is a convex function of the parameters, so that every search for its minimum ends there.
    fn is_divergence_convex(&self) -> bool {
        false
    }

    /// Number of filters to choose from; `None` for families of continuous parameters.
    fn choices(&self) -> Option<usize> {
        None
    }
}

pub(super) fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-x))
}

/// An error about a key unless it fits.
pub(super) fn check(key: &str, fits: bool, found: f64, expected: &str) -> Result<(), DesignError> {
    if fits { Ok(()) } else { Err(DesignError::key(key, format!("{found}; expected {expected}"))) }
}

/// Checks a transmittance.
pub(super) fn check_share(key: &str, value: f64) -> Result<(), DesignError> {
    check(key, value > 0.0 && value <= 1.0, value, "more than 0 and at most 1")
}

/// The transmittances of a library on a grid, all of which transmit some light.
pub(super) fn library(
    key: &str,
    filters: &[Filter],
    grid: WavelengthGrid,
) -> Result<Vec<Spectrum>, DesignError> {
    if filters.is_empty() {
        return Err(DesignError::key(key, "expected at least one filter"));
    }
    let sampled = |(at, filter): (usize, &Filter)| {
        let wrong = |e: &dyn ToString| DesignError::key(format!("{key}[{at}]"), e.to_string());
        let spectrum = filter.spectrum(grid).map_err(|e| wrong(&e))?;
        match spectrum.max() > 0.0 {
            true => Ok(spectrum),
            false => Err(wrong(&"it transmits no light; expected a filter with some transmittance")),
        }
    };
    filters.iter().enumerate().map(sampled).collect()
}
