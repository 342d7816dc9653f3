//! Smooth gradients of colour and of illumination.

use rayon::prelude::*;

use super::compose::count_reflectances;
use super::compose::{Fragment, check_size, fragments, lit};
use super::{Scene, SceneError, Setting};
use crate::numeric::philox::Stream;
use crate::numeric::require;
use crate::spectrum::Spectrum;

/// Separates the random numbers of this pattern from other uses of the seed.
const PURPOSE: u32 = 0x6772_6164;

/// Colours at the nodes of a square lattice. Between nodes, reflectance is interpolated linearly and
/// illumination geometrically.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gradients {
    /// Rows, 1 to 32768.
    pub rows: usize,
    /// Columns, 1 to 32768.
    pub cols: usize,
    /// Distance between nodes in pixels, 2 to 32768.
    pub cell_px: usize,
    /// Ratio of the brightest to the darkest illumination, 1 to 10⁸.
    pub contrast_ratio: f64,
    /// Whether every node is white, so that only the illumination varies.
    pub neutral: bool,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Draws the gradients; a node has a random one of the `reflectances` (on the grid of the setting) and a
/// random illumination.
///
/// # Errors
/// When a parameter or the setting is out of range, the list of reflectances is empty, or a reflectance is
/// negative or on another grid.
pub fn gradients(
    pattern: &Gradients,
    reflectances: &[Spectrum],
    setting: &Setting,
) -> Result<Scene, SceneError> {
    let Gradients { rows, cols, cell_px, contrast_ratio, neutral, seed } = *pattern;
    require((1..=32768).contains(&rows), "rows", rows as f64, "1 to 32768")?;
    require((1..=32768).contains(&cols), "cols", cols as f64, "1 to 32768")?;
    require((2..=32768).contains(&cell_px), "cell_px", cell_px as f64, "2 to 32768")?;
    require((1.0..=1e8).contains(&contrast_ratio), "contrast_ratio", contrast_ratio, "1 to 1e8")?;
    check_size(rows, cols, setting.grid)?;
    let white = [Spectrum::constant(setting.grid, 1.0)?];
    let reflectances = if neutral { &white[..] } else { reflectances };
    let kinds = count_reflectances(reflectances, setting.grid)?;
    let node = |down: usize, right: usize| {
        let mut random = Stream::new(seed, PURPOSE, (down as u32) << 16 | right as u32);
        (random.below(kinds), -random.uniform() * contrast_ratio.ln())
    };
    let row_of = |row: usize| -> Vec<Fragment> {
        let mut out = Vec::with_capacity(4 * cols);
        let (down, v) = (row / cell_px, (row % cell_px) as f64 / cell_px as f64);
        for right in 0..cols.div_ceil(cell_px) {
            let corners = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(d, r)| node(down + d, right + r));
            for col in right * cell_px..((right + 1) * cell_px).min(cols) {
                let u = (col % cell_px) as f64 / cell_px as f64;
                let shares = [(1.0 - v) * (1.0 - u), (1.0 - v) * u, v * (1.0 - u), v * u];
                let light = corners.iter().zip(shares).map(|((_, l), s)| l * s).sum::<f64>().exp();
                let parts = corners.iter().zip(shares).filter(|(_, share)| *share > 0.0);
                out.extend(parts.map(|(&(spectrum, _), share)| Fragment {
                    col: col as u32,
                    spectrum,
                    weight: (share * light) as f32,
                }));
            }
        }
        out
    };
    let painted: Vec<_> = (0..rows).into_par_iter().map(row_of).collect();
    let light = setting.light()?;
    fragments("gradients", cols, &painted, &lit(reflectances, &light)?, &light, setting)
}
