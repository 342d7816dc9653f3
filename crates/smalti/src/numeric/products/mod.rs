//! Sums of products z zᵀ of vectors with themselves, for moments.

#[cfg(target_arch = "x86_64")]
mod x86;

/// The length of z with its padding is a multiple of it: the doubles of the longest register.
pub(crate) const LANES: usize = 8;

/// Adds Σ z zᵀ over a batch of vectors of `stride` numbers, one after the other. Only the upper triangle of `sums`, a square
/// matrix with rows of `stride` numbers, is valid afterwards.
///
/// The numbers have to be those of single precision. Their products are exact in double precision, so that processors which multiply
/// and add in one step give the same bits as those which need two.
pub(crate) fn add_products(batch: &[f64], stride: usize, sums: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    if x86::add_products(batch, stride, sums) {
        return;
    }
    tiles(batch, stride, sums);
}

/// Rows and columns of a tile, whose sums stay in eight registers of two doubles, half of those that a browser has.
const TILE: usize = 4;

/// [`add_products`] for short registers.
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
                // Written out, since compilers turn a loop into gathers, or store every sum in every step.
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

#[inline(always)]
fn plus_product(mut sum: [f64; TILE], factor: f64, values: [f64; TILE]) -> [f64; TILE] {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum =
            if cfg!(target_arch = "aarch64") { factor.mul_add(value, *sum) } else { *sum + factor * value };
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;
    use crate::numeric::simd::{Set, with_widest};

    /// Products have the same bits with every instruction set. They are those of the definition.
    #[test]
    fn every_instruction_set_sums_to_the_same_bits() {
        for stride in [16, 24, 32, 56, 72] {
            let mut random = Stream::new(stride as u64, 1, 2);
            let batch: Vec<f64> = (0..stride * 5).map(|_| f64::from(random.uniform() as f32 - 0.3)).collect();
            for set in [Set::Plain, Set::Avx2, Set::Avx512] {
                let mut sums = vec![0.25; stride * stride];
                with_widest(set, || add_products(&batch, stride, &mut sums));
                for row in 0..stride {
                    for col in row..stride {
                        let sum = batch.chunks_exact(stride).fold(0.0, |sum, z| sum + z[row] * z[col]);
                        assert!(sums[row * stride + col] == 0.25 + sum, "{set:?}, {stride}: {row}, {col}");
                    }
                }
            }
        }
    }
}
