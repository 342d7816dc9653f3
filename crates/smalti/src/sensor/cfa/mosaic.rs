//! The mosaic tile, its channels and the colour filter array that joins them.

use serde::Serialize;
use thiserror::Error;

use crate::names::did_you_mean;
use crate::numeric::OutOfRange;
use crate::spectrum::{Extrapolation, Spectrum, SpectrumError, WavelengthGrid};

/// An error of a colour filter array.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CfaError {
    /// The tile has no cells, more than 65536, or lines of different length.
    #[error("a mosaic tile is a rectangle of 1 to 65536 cells; got {rows} × {cols} with {cells} cells")]
    Tile {
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
        /// Actual number of cells.
        cells: usize,
    },
    /// A cell names a channel that does not exist.
    #[error("cell ({row}, {col}) names channel {channel}, but there are {channels} (counted from 0)")]
    CellChannel {
        /// Row of the cell.
        row: usize,
        /// Column of the cell.
        col: usize,
        /// The channel.
        channel: usize,
        /// Number of channels.
        channels: usize,
    },
    /// A channel appears in no cell.
    #[error("channel {channel} (counted from 0) appears in no cell of the mosaic")]
    UnusedChannel {
        /// Its index.
        channel: usize,
    },
    /// A pattern uses a letter without a filter.
    #[error(
        "the pattern uses '{letter}' at row {row}, column {col} (counted from 0), but no filter has that name (filters: {known}); add one or change the pattern"
    )]
    UnknownLetter {
        /// The letter.
        letter: char,
        /// Row of the pattern.
        row: usize,
        /// Column of the pattern.
        col: usize,
        /// The known filters.
        known: String,
    },
    /// No built-in has that name.
    #[error("no built-in {what} is called '{name}'{}", did_you_mean(suggestion.as_deref()))]
    UnknownName {
        /// The kind of item (CFA, filter).
        what: &'static str,
        /// The name.
        name: String,
        /// The closest known name.
        suggestion: Option<String>,
    },
    /// A filter names a file that has not been read.
    #[error("the filter file '{name}' has not been read")]
    UnreadFile {
        /// The file.
        name: String,
    },
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] OutOfRange),
    /// A parameter written as text cannot be read.
    #[error("{name} is '{value}'; expected {expected}")]
    ParameterText {
        /// Its name.
        name: String,
        /// The text.
        value: String,
        /// What can be read.
        expected: &'static str,
    },
    /// Spectral data do not fit.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}

/// A tile of channel indices, repeated over the sensor from its top left corner. Every channel below
/// [`Mosaic::channels`] appears in at least one cell.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Mosaic {
    rows: usize,
    cols: usize,
    cells: Vec<u8>,
    channels: usize,
}

impl Mosaic {
    /// A tile from its cells in row order.
    ///
    /// # Errors
    /// When the number of cells is not `rows * cols` or is 0 or above 65536, or a channel below the largest
    /// one is in no cell.
    pub fn new(rows: usize, cols: usize, cells: Vec<u8>) -> Result<Self, CfaError> {
        let count = rows.saturating_mul(cols);
        if count == 0 || count > 65536 || cells.len() != count {
            return Err(CfaError::Tile { rows, cols, cells: cells.len() });
        }
        let channels = cells.iter().copied().max().map_or(0, |m| usize::from(m) + 1);
        match (0..channels).find(|&c| !cells.iter().any(|&x| usize::from(x) == c)) {
            Some(channel) => Err(CfaError::UnusedChannel { channel }),
            None => Ok(Self { rows, cols, cells, channels }),
        }
    }

    /// Rows of the tile.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of the tile.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The cells of the tile in row order.
    #[must_use]
    pub fn cells(&self) -> &[u8] {
        &self.cells
    }

    /// The channel of a pixel anywhere on the sensor.
    #[must_use]
    pub fn channel_at(&self, row: usize, col: usize) -> usize {
        usize::from(self.cells[(row % self.rows) * self.cols + col % self.cols])
    }

    /// The mosaic as seen after cropping `rows` from the top and `cols` from the left.
    #[must_use]
    pub fn shifted(&self, rows: usize, cols: usize) -> Self {
        let cell = |i: usize| {
            self.channel_at(i / self.cols + rows % self.rows, i % self.cols + cols % self.cols) as u8
        };
        Self { cells: (0..self.cells.len()).map(cell).collect(), ..self.clone() }
    }

