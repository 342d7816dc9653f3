//! Rectangles of an image.

/// A rectangle of pixels, indexed from 0: `rows` × `cols` pixels with the upper left one at (`row`, `col`).
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
    /// The rectangle that covers a whole image.
    #[must_use]
    pub fn whole(rows: usize, cols: usize) -> Self {
        Self { row: 0, col: 0, rows, cols }
    }

    /// Number of pixels (saturated).
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.saturating_mul(self.cols)
    }

    /// Whether it contains no pixel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows == 0 || self.cols == 0
    }

    /// Whether it is not empty and lies within an image of `rows` × `cols`.
    #[must_use]
    pub fn fits(&self, rows: usize, cols: usize) -> bool {
        let fits = |first: usize, count: usize, all| first.checked_add(count).is_some_and(|end| end <= all);
        !self.is_empty() && fits(self.row, self.rows, rows) && fits(self.col, self.cols, cols)
    }

    /// The values of a plane of `plane_cols` columns inside the rectangle, in row order. Rows beyond the
    /// plane are skipped; check [`Rect::fits`] first.
    pub(crate) fn values<'a>(&self, plane: &'a [f32], plane_cols: usize) -> impl Iterator<Item = f64> + 'a {
        let Self { row, col, rows, cols } = *self;
        plane
            .chunks(plane_cols.max(1))
            .skip(row)
            .take(rows)
            .flat_map(move |line| line.iter().skip(col).take(cols).map(|&v| f64::from(v)))
    }
}
