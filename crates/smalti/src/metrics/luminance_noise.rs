//! Luminance noise on grey patches.

use super::error::{at_least, finite};
use super::patch::{check_plane, check_region, mean_and_variance};
use super::{MetricError, Rect};
use crate::numeric::Planes;

/// Noise of each patch and their mean.
#[derive(Debug, Clone, PartialEq)]
pub struct LuminanceNoise {
    /// `100 · std(Y) / mean(Y)` per patch, in percent; the standard deviation has the divisor n − 1.
    pub percent: Vec<f64>,
    /// Their mean.
    pub mean_percent: f64,
}

/// Luminance noise of uniform patches of a luminance plane (Y of XYZ in any scale), as in ISETCam for the grey series of the
/// Macbeth chart.
///
/// # Errors
/// When the plane or a patch does not exist, there is no patch, a patch has fewer than two pixels, a value is not
/// finite, or the mean of a patch is not above 0.
pub fn luminance_noise(
    planes: &Planes,
    plane: usize,
    patches: &[Rect],
) -> Result<LuminanceNoise, MetricError> {
    let mut of_one = luminance_noise_of_captures(&[planes], plane, patches)?;
    of_one.pop().ok_or(MetricError::TooFew { what: "captures", minimum: 1, got: 0 })
}

/// Luminance noise of several captures of the same patches, each relative to the mean of the patch over all captures. In the dark, noise
/// moves that mean less than the mean of a single capture, which may be 0.
///
/// # Errors
/// As [`luminance_noise`], for the mean over all captures.
pub fn luminance_noise_of_captures(
    captures: &[&Planes],
    plane: usize,
    patches: &[Rect],
) -> Result<Vec<LuminanceNoise>, MetricError> {
    let of_captures = captures.iter().map(|planes| means_and_deviations(planes, plane, patches));
    let of_captures = of_captures.collect::<Result<Vec<_>, _>>()?;
    let mean = |patch: usize| {
        let means = of_captures.iter().map(|of_patches| of_patches[patch].0);
        above_0(means.sum::<f64>() / of_captures.len() as f64)
    };
    let means = (0..patches.len()).map(mean).collect::<Result<Vec<_>, _>>()?;
    let noise = |of_patches: &Vec<(f64, f64)>| {
        let percent: Vec<f64> =
            of_patches.iter().zip(&means).map(|((_, std), mean)| 100.0 * std / mean).collect();
        let mean_percent = percent.iter().sum::<f64>() / percent.len() as f64;
        LuminanceNoise { percent, mean_percent }
    };
    Ok(of_captures.iter().map(noise).collect())
}

/// Mean (above 0) and standard deviation of every patch.
pub(super) fn plane_statistics(
    planes: &Planes,
    plane: usize,
    patches: &[Rect],
) -> Result<Vec<(f64, f64)>, MetricError> {
    let statistics = means_and_deviations(planes, plane, patches)?;
    statistics.into_iter().map(|(mean, std)| Ok((above_0(mean)?, std))).collect()
}

/// The mean of a patch, which must be above 0.
fn above_0(mean: f64) -> Result<f64, MetricError> {
    let (quantity, reason) = ("noise relative to the mean", "the mean is not above 0");
    if mean > 0.0 { Ok(mean) } else { Err(MetricError::Undefined { quantity, reason }) }
}

/// Mean and standard deviation of every patch.
fn means_and_deviations(
    planes: &Planes,
    plane: usize,
    patches: &[Rect],
) -> Result<Vec<(f64, f64)>, MetricError> {
    check_plane(planes.count(), plane)?;
    at_least("patches", 1, patches.len())?;
    let data = planes.plane(plane)?;
    let statistics = |rect: &Rect| {
        check_region(*rect, planes.rows(), planes.cols())?;
        at_least("pixels in a patch", 2, rect.len())?;
        let values = || rect.values(data, planes.cols());
        finite("a patch", values())?;
        let (mean, variance) = mean_and_variance(values);
        Ok((mean, variance.sqrt()))
    };
    patches.iter().map(statistics).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A capture whose mean is below 0 is measured relative to the mean of all.
    #[test]
    fn captures_share_their_mean() {
        let of = |a: f32, b: f32| Planes::new(1, 2, 1, vec![a, b]).unwrap();
        let (dark, light) = (of(-2.0, 0.0), of(2.0, 4.0));
        let all = [Rect { row: 0, col: 0, rows: 1, cols: 2 }];
        let noise = luminance_noise_of_captures(&[&dark, &light], 0, &all).unwrap();
        assert!(noise.iter().all(|n| (n.mean_percent - 100.0 * 2f64.sqrt()).abs() < 1e-9), "{noise:?}");
        assert!(matches!(luminance_noise(&dark, 0, &all), Err(MetricError::Undefined { .. })));
        assert_eq!(
            luminance_noise_of_captures(&[&light], 0, &all).unwrap(),
            [luminance_noise(&light, 0, &all).unwrap()]
        );
    }

    #[test]
    fn noise_of_known_patches() {
        // Left patch 9, 11 alternating: mean 10, std sqrt(8 / 7); right patch constant.
        let data = (0..32).map(|i| if i % 8 < 4 { 9.0 + 2.0 * (i % 2) as f32 } else { 5.0 }).collect();
        let p = Planes::new(4, 8, 1, data).unwrap();
        let left = Rect { row: 0, col: 0, rows: 2, cols: 4 };
        let right = Rect { row: 0, col: 4, rows: 4, cols: 4 };
        let n = luminance_noise(&p, 0, &[left, right]).unwrap();
        let expected = 10.0 * (8.0f64 / 7.0).sqrt();
        assert!((n.percent[0] - expected).abs() < 1e-12 && n.percent[1] == 0.0);
        assert!((n.mean_percent - expected / 2.0).abs() < 1e-12);
    }

    #[test]
    fn undefined_noise_is_refused() {
        let p = Planes::zeros(4, 4, 1);
        let all = Rect::whole(4, 4);
        assert!(matches!(luminance_noise(&p, 0, &[all]), Err(MetricError::Undefined { .. })));
        assert!(matches!(luminance_noise(&p, 0, &[]), Err(MetricError::TooFew { .. })));
        assert!(matches!(luminance_noise(&p, 1, &[all]), Err(MetricError::Plane { .. })));
        let mut hole = Planes::zeros(4, 4, 1);
        hole.data_mut()[3] = f32::INFINITY;
        assert!(matches!(luminance_noise(&hole, 0, &[all]), Err(MetricError::NotFinite { .. })));
    }
}
