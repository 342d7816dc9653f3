//! The second stage in integers, as camera firmware computes it. It is the definition that exports are tested against, not fast code.

use rayon::prelude::*;

use super::super::{L3Error, Textures};
use super::axes::structure;
use super::highlights;
use super::inputs::{COUNT, NEIGHBOURHOODS, OUTPUTS, ROOTS_OF};
use super::pictures::RefinementPicture;
use super::polynomial::Polynomial;
use super::refinement::Refinement;
use super::roots::{fixed_rgb_from_xyz, fixed_roots};
use super::samples::{self, RefinementSamples};
use super::stages::{FINE, PICTURES, SCALES};
use crate::numeric::mirror::about_outermost;
use crate::numeric::{Planes, ShapeError};

const PLACES: u32 = FixedRefinement::PLACES;
const MOST: i32 = FixedRefinement::MOST;
const TENSOR_SHIFT: u32 = FixedRefinement::TENSOR_SHIFT;
/// Binary places of sums of squares of gradients and of what they are compared with, beyond those of 324 = 4 · 9²: gradients are not halved,
/// and tents of 5 × 5 pixels sum to 9².
const TENSOR_PLACES: u32 = 2 * PLACES - TENSOR_SHIFT;
/// Bits of the weights of a smoothing before they are squared.
const WEIGHT_BITS: u32 = 14;
/// Bits of the tensor before it is squared.
const TENSOR_BITS: u32 = 30;
/// Bits of a strength, and the most places.
const STRENGTH_BITS: u32 = 16;
const MAX_STRENGTH_PLACES: u32 = 30;
/// Greatest number of binary places of a kernel.
const MAX_SHIFT: u8 = 24;
/// Weights of the average of products of gradients, in both directions.
const TENT: [i64; 5] = [1, 2, 3, 2, 1];
/// The tangent of 22.5° in 2⁻¹⁵.
const TANGENT: i64 = 13_573;
/// Right shifts of Y, and left shifts of Y and noise, in the contrast, by distance along a row or a column.
const FALL: [u32; 1 + highlights::REACH] = [0, 0, 0, 1, 2];
/// Weights of the mean Y by distance; those of a line sum to 2⁸, those of 9 × 9 pixels to 2¹⁶.
const BINOMIAL: [i64; 1 + highlights::REACH] = [70, 56, 28, 8, 1];
const BINOMIAL_PLACES: u32 = 16;
/// Greatest ratios of X and Z of the mean colour to its Y.
const MOST_OF_Y: [i64; 2] = [highlights::MOST[0] as i64, highlights::MOST[1] as i64];
/// Binary places of sums of colours times weights, beyond those of pictures.
const SUM_PLACES: u32 = 12;
/// Contrasts at which the correction begins and is complete.
const FROM: i64 = highlights::CONTRASTS[0] as i64;
const TO: i64 = highlights::CONTRASTS[1] as i64;
/// Binary places of how much of the correction applies.
const SHARE_PLACES: u32 = 10;
/// Binary places of Y and of a response relative to both together.
const RESPONSE_PLACES: u32 = 14;
/// Down, right and times of the neighbours of a smoothing.
const AROUND: [[isize; 3]; 8] =
    [[-1, 0, 2], [0, -1, 2], [0, 1, 2], [1, 0, 2], [-1, -1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, 1]];

