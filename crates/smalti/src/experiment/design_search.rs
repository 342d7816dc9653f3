//! The parts of a search: mosaics with their filters, layouts, the front.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use super::design_store::{DesignStore, KeptFind};
use super::design_task::{DesignTask, DesignedCfa, FrontPoint};
use super::progress::ensure_running;
use super::{ExperimentError, Progress};
use crate::design::MosaicFamily;
use crate::design::screen::Screen;
use crate::design::search::{
    FilterSearch, FoundFilters, FoundLayout, Front, Goal, LayoutSearch, SampledSpace, SearchSettings,
};
use crate::sensor::Mosaic;
use crate::spectrum::Spectrum;

/// Mosaics that are searched in full. When there are more, short searches choose them.
const FINALISTS: usize = 6;
/// Steps and starts of the short searches.
const SHORT: SearchSettings = SearchSettings { starts: 4, steps: 25, seed: 0 };
/// A mosaic that is searched.
pub(super) struct Candidate {
    pub(super) name: String,
    pub(super) is_published: bool,
    pub(super) mosaic: Mosaic,
    /// Parameters of filters to begin with.
    pub(super) first: Vec<Vec<Vec<f64>>>,
    /// The key of its random numbers.
    pub(super) item: u32,
}

/// First keys of random numbers.
pub(super) const RIVALS: u32 = 1 << 16;
const FRONT: u32 = 1 << 24;
/// Keys for each number of filters of a front.
const FRONT_GROUP: usize = 1 << 16;

/// What all parts of a search share.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) task: &'a DesignTask,
    pub(super) screens: &'a [Screen],
    pub(super) space: &'a SampledSpace,
    pub(super) store: &'a dyn DesignStore,
    pub(super) progress: &'a dyn Progress,
}

