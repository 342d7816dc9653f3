//! The best filters for a mosaic, and the best mosaic, by the closed form of [`Screen`].
//!
//! The filters are those of a [`FilterSpace`]. L-BFGS changes their parameters along the gradient of the expected errors, from many random
//! starts; filters that can only be chosen are exchanged one by one. Mosaics are all layouts of a tile, or annealed ([`LayoutSearch`]). Starts are independent and
//! keyed by their number, so that any number of threads finds the same.

mod exchange;
mod goal;
mod improve;
mod layouts;
mod lbfgs;
mod settings;
mod space;
mod tolerance;

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

pub use goal::{Front, FrontAim, Goal, Objective, Over};
pub use improve::{Improvement, Locks};
pub use layouts::{Annealing, FoundLayout, LayoutRules, LayoutSearch, TileRules};
pub use settings::SearchSettings;
pub use space::{Dichroic, FilterSpace, FreeCurves, Measured, Mixtures, Pigments, SampledSpace};
pub use tolerance::Tolerance;

use super::error::DesignError;
use super::screen::{Differentiable, ExpectedError, Figures, FilterResponses, Screen};
use crate::numeric::philox::Stream;
use crate::sensor::Mosaic;
use crate::spectrum::Spectrum;

/// Purpose of the random numbers of starts.
const PURPOSE: u32 = 0x0044_5347;
/// Steps of the first, short search, after which the poorer half of the starts ends.
const SHORT_STEPS: usize = 25;

/// Parameters of each filter; none for a filter that is given.
type Parameters = Vec<Vec<f64>>;

/// Filters that were found for a mosaic.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundFilters {
    /// Parameters of each filter in its space; none for a filter that is given.
    pub parameters: Vec<Vec<f64>>,
    /// Transmittances on the wavelengths of the camera.
    pub transmittances: Vec<Spectrum>,
    /// Expected errors, one for each condition of each screen.
    pub expected: Vec<ExpectedError>,
    /// The cost by the [`Goal`], a mean over the deviations.
    pub cost: f64,
    /// The number of its start. Those from given parameters come first.
    pub start: usize,
}

/// A search for the filters of one mosaic.
#[derive(Debug, Clone, Copy)]
pub struct FilterSearch<'a> {
    /// The expected errors, a screen for each illuminant.
    pub screens: &'a [Screen],
    /// The filters that can be made.
    pub space: &'a SampledSpace,
    /// Transmittances of filters that are given, by channel. Further channels are free.
    pub given: &'a [Option<Spectrum>],
    /// What is minimised.
    pub goal: &'a Goal,
    /// How filters deviate from those that were wanted.
    pub tolerance: Tolerance,
    /// The extent of the search.
    pub settings: SearchSettings,
}

