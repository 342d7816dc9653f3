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
pub(in super::super) const REACH: usize = ROWS_BEYOND + MARGIN_OF_CLASSES;
/// Rows and columns around a pixel that determine its class, in the picture that is classified.
const MARGIN_OF_CLASSES: usize = 3;
/// Rows and columns around a picture: the longest step.
pub(super) const MARGIN: usize = STEPS[SCALES - 1];
/// Columns that one step of the smoothing processes, two vectors.
const WIDTH: usize = 2 * LANES;

/// X, Y and Z of the rows of a picture, which is mirrored about its outermost pixels. It keeps all rows or the latest ones.
pub(super) struct Padded {
    rows: usize,
    cols: usize,
    /// Values of a row of one plane.
    stride: usize,
    /// Rows that are kept: row r takes the place of row r − kept.
    kept: usize,
    data: Vec<f32>,
}

impl Padded {
    fn keeping(kept: usize, rows: usize, cols: usize) -> Self {
        // Vectors that begin within a row may end in its padding.
        let stride = (cols + 2 * MARGIN).next_multiple_of(WIDTH) + WIDTH;
        let kept = kept.min(rows).max(1);
        Self { rows, cols, stride, kept, data: vec![0.0; kept * 3 * stride] }
    }

    /// All rows, each written by `row(row, planes)`, which leaves the margins to this function.
    fn whole(rows: usize, cols: usize, row: impl Fn(usize, [&mut [f32]; 3]) + Sync) -> Self {
        let mut all = Self::keeping(rows, rows, cols);
        let stride = all.stride;
        let lines = all.data.par_chunks_exact_mut(3 * stride).take(rows).enumerate();
        lines.for_each(|(r, line)| with_margins(line, cols, |planes| row(r, planes)));
        all
    }

    /// Writes one row.
    #[inline(always)]
    fn write(&mut self, row: usize, write: impl FnOnce([&mut [f32]; 3])) {
        let length = 3 * self.stride;
        let at = row % self.kept * length;
        if let Some(line) = self.data.get_mut(at..at + length) {
            with_margins(line, self.cols, write);
        }
    }

    /// A row of a plane, from its left margin on. Rows beyond the picture are mirrored.
    #[inline(always)]
    pub(super) fn line(&self, plane: usize, row: isize) -> &[f32] {
        let at = (about_outermost(row, self.rows) % self.kept * 3 + plane) * self.stride;
        self.data.get(at..at + self.stride).unwrap_or(&[])
    }

    /// Writes a row of the picture averaged over the neighbours of a step, without those whose colours differ.
    fn smooth(&self, scale: usize, row: usize, noise: [f32; 3], planes: [&mut [f32]; 3]) {
        dispatch(Smoothing {
            of: self,
            row,
            step: STEPS[scale],
            tolerance: TOLERANCES[scale],
            noise,
            planes,
        });
    }
}

/// Writes the three planes of a row and mirrors them in their margins.
#[inline(always)]
fn with_margins(line: &mut [f32], cols: usize, write: impl FnOnce([&mut [f32]; 3])) {
    let stride = line.len() / 3;
    let (x, rest) = line.split_at_mut(stride);
    let (y, z) = rest.split_at_mut(stride);
    write([&mut *x, &mut *y, &mut *z]);
    for plane in [x, y, z] {
        for i in 0..MARGIN {
            plane[i] = plane[MARGIN + about_outermost(i as isize - MARGIN as isize, cols)];
            plane[MARGIN + cols + i] = plane[MARGIN + about_outermost((cols + i) as isize, cols)];
        }
    }
}

/// Copies a row of a picture behind the left margin.
#[inline(always)]
pub(super) fn copy_row(from: [&[f32]; 3], to: [&mut [f32]; 3]) {
    for (from, to) in from.into_iter().zip(to) {
        to[MARGIN..MARGIN + from.len()].copy_from_slice(from);
    }
}

/// The picture, then its smooth versions, the finest first.
pub(super) struct Stages(pub(super) [Padded; 1 + SCALES]);

