//! Portable inner loops, which define the order of summation.

use super::super::vectors::tree;
use super::fixed::Entry;
use super::table::{Run, registers_of};
use crate::numeric::simd::Kernel;

/// Products of a run in single precision.
pub(super) struct Float<'r, 'a, 'p, 'q>(pub(super) &'r Run<'a, f32>, pub(super) &'p mut [&'q mut [f32]]);

impl Kernel for Float<'_, '_, '_, '_> {
    type Output = ();

    /// Lane `i` sums the products of taps `i`, `i + 16`, … in this order, rounding each. The constant after
    /// the last tap counts as a tap.
    #[inline(always)]
    fn run(self) {
        let Self(run, planes) = self;
        let side = run.table.side;
        let (taps, per_output) = (side * side, registers_of::<f32>(side));
        let mut lanes = [[0.0f32; 16]; 8];
        let lanes = &mut lanes[..per_output];
        for (x, &kernel) in run.kernels[..run.count].iter().enumerate() {
            if let Some(last) = lanes.last_mut() {
                *last = run.table.beyond.0;
            }
            let patch = &run.patches[x * side..][..taps];
            lanes.as_flattened_mut()[..taps].copy_from_slice(patch);
            let kernels = run.table.registers[kernel as usize..].chunks_exact(per_output);
            for (plane, weights) in planes.iter_mut().zip(kernels) {
                let mut sums = [0.0f32; 16];
                for (register, (values, weights)) in lanes.iter().zip(weights).enumerate() {
                    for i in 0..16 {
                        let product = values[i] * weights.0[i];
                        sums[i] = if register == 0 { product } else { sums[i] + product };
                    }
                }
                plane[run.at + x] = tree(&sums);
            }
        }
    }
}

/// Products of a run in fixed point.
pub(super) struct Fixed<'r, 'a, 'p, 'q>(pub(super) &'r Run<'a, i16>, pub(super) &'p mut [&'q mut [f32]]);

impl Kernel for Fixed<'_, '_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self(run, planes) = self;
        let side = run.table.side;
        let (taps, per_output) = (side * side, registers_of::<i16>(side));
        let mut lanes = [[0i16; 32]; 4];
        let lanes = &mut lanes[..per_output];
        for (x, &kernel) in run.kernels[..run.count].iter().enumerate() {
            if let Some(last) = lanes.last_mut() {
                *last = run.table.beyond.0;
            }
            let patch = &run.patches[x * side..][..taps];
            lanes.as_flattened_mut()[..taps].copy_from_slice(patch);
            let (place, scale) = (Entry(kernel).place(), Entry(kernel).scale(run.table.scale));
            let kernels = run.table.registers[place..].chunks_exact(per_output);
            for (plane, weights) in planes.iter_mut().zip(kernels) {
                let mut sum = 0i32;
                for (values, weights) in lanes.iter().zip(weights) {
                    for (&value, &weight) in values.iter().zip(&weights.0) {
                        // No partial sum overflows; see `FixedKernels`.
                        sum = sum.wrapping_add(i32::from(value) * i32::from(weight));
                    }
                }
                plane[run.at + x] = sum as f32 * scale;
            }
        }
    }
}
