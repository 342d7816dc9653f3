//! The picture and its smooth versions, with mirrored margins.

use rayon::prelude::*;

use super::super::blocks::{BLOCK, LANES, values, values_mut};
use super::super::vectors::Register;
use crate::numeric::Planes;
use crate::numeric::mirror::about_outermost;
use crate::numeric::simd::{Kernel, dispatch};

/// Number of smooth pictures.
pub(super) const SCALES: usize = 5;
/// Smooth pictures that have every pixel. The others have every second row and column: neighbours farther apart than a pixel of theirs
/// are pixels of theirs as well.
pub(super) const FINE: usize = 3;
/// Number of pictures: the picture, the fine smooth ones, every second pixel of the last of these, and the coarse smooth ones.
pub(super) const PICTURES: usize = 2 + SCALES;
/// Index of the first picture of every second row and column.
pub(super) const HALF: usize = 1 + FINE;
/// Distances of the neighbours over which a smoothing averages, in its own pixels; 0 for pictures that are not smoothings.
pub(super) const STEPS: [usize; PICTURES] = [0, 1, 2, 4, 0, 4, 8];
/// Differences of colour up to twice these tolerances count, in standard deviations of a sample: each is half of that of the smoothing
/// before, because the noise falls about as fast.
const TOLERANCES: [f32; PICTURES] = [0.0, 3.0, 1.5, 0.75, 0.0, 0.375, 0.1875];
/// Contrast that is tolerated as noise is, because it may be an error of the first stage: a tenth.
pub(super) const CONTRAST: f32 = 0.1;
/// Bounds of the squared difference of colours that is tolerated, so that its square has single precision.
const SQUARES: [f32; 2] = [1e-15, 1e15];
/// Distance of the farthest pixel of the picture on which a refined pixel depends. A pixel of an odd row reads the coarse pictures of the row
/// before.
pub(super) const REACH: usize = ROWS_BEYOND + 1;
/// Rows and columns around a picture: at least the longest step, and what classes and products read.
pub(super) const MARGIN: usize = 16;
/// Rows around an output that classes and products read.
const AROUND: usize = 3;

/// X, Y and Z of the rows of a picture, which is mirrored about its outermost pixels. It keeps all rows or the latest ones.
pub(super) struct Padded {
    rows: usize,
    cols: usize,
    /// Vectors of a row of one plane.
    stride: usize,
    /// Rows that are kept: row r takes the place of row r − kept.
    kept: usize,
    data: Vec<Register<f32, LANES>>,
}

