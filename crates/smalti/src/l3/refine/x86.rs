//! The products with AVX-512: sixteen pixels are summed in one tree.

use std::arch::x86_64::*;

use super::super::blocks::LANES;
use super::super::vectors::{Avx512, PIXELS, quarters_f32, store, whole_f32};
use super::inputs::{OUTPUTS, SIDE_XZ, SIDE_Y};
use super::layout::{INPUTS_COARSE, INPUTS_FINE, Kernels, PATCH_XZ, PATCH_Y, REGISTERS, RowInputs};
use super::roots::ROOTS;

/// Lanes of the second register that hold the end of the patch of Y; the rest hold the beginning of that of X and Z.
const END_Y: usize = PATCH_Y - LANES;
const BEGIN_XZ: usize = LANES - END_Y;
/// Lanes of the third register that hold the end of the patch of X and Z, which the roots follow.
const END_XZ: usize = PATCH_XZ - BEGIN_XZ;

/// A mask of lanes.
const fn lanes(first: usize, end: usize) -> u16 {
    ((1u32 << end) - (1 << first)) as u16
}

/// As [`super::products::products`].
pub(super) fn products(
    _: Avx512,
    kernels: &[Kernels],
    classes: &[u32],
    inputs: &RowInputs,
    out: [&mut [f32]; OUTPUTS],
) {
    // SAFETY: a value of the first parameter's type proves that the processor has the features.
    unsafe { all(kernels, classes, inputs, out) }
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn all(kernels: &[Kernels], classes: &[u32], inputs: &RowInputs, out: [&mut [f32]; OUTPUTS]) {
    let (blocks, _) = classes.as_chunks::<PIXELS>();
    let cols = blocks.len() * PIXELS;
    let RowInputs { y, xz, roots, fine, coarse, .. } = inputs;
    // One check covers the inputs of all pixels.
    let enough = y.len() >= (cols + SIDE_Y - 1) * SIDE_Y
        && xz.len() >= (cols + SIDE_XZ - 1) * 2 * SIDE_XZ
        && roots.len() >= cols * ROOTS
        && fine.len() >= cols * INPUTS_FINE
        && coarse.len() >= cols / 2 * INPUTS_COARSE;
    if !enough {
        return;
    }
    let mut outs = out.map(|plane| plane.chunks_mut(PIXELS));
    for (block, classes) in blocks.iter().enumerate() {
        let mut quads = [[_mm512_setzero_ps(); 4]; OUTPUTS];
        for q in 0..4 {
            let mut sums = [[_mm512_setzero_ps(); 4]; OUTPUTS];
            for p in 0..4 {
                let x = block * PIXELS + 4 * q + p;
                let Some(kernels) = kernels.get(classes[4 * q + p] as usize) else { return };
                // SAFETY: only lanes whose numbers have been checked to exist are read; a pointer whose first lanes are masked may
                // begin before its list.
                let values: [__m512; REGISTERS] = unsafe {
                    let (y, xz) = (y.as_ptr().add(x * SIDE_Y), xz.as_ptr().add(x * 2 * SIDE_XZ));
                    let roots = roots.as_ptr().add(x * ROOTS);
                    let (fine, coarse) =
                        (fine.as_ptr().add(x * INPUTS_FINE), coarse.as_ptr().add(x / 2 * INPUTS_COARSE));
                    let end_y = _mm512_maskz_loadu_ps(lanes(0, END_Y), y.add(LANES));
                    let end_xz = _mm512_maskz_loadu_ps(lanes(0, END_XZ), xz.add(BEGIN_XZ));
                    let fine = _mm512_maskz_loadu_ps(lanes(0, INPUTS_FINE), fine);
                    let coarse = coarse.wrapping_sub(INPUTS_FINE);
                    [
                        _mm512_loadu_ps(y),
                        _mm512_mask_loadu_ps(end_y, lanes(END_Y, LANES), xz.wrapping_sub(END_Y)),
                        _mm512_mask_loadu_ps(
                            end_xz,
                            lanes(END_XZ, END_XZ + ROOTS),
                            roots.wrapping_sub(END_XZ),
                        ),
                        _mm512_mask_loadu_ps(fine, lanes(INPUTS_FINE, LANES), coarse),
                    ]
                };
                for (kernel, sums) in kernels.iter().zip(&mut sums) {
                    for (r, (value, weights)) in values.iter().zip(kernel).enumerate() {
                        // SAFETY: a register, aligned to 64 bytes.
                        let weights = unsafe { _mm512_load_ps(weights.0.as_ptr()) };
                        let product = _mm512_mul_ps(*value, weights);
                        sums[p] = if r == 0 { product } else { _mm512_add_ps(sums[p], product) };
                    }
                }
            }
            for (quads, sums) in quads.iter_mut().zip(sums) {
                quads[q] = quarters_f32(sums);
            }
        }
        for (out, quads) in outs.iter_mut().zip(quads) {
            if let Some(out) = out.next() {
                store(out, whole_f32(quads));
            }
        }
    }
}
