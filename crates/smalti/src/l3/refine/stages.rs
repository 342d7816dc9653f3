//! The picture and its smooth versions, with mirrored margins.

use rayon::prelude::*;

use super::super::blocks::{LANES, values, values_mut};
use crate::numeric::Planes;
use crate::numeric::mirror::about_outermost;
use crate::numeric::simd::{Kernel, dispatch};

/// Number of smooth pictures.
pub(super) const SCALES: usize = 5;
/// Distances of the neighbours that each smoothing averages.
const STEPS: [usize; SCALES] = [1, 2, 4, 8, 16];
/// Differences of colour up to twice these tolerances count, in standard deviations of a sample: each is half of that of the smoothing
/// before, because the noise falls about as fast.
const TOLERANCES: [f32; SCALES] = [3.0, 1.5, 0.75, 0.375, 0.1875];
/// Contrast that is tolerated as noise is, because it may be an error of the first stage: a tenth.
const CONTRAST: f32 = 0.1;
/// Weights of X, Y and Z in the squared difference of two colours.
const WEIGHTS: [f32; 3] = [0.5, 1.0, 0.5];
/// Distance of the farthest pixel of the picture on which an output depends: all smoothings, and the structure around them.
pub(in super::super) const REACH: usize =
    STEPS[0] + STEPS[1] + STEPS[2] + STEPS[3] + STEPS[4] + MARGIN_OF_CLASSES;
/// Rows and columns around a pixel that determine its class, in the picture that is classified.
const MARGIN_OF_CLASSES: usize = 3;
/// Rows and columns around a picture: the longest step.
pub(super) const MARGIN: usize = STEPS[SCALES - 1];
/// Columns that one step of the smoothing processes, two vectors.
const WIDTH: usize = 2 * LANES;

/// X, Y and Z of a picture, row by row, with a margin that mirrors it about its outermost pixels.
pub(super) struct Padded {
    rows: usize,
    cols: usize,
    /// Values of a row of one plane.
    stride: usize,
    data: Vec<f32>,
}

impl Padded {
    fn empty(rows: usize, cols: usize) -> Self {
        // Vectors that begin within a row may end in its padding.
        let stride = (cols + 2 * MARGIN).next_multiple_of(WIDTH) + WIDTH;
        Self { rows, cols, stride, data: vec![0.0; (rows + 2 * MARGIN) * 3 * stride] }
    }

    /// A copy of the first three planes.
    fn of(planes: &Planes) -> Self {
        let mut padded = Self::empty(planes.rows(), planes.cols());
        padded.fill(|row, out| {
            let cols = planes.cols();
            for (plane, out) in planes.planes().zip(out) {
                out[MARGIN..MARGIN + cols].copy_from_slice(&plane[row * cols..(row + 1) * cols]);
            }
        });
        padded
    }

    /// Writes every row of the picture with `row(row, planes)`, which leaves the margins to this function.
    fn fill(&mut self, row: impl Fn(usize, [&mut [f32]; 3]) + Sync) {
        let (rows, cols, stride) = (self.rows, self.cols, self.stride);
        let inner = &mut self.data[MARGIN * 3 * stride..][..rows * 3 * stride];
        inner.par_chunks_exact_mut(3 * stride).enumerate().for_each(|(r, line)| {
            let (x, rest) = line.split_at_mut(stride);
            let (y, z) = rest.split_at_mut(stride);
            row(r, [&mut *x, &mut *y, &mut *z]);
            for plane in [x, y, z] {
                for i in 0..MARGIN {
                    plane[i] = plane[MARGIN + about_outermost(i as isize - MARGIN as isize, cols)];
                    plane[MARGIN + cols + i] = plane[MARGIN + about_outermost((cols + i) as isize, cols)];
                }
            }
        });
        let source = |at: isize| (MARGIN + about_outermost(at, rows)) * 3 * stride;
        for i in 0..MARGIN {
            let above = source(i as isize - MARGIN as isize);
            self.data.copy_within(above..above + 3 * stride, i * 3 * stride);
            let below = source((rows + i) as isize);
            self.data.copy_within(below..below + 3 * stride, (MARGIN + rows + i) * 3 * stride);
        }
    }