impl Padded {
    pub(super) fn keeping(kept: usize, rows: usize, cols: usize) -> Self {
        // Blocks that begin within a row, and what they read around it, end in its padding.
        let stride = (cols.next_multiple_of(BLOCK) + 2 * MARGIN) / LANES + 1;
        let kept = kept.min(rows).max(1);
        Self { rows, cols, stride, kept, data: vec![Register([0.0; LANES]); kept * 3 * stride] }
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
    pub(super) fn write(&mut self, row: usize, write: impl FnOnce([&mut [f32]; 3])) {
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
        Register::flat(self.data.get(at..at + self.stride).unwrap_or(&[]))
    }

    /// Writes a row of the picture that follows this one: smoothed, or every second column.
    fn next(&self, index: usize, row: usize, noise: [f32; 3], planes: [&mut [f32]; 3]) {
        if index == HALF {
            return dispatch(EverySecond { of: self, row: 2 * row, planes });
        }
        let squares = scaled(index, noise);
        dispatch(Smoothing { of: self, row, step: STEPS[index], squares, planes });
    }
}

/// Writes the three planes of a row and mirrors them in their margins.
#[inline(always)]
fn with_margins(line: &mut [Register<f32, LANES>], cols: usize, write: impl FnOnce([&mut [f32]; 3])) {
    let line = Register::flat_mut(line);
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

/// The picture, its fine smooth versions, every second pixel of the last, and the coarse smooth versions.
pub(super) struct Stages([Padded; PICTURES]);

/// The coefficients of what is tolerated, from those of 1, Y and Y² in the variance of the noise of a sample.
fn tolerated([v0, v1, v2]: [f32; 3]) -> [f32; 3] {
    [v0, v1, v2 + CONTRAST * CONTRAST]
}

/// The coefficients of the greatest squared difference of colours that counts in a smoothing, from those of what is tolerated.
fn scaled(index: usize, tolerated: [f32; 3]) -> [f32; 3] {
    let squared = 4.0 * TOLERANCES[index] * TOLERANCES[index];
    tolerated.map(|v| squared * v)
}

/// The same from the coefficients of the noise of a sample.
pub(super) fn squares_of(index: usize, noise: [f32; 3]) -> [f32; 3] {
    scaled(index, tolerated(noise))
}

/// Size of a picture.
fn size_of(index: usize, [rows, cols]: [usize; 2]) -> [usize; 2] {
    if index < HALF { [rows, cols] } else { [rows.div_ceil(2), cols.div_ceil(2)] }
}

impl Stages {
    /// All rows of all pictures. `noise` has the coefficients of 1, Y and Y² in the variance of the noise of a sample.
    pub(super) fn of(planes: &Planes, noise: [f32; 3]) -> Self {
        let (size, noise) = ([planes.rows(), planes.cols()], tolerated(noise));
        let mut all: [Padded; PICTURES] = std::array::from_fn(|_| Padded::keeping(0, 0, 0));
        all[0] = Padded::whole(size[0], size[1], |row, out| {
            let line = |plane: usize| {
                let at = (plane * size[0] + row) * size[1];
                planes.data().get(at..at + size[1]).unwrap_or(&[])
            };
            copy_row([0, 1, 2].map(line), out);
        });
        for index in 1..PICTURES {
            let ([rows, cols], from) = (size_of(index, size), &all[index - 1]);
            all[index] = Padded::whole(rows, cols, |row, out| from.next(index, row, noise, out));
        }
        Self(all)
    }

    /// The picture.
    #[inline(always)]
    pub(super) fn picture(&self) -> &Padded {
        &self.0[0]
    }

    /// A smooth picture, the finest first. From [`FINE`] on, it has every second row and column.
    #[inline(always)]
    pub(super) fn smooth(&self, scale: usize) -> &Padded {
        &self.0[if scale < FINE { 1 + scale } else { 2 + scale }]
    }
}

/// The row of a picture at a row of the outputs, rounded down where the picture has every second row.
fn row_of(index: usize, output: isize) -> isize {
    if index < HALF { output } else { output.div_euclid(2) }
}

/// Rows of every picture, in its own rows, beyond the outputs that depend on them, for outputs from an even row on.
pub(super) const BEYOND: [usize; PICTURES] = {
    let mut beyond = [0; PICTURES];
    let mut index = PICTURES - 1;
    while index > 0 {
        let own = beyond[index];
        beyond[index - 1] = if index == HALF { 2 * own } else { own + STEPS[index] };
        index -= 1;
    }
    beyond
};
/// Rows of the picture beyond the outputs that depend on them.
pub(super) const ROWS_BEYOND: usize = BEYOND[0];

/// Rows of a picture before its latest one that are read again: by the next picture, and by classes and products.
pub(super) fn rows_read_again(index: usize) -> usize {
    let next = STEPS.get(index + 1).map_or(0, |step| 2 * step);
    next.max(BEYOND[index] + AROUND)
}

/// The stages of a few rows at a time, from the first row of a strip on. They need memory for the rows that are read again, and stay in the cache.
pub(super) struct RollingStages {
    pub(super) stages: Stages,
    noise: [f32; 3],
    /// The first row of the strip.
    first: isize,
    /// The rows of every picture below this one are ready.
    ready: [usize; PICTURES],
    /// Outputs up to this row can be computed; below the first of the strip while the stages begin.
    end: isize,
}

impl RollingStages {
    /// Outputs that are made ready at once.
    pub(super) const ROWS: usize = 8;

    /// For outputs from an even row on, of a picture of `rows` × `cols`.
    pub(super) fn new(first: usize, rows: usize, cols: usize, noise: [f32; 3]) -> Self {
        let padded = |index: usize| {
            let [rows, cols] = size_of(index, [rows, cols]);
            Padded::keeping(Self::ROWS + rows_read_again(index), rows, cols)
        };
        let first = first as isize;
        Self {
            stages: Stages(std::array::from_fn(padded)),
            noise: tolerated(noise),
            first,
            ready: std::array::from_fn(|i| (row_of(i, first) - BEYOND[i] as isize).max(0) as usize),
            end: first - 2 * ROWS_BEYOND as isize,
        }
    }

    /// Makes the stages ready for the outputs below `end`, at most [`Self::ROWS`] beyond those before. `source(row, planes)` writes a row of the picture.
    pub(super) fn advance(&mut self, end: usize, source: impl Fn(usize, [&mut [f32]; 3])) {
        // The first pictures begin earlier, a few rows at a time as well.
        while self.end < end as isize {
            let goal = if self.end < self.first { self.first } else { end as isize };
            self.end = (self.end + Self::ROWS as isize).min(goal);
            for (index, beyond) in BEYOND.into_iter().enumerate() {
                let (before, after) = self.stages.0.split_at_mut(index);
                let Some(padded) = after.first_mut() else { return };
                let end = row_of(index, self.end - 1) + 1 + beyond as isize;
                let until = end.clamp(0, padded.rows as isize) as usize;
                for row in self.ready[index]..until {
                    padded.write(row, |planes| match before.last() {
                        None => source(row, planes),
                        Some(before) => before.next(index, row, self.noise, planes),
                    });
                }
                self.ready[index] = self.ready[index].max(until);
            }
        }
    }
}

/// Every second column of a row, from the first on.
struct EverySecond<'a> {
    of: &'a Padded,
    row: usize,
    planes: [&'a mut [f32]; 3],
}

impl Kernel for EverySecond<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (plane, out) in self.planes.into_iter().enumerate() {
            let pairs = self.of.line(plane, self.row as isize)[MARGIN..].as_chunks::<2>().0;
            out[MARGIN..].iter_mut().zip(pairs).for_each(|(out, [first, _])| *out = *first);
        }
    }
}