/// The second stage in integers.
///
/// Pictures have 20 binary places and saturate at ±8. The kernels of a class have as many binary places as their 16 bits allow, the same for X, Y
/// and Z; their sums have 64 bits and are rounded once, halves away from zero. Differences of colours are squared and compared in 64 bits.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedRefinement {
    /// Weights times 2^`shifts` of their class, ordered class, output, input ([`super::REFINEMENT_INPUTS`]).
    pub weights: Vec<i16>,
    /// Offsets in units of 2^−(20 + `shifts`), ordered class, output.
    pub offsets: Vec<i64>,
    /// Binary places of the weights of each class, 0 to 24.
    pub shifts: Vec<u8>,
    /// Levels: the least sums of Y over 3 × 3 pixels with binomial weights, which sum to 16.
    pub cuts: Vec<i64>,
    /// 324 · 2³⁶ times the variance of the noise of a sample, of the same sums of Y.
    pub noise: Polynomial,
    /// Thresholds of the strengths: factor of the noise, and its binary places.
    pub strengths: Vec<[u32; 2]>,
    /// For each picture, 2⁴⁰ times the squared difference of colours beyond which neighbours do not count (X² + 2 Y² + Z²), of Y. All zeros for
    /// pictures that are not averaged.
    pub squares: [Polynomial; PICTURES],
    /// 2²⁰ times the standard deviation of the noise of a sample at Y = 0, at least 1, which the correction beside highlights adds to dark pixels.
    pub dark: i64,
    /// Red, green and blue of the roots from X, Y, Z, with 30 binary places.
    pub rgb_from_xyz: [[i64; 3]; 3],
    steps: [usize; PICTURES],
    halved: [bool; PICTURES],
    orientations: u32,
    structures: u32,
}

impl Refinement {
    /// The second stage in integers.
    ///
    /// # Errors
    /// [`L3Error::NoFixedPoint`] when a weight or a threshold has no place in the integers used.
    pub fn fixed(&self) -> Result<FixedRefinement, L3Error> {
        let axes = self.axes();
        let (mut weights, mut offsets, mut shifts) = (Vec::new(), Vec::new(), Vec::new());
        let floats: Vec<f32> = self.weights().collect();
        for (own, offset) in floats.chunks_exact(OUTPUTS * COUNT).zip(self.offsets().chunks_exact(OUTPUTS)) {
            let most = own.iter().fold(0.0f64, |most, &w| most.max(f64::from(w).abs()));
            let fits = |shift: &u8| (most * f64::from(1u32 << shift)).round() <= f64::from(i16::MAX);
            let shift = (0..=MAX_SHIFT).rev().find(fits);
            let shift = shift
                .ok_or(L3Error::NoFixedPoint("a weight of its second stage is too large for 16 bits"))?;
            let factor = f64::from(1u32 << shift);
            weights.extend(own.iter().map(|&w| (f64::from(w) * factor).round() as i16));
            for &offset in offset {
                let scaled = (f64::from(offset) * factor * f64::from(1u32 << PLACES)).round();
                if scaled.abs() > (1i64 << 56) as f64 {
                    return Err(L3Error::NoFixedPoint("an offset of its second stage is too large"));
                }
                offsets.push(scaled as i64);
            }
            shifts.push(shift);
        }
        let one = f64::from(1u32 << PLACES);
        // As units of a sum of Y of weights 16.
        let unit = 1.0 / (16.0 * one);
        let too_large = L3Error::NoFixedPoint("the noise of its second stage is too large");
        let in_tensor = 324.0 * (1u64 << TENSOR_PLACES) as f64;
        let [v0, v1, v2] = axes.noise().map(|v| f64::from(v) * in_tensor);
        let noise = Polynomial::new([v0, v1 * unit, v2 * unit * unit], 16.0 * f64::from(MOST), 45);
        let strength = |&strength: &f32| {
            let strength = f64::from(strength);
            let places = (0..=MAX_STRENGTH_PLACES)
                .rev()
                .find(|p| (strength * f64::from(1u32 << p)).round() < f64::from(1u32 << STRENGTH_BITS))?;
            Some([(strength * f64::from(1u32 << places)).round() as u32, places])
        };
        let strengths = axes.strengths().iter().map(strength).collect::<Option<_>>();
        let pictures = axes.pictures();
        let square = |picture: &RefinementPicture| {
            let [s0, s1, s2] = picture.squares.map(|s| 2.0 * f64::from(s));
            Polynomial::new([s0 * one * one, s1 * one, s2], f64::from(MOST), 60)
        };
        let mut squares = [Polynomial::default(); PICTURES];
        for (place, picture) in squares.iter_mut().zip(&pictures) {
            *place = square(picture).ok_or(too_large.clone())?;
        }
        let cut = |&cut: &f32| (f64::from(cut) * 16.0 * one).ceil() as i64;
        Ok(FixedRefinement {
            weights,
            offsets,
            shifts,
            cuts: axes.levels().cuts().iter().map(cut).collect(),
            noise: noise.ok_or(too_large)?,
            strengths: strengths
                .ok_or(L3Error::NoFixedPoint("a strength of its second stage is above 65535"))?,
            squares,
            dark: ((f64::from(axes.dark_noise()) * one).round() as i64).max(1),
            rgb_from_xyz: fixed_rgb_from_xyz(),
            steps: pictures.map(|p| p.step.unwrap_or(0)),
            halved: pictures.map(|p| p.is_half),
            orientations: axes.orientations() as u32,
            structures: axes.structures() as u32,
        })
    }
}

