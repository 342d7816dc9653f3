//! The Vora value of a sensor: how much of the standard observer's space of colours its channels span.
//!
//! P. L. Vora and H. J. Trussell (1993), "Measure of goodness of a set of color-scanning filters", *Journal of the Optical Society of
//! America A* 10(7), 1499–1508 ([vora1993]). With P_S and P_V the orthogonal projectors onto the spaces that the spectral sensitivities of
//! the sensor and the colour matching functions span,
//!
//! ν = trace(P_S P_V) / dim V,
//!
//! the mean of cos² of the principal angles between the two spaces. It is 1 if and only if the colour matching functions are
//! linear combinations of the channels (the Maxwell–Ives or Luther condition), 0 for channels that see nothing of what the
//! observer sees. It does not change when the channels are mixed invertibly, and cannot fall when one is added.
//!
//! Noise plays no role: a channel that differs little from a sum of the others counts as a full dimension.
//!
//! [vora1993]: https://doi.org/10.1364/JOSAA.10.001499

use super::MetricError;
use super::channels::weighted_basis;
use crate::numeric::orthonormal::dot;
use crate::spectrum::{Observer, Spectrum};

/// The Vora value of channels, given as response per photon, against the colour matching functions of the CIE 1931 observer, 0 to 1.
///
/// Both sets are compared as responses to radiant power at every wavelength of the grid, without a light.
///
/// # Errors
/// When there is no channel, grids differ, or no channel responds.
pub fn vora_value(channels: &[Spectrum]) -> Result<f64, MetricError> {
    let grid = channels.first().ok_or(MetricError::TooFew { what: "channels", minimum: 1, got: 0 })?.grid();
    // A joule has as many photons as its wavelength is long.
    let photons_per_power = Spectrum::from_fn(grid, |nm| nm)?;
    let sensor = weighted_basis("channels", channels, &photons_per_power)?;
    let functions = Observer::Cie1931.matching_functions(grid)?;
    let observer = weighted_basis("colour matching functions", &functions, &Spectrum::constant(grid, 1.0)?)?;
    let trace: f64 = sensor.iter().flat_map(|s| observer.iter().map(|v| dot(s, v).powi(2))).sum();
    Ok(trace / observer.len() as f64)
}