impl FilterSearch<'_> {
    /// The best filters for a mosaic from each start, best first: from the parameters in `first`, then from random ones. `item` keys the random numbers
    /// of the mosaic. `done` is called after each start, from any thread, with its cost, and stops the search once it returns false;
    /// what was found so far is returned.
    ///
    /// # Errors
    /// When a setting is out of its range.
    pub fn filters(
        &self,
        mosaic: &Mosaic,
        first: &[Vec<Vec<f64>>],
        item: u32,
        done: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<FoundFilters>, DesignError> {
        self.settings.validate()?;
        self.tolerance.validate()?;
        let SearchSettings { starts, steps, seed } = self.settings;
        let stopped = AtomicBool::new(false);
        let is_stopped = || stopped.load(Ordering::Relaxed);
        let channels = mosaic.channels();
        let begin = |start: usize| {
            let known = first.get(start).filter(|p| p.len() == channels).cloned();
            let parameters = known.unwrap_or_else(|| {
                let mut random = Stream::new(seed ^ u64::from(item) << 32, PURPOSE, start as u32);
                let of = |channel| {
                    if self.is_given(channel) { Vec::new() } else { self.space.random(&mut random) }
                };
                (0..channels).map(of).collect()
            });
            let (parameters, cost) = self.search(mosaic, parameters, SHORT_STEPS.min(steps), &is_stopped);
            (cost, start, parameters)
        };
        // All starts lead to the best of all sets when all are tried.
        let all = if self.tries_all(channels) { 1 } else { starts + first.len() };
        let mut begun: Vec<(f64, usize, Parameters)> = (0..all).into_par_iter().map(begin).collect();
        begun.sort_by(|a, b| a.0.total_cmp(&b.0));
        begun.truncate(all.div_ceil(2));
        let finish = |(_, start, parameters): (f64, usize, Parameters)| {
            let found = self.search(mosaic, parameters, steps, &is_stopped);
            let (parameters, cost) = self.makeable(mosaic, found, steps, &is_stopped);
            if !done(cost) {
                stopped.store(true, Ordering::Relaxed);
            }
            self.found(mosaic, parameters, cost, start)
        };
        let mut found: Vec<FoundFilters> =
            begun.into_par_iter().map(finish).collect::<Result<_, DesignError>>()?;
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.start.cmp(&b.start)));
        Ok(found)
    }

    fn is_given(&self, channel: usize) -> bool {
        self.given.get(channel).is_some_and(Option::is_some)
    }

    /// The filters of parameters that were found, with their expected errors.
    ///
    /// # Errors
    /// When a parameter is not finite.
    pub fn found(
        &self,
        mosaic: &Mosaic,
        parameters: Vec<Vec<f64>>,
        cost: f64,
        start: usize,
    ) -> Result<FoundFilters, DesignError> {
        let spectrum =
            |values| Spectrum::new(self.space.grid(), values).map_err(crate::camera::CameraError::from);
        let transmittances: Vec<Spectrum> =
            self.transmittances(&parameters).into_iter().map(spectrum).collect::<Result<_, _>>()?;
        let of_screen = |screen: &Screen| {
            let responses = screen.responses(&transmittances);
            screen.expected_of(mosaic, &[responses], Figures::All).pop().unwrap_or_default()
        };
        let expected = self.screens.iter().flat_map(of_screen).collect();
        Ok(FoundFilters { parameters, transmittances, expected, cost, start })
    }

    /// The transmittances of all channels.
    fn transmittances(&self, parameters: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of = |(channel, p): (usize, &Vec<f64>)| match self.given.get(channel) {
            Some(Some(given)) => given.values().to_vec(),
            _ => self.space.transmittance(p),
        };
        parameters.iter().enumerate().map(of).collect()
    }

    /// Parameters that were found and their cost, without what a factory cannot make; what is left is searched once more.
    fn makeable(
        &self,
        mosaic: &Mosaic,
        (mut parameters, cost): (Parameters, f64),
        steps: usize,
        is_stopped: &impl Fn() -> bool,
    ) -> (Parameters, f64) {
        match self.space.prune(&mut parameters) {
            true => self.search(mosaic, parameters, steps, is_stopped),
            false => (parameters, cost),
        }
    }

    /// The parameters and the cost after a search from some parameters.
    fn search(
        &self,
        mosaic: &Mosaic,
        start: Parameters,
        steps: usize,
        is_stopped: &impl Fn() -> bool,
    ) -> (Parameters, f64) {
        if let Some(choices) = self.space.choices() {
            return self.exchange(mosaic, start, choices, is_stopped);
        }
        let each = self.space.parameters();
        let taken: Vec<bool> = start.iter().map(|p| !p.is_empty()).collect();
        let unpacked = |flat: &[f64]| -> Parameters {
            let mut parts = flat.chunks_exact(each);
            let of =
                |taken: &bool| if *taken { parts.next().unwrap_or_default().to_vec() } else { Vec::new() };
            taken.iter().map(of).collect()
        };
        let function = |flat: &[f64]| {
            let (cost, gradient) = self.cost(mosaic, &unpacked(flat));
            (cost, gradient.concat())
        };
        let point = lbfgs::minimise(start.concat(), steps, function, is_stopped);
        (unpacked(&point.at), point.value)
    }

    /// The cost of filters, given by their parameters, and its derivatives.
    #[must_use]
    pub fn cost(&self, mosaic: &Mosaic, parameters: &[Vec<f64>]) -> (f64, Vec<Vec<f64>>) {
        let transmittances = self.transmittances(parameters);
        let draws = self.tolerance.draws(transmittances.len(), self.settings.seed);
        let (grid, clear) = (self.space.grid(), self.space.clear());
        let share = 1.0 / draws.len() as f64;
        let (mut cost, mut by_wanted) = (0.0, transmittances.clone());
        by_wanted.iter_mut().for_each(|g| g.fill(0.0));
        for draw in &draws {
            let deviating: Vec<Vec<f64>> = transmittances
                .iter()
                .zip(draw)
                .map(|(t, deviation)| deviation.apply(t, grid, clear))
                .collect();
            let (of_draw, by_deviating) = self.cost_of(mosaic, &deviating);
            cost += share * of_draw;
            for (channel, deviation) in draw.iter().enumerate() {
                let by = deviation.by_wanted(&transmittances[channel], &by_deviating[channel], grid, clear);
                by_wanted[channel].iter_mut().zip(by).for_each(|(sum, g)| *sum += share * g);
            }
        }
        let by_parameters = |(p, g): (&Vec<f64>, &Vec<f64>)| match p.is_empty() {
            true => Vec::new(),
            false => self.space.by_parameters(p, g),
        };
        (cost, parameters.iter().zip(&by_wanted).map(by_parameters).collect())
    }

    /// The cost of transmittances, and its derivatives with respect to them.
    fn cost_of(&self, mosaic: &Mosaic, transmittances: &[Vec<f64>]) -> (f64, Vec<Vec<f64>>) {
        let figures = self.figures();
        let of_screen = |screen: &'_ Screen| -> FilterResponses {
            let spectra = screen.response_spectra();
            let of = |t: &Vec<f64>| {
                spectra.iter().map(|s| s.values().iter().zip(t).map(|(a, b)| a * b).sum()).collect()
            };
            FilterResponses::new(transmittances.iter().map(of).collect())
        };
        let parts: Vec<Differentiable<'_>> = self
            .screens
            .iter()
            .map(|screen| screen.differentiable(mosaic, &of_screen(screen), figures))
            .collect();
        let expected: Vec<ExpectedError> = parts.iter().flat_map(|p| p.expected().iter().copied()).collect();
        let (cost, weights) = self.goal.differentiated(&expected);
        let mut by_transmittance: Vec<Vec<f64>> = transmittances.iter().map(|t| vec![0.0; t.len()]).collect();
        let mut weights = &weights[..];
        for (part, screen) in parts.iter().zip(self.screens) {
            let (own, others) = weights.split_at(screen.conditions());
            weights = others;
            for (sums, by_response) in by_transmittance.iter_mut().zip(part.by_response(own)) {
                for (g, spectrum) in by_response.iter().zip(screen.response_spectra()) {
                    sums.iter_mut().zip(spectrum.values()).for_each(|(sum, v)| *sum += g * v);
                }
            }
        }
        (cost, by_transmittance)
    }

    fn figures(&self) -> Figures {
        self.goal.figures()
    }
}
