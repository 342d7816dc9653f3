//! The Bayer layout, independent of the names of its channels.

use super::super::IspError;
use crate::sensor::Mosaic;

/// The positions of the channels of a Bayer mosaic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Bayer {
    /// The channel of every second pixel.
    pub(super) green: usize,
    green_at_origin: bool,
    /// The other channel of even rows, and of odd rows.
    chroma: [usize; 2],
}

impl Bayer {
    /// The layout of a mosaic with a period of 2 × 2 and three channels, one of them on a diagonal; `None` for any other mosaic.
    pub(super) fn of(mosaic: &Mosaic) -> Option<Self> {
        let at = |r, c| mosaic.channel_at(r, c);
        let (rows, cols) = (mosaic.rows(), mosaic.cols());
        let repeats = rows.is_multiple_of(2)
            && cols.is_multiple_of(2)
            && (0..rows).all(|r| (0..cols).all(|c| at(r, c) == at(r % 2, c % 2)));
        if !repeats || mosaic.channels() != 3 {
            return None;
        }
        match [at(0, 0), at(0, 1), at(1, 0), at(1, 1)] {
            [g, a, b, h] if g == h => Some(Self { green: g, green_at_origin: true, chroma: [a, b] }),
            [a, g, h, b] if g == h => Some(Self { green: g, green_at_origin: false, chroma: [a, b] }),
            _ => None,
        }
    }

    /// [`Bayer::of`] for a method that is defined for Bayer mosaics only.
    pub(super) fn required(mosaic: &Mosaic, method: &'static str) -> Result<Self, IspError> {
        let (rows, cols, channels) = (mosaic.rows(), mosaic.cols(), mosaic.channels());
        Self::of(mosaic).ok_or(IspError::UnsupportedCfa { rows, cols, channels, method })
    }

    pub(super) fn is_green(&self, row: usize, col: usize) -> bool {
        (row + col).is_multiple_of(2) == self.green_at_origin
    }

    /// The channel that shares a row with green.
    pub(super) fn chroma_of_row(&self, row: usize) -> usize {
        self.chroma[row % 2]
    }
}
