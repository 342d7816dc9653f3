//! The inner loops of demosaicking.
//!
//! Each loop is written once on arrays of lanes. Products and sums are rounded separately everywhere, so that every
//! instruction set gives the same bits.

use crate::numeric::simd::Kernel;

/// Lanes per vector: one AVX-512 register of `f32`, or two of AVX2.
pub(super) const LANES: usize = 16;

/// One sample of a vector of pixels: its position and its weight in each lane.
#[derive(Debug, Clone)]
pub(super) struct LaneTap {
    /// Offset in the buffer from the first lane, shifted by the largest reach upwards and to the left.
    pub(super) offset: usize,
    pub(super) weights: [f32; LANES],
}

/// An output sample of a plan.
pub(super) trait Sample: Copy + Default + Send + Sync {
    fn from_f32(value: f32) -> Self;
}

impl Sample for f32 {
    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        value
    }
}

impl Sample for u16 {
    /// The nearest integer. `value` is a weighted mean of 16-bit numbers and therefore in range. Adding 2²³ moves it to the low
    /// bits of the mantissa, which vectorises, unlike a checked conversion.
    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        (value + 8_388_608.0).to_bits() as u16
    }
}

/// One row of one channel: `out[x] = Σ weight · window[x + offset]`, where the taps of the vector at `x` are
/// `spans[(x / LANES) % spans.len()]`. `window` reaches a vector beyond the last offset of the row.
pub(super) struct WeightedRow<'a, T> {
    pub(super) taps: &'a [LaneTap],
    pub(super) spans: &'a [(usize, usize)],
    pub(super) window: &'a [f32],
    pub(super) out: &'a mut [T],
}

/// Vectors that share one load of the weights.
const BLOCK: usize = 8;

impl<T: Sample> Kernel for WeightedRow<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { taps, spans, window, out } = self;
        let step = spans.len() * LANES;
        for (vector, &(from, to)) in spans.iter().enumerate() {
            let taps = taps.get(from..to).unwrap_or(&[]);
            let mut at = vector * LANES;
            while at + (BLOCK - 1) * step + LANES <= out.len() {
                weighted_block::<T, BLOCK>(taps, step, &window[at..], &mut out[at..]);
                at += BLOCK * step;
            }
            while at < out.len() {
                weighted_block::<T, 1>(taps, step, &window[at..], &mut out[at..]);
                at += step;
            }
        }
    }
}

/// `B` vectors of pixels, `step` apart.
#[inline(always)]
fn weighted_block<T: Sample, const B: usize>(taps: &[LaneTap], step: usize, window: &[f32], out: &mut [T]) {
    // One window of equal length per vector, so that one bounds check per tap suffices.
    let Some(len) = window.len().checked_sub((B - 1) * step) else { return };
    let mut windows = [window; B];
    for (b, w) in windows.iter_mut().enumerate() {
        *w = &window[b * step..][..len];
    }
    let mut sums = [[0.0f32; LANES]; B];
    for tap in taps {
        let (from, to) = (tap.offset, tap.offset + LANES);
        if from > to || to > len {
            return;
        }
        for b in 0..B {
            let samples = &windows[b][from..to];
            for lane in 0..LANES {
                sums[b][lane] += tap.weights[lane] * samples[lane];
            }
        }
    }
    for (b, sum) in sums.iter().enumerate() {
        // A loop, because the closure of `map` would be compiled without the instruction set. The local array keeps the sums
        // in registers, which writing to `out` directly does not.
        let mut values = [T::default(); LANES];
        for lane in 0..LANES {
            values[lane] = T::from_f32(sum[lane]);
        }
        let out = &mut out[b * step..];
        match out.first_chunk_mut::<LANES>() {
            Some(full) => *full = values,
            // The last, incomplete vector of a row.
            None => out.iter_mut().zip(values).for_each(|(o, v)| *o = v),
        }
    }
}

/// Three rows of Bayer samples of equal length.
#[derive(Debug, Clone, Copy)]
pub(super) struct BayerLines<'a> {
    pub(super) above: &'a [u16],
    pub(super) here: &'a [u16],
    pub(super) below: &'a [u16],
    /// Whether the first sample of the middle row is green.
    pub(super) green_first: bool,
}

/// Bilinear interpolation of the middle row: green, the other channel of the row, and the channel that the row lacks. The
/// first and last pixels are not written.
pub(super) struct BayerRow<'a> {
    pub(super) lines: BayerLines<'a>,
    pub(super) green: &'a mut [u16],
    pub(super) own: &'a mut [u16],
    pub(super) other: &'a mut [u16],
}

/// Pixels per vector: 32 of 16 bits fill an AVX-512 register.
const WIDE: usize = 2 * LANES;

impl Kernel for BayerRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lines, green, own, other } = self;
        let n = lines.here.len();
        // The first pixel has no left neighbour, so vectors start at odd columns.
        let mut col = 1;
        while col + WIDE < n {
            bayer_vector::<WIDE>(&lines, col, green, own, other);
            col += WIDE;
        }
        while col + 1 < n {
            bayer_vector::<1>(&lines, col, green, own, other);
            col += 1;
        }
    }
}

#[inline(always)]
fn bayer_vector<const N: usize>(
    lines: &BayerLines<'_>,
    col: usize,
    green: &mut [u16],
    own: &mut [u16],
    other: &mut [u16],
) {
    let at = |line: &[u16], col: usize| line.get(col..).and_then(|l| l.first_chunk::<N>()).copied();
    let (a, h, b) = (lines.above, lines.here, lines.below);
    let corners = (at(a, col - 1), at(a, col + 1), at(b, col - 1), at(b, col + 1));
    let cross = (at(a, col), at(h, col - 1), at(h, col), at(h, col + 1), at(b, col));
    let (Some(nw), Some(ne), Some(sw), Some(se)) = corners else { return };
    let (Some(north), Some(west), Some(here), Some(east), Some(south)) = cross else { return };
    let outs = (green.get_mut(col..), own.get_mut(col..), other.get_mut(col..));
    let (Some(green), Some(own), Some(other)) = outs else { return };
    let outs = (green.first_chunk_mut::<N>(), own.first_chunk_mut::<N>(), other.first_chunk_mut::<N>());
    let (Some(green), Some(own), Some(other)) = outs else { return };
    for i in 0..N {
        let is_green = lines.green_first == (col + i).is_multiple_of(2);
        let across = half(west[i], east[i]);
        let down = half(north[i], south[i]);
        let four = quarter(west[i], east[i], north[i], south[i]);
        let diagonal = quarter(nw[i], ne[i], sw[i], se[i]);
        green[i] = if is_green { here[i] } else { four };
        own[i] = if is_green { across } else { here[i] };
        other[i] = if is_green { down } else { diagonal };
    }
}

/// Mean of two, halves up: one instruction on vectors of 16 bits.
#[inline(always)]
fn half(a: u16, b: u16) -> u16 {
    ((u32::from(a) + u32::from(b) + 1) >> 1) as u16
}

/// `(a + b + c + d + 2) >> 2` without leaving 16 bits: the mean of two means, less one where both roundings went up.
#[inline(always)]
fn quarter(a: u16, b: u16, c: u16, d: u16) -> u16 {
    let (ab, cd) = (half(a, b), half(c, d));
    half(ab, cd) - (((a ^ b) | (c ^ d)) & (ab ^ cd) & 1)
}
