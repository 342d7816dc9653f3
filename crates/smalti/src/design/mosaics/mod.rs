//! Families of mosaics. A family counts its mosaics of N colours and lists all of them or a random sample.

mod group;
mod interchange;
mod published;
mod request;
mod surjection;
mod tile;

use serde::{Deserialize, Serialize};

pub use group::Symmetry;
pub(super) use interchange::distinct;
pub use published::published;
pub(crate) use published::published_filters;
pub(super) use request::MosaicRequest;
use request::{THIS_TILE, sampled};
pub use tile::Tile;

use super::error::{DesignError, colors_checked};
use crate::sensor::Mosaic;

/// Maximum number of mosaics in a list.
const MAX_LISTED: u64 = 10_000_000;
/// Maximum number of cells of all mosaics in a list. With a few bytes per cell, a list stays below a gigabyte.
const MAX_LISTED_CELLS: u64 = 100_000_000;

/// `mosaics` of a study: `"catalogue"`, `{ given = [["bc", "ab"]] }` or a table `[mosaics.tile]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum MosaicFamily {
    /// Listed tiles, one string per row. The letters a, b, c, … are the filters in ascending wavelength, so that the number of
    /// letters is the number of colours. Tiles are used as written.
    Given(Vec<Vec<String>>),
    /// Every placement of the colours in a tile.
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

    /// A random sample of `count` different mosaics of `colors` colours, or all mosaics when `count` is `None`. All samples are
    /// equally likely. A mosaic of a tile is represented by its lexicographically smallest tile, reduced to its period.
    ///
    /// # Errors
    /// As [`MosaicFamily::count`], but a sample may be drawn from more than 2¹²⁸ − 1 mosaics. Also when more mosaics are
    /// requested than exist, or more than ten million, or mosaics of more than a hundred million cells in total.
    pub fn pick(&self, colors: usize, count: Option<u64>, seed: u64) -> Result<Vec<Mosaic>, DesignError> {
        self.list(colors, self.request(colors, count)?, seed)
    }

    /// [`MosaicFamily::pick`] for a request that has been checked.
    pub(super) fn list(
        &self,
        colors: usize,
        request: MosaicRequest,
        seed: u64,
    ) -> Result<Vec<Mosaic>, DesignError> {
        let all = match self {
            Self::Given(tiles) => given(tiles, colors)?,
            Self::Tile(tile) => return tile.pick(colors, request, seed),
            Self::Catalogue => published(colors)?.into_iter().map(|(_, mosaic)| mosaic).collect(),
        };
        sampled(all, request.count, colors, seed)
    }

    /// The mosaics of [`MosaicFamily::pick`], without those of a tile that equal another after an exchange of filters: for filters that
    /// are still to be found.
    ///
    /// # Errors
    /// As [`MosaicFamily::pick`].
    pub fn pick_layouts(
        &self,
        colors: usize,
        count: Option<u64>,
        seed: u64,
    ) -> Result<Vec<Mosaic>, DesignError> {
        let all = self.pick(colors, count, seed)?;
        Ok(if let Self::Tile(tile) = self { distinct(all, tile.symmetry) } else { all })
    }

    /// Checks a request for mosaics without listing them.
    ///
    /// # Errors
    /// As [`MosaicFamily::pick`].
    pub(super) fn request(&self, colors: usize, count: Option<u64>) -> Result<MosaicRequest, DesignError> {
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
            Ok(count) if count <= limit => Ok(MosaicRequest { count, available, limit }),
            _ => Err(DesignError::TooMany { what, colors, wanted, limit }),
        }
    }
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