/// X, Y and Z of a picture in integers.
#[derive(Debug, Clone, Default)]
struct Whole {
    rows: usize,
    cols: usize,
    /// Pixel by pixel.
    data: Vec<[i32; OUTPUTS]>,
}

impl Whole {
    /// Computed pixel by pixel.
    fn of(rows: usize, cols: usize, pixel: impl Fn(isize, isize) -> [i32; OUTPUTS] + Sync) -> Self {
        let mut data = vec![[0; OUTPUTS]; rows * cols];
        data.par_chunks_mut(cols.max(1)).enumerate().for_each(|(row, line)| {
            line.iter_mut().enumerate().for_each(|(col, out)| *out = pixel(row as isize, col as isize));
        });
        Self { rows, cols, data }
    }

    /// A pixel, mirrored about the outermost ones.
    #[inline]
    fn at(&self, row: isize, col: isize) -> [i32; OUTPUTS] {
        let inside = |at: isize, len: usize| {
            if (0..len as isize).contains(&at) { at as usize } else { about_outermost(at, len) }
        };
        let at = inside(row, self.rows) * self.cols + inside(col, self.cols);
        self.data.get(at).copied().unwrap_or_default()
    }
}

/// v / 2^places, halves away from zero.
fn rounded(v: i64, places: u32) -> i64 {
    let half = (1i64 << places) >> 1;
    let magnitude = (v.abs() + half) >> places;
    if v < 0 { -magnitude } else { magnitude }
}

fn saturated(v: i64) -> i32 {
    v.clamp(-i64::from(MOST), i64::from(MOST)) as i32
}

/// Bits of a number that is not negative.
fn bits(v: i64) -> u32 {
    i64::BITS - v.leading_zeros()
}

impl FixedRefinement {
    /// Binary places of pictures: 1, the white level, is 2²⁰.
    pub const PLACES: u32 = samples::PLACES;
    /// The value at which pictures saturate, 8 times white.
    pub const MOST: i32 = (1 << (Self::PLACES + 3)) - 1;
    /// Bits that sums of squares of gradients lose before they are compared with the noise.
    pub const TENSOR_SHIFT: u32 = 4;

