//! The search for the best colour filter array.

use std::sync::{Mutex, PoisonError};

use super::design_store::{DesignStore, KeptFind};
use super::progress::ensure_running;
use super::{ExperimentError, Progress};
use crate::camera::Camera;
use crate::design::light::{LightSettings, LightStatistics};
use crate::design::screen::{ExpectedError, Screen, ScreenCondition};
use crate::design::search::{
    Annealing, FilterSearch, FilterSpace, FoundFilters, FoundLayout, Front, Goal, LayoutRules, LayoutSearch,
    Objective, SampledSpace, SearchSettings, Tolerance,
};
use crate::design::{Design, DesignError, FilterSet, MosaicFamily, published};
use crate::sensor::{Filter, Mosaic};
use crate::spectrum::{Illuminant, Spectrum};

/// Mosaics that are searched in full. When there are more, short searches choose them.
const FINALISTS: usize = 6;
/// Steps and starts of the short searches.
const SHORT: SearchSettings = SearchSettings { starts: 4, steps: 25, seed: 0 };
/// Largest tile of a published mosaic that competes.
const MAX_RIVAL_CELLS: usize = 64;
/// The numbers of filters of published mosaics.
const RIVAL_COLORS: std::ops::RangeInclusive<usize> = 3..=7;

/// A search: which array is wanted, for which camera and light.
#[derive(Debug, Clone)]
pub struct DesignTask {
    /// Its name.
    pub name: String,
    /// The camera, whose own filters do not matter.
    pub camera: Camera,
    /// The illuminants of the scenes. All count equally.
    pub illuminants: Vec<Illuminant>,
    /// Luminances and exposures, under each of the illuminants.
    pub conditions: Vec<ScreenCondition>,
    /// Numbers of filters.
    pub colors: Vec<usize>,
    /// The filters that can be made.
    pub filters: FilterSpace,
    /// The mosaics that are searched.
    pub mosaics: MosaicFamily,
    /// Number of mosaics drawn for each number of filters. When `None`, all are tried if they are few; those of larger tiles are annealed.
    pub mosaic_count: Option<u64>,
    /// What mosaics must fulfil. Published ones that compete need not.
    pub rules: LayoutRules,
    /// The search for layouts of large tiles.
    pub annealing: Annealing,
    /// Whether the published mosaics compete, with filters found for each in the same way.
    pub rivals: bool,
    /// What is minimised.
    pub objective: Objective,
    /// The aims between which compromises are wanted as well.
    pub front: Option<Front>,
    /// How filters deviate from those that were wanted.
    pub tolerance: Tolerance,
    /// The extent of the search.
    pub search: SearchSettings,
    /// The statistics of the light.
    pub light: LightSettings,
}

/// A mosaic with the filters that were found for it.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignedCfa {
    /// The name of a published mosaic, else its tile in letters.
    pub name: String,
    /// Whether the mosaic is published.
    pub is_published: bool,
    /// The mosaic; channel i has filter i.
    pub mosaic: Mosaic,
    /// The best filters of each start, best first; never empty.
    pub found: Vec<FoundFilters>,
}

impl DesignedCfa {
    /// The best filters.
    #[must_use]
    pub fn best(&self) -> Option<&FoundFilters> {
        self.found.first()
    }

    /// The array with its best filters in ascending order of wavelength.
    #[must_use]
    pub fn design(&self) -> Option<Design> {
        let best = self.best()?;
        let mean_nm = |s: &Spectrum| {
            let sum: f64 = s.values().iter().sum();
            let moment: f64 = s.values().iter().zip(s.grid().wavelengths_nm()).map(|(t, nm)| t * nm).sum();
            moment / sum.max(f64::MIN_POSITIVE)
        };
        let mut order: Vec<usize> = (0..best.transmittances.len()).collect();
        order.sort_by(|&a, &b| {
            mean_nm(&best.transmittances[a]).total_cmp(&mean_nm(&best.transmittances[b])).then(a.cmp(&b))
        });
        let place = |cell: &u8| order.iter().position(|i| *i == usize::from(*cell)).map(|p| p as u8);
        let cells = self.mosaic.cells().iter().map(place).collect::<Option<Vec<u8>>>()?;
        let filter = |i: &usize| {
            let (t, grid) = (&best.transmittances[*i], best.transmittances[*i].grid());
            Filter::Samples {
                start_nm: grid.start_nm(),
                step_nm: grid.step_nm(),
                values: t.values().to_vec(),
            }
        };
        Some(Design {
            filters: FilterSet { label: self.name.clone(), filters: order.iter().map(filter).collect() },
            mosaic: Mosaic::new(self.mosaic.rows(), self.mosaic.cols(), cells).ok()?,
        })
    }

