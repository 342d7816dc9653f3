//! Inner loops with AVX-512: they multiply four pixels at a time and sum sixteen in one tree.

use std::arch::x86_64::*;

use super::super::MAX_SIDE;
use super::super::vectors::{
    Avx512, PIXELS, for_side, quarters_f32, quarters_i32, store, whole_f32, whole_i32,
};
use super::fixed::Entry;
use super::table::{Run, Sample, registers_of};

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

pub(super) fn products_f32(_: Avx512, run: &Run<'_, f32>, planes: &mut [&mut [f32]]) {
    // SAFETY: a value of this type proves that the processor has the features.
    unsafe { for_side!(run.table.side, all_f32(run, planes)) }
}

pub(super) fn products_i16(_: Avx512, run: &Run<'_, i16>, planes: &mut [&mut [f32]]) {
    // SAFETY: as above.
    unsafe { for_side!(run.table.side, all_i16(run, planes)) }
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
