//! An array that becomes better step by step, from one that is given, while some of its filters and cells stay as they are.

use super::{FilterSearch, Goal, Objective, SampledSpace, SearchSettings, Tolerance};
use crate::design::error::DesignError;
use crate::design::screen::{ExpectedError, Figures, Screen};
use crate::numeric::philox::Stream;
use crate::sensor::{Cfa, Mosaic};
use crate::spectrum::Spectrum;

/// Purpose of the random numbers of exchanges.
const PURPOSE: u32 = 0x0049_4d50;
/// Steps of the descent in one step of the improvement.
const DESCENT: usize = 6;
/// Changes of cells that one step tries.
const CHANGES: usize = 24;
/// Steps in turn without a better array, after which there is none to be found.
const PATIENCE: usize = 4;
/// A cost counts as lower from this difference on.
const LEAST: f64 = 1e-4;

/// What an improvement keeps.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Locks {
    /// Whether each filter is kept, by channel; filters beyond the last are free.
    pub filters: Vec<bool>,
    /// Whether each cell of the tile is kept, row by row; cells beyond the last are free.
    pub cells: Vec<bool>,
}

/// An array on its way to a better one. Filters follow the derivative of the cost ([`FilterSearch`]); when that no longer helps, cells
/// are exchanged or take another filter.
#[derive(Debug, Clone)]
pub struct Improvement {
    screens: Vec<Screen>,
    space: SampledSpace,
    goal: Goal,
    locks: Locks,
    given: Vec<Option<Spectrum>>,
    mosaic: Mosaic,
    /// Filters that can be made.
    parameters: Vec<Vec<f64>>,
    /// The filters that the descent follows. They may have traces of more pigments than a filter may have, until it is known which of them it needs.
    unpruned: Vec<Vec<f64>>,
    cost: f64,
    own_cost: f64,
    steps: usize,
    /// Steps in turn without a better array.
    idle: usize,
}

impl Improvement {
    /// An improvement of an array. Filters that are free become the nearest ones of the family first, without what a factory cannot make. `screens` has an entry for
    /// each illuminant.
    ///
    /// # Errors
    /// When the objective is invalid, or the array is on other wavelengths than the screens.
    pub fn new(
        screens: Vec<Screen>,
        space: SampledSpace,
        objective: &Objective,
        cfa: &Cfa,
        locks: Locks,
    ) -> Result<Self, DesignError> {
        objective.validate()?;
        let cfa = cfa.on_grid(space.grid())?;
        let own = screens.iter().map(|s| s.expected(&cfa)).collect::<Result<Vec<_>, _>>()?.concat();
        let is_kept = |channel: usize| locks.filters.get(channel).copied().unwrap_or(false);
        let channels = || cfa.channels().iter().map(|c| &c.transmittance).enumerate();
        let given = channels().map(|(i, t)| is_kept(i).then(|| t.clone())).collect();
        let first = |(i, t): (usize, &Spectrum)| match is_kept(i) {
            true => Vec::new(),
            false => space.start_near(t.values()),
        };
        let unpruned: Vec<Vec<f64>> = channels().map(first).collect();
        let mut parameters = unpruned.clone();
        space.prune(&mut parameters);
        let goal = objective.goal(&own);
        let mut improvement = Self {
            own_cost: goal.cost(&own),
            goal,
            given,
            mosaic: cfa.mosaic().clone(),
            parameters,
            unpruned,
            cost: f64::INFINITY,
            screens,
            space,
            locks,
            steps: 0,
            idle: 0,
        };
        improvement.cost = improvement.cost_of(&improvement.mosaic);
        Ok(improvement)
    }

