//! Correction of pixels beside light that is many times as bright.
//!
//! Near a lamp, what a mosaic does not resolve of its edge is wrong by a few percent of its brightness, in other colours at every pixel: more than
//! the light of its surroundings. Where Y around a pixel has such a contrast, the pixel has the mean colour of the light around it instead, and its
//! Y is at least half of the mean Y of its neighbours and a quarter of the mean Y around it, in which negative Y counts as 0. Light
//! near saturation counts less in the mean colour, because the colour of clipped light is wrong.
//!
//! Each pixel has one sample, which holds its own light even where the picture does not resolve it. Where all light has one colour, Y is in proportion to the
//! responses of the samples that see the same cell of the tile. Y therefore goes halfway to what the pixel's own response gives.

use super::super::blocks::{LANES, values, values_mut};
use super::samples::{CLIPPED, RefinementSamples};
use super::stages::{MARGIN, Padded, Vector, copy_row};
use super::strips::Strip;
use crate::numeric::simd::{Kernel, dispatch};

/// Distance of the farthest row and column on which a pixel depends.
pub(super) const REACH: usize = 4;
const SIDE: usize = 2 * REACH + 1;
/// Weights of light in the contrast by distance along a row or a column; in both directions they are multiplied. The Y of dark pixels is divided by
/// them. They are powers of 2, so that this is exact.
const FALL: [f32; 1 + REACH] = [1.0, 1.0, 1.0, 0.5, 0.25];
/// The contrast at which the correction begins, and the contrast at which it is complete.
pub(super) const CONTRASTS: [f32; 2] = [16.0, 32.0];
/// The greatest ratios of X and Z of the mean colour to its Y. Red light of 700 nm has 2.8, blue light of 470 nm 14.
pub(super) const MOST: [f32; 2] = [3.0, 16.0];
/// The least headroom. Its fourth power is the weight of a pixel in the mean colour.
const LEAST_HEADROOM: f32 = 0.25;
/// Binomial weights of the mean Y by distance; those of the nine pixels of a line sum to 1.
const WEIGHTS: [f32; 1 + REACH] = [70.0 / 256.0, 56.0 / 256.0, 28.0 / 256.0, 8.0 / 256.0, 1.0 / 256.0];
/// Least Y of a corrected pixel, relative to the means of Y with binomial weights over 3 × 3 and over all pixels. Negative Y counts as 0 in them: it
/// would cancel the light beside it.
const LEAST: [f32; 2] = [0.5, 0.25];
/// Bounds of the Y that a response gives, relative to the Y that it had.
const OF_RESPONSE: [f32; 2] = [0.5, 2.0];

/// Corrects a strip. `dark` is the standard deviation of the noise of a sample at Y = 0, which is added to the Y of dark pixels.
pub(super) fn correct(mut strip: Strip<'_>, dark: f32, samples: Option<RefinementSamples<'_>>) {
    let [rows, cols] = strip.size;
    let samples = samples.and_then(|samples| samples.repeated_within(REACH));
    let mut picture = Padded::keeping(SIDE, rows, cols);
    let mut ready = strip.rows.start.saturating_sub(REACH);
    let mut scratch = Scratch::default();
    for row in strip.rows.clone() {
        while ready < (row + REACH + 1).min(rows) {
            picture.write(ready, |planes| copy_row(strip.line(ready), planes));
            ready += 1;
        }
        if let Some(out) = strip.line_mut(row) {
            dispatch(Row { picture: &picture, row, dark, samples, scratch: &mut scratch, out });
        }
    }
}

/// Memory that a strip reuses.
#[derive(Default)]
struct Scratch {
    /// The brightest and the darkest of every column, from [`REACH`] columns before the first on.
    brightest: Vec<f32>,
    darkest: Vec<f32>,
    /// How much of the correction applies.
    shares: Vec<f32>,
    /// Sums over every column of weights, and of X, Y and Z times weights.
    sums: [Vec<f32>; 4],
    /// Means of Y over every column, and over 3 rows of it.
    around: Vec<f32>,
    near: Vec<f32>,
    /// Responses of a row, and of the row that is corrected.
    responses: Vec<f32>,
    own: Vec<f32>,
    /// Sums down every column of Y and of responses, each divided by the sum of Y, response and noise, over samples that see the same row of the tile.
    ratio_sums: [Vec<f32>; 2],
}

