//! The mosaics that a search tries: all layouts of a small tile, annealed layouts of a large one, within rules.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{FilterSearch, Parameters, SearchSettings};
use crate::design::error::DesignError;
use crate::design::mosaics::{Tile, distinct};
use crate::numeric::philox::Stream;
use crate::sensor::{Filter, Mosaic};

/// Purpose of the random numbers.
const PURPOSE: u32 = 0x0044_534C;
/// Layouts up to which all are tried.
const MAX_LAYOUTS: usize = 256;
/// Layouts, with those that equal another by symmetry, up to which they are listed.
const MAX_LISTED: usize = 50_000;
/// Steps of the filters between two rounds.
const STEPS: usize = 25;
/// The cost of two pixels that are too close: more than any layout gains.
const TOO_CLOSE: f64 = 10.0;
/// The temperature falls from the first to the second, in units of the cost.
const TEMPERATURES: [f64; 2] = [0.2, 0.002];

/// `rules` of a design: what every mosaic must fulfil.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LayoutRules {
    /// Least distance of two pixels with the same filter, pixels from centre to centre: 1.4 forbids neighbours in a row or column.
    pub least_distance_px: f64,
    /// Cells that are kept: a string for each row of the tile with a letter for each kept cell and a point for every other. Cells with the same
    /// letter have the same filter. For `mosaics.tile` only.
    pub kept: Vec<String>,
    /// The filters of letters in `kept`. The filters of other letters are found.
    pub filters: BTreeMap<char, Filter>,
}

/// Rules for the tiles of a size.
#[derive(Debug, Clone, PartialEq)]
pub struct TileRules {
    tile: Tile,
    least_distance_px: f64,
    /// The channel of each kept cell.
    kept: Vec<Option<u8>>,
    /// The letters of the first channels.
    letters: Vec<char>,
}

impl LayoutRules {
    /// The letters of kept cells in their order, which are the first channels.
    #[must_use]
    pub fn letters(&self) -> Vec<char> {
        let all: std::collections::BTreeSet<char> =
            self.kept.iter().flat_map(|row| row.chars()).filter(|c| *c != '.').collect();
        all.into_iter().collect()
    }

    /// Checks the rules that do not depend on a tile.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the first key that is wrong.
    pub fn validate(&self) -> Result<(), DesignError> {
        let distance = self.least_distance_px;
        if !(0.0..=64.0).contains(&distance) {
            let message = format!("{distance}; expected 0 to 64 pixels");
            return Err(DesignError::key("rules.least_distance_px", message));
        }
        let letters = self.letters();
        if let Some(letter) = letters.iter().find(|c| !c.is_ascii_lowercase()) {
            let message = format!("'{letter}' is no filter; expected the letters a to z, or a point");
            return Err(DesignError::key("rules.kept", message));
        }
        if let Some(letter) = self.filters.keys().find(|c| !letters.contains(c)) {
            let message = "no kept cell has this letter";
            return Err(DesignError::key(format!("rules.filters.{letter}"), message));
        }
        Ok(())
    }

    /// Whether mosaics of other families fulfil them.
    #[must_use]
    pub fn allow(&self, mosaic: &Mosaic) -> bool {
        too_close(mosaic.cells(), (mosaic.rows(), mosaic.cols()), self.least_distance_px) == 0
    }

    /// The rules for a tile.
    ///
    /// # Errors
    /// [`DesignError::Key`] when kept cells are not those of the tile, or are too close.
    pub fn of_tile(&self, tile: Tile) -> Result<TileRules, DesignError> {
        self.validate()?;
        tile.validate()?;
        let letters = self.letters();
        let wrong = |message: String| DesignError::key("rules.kept", message);
        let mut kept = vec![None; tile.rows * tile.cols];
        if !self.kept.is_empty() {
            let fits =
                self.kept.len() == tile.rows && self.kept.iter().all(|r| r.chars().count() == tile.cols);
            if !fits {
                let (rows, cols) = (tile.rows, tile.cols);
                return Err(wrong(format!("expected {rows} rows of {cols} cells, as mosaics.tile has")));
            }
            for (cell, letter) in kept.iter_mut().zip(self.kept.iter().flat_map(|row| row.chars())) {
                *cell = letters.iter().position(|l| *l == letter).map(|at| at as u8);
            }
        }
        let rules = TileRules { tile, least_distance_px: self.least_distance_px, kept, letters };
        // Every cell that is not kept has a number of its own.
        let cells: Vec<u32> = (100..).zip(&rules.kept).map(|(own, k)| k.map_or(own, u32::from)).collect();
        if too_close(&cells, (tile.rows, tile.cols), self.least_distance_px) > 0 {
            let (rows, cols) = (tile.rows, tile.cols);
            let message = match rules.letters.is_empty() {
                true => format!(
                    "a tile of {rows} × {cols} repeats after {} pixels, closer than this; use a larger tile or a smaller distance",
                    rows.min(cols)
                ),
                false => "kept cells of the same letter, or of the same cell in the next tile, are closer than this".into(),
            };
            return Err(DesignError::key("rules.least_distance_px", message));
        }
        Ok(rules)
    }
}