    /// Refines a picture, X, Y, Z in units of 2⁻²⁰, each row by row. Values beyond ±8 are saturated. Results are the same for any number of threads.
    /// It keeps all pictures as a whole, 69 bytes per pixel. Beside highlights, it compares Y with `samples`, as [`Refinement::apply`] does.
    ///
    /// # Errors
    /// When the picture does not have three planes of this size, the size of the raw image differs, or its samples are in volts.
    pub fn apply(
        &self,
        picture: &mut [i32],
        rows: usize,
        cols: usize,
        samples: Option<RefinementSamples<'_>>,
    ) -> Result<(), L3Error> {
        let (plane, got) = (rows * cols, picture.len());
        if got != OUTPUTS * plane {
            return Err(ShapeError { count: OUTPUTS, rows, cols, expected: OUTPUTS * plane, got }.into());
        }
        if let Some(samples) = samples {
            samples.ensure_size([rows, cols])?;
            if !samples.is_digital() {
                return Err(L3Error::NotDigital);
            }
        }
        if plane == 0 {
            return Ok(());
        }
        let mut pictures: [Whole; PICTURES] = Default::default();
        let source = &*picture;
        pictures[0] = Whole::of(rows, cols, |row, col| {
            std::array::from_fn(|p| {
                saturated(i64::from(source[p * plane + row as usize * cols + col as usize]))
            })
        });
        for index in 1..PICTURES {
            let (before, after) = pictures.split_at_mut(index);
            let [.., from] = before else { return Ok(()) };
            let [rows, cols] =
                if self.halved[index] { [rows.div_ceil(2), cols.div_ceil(2)] } else { [rows, cols] };
            after[0] = Whole::of(rows, cols, |row, col| match self.steps[index] {
                0 => from.at(2 * row, 2 * col),
                step => smoothed(from, row, col, step as isize, &self.squares[index]),
            });
        }
        let refined = Whole::of(rows, cols, |row, col| self.pixel(&pictures, row, col));
        drop(pictures);
        let samples = samples.and_then(|samples| samples.repeated_within(highlights::REACH));
        let corrected = Whole::of(rows, cols, |row, col| self.corrected(&refined, samples, row, col));
        for (p, out) in picture.chunks_exact_mut(plane).enumerate() {
            out.iter_mut().zip(&corrected.data).for_each(|(out, pixel)| *out = pixel[p]);
        }
        Ok(())
    }

    /// Refines a picture in single precision in place: it is rounded before and converted back.
    pub(in super::super) fn apply_to(
        &self,
        planes: &mut Planes,
        samples: Option<RefinementSamples<'_>>,
    ) -> Result<(), L3Error> {
        let (rows, cols, one) = (planes.rows(), planes.cols(), (1u32 << PLACES) as f32);
        // A conversion to an integer saturates.
        let mut whole: Vec<i32> = planes.data().iter().map(|v| (v * one).round() as i32).collect();
        self.apply(&mut whole, rows, cols, samples)?;
        planes.data_mut().iter_mut().zip(whole).for_each(|(v, w)| *v = w as f32 / one);
        Ok(())
    }

    fn pixel(&self, pictures: &[Whole; PICTURES], row: isize, col: isize) -> [i32; OUTPUTS] {
        let class = self.class(&pictures[1], row, col);
        let mut inputs = [0; COUNT];
        let mut places = inputs.iter_mut();
        for (plane, side) in NEIGHBOURHOODS {
            let half = (side / 2) as isize;
            for (r, c) in (-half..=half).flat_map(|r| (-half..=half).map(move |c| (r, c))) {
                if let Some(place) = places.next() {
                    *place = pictures[0].at(row + r, col + c)[plane];
                }
            }
        }
        for scale in 0..SCALES {
            let smooth = if scale < FINE {
                pictures[1 + scale].at(row, col)
            } else {
                pictures[2 + scale].at(row / 2, col / 2)
            };
            smooth.into_iter().zip(places.by_ref()).for_each(|(v, place)| *place = v);
        }
        let roots = fixed_roots(&self.rgb_from_xyz, pictures[1 + ROOTS_OF].at(row, col));
        roots.into_iter().zip(places).for_each(|(root, place)| *place = root);
        let shift = u32::from(self.shifts[class]);
        std::array::from_fn(|output| {
            let kernel = class * OUTPUTS + output;
            let weights = &self.weights[kernel * COUNT..(kernel + 1) * COUNT];
            let sum: i64 = weights.iter().zip(&inputs).map(|(&w, &v)| i64::from(w) * i64::from(v)).sum();
            saturated(rounded(sum + self.offsets[kernel], shift))
        })
    }

