//! Families of mosaics: how many mosaics of N colours each has, all of them, or a random sample.

mod group;
mod published;
mod surjection;
mod tile;

use serde::{Deserialize, Serialize};

pub use group::Symmetry;
pub use published::published;
pub use tile::Tile;

use super::error::{DesignError, colors_checked};
use super::permutation::Permutation;
use crate::sensor::Mosaic;

/// Separates these random numbers from other uses of the same seed.
const PURPOSE: u32 = 0x4453_4E02;

/// Most mosaics that are listed at once.
const MAX_LISTED: u64 = 10_000_000;
/// Most cells of all mosaics that are listed at once: some bytes each, so that a list stays below a gigabyte.
const MAX_LISTED_CELLS: u64 = 100_000_000;

const THIS_TILE: &str = "this tile";

/// How many mosaics are wanted, of how many, and how many are listed at most.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    pub(super) count: u64,
    available: u128,
    pub(super) limit: u64,
}

/// `mosaics` of a study: `"catalogue"`, `{ given = [["bc", "ab"]] }` or a table `[mosaics.tile]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum MosaicFamily {
    /// Tiles written out, one text per row: the letters a, b, c, … are the filters, ascending in wavelength, so that the
    /// number of letters is the number of colours. Taken as they are written.
    Given(Vec<Vec<String>>),
    /// Every placement in a tile.
    Tile(Tile),
    /// The published mosaics: [`published`].
    Catalogue,
}

impl MosaicFamily {
    /// The number of different mosaics of `colors` colours.
    ///
    /// # Errors
    /// When `colors` is not 1 to 26, a key has an impossible value, or there are more than 2¹²⁸ − 1.
    pub fn count(&self, colors: usize) -> Result<u128, DesignError> {
        match self {
            Self::Given(tiles) => Ok(given(tiles, colors)?.len() as u128),
            Self::Tile(tile) => tile.count(colors),
            Self::Catalogue => Ok(published(colors)?.len() as u128),
        }
    }

    /// `count` different mosaics of `colors` colours, each selection of them equally likely; all, when `count` is
    /// `None`. The seed decides which; of a tile each mosaic is shown by the first of its tiles in the order of the
    /// cells, reduced to its period.
    ///
    /// # Errors
    /// As [`MosaicFamily::count`], though a sample may be drawn from more than 2¹²⁸ − 1; when more are asked for than
    /// there are, or more than ten million, or than have a hundred million cells.
    pub fn pick(&self, colors: usize, count: Option<u64>, seed: u64) -> Result<Vec<Mosaic>, DesignError> {
        self.list(colors, self.wanted(colors, count)?, seed)
    }

    /// As [`MosaicFamily::pick`], of mosaics that are counted already.
    pub(super) fn list(&self, colors: usize, wanted: Wanted, seed: u64) -> Result<Vec<Mosaic>, DesignError> {
        let all = match self {
            Self::Given(tiles) => given(tiles, colors)?,
            Self::Tile(tile) => return tile.pick(colors, wanted, seed),
            Self::Catalogue => published(colors)?.into_iter().map(|(_, mosaic)| mosaic).collect(),
        };
        chosen(all, wanted.count, colors, seed)
    }

    /// How many mosaics [`MosaicFamily::pick`] returns, without a list of them.
    ///
    /// # Errors
    /// As [`MosaicFamily::pick`].
    pub(super) fn wanted(&self, colors: usize, count: Option<u64>) -> Result<Wanted, DesignError> {
        let (what, available, cells) = match self {
            Self::Given(tiles) => ("the list of given mosaics", given(tiles, colors)?.len() as u128, 1),
            Self::Tile(tile) => (THIS_TILE, tile.available(colors, count)?, tile.rows * tile.cols),
            Self::Catalogue => ("the catalogue", published(colors)?.len() as u128, 1),
        };
        if let Some(wanted) = count.filter(|&n| u128::from(n) > available) {
            return Err(DesignError::TooFew { what, colors, wanted, available });
        }
        let wanted = count.map_or(available, u128::from);
        let limit = MAX_LISTED.min(MAX_LISTED_CELLS / cells.max(1) as u64);
        match u64::try_from(wanted) {
            Ok(count) if count <= limit => Ok(Wanted { count, available, limit }),
            _ => Err(DesignError::TooMany { what, colors, wanted, limit }),
        }
    }
}

/// All mosaics in their order, or a random choice of them.
fn chosen(all: Vec<Mosaic>, wanted: u64, colors: usize, seed: u64) -> Result<Vec<Mosaic>, DesignError> {
    if wanted == all.len() as u64 {
        return Ok(all);
    }
    let order = Permutation::new(all.len() as u128, seed, PURPOSE, colors as u32);
    let places = (0..u128::from(wanted)).filter_map(|i| order.at(i));
    Ok(places.filter_map(|i| all.get(i as usize).cloned()).collect())
}

/// The given tiles with `colors` letters.
fn given(tiles: &[Vec<String>], colors: usize) -> Result<Vec<Mosaic>, DesignError> {
    colors_checked(colors)?;
    let mut found = Vec::new();
    for (i, lines) in tiles.iter().enumerate() {
        let wrong = |message: String| DesignError::key(format!("given[{i}]"), message);
        let (mosaic, letters) = Mosaic::from_letters(lines).map_err(|e| wrong(e.to_string()))?;
        if let Some(letter) = letters.iter().find(|l| !l.is_ascii_lowercase()) {
            return Err(wrong(format!("'{letter}' is no channel; expected the letters a to z")));
        }
        let mut sorted = letters.clone();
        sorted.sort_unstable();
        if let Some((letter, _)) = ('a'..='z').zip(&sorted).find(|(expected, got)| expected != *got) {
            return Err(wrong(format!(
                "the filter '{letter}' is in no cell; {} letters are a to the last of them",
                letters.len()
            )));
        }
        if letters.len() == colors {
            let cell = |&c: &u8| letters[usize::from(c)] as u8 - b'a';
            found.push(Mosaic::new(mosaic.rows(), mosaic.cols(), mosaic.cells().iter().map(cell).collect())?);
        }
    }
    Ok(found)
}