    /// A row of a plane, from its left margin on; rows from −16 to 15 below the last exist.
    #[inline(always)]
    pub(super) fn line(&self, plane: usize, row: isize) -> &[f32] {
        let at = ((row + MARGIN as isize) as usize * 3 + plane) * self.stride;
        self.data.get(at..at + self.stride).unwrap_or(&[])
    }

    /// The picture averaged over the neighbours `step` pixels away, without those whose colours differ.
    fn smoothed(&self, step: usize, tolerance: f32, noise: [f32; 3]) -> Self {
        let mut out = Self::empty(self.rows, self.cols);
        out.fill(|row, planes| dispatch(Smoothing { of: self, row, step, tolerance, noise, planes }));
        out
    }
}

/// The picture, then its smooth versions, the finest first.
pub(super) struct Stages(pub(super) [Padded; 1 + SCALES]);

impl Stages {
    /// `noise` has the coefficients of 1, Y and Y² in the variance of the noise of a sample.
    pub(super) fn of(planes: &Planes, [v0, v1, v2]: [f32; 3]) -> Self {
        let noise = [v0, v1, v2 + CONTRAST * CONTRAST];
        let mut stages: [Padded; 1 + SCALES] = std::array::from_fn(|_| Padded::empty(0, 0));
        stages[0] = Padded::of(planes);
        for scale in 0..SCALES {
            stages[scale + 1] = stages[scale].smoothed(STEPS[scale], TOLERANCES[scale], noise);
        }
        Self(stages)
    }
}

/// One row of a smoothing: weights of a 3 × 3 binomial filter times (1 − d)², where d is the squared difference of the colours
/// relative to four times the tolerated variance, at most 1.
struct Smoothing<'a> {
    of: &'a Padded,
    row: usize,
    step: usize,
    tolerance: f32,
    noise: [f32; 3],
    planes: [&'a mut [f32]; 3],
}

impl Kernel for Smoothing<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        const BINOMIAL: [f32; 3] = [1.0, 2.0, 1.0];
        let Self { of, row, step, tolerance, noise: [v0, v1, v2], mut planes } = self;
        let lines: [[&[f32]; 3]; 3] = std::array::from_fn(|down| {
            let at = row as isize + (down as isize - 1) * step as isize;
            std::array::from_fn(|plane| of.line(plane, at))
        });
        let share = 1.0 / (4.0 * tolerance * tolerance);
        for first in (0..of.cols).step_by(WIDTH) {
            let at = |right: usize| first + MARGIN + right * step - step;
            let load = |plane: usize, down: usize, right: usize| {
                values::<f32, WIDTH>(lines[down][plane], at(right)).unwrap_or(&[0.0; WIDTH])
            };
            let centre = [0, 1, 2].map(|plane| *load(plane, 1, 1));
            let mut scale = [0.0; WIDTH];
            for i in 0..WIDTH {
                let y = if centre[1][i] > 0.0 { centre[1][i] } else { 0.0 };
                scale[i] = share / (v0 + (v1 + v2 * y) * y);
            }
            let mut sums = centre.map(|c| c.map(|v| 4.0 * v));
            let mut total = [4.0; WIDTH];
            for (down, vertical) in BINOMIAL.into_iter().enumerate() {
                for (right, horizontal) in BINOMIAL.into_iter().enumerate() {
                    if down == 1 && right == 1 {
                        continue;
                    }
                    let other = [0, 1, 2].map(|plane| load(plane, down, right));
                    let binomial = vertical * horizontal;
                    for i in 0..WIDTH {
                        let mut difference = 0.0;
                        for plane in 0..3 {
                            let d = other[plane][i] - centre[plane][i];
                            difference += WEIGHTS[plane] * d * d;
                        }
                        let left = 1.0 - difference * scale[i];
                        let left = if left > 0.0 { left } else { 0.0 };
                        let weight = binomial * left * left;
                        total[i] += weight;
                        for plane in 0..3 {
                            sums[plane][i] += weight * other[plane][i];
                        }
                    }
                }
            }
            for (sum, plane) in sums.iter().zip(&mut planes) {
                if let Some(out) = values_mut::<f32, WIDTH>(plane, first + MARGIN) {
                    for i in 0..WIDTH {
                        out[i] = sum[i] / total[i];
                    }
                }
            }
        }
    }
}
