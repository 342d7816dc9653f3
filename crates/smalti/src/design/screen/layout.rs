//! Which filter every pixel of a patch has.

use crate::sensor::Mosaic;

/// The filter of every pixel of a patch, for each position of its middle pixel in the tile.
pub(super) struct Layout {
    side: usize,
    taps: usize,
    light_taps: usize,
    filters: usize,
    /// By position and pixel of the patch of light.
    filter: Vec<u8>,
    /// The position of a pixel that is displaced by −(side − 1) to side − 1 rows and columns.
    displaced: Vec<usize>,
}

impl Layout {
    /// For patches of `side` × `side` samples and of light on `border` more rings of pixels.
    pub(super) fn new(side: usize, border: usize, mosaic: &Mosaic) -> Self {
        let width = side + 2 * border;
        let half = width / 2;
        let mut filter = Vec::new();
        for row in 0..mosaic.rows() {
            for col in 0..mosaic.cols() {
                for r in 0..width {
                    for c in 0..width {
                        let down = (row + r + half * (mosaic.rows() - 1)) % mosaic.rows();
                        let right = (col + c + half * (mosaic.cols() - 1)) % mosaic.cols();
                        filter.push(mosaic.channel_at(down, right) as u8);
                    }
                }
            }
        }
        let (rows, cols, reach) = (mosaic.rows(), mosaic.cols(), side - 1);
        let wrapped = |at: usize, by: usize, period: usize| (at + by + reach * (period - 1)) % period;
        let to = |at: usize| {
            let (position, by) = (at / (2 * side - 1).pow(2), at % (2 * side - 1).pow(2));
            let row = wrapped(position / cols, by / (2 * side - 1), rows);
            row * cols + wrapped(position % cols, by % (2 * side - 1), cols)
        };
        let displaced = (0..rows * cols * (2 * side - 1).pow(2)).map(to).collect();
        let (taps, light_taps, filters) = (side * side, width * width, mosaic.channels());
        Self { side, taps, light_taps, filters, filter, displaced }
    }

    /// Number of positions in the tile.
    pub(super) fn positions(&self) -> usize {
        self.filter.len() / self.light_taps
    }

    pub(super) fn filters(&self) -> usize {
        self.filters
    }

    /// Number of samples of a patch.
    #[inline(always)]
    pub(super) fn taps(&self) -> usize {
        self.taps
    }

    /// The position of the pixel `down` − (side − 1) rows below and `right` − (side − 1) columns right of one at a position.
    #[inline(always)]
    pub(super) fn displaced(&self, position: usize, down: usize, right: usize) -> usize {
        let width = 2 * self.side - 1;
        self.displaced[(position * width + down) * width + right]
    }

    /// The filter of each pixel of a patch of light.
    #[inline(always)]
    pub(super) fn at(&self, position: usize) -> &[u8] {
        &self.filter[position * self.light_taps..(position + 1) * self.light_taps]
    }
}
