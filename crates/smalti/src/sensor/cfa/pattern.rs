//! Mosaics as patterns of letters, and properties of a tile: its period, its phase, whether it is a Bayer
//! arrangement.

use super::{Cfa, CfaError, Channel, Mosaic};
use crate::spectrum::Spectrum;

/// The positions of the three channels in a 2 × 2 tile with one channel on a diagonal. This is the Bayer
/// arrangement of any colours; RYYB and RCCB have it as well.
///
/// The geometry does not determine which of the other two channels is red; that depends on the filters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BayerPhase {
    /// The channel of the diagonal, green in a Bayer mosaic.
    pub diagonal: usize,
    /// The other channel of the even rows (0, 2, …).
    pub even_rows: usize,
    /// The other channel of the odd rows.
    pub odd_rows: usize,
    /// Column (0 or 1) of the diagonal channel in the even rows; in the odd rows it is in the other column.
    pub diagonal_col: usize,
}

impl Mosaic {
    /// A tile from one letter per cell and one string per row, and the letter of each channel. Channels are
    /// numbered by first appearance of their letters, row by row.
    ///
    /// # Errors
    /// When the rows differ in length, there is no cell, or there are more than 256 different letters.
    pub fn from_letters<S: AsRef<str>>(lines: &[S]) -> Result<(Self, Vec<char>), CfaError> {
        let mut letters: Vec<char> = Vec::new();
        let mut cells = Vec::new();
        let cols = lines.first().map_or(0, |l| l.as_ref().chars().count());
        let total = lines.iter().map(|l| l.as_ref().chars().count()).sum();
        let tile = CfaError::Tile { rows: lines.len(), cols, cells: total };
        if lines.iter().any(|l| l.as_ref().chars().count() != cols) || total > 65536 {
            return Err(tile);
        }
        for letter in lines.iter().flat_map(|l| l.as_ref().chars()) {
            let channel = letters.iter().position(|&l| l == letter).unwrap_or_else(|| {
                letters.push(letter);
                letters.len() - 1
            });
            cells.push(u8::try_from(channel).map_err(|_| tile.clone())?);
        }
        Ok((Self::new(lines.len(), cols, cells)?, letters))
    }

    /// The tile as text, one letter per cell and one string per row.
    ///
    /// # Errors
    /// [`CfaError::CellChannel`] when there are fewer letters than channels.
    pub fn to_letters(&self, letters: &[char]) -> Result<Vec<String>, CfaError> {
        let letter = |row: usize, col: usize| {
            let (channel, channels) = (self.channel_at(row, col), letters.len());
            letters.get(channel).ok_or(CfaError::CellChannel { row, col, channel, channels })
        };
        (0..self.rows()).map(|row| (0..self.cols()).map(|col| letter(row, col)).collect()).collect()
    }

    /// The smallest tile that gives the same mosaic.
    #[must_use]
    pub fn reduced(&self) -> Self {
        let (rows, cols) = (self.rows(), self.cols());
        let repeats = |dr: usize, dc: usize| {
            (0..rows).all(|r| (0..cols).all(|c| self.channel_at(r, c) == self.channel_at(r + dr, c + dc)))
        };
        let divisors = |n: usize| (1..=n).filter(move |d| n.is_multiple_of(*d));
        let rows = divisors(rows).find(|&d| repeats(d, 0)).unwrap_or(rows);
        let cols = divisors(cols).find(|&d| repeats(0, d)).unwrap_or(cols);
        let cells = (0..rows * cols).map(|i| self.channel_at(i / cols, i % cols) as u8).collect();
        // Every channel of the tile occurs in its period, so the parts are valid.
        Self::new(rows, cols, cells).unwrap_or_else(|_| self.clone())
    }