    fn cost(&self) -> f64 {
        self.best().map_or(f64::INFINITY, |f| f.cost)
    }
}

/// A compromise between the aims of a front.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontPoint {
    /// The share of each aim.
    pub shares: Vec<f64>,
    /// The cost of each aim: less is better.
    pub costs: Vec<f64>,
    /// The array.
    pub cfa: DesignedCfa,
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Designs {
    /// The expected errors of the camera's own array, by illuminant and condition.
    pub own: Vec<ExpectedError>,
    /// What was minimised.
    pub goal: Goal,
    /// The searched mosaics, best first.
    pub searched: Vec<DesignedCfa>,
    /// The published mosaics with filters of the same kind, best first.
    pub rivals: Vec<DesignedCfa>,
    /// The compromises between the aims of the front that no other surpasses in all of them, by the cost of the first aim.
    pub front: Vec<FrontPoint>,
}

/// A mosaic that is searched.
struct Candidate {
    name: String,
    is_published: bool,
    mosaic: Mosaic,
    /// Parameters of filters to begin with.
    first: Vec<Vec<Vec<f64>>>,
    /// The key of its random numbers.
    item: u32,
}

/// First keys of random numbers.
const RIVALS: u32 = 1 << 16;
const FRONT: u32 = 1 << 24;

impl DesignTask {
    /// Checks everything that needs no statistics. The keys of errors are those of a design file.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the first key that is out of its range.
    pub fn validate(&self) -> Result<(), DesignError> {
        self.objective.validate()?;
        self.tolerance.validate()?;
        self.search.validate()?;
        self.annealing.validate()?;
        self.rules.validate()?;
        if let Some(front) = &self.front {
            front.validate(&self.luminances_cd_m2())?;
        }
        let of_tile = matches!(self.mosaics, MosaicFamily::Tile(_)) && self.mosaic_count.is_none();
        if !of_tile && !self.rules.kept.is_empty() {
            let message = "cells are kept in the tile of `mosaics.tile` without `mosaic_count` only";
            return Err(DesignError::key("rules.kept", message));
        }
        Ok(())
    }

    /// The mean luminance of the scenes of each condition, cd/m².
    #[must_use]
    pub fn luminances_cd_m2(&self) -> Vec<f64> {
        self.conditions.iter().map(|c| c.luminance_cd_m2).collect()
    }

    /// The filters of the first channels that are given, sampled.
    fn given(&self) -> Result<Vec<Option<Spectrum>>, DesignError> {
        let of = |letter: char| {
            let Some(filter) = self.rules.filters.get(&letter) else { return Ok(None) };
            let wrong = |e: &dyn ToString| DesignError::key(format!("rules.filters.{letter}"), e.to_string());
            filter.spectrum(self.camera.grid()).map(Some).map_err(|e| wrong(&e))
        };
        self.rules.letters().into_iter().map(of).collect()
    }

    /// The mosaics of a number of filters when they are tried one by one, or `None` when layouts are annealed.
    ///
    /// # Errors
    /// When there is no such mosaic, or too many.
    pub fn listed_mosaics(&self, colors: usize) -> Result<Option<Vec<Mosaic>>, DesignError> {
        if let (MosaicFamily::Tile(tile), None) = (&self.mosaics, self.mosaic_count) {
            return self.rules.of_tile(*tile)?.all(colors);
        }
        let mut all = self.mosaics.pick_layouts(colors, self.mosaic_count, self.search.seed)?;
        let count = all.len();
        all.retain(|mosaic| self.rules.allow(mosaic));
        if all.is_empty() && count > 0 {
            let message = format!("none of the {count} mosaics of {colors} filters fulfils it");
            return Err(DesignError::key("rules.least_distance_px", message));
        }
        Ok(Some(all))
    }
}

