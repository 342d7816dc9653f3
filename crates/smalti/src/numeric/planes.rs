//! A stack of image planes of equal size.

use std::ops::Range;

use serde::Serialize;
use thiserror::Error;

/// The size of a buffer does not match the shape it should have.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("expected {expected} values for {count} planes of {rows} × {cols}, got {got}")]
pub struct ShapeError {
    /// Planes.
    pub count: usize,
    /// Rows of each plane.
    pub rows: usize,
    /// Columns of each plane.
    pub cols: usize,
    /// Values the shape asks for (saturated where it overflows).
    pub expected: usize,
    /// Values that came.
    pub got: usize,
}

/// `count` planes of `rows` × `cols` values, one plane after another, each in row order.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Planes {
    rows: usize,
    cols: usize,
    count: usize,
    data: Vec<f32>,
}

impl Planes {
    /// Takes a buffer ordered plane, row, column.
    ///
    /// # Errors
    /// When `data.len()` is not `count * rows * cols`.
    pub fn new(rows: usize, cols: usize, count: usize, data: Vec<f32>) -> Result<Self, ShapeError> {
        let expected = rows.checked_mul(cols).and_then(|n| n.checked_mul(count)).unwrap_or(usize::MAX);
        if expected != data.len() {
            return Err(ShapeError { count, rows, cols, expected, got: data.len() });
        }
        Ok(Self { rows, cols, count, data })
    }

    /// All zero.
    #[must_use]
    pub fn zeros(rows: usize, cols: usize, count: usize) -> Self {
        Self { rows, cols, count, data: vec![0.0; rows * cols * count] }
    }

    /// The part of `rows` × `cols` values of every plane from `row` and `col` on.
    ///
    /// # Errors
    /// When it reaches beyond the planes.
    pub fn cropped(&self, row: usize, col: usize, rows: usize, cols: usize) -> Result<Self, ShapeError> {
        let mut data =
            Vec::with_capacity(self.count.saturating_mul(rows).saturating_mul(cols).min(self.data.len()));
        for plane in self.planes() {
            for line in plane.chunks_exact(self.cols.max(1)).skip(row).take(rows) {
                data.extend(line.iter().skip(col).take(cols));
            }
        }
        Self::new(rows, cols, self.count, data)
    }

    /// Rows of each plane.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of each plane.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Number of planes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Values in one plane.
    #[must_use]
    pub fn plane_len(&self) -> usize {
        self.rows * self.cols
    }

    /// One plane, in row order.
    ///
    /// # Errors
    /// When `index` is not below [`Planes::count`]; the error states the values that so many planes would have.
    pub fn plane(&self, index: usize) -> Result<&[f32], ShapeError> {
        Ok(&self.data[self.place(index)?])
    }

    /// One plane to write to, in row order.
    ///
    /// # Errors
    /// As [`Planes::plane`].
    pub fn plane_mut(&mut self, index: usize) -> Result<&mut [f32], ShapeError> {
        let place = self.place(index)?;
        Ok(&mut self.data[place])
    }

    fn place(&self, index: usize) -> Result<Range<usize>, ShapeError> {
        let n = self.plane_len();
        if index < self.count {
            return Ok(index * n..(index + 1) * n);
        }
        let (rows, cols, count) = (self.rows, self.cols, index.saturating_add(1));
        Err(ShapeError { count, rows, cols, expected: count.saturating_mul(n), got: self.data.len() })
    }

    /// The planes in order.
    pub fn planes(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.data.chunks_exact(self.plane_len().max(1))
    }

    /// The planes in order, to write to.
    pub fn planes_mut(&mut self) -> impl ExactSizeIterator<Item = &mut [f32]> {
        let n = self.plane_len().max(1);
        self.data.chunks_exact_mut(n)
    }

    /// All values, ordered plane, row, column.
    #[must_use]
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    /// All values to write to, ordered plane, row, column.
    #[must_use]
    pub fn data_mut(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// The buffer, ordered plane, row, column.
    #[must_use]
    pub fn into_data(self) -> Vec<f32> {
        self.data
    }
}

/// The rows of each band of all planes, for tasks that write some rows of every plane.
pub(crate) fn bands_of<T>(band_rows: usize, data: &mut [T], rows: usize, cols: usize) -> Vec<Vec<&mut [T]>> {
    let mut bands: Vec<Vec<&mut [T]>> = (0..rows.div_ceil(band_rows)).map(|_| Vec::new()).collect();
    for plane in data.chunks_mut((rows * cols).max(1)) {
        for (band, rows) in bands.iter_mut().zip(plane.chunks_mut(band_rows * cols)) {
            band.push(rows);
        }
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_length_is_refused() {
        assert!(Planes::new(2, 3, 2, vec![0.0; 11]).is_err());
        assert!(Planes::new(usize::MAX, 3, 2, vec![0.0; 11]).is_err());
    }

    #[test]
    fn a_part_lies_within_every_plane() {
        let all = Planes::new(3, 4, 2, (0..24).map(|i| i as f32).collect()).unwrap();
        let part = all.cropped(1, 2, 2, 2).unwrap();
        assert_eq!(part.data(), [6.0, 7.0, 10.0, 11.0, 18.0, 19.0, 22.0, 23.0]);
        assert!(all.cropped(2, 0, 2, 4).is_err() && all.cropped(0, 3, 3, 2).is_err());
        assert!(all.cropped(usize::MAX, 0, 1, 1).is_err() && all.cropped(0, 0, usize::MAX, 2).is_err());
    }

    #[test]
    fn planes_lie_one_after_another() {
        let mut p = Planes::new(1, 2, 2, vec![1.0, 2.0, 3.0, 4.0]).unwrap();
        assert_eq!(p.plane(1).unwrap(), &[3.0, 4.0]);
        assert_eq!(p.planes().len(), 2);
        p.planes_mut().for_each(|plane| plane[0] = 0.0);
        assert_eq!(p.data(), [0.0, 2.0, 0.0, 4.0]);
    }

    #[test]
    fn a_plane_beyond_the_last_is_an_error() {
        let mut p = Planes::zeros(1, 2, 2);
        let missing = ShapeError { count: 3, rows: 1, cols: 2, expected: 6, got: 4 };
        assert_eq!(p.plane(2), Err(missing.clone()));
        assert_eq!(p.plane_mut(2), Err(missing));
        assert!(p.plane(usize::MAX).is_err());
    }
}
