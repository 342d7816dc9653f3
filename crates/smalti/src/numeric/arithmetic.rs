//! What tells machines apart whose results differ in their last bits.

use std::hint::black_box;

use super::fft::RealFft2;
use super::philox::Stream;

/// Sizes of the planes that are transformed: powers of two, and sides with the factors 3 and 5.
const SIZES: [(usize, usize); 3] = [(64, 64), (48, 90), (25, 54)];
/// Arguments of every function.
const ARGUMENTS: usize = 256;

/// A hash, 16 hexadecimal digits, of what this machine computes where machines may differ in the last bit: Fourier transforms, for which
/// processors with fused multiply-adds use those, and the functions of the system's maths library. All other arithmetic gives the same
/// bits everywhere. Machines with equal hashes give equal results.
#[must_use]
pub fn arithmetic() -> String {
    let mut hash = Hash::default();
    for (rows, cols) in SIZES {
        let Ok(transform) = RealFft2::new(rows, cols) else { continue };
        let mut random = Stream::new(1, 0, (rows * cols) as u32);
        let plane: Vec<f32> = (0..rows * cols).map(|_| random.uniform() as f32).collect();
        let spectrum = transform.forward(&plane).unwrap_or_default();
        spectrum.iter().for_each(|v| hash.put([v.re, v.im].map(|v| u64::from(v.to_bits()))));
        let back = transform.inverse(&spectrum).unwrap_or_default();
        hash.put(back.iter().map(|v| u64::from(v.to_bits())));
    }
    let mut random = Stream::new(1, 1, 0);
    for _ in 0..ARGUMENTS {
        // The compiler must not compute them itself.
        let (x, y) = black_box((20.0 * random.uniform() + 1e-3, 4.0 * random.uniform() - 2.0));
        hash.put([x.ln(), x.log10(), x.log2(), x.cbrt(), x.powf(y), y.exp(), y.exp2()].map(f64::to_bits));
        hash.put([x.sin(), x.cos(), x.tan(), x.atan(), x.atan2(y), x.hypot(y), y.tanh()].map(f64::to_bits));
        let (x, y) = (x as f32, y as f32);
        hash.put([x.ln(), x.powf(y), y.exp(), x.sin(), x.cos()].map(|v| u64::from(v.to_bits())));
    }
    format!("{:016x}", hash.0)
}

/// FNV-1a over words.
struct Hash(u64);

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    fn put(&mut self, words: impl IntoIterator<Item = u64>) {
        for byte in words.into_iter().flat_map(u64::to_le_bytes) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// A hash of values whose bits every machine must reproduce.
#[cfg(test)]
pub(crate) fn digest(words: impl IntoIterator<Item = u64>) -> u64 {
    let mut hash = Hash::default();
    hash.put(words);
    hash.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_machine_has_one_hash() {
        let first = arithmetic();
        assert!(first.len() == 16 && first.bytes().all(|b| b.is_ascii_hexdigit()), "{first}");
        let other = std::thread::spawn(arithmetic).join().unwrap();
        assert_eq!(first, other);
    }

    /// The lengths of the planes reveal whether transforms use fused multiply-adds.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn a_transform_with_fused_multiply_adds_has_other_bits() {
        use rustfft::FftPlannerScalar;
        use rustfft::num_complex::Complex32;

        let fused = std::arch::is_x86_feature_detected!("avx") && std::arch::is_x86_feature_detected!("fma");
        for len in SIZES.iter().flat_map(|&(rows, cols)| [rows, cols]) {
            let mut random = Stream::new(2, 0, len as u32);
            let line: Vec<Complex32> =
                (0..len).map(|_| Complex32::new(random.uniform() as f32, random.uniform() as f32)).collect();
            let (mut plain, mut chosen) = (line.clone(), line);
            FftPlannerScalar::new().plan_fft_forward(len).process(&mut plain);
            rustfft::FftPlanner::new().plan_fft_forward(len).process(&mut chosen);
            assert_eq!(plain != chosen, fused, "length {len}");
            // Both are right.
            let most = plain.iter().zip(&chosen).map(|(a, b)| (a - b).norm()).fold(0.0, f32::max);
            assert!(most < 1e-5 * len as f32, "{most}");
        }
    }
}