/// Finds the filters for every mosaic of a task, those for the published mosaics, and the front. `statistics` has an entry for each illuminant. Each start
/// is one step of progress. What `store` has of an earlier run is not searched again.
///
/// The same task gives the same arrays for any number of threads.
///
/// # Errors
/// When a setting is invalid, the statistics are of another camera, or the work is stopped.
pub fn design(
    task: &DesignTask,
    statistics: &[LightStatistics],
    store: &dyn DesignStore,
    progress: &dyn Progress,
) -> Result<Designs, ExperimentError> {
    task.validate()?;
    let screens = screens(task, statistics)?;
    let space = task.filters.sampled(task.camera.grid())?;
    let given = task.given()?;
    let own = screens
        .iter()
        .map(|screen| screen.expected(&task.camera.sensor.cfa))
        .collect::<Result<Vec<_>, _>>()?
        .concat();
    let goal = task.objective.goal(&own);
    let search = Search { task, screens: &screens, space: &space, store, progress };
    let free = search.filters(&goal, &[], task.search);
    let constrained = FilterSearch { given: &given, ..free };
    let mut candidates: Vec<Candidate> = Vec::new();
    for &colors in &task.colors {
        let found: Vec<(Mosaic, Vec<Vec<Vec<f64>>>)> = match task.listed_mosaics(colors)? {
            Some(listed) => listed.into_iter().map(|mosaic| (mosaic, Vec::new())).collect(),
            None => {
                let annealed = search.annealed(&constrained, colors)?;
                annealed.into_iter().map(|found| (found.mosaic, vec![found.parameters])).collect()
            }
        };
        for (mosaic, first) in found {
            let item = candidates.len() as u32;
            candidates.push(Candidate { name: tile_name(&mosaic), is_published: false, mosaic, first, item });
        }
    }
    let mut rivals: Vec<Candidate> = Vec::new();
    if task.rivals {
        for colors in RIVAL_COLORS {
            for (info, mosaic) in published(colors)? {
                if mosaic.cells().len() <= MAX_RIVAL_CELLS {
                    let (name, item) = (info.name.to_owned(), RIVALS + rivals.len() as u32);
                    rivals.push(Candidate { name, is_published: true, mosaic, first: Vec::new(), item });
                }
            }
        }
    }
    let searched = search.contest(&constrained, candidates)?;
    let rivals = search.contest(&free, rivals)?;
    let front = match &task.front {
        Some(front) => search.front(&given, front, &searched)?,
        None => Vec::new(),
    };
    Ok(Designs { own, goal, searched, rivals, front })
}

/// A screen for each illuminant of a task.
///
/// # Errors
/// When there are not as many statistics as illuminants, or they are of another camera.
pub fn screens(task: &DesignTask, statistics: &[LightStatistics]) -> Result<Vec<Screen>, DesignError> {
    if statistics.len() != task.illuminants.len() || statistics.is_empty() {
        let (found, expected) = (statistics.len(), task.illuminants.len());
        let message =
            format!("{expected} illuminants and {found} statistics of light; expected one for each");
        return Err(DesignError::key("illuminants", message));
    }
    statistics.iter().map(|s| Screen::new(&task.camera, s, &task.conditions)).collect()
}

/// What all parts of a search share.
#[derive(Clone, Copy)]
struct Search<'a> {
    task: &'a DesignTask,
    screens: &'a [Screen],
    space: &'a SampledSpace,
    store: &'a dyn DesignStore,
    progress: &'a dyn Progress,
}