    /// A unique tile for all mosaics that differ only by a shift: the reduced tile at the shift whose cells
    /// come first in lexicographic row order. Two mosaics are equal up to the choice of origin when their
    /// canonical tiles are equal.
    #[must_use]
    pub fn canonical(&self) -> Self {
        let tile = self.reduced();
        let (rows, cols) = (tile.rows(), tile.cols());
        // Rank the rows read cyclically from each cell, then all rows read from each cell. Doubling the
        // compared length takes log₂ n steps, whereas comparing every pair of shifts takes n².
        let mut rank: Vec<u32> = tile.cells().iter().map(|&c| u32::from(c)).collect();
        let doubled = |rank: &[u32], dr: usize, dc: usize| {
            let pair = |i: usize| (rank[i], rank[(i / cols + dr) % rows * cols + (i % cols + dc) % cols]);
            let mut order: Vec<_> = (0..rank.len()).map(pair).collect();
            order.sort_unstable();
            order.dedup();
            (0..rank.len()).map(|i| order.binary_search(&pair(i)).unwrap_or(0) as u32).collect::<Vec<_>>()
        };
        for step in std::iter::successors(Some(1), |s| Some(s * 2)).take_while(|&s| s < cols) {
            rank = doubled(&rank, 0, step);
        }
        for step in std::iter::successors(Some(1), |s| Some(s * 2)).take_while(|&s| s < rows) {
            rank = doubled(&rank, step, 0);
        }
        let first = (0..rank.len()).min_by_key(|&i| rank[i]).unwrap_or(0);
        tile.shifted(first / cols, first % cols)
    }

    /// The phase of a Bayer arrangement (three channels, one on a diagonal); `None` for other mosaics.
    #[must_use]
    pub fn bayer_phase(&self) -> Option<BayerPhase> {
        let tile = self.reduced();
        let &[a, b, c, d] = tile.cells() else { return None };
        if tile.rows() != 2 || tile.channels() != 3 {
            return None;
        }
        let [a, b, c, d] = [a, b, c, d].map(usize::from);
        if a == d {
            Some(BayerPhase { diagonal: a, even_rows: b, odd_rows: c, diagonal_col: 0 })
        } else if b == c {
            Some(BayerPhase { diagonal: b, even_rows: a, odd_rows: d, diagonal_col: 1 })
        } else {
            None
        }
    }
}

impl Cfa {
    /// A colour filter array from a pattern of letters and a filter (transmittance, 0 to 1) for each letter.
    /// Filters that do not occur in the pattern are ignored.
    ///
    /// # Errors
    /// When the pattern is not a rectangle, a letter has no filter, or as for [`Cfa::new`].
    pub fn from_pattern<S: AsRef<str>>(
        name: impl Into<String>,
        lines: &[S],
        filters: &[(char, Spectrum)],
    ) -> Result<Self, CfaError> {
        let (mosaic, letters) = Mosaic::from_letters(lines)?;
        let channel = |(index, &letter): (usize, &char)| match filters.iter().find(|(l, _)| *l == letter) {
            Some((_, filter)) => Ok(Channel { name: letter.into(), transmittance: filter.clone() }),
            None => {
                let at = mosaic.cells().iter().position(|&c| usize::from(c) == index).unwrap_or(0);
                let known: Vec<String> = filters.iter().map(|(l, _)| l.to_string()).collect();
                Err(CfaError::UnknownLetter {
                    letter,
                    row: at / mosaic.cols(),
                    col: at % mosaic.cols(),
                    known: if known.is_empty() { "none".into() } else { known.join(", ") },
                })
            }
        };
        let channels = letters.iter().enumerate().map(channel).collect::<Result<_, _>>()?;
        Self::new(name, mosaic, channels)
    }

    /// The pattern in letters, one string per row; `None` when a channel name is not a single letter.
    #[must_use]
    pub fn letters(&self) -> Option<Vec<String>> {
        let single = |name: &str| {
            let mut chars = name.chars();
            chars.next().filter(|_| chars.next().is_none())
        };
        let letters: Option<Vec<char>> = self.channels().iter().map(|c| single(&c.name)).collect();
        self.mosaic().to_letters(&letters?).ok()
    }
}