/// The greater number; `a` if `b` is none.
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The lesser number; `a` if `b` is none.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// The brightest and the darkest pixel of a line, at several places.
struct Extremes {
    brightest: Vector,
    darkest: Vector,
}

impl Extremes {
    /// From light and darkness at all distances. To the darkness, `dark` is added.
    #[inline(always)]
    fn of(light: [&Vector; SIDE], darkness: [&Vector; SIDE], dark: f32) -> Self {
        let mut all = Self { brightest: [0.0; LANES], darkest: [f32::INFINITY; LANES] };
        for at in 0..SIDE {
            let far = at.abs_diff(REACH);
            for i in 0..LANES {
                all.brightest[i] = greater(all.brightest[i], light[at][i] * FALL[far]);
                all.darkest[i] =
                    lesser(all.darkest[i], (greater(0.0, darkness[at][i]) + dark) * (1.0 / FALL[far]));
            }
        }
        all
    }
}

/// Means with [`WEIGHTS`], in which negative values count as 0.
#[inline(always)]
fn weighted(lines: [&Vector; SIDE]) -> Vector {
    let mut means = [0.0; LANES];
    for (i, mean) in means.iter_mut().enumerate() {
        let line = |at: usize| greater(0.0, lines[at][i]);
        *mean = line(REACH) * WEIGHTS[0];
        for (far, weight) in (0..).zip(WEIGHTS).skip(1) {
            *mean += (line(REACH - far) + line(REACH + far)) * weight;
        }
    }
    means
}

/// Sums of weights, and of X, Y and Z times weights. The weight of a pixel is the fourth power of its headroom, which is 1 less the largest of 0 and its
/// X, Y and Z, because a channel saturates at about 1, but at least [`LEAST_HEADROOM`].
#[inline(always)]
fn by_headroom([x, y, z]: [[&Vector; SIDE]; 3]) -> [Vector; 4] {
    let mut sums = [[0.0; LANES]; 4];
    for at in 0..SIDE {
        for i in 0..LANES {
            let own = [x[at][i], y[at][i], z[at][i]];
            let headroom = 1.0 - own.into_iter().fold(0.0, greater);
            let headroom = greater(headroom, LEAST_HEADROOM);
            let weight = (headroom * headroom) * (headroom * headroom);
            sums[0][i] += weight;
            sums[1][i] += weight * own[0];
            sums[2][i] += weight * own[1];
            sums[3][i] += weight * own[2];
        }
    }
    sums
}

/// The sums of nine lines.
#[inline(always)]
fn total(lines: [&Vector; SIDE]) -> Vector {
    let mut sums = *lines[0];
    for line in &lines[1..] {
        for (sum, v) in sums.iter_mut().zip(*line) {
            *sum += v;
        }
    }
    sums
}

/// The sums of the lines that see the same column of a tile as the one in the middle.
#[inline(always)]
fn of_tile(lines: [&Vector; SIDE], tile_cols: usize) -> Vector {
    let mut sums = [0.0; LANES];
    for line in lines.into_iter().skip(REACH % tile_cols).step_by(tile_cols) {
        for (sum, v) in sums.iter_mut().zip(line) {
            *sum += v;
        }
    }
    sums
}

/// Means with weights 1, 2, 1 of the three lines in the middle, of which negative values count as 0.
#[inline(always)]
fn nearest(lines: [&Vector; SIDE]) -> Vector {
    let mut means = [0.0; LANES];
    for (i, mean) in means.iter_mut().enumerate() {
        let [before, own, after] = [REACH - 1, REACH, REACH + 1].map(|at| greater(0.0, lines[at][i]));
        *mean = (before + after + 2.0 * own) * 0.25;
    }
    means
}

