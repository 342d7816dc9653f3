//! The best filters for a mosaic, and the best mosaic, by the closed form of [`Screen`].
//!
//! The filters are those of a [`FilterSpace`], whose parameters L-BFGS changes along the gradient of the expected errors, from many random
//! starts. Starts are independent and keyed by their number, so that any number of threads finds the same.

mod filter_space;
mod lbfgs;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use filter_space::{FilterSpace, FreeCurves, Pigments, SampledSpace};

use super::error::DesignError;
use super::screen::{ExpectedError, FigureWeights, Figures, FilterResponses, Screen};
use crate::numeric::philox::Stream;
use crate::sensor::Mosaic;
use crate::spectrum::Spectrum;

/// Purpose of the random numbers of starts.
const PURPOSE: u32 = 0x0044_5347;
/// Steps of the first, short search, after which the poorer half of the starts ends.
const SHORT_STEPS: usize = 25;

/// Limits of [`SearchSettings`].
const MAX_STARTS: usize = 100_000;
const MAX_STEPS: usize = 100_000;

/// What is minimised: a weighted sum of the expected figures, averaged over the conditions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Objective {
    /// Weight of a decibel of CPSNR.
    pub cpsnr_db: f64,
    /// Weight of a unit of mean CIEDE2000.
    pub delta_e_2000: f64,
}

impl Default for Objective {
    /// A decibel counts as much as a colour difference of 1.
    fn default() -> Self {
        Self { cpsnr_db: 1.0, delta_e_2000: 1.0 }
    }
}

impl Objective {
    /// Checks the weights.
    ///
    /// # Errors
    /// [`DesignError::Key`] when a weight is negative or not finite, or all are zero.
    pub fn validate(&self) -> Result<(), DesignError> {
        let weights = [("cpsnr_db", self.cpsnr_db), ("delta_e_2000", self.delta_e_2000)];
        if let Some((key, value)) = weights.iter().find(|(_, w)| !(w.is_finite() && *w >= 0.0)) {
            return Err(DesignError::key(format!("objective.{key}"), format!("{value}; expected 0 or more")));
        }
        if weights.iter().all(|(_, w)| *w == 0.0) {
            return Err(DesignError::key("objective", "expected a weight above 0"));
        }
        Ok(())
    }

    /// The cost of expected errors: less is better.
    #[must_use]
    pub fn cost(&self, expected: &[ExpectedError]) -> f64 {
        let of = |e: &ExpectedError| {
            // Without its weight, a figure that was not computed must not count.
            let colour = if self.delta_e_2000 > 0.0 { self.delta_e_2000 * e.delta_e_2000 } else { 0.0 };
            colour - self.cpsnr_db * e.cpsnr_db
        };
        expected.iter().map(of).sum::<f64>() / expected.len().max(1) as f64
    }

    fn weights(&self, expected: &[ExpectedError]) -> (f64, Vec<FigureWeights>) {
        let n = expected.len().max(1) as f64;
        let each = FigureWeights { cpsnr_db: -self.cpsnr_db / n, delta_e_2000: self.delta_e_2000 / n };
        (self.cost(expected), vec![each; expected.len()])
    }
}

/// The extent of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SearchSettings {
    /// Random starts for each mosaic, 1 to 100 000. The better half of them is searched to the end.
    pub starts: usize,
    /// Greatest number of steps of a start, 1 to 100 000.
    pub steps: usize,
    /// Seed of the starts.
    pub seed: u64,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self { starts: 12, steps: 200, seed: 1 }
    }
}

impl SearchSettings {
    /// Checks that there is something to do.
    ///
    /// # Errors
    /// [`DesignError::Key`] without a start or a step.
    pub fn validate(&self) -> Result<(), DesignError> {
        let range = |key: &str, value: usize, most: usize| {
            if (1..=most).contains(&value) {
                return Ok(());
            }
            Err(DesignError::key(format!("search.{key}"), format!("{value}; expected 1 to {most}")))
        };
        range("starts", self.starts, MAX_STARTS)?;
        range("steps", self.steps, MAX_STEPS)
    }
}

/// Parameters of each filter.
type Parameters = Vec<Vec<f64>>;

/// Filters that were found for a mosaic.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundFilters {
    /// Parameters of each filter in its space.
    pub parameters: Vec<Vec<f64>>,
    /// Transmittances on the wavelengths of the camera.
    pub transmittances: Vec<Spectrum>,
    /// Expected errors, one for each condition.
    pub expected: Vec<ExpectedError>,
    /// The cost by the [`Objective`].
    pub cost: f64,
    /// The number of its start.
    pub start: usize,
}

/// A search for the filters of one mosaic.
#[derive(Debug, Clone, Copy)]
pub struct FilterSearch<'a> {
    /// The expected errors.
    pub screen: &'a Screen,
    /// The filters that can be made.
    pub space: &'a SampledSpace,
    /// What is minimised.
    pub objective: Objective,
    /// The extent of the search.
    pub settings: SearchSettings,
}

