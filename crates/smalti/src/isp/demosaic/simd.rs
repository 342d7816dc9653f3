//! The inner loops of demosaicking, compiled for each instruction set and chosen at run time.
//!
//! Each loop is written once on arrays of lanes. Products and sums are rounded separately everywhere, so that every
//! instruction set gives the same bits.

/// Lanes per vector: one AVX-512 register of `f32`, or two of AVX2.
pub(super) const LANES: usize = 16;

/// An instruction set of this machine. Only [`Simd::all`] constructs one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Simd(Set);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Set {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Simd {
    /// The instruction sets of this machine, the widest last.
    pub(super) fn all() -> Vec<Self> {
        let mut sets = vec![Self(Set::Portable)];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                sets.push(Self(Set::Avx2));
            }
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512vl")
            {
                sets.push(Self(Set::Avx512));
            }
        }
        sets
    }

    /// The widest instruction set.
    pub(super) fn best() -> Self {
        Self::all().pop().unwrap_or(Self(Set::Portable))
    }
}

/// `$name(simd, args…)` runs `$body(args…)`, compiled for the instruction set.
macro_rules! dispatched {
    ($(#[$doc:meta])* $name:ident => $body:ident($($arg:ident: $type:ty),* $(,)?)) => {
        $(#[$doc])*
        pub(super) fn $name(simd: Simd, $($arg: $type),*) {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn avx2($($arg: $type),*) {
                    $body($($arg),*);
                }
                #[target_feature(enable = "avx512f,avx512bw,avx512vl")]
                fn avx512($($arg: $type),*) {
                    $body($($arg),*);
                }
                match simd.0 {
                    Set::Portable => $body($($arg),*),
                    // SAFETY: a `Simd` of this kind exists only where the processor was found to have it.
                    Set::Avx2 => unsafe { avx2($($arg),*) },
                    // SAFETY: as above.
                    Set::Avx512 => unsafe { avx512($($arg),*) },
                }
            }
            #[cfg(not(target_arch = "x86_64"))]
            {
                let _ = simd;
                $body($($arg),*);
            }
        }
    };
}

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
    /// [`weighted_row_f32`] or its equivalent for the type.
    fn weighted_row(simd: Simd, taps: &[LaneTap], spans: &[(usize, usize)], window: &[f32], out: &mut [Self]);
}

impl Sample for f32 {
    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        value
    }

    fn weighted_row(
        simd: Simd,
        taps: &[LaneTap],
        spans: &[(usize, usize)],
        window: &[f32],
        out: &mut [Self],
    ) {
        weighted_row_f32(simd, taps, spans, window, out);
    }
}

impl Sample for u16 {
    /// The nearest integer. `value` is a weighted mean of 16-bit numbers and therefore in range. Adding 2²³ moves it to the low
    /// bits of the mantissa, which vectorises, unlike a checked conversion.
    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        (value + 8_388_608.0).to_bits() as u16
    }

    fn weighted_row(
        simd: Simd,
        taps: &[LaneTap],
        spans: &[(usize, usize)],
        window: &[f32],
        out: &mut [Self],
    ) {
        weighted_row_u16(simd, taps, spans, window, out);
    }
}

dispatched! {
    /// One row of one channel: `out[x] = Σ weight · window[x + offset]`, where the taps of the vector at `x` are
    /// `spans[(x / LANES) % spans.len()]`. `window` reaches a vector beyond the last offset of the row.
    weighted_row_f32 => weighted_row_body(taps: &[LaneTap], spans: &[(usize, usize)], window: &[f32], out: &mut [f32])
}

dispatched! {
    /// As [`weighted_row_f32`], rounded.
    weighted_row_u16 => weighted_row_body(taps: &[LaneTap], spans: &[(usize, usize)], window: &[f32], out: &mut [u16])
}

/// Vectors that share one load of the weights.
const BLOCK: usize = 8;

#[inline(always)]
fn weighted_row_body<T: Sample>(taps: &[LaneTap], spans: &[(usize, usize)], window: &[f32], out: &mut [T]) {
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

dispatched! {
    /// Bilinear interpolation of the middle row: green, the other channel of the row, and the channel that the row lacks. The
    /// first and last pixels are not written.
    bayer_row => bayer_row_body(lines: BayerLines<'_>, green: &mut [u16], own: &mut [u16], other: &mut [u16])
}

/// Pixels per vector: 32 of 16 bits fill an AVX-512 register.
const WIDE: usize = 2 * LANES;

#[inline(always)]
fn bayer_row_body(lines: BayerLines<'_>, green: &mut [u16], own: &mut [u16], other: &mut [u16]) {
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
