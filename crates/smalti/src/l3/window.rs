//! Bands of a raw image with what lies around them, normalised.

use crate::isp::source::Source;
use crate::numeric::mirror::about_outermost;

/// Lanes that classification works on; windows reach so far beyond their last column that whole vectors can be read.
pub(super) const LANES: usize = 16;

/// The place in `0..len` that stands in for `at`: itself; beyond the ends the one of the same phase in a tile of `period` that
/// is nearest to the mirrored place. For a period of 1 or 2 that is the mirror about the outermost sample.
pub(super) fn mirrored(at: isize, len: usize, period: usize) -> usize {
    if (0..len as isize).contains(&at) {
        return at as usize;
    }
    let mirror = about_outermost(at, len) as isize;
    let period = period as isize;
    // The shifts of the mirrored place to the phase of `at`, down and up.
    let down = (mirror - at).rem_euclid(period);
    let candidates = [mirror - down, mirror - down + period];
    let inside = |c: &isize| (0..len as isize).contains(c);
    let nearest = candidates.into_iter().filter(inside).min_by_key(|c| (c - mirror).abs());
    nearest.unwrap_or(mirror) as usize
}

/// What lies beyond the right margin of a line: vectors that start within the line may reach so far.
const SPARE: usize = 3 * LANES;

/// Rows of a raw image with a margin on all sides, mirrored by the phase of the tile.
#[derive(Debug, Default)]
pub(super) struct Window<S = f32> {
    pub(super) stride: usize,
    pub(super) margin: [usize; 2],
    pub(super) cols: usize,
    /// Row `first − margin` of the image is at the top.
    pub(super) data: Vec<S>,
}

impl Window {
    /// Fills the window with `rows` rows from `first` on.
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
    }
}

impl<S: Copy + Default> Window<S> {
    /// Fills the window with `rows` rows from `first` on of an image of a size, each as `read(row, out)` gives it.
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
        self.stride = (cols + 2 * left).next_multiple_of(LANES) + SPARE;
        self.margin = margin;
        self.cols = cols;
        self.data.resize((rows + 2 * above) * self.stride, S::default());
        for (i, line) in self.data.chunks_exact_mut(self.stride).enumerate() {
            let row = mirrored(first as isize + i as isize - above as isize, image_rows, tile[0]);
            read(row, &mut line[left..left + cols]);
            for c in (0..left).chain(left + cols..cols + 2 * left) {
                line[c] = line[left + mirrored(c as isize - left as isize, cols, tile[1])];
            }
            line[cols + 2 * left..].fill(S::default());
        }
    }

    /// Row `row` of the band (negative: above it), from its left margin on.
    pub(super) fn line(&self, row: isize) -> &[S] {
        let at = (row + self.margin[0] as isize) as usize * self.stride;
        self.data.get(at..at + self.stride).unwrap_or(&[])
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
