//! Crosstalk between neighbouring samples, a linear operator X on the samples of a patch.
//!
//! A sample is the light of its own pixel and of its neighbours, each behind its own filter: x = X A u. The light is therefore described on
//! patches that are one ring of pixels wider than those of samples. Covariances follow as X (A C Aᵀ) Xᵀ and X R, and derivatives with respect to
//! them return as Xᵀ Q X.

use super::lanes::{Lanes, ZERO, plus_scaled};

/// The operator, for patches of samples and of light.
#[derive(Debug, Clone)]
pub(super) struct Crosstalk {
    /// The pixels of the patch of light that reach each sample, and their shares.
    sources: Vec<Vec<(usize, f64)>>,
    light_taps: usize,
}

impl Crosstalk {
    /// Rings of pixels around a patch that reach its samples.
    pub(super) const BORDER: usize = 1;

    /// The operator of a [kernel](crate::sensor::Sensor::crosstalk_between_samples), for patches of `side` × `side` samples.
    pub(super) fn new(kernel: &[[f64; 3]; 3], side: usize) -> Self {
        let width = side + 2 * Self::BORDER;
        let of_sample = |tap: usize| {
            // The kernel states where the light of a pixel goes.
            let of = |at: usize| (tap / side + 2 - at / 3) * width + tap % side + 2 - at % 3;
            let all = kernel.as_flattened().iter().enumerate();
            all.filter(|(_, share)| **share != 0.0).map(|(at, share)| (of(at), *share)).collect()
        };
        Self { sources: (0..side * side).map(of_sample).collect(), light_taps: width * width }
    }

    /// The samples X v of numbers of the pixels.
    #[inline(always)]
    pub(super) fn samples<const N: usize>(&self, pixels: &[[Lanes; N]], out: &mut [[Lanes; N]]) {
        for (out, sources) in out.iter_mut().zip(&self.sources) {
            *out = [ZERO; N];
            for (from, share) in sources {
                for (sum, value) in out.iter_mut().zip(&pixels[*from]) {
                    *sum = plus_scaled(*sum, *share, *value);
                }
            }
        }
    }

    /// Xᵀ v of numbers of the samples.
    #[inline(always)]
    pub(super) fn pixels<const N: usize>(&self, samples: &[[Lanes; N]], out: &mut [[Lanes; N]]) {
        out.fill([ZERO; N]);
        for (value, sources) in samples.iter().zip(&self.sources) {
            for (to, share) in sources {
                for (sum, value) in out[*to].iter_mut().zip(value) {
                    *sum = plus_scaled(*sum, *share, *value);
                }
            }
        }
    }

    /// Number of the pair of pixels (a, b), in either order.
    #[inline(always)]
    fn pair(&self, a: usize, b: usize) -> usize {
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        low * (2 * self.light_taps - low + 1) / 2 + high - low
    }

    /// X G Xᵀ of a symmetric matrix of the pixels, both by pairs i ≤ j.
    #[inline(always)]
    pub(super) fn sample_pairs(&self, pixels: &[Lanes], out: &mut [Lanes]) {
        let mut pair = 0;
        for (i, left) in self.sources.iter().enumerate() {
            for right in &self.sources[i..] {
                let mut sum = ZERO;
                for (a, by) in left {
                    for (b, share) in right {
                        sum = plus_scaled(sum, by * share, pixels[self.pair(*a, *b)]);
                    }
                }
                out[pair] = sum;
                pair += 1;
            }
        }
    }

    /// Xᵀ Q X of a symmetric matrix of the samples, both by pairs i ≤ j.
    #[inline(always)]
    pub(super) fn pixel_pairs(&self, samples: &[Lanes], out: &mut [Lanes]) {
        out.fill(ZERO);
        let mut pair = 0;
        for (i, left) in self.sources.iter().enumerate() {
            for (j, right) in self.sources.iter().enumerate().skip(i) {
                for (a, by) in left {
                    for (b, share) in right {
                        // Entries (i, j) and (j, i) lead to (a, b) and (b, a), of which the upper one is kept.
                        let times = match (i == j, a == b) {
                            (true, _) if a > b => continue,
                            (false, true) => 2.0,
                            _ => 1.0,
                        };
                        let to = self.pair(*a, *b);
                        out[to] = plus_scaled(out[to], times * by * share, samples[pair]);
                    }
                }
                pair += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::kernel::pairs;
    use super::super::lanes::LANES;
    use super::*;

    const KERNEL: [[f64; 3]; 3] = [[0.01, 0.02, 0.03], [0.04, 0.7, 0.05], [0.06, 0.07, 0.02]];

    /// ⟨Q, X G Xᵀ⟩ = ⟨Xᵀ Q X, G⟩ over all entries of symmetric matrices, and ⟨q, X v⟩ = ⟨Xᵀ q, v⟩.
    #[test]
    fn the_transposed_operator_has_the_same_scalar_products() {
        let crosstalk = Crosstalk::new(&KERNEL, 3);
        let number = |i: usize| [libm::sin(1.3 * i as f64 + 0.2); LANES];
        let (g, q): (Vec<Lanes>, Vec<Lanes>) =
            ((0..pairs(25)).map(number).collect(), (0..pairs(9)).map(|i| number(7 * i + 3)).collect());
        let (mut seen, mut back) = (vec![ZERO; pairs(9)], vec![ZERO; pairs(25)]);
        crosstalk.sample_pairs(&g, &mut seen);
        crosstalk.pixel_pairs(&q, &mut back);
        let product = |a: &[Lanes], b: &[Lanes], taps: usize| {
            let entries = (0..taps).flat_map(|i| (i..taps).map(move |j| if i == j { 1.0 } else { 2.0 }));
            entries.zip(a.iter().zip(b)).map(|(times, (a, b))| times * a[3] * b[3]).sum::<f64>()
        };
        let (one, other) = (product(&q, &seen, 9), product(&back, &g, 25));
        assert!((one - other).abs() < 1e-12, "{one} {other}");
        let (v, w): (Vec<[Lanes; 1]>, Vec<[Lanes; 1]>) =
            ((0..25).map(|i| [number(i)]).collect(), (0..9).map(|i| [number(5 * i + 2)]).collect());
        let (mut seen, mut back) = (vec![[ZERO]; 9], vec![[ZERO]; 25]);
        crosstalk.samples(&v, &mut seen);
        crosstalk.pixels(&w, &mut back);
        let product =
            |a: &[[Lanes; 1]], b: &[[Lanes; 1]]| a.iter().zip(b).map(|(a, b)| a[0][1] * b[0][1]).sum::<f64>();
        assert!((product(&w, &seen) - product(&back, &v)).abs() < 1e-12);
    }
}
