//! A chart of uniform colour patches of several sizes: every square is one patch or splits into four smaller
//! squares.

use super::compose::count_reflectances;
use super::compose::{Fragment, check_size, fragments, lit};
use super::{Scene, SceneError, Setting};
use crate::numeric::philox::Stream;
use crate::numeric::require;
use crate::spectrum::Spectrum;

/// Separates the random numbers of this pattern from other uses of the seed.
const PURPOSE: u32 = 0x7061_7463;
/// The fraction of divisible squares that are divided; each patch size then covers a quarter of the remaining
/// area.
const DIVIDED: f64 = 0.75;

/// Square patches, each of a single reflectance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorPatches {
    /// Rows, 1 to 32768.
    pub rows: usize,
    /// Columns, 1 to 32768.
    pub cols: usize,
    /// Side of the smallest patches in pixels, 1 to 4096.
    pub least_px: usize,
    /// Number of times that the side doubles, at most 8: the largest patches are `least_px` · 2^`doublings`.
    pub doublings: u32,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Draws the patches, each with a random one of the `reflectances` (on the grid of the setting). The right
/// and bottom borders of the image truncate squares.
///
/// # Errors
/// When a parameter or the setting is out of range, the list of reflectances is empty, or a reflectance is
/// negative or on another grid.
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
    let kinds = count_reflectances(reflectances, setting.grid)?;
    check_size(rows, cols, setting.grid)?;
    // Each pixel finds its square from the largest size downwards. Every square has its own random numbers,
    // so the order of evaluation does not matter.
    let painted_by = |row: usize, col: usize| -> (u32, usize) {
        for level in (0..=doublings).rev() {
            let side = least_px << level;
            let (down, right) = (row / side, col / side);
            // There are fewer than 2¹⁵ squares in each direction.
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
