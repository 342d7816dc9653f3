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
    /// Whether the tile in a row and a column of tiles is one of them.
    pub(super) fn contains(self, row: usize, col: usize) -> bool {
        match self {
            Self::All => true,
            Self::Even => (row + col).is_multiple_of(2),
            Self::Odd => !(row + col).is_multiple_of(2),
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
