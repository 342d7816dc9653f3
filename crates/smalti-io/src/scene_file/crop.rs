//! The part of an image that is read.

use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use crate::IoError;

/// A rectangle of an image, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crop {
    /// First row, from 0.
    pub row: usize,
    /// First column, from 0.
    pub col: usize,
    /// Rows, at least one.
    pub rows: usize,
    /// Columns, at least one.
    pub cols: usize,
}

impl FromStr for Crop {
    type Err = String;

    /// From `ROW,COL,ROWS,COLS`.
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[row, col, rows, cols]) if rows > 0 && cols > 0 => Ok(Self { row, col, rows, cols }),
            _ => Err("expected ROW,COL,ROWS,COLS: first row and column from 0, then how many of each".into()),
        }
    }
}

impl Crop {
    /// The whole of an image.
    #[must_use]
    pub fn whole(rows: usize, cols: usize) -> Self {
        Self { row: 0, col: 0, rows, cols }
    }

    /// # Errors
    /// When it reaches beyond the image.
    pub(crate) fn within(self, rows: usize, cols: usize, path: &Path) -> Result<Self, IoError> {
        let inside = |first: usize, count: usize, len: usize| {
            count > 0 && first.checked_add(count).is_some_and(|end| end <= len)
        };
        if inside(self.row, self.rows, rows) && inside(self.col, self.cols, cols) {
            return Ok(self);
        }
        let Self { row, col, rows: high, cols: wide } = self;
        let found = format!("{high} rows from {row} and {wide} columns from {col}");
        let expected = format!("a part of {rows} rows and {cols} columns");
        Err(IoError::field(path, "the part to read", found, expected))
    }

    /// Its rows and columns.
    pub(crate) fn ranges(self) -> (Range<usize>, Range<usize>) {
        (self.row..self.row + self.rows, self.col..self.col + self.cols)
    }

    /// The horizontal field of view of the part, taken as if it were in the middle: tan(φ′/2) = tan(φ/2) · cols′/cols.
    pub(super) fn field_of_view_deg(self, whole_deg: f64, whole_cols: usize) -> f64 {
        if self.cols == whole_cols {
            return whole_deg;
        }
        let half = (whole_deg.to_radians() / 2.0).tan() * self.cols as f64 / whole_cols.max(1) as f64;
        2.0 * half.atan().to_degrees()
    }
}