/// Pairs of pixels with the same filter that are closer than `least`. A cell is also near itself in the next tiles.
fn too_close<T: PartialEq>(cells: &[T], (rows, cols): (usize, usize), least: f64) -> usize {
    if least <= 1.0 || cols == 0 {
        return 0;
    }
    let reach = least.ceil() as isize;
    let mut count = 0;
    for (at, cell) in cells.iter().enumerate() {
        let (row, col) = ((at / cols) as isize, (at % cols) as isize);
        for down in 0..=reach {
            for right in -reach..=reach {
                if down == 0 && right <= 0 || (down * down + right * right) as f64 >= least * least - 1e-9 {
                    continue;
                }
                let other = |v: isize, n: usize| v.rem_euclid(n as isize) as usize;
                count +=
                    usize::from(cells[other(row + down, rows) * cols + other(col + right, cols)] == *cell);
            }
        }
    }
    count
}

impl TileRules {
    /// All layouts of `colors` filters up to symmetry and the names of filters, when they are few enough to try each.
    ///
    /// # Errors
    /// When no layout fulfils the rules, or the tile cannot have as many filters.
    pub fn all(&self, colors: usize) -> Result<Option<Vec<Mosaic>>, DesignError> {
        let (rows, cols) = (self.tile.rows, self.tile.cols);
        self.ensure_room(colors)?;
        let mut cells: Vec<u8> = self.kept.iter().map(|k| k.unwrap_or(u8::MAX)).collect();
        let mut found = Vec::new();
        if !self.extend(&mut cells, 0, self.letters.len(), colors, &mut found) {
            return Ok(None);
        }
        let mosaics = found.into_iter().map(|c| Mosaic::new(rows, cols, c)).collect::<Result<Vec<_>, _>>()?;
        // Kept cells tell images of a layout apart.
        let mosaics = if self.letters.is_empty() { distinct(mosaics, self.tile.symmetry) } else { mosaics };
        if mosaics.is_empty() {
            let message = format!(
                "no layout of {colors} filters in {rows} × {cols} keeps equal filters {} pixels apart{}",
                self.least_distance_px,
                if self.letters.is_empty() { "" } else { " around the kept cells" },
            );
            return Err(DesignError::key("rules.least_distance_px", message));
        }
        Ok((mosaics.len() <= MAX_LAYOUTS).then_some(mosaics))
    }

    fn ensure_room(&self, colors: usize) -> Result<(), DesignError> {
        let free = self.kept.iter().filter(|k| k.is_none()).count();
        let letters = self.letters.len();
        if colors < letters || colors - letters > free {
            let message =
                format!("{colors} filters; the tile has {letters} kept filters and {free} other cells");
            return Err(DesignError::key("colors", message));
        }
        Ok(())
    }

    /// Fills the cells from `at` on, the filters in the order of their appearance. Returns false once there are too many layouts.
    fn extend(
        &self,
        cells: &mut Vec<u8>,
        at: usize,
        used: usize,
        colors: usize,
        found: &mut Vec<Vec<u8>>,
    ) -> bool {
        let Some(next) = (at..cells.len()).find(|i| self.kept[*i].is_none()) else {
            let size = (self.tile.rows, self.tile.cols);
            if used == colors && too_close(cells, size, self.least_distance_px) == 0 {
                found.push(cells.clone());
            }
            return found.len() <= MAX_LISTED;
        };
        let left = (next..cells.len()).filter(|i| self.kept[*i].is_none()).count();
        for cell in 0..colors.min(used + 1) {
            let now = used.max(cell + 1);
            if colors - now > left - 1 {
                continue;
            }
            cells[next] = cell as u8;
            if !self.extend(cells, next + 1, now, colors, found) {
                return false;
            }
        }
        cells[next] = u8::MAX;
        true
    }
}