/// The vectors of several lines at a place. `None` where they end.
#[inline(always)]
fn down<'a>(lines: &[&'a [f32]; SIDE], at: usize) -> Option<[&'a Vector; SIDE]> {
    let mut all = [&[0.0; LANES]; SIDE];
    for (vector, line) in all.iter_mut().zip(lines) {
        *vector = values(line, at)?;
    }
    Some(all)
}

/// The vectors of a line from a place on, each a column after the one before. `None` where it ends.
#[inline(always)]
fn along(line: &[f32], at: usize) -> Option<[&Vector; SIDE]> {
    let line = values::<f32, { LANES + SIDE - 1 }>(line, at)?;
    let mut all = [&[0.0; LANES]; SIDE];
    for (right, vector) in all.iter_mut().enumerate() {
        *vector = values(line, right)?;
    }
    Some(all)
}

/// Corrects a row.
struct Row<'a> {
    picture: &'a Padded,
    row: usize,
    dark: f32,
    samples: Option<RefinementSamples<'a>>,
    scratch: &'a mut Scratch,
    out: [&'a mut [f32]; 3],
}

impl<'a> Row<'a> {
    /// The rows around this one, of a plane, from [`REACH`] columns before the first on.
    #[inline(always)]
    fn lines(&self, plane: usize) -> [&'a [f32]; SIDE] {
        let (picture, mut lines) = (self.picture, [&[] as &[f32]; SIDE]);
        for (down, line) in lines.iter_mut().enumerate() {
            *line = &picture.line(plane, (self.row + down) as isize - REACH as isize)[MARGIN - REACH..];
        }
        lines
    }

    /// Computes the shares of the correction, and whether there are any.
    #[inline(always)]
    fn shares(&mut self, padded: usize) -> Option<bool> {
        let (lines, scratch) = (self.lines(1), &mut *self.scratch);
        for at in (0..padded + LANES).step_by(LANES) {
            let lines = down(&lines, at)?;
            let all = Extremes::of(lines, lines, self.dark);
            *values_mut(&mut scratch.brightest, at)? = all.brightest;
            *values_mut(&mut scratch.darkest, at)? = all.darkest;
        }
        let mut any = [0u32; LANES];
        for at in (0..padded).step_by(LANES) {
            let all = Extremes::of(along(&scratch.brightest, at)?, along(&scratch.darkest, at)?, 0.0);
            let shares = values_mut::<f32, LANES>(&mut scratch.shares, at)?;
            for i in 0..LANES {
                let contrast = all.brightest[i] / all.darkest[i];
                let share = (contrast - CONTRASTS[0]) / (CONTRASTS[1] - CONTRASTS[0]);
                shares[i] = lesser(greater(share, 0.0), 1.0);
                any[i] |= u32::from(share > 0.0);
            }
        }
        Some(any.contains(&1))
    }

    /// Computes the sums and means of every column.
    #[inline(always)]
    fn columns(&mut self, padded: usize) -> Option<()> {
        let [x, y, z] = [self.lines(0), self.lines(1), self.lines(2)];
        let scratch = &mut *self.scratch;
        for at in (0..padded + LANES).step_by(LANES) {
            let lines = [down(&x, at)?, down(&y, at)?, down(&z, at)?];
            for (sums, place) in by_headroom(lines).into_iter().zip(&mut scratch.sums) {
                *values_mut(place, at)? = sums;
            }
            *values_mut(&mut scratch.around, at)? = weighted(lines[1]);
            *values_mut(&mut scratch.near, at)? = nearest(lines[1]);
        }
        Some(())
    }