/// The coefficients of what is tolerated, from those of 1, Y and Y² in the variance of the noise of a sample.
fn tolerated([v0, v1, v2]: [f32; 3]) -> [f32; 3] {
    [v0, v1, v2 + CONTRAST * CONTRAST]
}

impl Stages {
    /// All rows of all stages. `noise` has the coefficients of 1, Y and Y² in the variance of the noise of a sample.
    pub(super) fn of(planes: &Planes, noise: [f32; 3]) -> Self {
        let (rows, cols, noise) = (planes.rows(), planes.cols(), tolerated(noise));
        let mut stages: [Padded; 1 + SCALES] = std::array::from_fn(|_| Padded::keeping(0, 0, 0));
        stages[0] = Padded::whole(rows, cols, |row, out| {
            let line = |plane: usize| {
                planes.data().get((plane * rows + row) * cols..).and_then(|l| l.get(..cols)).unwrap_or(&[])
            };
            copy_row([0, 1, 2].map(line), out);
        });
        for scale in 0..SCALES {
            let from = &stages[scale];
            stages[scale + 1] = Padded::whole(rows, cols, |row, out| from.smooth(scale, row, noise, out));
        }
        Self(stages)
    }
}

/// Rows of every stage beyond the outputs that depend on them: those of the picture on the sum of all steps, those of the last stage on none.
const BEYOND: [usize; 1 + SCALES] = {
    let mut beyond = [0; 1 + SCALES];
    let mut scale = SCALES;
    while scale > 0 {
        scale -= 1;
        beyond[scale] = beyond[scale + 1] + STEPS[scale];
    }
    beyond
};
/// Rows of the picture beyond the outputs that depend on them.
pub(super) const ROWS_BEYOND: usize = BEYOND[0];

/// The stages of a few rows at a time, from the first row of a strip on. They need memory for the rows that are read again, and stay in the cache.
pub(super) struct RollingStages {
    pub(super) stages: Stages,
    noise: [f32; 3],
    /// The first row of the strip.
    first: usize,
    /// The rows of every stage below this one are ready.
    ready: [usize; 1 + SCALES],
    /// Outputs up to this row can be computed; below the first of the strip while the stages begin.
    end: isize,
}

impl RollingStages {
    /// Outputs that are made ready at once.
    pub(super) const ROWS: usize = 8;

    /// For outputs from a row on, of a picture of `rows` × `cols`.
    pub(super) fn new(first: usize, rows: usize, cols: usize, noise: [f32; 3]) -> Self {
        let kept = |stage: usize| {
            // What the next stage reads, and what classes and products read.
            let next = STEPS.get(stage).map_or(0, |step| 2 * step);
            Self::ROWS + next.max(BEYOND[stage] + MARGIN_OF_CLASSES)
        };
        Self {
            stages: Stages(std::array::from_fn(|stage| Padded::keeping(kept(stage), rows, cols))),
            noise: tolerated(noise),
            first,
            ready: BEYOND.map(|beyond| first.saturating_sub(beyond)),
            end: first as isize - 2 * ROWS_BEYOND as isize,
        }
    }

    /// Makes the stages ready for the outputs below `end`, at most [`Self::ROWS`] beyond those before. `source(row, planes)` writes a row of the picture.
    pub(super) fn advance(&mut self, end: usize, source: impl Fn(usize, [&mut [f32]; 3])) {
        // The first stages begin earlier, a few rows at a time as well.
        while self.end < end as isize {
            let goal = if self.end < self.first as isize { self.first } else { end } as isize;
            self.end = (self.end + Self::ROWS as isize).min(goal);
            for (stage, beyond) in BEYOND.into_iter().enumerate() {
                let (before, after) = self.stages.0.split_at_mut(stage);
                let Some(padded) = after.first_mut() else { return };
                let until = (self.end + beyond as isize).clamp(0, padded.rows as isize) as usize;
                for row in self.ready[stage]..until {
                    padded.write(row, |planes| match before.last() {
                        None => source(row, planes),
                        Some(finer) => finer.smooth(stage - 1, row, self.noise, planes),
                    });
                }
                self.ready[stage] = self.ready[stage].max(until);
            }
        }
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
