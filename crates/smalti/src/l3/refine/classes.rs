//! Classification of the pixels of a picture by brightness and structure.

use std::ops::Range;

use super::super::Textures;
use super::super::blocks::{LANES, values};
use super::super::orientation::{direction, fine_direction};
use super::axes::{MAX_STRENGTHS, RefinementAxes, structure};
use super::stages::{MARGIN, Padded};
use crate::numeric::simd::{Kernel, dispatch};

/// Columns and rows around a pixel whose gradients are averaged.
const HALF: usize = 2;
const SIDE: usize = 2 * HALF + 1;
/// Weights of their average, in both directions.
const TENT: [f32; SIDE] = [1.0 / 9.0, 2.0 / 9.0, 3.0 / 9.0, 2.0 / 9.0, 1.0 / 9.0];

/// Memory that a thread reuses.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Products of the gradients, X X, Y Y, X Y, of the rows around a band.
    products: [Vec<f32>; 3],
    /// Averages down the columns.
    averages: [Vec<f32>; 3],
}

/// The classes of some rows of a picture, row by row, each padded to whole vectors.
pub(super) fn classify(
    axes: &RefinementAxes,
    picture: &Padded,
    rows: Range<usize>,
    cols: usize,
    scratch: &mut Scratch,
    classes: &mut Vec<u32>,
) {
    dispatch(Classification { axes, picture, rows, cols, scratch, classes });
}

struct Classification<'a> {
    axes: &'a RefinementAxes,
    picture: &'a Padded,
    rows: Range<usize>,
    cols: usize,
    scratch: &'a mut Scratch,
    classes: &'a mut Vec<u32>,
}

impl Kernel for Classification<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { axes, picture, rows, cols, scratch, classes } = self;
        let padded = cols.next_multiple_of(LANES);
        // A vector that begins within a row reads as many columns beyond it.
        let width = padded + LANES;
        let count = rows.len() + 2 * HALF;
        for plane in &mut scratch.products {
            plane.resize(count * width, 0.0);
        }
        for plane in &mut scratch.averages {
            plane.resize(width, 0.0);
        }
        let y = |row: isize| picture.line(1, row);
        let [xx, yy, xy] = &mut scratch.products;
        for i in 0..count {
            let row = (rows.start + i) as isize - HALF as isize;
            let (above, here, below) = (y(row - 1), y(row), y(row + 1));
            let first = MARGIN - HALF;
            let (above, below) = (&above[first..][..width], &below[first..][..width]);
            let (left, right) = (&here[first - 1..][..width], &here[first + 1..][..width]);
            let line = i * width..(i + 1) * width;
            let (xx, yy, xy) = (&mut xx[line.clone()], &mut yy[line.clone()], &mut xy[line]);
            for c in 0..width {
                let (across, down) = (0.5 * (right[c] - left[c]), 0.5 * (below[c] - above[c]));
                xx[c] = across * across;
                yy[c] = down * down;
                xy[c] = across * down;
            }
        }
        classes.clear();
        classes.resize(rows.len() * padded, 0);
        // Strengths that do not exist are never reached.
        let mut limits = [f32::INFINITY; MAX_STRENGTHS];
        limits.iter_mut().zip(axes.strengths()).for_each(|(limit, strength)| *limit = *strength);
        let of_block = Block { axes, limits };
        for (i, out) in classes.chunks_exact_mut(padded).enumerate() {
            for (plane, average) in scratch.products.iter().zip(&mut scratch.averages) {
                let mut lines = plane[i * width..].chunks_exact(width);
                average.fill(0.0);
                for (tent, line) in TENT.into_iter().zip(&mut lines) {
                    average.iter_mut().zip(line).for_each(|(sum, v)| *sum += tent * v);
                }
            }
            let row = (rows.start + i) as isize;
            let lines = [y(row - 1), y(row), y(row + 1)];
            for (out, at) in out.as_chunks_mut::<LANES>().0.iter_mut().zip((0..).step_by(LANES)) {
                let near = lines.map(|line| values::<f32, { LANES + 2 }>(line, MARGIN - 1 + at));
                let [Some(above), Some(here), Some(below)] = near else { return };
                let [xx, yy, xy] = &scratch.averages;
                let tensor = [tent(xx, at), tent(yy, at), tent(xy, at)];
                of_block.classes([above, here, below], &tensor, out);
            }
        }
    }
}

/// The average of a plane along a row.
#[inline(always)]
fn tent(plane: &[f32], at: usize) -> [f32; LANES] {
    let mut sums = [0.0; LANES];
    for (right, tent) in TENT.iter().enumerate() {
        let Some(values) = values::<f32, LANES>(plane, at + right) else { return sums };
        for i in 0..LANES {
            sums[i] += tent * values[i];
        }
    }
    sums
}

/// Classification of a vector of pixels.
struct Block<'a> {
    axes: &'a RefinementAxes,
    limits: [f32; MAX_STRENGTHS],
}

impl Block<'_> {
    /// From Y of the rows around the pixels, and their structure tensors X X, Y Y, X Y.
    #[inline(always)]
    fn classes(&self, y: [&[f32; LANES + 2]; 3], tensor: &[[f32; LANES]; 3], out: &mut [u32; LANES]) {
        const COHERENCE: f32 = Textures::EDGE_COHERENCE as f32;
        let [v0, v1, v2] = self.axes.noise();
        let (mut mean, mut noise) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let [above, here, below] = y.map(|line| line[i] + 2.0 * line[i + 1] + line[i + 2]);
            mean[i] = (above + 2.0 * here + below) / 16.0;
            let light = if mean[i] > 0.0 { mean[i] } else { 0.0 };
            noise[i] = v0 + (v1 + v2 * light) * light;
        }
        let mut levels = [0; LANES];
        for &cut in self.axes.levels().cuts() {
            for i in 0..LANES {
                levels[i] += u32::from(cut <= mean[i]);
            }
        }
        let [xx, yy, xy] = tensor;
        let mut strengths = [0; LANES];
        for limit in self.limits {
            for i in 0..LANES {
                strengths[i] += u32::from(xx[i] + yy[i] > limit * noise[i]);
            }
        }
        let mut kinds = [0; LANES];
        let is_fine = self.axes.orientations() == 8;
        for i in 0..LANES {
            let (trace, difference, twice) = (xx[i] + yy[i], xx[i] - yy[i], 2.0 * xy[i]);
            let is_edge = difference * difference + twice * twice > COHERENCE * COHERENCE * trace * trace;
            let orientation =
                if is_fine { fine_direction(difference, twice) } else { direction(difference, twice) };
            kinds[i] = if is_edge { 1 + orientation } else { 0 };
        }
        let (structures, per_strength) = (self.axes.structures() as u32, self.axes.kinds() as u32);
        for i in 0..LANES {
            out[i] = levels[i] * structures + structure(strengths[i], kinds[i], per_strength);
        }
    }
}