/// `annealing` of a design: how layouts are found in a tile that has too many to try each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Annealing {
    /// Independent chains, 1 to 10 000.
    pub chains: usize,
    /// Rounds of a chain, 1 to 100: the filters are improved for the layout, then the layout for the filters.
    pub rounds: usize,
    /// Changes of the layout in each round, 1 to 1 000 000.
    pub moves: usize,
}

impl Default for Annealing {
    fn default() -> Self {
        Self { chains: 8, rounds: 4, moves: 400 }
    }
}

impl Annealing {
    /// Checks every field.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the first field that is out of its range.
    pub fn validate(&self) -> Result<(), DesignError> {
        let range = |key: &str, value: usize, most: usize| {
            if (1..=most).contains(&value) {
                return Ok(());
            }
            Err(DesignError::key(format!("annealing.{key}"), format!("{value}; expected 1 to {most}")))
        };
        range("chains", self.chains, 10_000)?;
        range("rounds", self.rounds, 100)?;
        range("moves", self.moves, 1_000_000)
    }
}

/// A search for layouts by simulated annealing ([kirkpatrick1983]): two cells are exchanged, a cell takes another filter, or a row or column is shifted.
///
/// [kirkpatrick1983]: https://doi.org/10.1126/science.220.4598.671
#[derive(Debug, Clone, Copy)]
pub struct LayoutSearch<'a> {
    /// The search for filters.
    pub filters: FilterSearch<'a>,
    /// What layouts must fulfil.
    pub rules: &'a TileRules,
    /// The extent of the search.
    pub annealing: Annealing,
}

/// A layout with the parameters of its filters.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundLayout {
    /// The layout.
    pub mosaic: Mosaic,
    /// Parameters of each filter; none for a filter that is given.
    pub parameters: Vec<Vec<f64>>,
    /// Its cost.
    pub cost: f64,
}

