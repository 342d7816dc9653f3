//! Fixed-point rendering with 16-bit kernels and samples.

use super::super::window::Window;
use super::super::{L3Error, Pipeline};
use super::table::{HIGH_PART, Place};
use crate::numeric::simd::{Kernel, dispatch};

/// Maximum sum of the magnitudes of a kernel's weights: with 16-bit samples the sum fits 32 bits.
const MAX_TOTAL: i64 = 65_535;
/// Maximum number of fractional bits of a kernel.
const MAX_SHIFT: u8 = 24;

/// Kernels for integer arithmetic, as in camera firmware.
///
/// With d = (sample − `black`), shifted right by `sample_shift` bits (halves round up) and clamped to 16
/// bits,
///
/// output = `scale` · 2^−`shifts` · (`offsets` + Σ `weights` · d).
///
/// The sum fits 32 bits in any order: every weight is within ±32767, and for every kernel 32768 Σ |weight| +
/// |offset| is below 2³¹ (so Σ |weight| ≤ 65535). Every class has as many fractional bits as these bounds
/// allow.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedKernels {
    /// Weights times 2^`shifts` of their class, ordered class, output, tap (row order).
    pub weights: Vec<i16>,
    /// Offsets in units of the sum, ordered class, output.
    pub offsets: Vec<i32>,
    /// Fractional bits of the weights of each class, 0 to 24, equal for all outputs.
    pub shifts: Vec<u8>,
    /// Value subtracted from samples, digital numbers: the rounded black level. The offsets compensate for
    /// the rounding.
    pub black: i32,
    /// Right shift of the difference: 1 where the range from black to white does not fit 15 bits, otherwise
    /// 0.
    pub sample_shift: u32,
    /// Factor from sums to outputs for a class without fractional bits.
    pub scale: f32,
}

impl FixedKernels {
    pub(super) fn new(pipeline: &Pipeline, black: f64, white: f64) -> Result<Self, L3Error> {
        let wrong = |reason: String| L3Error::Table(reason);
        if !(black.is_finite() && white.is_finite() && white > black) {
            return Err(wrong(format!("white level {white} must lie above black level {black}")));
        }
        let range = white - black;
        let sample_shift = u32::from(range > f64::from(i16::MAX));
        let unit = range / f64::from(1 << sample_shift);
        let scale = (1.0 / unit) as f32;
        if black.abs() > 1e5 || white > 1e5 || !scale.is_finite() {
            return Err(wrong(format!("levels {black} and {white} are not those of 16-bit samples")));
        }
        let rounded = black.round();
        let kernels = pipeline.kernels();
        let taps = pipeline.axes().taps();
        // The error of a normalised sample due to the rounded black level.
        let excess = (black - rounded) / range;
        let offset = |(weights, &offset): (&[f32], &f32)| {
            let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
            (f64::from(offset) - total * excess) * unit
        };
        let offsets: Vec<f64> =
            kernels.weights.chunks_exact(taps).zip(&kernels.offsets).map(offset).collect();
        let mut fixed = Self {
            weights: Vec::with_capacity(kernels.weights.len()),
            offsets: Vec::with_capacity(offsets.len()),
            shifts: Vec::with_capacity(pipeline.classes().len()),
            black: rounded as i32,
            sample_shift,
            scale,
        };
        let outputs = pipeline.outputs().len();
        for (weights, offsets) in kernels.weights.chunks_exact(taps * outputs).zip(offsets.chunks(outputs)) {
            let (shift, (weights, offsets)) = (0..=most_shift(weights, taps))
                .rev()
                .find_map(|shift| Some((shift, quantized(weights, offsets, taps, shift)?)))
                .ok_or(L3Error::NoFixedPoint("its weights are too large for 16 bits"))?;
            fixed.weights.extend(weights);
            fixed.offsets.extend(offsets);
            fixed.shifts.push(shift);
        }
        Ok(fixed)
    }

    /// Factor from sums to outputs of a class; `None` when there is no such class.
    #[must_use]
    pub fn scale_of(&self, class: usize) -> Option<f32> {
        self.shifts.get(class).map(|&shift| shifted(self.scale, u32::from(shift)))
    }

    /// The two weights that represent an offset, for the factors [`HIGH_PART`] and 1.
    pub(super) fn parts(offset: i32) -> [i16; 2] {
        let low = (offset + HIGH_PART / 2).rem_euclid(HIGH_PART) - HIGH_PART / 2;
        [((offset - low) / HIGH_PART) as i16, low as i16]
    }
}

