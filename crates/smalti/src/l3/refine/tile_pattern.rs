//! Errors that repeat with the tile of the mosaic.
//!
//! The kernels of the first stage differ between the positions of the tile, and so do their errors and their noise. A uniform area of its
//! pictures therefore has a faint pattern with the period of the tile. So has, after noise of different strength was smoothed, each smooth
//! picture, whose neighbours are mostly of the same position. What such patterns do to the inputs is added to their covariance, so that the kernels of
//! uniform areas do not pass them on.

use rayon::prelude::*;

use super::axes::RefinementAxes;
use super::inputs::{COUNT, LINEAR, Lines, OUTPUTS, SMOOTH, plane_of};
use super::stages::{CONTRAST, HALF, ROWS_BEYOND, STEPS, Stages};
use crate::numeric::Planes;
use crate::numeric::normal::normal_pair;
use crate::numeric::philox::Stream;

/// Standard deviation of the error that each position of the tile is taken to have, relative to brightness, in the picture and in its finest
/// smooth version. It is far larger than real ones, which are some thousandths, because they are to vanish.
pub(super) const ERROR: f64 = 0.4;
/// The greatest strength of structure that noise gives to uniform areas.
const UNIFORM_STRENGTH: usize = 2;
/// Least side of the area whose inputs are averaged, and the pixels on either side of it that they depend on.
const SIDE: usize = 96;
const AROUND: usize = (ROWS_BEYOND + 1).next_multiple_of(2);
/// The size of the pattern, relative to the noise and contrast that smoothing tolerates.
const SIZE: f32 = 0.25;
/// Separates the random numbers of the noise from other uses of a seed.
const PURPOSE: u32 = 0x7469_6c65;

/// What errors of the positions of a tile add to the covariance of the inputs.
pub(super) struct TilePattern<'a> {
    axes: &'a RefinementAxes,
    /// Inputs × inputs for each level.
    levels: Vec<Vec<f64>>,
}

impl<'a> TilePattern<'a> {
    /// For a tile of so many rows and columns. A tile of one pixel has no pattern.
    pub(super) fn new(axes: &'a RefinementAxes, tile: [usize; 2]) -> Self {
        let (smooth, field) = (of_smooth_picture(tile), Field::new(tile));
        let of_level = |level: usize| {
            let y = axes.brightness(level);
            let variance = (ERROR * f64::from(y)).powi(2);
            let both = field.of_picture(axes, y).into_iter().zip(&smooth);
            both.map(|(picture, smooth)| variance * (picture + smooth)).collect()
        };
        Self { axes, levels: (0..axes.levels().count()).into_par_iter().map(of_level).collect() }
    }

    /// Covariance to add in a class: nothing in classes of stronger structure than uniform areas have, in which such a frequency is mostly
    /// detail.
    pub(super) fn of_class(&self, class: u32) -> &[f64] {
        let (level, strength) = self.axes.level_and_strength(class);
        self.levels.get(level).filter(|_| strength <= UNIFORM_STRENGTH).map_or(&[], Vec::as_slice)
    }
}

/// The period of all pictures: coarse ones have every second row and column.
fn period(tile: [usize; 2]) -> [usize; 2] {
    tile.map(|n| if n.is_multiple_of(2) { n } else { 2 * n })
}

/// The pattern of one position's error: 1 where that is, less its mean.
fn pattern(tile: [usize; 2], row: usize, col: usize) -> f64 {
    let is_there = row.is_multiple_of(tile[0]) && col.is_multiple_of(tile[1]);
    f64::from(u8::from(is_there)) - 1.0 / (tile[0] * tile[1]) as f64
}

/// A uniform area with noise, which is the same with and without a pattern and at every level.
struct Field {
    tile: [usize; 2],
    /// Rows and columns.
    size: [usize; 2],
    /// Of variance 1, for each pixel and plane.
    noise: Vec<f32>,
}

impl Field {
    fn new(tile: [usize; 2]) -> Self {
        let size = period(tile).map(|n| SIDE.next_multiple_of(n) + 2 * AROUND);
        let mut random = Stream::new(1, PURPOSE, 0);
        let pairs = (OUTPUTS * size[0] * size[1]).div_ceil(2);
        let pair = |_| <[f32; 2]>::from(normal_pair(random.next_u32(), random.next_u32()));
        Self { tile, size, noise: (0..pairs).flat_map(pair).collect() }
    }