    fn search(&self) -> FilterSearch<'_> {
        FilterSearch {
            screens: &self.screens,
            space: &self.space,
            given: &self.given,
            goal: &self.goal,
            tolerance: Tolerance::default(),
            settings: SearchSettings::default(),
        }
    }

    fn cost_of(&self, mosaic: &Mosaic) -> f64 {
        self.search().cost(mosaic, &self.parameters).0
    }

    /// Takes steps of the descent. Returns whether the filters that it follows became better, even if those that can be made did not.
    fn descend(&mut self) -> bool {
        let (search, is_stopped) = (self.search(), || false);
        let before = search.cost(&self.mosaic, &self.unpruned).0;
        let (unpruned, cost) = search.search(&self.mosaic, self.unpruned.clone(), DESCENT, &is_stopped);
        let makeable = search.makeable(&self.mosaic, (unpruned.clone(), cost), DESCENT, &is_stopped);
        // The best filters so far may have other pigments, of which other thicknesses may be better.
        let kept = (unpruned != makeable.0)
            .then(|| search.search(&self.mosaic, self.parameters.clone(), DESCENT, &is_stopped));
        let best = kept.into_iter().chain([makeable]).min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((parameters, cost)) = best.filter(|(_, cost)| *cost < self.cost) {
            (self.parameters, self.cost) = (parameters, cost);
        }
        if cost < before {
            self.unpruned = unpruned;
        }
        cost < before - LEAST
    }

    /// Takes a step. The cost never rises.
    pub fn step(&mut self) {
        self.steps += 1;
        let before = self.cost;
        let is_free = self.parameters.iter().any(|p| !p.is_empty());
        let mut goes_on = false;
        // Filters first, and again after each better mosaic.
        if is_free && self.idle == 0 {
            goes_on = self.descend();
        } else {
            let best = self
                .changes()
                .into_iter()
                .map(|mosaic| (self.cost_of(&mosaic), mosaic))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((cost, mosaic)) = best.filter(|(cost, _)| *cost < self.cost - LEAST) {
                (self.mosaic, self.cost) = (mosaic, cost);
            }
        }
        self.idle = if goes_on || self.cost < before - LEAST { 0 } else { self.idle + 1 };
    }

    /// Whether the latest steps found nothing better.
    #[must_use]
    pub fn is_done(&self) -> bool {
        let cells = self.mosaic.cells().len();
        let is_fixed = (0..cells).all(|cell| self.is_kept(cell));
        self.idle >= if is_fixed { 1 } else { PATIENCE }
    }

    fn is_kept(&self, cell: usize) -> bool {
        self.locks.cells.get(cell).copied().unwrap_or(false)
    }

    /// Mosaics with one change: two cells exchanged, or one with another filter. Every filter keeps a cell.
    fn changes(&self) -> Vec<Mosaic> {
        let (cells, channels) = (self.mosaic.cells(), self.mosaic.channels());
        let free: Vec<usize> = (0..cells.len()).filter(|cell| !self.is_kept(*cell)).collect();
        let mut all: Vec<Vec<u8>> = Vec::new();
        let mut random = Stream::new(0, PURPOSE, self.steps as u32);
        let mut any =
            |count: usize| ((random.uniform() * count as f64) as usize).min(count.saturating_sub(1));
        if free.is_empty() || channels < 2 {
            return Vec::new();
        }
        for _ in 0..CHANGES {
            let mut changed = cells.to_vec();
            let at = free[any(free.len())];
            if any(2) == 0 {
                changed.swap(at, free[any(free.len())]);
            } else {
                changed[at] = any(channels) as u8;
            }
            let is_whole = (0..channels).all(|channel| changed.iter().any(|c| usize::from(*c) == channel));
            if is_whole && changed != cells && !all.contains(&changed) {
                all.push(changed);
            }
        }
        let (rows, cols) = (self.mosaic.rows(), self.mosaic.cols());
        all.into_iter().filter_map(|cells| Mosaic::new(rows, cols, cells).ok()).collect()
    }

    /// Number of steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// The cost of the array so far.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// The cost of the array at the beginning.
    #[must_use]
    pub fn own_cost(&self) -> f64 {
        self.own_cost
    }

    /// The mosaic so far.
    #[must_use]
    pub fn mosaic(&self) -> &Mosaic {
        &self.mosaic
    }

    /// The transmittances of the filters so far, by channel.
    ///
    /// # Errors
    /// When a parameter is not finite.
    pub fn transmittances(&self) -> Result<Vec<Spectrum>, DesignError> {
        let spectrum =
            |values| Spectrum::new(self.space.grid(), values).map_err(crate::camera::CameraError::from);
        Ok(self
            .search()
            .transmittances(&self.parameters)
            .into_iter()
            .map(spectrum)
            .collect::<Result<_, _>>()?)
    }

    /// The expected errors of the array so far, one for each condition of each screen.
    ///
    /// # Errors
    /// As [`Improvement::transmittances`].
    pub fn expected(&self) -> Result<Vec<ExpectedError>, DesignError> {
        let transmittances = self.transmittances()?;
        let of_screen = |screen: &Screen| {
            let responses = screen.responses(&transmittances);
            screen.expected_of(&self.mosaic, &[responses], Figures::All).pop().unwrap_or_default()
        };
        Ok(self.screens.iter().flat_map(of_screen).collect())
    }
}