/// One row of a smoothing: weights of a 3 × 3 binomial filter times (s − d)², where d is the squared difference of the colours, in which X
/// and Z count half, and s is four times the variance that is tolerated. Colours that differ by more do not count.
struct Smoothing<'a> {
    of: &'a Padded,
    row: usize,
    step: usize,
    /// Coefficients of 1, Y and Y² in s.
    squares: [f32; 3],
    planes: [&'a mut [f32]; 3],
}

/// Values of neighbouring columns.
pub(super) type Vector = [f32; LANES];

/// The three vectors of neighbours in a line: to the left, in the middle, to the right.
#[inline(always)]
fn neighbours(line: &[f32], at: usize, step: usize) -> Option<[&Vector; 3]> {
    Some([values(line, at - step)?, values(line, at)?, values(line, at + step)?])
}

/// Weighted sums of colours.
struct Sums {
    weights: Vector,
    colours: [Vector; 3],
}

impl Sums {
    /// Adds a neighbour, whose planes are given, `TIMES` times; `most` is what its squared difference to the centre may be.
    #[inline(always)]
    fn add<const TIMES: u8>(&mut self, other: [&Vector; 3], centre: [&Vector; 3], most: &Vector) {
        let Self { weights, colours: [sum_x, sum_y, sum_z] } = self;
        let ([other_x, other_y, other_z], [own_x, own_y, own_z]) = (other, centre);
        for i in 0..LANES {
            let (x, y, z) = (other_x[i] - own_x[i], other_y[i] - own_y[i], other_z[i] - own_z[i]);
            let squares = y * y;
            let left = most[i] - (x * x + z * z + (squares + squares));
            let left = if left > 0.0 { left } else { 0.0 };
            let weight = f32::from(TIMES) * left * left;
            weights[i] += weight;
            sum_x[i] += weight * other_x[i];
            sum_y[i] += weight * other_y[i];
            sum_z[i] += weight * other_z[i];
        }
    }
}