/// Weights and offsets of a class with `shift` fractional bits, if they respect the bounds.
fn quantized(weights: &[f32], offsets: &[f64], taps: usize, shift: u8) -> Option<(Vec<i16>, Vec<i32>)> {
    let factor = f64::from(1u32 << shift);
    let integer = |&w: &f32| {
        let w = (f64::from(w) * factor).round();
        (w.abs() <= f64::from(i16::MAX)).then_some(w as i16)
    };
    let weights: Vec<i16> = weights.iter().map(integer).collect::<Option<_>>()?;
    let offset = |(weights, offset): (&[i16], &f64)| {
        let total: i64 = weights.iter().map(|w| i64::from(w.unsigned_abs())).sum();
        let offset = (offset * factor).round();
        // The magnitudes of the two parts can exceed that of the offset by at most twice the finer part.
        let most = total as f64 * 32_768.0 + offset.abs() + f64::from(HIGH_PART);
        let whole = most < f64::from(i32::MAX) && total <= MAX_TOTAL;
        let parts = offset.abs() + f64::from(HIGH_PART) < f64::from(HIGH_PART) * f64::from(i16::MAX);
        (whole && parts).then_some(offset as i32)
    };
    let offsets = weights.chunks_exact(taps).zip(offsets).map(offset).collect::<Option<_>>()?;
    Some((weights, offsets))
}

/// Upper bound on the fractional bits of a class.
fn most_shift(weights: &[f32], taps: usize) -> u8 {
    let most = |limit: f64, found: f64| (limit / found.max(f64::MIN_POSITIVE)).log2().ceil();
    let largest = weights.iter().fold(0.0f64, |m, &w| m.max(f64::from(w).abs()));
    let total = |kernel: &[f32]| kernel.iter().map(|&w| f64::from(w).abs()).sum::<f64>();
    let total = weights.chunks_exact(taps).map(total).fold(0.0, f64::max);
    let shift = most(f64::from(i16::MAX), largest).min(most(MAX_TOTAL as f64, total));
    shift.clamp(0.0, f64::from(MAX_SHIFT)) as u8
}

/// Index of the kernels of a class, with their fractional bits in the upper bits. One read yields both.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry(pub(super) u32);

impl Entry {
    /// Bits of the index.
    pub(super) const PLACE: u32 = 27;
    /// Position of the exponent in a single-precision number.
    pub(super) const MANTISSA: u32 = 23;

    /// `None` when the index does not fit.
    pub(super) fn new(place: u32, shift: u8) -> Option<Self> {
        let fits = place >> Self::PLACE == 0 && shift <= MAX_SHIFT;
        fits.then_some(Self(place | u32::from(shift) << Self::PLACE))
    }

    /// Index of the first register.
    #[inline(always)]
    pub(super) fn place(self) -> usize {
        (self.0 & ((1 << Self::PLACE) - 1)) as usize
    }

    /// Factor from sums to outputs, given that for no fractional bits.
    #[inline(always)]
    pub(super) fn scale(self, whole: f32) -> f32 {
        shifted(whole, self.0 >> Self::PLACE)
    }
}

/// `scale` / 2^`shift`, exact: levels are within 1e5, so the scale is at least 2^-18 and finite.
#[inline(always)]
fn shifted(scale: f32, shift: u32) -> f32 {
    f32::from_bits(scale.to_bits().wrapping_sub(shift << Entry::MANTISSA))
}

/// Samples of a raw image, read in the form of [`FixedKernels`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Digital<'a> {
    samples: &'a [u16],
    cols: usize,
    black: i32,
    shift: u32,
}

impl<'a> Digital<'a> {
    pub(super) fn new(samples: &'a [u16], cols: usize, kernels: &FixedKernels) -> Self {
        Self { samples, cols, black: kernels.black, shift: kernels.sample_shift }
    }

    /// The 16-bit value of a sample.
    #[inline(always)]
    pub(super) fn reduced(&self, sample: u16) -> i16 {
        let difference = i32::from(sample) - self.black;
        let reduced = (difference + (self.shift & 1) as i32) >> self.shift;
        reduced.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16
    }

    pub(super) fn fill(&self, window: &mut Window<i16>, place: &Place) {
        dispatch(Fill { digital: self, window, place });
    }
}

struct Fill<'a> {
    digital: &'a Digital<'a>,
    window: &'a mut Window<i16>,
    place: &'a Place,
}

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { digital, window, place } = self;
        let margin = [place.half; 2];
        window.read_with(place.size, place.first, place.rows, margin, place.tile, |row, out| {
            let from = row * digital.cols;
            let samples = &digital.samples[from..from + digital.cols];
            out.iter_mut().zip(samples).for_each(|(o, &s)| *o = digital.reduced(s));
        });
    }
}
