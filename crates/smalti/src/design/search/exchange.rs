//! The best choice among given filters: all sets when they are few, else by the exchange of one filter at a time.

use super::{FilterSearch, Parameters};
use crate::design::screen::{ExpectedError, FilterResponses};
use crate::sensor::Mosaic;

/// Sets of filters up to which all are tried.
const MAX_TRIED: usize = 4096;

impl FilterSearch<'_> {
    /// Whether all sets of filters for some channels are tried.
    pub(super) fn tries_all(&self, channels: usize) -> bool {
        let free = (0..channels).filter(|channel| !self.is_given(*channel)).count();
        let sets = self.space.choices().and_then(|n| n.checked_pow(free as u32));
        sets.is_some_and(|n| n <= MAX_TRIED)
    }

    /// The best choice from a start. The cost never rises, so that the search ends.
    pub(super) fn exchange(
        &self,
        mosaic: &Mosaic,
        start: Parameters,
        choices: usize,
        is_stopped: &impl Fn() -> bool,
    ) -> (Parameters, f64) {
        let free: Vec<usize> = (0..start.len()).filter(|channel| !start[*channel].is_empty()).collect();
        if self.tries_all(start.len()) {
            let count = choices.pow(free.len() as u32);
            let set = |number: usize| {
                let mut set = start.clone();
                let mut rest = number;
                for &channel in &free {
                    set[channel] = vec![(rest % choices) as f64];
                    rest /= choices;
                }
                set
            };
            return self.cheapest(mosaic, (0..count).map(set).collect()).unwrap_or((start, f64::INFINITY));
        }
        let (mut best, mut cost) =
            self.cheapest(mosaic, vec![start.clone()]).unwrap_or((start, f64::INFINITY));
        loop {
            let before = cost;
            for &channel in &free {
                let with = |choice: usize| {
                    let mut set = best.clone();
                    set[channel] = vec![choice as f64];
                    set
                };
                let found = self.cheapest(mosaic, (0..choices).map(with).collect());
                if let Some((set, value)) = found.filter(|(_, value)| *value < cost) {
                    (best, cost) = (set, value);
                }
            }
            if cost >= before || is_stopped() {
                return (best, cost);
            }
        }
    }

    /// The first of the cheapest sets.
    fn cheapest(&self, mosaic: &Mosaic, sets: Vec<Parameters>) -> Option<(Parameters, f64)> {
        let costs = self.costs(mosaic, &sets);
        sets.into_iter().zip(costs).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The costs of sets of filters, without derivatives.
    pub(super) fn costs(&self, mosaic: &Mosaic, sets: &[Parameters]) -> Vec<f64> {
        let figures = self.figures();
        let transmittances: Vec<Vec<Vec<f64>>> = sets.iter().map(|s| self.transmittances(s)).collect();
        let draws = self.tolerance.draws(mosaic.channels(), self.settings.seed);
        let mut costs = vec![0.0; sets.len()];
        for draw in &draws {
            let mut expected: Vec<Vec<ExpectedError>> = vec![Vec::new(); sets.len()];
            for screen in self.screens {
                let spectra = screen.response_spectra();
                let response = |t: &[f64]| {
                    spectra.iter().map(|s| s.values().iter().zip(t).map(|(a, b)| a * b).sum()).collect()
                };
                let of_set = |set: &Vec<Vec<f64>>| {
                    let deviating =
                        set.iter().zip(draw).map(|(t, d)| d.apply(t, self.space.grid(), self.space.clear()));
                    FilterResponses::new(deviating.map(|t| response(&t)).collect())
                };
                let responses: Vec<FilterResponses> = transmittances.iter().map(of_set).collect();
                let found = screen.expected_of(mosaic, &responses, figures);
                expected.iter_mut().zip(found).for_each(|(all, of_screen)| all.extend(of_screen));
            }
            let share = 1.0 / draws.len() as f64;
            costs.iter_mut().zip(&expected).for_each(|(sum, e)| *sum += share * self.goal.cost(e));
        }
        costs
    }
}
