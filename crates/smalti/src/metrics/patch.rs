//! Rectangles of an image and their means.

use super::MetricError;
use crate::numeric::Planes;

/// A rectangle of pixels, counted from 0; it covers `rows` × `cols` pixels from (`row`, `col`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rect {
    /// First row.
    pub row: usize,
    /// First column.
    pub col: usize,
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub cols: usize,
}

impl Rect {
    /// The whole of an image.
    #[must_use]
    pub fn whole(rows: usize, cols: usize) -> Self {
        Self { row: 0, col: 0, rows, cols }
    }

    /// Number of pixels (saturated).
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.saturating_mul(self.cols)
    }

    /// Whether it holds no pixel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows == 0 || self.cols == 0
    }

    /// Checks that it has pixels and lies within an image of `rows` × `cols`.
    ///
    /// # Errors
    /// [`MetricError::Region`] when it does not.
    pub fn within(&self, rows: usize, cols: usize) -> Result<Self, MetricError> {
        let fits = |first: usize, count: usize, all| first.checked_add(count).is_some_and(|end| end <= all);
        if !self.is_empty() && fits(self.row, self.rows, rows) && fits(self.col, self.cols, cols) {
            Ok(*self)
        } else {
            Err(MetricError::Region { rect: *self, rows, cols })
        }
    }

    /// The values of a plane of `plane_cols` columns inside the rectangle, in row order. Rows that are not
    /// there are left out; call [`Rect::within`] first.
    pub(super) fn values<'a>(&self, plane: &'a [f32], plane_cols: usize) -> impl Iterator<Item = f64> + 'a {
        let Self { row, col, rows, cols } = *self;
        plane
            .chunks(plane_cols.max(1))
            .skip(row)
            .take(rows)
            .flat_map(move |line| line.iter().skip(col).take(cols).map(|&v| f64::from(v)))
    }
}

/// The mean of every plane over every rectangle: one inner vector per rectangle, one value per plane.
///
/// # Errors
/// When a rectangle leaves the image or holds no pixel.
pub fn patch_means(planes: &Planes, rects: &[Rect]) -> Result<Vec<Vec<f64>>, MetricError> {
    let mean = |plane: usize, rect: &Rect| {
        rect.values(planes.plane(plane), planes.cols()).sum::<f64>() / rect.len() as f64
    };
    rects
        .iter()
        .map(|rect| {
            rect.within(planes.rows(), planes.cols())?;
            Ok((0..planes.count()).map(|p| mean(p, rect)).collect())
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
