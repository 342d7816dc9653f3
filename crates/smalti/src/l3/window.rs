//! Normalised bands of a raw image with their surroundings.

use super::blocks::{BLOCK, LANES};
use crate::isp::source::Source;
use crate::numeric::mirror::about_outermost;

/// The index in `0..len` that replaces `at`. Beyond the ends it is the index nearest to the reflected one
/// that has the same phase in a tile of `period`. For a period of 1 or 2 this is the reflection about the
/// outermost sample.
pub(super) fn mirrored(at: isize, len: usize, period: usize) -> usize {
    if (0..len as isize).contains(&at) {
        return at as usize;
    }
    let mirror = about_outermost(at, len) as isize;
    let period = period as isize;
    // The shifts from the reflected index to the phase of `at`, down and up.
    let down = (mirror - at).rem_euclid(period);
    let candidates = [mirror - down, mirror - down + period];
    let inside = |c: &isize| (0..len as isize).contains(c);
    let nearest = candidates.into_iter().filter(inside).min_by_key(|c| (c - mirror).abs());
    nearest.unwrap_or(mirror) as usize
}

/// Alignment of lines: reading a register that spans two cache lines takes twice as long.
const REGISTER_BYTES: usize = 64;
/// Padding beyond the right margin of a line, for vectors that start within the line.
const SPARE: usize = 3 * BLOCK;

/// Rows of a raw image with a margin on all sides, reflected with the phase of the tile.
#[derive(Debug, Default)]
pub(super) struct Window<S = f32> {
    pub(super) stride: usize,
    pub(super) margin: [usize; 2],
    pub(super) cols: usize,
    /// Row `first − margin` of the image is at the top.
    data: Vec<S>,
    /// Offset of the data that aligns lines to whole registers.
    base: usize,
    /// The highest sample of each row, where samples are normalised; NaN is ignored.
    pub(super) highest: Vec<f32>,
}

impl Window {
    /// Fills the window with `rows` rows from `first`.
    #[inline(always)]
    pub(super) fn read(
        &mut self,
        source: Source<'_>,
        first: usize,
        rows: usize,
        margin: [usize; 2],
        tile: [usize; 2],
    ) {
        let size = [source.rows(), source.cols()];
        self.read_with(size, first, rows, margin, tile, |row, out| source.read_row(row, out));
        self.highest.clear();
        let highest = |line: &[f32]| {
            let mut found = [f32::MIN; LANES];
            for v in line.as_chunks::<LANES>().0 {
                for i in 0..LANES {
                    found[i] = if v[i] > found[i] { v[i] } else { found[i] };
                }
            }
            found.into_iter().fold(f32::MIN, f32::max)
        };
        let len = (rows + 2 * margin[0]) * self.stride;
        for line in self.data[self.base..][..len].chunks_exact(self.stride) {
            self.highest.push(highest(line));
        }
    }
}

impl<S: Copy + Default> Window<S> {
    /// Fills the window with `rows` rows from `first` of an image of a given size; `read(row, out)` supplies
    /// each row.
    #[inline(always)]
    pub(super) fn read_with(
        &mut self,
        size: [usize; 2],
        first: usize,
        rows: usize,
        margin: [usize; 2],
        tile: [usize; 2],
        read: impl Fn(usize, &mut [S]),
    ) {
        let ([image_rows, cols], [above, left]) = (size, margin);
        self.stride = (cols + 2 * left).next_multiple_of(BLOCK) + SPARE;
        self.margin = margin;
        self.cols = cols;
        let len = (rows + 2 * above) * self.stride;
        self.data.resize(len + REGISTER_BYTES, S::default());
        self.base = self.data.as_ptr().align_offset(REGISTER_BYTES).min(REGISTER_BYTES);
        let beyond = (0..left).chain(left + cols..cols + 2 * left);
        let source = |c: usize| (c, left + mirrored(c as isize - left as isize, cols, tile[1]));
        let beyond: Vec<(usize, usize)> = beyond.map(source).collect();
        for (i, line) in self.data[self.base..][..len].chunks_exact_mut(self.stride).enumerate() {
            let row = mirrored(first as isize + i as isize - above as isize, image_rows, tile[0]);
            read(row, &mut line[left..left + cols]);
            beyond.iter().for_each(|&(to, from)| line[to] = line[from]);
            line[cols + 2 * left..].fill(S::default());
        }
    }

    /// All lines, concatenated.
    pub(super) fn lines(&self) -> &[S] {
        self.data.get(self.base..).unwrap_or(&[])
    }

    /// Row `row` of the band (negative: above it), starting at its left margin.
    pub(super) fn line(&self, row: isize) -> &[S] {
        let at = self.base + (row + self.margin[0] as isize) as usize * self.stride;
        self.data.get(at..at + self.stride).unwrap_or(&[])
    }
}

/// A range of columns of a row of a window.
#[derive(Clone, Copy)]
pub(super) struct Strip<'a> {
    pub(super) window: &'a Window,
    pub(super) row: isize,
    /// Phase of the first column.
    pub(super) phase: [usize; 2],
    pub(super) first: usize,
    /// Number of columns, a multiple of the vector length.
    pub(super) len: usize,
}

impl Strip<'_> {
    /// Index in the lines of the window of the column `right` of the first. The margin covers every sample
    /// that is read beside a patch.
    #[inline(always)]
    pub(super) fn at(&self, right: isize) -> usize {
        ((self.window.margin[1] + self.first) as isize + right).max(0) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrored_places_keep_the_phase() {
        for (len, period) in [(7, 1), (7, 2), (8, 2), (9, 3), (10, 4), (13, 5), (5, 5)] {
            for at in -9..(len as isize + 9) {
                let place = mirrored(at, len, period);
                assert!(place < len);
                assert_eq!((place as isize - at).rem_euclid(period as isize), 0, "{at} in {len} by {period}");
                if (0..len as isize).contains(&at) {
                    assert_eq!(place as isize, at);
                }
                if period <= 2 {
                    assert_eq!(place, about_outermost(at, len));
                }
            }
        }
    }
}
