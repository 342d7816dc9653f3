//! Classification of the pixels of a picture by brightness and structure.

use std::ops::Range;

use super::super::Textures;
use super::super::orientation::{direction, fine_direction};
use super::axes::{MAX_STRENGTHS, RefinementAxes, structure};
use super::stages::{MARGIN, Padded};
use crate::numeric::simd::{Kernel, dispatch};

/// Columns and rows around a pixel whose gradients are averaged.
const HALF: usize = 2;
/// Weights of their average, in both directions.
const TENT: [f32; 2 * HALF + 1] = [1.0 / 9.0, 2.0 / 9.0, 3.0 / 9.0, 2.0 / 9.0, 1.0 / 9.0];

/// Memory that a thread reuses.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Products of the gradients, X X, Y Y, X Y, of the rows around a band.
    products: [Vec<f32>; 3],
    /// Averages down the columns.
    averages: [Vec<f32>; 3],
}

/// The classes of some rows of a picture, row by row.
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
        let width = cols + 2 * HALF;
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
        classes.resize(rows.len() * cols, 0);
        let [v0, v1, v2] = axes.noise();
        // Strengths that do not exist are never reached.
        let mut limits = [f32::INFINITY; MAX_STRENGTHS];
        limits.iter_mut().zip(axes.strengths()).for_each(|(limit, strength)| *limit = *strength);
        let (structures, is_fine) = (axes.structures() as u32, axes.orientations() == 8);
        let kinds = axes.kinds() as u32;
        for (i, out) in classes.chunks_exact_mut(cols).enumerate() {
            for (plane, average) in scratch.products.iter().zip(&mut scratch.averages) {
                let lines: [&[f32]; 2 * HALF + 1] =
                    std::array::from_fn(|down| &plane[(i + down) * width..][..width]);
                for c in 0..width {
                    let mut sum = 0.0;
                    for (line, tent) in lines.iter().zip(TENT) {
                        sum += tent * line[c];
                    }
                    average[c] = sum;
                }
            }
            let row = (rows.start + i) as isize;
            let lines = [y(row - 1), y(row), y(row + 1)].map(|line| &line[MARGIN - 1..][..cols + 2]);
            let averages = &scratch.averages;
            for (c, class) in out.iter_mut().enumerate() {
                let [xx, yy, xy]: [f32; 3] = std::array::from_fn(|plane| {
                    let mut sum = 0.0;
                    for (right, tent) in TENT.iter().enumerate() {
                        sum += tent * averages[plane][c + right];
                    }
                    sum
                });
                let sides = |line: &[f32]| line[c] + 2.0 * line[c + 1] + line[c + 2];
                let mean = (sides(lines[0]) + 2.0 * sides(lines[1]) + sides(lines[2])) / 16.0;
                let light = if mean > 0.0 { mean } else { 0.0 };
                let noise = v0 + (v1 + v2 * light) * light;
                let trace = xx + yy;
                let mut strength = 0;
                for limit in limits {
                    strength += u32::from(trace > limit * noise);
                }
                let (difference, twice) = (xx - yy, 2.0 * xy);
                let coherence = Textures::EDGE_COHERENCE as f32;
                let is_edge = difference * difference + twice * twice > coherence * coherence * trace * trace;
                let orientation =
                    if is_fine { fine_direction(difference, twice) } else { direction(difference, twice) };
                let kind = if is_edge { 1 + orientation } else { 0 };
                let level = axes.levels().level_of(mean) as u32;
                *class = level * structures + structure(strength, kind, kinds);
            }
        }
    }
}