    /// Computes the responses of the row, and the sums over every column of Y and of responses.
    #[inline(always)]
    fn compare(&mut self, samples: RefinementSamples<'_>, padded: usize) -> Option<()> {
        let [rows, cols] = samples.size();
        let (lines, scratch) = (self.lines(1), &mut *self.scratch);
        // Samples beyond the image do not count.
        scratch.responses.clear();
        scratch.responses.resize(padded + LANES, CLIPPED);
        for sums in &mut scratch.ratio_sums {
            sums.clear();
            sums.resize(padded + LANES, 0.0);
        }
        let [lights, responses] = &mut scratch.ratio_sums;
        let [tile_rows, _] = samples.tile();
        for (down, line) in lines.iter().enumerate().skip(REACH % tile_rows).step_by(tile_rows) {
            let Some(row) = (self.row + down).checked_sub(REACH).filter(|row| *row < rows) else { continue };
            samples.read_row(row, scratch.responses.get_mut(REACH..REACH + cols)?);
            for at in (0..padded + LANES).step_by(LANES) {
                let [y, response]: [&Vector; 2] = [values(line, at)?, values(&scratch.responses, at)?];
                let lights = values_mut::<f32, LANES>(lights, at)?;
                let responses = values_mut::<f32, LANES>(responses, at)?;
                for i in 0..LANES {
                    let (y, response) = (greater(0.0, y[i]), response[i]);
                    let weight = 1.0 / (y + response + self.dark);
                    lights[i] += if response < 0.0 { 0.0 } else { weight * y };
                    responses[i] += if response < 0.0 { 0.0 } else { weight * response };
                }
            }
            if down == REACH {
                scratch.own.clone_from(&scratch.responses);
            }
        }
        Some(())
    }

    /// Corrects the pixels whose share is above 0.
    #[inline(always)]
    fn correct(&mut self, cols: usize) -> Option<()> {
        let scratch = &*self.scratch;
        let [x, y, z] = &mut self.out;
        for at in (0..cols).step_by(LANES) {
            let shares = values::<f32, LANES>(&scratch.shares, at)?;
            if !shares.iter().any(|share| *share > 0.0) {
                continue;
            }
            let mut sums = [[0.0; LANES]; 4];
            for (sums, columns) in sums.iter_mut().zip(&scratch.sums) {
                *sums = total(along(columns, at)?);
            }
            let [weights, sum_x, sum_y, sum_z] = sums;
            let (around, near) = (weighted(along(&scratch.around, at)?), nearest(along(&scratch.near, at)?));
            let (mut own, mut of_response) = ([CLIPPED; LANES], [[0.0; LANES]; 2]);
            if let Some(samples) = self.samples {
                own = *values(&scratch.own, at + REACH)?;
                for (sums, columns) in of_response.iter_mut().zip(&scratch.ratio_sums) {
                    *sums = of_tile(along(columns, at)?, samples.tile()[1]);
                }
            }
            let here = at..(at + LANES).min(cols);
            for (i, col) in here.enumerate() {
                let least = greater(LEAST[0] * near[i], LEAST[1] * around[i]);
                let mut light = greater(y[col], least);
                let [lights, responses] = [of_response[0][i], of_response[1][i]];
                if own[i] >= 0.0 && responses > 0.0 {
                    let given = own[i] * lights / responses;
                    let given = greater(lesser(given, OF_RESPONSE[1] * light), OF_RESPONSE[0] * light);
                    light = greater(0.5 * (light + given), least);
                }
                // Negative Y may cancel what a mean has of light.
                let of_color = greater(sum_x[i] * (1.0 / MOST[0]), sum_z[i] * (1.0 / MOST[1]));
                let factor = light / greater(greater(sum_y[i], self.dark * weights[i]), of_color);
                let goal = [greater(sum_x[i], 0.0) * factor, light, greater(sum_z[i], 0.0) * factor];
                if shares[i] > 0.0 {
                    for (own, goal) in [&mut x[col], &mut y[col], &mut z[col]].into_iter().zip(goal) {
                        *own += shares[i] * (goal - *own);
                    }
                }
            }
        }
        Some(())
    }
}

impl Kernel for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let cols = self.out[1].len();
        let padded = cols.next_multiple_of(LANES);
        let Scratch { brightest, darkest, shares, sums: [weights, x, y, z], around, near, .. } =
            &mut *self.scratch;
        for plane in [brightest, darkest, shares, weights, x, y, z, around, near] {
            plane.resize(padded + LANES, 0.0);
        }
        if self.shares(padded) != Some(true) || self.columns(padded).is_none() {
            return;
        }
        if self.samples.is_none_or(|samples| self.compare(samples, padded).is_some()) {
            self.correct(cols);
        }
    }
}