    /// A pixel of the refined picture, corrected beside light that is many times as bright.
    fn corrected(
        &self,
        refined: &Whole,
        samples: Option<RefinementSamples<'_>>,
        row: isize,
        col: isize,
    ) -> [i32; OUTPUTS] {
        let (own, reach) = (refined.at(row, col), highlights::REACH as isize);
        let at = |r: isize, c: isize| refined.at(row + r, col + c);
        let around = || (-reach..=reach).flat_map(move |r| (-reach..=reach).map(move |c| (r, c)));
        let shift = |r: isize, c: isize| FALL[r.unsigned_abs()] + FALL[c.unsigned_abs()];
        // Of Y, where negative values count as 0.
        let lights = || around().map(|(r, c)| (r, c, i64::from(at(r, c)[1].max(0))));
        let brightest = lights().map(|(r, c, y)| y >> shift(r, c)).max().unwrap_or(0);
        let dark = |(r, c, y): (isize, isize, i64)| (y + self.dark) << shift(r, c);
        let darkest = lights().map(dark).min().unwrap_or(1);
        let beyond = brightest - FROM * darkest;
        if beyond <= 0 {
            return own;
        }
        let share = ((beyond << SHARE_PLACES) / ((TO - FROM) * darkest)).min(1 << SHARE_PLACES);
        let binomial = |r: isize, c: isize| BINOMIAL[r.unsigned_abs()] * BINOMIAL[c.unsigned_abs()];
        let mean: i64 = lights().map(|(r, c, y)| binomial(r, c) * y).sum();
        let (mut sums, mut weights) = ([0i64; OUTPUTS], 0i64);
        for (r, c) in around() {
            let color = at(r, c);
            let most = color.into_iter().fold(0, i32::max);
            let headroom = i64::from(((1 << PLACES) - most).max(1 << (PLACES - 2)));
            let squared = (headroom * headroom) >> PLACES;
            let weight = (squared * squared) >> PLACES;
            sums.iter_mut().zip(color).for_each(|(sum, v)| *sum += weight * i64::from(v));
            weights += weight;
        }
        let sum_places = PLACES - SUM_PLACES;
        let [x, y, z] = sums.map(|sum| rounded(sum, sum_places));
        let is_near = |r: isize, c: isize| r.abs() <= 1 && c.abs() <= 1;
        let near = lights().filter(|&(r, c, _)| is_near(r, c));
        let near = rounded(near.map(|(r, c, y)| y << (2 - r.abs() - c.abs())).sum(), 4);
        let least = (near >> 1).max(mean >> (BINOMIAL_PLACES + 2));
        let light = i64::from(own[1]).max(least);
        let given = samples.and_then(|samples| self.given(refined, samples, row, col));
        let halfway = |given: i64| (light + given.max(light >> 1).min(2 * light)) >> 1;
        let light = given.map_or(light, |given| halfway(given).max(least));
        let total = y.max((self.dark * weights) >> sum_places).max(x / MOST_OF_Y[0]).max(z / MOST_OF_Y[1]);
        let goal = [x.max(0) * light / total, light, z.max(0) * light / total];
        std::array::from_fn(|p| {
            let (own, goal) = (i64::from(own[p]), i64::from(saturated(goal[p])));
            saturated(own + rounded(share * (goal - own), SHARE_PLACES))
        })
    }

    /// The Y that the response of a pixel's own sample gives, from Y and responses of the samples around it that see the same cell of the tile. `None` where
    /// it is clipped.
    fn given(&self, refined: &Whole, samples: RefinementSamples<'_>, row: isize, col: isize) -> Option<i64> {
        let response = |row: isize, col: isize| {
            let [row, col] = [usize::try_from(row).ok()?, usize::try_from(col).ok()?];
            (row < refined.rows && col < refined.cols).then(|| samples.whole(row, col)).flatten()
        };
        let of_tile = |at: isize, len: usize| {
            let (reach, len) = (highlights::REACH as isize, len as isize);
            (-(reach / len)..=reach / len).map(move |i| at + i * len)
        };
        let [tile_rows, tile_cols] = samples.tile();
        let (mut lights, mut responses) = (0, 0);
        for row in of_tile(row, tile_rows) {
            for col in of_tile(col, tile_cols) {
                let Some(response) = response(row, col) else { continue };
                let y = i64::from(refined.at(row, col)[1].max(0));
                let total = y + response + self.dark;
                lights += (y << RESPONSE_PLACES) / total;
                responses += (response << RESPONSE_PLACES) / total;
            }
        }
        let own = response(row, col)?;
        (responses > 0).then(|| own * lights / responses)
    }

