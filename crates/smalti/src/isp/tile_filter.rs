//! A linear pipeline for one mosaic: demosaicking and one output of the colour matrix as one filter per cell of the tile.

use super::IspError;
use super::demosaic::Plan;
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::Mosaic;

/// Lanes of a vector of pixels.
const LANES: usize = 16;

/// One output plane from normalised raw samples. Each pixel is a weighted sum of the samples around it, with weights for its
/// cell of the tile. It is defined where all samples within the reach exist.
#[derive(Debug, Clone)]
pub(crate) struct TileFilter {
    reach: usize,
    rows: usize,
    /// Period of the weights along a row, in vectors.
    period: usize,
    /// By row of the tile, then sample (in row order within the reach), then vector.
    weights: Vec<[f32; LANES]>,
}

impl TileFilter {
    /// The sum of the interpolated channels of a mosaic, each multiplied by its factor.
    pub(crate) fn new(interpolation: &Plan, mosaic: &Mosaic, factors: &[f32]) -> Self {
        let (reach, rows, period) = (interpolation.reach(), mosaic.rows(), mosaic.cols());
        let side = 2 * reach + 1;
        let mut weights = vec![[0.0; LANES]; rows * side * side * period];
        for (row, of_row) in weights.chunks_exact_mut(side * side * period).enumerate() {
            for col in 0..period {
                let mut cell = vec![0.0f32; side * side];
                for (channel, factor) in factors.iter().enumerate() {
                    for t in interpolation.taps(row, col, channel) {
                        let at = (reach as i32 + t.row) as usize * side + (reach as i32 + t.col) as usize;
                        cell[at] += factor * t.weight;
                    }
                }
                for (tap, vectors) in of_row.chunks_exact_mut(period).enumerate() {
                    let lanes = vectors.as_flattened_mut().iter_mut().skip(col).step_by(period);
                    lanes.for_each(|w| *w = cell[tap]);
                }
            }
        }
        Self { reach, rows, period, weights }
    }

    /// The plane of `raw`, which has `cols` columns and begins with a whole tile. A margin as wide as the reach is 0.
    ///
    /// # Errors
    /// When the image is not larger than the margin.
    pub(crate) fn apply(&self, raw: &[f32], cols: usize) -> Result<Vec<f32>, IspError> {
        let rows = raw.len() / cols.max(1);
        let side = 2 * self.reach + 1;
        if rows < side || cols < side {
            return Err(IspError::Empty("pixels with all the samples around them that a pipeline needs"));
        }
        let mut out = vec![0.0; raw.len()];
        dispatch(Rows { filter: self, raw, cols, out: &mut out });
        Ok(out)
    }
}

struct Rows<'a> {
    filter: &'a TileFilter,
    raw: &'a [f32],
    cols: usize,
    out: &'a mut [f32],
}

impl Kernel for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let TileFilter { reach, rows, period, weights } = self.filter;
        let (reach, period, side) = (*reach, *period, 2 * self.filter.reach + 1);
        let count = self.raw.len() / self.cols;
        let taps = side * side * period;
        for row in reach..count - reach {
            let weights = &weights[row % rows * taps..][..taps];
            let out = &mut self.out[row * self.cols..(row + 1) * self.cols];
            for (v, out) in out.chunks_mut(LANES).enumerate() {
                let first = v * LANES;
                // The columns with all samples. Vectors are aligned to the period, so the range is cut within them.
                let (from, to) =
                    (reach.saturating_sub(first), (self.cols - reach).saturating_sub(first).min(LANES));
                if from >= to {
                    continue;
                }
                let mut sums = [0.0f32; LANES];
                for i in 0..side {
                    let line = (row + i - reach) * self.cols;
                    for j in 0..side {
                        let w = &weights[(i * side + j) * period + v % period];
                        let at = (line + first + j) as isize - reach as isize;
                        match usize::try_from(at)
                            .ok()
                            .and_then(|at| self.raw.get(at..)?.first_chunk::<LANES>())
                        {
                            Some(samples) => {
                                for l in 0..LANES {
                                    sums[l] += w[l] * samples[l];
                                }
                            }
                            None => {
                                for l in from..to {
                                    sums[l] += w[l] * self.raw[(at + l as isize) as usize];
                                }
                            }
                        }
                    }
                }
                for (l, o) in out.iter_mut().enumerate().take(to).skip(from) {
                    *o = sums[l];
                }
            }
        }
    }
}
