//! Mosaics whose cells are weighted mixtures of a few primaries, and those built from carriers.

use super::{Cfa, CfaError, Channel, Mosaic};
use crate::numeric::require;
use crate::spectrum::{Spectrum, SpectrumError};

/// A tile whose cells transmit a fraction of every primary: the transmittance of a cell is the weighted sum
/// of the primaries' transmittances.
///
/// Each weight is from 0 to 1, where 1 is the primary's own filter. The sum of weights can exceed 1, since
/// primaries that do not overlap add up to at most 1 at any wavelength. Where primaries overlap,
/// [`WeightedMosaic::cfa`] scales the whole array by one factor.
#[derive(Debug, Clone, PartialEq)]
pub struct WeightedMosaic {
    rows: usize,
    cols: usize,
    primaries: usize,
    weights: Vec<f64>,
}

/// The weight of one primary over the tile: `mean + amplitude cos(2π (carrier · position) + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modulation {
    /// Mean weight.
    pub mean: f64,
    /// Amplitude around the mean.
    pub amplitude: f64,
    /// Phase at the first cell, turns (1 is 2π).
    pub phase_turns: f64,
}

impl WeightedMosaic {
    /// A tile from the weights of its cells, ordered row, column, primary.
    ///
    /// # Errors
    /// When the number of weights is not `rows * cols * primaries`, there is no primary, the number of cells
    /// is not within 1–65536, or a weight is not within 0–1.
    pub fn new(rows: usize, cols: usize, primaries: usize, weights: Vec<f64>) -> Result<Self, CfaError> {
        let count = rows.checked_mul(cols).filter(|n| (1..=65536).contains(n)).unwrap_or(0);
        if count == 0 || count.checked_mul(primaries) != Some(weights.len()) || primaries == 0 {
            return Err(CfaError::Tile { rows, cols, cells: weights.len() / primaries.max(1) });
        }
        if let Some(at) = weights.iter().position(|w| !(0.0..=1.0).contains(w)) {
            let (primary, cell) = (at % primaries, at / primaries);
            let name = format!(
                "the weight of primary {primary} in cell ({}, {}), counted from 0,",
                cell / cols,
                cell % cols
            );
            require(false, name, weights[at], "0 to 1")?;
        }
        Ok(Self { rows, cols, primaries, weights })
    }

    /// A tile in which each primary modulates one carrier, the representation of Hirakawa and Wolfe (2008)
    /// and Condat (2011): luminance is at frequency zero, and chrominance entirely at the carrier. `carrier`
    /// counts cycles over the rows and over the columns of the tile.
    ///
    /// # Errors
    /// As [`WeightedMosaic::new`].
    pub fn modulated(
        rows: usize,
        cols: usize,
        carrier: [f64; 2],
        primaries: &[Modulation],
    ) -> Result<Self, CfaError> {
        if rows.checked_mul(cols).is_none_or(|n| n > 65536) {
            return Err(CfaError::Tile { rows, cols, cells: 0 });
        }
        let weight = |cell: usize, m: &Modulation| {
            let turns = carrier[0] * (cell / cols) as f64 / rows as f64
                + carrier[1] * (cell % cols) as f64 / cols as f64
                + m.phase_turns;
            let value = m.mean + m.amplitude * libm::cos(std::f64::consts::TAU * turns);
            // Without rounding, the error of the cosine would separate equal cells and make a weight of 0
            // negative.
            (value * 1e9).round() / 1e9 + 0.0
        };
        let weights = (0..rows * cols).flat_map(|cell| primaries.iter().map(move |m| weight(cell, m)));
        Self::new(rows, cols, primaries.len(), weights.collect())
    }

    /// The distinct mixtures in order of first appearance, and the mosaic of their indices.
    ///
    /// # Errors
    /// When there are more than 256 distinct mixtures.
    pub fn distinct(&self) -> Result<(Mosaic, Vec<Vec<f64>>), CfaError> {
        let mut mixtures: Vec<Vec<f64>> = Vec::new();
        let mut cells = Vec::with_capacity(self.rows * self.cols);
        for weights in self.weights.chunks_exact(self.primaries) {
            let index = mixtures.iter().position(|m| m == weights).unwrap_or_else(|| {
                mixtures.push(weights.to_vec());
                mixtures.len() - 1
            });
            require(index < 256, "the number of distinct mixtures", mixtures.len() as f64, "at most 256")?;
            cells.push(index as u8);
        }
        Ok((Mosaic::new(self.rows, self.cols, cells)?, mixtures))
    }

    /// The colour filter array: a channel for each distinct mixture, named by its weights (`1R+0.5G`).
    ///
    /// Where overlapping primaries would give a mixture a transmittance above 1, the transmittances of all
    /// channels are divided by the largest one, which preserves the ratios between cells.
    ///
    /// # Errors
    /// When the number of primaries is not that of the weights, their grids differ, or as for [`Cfa::new`].
    pub fn cfa(&self, name: impl Into<String>, primaries: &[Channel]) -> Result<Cfa, CfaError> {
        let (count, expected) = (primaries.len(), "one per weight of a cell");
        require(count == self.primaries, "the number of primaries", count as f64, expected)?;
        // A tile has at least one primary.
        let grid = primaries[0].transmittance.grid();
        if let Some(p) = primaries.iter().find(|p| p.transmittance.grid() != grid) {
            return Err(SpectrumError::GridMismatch { left: grid, right: p.transmittance.grid() }.into());
        }
        let (mosaic, mixtures) = self.distinct()?;
        let mix = |weights: &Vec<f64>| {
            let at =
                |i: usize| weights.iter().zip(primaries).map(|(w, p)| w * p.transmittance.values()[i]).sum();
            Spectrum::new(grid, (0..grid.len()).map(at).collect())
        };
        let spectra = mixtures.iter().map(mix).collect::<Result<Vec<_>, _>>()?;
        let largest = spectra.iter().map(Spectrum::max).fold(1.0, f64::max);
        let named = |weights: &[f64]| {
            let parts = weights.iter().zip(primaries).filter(|(w, _)| **w > 0.0);
            let text: Vec<String> = parts.map(|(w, p)| format!("{w:.3}{}", p.name)).collect();
            text.join("+")
        };
        let channels = mixtures
            .iter()
            .zip(&spectra)
            .map(|(m, s)| Ok(Channel { name: named(m), transmittance: s.scaled(1.0 / largest)? }))
            .collect::<Result<_, SpectrumError>>()?;
        Cfa::new(name, mosaic, channels)
    }
}
