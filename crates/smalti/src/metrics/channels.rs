//! The channels of a sensor as vectors over wavelength.

use super::MetricError;
use crate::numeric::orthonormal::orthonormal_basis;
use crate::spectrum::{Spectrum, SpectrumError, WavelengthGrid};

/// Orthonormal vectors that span the curves, each multiplied by a weight.
pub(super) fn weighted_basis(
    what: &'static str,
    curves: &[Spectrum],
    weight: &Spectrum,
) -> Result<Vec<Vec<f64>>, MetricError> {
    super::error::at_least(what, 1, curves.len())?;
    let weighted = curves.iter().map(|c| Ok(c.times(weight)?.values().to_vec()));
    let basis = orthonormal_basis(&weighted.collect::<Result<Vec<_>, MetricError>>()?);
    if basis.is_empty() {
        let reason = "no channel responds to the light";
        return Err(MetricError::Undefined { quantity: "the colorimetry of a sensor", reason });
    }
    Ok(basis)
}

/// Checks that curves are on the grid of the light.
pub(super) fn on_grid(curves: &[Spectrum], grid: WavelengthGrid) -> Result<(), MetricError> {
    match curves.iter().find(|c| c.grid() != grid) {
        Some(c) => Err(SpectrumError::GridMismatch { left: c.grid(), right: grid }.into()),
        None => Ok(()),
    }
}