impl Smoothing<'_> {
    /// The sums of the pixels from a column of the lines on. `None` where they end.
    #[inline(always)]
    fn sums(&self, lines: &[[&[f32]; 3]; 3], at: usize) -> Option<Sums> {
        let ([[xa, ya, za], [xh, yh, zh], [xb, yb, zb]], step) = (*lines, self.step);
        let [xa, ya, za] = [neighbours(xa, at, step)?, neighbours(ya, at, step)?, neighbours(za, at, step)?];
        let [xh, yh, zh] = [neighbours(xh, at, step)?, neighbours(yh, at, step)?, neighbours(zh, at, step)?];
        let [xb, yb, zb] = [neighbours(xb, at, step)?, neighbours(yb, at, step)?, neighbours(zb, at, step)?];
        let centre = [xh[1], yh[1], zh[1]];
        let [s0, s1, s2] = self.squares;
        let mut most = [0.0; LANES];
        let own = yh[1];
        for i in 0..LANES {
            let y = if own[i] > 0.0 { own[i] } else { 0.0 };
            let square = s0 + (s1 + s2 * y) * y;
            let square = if square > SQUARES[0] { square } else { SQUARES[0] };
            most[i] = 2.0 * if square < SQUARES[1] { square } else { SQUARES[1] };
        }
        let mut weights = [0.0; LANES];
        for i in 0..LANES {
            weights[i] = 4.0 * most[i] * most[i];
        }
        let mut colours = [[0.0; LANES]; 3];
        for (sum, centre) in colours.iter_mut().zip(centre) {
            for i in 0..LANES {
                sum[i] = weights[i] * centre[i];
            }
        }
        let mut sums = Sums { weights, colours };
        sums.add::<2>([xa[1], ya[1], za[1]], centre, &most);
        sums.add::<2>([xh[0], yh[0], zh[0]], centre, &most);
        sums.add::<2>([xh[2], yh[2], zh[2]], centre, &most);
        sums.add::<2>([xb[1], yb[1], zb[1]], centre, &most);
        sums.add::<1>([xa[0], ya[0], za[0]], centre, &most);
        sums.add::<1>([xa[2], ya[2], za[2]], centre, &most);
        sums.add::<1>([xb[0], yb[0], zb[0]], centre, &most);
        sums.add::<1>([xb[2], yb[2], zb[2]], centre, &most);
        Some(sums)
    }
}

impl Kernel for Smoothing<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let mut lines = [[&[] as &[f32]; 3]; 3];
        for (down, lines) in lines.iter_mut().enumerate() {
            let at = self.row as isize + (down as isize - 1) * self.step as isize;
            for (plane, line) in lines.iter_mut().enumerate() {
                *line = self.of.line(plane, at);
            }
        }
        // The sums of a block are divided in loops of their own: divided at once, they would be scalars.
        let (mut weights, mut colours) = ([0.0; BLOCK], [[0.0; BLOCK]; 3]);
        for first in (MARGIN..MARGIN + self.of.cols).step_by(BLOCK) {
            for at in (0..BLOCK).step_by(LANES) {
                let Some(sums) = self.sums(&lines, first + at) else { return };
                weights[at..at + LANES].copy_from_slice(&sums.weights);
                for (colour, sums) in colours.iter_mut().zip(&sums.colours) {
                    colour[at..at + LANES].copy_from_slice(sums);
                }
            }
            for weight in &mut weights {
                *weight = 1.0 / *weight;
            }
            for (plane, colour) in self.planes.iter_mut().zip(&colours) {
                let Some(out) = values_mut::<f32, BLOCK>(plane, first) else { return };
                for i in 0..BLOCK {
                    out[i] = colour[i] * weights[i];
                }
            }
        }
    }
}
