//! Vectors of numbers with AVX-512.

use std::arch::x86_64::*;

use super::super::MAX_SIDE;
use super::portable::{self, PIXELS};
use crate::numeric::simd::has_avx512;

/// Calls a function that is compiled for each side of a patch.
macro_rules! for_side {
    ($side:expr, $function:ident($($arg:expr),*)) => {
        match $side {
            3 => $function::<3>($($arg),*),
            5 => $function::<5>($($arg),*),
            7 => $function::<7>($($arg),*),
            9 => $function::<9>($($arg),*),
            _ => $function::<{ MAX_SIDE }>($($arg),*),
        }
    };
}
pub(in super::super) use for_side;

/// Proof that the processor has AVX-512 with 16-bit instructions. Only [`Avx512::detect`] constructs it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) struct Avx512(());

impl Avx512 {
    pub(in super::super) fn detect() -> Option<Self> {
        has_avx512().then_some(Self(()))
    }

    /// Any number of lines up to 11.
    pub(in super::super) fn interleave_f32(self, lines: &[&[f32]], columns: usize, out: &mut Vec<f32>) {
        // SAFETY: a value of this type proves that the processor has the features.
        unsafe {
            match lines.len() {
                6 => interleave_f32::<6>(lines, columns, out),
                side => for_side!(side, interleave_f32(lines, columns, out)),
            }
        }
    }

    pub(in super::super) fn interleave_i16(self, lines: &[&[i16]], columns: usize, out: &mut Vec<i16>) {
        // SAFETY: as above.
        unsafe { for_side!(lines.len(), interleave_i16(lines, columns, out)) }
    }