impl LayoutSearch<'_> {
    /// The best layout of each chain, best first, without those that equal another. `done` is called after each round, from any thread, with
    /// the cost, and stops the search once it returns false.
    ///
    /// # Errors
    /// When a setting is out of its range or no chain found a layout that fulfils the rules.
    pub fn layouts(
        &self,
        colors: usize,
        done: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<FoundLayout>, DesignError> {
        self.annealing.validate()?;
        self.rules.ensure_room(colors)?;
        let chain = |number: usize| self.chain(colors, number, done);
        let mut all: Vec<FoundLayout> =
            (0..self.annealing.chains).into_par_iter().map(chain).collect::<Result<_, DesignError>>()?;
        all.retain(|found| self.rules.violations(found.mosaic.cells()) == 0);
        all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let mut known: Vec<Mosaic> = Vec::new();
        all.retain(|found| {
            known.push(found.mosaic.clone());
            let kept = if self.rules.letters.is_empty() {
                distinct(known.clone(), self.rules.tile.symmetry).len()
            } else {
                known[..known.len() - 1].iter().filter(|m| **m != found.mosaic).count() + 1
            };
            let is_new = kept == known.len();
            if !is_new {
                known.pop();
            }
            is_new
        });
        if all.is_empty() {
            let message = format!(
                "no chain found a layout of {colors} filters that keeps equal filters {} pixels apart; reduce it, or add filters",
                self.rules.least_distance_px
            );
            return Err(DesignError::key("rules.least_distance_px", message));
        }
        Ok(all)
    }

    fn chain(
        &self,
        colors: usize,
        number: usize,
        done: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<FoundLayout, DesignError> {
        let Annealing { rounds, moves, .. } = self.annealing;
        let mut random = Stream::new(self.filters.settings.seed, PURPOSE, number as u32);
        let mut cells = self.rules.random(colors, &mut random);
        let mut best: Option<FoundLayout> = None;
        let mut parameters: Vec<Parameters> = Vec::new();
        for round in 0..rounds {
            let mosaic = self.rules.mosaic(&cells)?;
            let starts = if round == 0 { 4 } else { 1 };
            let settings = SearchSettings { starts, steps: STEPS, ..self.filters.settings };
            let search = FilterSearch { settings, ..self.filters };
            let item = (number * rounds + round) as u32 | 1 << 30;
            let Some(found) = search.filters(&mosaic, &parameters, item, &|_| true)?.into_iter().next()
            else {
                break;
            };
            parameters = vec![found.parameters];
            let [hot, cold] = TEMPERATURES;
            let cooled = |share: f64| hot * libm::pow(cold / hot, share);
            let mut cost = self.cost(&cells, &parameters)?;
            for step in 0..moves {
                // Each round begins cooler, so that it does not undo the one before.
                let share = (round as f64 + step as f64 / moves as f64) / rounds as f64;
                let next = self.rules.moved(&cells, colors, &mut random);
                let value = self.cost(&next, &parameters)?;
                let keep = value <= cost || random.uniform() < libm::exp((cost - value) / cooled(share));
                if keep {
                    (cells, cost) = (next, value);
                }
            }
            let better = best.as_ref().is_none_or(|b| cost < b.cost);
            if better && let Some(parameters) = parameters.first() {
                let mosaic = self.rules.mosaic(&cells)?;
                best = Some(FoundLayout { mosaic, parameters: parameters.clone(), cost });
            }
            if !done(cost) {
                break;
            }
        }
        best.ok_or_else(|| DesignError::key("annealing.rounds", "expected at least one round"))
    }

    fn cost(&self, cells: &[u8], parameters: &[Parameters]) -> Result<f64, DesignError> {
        let mosaic = self.rules.mosaic(cells)?;
        let cost = self.filters.costs(&mosaic, parameters).into_iter().next().unwrap_or(f64::INFINITY);
        Ok(cost + TOO_CLOSE * self.rules.violations(cells) as f64)
    }
}

impl TileRules {
    fn mosaic(&self, cells: &[u8]) -> Result<Mosaic, DesignError> {
        Ok(Mosaic::new(self.tile.rows, self.tile.cols, cells.to_vec())?)
    }

    fn violations(&self, cells: &[u8]) -> usize {
        too_close(cells, (self.tile.rows, self.tile.cols), self.least_distance_px)
    }

    /// The cells that may change.
    fn free(&self) -> Vec<usize> {
        (0..self.kept.len()).filter(|i| self.kept[*i].is_none()).collect()
    }

    /// A random layout in which every filter appears.
    fn random(&self, colors: usize, random: &mut Stream) -> Vec<u8> {
        let mut free = self.free();
        for last in (1..free.len()).rev() {
            free.swap(last, random.below(last as u32 + 1) as usize);
        }
        let mut cells: Vec<u8> = self.kept.iter().map(|k| k.unwrap_or_default()).collect();
        let mut missing = self.letters.len()..colors;
        for cell in free {
            cells[cell] = missing.next().map_or_else(|| random.below(colors as u32), |m| m as u32) as u8;
        }
        cells
    }

    /// A layout with one change, in which every filter still appears.
    fn moved(&self, cells: &[u8], colors: usize, random: &mut Stream) -> Vec<u8> {
        let free = self.free();
        let mut next = cells.to_vec();
        let mut any = || free[random.below(free.len() as u32) as usize];
        let (a, b) = (any(), any());
        match random.below(5) {
            0 | 1 => next.swap(a, b),
            2 | 3 => next[a] = random.below(colors as u32) as u8,
            _ if self.letters.is_empty() => {
                let (rows, cols) = (self.tile.rows, self.tile.cols);
                let (row, col) = (a / cols, a % cols);
                if random.below(2) == 0 {
                    (0..cols).for_each(|c| next[row * cols + c] = cells[row * cols + (c + 1) % cols]);
                } else {
                    (0..rows).for_each(|r| next[r * cols + col] = cells[(r + 1) % rows * cols + col]);
                }
            }
            _ => next.swap(a, b),
        }
        let appears = |filter: usize| next.iter().any(|c| usize::from(*c) == filter);
        if (0..colors).all(appears) { next } else { cells.to_vec() }
    }
}

#[cfg(test)]
mod tests;
