//! The mosaics of a tile: their number, all of them, or a random sample.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

use super::group::{Group, Symmetry, cycles};
use super::request::{MosaicRequest, PURPOSE, THIS_TILE, sampled};
use super::surjection;
use crate::design::error::{DesignError, colors_checked};
use crate::numeric::philox::Stream;
use crate::sensor::Mosaic;

/// Largest number of cells. The permutations of a tile of 32 × 32 cells take 16 MB.
const MAX_CELLS: usize = 1024;

/// `[mosaics.tile]`: every placement of N colours in a tile in which all colours appear. Placements that are equal under the
/// symmetry count once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Tile {
    /// Rows; a tile has at most 1024 cells.
    pub rows: usize,
    /// Columns.
    pub cols: usize,
    /// The symmetry under which two tiles count as the same mosaic.
    #[serde(default)]
    pub symmetry: Symmetry,
}

impl Tile {
    /// Checks size and symmetry.
    ///
    /// # Errors
    /// [`DesignError::Key`] when the tile has no cell or more than 1024, or rotation is asked of a tile that is not square.
    pub fn validate(&self) -> Result<(), DesignError> {
        let Self { rows, cols, symmetry } = *self;
        if !rows.checked_mul(cols).is_some_and(|n| (1..=MAX_CELLS).contains(&n)) {
            let message = format!("{rows} × {cols} cells; expected 1 to {MAX_CELLS}");
            return Err(DesignError::key("tile.rows", message));
        }
        if symmetry == Symmetry::ShiftMirrorRotation && rows != cols {
            let message = format!("rotation needs a square tile, and this one is {rows} × {cols}");
            return Err(DesignError::key("tile.symmetry", message));
        }
        Ok(())
    }

    fn group(&self) -> Result<Group, DesignError> {
        self.validate()?;
        Ok(Group::new(self.rows, self.cols, self.symmetry))
    }

    /// Burnside's lemma: the mean over the group of the number of placements that an element fixes.
    pub(super) fn count(&self, colors: usize) -> Result<u128, DesignError> {
        colors_checked(colors)?;
        let group = self.group()?;
        let order = group.elements().len() as u128;
        let uncountable = DesignError::Uncountable { what: THIS_TILE, colors };
        let mut of = vec![0; self.rows * self.cols];
        // Number of elements for each number of cycles.
        let mut with = vec![0u128; of.len() + 1];
        group.elements().for_each(|element| with[cycles(element, &mut of)] += 1);
        // The sum may overflow although the mean fits, so quotients and remainders are summed separately.
        let (mut whole, mut rest) = (0u128, 0u128);
        for (places, &elements) in with.iter().enumerate().filter(|(_, n)| **n > 0) {
            let fixed = surjection::count(places, colors).ok_or(uncountable.clone())?;
            let part = (fixed / order).checked_mul(elements).and_then(|p| whole.checked_add(p));
            whole = part.ok_or(uncountable.clone())?;
            rest += fixed % order * elements;
        }
        whole.checked_add(rest / order).ok_or(uncountable)
    }

    /// Number of mosaics to draw from. For a sample, 2¹²⁸ − 1 stands for any larger number.
    pub(super) fn available(&self, colors: usize, count: Option<u64>) -> Result<u128, DesignError> {
        match self.count(colors) {
            Err(DesignError::Uncountable { .. }) if count.is_some() => Ok(u128::MAX),
            other => other,
        }
    }

    pub(super) fn pick(
        &self,
        colors: usize,
        request: MosaicRequest,
        seed: u64,
    ) -> Result<Vec<Mosaic>, DesignError> {
        // Rejection sampling of most mosaics would mostly draw duplicates.
        if u128::from(request.count) * 2 > request.available {
            return sampled(self.all(colors)?, request.count, colors, seed);
        }
        self.sample(colors, request.count, seed)
    }

    fn mosaic(&self, cells: &[u8]) -> Result<Mosaic, DesignError> {
        Ok(Mosaic::new(self.rows, self.cols, cells.to_vec())?.reduced())
    }

    /// All mosaics, in the order of their cells.
    fn all(&self, colors: usize) -> Result<Vec<Mosaic>, DesignError> {
        let group = self.group()?;
        let places = self.rows * self.cols;
        let mut found = Vec::new();
        let mut uses = vec![0usize; colors];
        let mut cells: Vec<u8> = vec![];
        // The next colour to append to `cells`.
        let mut next = 0u8;
        loop {
            let missing = uses.iter().filter(|&&n| n == 0).count();
            let open = cells.len() < places && missing <= places - cells.len() && usize::from(next) < colors;
            if open {
                cells.push(next);
                uses[usize::from(next)] += 1;
                next = 0;
                let missing = uses.iter().filter(|&&n| n == 0).count();
                if missing <= places - cells.len() && group.may_be_canonical(&cells) {
                    if cells.len() < places {
                        continue;
                    }
                    found.push(self.mosaic(&cells)?);
                }
            }
            // Backtrack: try the next colour of the last cell.
            let Some(last) = cells.pop() else { return Ok(found) };
            uses[usize::from(last)] -= 1;
            next = last + 1;
        }
    }

    /// `count` different mosaics; all sets of that size are equally likely.
    ///
    /// An element of the group is drawn with a weight equal to the number of placements that it fixes, then one of these
    /// placements. Every mosaic is then equally likely, regardless of the size of its orbit ([dixon1983]).
    fn sample(&self, colors: usize, count: u64, seed: u64) -> Result<Vec<Mosaic>, DesignError> {
        let group = self.group()?;
        let places = self.rows * self.cols;
        let sampler = surjection::Sampler::new(places, colors);
        let mut of = vec![0; places];
        let mut sum = 0.0;
        let weight = |element: &[u16]| {
            let cycles = cycles(element, &mut of);
            // Relative to the number of all colourings, colors^places.
            sum += sampler.probability(cycles) * libm::pow(colors as f64, cycles as f64 - places as f64);
            sum
        };
        let cumulative: Vec<f64> = group.elements().map(weight).collect();
        let mut stream = Stream::new(seed, PURPOSE, colors as u32);
        let (mut seen, mut found) = (HashSet::new(), Vec::new());
        let (mut palette, mut tile) = (vec![0; places], vec![0; places]);
        while (found.len() as u64) < count {
            let at = stream.uniform() * sum;
            let element = group.element(cumulative.partition_point(|&c| c <= at).min(cumulative.len() - 1));
            let cycles = cycles(element, &mut of);
            sampler.draw(&mut stream, &mut palette[..cycles]);
            tile.iter_mut().zip(&of).for_each(|(cell, &cycle)| *cell = palette[usize::from(cycle)]);
            let cells = group.canonical(&tile);
            if !seen.contains(&cells) {
                found.push(self.mosaic(&cells)?);
                seen.insert(cells);
            }
        }
        Ok(found)
    }
}
