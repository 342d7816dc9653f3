//! Measured reflectances: a colour chart and natural objects.

use super::generated::{COLORCHECKER, COLORCHECKER_NAMES, NATURAL, NATURAL_NAMES, Table};
use super::{Outside, Spectrum, SpectrumError, WavelengthGrid};

/// The 24 patches of the ColorChecker with their names, row by row from dark skin (so the grey series is last),
/// 0 to 1; measured 380–730 nm in steps of 10, constant beyond. Average of 30 charts (Pascale, BabelColor, 2012).
///
/// # Errors
/// Never for a valid grid.
pub fn colorchecker(grid: WavelengthGrid) -> Result<Vec<(&'static str, Spectrum)>, SpectrumError> {
    named(&COLORCHECKER, &COLORCHECKER_NAMES, grid)
}

/// Natural objects with their names: flowers, leaves, fruits, vegetables, barks and stones, 0 to 1; measured
/// 380–780 nm, constant beyond. A selection in steps of 10 nm from the 359 spectra of Morimoto et al. (2022),
/// "Spectral measurement of daylights and surface properties of natural objects in Japan", *Optics Express* 30(3),
/// <https://doi.org/10.5281/zenodo.5189606>, CC BY 4.0.
///
/// # Errors
/// Never for a valid grid.
pub fn natural(grid: WavelengthGrid) -> Result<Vec<(&'static str, Spectrum)>, SpectrumError> {
    named(&NATURAL, &NATURAL_NAMES, grid)
}

fn named<const N: usize>(
    table: &Table<N>,
    names: &[&'static str; N],
    grid: WavelengthGrid,
) -> Result<Vec<(&'static str, Spectrum)>, SpectrumError> {
    names.iter().enumerate().map(|(i, &name)| Ok((name, table.spectrum(i, grid, Outside::Hold)?))).collect()
}
