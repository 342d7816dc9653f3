//! Inner loops with AVX-512: they multiply four pixels at a time and sum sixteen in one tree.

use std::arch::x86_64::*;

use super::super::MAX_SIDE;
use super::fixed::Entry;
use super::portable::{self, PIXELS};
use super::table::{Run, Sample, registers_of};
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

/// `$all::<P>(run, planes)` calls `$group` for the outputs in groups of three, then the rest; a loaded patch serves a whole group.
macro_rules! in_groups {
    ($all:ident, $group:ident, $number:ty) => {
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
        fn $all<const P: usize>(run: &Run<'_, $number>, planes: &mut [&mut [f32]]) {
            for (group, planes) in planes.chunks_mut(3).enumerate() {
                match planes {
                    [a, b, c] => $group::<P, 3>(run, 3 * group, [a, b, c]),
                    [a, b] => $group::<P, 2>(run, 3 * group, [a, b]),
                    [a] => $group::<P, 1>(run, 3 * group, [a]),
                    _ => {}
                }
            }
        }
    };
}

in_groups!(all_f32, group_f32, f32);
in_groups!(all_i16, group_i16, i16);

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

    pub(super) fn interleave_i16(self, lines: &[&[i16]], columns: usize, out: &mut Vec<i16>) {
        // SAFETY: as above.
        unsafe { for_side!(lines.len(), interleave_i16(lines, columns, out)) }
    }

    pub(super) fn products_f32(self, run: &Run<'_, f32>, planes: &mut [&mut [f32]]) {
        // SAFETY: as above.
        unsafe { for_side!(run.table.side, all_f32(run, planes)) }
    }

    pub(super) fn products_i16(self, run: &Run<'_, i16>, planes: &mut [&mut [f32]]) {
        // SAFETY: as above.
        unsafe { for_side!(run.table.side, all_i16(run, planes)) }
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
fn quarters_i32([a, b, c, d]: [__m512i; 4]) -> __m512i {
    let ab = _mm512_add_epi32(_mm512_unpacklo_epi32(a, b), _mm512_unpackhi_epi32(a, b));
    let cd = _mm512_add_epi32(_mm512_unpacklo_epi32(c, d), _mm512_unpackhi_epi32(c, d));
    _mm512_add_epi32(_mm512_unpacklo_epi64(ab, cd), _mm512_unpackhi_epi64(ab, cd))
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn whole_i32([a, b, c, d]: [__m512i; 4]) -> __m512i {
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

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn group_f32<const P: usize, const G: usize>(run: &Run<'_, f32>, first: usize, planes: [&mut &mut [f32]; G]) {
    let n = const { registers_of::<f32>(P) };
    let last: u16 = const { (1 << (P * P - f32::LANES * (registers_of::<f32>(P) - 1))) - 1 };
    let registers = &run.table.registers;
    // One check covers every patch of the run and the range of kernel indices.
    let Some(patches) = run.patches.get(..(run.kernels.len() + P - 1) * P) else { return };
    let Some(most) = registers.len().checked_sub(G * n) else { return };
    // SAFETY: an aligned register of 64 bytes.
    let beyond = unsafe { _mm512_load_ps(run.table.beyond.0.as_ptr()) };
    let mut outs = planes.map(|p| p[run.at..run.at + run.count].chunks_mut(PIXELS));
    for (block, kernels) in run.kernels.as_chunks::<PIXELS>().0.iter().enumerate() {
        let mut quads = [[_mm512_setzero_ps(); 4]; G];
        for q in 0..4 {
            let mut sums = [[_mm512_setzero_ps(); 4]; G];
            for p in 0..4 {
                let x = block * PIXELS + 4 * q + p;
                let from = kernels[4 * q + p] as usize + first * n;
                if from > most {
                    return;
                }
                // SAFETY: G n registers exist from this index.
                let weights = unsafe { registers.as_ptr().add(from) };
                let mut values = [beyond; 8];
                for (r, value) in values.iter_mut().enumerate().take(n) {
                    // SAFETY: the patch lies within the patches, all but the last register within the patch, and of that only
                    // the lanes are read that do.
                    *value = unsafe {
                        let at = patches.as_ptr().add(x * P + r * f32::LANES);
                        if r + 1 < n { _mm512_loadu_ps(at) } else { _mm512_mask_loadu_ps(beyond, last, at) }
                    };
                }
                for (g, sums) in sums.iter_mut().enumerate() {
                    for (r, &value) in values.iter().enumerate().take(n) {
                        // SAFETY: one of these registers, aligned to 64 bytes.
                        let weight = unsafe { _mm512_load_ps(weights.add(g * n + r).cast()) };
                        let product = _mm512_mul_ps(value, weight);
                        sums[p] = if r == 0 { product } else { _mm512_add_ps(sums[p], product) };
                    }
                }
            }
            for g in 0..G {
                quads[g][q] = quarters_f32(sums[g]);
            }
        }
        for g in 0..G {
            if let Some(out) = outs[g].next() {
                store(out, whole_f32(quads[g]));
            }
        }
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn group_i16<const P: usize, const G: usize>(run: &Run<'_, i16>, first: usize, planes: [&mut &mut [f32]; G]) {
    let n = const { registers_of::<i16>(P) };
    let last: u32 = const { (1 << (P * P - i16::LANES * (registers_of::<i16>(P) - 1))) - 1 };
    let registers = &run.table.registers;
    // One check covers every patch of the run and the range of kernel indices.
    let Some(patches) = run.patches.get(..(run.kernels.len() + P - 1) * P) else { return };
    let Some(most) = registers.len().checked_sub(G * n) else { return };
    // SAFETY: an aligned register of 64 bytes.
    let beyond = unsafe { _mm512_load_si512(run.table.beyond.0.as_ptr().cast()) };
    let whole = _mm512_castps_si512(_mm512_set1_ps(run.table.scale));
    let mut outs = planes.map(|p| p[run.at..run.at + run.count].chunks_mut(PIXELS));
    for (block, kernels) in run.kernels.as_chunks::<PIXELS>().0.iter().enumerate() {
        let mut quads = [[_mm512_setzero_si512(); 4]; G];
        for q in 0..4 {
            let mut sums = [[_mm512_setzero_si512(); 4]; G];
            for p in 0..4 {
                let x = block * PIXELS + 4 * q + p;
                let from = Entry(kernels[4 * q + p]).place() + first * n;
                if from > most {
                    return;
                }
                // SAFETY: G n registers exist from this index.
                let weights = unsafe { registers.as_ptr().add(from) };
                let mut values = [beyond; 4];
                for (r, value) in values.iter_mut().enumerate().take(n) {
                    // SAFETY: the patch lies within the patches, all but the last register within the patch, and of that only
                    // the lanes are read that do.
                    *value = unsafe {
                        let at = patches.as_ptr().add(x * P + r * i16::LANES);
                        if r + 1 < n {
                            _mm512_loadu_si512(at.cast())
                        } else {
                            _mm512_mask_loadu_epi16(beyond, last, at)
                        }
                    };
                }
                for (g, sums) in sums.iter_mut().enumerate() {
                    for (r, &value) in values.iter().enumerate().take(n) {
                        // SAFETY: one of these registers, aligned to 64 bytes.
                        let weight = unsafe { _mm512_load_si512(weights.add(g * n + r).cast()) };
                        let pairs = _mm512_madd_epi16(value, weight);
                        sums[p] = if r == 0 { pairs } else { _mm512_add_epi32(sums[p], pairs) };
                    }
                }
            }
            for g in 0..G {
                quads[g][q] = quarters_i32(sums[g]);
            }
        }
        // SAFETY: sixteen numbers of 32 bits.
        let entries = unsafe { _mm512_loadu_si512(kernels.as_ptr().cast()) };
        // Vector form of `Entry::scale`.
        let shifts = _mm512_srli_epi32::<{ Entry::PLACE }>(entries);
        let exponents = _mm512_slli_epi32::<{ Entry::MANTISSA }>(shifts);
        let scales = _mm512_castsi512_ps(_mm512_sub_epi32(whole, exponents));
        for g in 0..G {
            if let Some(out) = outs[g].next() {
                store(out, _mm512_mul_ps(_mm512_cvtepi32_ps(whole_i32(quads[g])), scales));
            }
        }
    }
}
