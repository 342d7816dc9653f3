//! Sums of products z zᵀ of vectors with themselves, for moments.

/// Doubles in a register. The length of z with its padding is a multiple of it.
pub(crate) const LANES: usize = 8;

/// Adds Σ z zᵀ over a batch of vectors of `stride` numbers, one after the other. Only the upper triangle of `sums`, a square
/// matrix with rows of `stride` numbers, is valid afterwards. Call it within a [`Kernel`](super::simd::Kernel).
#[inline(always)]
pub(crate) fn add_products(batch: &[f64], stride: usize, sums: &mut [f64]) {
    if cfg!(target_arch = "wasm32") { tiles(batch, stride, sums) } else { blocks(batch, stride, sums) }
}

/// Rows and columns of a tile, whose sums stay in eight registers of two doubles, half of those that a browser has.
const TILE: usize = 4;

/// [`add_products`] for short registers.
#[inline(always)]
fn tiles(batch: &[f64], stride: usize, sums: &mut [f64]) {
    for row in (0..stride).step_by(TILE) {
        for col in (row..stride).step_by(TILE) {
            let mut acc = [[0.0; TILE]; TILE];
            for z in batch.chunks_exact(stride) {
                let (Some(left), Some(right)) = (z[row..].first_chunk(), z[col..].first_chunk::<TILE>())
                else {
                    return;
                };
                let left: &[f64; TILE] = left;
                acc[0] = plus_product(acc[0], left[0], *right);
                acc[1] = plus_product(acc[1], left[1], *right);
                acc[2] = plus_product(acc[2], left[2], *right);
                acc[3] = plus_product(acc[3], left[3], *right);
            }
            for (r, more) in acc.iter().enumerate() {
                let first = (row + r) * stride + col;
                sums[first..first + TILE].iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            }
        }
    }
}

/// [`add_products`] for long registers.
#[inline(always)]
fn blocks(batch: &[f64], stride: usize, sums: &mut [f64]) {
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
fn plus_product<const N: usize>(mut sum: [f64; N], factor: f64, values: [f64; N]) -> [f64; N] {
    for i in 0..N {
        sum[i] += factor * values[i];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    /// Tiles and blocks sum in the same order: products have the same bits on every machine. They are those of the definition.
    #[test]
    fn tiles_and_blocks_have_the_same_bits() {
        for stride in [16, 24, 32, 56, 72] {
            let mut random = Stream::new(stride as u64, 1, 2);
            let batch: Vec<f64> = (0..stride * 29).map(|_| random.uniform() - 0.3).collect();
            let [mut tiled, mut blocked] = [(); 2].map(|()| vec![0.25; stride * stride]);
            tiles(&batch, stride, &mut tiled);
            blocks(&batch, stride, &mut blocked);
            for row in 0..stride {
                for col in row..stride {
                    let (a, b) = (tiled[row * stride + col], blocked[row * stride + col]);
                    let sum = batch.chunks_exact(stride).fold(0.0, |sum, z| sum + z[row] * z[col]);
                    assert!(a.to_bits() == b.to_bits() && a == 0.25 + sum, "{stride}: {row}, {col}");
                }
            }
        }
    }
}
