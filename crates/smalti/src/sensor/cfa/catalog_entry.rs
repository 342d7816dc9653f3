//! An entry of the catalogue, and how its tile is made.

use super::random::blue_noise;
use super::{CfaError, Modulation, Mosaic, WeightedMosaic};

/// How the tile of an entry is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Layout {
    /// One letter per cell.
    Letters(&'static [&'static str]),
    /// Mixtures of primaries on one carrier.
    Weighted { rows: usize, cols: usize, carrier: [f64; 2], primaries: &'static [Modulation] },
    /// Made from parameters.
    Random,
}

/// One entry of the catalogue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CfaInfo {
    /// Its name.
    pub name: &'static str,
    /// Aliases.
    pub aliases: &'static [&'static str],
    /// A short description.
    pub summary: &'static str,
    /// The publication of the pattern. If the pattern could not be checked against it, the text states this.
    pub source: &'static str,
    /// The default filter of each letter (of each primary, where cells are mixtures), by its name among the
    /// [`builtin_filters`](super::builtin_filters). These filters are generic; the publications use their
    /// own.
    pub filters: &'static [(char, &'static str)],
    pub(super) layout: Layout,
}

impl CfaInfo {
    /// The pattern, one string per row. Where cells are mixtures of primaries, each distinct mixture has a
    /// letter, starting with `a`. The random mosaic is shown with its default parameters.
    ///
    /// # Errors
    /// Never for the entries of the catalogue, as a test of all of them shows.
    pub fn pattern(&self) -> Result<Vec<String>, CfaError> {
        match self.layout {
            Layout::Letters(lines) => Ok(lines.iter().map(|&l| l.into()).collect()),
            Layout::Weighted { rows, cols, carrier, primaries } => {
                let (mosaic, _) = WeightedMosaic::modulated(rows, cols, carrier, primaries)?.distinct()?;
                mosaic.to_letters(&('a'..='z').collect::<Vec<_>>())
            }
            Layout::Random => RandomTile::default().pattern(),
        }
    }

    /// The pattern of an entry whose letters are single filters. `None` where cells are mixtures of filters
    /// or the tile depends on parameters.
    #[must_use]
    pub fn fixed_pattern(&self) -> Option<&'static [&'static str]> {
        match self.layout {
            Layout::Letters(lines) => Some(lines),
            Layout::Weighted { .. } | Layout::Random => None,
        }
    }

    /// Rows of the tile.
    #[must_use]
    pub fn rows(&self) -> usize {
        match self.layout {
            Layout::Letters(lines) => lines.len(),
            Layout::Weighted { rows, .. } => rows,
            Layout::Random => RandomTile::default().rows,
        }
    }

    /// Columns of the tile.
    #[must_use]
    pub fn cols(&self) -> usize {
        match self.layout {
            Layout::Letters(lines) => lines.first().map_or(0, |l| l.chars().count()),
            Layout::Weighted { cols, .. } => cols,
            Layout::Random => RandomTile::default().cols,
        }
    }
}

/// The parameters of the random mosaic.
pub(super) struct RandomTile {
    pub(super) channels: usize,
    pub(super) rows: usize,
    pub(super) cols: usize,
    pub(super) seed: u64,
}

impl Default for RandomTile {
    fn default() -> Self {
        Self { channels: 3, rows: 8, cols: 8, seed: 1 }
    }
}

impl RandomTile {
    /// The tile, with channels numbered in order of appearance, as in patterns of letters.
    fn mosaic(&self) -> Result<Mosaic, CfaError> {
        blue_noise(self.channels, self.rows, self.cols, self.seed)
    }

    /// Red, green, blue and white for up to four channels, otherwise adjacent bands.
    pub(super) fn filters(&self) -> Vec<(char, String)> {
        let common = [('R', "red"), ('G', "green"), ('B', "blue"), ('W', "white")];
        match self.channels {
            n @ 3..=4 => common.iter().take(n).map(|&(l, f)| (l, f.to_owned())).collect(),
            n => {
                ('A'..='Z').take(n).enumerate().map(|(k, l)| (l, format!("band-{}-of-{n}", k + 1))).collect()
            }
        }
    }

    pub(super) fn pattern(&self) -> Result<Vec<String>, CfaError> {
        let letters: Vec<char> = self.filters().into_iter().map(|(l, _)| l).collect();
        self.mosaic()?.to_letters(&letters)
    }
}