    /// The class of a pixel of the finest smooth picture.
    fn class(&self, picture: &Whole, row: isize, col: isize) -> usize {
        let y = |r: isize, c: isize| i64::from(picture.at(row + r, col + c)[1]);
        let [mut xx, mut yy, mut xy] = [0i64; 3];
        for (r, down) in (-2..).zip(TENT) {
            for (c, right) in (-2..).zip(TENT) {
                let (across, along) = (y(r, c + 1) - y(r, c - 1), y(r + 1, c) - y(r - 1, c));
                xx += down * right * across * across;
                yy += down * right * along * along;
                xy += down * right * across * along;
            }
        }
        let line = |r: isize| y(r, -1) + 2 * y(r, 0) + y(r, 1);
        let sum = line(-1) + 2 * line(0) + line(1);
        let level = self.cuts.iter().filter(|&&cut| cut <= sum).count();
        let noise = self.noise.at(sum.max(0));
        let (trace, difference, twice) = (xx + yy, xx - yy, 2 * xy);
        let reaches =
            |[factor, places]: &&[u32; 2]| trace >> TENSOR_SHIFT > (i64::from(*factor) * noise) >> places;
        let strength = self.strengths.iter().filter(reaches).count() as u32;
        // What follows squares them.
        let divisor = 1i64 << bits(trace).saturating_sub(TENSOR_BITS);
        let (trace, difference, twice) = (trace / divisor, difference / divisor, twice / divisor);
        let is_edge = 4 * (difference * difference + twice * twice) > trace * trace;
        const { assert!(Textures::EDGE_COHERENCE == 0.5) };
        let kind = if is_edge { 1 + self.orientation(difference, twice) } else { 0 };
        level * self.structures as usize + structure(strength, kind, 1 + self.orientations) as usize
    }

    /// As those of the stage in single precision.
    fn orientation(&self, cos: i64, sin: i64) -> u32 {
        let (along, across) = (cos.abs(), sin.abs());
        if self.orientations == 8 {
            let from_axis =
                u32::from(across << 15 > TANGENT * along) + u32::from(TANGENT * across >= along << 15);
            let turned = if cos >= 0 { from_axis } else { 4 - from_axis };
            return if sin > 0 { turned } else { (8 - turned) % 8 };
        }
        match (along >= across, cos >= 0, sin > 0) {
            (true, true, _) => 0,
            (true, false, _) => 2,
            (false, _, true) => 1,
            (false, _, false) => 3,
        }
    }
}

/// A pixel of the mean over 3 × 3 pixels `step` apart, without the neighbours whose colours differ too much.
fn smoothed(from: &Whole, row: isize, col: isize, step: isize, squares: &Polynomial) -> [i32; OUTPUTS] {
    let own = from.at(row, col);
    let most = squares.at(i64::from(own[1].max(0))).max(1);
    let shift = bits(most).saturating_sub(WEIGHT_BITS);
    let mut total = 4 * (most >> shift) * (most >> shift);
    let mut sums = [0i64; OUTPUTS];
    for [down, right, times] in AROUND {
        let other = from.at(row + down * step, col + right * step);
        let [x, y, z]: [i64; OUTPUTS] = std::array::from_fn(|p| i64::from(other[p]) - i64::from(own[p]));
        let left = (most - (x * x + 2 * y * y + z * z)).max(0) >> shift;
        let weight = times as i64 * left * left;
        total += weight;
        sums.iter_mut().zip([x, y, z]).for_each(|(sum, d)| *sum += weight * d);
    }
    std::array::from_fn(|p| {
        let mean = (sums[p].abs() + total / 2) / total;
        saturated(i64::from(own[p]) + if sums[p] < 0 { -mean } else { mean })
    })
}
