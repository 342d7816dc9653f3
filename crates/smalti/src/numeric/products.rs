//! Sums of products z zᵀ of vectors with themselves, for moments.

/// Doubles in a register. The length of z with its padding is a multiple of it.
pub(crate) const LANES: usize = 8;

/// Adds Σ z zᵀ over a batch of vectors of `stride` numbers, one after the other. Only the upper triangle of `sums`, a square
/// matrix with rows of `stride` numbers, is valid afterwards. Call it within a [`Kernel`](super::simd::Kernel).
#[inline(always)]
pub(crate) fn add_products(batch: &[f64], stride: usize, sums: &mut [f64]) {
    let (batch, sums) = (batch.as_chunks::<LANES>().0, sums.as_chunks_mut::<LANES>().0);
    let registers = stride / LANES;
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

/// Adds Σ z zᵀ to `sums` for the rows of one register of z and the columns of `C` registers. z has `registers` of them, and `at`
/// are the first ones of the block.
///
/// The sums of the block stay in registers: three by eight of 32 that AVX-512 has. The rows are written out, since compilers turn a
/// loop over them into gathers, or store every sum in every step.
#[inline(always)]
fn block<const C: usize>(
    batch: &[[f64; LANES]],
    registers: usize,
    at: [usize; 2],
    sums: &mut [[f64; LANES]],
) {
    let mut acc = [[[0.0; LANES]; C]; LANES];
    for z in batch.chunks_exact(registers) {
        let left = z[at[0]];
        let mut right = [[0.0; LANES]; C];
        right.copy_from_slice(&z[at[1]..at[1] + C]);
        macro_rules! add_rows {
            ($($r:literal)*) => {$(
                for c in 0..C {
                    acc[$r][c] = plus_product(acc[$r][c], left[$r], right[c]);
                }
            )*};
        }
        add_rows!(0 1 2 3 4 5 6 7);
    }
    for (r, row) in acc.iter().enumerate() {
        let first = (at[0] * LANES + r) * registers + at[1];
        for (sum, more) in sums[first..first + C].iter_mut().zip(row) {
            *sum = plus_product(*sum, 1.0, *more);
        }
    }
}

#[inline(always)]
fn plus_product(mut sum: [f64; LANES], factor: f64, values: [f64; LANES]) -> [f64; LANES] {
    for i in 0..LANES {
        sum[i] += factor * values[i];
    }
    sum
}
