//! A stack of image planes of equal size.

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

    /// One plane, in row order. Empty when `index` is not below [`Planes::count`].
    #[must_use]
    pub fn plane(&self, index: usize) -> &[f32] {
        let n = self.plane_len();
        self.data.get(index * n..(index + 1) * n).unwrap_or(&[])
    }

    /// One plane to write to. Empty when `index` is not below [`Planes::count`].
    #[must_use]
    pub fn plane_mut(&mut self, index: usize) -> &mut [f32] {
        let n = self.plane_len();
        self.data.get_mut(index * n..(index + 1) * n).unwrap_or(&mut [])
    }

    /// The planes in order.
    pub fn planes(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.data.chunks_exact(self.plane_len().max(1))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_length_is_refused() {
        assert!(Planes::new(2, 3, 2, vec![0.0; 11]).is_err());
        assert!(Planes::new(usize::MAX, 3, 2, vec![0.0; 11]).is_err());
    }

    #[test]
    fn planes_lie_one_after_another() {
        let p = Planes::new(1, 2, 2, vec![1.0, 2.0, 3.0, 4.0]).unwrap();
        assert_eq!(p.plane(1), &[3.0, 4.0]);
        assert!(p.plane(2).is_empty());
        assert_eq!(p.planes().len(), 2);
    }
}
