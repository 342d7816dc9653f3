//! A chart of even patches of several sizes, for colours: every square is one patch or four smaller squares.

use super::compose::{Fragment, check_size, fragments, lit};
use super::error::require;
use super::macbeth::check_reflectances;
use super::{Scene, SceneError, Setting};
use crate::numeric::philox::Stream;
use crate::spectrum::Spectrum;

/// Separates the random numbers of this pattern from other uses of a seed.
const PURPOSE: u32 = 0x7061_7463;
/// Of the squares that may be divided, so many are: every halving of the side then covers a quarter of what is left.
const DIVIDED: f64 = 0.75;

/// Square patches, each of one reflectance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorPatches {
    /// Rows, 1 to 32768.
    pub rows: usize,
    /// Columns, 1 to 32768.
    pub cols: usize,
    /// Side of the smallest patches in pixels, 1 to 4096.
    pub least_px: usize,
    /// How often the side may double: the largest are `least_px` · 2^`doublings`, at most 8.
    pub doublings: u32,
    /// Equal seeds give equal pictures.
    pub seed: u64,
}

impl Default for ColorPatches {
    /// Patches of 8 to 128 pixels.
    fn default() -> Self {
        Self { rows: 512, cols: 512, least_px: 8, doublings: 4, seed: 1 }
    }
}

/// Draws the patches, each with one of the `reflectances` (on the grid of the setting) at random. Squares are cut at the right
/// and at the bottom.
///
/// # Errors
/// When a parameter or the setting is out of its range, there is no reflectance, one is negative, or their grid is another.
pub fn color_patches(
    chart: &ColorPatches,
    reflectances: &[Spectrum],
    setting: &Setting,
) -> Result<Scene, SceneError> {
    let ColorPatches { rows, cols, least_px, doublings, seed } = *chart;
    require((1..=32768).contains(&rows), "rows", rows as f64, "1 to 32768")?;
    require((1..=32768).contains(&cols), "cols", cols as f64, "1 to 32768")?;
    require((1..=4096).contains(&least_px), "least_px", least_px as f64, "1 to 4096")?;
    require(doublings <= 8, "doublings", f64::from(doublings), "0 to 8")?;
    let kinds = u32::try_from(reflectances.len()).unwrap_or(0);
    if kinds == 0 {
        return Err(SceneError::Reflectances { got: reflectances.len(), expected: "at least 1" });
    }
    check_reflectances(reflectances, setting.grid)?;
    check_size(rows, cols, setting.grid)?;
    // The square of a pixel is found from the largest down, each with random numbers of its own: no order of drawing matters.
    let painted_by = |row: usize, col: usize| -> (u32, usize) {
        for level in (0..=doublings).rev() {
            let side = least_px << level;
            let (down, right) = (row / side, col / side);
            // Fewer than 2¹⁵ in each direction.
            let place = (down as u32) << 16 | right as u32;
            let mut random = Stream::new(seed, PURPOSE + level, place);
            if level == 0 || random.uniform() >= DIVIDED {
                return (random.below(kinds), (right + 1) * side);
            }
        }
        (0, cols)
    };
    let row_of = |row: usize| -> Vec<Fragment> {
        let mut out = Vec::with_capacity(cols);
        while out.len() < cols {
            let (spectrum, end) = painted_by(row, out.len());
            let from = out.len() as u32..end.min(cols) as u32;
            out.extend(from.map(|col| Fragment { col, spectrum, weight: 1.0 }));
        }
        out
    };
    let painted: Vec<_> = (0..rows).map(row_of).collect();
    let light = setting.light()?;
    fragments("color-patches", cols, &painted, &lit(reflectances, &light)?, &light, setting)
}
