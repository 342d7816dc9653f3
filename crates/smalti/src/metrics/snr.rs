//! Signal-to-noise ratio of uniform patches.

use super::luminance_noise::plane_statistics;
use super::{MetricError, Rect};
use crate::numeric::Planes;

/// A ratio of amplitudes in decibels: `20 · log10`; infinite where the noise is 0.
#[must_use]
pub fn decibels(signal: f64, noise: f64) -> f64 {
    20.0 * (signal / noise).log10()
}

/// `20 · log10(mean / std)` of every patch of a plane of linear values, in decibels (ISO 15739); infinite where all
/// values of a patch are equal.
///
/// # Errors
/// As [`luminance_noise`](super::luminance_noise::luminance_noise).
pub fn patch_snr_db(planes: &Planes, plane: usize, patches: &[Rect]) -> Result<Vec<f64>, MetricError> {
    let statistics = plane_statistics(planes, plane, patches)?;
    Ok(statistics.into_iter().map(|(mean, std)| decibels(mean, std)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_of_noise_is_20_db() {
        // Two values 9, 11 repeated: std → 1 with many samples.
        let p = Planes::new(100, 100, 1, (0..10_000).map(|i| 9.0 + 2.0 * (i % 2) as f32).collect()).unwrap();
        let snr = patch_snr_db(&p, 0, &[Rect::whole(100, 100)]).unwrap();
        assert!((snr[0] - 20.0).abs() < 1e-3);
        let flat = Planes::new(2, 2, 1, vec![1.0; 4]).unwrap();
        assert_eq!(patch_snr_db(&flat, 0, &[Rect::whole(2, 2)]).unwrap(), [f64::INFINITY]);
    }
}