impl FilterSearch<'_> {
    /// The best filters for a mosaic from each start, best first. `item` keys the random numbers of the mosaic. `done` is called after
    /// each start, from any thread, with its cost, and stops the search once it returns false; what was found so far is returned.
    ///
    /// # Errors
    /// When a setting is out of its range.
    pub fn filters(
        &self,
        mosaic: &Mosaic,
        item: u32,
        done: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<FoundFilters>, DesignError> {
        self.objective.validate()?;
        self.settings.validate()?;
        let SearchSettings { starts, steps, seed } = self.settings;
        let stopped = std::sync::atomic::AtomicBool::new(false);
        let is_stopped = || stopped.load(std::sync::atomic::Ordering::Relaxed);
        let begin = |start: usize| {
            let mut random = Stream::new(seed ^ u64::from(item) << 32, PURPOSE, start as u32);
            let parameters: Parameters =
                (0..mosaic.channels()).map(|_| self.space.random(&mut random)).collect();
            let (parameters, cost) = self.search(mosaic, &parameters, SHORT_STEPS.min(steps), &is_stopped);
            (cost, start, parameters)
        };
        let mut begun: Vec<(f64, usize, Parameters)> = (0..starts).into_par_iter().map(begin).collect();
        begun.sort_by(|a, b| a.0.total_cmp(&b.0));
        begun.truncate(starts.div_ceil(2));
        let finish = |(_, start, parameters): (f64, usize, Parameters)| {
            let (mut parameters, mut cost) = self.search(mosaic, &parameters, steps, &is_stopped);
            let pruned: Vec<bool> = parameters.iter_mut().map(|p| self.space.prune(p)).collect();
            if pruned.contains(&true) {
                (parameters, cost) = self.search(mosaic, &parameters, steps, &is_stopped);
            }
            if !done(cost) {
                stopped.store(true, std::sync::atomic::Ordering::Relaxed);
            }
            self.found(mosaic, parameters, cost, start)
        };
        let mut found: Vec<FoundFilters> =
            begun.into_par_iter().map(finish).collect::<Result<_, DesignError>>()?;
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.start.cmp(&b.start)));
        Ok(found)
    }

    fn found(
        &self,
        mosaic: &Mosaic,
        parameters: Parameters,
        cost: f64,
        start: usize,
    ) -> Result<FoundFilters, DesignError> {
        let transmittances: Vec<Spectrum> =
            parameters.iter().map(|p| self.space.spectrum(p)).collect::<Result<_, _>>()?;
        let responses = self.screen.responses(&transmittances);
        let expected = self.screen.expected_of(mosaic, &[responses], Figures::All).pop().unwrap_or_default();
        Ok(FoundFilters { parameters, transmittances, expected, cost, start })
    }

    /// The parameters and the cost after a search from some parameters.
    fn search(
        &self,
        mosaic: &Mosaic,
        start: &[Vec<f64>],
        steps: usize,
        is_stopped: &impl Fn() -> bool,
    ) -> (Parameters, f64) {
        let each = self.space.parameters();
        let function = |flat: &[f64]| {
            let parameters: Vec<&[f64]> = flat.chunks_exact(each).collect();
            let (cost, gradient) = self.cost(mosaic, &parameters);
            (cost, gradient.concat())
        };
        let point = lbfgs::minimise(start.concat(), steps, function, is_stopped);
        (point.at.chunks_exact(each).map(<[f64]>::to_vec).collect(), point.value)
    }

    /// The cost of filters, given by their parameters, and its derivatives.
    #[must_use]
    pub fn cost(&self, mosaic: &Mosaic, parameters: &[&[f64]]) -> (f64, Vec<Vec<f64>>) {
        let spectra = self.screen.response_spectra();
        let response = |p: &&[f64]| {
            let t = self.space.transmittance(p);
            spectra.iter().map(|s| s.values().iter().zip(&t).map(|(a, b)| a * b).sum()).collect()
        };
        let responses = FilterResponses::new(parameters.iter().map(response).collect());
        let figures = if self.objective.delta_e_2000 > 0.0 { Figures::All } else { Figures::Cpsnr };
        let gradient = self.screen.gradient(mosaic, &responses, figures, |e| self.objective.weights(e));
        let by_parameters = |(p, by_response): (&&[f64], &Vec<f64>)| {
            let mut by_transmittance = vec![0.0; spectra.first().map_or(0, |s| s.values().len())];
            for (g, s) in by_response.iter().zip(spectra) {
                by_transmittance.iter_mut().zip(s.values()).for_each(|(sum, v)| *sum += g * v);
            }
            self.space.by_parameters(p, &by_transmittance)
        };
        (gradient.sum, parameters.iter().zip(&gradient.by_response).map(by_parameters).collect())
    }
}