    /// For each start: 1, then the `side` rows of the patch as doubles, then zeros up to a whole register, written every `stride` numbers of
    /// `out`. A start is the place of the first sample in `lines`, and rows are `step` samples apart. Stops at the first patch that is not
    /// within `lines` or does not fit. The side is one that [`Axes`](crate::l3::Axes) admit.
    #[inline]
    pub(in super::super) fn copy_patches(
        self,
        side: usize,
        (lines, step): (&[f32], usize),
        starts: impl Iterator<Item = usize>,
        (out, stride): (&mut [f64], usize),
    ) {
        debug_assert!(matches!(side, 3 | 5 | 7 | 9 | 11), "{side}");
        // SAFETY: as above.
        unsafe { for_side!(side, copy_patches((lines, step), starts, (out, stride))) }
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn copy_patches<const SIDE: usize>(
    (lines, step): (&[f32], usize),
    starts: impl Iterator<Item = usize>,
    (out, stride): (&mut [f64], usize),
) {
    let blocks = const { (1 + SIDE * SIDE).div_ceil(8) };
    let reach = (SIDE - 1).saturating_mul(step).saturating_add(SIDE);
    let first = _mm512_zextps128_ps512(_mm_set_ss(1.0));
    for (start, out) in starts.zip(out.chunks_mut(stride)) {
        if lines.get(start..start.saturating_add(reach)).is_none() || out.len() < blocks * 8 {
            return;
        }
        let mut registers = [_mm512_setzero_ps(); (1 + MAX_SIDE * MAX_SIDE).div_ceil(16)];
        registers[0] = first;
        for row in 0..SIDE {
            // The row stands in lanes of one register or of two. Lanes outside the mask are not read, wherever they would be.
            let (register, lane) = ((1 + row * SIDE) / 16, (1 + row * SIDE) % 16);
            let lanes = ((1u32 << SIDE) - 1) << lane;
            // SAFETY: the lanes of the mask are the row, which is within the lines.
            unsafe {
                let from = lines.as_ptr().add(start + row * step);
                let [now, next] = [lanes as u16, (lanes >> 16) as u16];
                registers[register] = _mm512_mask_loadu_ps(registers[register], now, from.wrapping_sub(lane));
                if next != 0 {
                    registers[register + 1] =
                        _mm512_mask_loadu_ps(registers[register + 1], next, from.wrapping_add(16 - lane));
                }
            }
        }
        for block in 0..blocks {
            let register = registers[block / 2];
            let half = if block % 2 == 0 {
                _mm512_castps512_ps256(register)
            } else {
                _mm512_extractf32x8_ps::<1>(register)
            };
            // SAFETY: there is room for as many blocks.
            unsafe { _mm512_storeu_pd(out.as_mut_ptr().add(8 * block), _mm512_cvtps_pd(half)) };
        }
    }
}

/// Register `o` of the interleaved lines contains in lane `l` column `(o L + l) / P` of line `(o L + l) % P`.
const fn columns_of<const P: usize, const L: usize>() -> [[i16; L]; P] {
    let (mut table, mut i) = ([[0; L]; P], 0);
    while i < L * P {
        table[i / L][i % L] = (i / P) as i16;
        i += 1;
    }
    table
}

/// The lanes of register `o` that line `i` fills, in `[o][i]`.
const fn lanes_of<const P: usize>(lanes: usize) -> [[u32; P]; P] {
    let (mut masks, mut place) = ([[0; P]; P], 0);
    while place < lanes * P {
        masks[place / lanes][place % P] |= 1 << (place % lanes);
        place += 1;
    }
    masks
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn interleave_f32<const P: usize>(lines: &[&[f32]], columns: usize, out: &mut Vec<f32>) {
    let blocks = columns.div_ceil(16);
    let Some(lines) = lines.first_chunk::<P>().filter(|l| l.iter().all(|l| l.len() >= blocks * 16)) else {
        return portable::interleave(lines, columns, out);
    };
    out.resize(blocks * 16 * P, 0.0);
    let (places, masks) = const { (columns_of::<P, 16>(), lanes_of::<P>(16)) };
    // SAFETY: arrays of 16 numbers of 16 bits.
    let places =
        places.each_ref().map(|p| unsafe { _mm512_cvtepi16_epi32(_mm256_loadu_si256(p.as_ptr().cast())) });
    let mut from = [_mm512_setzero_ps(); P];
    for (block, out) in out.chunks_exact_mut(16 * P).enumerate() {
        for i in 0..P {
            // SAFETY: every line has been checked to hold as many blocks.
            from[i] = unsafe { _mm512_loadu_ps(lines[i].as_ptr().add(block * 16)) };
        }
        for o in 0..P {
            let mut v = _mm512_permutexvar_ps(places[o], from[0]);
            for i in 1..P {
                v = _mm512_mask_permutexvar_ps(v, masks[o][i] as u16, places[o], from[i]);
            }
            // SAFETY: `out` has 16 P elements.
            unsafe { _mm512_storeu_ps(out.as_mut_ptr().add(16 * o), v) };
        }
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn interleave_i16<const P: usize>(lines: &[&[i16]], columns: usize, out: &mut Vec<i16>) {
    let blocks = columns.div_ceil(32);
    let Some(lines) = lines.first_chunk::<P>().filter(|l| l.iter().all(|l| l.len() >= blocks * 32)) else {
        return portable::interleave(lines, columns, out);
    };
    out.resize(blocks * 32 * P, 0);
    let (places, masks) = const { (columns_of::<P, 32>(), lanes_of::<P>(32)) };
    // SAFETY: arrays of 32 numbers of 16 bits.
    let places = places.each_ref().map(|p| unsafe { _mm512_loadu_si512(p.as_ptr().cast()) });
    let mut from = [_mm512_setzero_si512(); P];
    for (block, out) in out.chunks_exact_mut(32 * P).enumerate() {
        for i in 0..P {
            // SAFETY: every line has been checked to hold as many blocks.
            from[i] = unsafe { _mm512_loadu_si512(lines[i].as_ptr().add(block * 32).cast()) };
        }
        for o in 0..P {
            let mut v = _mm512_permutexvar_epi16(places[o], from[0]);
            for i in 1..P {
                v = _mm512_mask_permutexvar_epi16(v, masks[o][i], places[o], from[i]);
            }
            // SAFETY: `out` has 32 P elements.
            unsafe { _mm512_storeu_si512(out.as_mut_ptr().add(32 * o).cast(), v) };
        }
    }
}

/// Four lane sums: each quarter of the result holds one number per vector.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
pub(in super::super) fn quarters_f32([a, b, c, d]: [__m512; 4]) -> __m512 {
    let ab = _mm512_add_ps(_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b));
    let cd = _mm512_add_ps(_mm512_unpacklo_ps(c, d), _mm512_unpackhi_ps(c, d));
    let (ab, cd) = (_mm512_castps_pd(ab), _mm512_castps_pd(cd));
    let low = _mm512_castpd_ps(_mm512_unpacklo_pd(ab, cd));
    _mm512_add_ps(low, _mm512_castpd_ps(_mm512_unpackhi_pd(ab, cd)))
}

/// The sums of the quarters of four vectors, concatenated.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
pub(in super::super) fn whole_f32([a, b, c, d]: [__m512; 4]) -> __m512 {
    let ab = _mm512_add_ps(_mm512_shuffle_f32x4::<0x88>(a, b), _mm512_shuffle_f32x4::<0xdd>(a, b));
    let cd = _mm512_add_ps(_mm512_shuffle_f32x4::<0x88>(c, d), _mm512_shuffle_f32x4::<0xdd>(c, d));
    _mm512_add_ps(_mm512_shuffle_f32x4::<0x88>(ab, cd), _mm512_shuffle_f32x4::<0xdd>(ab, cd))
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
pub(in super::super) fn quarters_i32([a, b, c, d]: [__m512i; 4]) -> __m512i {
    let ab = _mm512_add_epi32(_mm512_unpacklo_epi32(a, b), _mm512_unpackhi_epi32(a, b));
    let cd = _mm512_add_epi32(_mm512_unpacklo_epi32(c, d), _mm512_unpackhi_epi32(c, d));
    _mm512_add_epi32(_mm512_unpacklo_epi64(ab, cd), _mm512_unpackhi_epi64(ab, cd))
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
pub(in super::super) fn whole_i32([a, b, c, d]: [__m512i; 4]) -> __m512i {
    let ab = _mm512_add_epi32(_mm512_shuffle_i32x4::<0x88>(a, b), _mm512_shuffle_i32x4::<0xdd>(a, b));
    let cd = _mm512_add_epi32(_mm512_shuffle_i32x4::<0x88>(c, d), _mm512_shuffle_i32x4::<0xdd>(c, d));
    _mm512_add_epi32(_mm512_shuffle_i32x4::<0x88>(ab, cd), _mm512_shuffle_i32x4::<0xdd>(ab, cd))
}

/// Writes the values of sixteen pixels, or of the remaining pixels of the row.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
pub(in super::super) fn store(out: &mut [f32], values: __m512) {
    let lanes = if out.len() >= PIXELS { u16::MAX } else { (1u16 << out.len()) - 1 };
    // SAFETY: the lanes that are written are within `out`.
    unsafe { _mm512_mask_storeu_ps(out.as_mut_ptr(), lanes, values) };
}