impl<'a> Search<'a> {
    pub(super) fn filters(
        &self,
        goal: &'a Goal,
        given: &'a [Option<Spectrum>],
        settings: SearchSettings,
    ) -> FilterSearch<'a> {
        let Self { task, screens, space, .. } = *self;
        FilterSearch { screens, space, given, goal, tolerance: task.tolerance, settings }
    }

    /// Annealed layouts; `None` when another process searches them.
    pub(super) fn annealed(
        &self,
        filters: &FilterSearch<'a>,
        colors: usize,
    ) -> Result<Option<Vec<FoundLayout>>, ExperimentError> {
        let MosaicFamily::Tile(tile) = self.task.mosaics else { return Ok(Some(Vec::new())) };
        let (rules, annealing) = (self.task.rules.of_tile(tile)?, self.task.annealing);
        let part = format!("layouts of {colors} filters");
        let layout = |kept: KeptFind| {
            let mosaic = Mosaic::new(tile.rows, tile.cols, kept.cells).ok()?;
            Some(FoundLayout { mosaic, parameters: kept.parameters, cost: kept.cost })
        };
        let kept: Option<Vec<FoundLayout>> =
            self.store.find(&part).and_then(|kept| kept.into_iter().map(layout).collect());
        if kept.is_some() || !self.store.takes(&part) {
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
        Ok(Some(found))
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

    /// The filters of a mosaic, unless an earlier run has found them; `None` when another process searches them.
    fn run(
        &self,
        search: &FilterSearch<'_>,
        candidate: &Candidate,
        live: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Option<Vec<FoundFilters>>, ExperimentError> {
        ensure_running(self.progress)?;
        let SearchSettings { starts, steps, .. } = search.settings;
        let part = format!("{} {} {starts} {steps}", candidate.item, candidate.name);
        if let Some(kept) = self.store.find(&part) {
            kept.iter().for_each(|_| self.progress.done());
            let found =
                kept.into_iter().map(|k| search.found(&candidate.mosaic, k.parameters, k.cost, k.start));
            return Ok(Some(found.collect::<Result<_, _>>()?));
        }
        if !self.store.takes(&part) {
            return Ok(None);
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
        Ok(Some(found))
    }

    /// Searches mosaics, best first. When there are many, short searches choose those that are searched in full; the others keep the result
    /// of the short one. `None` when other processes search some of them.
    pub(super) fn contest(
        &self,
        search: &FilterSearch<'_>,
        mosaics: Vec<Candidate>,
    ) -> Result<Option<Vec<DesignedCfa>>, ExperimentError> {
        let seed = search.settings.seed;
        let short = FilterSearch { settings: SearchSettings { seed, ..SHORT }, ..*search };
        let has_heats = mosaics.len() > FINALISTS;
        // The better half of the starts is finished: random ones and those that are known.
        let known = mosaics.iter().map(|m| m.first.len()).max().unwrap_or(0);
        let of_full = (search.settings.starts + known).div_ceil(2);
        let heats = if has_heats { mosaics.len() * (SHORT.starts + known).div_ceil(2) } else { 0 };
        self.progress.expect((heats + of_full * mosaics.len().min(FINALISTS)) as u64);
        let is_published = mosaics.first().is_some_and(|m| m.is_published);
        let live = self.live(if is_published { "published mosaics" } else { "mosaics" }.to_owned());
        let mut all: Vec<(Candidate, Vec<FoundFilters>)> = Vec::new();
        let mut is_whole = true;
        for candidate in mosaics {
            let found = if has_heats { self.run(&short, &candidate, &live)? } else { Some(Vec::new()) };
            is_whole &= found.is_some();
            all.push((candidate, found.unwrap_or_default()));
        }
        if !is_whole {
            return Ok(None);
        }
        let cost = |found: &[FoundFilters]| found.first().map_or(f64::INFINITY, |f| f.cost);
        let order = |a: &(Candidate, Vec<FoundFilters>), b: &(Candidate, Vec<FoundFilters>)| {
            cost(&a.1).total_cmp(&cost(&b.1)).then(a.0.item.cmp(&b.0.item))
        };
        all.sort_by(order);
        for (candidate, known) in all.iter_mut().take(FINALISTS) {
            let Some(mut found) = self.run(search, candidate, &live)? else {
                is_whole = false;
                continue;
            };
            found.append(known);
            found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            *known = found;
        }
        if !is_whole {
            return Ok(None);
        }
        all.sort_by(order);
        let designed =
            |(Candidate { name, is_published, mosaic, .. }, found): (Candidate, Vec<FoundFilters>)| {
                DesignedCfa { name, is_published, mosaic, found }
            };
        Ok(Some(all.into_iter().map(designed).collect()))
    }

    /// The front: each aim alone, then their compromises, on the mosaics that did best; for each number of filters when that is an aim.
    pub(super) fn front(
        &self,
        given: &[Option<Spectrum>],
        front: &Front,
        searched: &[DesignedCfa],
    ) -> Result<Vec<FrontPoint>, ExperimentError> {
        let mut groups: BTreeMap<usize, Vec<&DesignedCfa>> = BTreeMap::new();
        for designed in searched {
            let group = groups.entry(if front.filters { designed.mosaic.channels() } else { 0 }).or_default();
            if group.len() < FINALISTS {
                group.push(designed);
            }
        }
        let mosaics: usize = groups.values().map(Vec::len).sum();
        self.progress.expect((front.shares().len() * mosaics) as u64);
        let mut points = Vec::new();
        for (first_item, (filters, mosaics)) in (FRONT..).step_by(FRONT_GROUP).zip(&groups) {
            let mut found = self.compromises(given, front, mosaics, first_item)?;
            if front.filters {
                found.iter_mut().for_each(|point| point.costs.push(*filters as f64));
            }
            points.append(&mut found);
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

    /// The compromises between the aims of a front on some mosaics: the corners first, each after those before it.
    fn compromises(
        &self,
        given: &[Option<Spectrum>],
        front: &Front,
        mosaics: &[&DesignedCfa],
        first_item: u32,
    ) -> Result<Vec<FrontPoint>, ExperimentError> {
        let luminances = self.task.luminances_cd_m2().repeat(self.screens.len());
        let goals: Vec<Goal> = front.aims.iter().map(|aim| aim.goal(&luminances)).collect();
        let costs =
            |found: &FoundFilters| goals.iter().map(|g| g.cost(&found.expected)).collect::<Vec<f64>>();
        let settings = SearchSettings { starts: SHORT.starts, ..self.task.search };
        let shares = front.shares();
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
            let (mut winner, mut is_whole): (Option<DesignedCfa>, bool) = (None, true);
            for (at, designed) in mosaics.iter().enumerate() {
                let known = designed.found.iter().take(2).map(|f| f.parameters.clone());
                let neighbours = points.iter().filter(|p| p.cfa.mosaic == designed.mosaic);
                let of_neighbours = neighbours.filter_map(|p| p.cfa.best()).map(|f| f.parameters.clone());
                let candidate = Candidate {
                    name: designed.name.clone(),
                    is_published: false,
                    mosaic: designed.mosaic.clone(),
                    first: known.chain(of_neighbours).collect(),
                    item: first_item + (number * FINALISTS + at) as u32,
                };
                let found = self.run(&search, &candidate, &|_| !self.progress.is_stopped())?;
                let Some(found) = found else {
                    is_whole = false;
                    continue;
                };
                self.progress.begin(&format!("front, compromise {}", number + 1));
                self.progress.done();
                let found = DesignedCfa { found, ..(*designed).clone() };
                if winner.as_ref().is_none_or(|w| found.cost() < w.cost()) {
                    winner = Some(found);
                }
            }
            // Each compromise begins with those before it.
            if !is_whole {
                return Err(ExperimentError::OpenParts);
            }
            if let Some(cfa) = winner
                && let Some(found) = cfa.best()
            {
                points.push(FrontPoint { shares, costs: costs(found), cfa });
            }
        }
        Ok(points)
    }
}
