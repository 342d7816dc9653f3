//! The products of a row of pixels with the kernels of their classes.

use super::super::blocks::LANES;
use super::super::vectors::{Register, tree};
use super::inputs::{OUTPUTS, SIDE_XZ, SIDE_Y};
use super::layout::{
    FIRST_ROOT, FIRST_SMOOTH, INPUTS_COARSE, INPUTS_FINE, Kernels, PATCH_XZ, PATCH_Y, REGISTERS, RowInputs,
};
use super::roots::ROOTS;
use crate::numeric::simd::{Kernel, dispatch};

/// Writes X, Y and Z of a row: Σ weight · input over the kernels of each pixel's class. `classes` are padded to whole vectors of pixels.
pub(super) fn products(kernels: &[Kernels], classes: &[u32], inputs: &RowInputs, out: [&mut [f32]; OUTPUTS]) {
    #[cfg(target_arch = "x86_64")]
    if let Some(set) = super::super::vectors::Avx512::detect() {
        return super::x86::products(set, kernels, classes, inputs, out);
    }
    dispatch(Products { kernels, classes, inputs, out });
}

/// The portable loop, which defines the order of summation: lane i sums the products of inputs i, i + 16, …, and a fixed tree the lanes.
struct Products<'a> {
    kernels: &'a [Kernels],
    classes: &'a [u32],
    inputs: &'a RowInputs,
    out: [&'a mut [f32]; OUTPUTS],
}

impl Kernel for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { kernels, classes, inputs, mut out } = self;
        let mut registers = [Register([0.0; LANES]); REGISTERS];
        for (col, &class) in classes.iter().enumerate().take(out[0].len()) {
            let Some(kernels) = kernels.get(class as usize) else { continue };
            let lanes = Register::flat_mut(&mut registers);
            let mut copy = |from: &[f32], each: usize, at: usize, to: usize, count: usize| {
                if let Some(found) = from.get(at * each..at * each + count) {
                    lanes[to..to + count].copy_from_slice(found);
                }
            };
            copy(&inputs.y, SIDE_Y, col, 0, PATCH_Y);
            copy(&inputs.xz, 2 * SIDE_XZ, col, PATCH_Y, PATCH_XZ);
            copy(&inputs.roots, ROOTS, col, FIRST_ROOT, ROOTS);
            copy(&inputs.fine, INPUTS_FINE, col, FIRST_SMOOTH, INPUTS_FINE);
            copy(&inputs.coarse, INPUTS_COARSE, col / 2, FIRST_SMOOTH + INPUTS_FINE, INPUTS_COARSE);
            for (kernel, plane) in kernels.iter().zip(&mut out) {
                let mut sums = [0.0f32; LANES];
                for (register, (values, weights)) in registers.iter().zip(kernel).enumerate() {
                    for ((sum, value), weight) in sums.iter_mut().zip(values.0).zip(weights.0) {
                        *sum = if register == 0 { value * weight } else { *sum + value * weight };
                    }
                }
                plane[col] = tree(&sums);
            }
        }
    }
}
