//! The ColorChecker ("Macbeth chart"): 24 matt patches in four rows of six.
//!
//! Patches are numbered row by row from dark skin (top left) to black (bottom right); the last row is the
//! grey series from white to black. They are adjacent squares without a frame, as in ISETCam's chart. Tables
//! made with ISETCam often number the patches column by column instead.

use super::compose::{Fragment, check_size, count_reflectances, fragments, lit};
use super::{Scene, SceneError, Setting};
use crate::numeric::require;
use crate::spectrum::generated::COLORCHECKER;
use crate::spectrum::{Extrapolation, Spectrum, WavelengthGrid};

/// Rows of patches.
pub const ROWS: usize = 4;
/// Columns of patches.
pub const COLS: usize = 6;

/// The reflectances of the 24 patches (average of 30 charts, 380–730 nm; held constant beyond), row by row
/// from dark skin.
///
/// # Errors
/// Never for a valid grid.
pub fn reflectances(grid: WavelengthGrid) -> Result<Vec<Spectrum>, SceneError> {
    (0..ROWS * COLS).map(|i| Ok(COLORCHECKER.spectrum(i, grid, Extrapolation::Hold)?)).collect()
}

/// The chart, 4 × 6 patches of `patch_px` × `patch_px` pixels.
///
/// # Errors
/// When `patch_px` is 0, the scene would be too large, or the setting is out of range.
pub fn chart(patch_px: usize, setting: &Setting) -> Result<Scene, SceneError> {
    size(patch_px, setting)?;
    chart_of(&reflectances(setting.grid)?, patch_px, setting)
}

/// Rows and columns of pixels. Fails when there would be none or too many.
fn size(patch_px: usize, setting: &Setting) -> Result<(usize, usize), SceneError> {
    require(patch_px > 0, "patch_px", patch_px as f64, "at least 1")?;
    let (rows, cols) = (ROWS.saturating_mul(patch_px), COLS.saturating_mul(patch_px));
    check_size(rows, cols, setting.grid)?;
    Ok((rows, cols))
}

/// The chart with other reflectances: 24 of them, row by row, on the grid of the setting.
///
/// # Errors
/// As for [`chart`], and when there are not 24 reflectances, or one is negative or on another grid.
pub fn chart_of(reflectances: &[Spectrum], patch_px: usize, setting: &Setting) -> Result<Scene, SceneError> {
    if reflectances.len() != ROWS * COLS {
        return Err(SceneError::Reflectances { got: reflectances.len(), expected: "24, row by row" });
    }
    count_reflectances(reflectances, setting.grid)?;
    let (rows, cols) = size(patch_px, setting)?;
    let row_of = |row: usize| -> Vec<Fragment> {
        let first = row / patch_px * COLS;
        (0..cols)
            .map(|col| Fragment { col: col as u32, spectrum: (first + col / patch_px) as u32, weight: 1.0 })
            .collect()
    };
    let painted: Vec<_> = (0..rows).map(row_of).collect();
    let light = setting.light()?;
    fragments("macbeth", cols, &painted, &lit(reflectances, &light)?, &light, setting)
}
