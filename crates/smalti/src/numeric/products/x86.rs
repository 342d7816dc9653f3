//! Products with fused multiply-adds.

use crate::numeric::simd::{has_avx2_and_fma, has_avx512};

/// [`super::add_products`], if the processor can multiply and add in one step.
pub(super) fn add_products(batch: &[f64], stride: usize, sums: &mut [f64]) -> bool {
    if has_avx512() {
        // SAFETY: the required features were detected.
        unsafe { avx512::add(batch, stride, sums) };
    } else if has_avx2_and_fma() {
        // SAFETY: as above.
        unsafe { avx2::add(batch, stride, sums) };
    } else {
        return false;
    }
    true
}

/// A module whose `add` sums products in registers of some doubles.
macro_rules! of_registers {
    ($name:ident, $features:literal, $lanes:literal, $zero:ident, $load:ident, $store:ident, $every:ident, $fused:ident, $plus:ident) => {
        mod $name {
            use std::arch::x86_64::{$every, $fused, $load, $plus, $store, $zero};

            #[target_feature(enable = $features)]
            pub(super) fn add(batch: &[f64], stride: usize, sums: &mut [f64]) {
                let (batch, sums) = (batch.as_chunks().0, sums.as_chunks_mut().0);
                let registers = stride / $lanes;
                for down in 0..registers {
                    let mut across = down;
                    while across + 3 <= registers {
                        block::<3>(batch, registers, [down, across], sums);
                        across += 3;
                    }
                    match registers - across {
                        2 => block::<2>(batch, registers, [down, across], sums),
                        1 => block::<1>(batch, registers, [down, across], sums),
                        _ => {}
                    }
                }
            }

            /// Adds Σ z zᵀ to `sums` for the rows of one register of z and the columns of `C` registers. z has `registers` of them,
            /// and `at` are the first ones of the block. The sums of the block stay in registers: three by eight of 32 that AVX-512
            /// has, or three by four of 16 that AVX2 has.
            #[inline]
            #[target_feature(enable = $features)]
            fn block<const C: usize>(
                batch: &[[f64; $lanes]],
                registers: usize,
                at: [usize; 2],
                sums: &mut [[f64; $lanes]],
            ) {
                let mut acc = [[$zero(); C]; $lanes];
                for z in batch.chunks_exact(registers) {
                    let left = &z[at[0]];
                    let mut right = [$zero(); C];
                    for (register, values) in right.iter_mut().zip(&z[at[1]..at[1] + C]) {
                        // SAFETY: the array is as long as the register.
                        *register = unsafe { $load(values.as_ptr()) };
                    }
                    for (row, left) in acc.iter_mut().zip(left) {
                        let left = $every(*left);
                        for (sum, right) in row.iter_mut().zip(right) {
                            *sum = $fused(left, right, *sum);
                        }
                    }
                }
                for (r, row) in acc.iter().enumerate() {
                    let first = (at[0] * $lanes + r) * registers + at[1];
                    for (sum, more) in sums[first..first + C].iter_mut().zip(row) {
                        // SAFETY: as above.
                        unsafe { $store(sum.as_mut_ptr(), $plus($load(sum.as_ptr()), *more)) };
                    }
                }
            }
        }
    };
}

of_registers!(
    avx512,
    "avx512f,avx512bw,avx512dq,avx512vl",
    8,
    _mm512_setzero_pd,
    _mm512_loadu_pd,
    _mm512_storeu_pd,
    _mm512_set1_pd,
    _mm512_fmadd_pd,
    _mm512_add_pd
);
of_registers!(
    avx2,
    "avx2,fma",
    4,
    _mm256_setzero_pd,
    _mm256_loadu_pd,
    _mm256_storeu_pd,
    _mm256_set1_pd,
    _mm256_fmadd_pd,
    _mm256_add_pd
);
