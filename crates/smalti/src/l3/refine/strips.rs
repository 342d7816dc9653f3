//! Strips of rows of a picture that are changed in place, each by one task.

use std::ops::Range;

use rayon::prelude::*;

use super::inputs::OUTPUTS;
use crate::numeric::{Planes, bands_of};

/// Least pixels of a strip, for which what a few rows beyond it need is computed again.
const STRIP_PIXELS: usize = 1 << 19;

/// Changes a picture of X, Y and Z in place. What `change` writes into a row of a strip may depend on `reach` rows around it.
pub(super) fn each_strip(picture: &mut Planes, reach: usize, change: impl Fn(Strip<'_>) + Sync) {
    let size = [picture.rows(), picture.cols()];
    let [rows, cols] = size;
    if rows == 0 || cols == 0 {
        return;
    }
    let strips = (rows * cols / STRIP_PIXELS).clamp(1, 2 * rayon::current_num_threads());
    // Coarse pictures have every second row, so that strips begin at even rows.
    let strip_rows = rows.div_ceil(strips).next_multiple_of(2);
    // Strips are changed in place, so that what they read of their neighbours is copied before.
    let beyond: Vec<[Beyond; 2]> = (0..rows)
        .step_by(strip_rows)
        .map(|first| {
            let end = (first + strip_rows).min(rows);
            [first.saturating_sub(reach)..first, end..(end + reach).min(rows)]
                .map(|rows| Beyond::of(picture, rows))
        })
        .collect();
    let strips = bands_of(strip_rows, picture.data_mut(), rows, cols).into_par_iter().zip(beyond);
    strips.enumerate().for_each(|(i, (band, beyond))| {
        let first = i * strip_rows;
        change(Strip { rows: first..(first + strip_rows).min(rows), size, band, beyond });
    });
}

/// Rows of a picture beyond a strip.
struct Beyond {
    first: usize,
    /// Row by row, X, Y and Z.
    data: Vec<f32>,
}

impl Beyond {
    fn of(picture: &Planes, rows: Range<usize>) -> Self {
        let cols = picture.cols();
        let line = |row: usize| picture.planes().map(move |p| &p[row * cols..(row + 1) * cols]);
        Self { first: rows.start, data: rows.flat_map(line).collect::<Vec<_>>().concat() }
    }
}

/// Some rows of a picture, which are changed in place, and those above and below as they were.
pub(super) struct Strip<'a> {
    pub(super) rows: Range<usize>,
    /// Rows and columns of the picture.
    pub(super) size: [usize; 2],
    /// X, Y and Z of its rows.
    band: Vec<&'a mut [f32]>,
    beyond: [Beyond; 2],
}

impl Strip<'_> {
    /// X, Y and Z of a row of the strip that is not changed yet, or of a row beyond it.
    pub(super) fn line(&self, row: usize) -> [&[f32]; OUTPUTS] {
        let [above, below] = &self.beyond;
        let (beyond, [_, cols]) = (if row < self.rows.start { above } else { below }, self.size);
        std::array::from_fn(|plane| {
            let found = if self.rows.contains(&row) {
                self.band.get(plane).and_then(|p| p.get((row - self.rows.start) * cols..))
            } else {
                beyond.data.get(((row - beyond.first) * OUTPUTS + plane) * cols..)
            };
            found.and_then(|line| line.get(..cols)).unwrap_or(&[])
        })
    }

    /// X, Y and Z of a row of the strip, to be changed.
    pub(super) fn line_mut(&mut self, row: usize) -> Option<[&mut [f32]; OUTPUTS]> {
        let [x, y, z] = self.band.as_mut_slice() else { return None };
        let [_, cols] = self.size;
        let at = row.checked_sub(self.rows.start)? * cols;
        Some([x.get_mut(at..at + cols)?, y.get_mut(at..at + cols)?, z.get_mut(at..at + cols)?])
    }
}