    /// The mosaic of blocks of `side` × `side` cells from the top left, one cell per block; `None` when a block
    /// has several channels or the side is 0.
    #[must_use]
    pub fn binned(&self, side: usize) -> Option<Self> {
        if side == 0 {
            return None;
        }
        // The fewest blocks that cover whole tiles.
        let blocks = |cells: usize| (1..cells).find(|n| (n * side).is_multiple_of(cells)).unwrap_or(cells);
        let (rows, cols) = (blocks(self.rows), blocks(self.cols));
        let mut cells = Vec::with_capacity(rows * cols);
        for block in 0..rows * cols {
            let (row, col) = (block / cols * side, block % cols * side);
            let channel = self.channel_at(row, col);
            // A block that is larger than the tile has the channels of the whole tile.
            let (high, wide) = (side.min(self.rows), side.min(self.cols));
            let is_uniform =
                (0..high * wide).all(|i| self.channel_at(row + i / wide, col + i % wide) == channel);
            if !is_uniform {
                return None;
            }
            cells.push(channel as u8);
        }
        Some(Self { rows, cols, cells, channels: self.channels })
    }

    /// The largest side, up to `most`, of the blocks of one channel that the tile consists of, from its top
    /// left; `None` when it has no such blocks of more than one cell.
    #[must_use]
    pub fn block_side(&self, most: usize) -> Option<usize> {
        let divides = |side: &usize| self.rows.is_multiple_of(*side) && self.cols.is_multiple_of(*side);
        (2..=most.min(self.rows)).rev().filter(divides).find(|&side| self.binned(side).is_some())
    }

    /// The mosaic with a block of `side` × `side` cells in place of each cell: the reverse of
    /// [`Mosaic::binned`]. Its tile may have more cells than [`Mosaic::new`] allows.
    pub(crate) fn with_blocks(&self, side: usize) -> Self {
        let (rows, cols) = (self.rows * side, self.cols * side);
        let cell = |i: usize| self.cells[i / cols / side * self.cols + i % cols / side];
        Self { rows, cols, cells: (0..rows * cols).map(cell).collect(), channels: self.channels }
    }
}

/// One channel of a colour filter array.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Channel {
    /// Its name, a letter where the pattern is written in letters.
    pub name: String,
    /// Transmittance of its filter, 0 to 1.
    pub transmittance: Spectrum,
}

/// A mosaic and the filter of each of its channels. Cells that are weighted mixtures of primaries
/// (Hirakawa-Wolfe, Condat) are channels of their own, their transmittance the mixture.
#[derive(Debug, Clone, PartialEq)]
pub struct Cfa {
    name: String,
    mosaic: Mosaic,
    channels: Vec<Channel>,
}

impl Cfa {
    /// The same array with its filters sampled on another wavelength grid.
    ///
    /// # Errors
    /// When a filter does not reach as far as the grid; the message names it.
    pub fn on_grid(&self, grid: WavelengthGrid) -> Result<Self, CfaError> {
        let channel = |c: &Channel| {
            let resampled = c.transmittance.resampled(grid, Extrapolation::Error);
            Ok(Channel { name: c.name.clone(), transmittance: resampled.map_err(|e| e.of(&c.name))? })
        };
        let channels = self.channels.iter().map(channel).collect::<Result<_, SpectrumError>>()?;
        Self::new(self.name.clone(), self.mosaic.clone(), channels)
    }

    /// A colour filter array from its parts.
    ///
    /// # Errors
    /// When a cell names a channel that is not there, a channel is in no cell, the grids of the channels
    /// differ, or a transmittance is outside 0–1.
    pub fn new(name: impl Into<String>, mosaic: Mosaic, channels: Vec<Channel>) -> Result<Self, CfaError> {
        if mosaic.channels() > channels.len() {
            let at = mosaic.cells().iter().position(|&c| usize::from(c) >= channels.len()).unwrap_or(0);
            return Err(CfaError::CellChannel {
                row: at / mosaic.cols(),
                col: at % mosaic.cols(),
                channel: usize::from(mosaic.cells()[at]),
                channels: channels.len(),
            });
        }
        if mosaic.channels() < channels.len() {
            return Err(CfaError::UnusedChannel { channel: mosaic.channels() });
        }
        let grid = channels[0].transmittance.grid();
        for c in &channels {
            if c.transmittance.grid() != grid {
                return Err(SpectrumError::GridMismatch { left: grid, right: c.transmittance.grid() }.into());
            }
            c.transmittance.check_fraction("the transmittance of a filter")?;
        }
        Ok(Self { name: name.into(), mosaic, channels })
    }

    /// The array of samples that are read from blocks of `side` × `side` cells; `None` when a block has several
    /// channels. See [`Mosaic::binned`].
    #[must_use]
    pub fn binned(&self, side: usize) -> Option<Self> {
        let mosaic = self.mosaic.binned(side)?;
        Some(Self { mosaic, ..self.clone() })
    }

    /// The array with a block of cells in place of each cell.
    pub(in crate::sensor) fn with_blocks(&self, side: usize) -> Self {
        Self { mosaic: self.mosaic.with_blocks(side), ..self.clone() }
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The tile.
    #[must_use]
    pub fn mosaic(&self) -> &Mosaic {
        &self.mosaic
    }

    /// The channels, in the order of the indices in the tile.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }
}
