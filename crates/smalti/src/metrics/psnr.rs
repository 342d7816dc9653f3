//! Mean squared error and peak signal-to-noise ratio against a reference.

use super::error::{at_least, finite};
use super::patch::check_region;
use super::{MetricError, Rect};
use crate::numeric::Planes;

/// Mean squared error and PSNR of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Psnr {
    /// Mean squared difference per plane.
    pub mse: Vec<f64>,
    /// `10 · log10(peak² / mse)` per plane, decibels; infinite for equal planes.
    pub psnr_db: Vec<f64>,
    /// Mean squared difference over all planes.
    pub cmse: f64,
    /// The peak signal-to-noise ratio over all planes (CPSNR), decibels.
    pub cpsnr_db: f64,
}

/// Compares an image with a reference within a region, which should exclude the border where demosaicking extrapolates. `peak` is
/// the largest value of the scale, such as 1 or 255.
///
/// # Errors
/// When the sizes differ, the region extends beyond the image, `peak` is not above 0, or a value is not finite.
pub fn psnr(image: &Planes, reference: &Planes, region: Rect, peak: f64) -> Result<Psnr, MetricError> {
    same_size(image, reference)?;
    check_region(region, image.rows(), image.cols())?;
    if !(peak > 0.0 && peak.is_finite()) {
        let (name, expected) = ("peak", "a finite number above 0");
        return Err(MetricError::Parameter { name, value: peak, expected });
    }
    let pairs: Vec<_> = image.planes().zip(reference.planes()).collect();
    let sums = match *pairs.as_slice() {
        [x, y, z] => squared_differences([x, y, z], image.cols(), region).to_vec(),
        _ => pairs.iter().flat_map(|pair| squared_differences([*pair], image.cols(), region)).collect(),
    };
    let mse: Vec<f64> = sums.iter().map(|sum| sum / region.len() as f64).collect();
    finite("the mean squared error of the planes", mse.iter().copied())?;
    let decibels = |mse: f64| 10.0 * (peak * peak / mse).log10();
    let cmse = mse.iter().sum::<f64>() / mse.len() as f64;
    Ok(Psnr { psnr_db: mse.iter().map(|&v| decibels(v)).collect(), cpsnr_db: decibels(cmse), mse, cmse })
}

/// The sums of the squared differences of pairs of planes within a region, in the order of pixels. An addition waits for the one before it
/// in the same sum, while those of the other pairs proceed.
fn squared_differences<const N: usize>(pairs: [(&[f32], &[f32]); N], cols: usize, region: Rect) -> [f64; N] {
    let mut sums = [0.0; N];
    for row in region.row..region.row + region.rows {
        let within = row * cols + region.col..row * cols + region.col + region.cols;
        let lines = pairs.map(|(a, b)| (&a[within.clone()], &b[within.clone()]));
        for i in 0..region.cols {
            for (sum, (a, b)) in sums.iter_mut().zip(&lines) {
                let difference = f64::from(a[i]) - f64::from(b[i]);
                *sum += difference * difference;
            }
        }
    }
    sums
}

/// Checks that two images have the same rows, columns and planes, at least one of each.
pub(super) fn same_size(left: &Planes, right: &Planes) -> Result<(), MetricError> {
    let size = |p: &Planes| (p.rows(), p.cols(), p.count());
    if size(left) != size(right) {
        return Err(MetricError::Size { left: size(left), right: size(right) });
    }
    at_least("values in the image", 1, left.data().len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_errors() {
        let a = Planes::new(2, 2, 2, vec![0.5; 8]).unwrap();
        let b = Planes::new(2, 2, 2, [[0.5; 4], [0.75; 4]].concat()).unwrap();
        let r = psnr(&a, &b, Rect::whole(2, 2), 1.0).unwrap();
        assert_eq!(r.mse, [0.0, 0.0625]);
        assert_eq!(r.psnr_db[0], f64::INFINITY);
        assert!((r.psnr_db[1] - 12.041_199_826_559_248).abs() < 1e-12);
        assert!((r.cpsnr_db - 15.051_499_783_199_06).abs() < 1e-12);
        let scaled = |p: &Planes| Planes::new(2, 2, 2, p.data().iter().map(|v| v * 255.0).collect()).unwrap();
        let s = psnr(&scaled(&a), &scaled(&b), Rect::whole(2, 2), 255.0).unwrap();
        assert!((s.cpsnr_db - r.cpsnr_db).abs() < 1e-9);
    }

    /// The planes of a picture have the errors that each has alone, within a region as well.
    #[test]
    fn planes_do_not_change_each_other() {
        let planes = |count: usize, seed: usize| {
            let values = (0..count * 5 * 7).map(|i| ((i * i + seed * i) % 53) as f32 / 53.0).collect();
            Planes::new(5, 7, count, values).unwrap()
        };
        let region = Rect { row: 1, col: 2, rows: 3, cols: 4 };
        for count in [1, 2, 3, 4] {
            let (a, b) = (planes(count, 3), planes(count, 8));
            let together = psnr(&a, &b, region, 1.0).unwrap();
            for (i, (x, y)) in a.planes().zip(b.planes()).enumerate() {
                let one = |plane: &[f32]| Planes::new(5, 7, 1, plane.to_vec()).unwrap();
                let differences =
                    region.values(x, 7).zip(region.values(y, 7)).map(|(x, y)| (x - y) * (x - y));
                assert_eq!(together.mse[i], differences.sum::<f64>() / 12.0);
                assert_eq!(psnr(&one(x), &one(y), region, 1.0).unwrap().mse, [together.mse[i]]);
            }
        }
    }

    #[test]
    fn what_cannot_be_compared_is_refused() {
        let (a, b) = (Planes::zeros(2, 2, 1), Planes::zeros(2, 2, 3));
        assert!(matches!(psnr(&a, &b, Rect::whole(2, 2), 1.0), Err(MetricError::Size { .. })));
        assert!(matches!(psnr(&a, &a, Rect::whole(2, 3), 1.0), Err(MetricError::Region { .. })));
        assert!(matches!(psnr(&a, &a, Rect::whole(2, 2), 0.0), Err(MetricError::Parameter { .. })));
        let none = Planes::zeros(2, 2, 0);
        assert!(matches!(psnr(&none, &none, Rect::whole(2, 2), 1.0), Err(MetricError::TooFew { .. })));
        let nan = Planes::new(1, 1, 1, vec![f32::NAN]).unwrap();
        assert!(matches!(psnr(&nan, &nan, Rect::whole(1, 1), 1.0), Err(MetricError::NotFinite { .. })));
    }
}
