//! What pipelines learn from.

use crate::numeric::Planes;
use crate::sensor::RawImage;

/// A raw image and its target.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// The samples for training: noise-free where the noise is added analytically ([`Statistics::new`](super::Statistics::new)),
    /// otherwise as captured.
    pub raw: &'a RawImage,
    /// The image that classifies patches, of the same size: noisy, like the images to render later. `None`
    /// stands for `raw`.
    pub seen: Option<&'a RawImage>,
    /// One plane per output, of the size of the raw image, with finite values.
    pub target: &'a Planes,
}

/// The tiles of the mosaic whose patches are learned from. Neighbouring patches overlap and teach nearly the same, so that an image
/// which is learned from at several exposures needs only half of them at each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tiles {
    /// All.
    All,
    /// One half, as the squares of one colour of a chessboard: those whose numbers of row and column have an even sum.
    Even,
    /// The other half.
    Odd,
}

impl Tiles {
    /// The step between those among the tiles of a row, and the number of tiles from that in a column on before the first of them.
    pub(super) fn step_and_skipped(self, row: usize, col: usize) -> (usize, usize) {
        match self {
            Self::All => (1, 0),
            Self::Even => (2, (row + col) % 2),
            Self::Odd => (2, (row + col + 1) % 2),
        }
    }
}

/// What a pair gives to learn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// The tiles that suffice.
    pub tiles: Tiles,
    /// How many times the pair counts.
    pub times: u32,
}

impl Share {
    /// All tiles, once.
    pub const WHOLE: Self = Self { tiles: Tiles::All, times: 1 };
}