    /// Of a pattern in the picture: the difference that it makes to noisy inputs, because noise lessens the weights of smoothing.
    fn of_picture(&self, axes: &RefinementAxes, y: f32) -> Vec<f64> {
        let [v0, v1, v2] = axes.noise();
        let sigma = (v0 + (v1 + v2 * y) * y).sqrt();
        let size = SIZE * sigma.hypot(CONTRAST * y);
        let [rows, cols] = self.size;
        let means = |size: f32| {
            let mut picture = Planes::zeros(rows, cols, OUTPUTS);
            for (i, (v, noise)) in picture.data_mut().iter_mut().zip(&self.noise).enumerate() {
                *v = y + sigma * noise + size * pattern(self.tile, i / cols % rows, i % cols) as f32;
            }
            self.mean_inputs(&Stages::of(&picture, axes.noise()))
        };
        let (with, without) = (means(size), means(0.0));
        let response = |(with, without): (&[f64; COUNT], &[f64; COUNT])| {
            std::array::from_fn(|i| (with[i] - without[i]) / f64::from(size))
        };
        covariance(with.iter().zip(&without).map(response).collect(), self.tile)
    }

    /// The mean inputs of every position of the period.
    fn mean_inputs(&self, stages: &Stages) -> Vec<[f64; COUNT]> {
        let (period, [rows, cols]) = (period(self.tile), self.size);
        let mut means = vec![[0.0; COUNT]; period[0] * period[1]];
        let share = means.len() as f64 / ((rows - 2 * AROUND) * (cols - 2 * AROUND)) as f64;
        let mut inputs = [0.0; COUNT];
        for row in AROUND..rows - AROUND {
            let lines = Lines::of(stages, row);
            for col in AROUND..cols - AROUND {
                lines.read(col, &mut inputs);
                let means = &mut means[row % period[0] * period[1] + col % period[1]];
                means.iter_mut().zip(inputs).for_each(|(mean, v)| *mean += share * f64::from(v));
            }
        }
        means
    }
}

/// Of a pattern in the finest smooth picture, which the others are made of.
fn of_smooth_picture(tile: [usize; 2]) -> Vec<f64> {
    let [rows, cols] = period(tile);
    let mut picture: Vec<f64> = (0..rows * cols).map(|i| pattern(tile, i / cols, i % cols)).collect();
    let mut responses = vec![[0.0; COUNT]; rows * cols];
    let mut inputs = (SMOOTH..LINEAR).step_by(OUTPUTS);
    for (index, step) in STEPS.into_iter().enumerate().skip(1) {
        if index == HALF {
            picture =
                (0..rows * cols).map(|i| picture[((i / cols) & !1) * cols + ((i % cols) & !1)]).collect();
            continue;
        }
        if index > 1 {
            // The period is in pixels of the first picture.
            picture = smoothed(&picture, [rows, cols], if index < HALF { step } else { 2 * step });
        }
        let Some(first) = inputs.next() else { break };
        for (response, v) in responses.iter_mut().zip(&picture) {
            response[first..first + OUTPUTS].fill(*v);
        }
    }
    covariance(responses, tile)
}

/// A binomial mean over 3 × 3 pixels of a periodic picture that are `step` apart.
fn smoothed(picture: &[f64], [rows, cols]: [usize; 2], step: usize) -> Vec<f64> {
    let around = |at: usize, len: usize| [(at + len * step - step) % len, at, (at + step) % len];
    let pixel = |i: usize| {
        let (down, right) = (around(i / cols, rows), around(i % cols, cols));
        let line = |row: usize| {
            let [a, b, c] = right.map(|col| picture[row * cols + col]);
            (a + 2.0 * b + c) / 4.0
        };
        let [a, b, c] = down.map(line);
        (a + 2.0 * b + c) / 4.0
    };
    (0..rows * cols).map(pixel).collect()
}

/// The covariance of the inputs where every position of the tile has an independent error of variance 1 in X, Y and Z each, from the inputs'
/// responses to that of one position.
fn covariance(mut responses: Vec<[f64; COUNT]>, tile: [usize; 2]) -> Vec<f64> {
    let count = responses.len() as f64;
    for input in 0..COUNT {
        let mean = responses.iter().map(|r| r[input]).sum::<f64>() / count;
        responses.iter_mut().for_each(|r| r[input] = if input < LINEAR { r[input] - mean } else { 0.0 });
    }
    let times = (tile[0] * tile[1]) as f64 / count;
    let mut sums = vec![0.0; COUNT * COUNT];
    for response in &responses {
        for (i, line) in sums.chunks_exact_mut(COUNT).enumerate() {
            let same = (0..LINEAR).filter(|&j| plane_of(i) == plane_of(j));
            same.for_each(|j| line[j] += times * response[i] * response[j]);
        }
    }
    sums
}