impl<'a> Search<'a> {
    fn filters(
        &self,
        goal: &'a Goal,
        given: &'a [Option<Spectrum>],
        settings: SearchSettings,
    ) -> FilterSearch<'a> {
        let Self { task, screens, space, .. } = *self;
        FilterSearch { screens, space, given, goal, tolerance: task.tolerance, settings }
    }

    /// Annealed layouts.
    fn annealed(
        &self,
        filters: &FilterSearch<'a>,
        colors: usize,
    ) -> Result<Vec<FoundLayout>, ExperimentError> {
        let MosaicFamily::Tile(tile) = self.task.mosaics else { return Ok(Vec::new()) };
        let (rules, annealing) = (self.task.rules.of_tile(tile)?, self.task.annealing);
        let part = format!("layouts of {colors} filters");
        let layout = |kept: KeptFind| {
            let mosaic = Mosaic::new(tile.rows, tile.cols, kept.cells).ok()?;
            Some(FoundLayout { mosaic, parameters: kept.parameters, cost: kept.cost })
        };
        let kept: Option<Vec<FoundLayout>> =
            self.store.find(&part).and_then(|kept| kept.into_iter().map(layout).collect());
        if let Some(kept) = kept {
            return Ok(kept);
        }
        self.progress.expect((annealing.chains * annealing.rounds) as u64);
        let done = self.live(part.clone());
        let found = LayoutSearch { filters: *filters, rules: &rules, annealing }.layouts(colors, &done)?;
        ensure_running(self.progress)?;
        let keep = |f: &FoundLayout| KeptFind {
            cells: f.mosaic.cells().to_vec(),
            parameters: f.parameters.clone(),
            cost: f.cost,
            start: 0,
        };
        self.store.keep(&part, &found.iter().map(keep).collect::<Vec<_>>());
        Ok(found)
    }

    /// Reports each cost with the best of them so far.
    fn live(&self, name: String) -> impl Fn(f64) -> bool + Sync {
        let (best, progress) = (Mutex::new(f64::INFINITY), self.progress);
        move |cost: f64| {
            let mut best = best.lock().unwrap_or_else(PoisonError::into_inner);
            *best = best.min(cost);
            progress.begin(&format!("{name}: cost {cost:.3}, best so far {:.3}", *best));
            progress.done();
            !progress.is_stopped()
        }
    }

    /// The filters of a mosaic, unless an earlier run has found them.
    fn run(
        &self,
        search: &FilterSearch<'_>,
        candidate: &Candidate,
        live: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<FoundFilters>, ExperimentError> {
        ensure_running(self.progress)?;
        let SearchSettings { starts, steps, .. } = search.settings;
        let part = format!("{} {} {starts} {steps}", candidate.item, candidate.name);
        if let Some(kept) = self.store.find(&part) {
            kept.iter().for_each(|_| self.progress.done());
            let found =
                kept.into_iter().map(|k| search.found(&candidate.mosaic, k.parameters, k.cost, k.start));
            return Ok(found.collect::<Result<_, _>>()?);
        }
        let found = search.filters(&candidate.mosaic, &candidate.first, candidate.item, live)?;
        ensure_running(self.progress)?;
        let keep = |f: &FoundFilters| KeptFind {
            cells: Vec::new(),
            parameters: f.parameters.clone(),
            cost: f.cost,
            start: f.start,
        };
        self.store.keep(&part, &found.iter().map(keep).collect::<Vec<_>>());
        Ok(found)
    }

    /// Searches mosaics, best first. When there are many, short searches choose those that are searched in full; the others keep the result
    /// of the short one.
    fn contest(
        &self,
        search: &FilterSearch<'_>,
        mosaics: Vec<Candidate>,
    ) -> Result<Vec<DesignedCfa>, ExperimentError> {
        let seed = search.settings.seed;
        let short = FilterSearch { settings: SearchSettings { seed, ..SHORT }, ..*search };
        let has_heats = mosaics.len() > FINALISTS;
        let of_full = search.settings.starts.div_ceil(2);
        let heats = if has_heats { mosaics.len() * SHORT.starts.div_ceil(2) } else { 0 };
        self.progress.expect((heats + of_full * mosaics.len().min(FINALISTS)) as u64);
        let is_published = mosaics.first().is_some_and(|m| m.is_published);
        let live = self.live(if is_published { "published mosaics" } else { "mosaics" }.to_owned());
        let mut all: Vec<(Candidate, Vec<FoundFilters>)> = Vec::new();
        for candidate in mosaics {
            let found = if has_heats { self.run(&short, &candidate, &live)? } else { Vec::new() };
            all.push((candidate, found));
        }
        let cost = |found: &[FoundFilters]| found.first().map_or(f64::INFINITY, |f| f.cost);
        let order = |a: &(Candidate, Vec<FoundFilters>), b: &(Candidate, Vec<FoundFilters>)| {
            cost(&a.1).total_cmp(&cost(&b.1)).then(a.0.item.cmp(&b.0.item))
        };
        all.sort_by(order);
        for (candidate, known) in all.iter_mut().take(FINALISTS) {
            let mut found = self.run(search, candidate, &live)?;
            found.append(known);
            found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            *known = found;
        }
        all.sort_by(order);
        let designed =
            |(Candidate { name, is_published, mosaic, .. }, found): (Candidate, Vec<FoundFilters>)| {
                DesignedCfa { name, is_published, mosaic, found }
            };
        Ok(all.into_iter().map(designed).collect())
    }

    /// The front: each aim alone, then their compromises, on the mosaics that did best.
    fn front(
        &self,
        given: &[Option<Spectrum>],
        front: &Front,
        searched: &[DesignedCfa],
    ) -> Result<Vec<FrontPoint>, ExperimentError> {
        let luminances = self.task.luminances_cd_m2().repeat(self.screens.len());
        let goals: Vec<Goal> = front.aims.iter().map(|aim| aim.goal(&luminances)).collect();
        let costs =
            |found: &FoundFilters| goals.iter().map(|g| g.cost(&found.expected)).collect::<Vec<f64>>();
        let mosaics = &searched[..searched.len().min(FINALISTS)];
        let settings = SearchSettings { starts: SHORT.starts, ..self.task.search };
        let shares = front.shares();
        self.progress.expect((shares.len() * mosaics.len()) as u64);
        let mut points: Vec<FrontPoint> = Vec::new();
        let (mut best, mut span) = (vec![0.0; goals.len()], vec![1.0; goals.len()]);
        for (number, shares) in shares.into_iter().enumerate() {
            let alone = number < goals.len();
            if number == goals.len() {
                let of = |aim: usize| points.iter().map(move |p| p.costs[aim]);
                best = (0..goals.len()).map(|aim| of(aim).fold(f64::INFINITY, f64::min)).collect();
                let most = |aim: usize| of(aim).fold(f64::NEG_INFINITY, f64::max);
                span = (0..goals.len()).map(|aim| (most(aim) - best[aim]).max(1e-6)).collect();
            }
            let goal =
                if alone { goals[number].clone() } else { Goal::compromise(&goals, &shares, &best, &span) };
            let search = FilterSearch { given, ..self.filters(&goal, &[], settings) };
            let mut winner: Option<DesignedCfa> = None;
            for (at, designed) in mosaics.iter().enumerate() {
                let known = designed.found.iter().take(2).map(|f| f.parameters.clone());
                let neighbours = points.iter().filter(|p| p.cfa.mosaic == designed.mosaic);
                let of_neighbours = neighbours.filter_map(|p| p.cfa.best()).map(|f| f.parameters.clone());
                let candidate = Candidate {
                    name: designed.name.clone(),
                    is_published: false,
                    mosaic: designed.mosaic.clone(),
                    first: known.chain(of_neighbours).collect(),
                    item: FRONT + (number * FINALISTS + at) as u32,
                };
                let found = self.run(&search, &candidate, &|_| !self.progress.is_stopped())?;
                self.progress.begin(&format!("front, compromise {}", number + 1));
                self.progress.done();
                let found = DesignedCfa { found, ..designed.clone() };
                if winner.as_ref().is_none_or(|w| found.cost() < w.cost()) {
                    winner = Some(found);
                }
            }
            if let Some(cfa) = winner
                && let Some(found) = cfa.best()
            {
                points.push(FrontPoint { shares, costs: costs(found), cfa });
            }
        }
        let is_surpassed = |p: &FrontPoint| {
            let surpasses = |q: &FrontPoint| {
                let mut pairs = q.costs.iter().zip(&p.costs);
                pairs.clone().all(|(a, b)| a <= b) && pairs.any(|(a, b)| a < b)
            };
            points.iter().any(surpasses)
        };
        let mut kept: Vec<FrontPoint> = points.iter().filter(|p| !is_surpassed(p)).cloned().collect();
        kept.sort_by(|a, b| a.costs[0].total_cmp(&b.costs[0]));
        kept.dedup_by(|a, b| a.costs == b.costs);
        Ok(kept)
    }
}

/// A tile in letters, such as `ab/cd`.
fn tile_name(mosaic: &Mosaic) -> String {
    let letter = |&cell: &u8| char::from(b'a' + cell % 26);
    let rows = mosaic.cells().chunks(mosaic.cols().max(1));
    rows.map(|row| row.iter().map(letter).collect::<String>()).collect::<Vec<_>>().join("/")
}
