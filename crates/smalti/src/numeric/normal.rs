//! Normal deviates by the Box–Muller transform ([box1958]): two deviates from two random words, without
//! rejection. Each pixel therefore needs a fixed number of random words, which suits vector code.
//!
//! The radius comes from a 32-bit uniform number, so deviates are limited to ±6.7 standard deviations. A
//! larger deviate has a probability of 2e-11.
//!
//! [box1958]: https://doi.org/10.1214/aoms/1177706645

use super::elementary::{ln_f32, sin_cos_turn};

/// Two independent deviates of mean 0 and variance 1.
#[inline(always)]
#[must_use]
pub fn normal_pair(radius: u32, angle: u32) -> (f32, f32) {
    // The offset of one half excludes 0. Rounding may give 1, where the radius is 0.
    let u = (radius as f32 + 0.5) * (1.0 / 4_294_967_296.0);
    let r = (-2.0 * ln_f32(u)).max(0.0).sqrt();
    let (s, c) = sin_cos_turn(angle);
    (r * c, r * s)
}

#[cfg(test)]
mod tests {
    use super::super::philox::philox4x32;
    use super::*;

    #[test]
    fn moments_and_tails_are_those_of_the_normal() {
        const N: u32 = 1_000_000;
        let (mut m, mut beyond) = ([0.0f64; 5], [0.0f64; 3]);
        for i in 0..N / 2 {
            let w = philox4x32([i, 0, 0, 0], [1, 2]);
            let (a, b) = normal_pair(w[0], w[1]);
            m[0] += f64::from(a) * f64::from(b);
            for x in [f64::from(a), f64::from(b)] {
                (1..5).for_each(|k| m[k] += x.powi(k as i32));
                [1.0, 3.0, 4.0].iter().zip(&mut beyond).for_each(|(t, n)| *n += f64::from(x > *t));
            }
        }
        let n = f64::from(N);
        // Four standard errors: the variance of x^k is (2k−1)!! minus the squared mean.
        for (k, (expected, variance)) in
            [(0.0, 0.5), (0.0, 1.0), (1.0, 2.0), (0.0, 15.0), (3.0, 96.0)].iter().enumerate()
        {
            assert!((m[k] / n - expected).abs() < 4.0 * (variance / n).sqrt(), "moment {k}: {}", m[k] / n);
        }
        for (count, p) in beyond.iter().zip([0.158_655_25, 1.349_898e-3, 3.167_124e-5]) {
            assert!((count - n * p).abs() < 4.0 * (n * p).sqrt(), "{count} beyond, expected {}", n * p);
        }
    }

    #[test]
    fn extreme_words_stay_finite() {
        for (a, b) in [(0, 0), (u32::MAX, 0), (0, u32::MAX), (u32::MAX, u32::MAX)] {
            let (x, y) = normal_pair(a, b);
            assert!(x.hypot(y) < 6.8);
        }
    }
}
