//! Means of the patches of an image.

use super::MetricError;
use crate::numeric::{Planes, Rect};

/// Checks that a rectangle has pixels and lies within an image of `rows` × `cols`.
///
/// # Errors
/// [`MetricError::Region`] when it does not.
pub(super) fn check_region(rect: Rect, rows: usize, cols: usize) -> Result<(), MetricError> {
    if rect.fits(rows, cols) { Ok(()) } else { Err(MetricError::Region { rect, rows, cols }) }
}

/// Checks that one of `count` planes exists.
pub(super) fn check_plane(count: usize, index: usize) -> Result<(), MetricError> {
    if index < count { Ok(()) } else { Err(MetricError::Plane { index, count }) }
}

/// The mean of every plane over every rectangle: one inner vector per rectangle, one value per plane.
///
/// # Errors
/// When a rectangle extends beyond the image or is empty.
pub fn patch_means(planes: &Planes, rects: &[Rect]) -> Result<Vec<Vec<f64>>, MetricError> {
    let mean =
        |plane: &[f32], rect: &Rect| rect.values(plane, planes.cols()).sum::<f64>() / rect.len() as f64;
    rects
        .iter()
        .map(|rect| {
            check_region(*rect, planes.rows(), planes.cols())?;
            Ok(planes.planes().map(|p| mean(p, rect)).collect())
        })
        .collect()
}

/// Mean and sample variance (divisor n − 1) in two passes; the variance of fewer than two values is 0.
pub(super) fn mean_and_variance<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> (f64, f64) {
    let n = values().count() as f64;
    let mean = values().sum::<f64>() / n;
    let squares: f64 = values().map(|v| (v - mean) * (v - mean)).sum();
    (mean, if n > 1.0 { squares / (n - 1.0) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_of_a_patch() {
        let p = Planes::new(2, 3, 2, (0..12).map(|v| v as f32).collect()).unwrap();
        let r = Rect { row: 1, col: 1, rows: 1, cols: 2 };
        assert_eq!(patch_means(&p, &[r, Rect::whole(2, 3)]).unwrap(), [[4.5, 10.5], [2.5, 8.5]]);
    }

    #[test]
    fn a_rectangle_outside_is_refused() {
        let p = Planes::zeros(4, 4, 1);
        for (row, col, rows, cols) in [(0, 0, 0, 1), (3, 0, 2, 1), (0, 1, 1, 4), (usize::MAX, 0, 2, 1)] {
            let r = Rect { row, col, rows, cols };
            assert!(matches!(patch_means(&p, &[r]), Err(MetricError::Region { .. })), "{r:?}");
        }
    }
}
