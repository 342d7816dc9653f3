//! The analysis of an experiment: who is kept, the scales of all kept observers, and which metric agrees with them.

use rayon::prelude::*;
use serde::Serialize;

use super::counts::Counts;
use super::intervals::{IntervalBasis, ObserverResamples, percentiles};
use super::model::Model;
use super::rank::{kendall_tau_b, spearman_rho};
use super::scale::{Penalty, Scale, ScaleError, fit, fit_from};
use super::screening::{Likelihood, OUTLIER_DISTANCE, likelihoods};
use crate::numeric::bootstrap::{Estimate, Interval, LEAST_GROUPS};
use crate::numeric::philox::Stream;

/// Resamples of observers.
const RESAMPLES: usize = 1000;
/// Separates these random numbers from others of the same seed.
const PURPOSE: u32 = 0x7363_656e;
/// The smallest number of hidden repeats that can exclude an observer.
const LEAST_REPEATS: u32 = 4;
/// The 0.975 quantile of the normal distribution.
const NORMAL: f64 = 1.959_964;

/// The choices of an observer.
#[derive(Debug, Clone, PartialEq)]
pub struct ObserverChoices {
    /// For each scene the counts of choices between the conditions. Traps and training are not among them; hidden repeats are.
    pub scenes: Vec<Counts>,
    /// Hidden repeats with the same choice as before, and all.
    pub repeats: [u32; 2],
    /// Traps with the right choice, and all.
    pub traps: [u32; 2],
}

/// Why an observer is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// Fewer than two thirds of the traps were answered rightly.
    Traps,
    /// Fewer than half of at least four hidden repeats had the same choice.
    Repeats,
    /// The choices are improbable under the scale of all others: see [`OUTLIER_DISTANCE`].
    Outlier,
}

/// What was found about an observer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Screening {
    /// How probable the choices are under the scale of all others.
    pub likelihood: Option<Likelihood>,
    /// Why the observer is left out; empty for one who is kept.
    pub reasons: Vec<Reason>,
}

/// Screens observers. Likelihoods are judged from [`LEAST_GROUPS`] observers on.
#[must_use]
pub fn screen(observers: &[ObserverChoices]) -> Vec<Screening> {
    let choices: Vec<Vec<Counts>> = observers.iter().map(|o| o.scenes.clone()).collect();
    let of = |(observer, likelihood): (&ObserverChoices, Option<Likelihood>)| {
        let ([right, traps], [same, repeats]) = (observer.traps, observer.repeats);
        let is_outlier =
            observers.len() >= LEAST_GROUPS && likelihood.is_some_and(|l| l.distance > OUTLIER_DISTANCE);
        let checks = [
            (3 * right < 2 * traps, Reason::Traps),
            (repeats >= LEAST_REPEATS && 2 * same < repeats, Reason::Repeats),
            (is_outlier, Reason::Outlier),
        ];
        Screening {
            likelihood,
            reasons: checks.into_iter().filter_map(|(failed, reason)| failed.then_some(reason)).collect(),
        }
    };
    observers.iter().zip(likelihoods(&choices)).map(of).collect()
}

/// The scores of conditions with their intervals.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScaledConditions {
    /// The score of each condition, JOD; their mean is 0.
    pub jod: Vec<Estimate>,
    /// How far each condition is below the best one, JOD.
    pub below_best_jod: Vec<Estimate>,
    /// The score of each condition by the model of Bradley and Terry, natural logarithm of odds; their mean is 0.
    pub log_odds: Vec<Estimate>,
}

/// The scales of an experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Scales {
    /// The scale of the choices on all scenes.
    pub all: Result<ScaledConditions, ScaleError>,
    /// The scale of each scene.
    pub scenes: Vec<Result<ScaledConditions, ScaleError>>,
    /// What the intervals describe.
    pub basis: IntervalBasis,
    /// For each resample the scores of each scene, JOD; empty where a resample has no scale.
    resamples: Vec<Vec<Vec<f64>>>,
    observers: usize,
}

/// Scales the choices of observers between `conditions`, the same in every scene. Intervals are percentiles over resampled observers, or
/// with fewer than [`LEAST_GROUPS`] observers those of the Fisher information.
#[must_use]
pub fn scale(observers: &[&ObserverChoices], conditions: usize, seed: u64) -> Scales {
    let scene_count = observers.iter().map(|o| o.scenes.len()).max().unwrap_or_default();
    let resamples = ObserverResamples::new(observers.len(), RESAMPLES, seed);
    let basis = if resamples.is_some() { IntervalBasis::Observers } else { IntervalBasis::Answers };
    let times: Vec<&[u32]> = resamples.iter().flat_map(ObserverResamples::iter).collect();
    let all_scenes: Vec<usize> = (0..scene_count).collect();
    let (all, _) = scaled(observers, conditions, &all_scenes, &times);
    let mut scenes = Vec::with_capacity(scene_count);
    let mut by_scene = Vec::with_capacity(scene_count);
    for scene in all_scenes {
        let (found, scores) = scaled(observers, conditions, &[scene], &times);
        scenes.push(found);
        by_scene.push(scores);
    }
    let resamples =
        (0..times.len()).map(|r| by_scene.iter().map(|s| s.get(r).cloned().unwrap_or_default()).collect());
    Scales { all, scenes, basis, resamples: resamples.collect(), observers: observers.len() }
}

/// The sum of the choices of observers on scenes, each observer counted a number of times.
fn summed(
    observers: &[&ObserverChoices],
    conditions: usize,
    scenes: &[usize],
    times: impl Fn(usize) -> u32,
) -> Counts {
    let mut sum = Counts::new(conditions);
    for (number, observer) in observers.iter().enumerate() {
        let times = f64::from(times(number));
        scenes.iter().filter_map(|&s| observer.scenes.get(s)).for_each(|counts| sum.merge(counts, times));
    }
    sum
}

/// The scale of the choices on scenes, and the scores of each resample, JOD.
fn scaled(
    observers: &[&ObserverChoices],
    conditions: usize,
    scenes: &[usize],
    times: &[&[u32]],
) -> (Result<ScaledConditions, ScaleError>, Vec<Vec<f64>>) {
    let counts = summed(observers, conditions, scenes, |_| 1);
    let fits = |counts: &Counts| -> Result<[Scale; 2], ScaleError> {
        Ok([
            fit(counts, Model::ThurstoneCaseV, Penalty::Jeffreys)?,
            fit(counts, Model::BradleyTerry, Penalty::Jeffreys)?,
        ])
    };
    let [jod, odds] = match fits(&counts) {
        Ok(fits) => fits,
        Err(error) => return (Err(error), Vec::new()),
    };
    let best = (0..conditions).max_by(|&a, &b| jod.scores[a].total_cmp(&jod.scores[b])).unwrap_or_default();
    let refit = |times: &&[u32]| -> Option<[Vec<f64>; 2]> {
        let counts = summed(observers, conditions, scenes, |o| times.get(o).copied().unwrap_or_default());
        let of = |model, from: &Scale| fit_from(&counts, model, Penalty::Jeffreys, &from.scores).ok();
        Some([of(Model::ThurstoneCaseV, &jod)?.scores, of(Model::BradleyTerry, &odds)?.scores])
    };
    let refits: Vec<Option<[Vec<f64>; 2]>> = times.par_iter().map(refit).collect();
    let estimate = |value: f64, error: f64, of: &dyn Fn(&[Vec<f64>; 2]) -> f64| {
        let interval = match times.is_empty() {
            true => Some(Interval { low: value - NORMAL * error, high: value + NORMAL * error }),
            // Resamples without a scale would lie outside any interval. With more than one in forty the ends are among them.
            false => {
                let values: Vec<f64> = refits.iter().flatten().map(of).collect();
                let is_known = values.len() * 40 >= refits.len() * 39;
                is_known.then(|| percentiles(values, observers.len())).flatten()
            }
        };
        Estimate { value, interval }
    };
    let variance = |scale: &Scale, i: usize| scale.covariance[i * conditions + i].max(0.0).sqrt();
    let found = ScaledConditions {
        jod: (0..conditions).map(|i| estimate(jod.scores[i], variance(&jod, i), &|r| r[0][i])).collect(),
        below_best_jod: (0..conditions)
            .map(|i| {
                let error = jod.standard_error(best, i);
                estimate(jod.scores[best] - jod.scores[i], error, &|r| r[0][best] - r[0][i])
            })
            .collect(),
        log_odds: (0..conditions)
            .map(|i| estimate(odds.scores[i], variance(&odds, i), &|r| r[1][i]))
            .collect(),
    };
    let scores = refits.into_iter().map(|r| r.map(|[jod, _]| jod).unwrap_or_default()).collect();
    (Ok(found), scores)
}

/// How well a metric predicts the choices.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// Spearman's rank correlation with the scores, its mean over the scenes.
    pub spearman: Estimate,
    /// Kendall's τ-b, its mean over the scenes.
    pub kendall: Estimate,
    /// The number of scenes that have both.
    pub scenes: usize,
}

impl Scales {
    /// The agreement with a metric: `values` has for each scene a value per condition, of which larger ones are better. Scores of
    /// different scenes are not comparable, so that the correlations are those of each scene. The intervals resample observers, and from
    /// [`LEAST_GROUPS`] scenes on also scenes. `None` where no scene has a correlation.
    #[must_use]
    pub fn agreement(&self, values: &[Vec<f64>], seed: u64) -> Option<Agreement> {
        let score = |scene: &ScaledConditions| -> Vec<f64> { scene.jod.iter().map(|e| e.value).collect() };
        let scores: Vec<Vec<f64>> =
            self.scenes.iter().map(|s| s.as_ref().map(score).unwrap_or_default()).collect();
        let scenes: Vec<usize> = (0..scores.len()).collect();
        let [spearman, kendall] = correlations(&scores, values, &scenes)?;
        let of_resample = |(number, scores): (usize, &Vec<Vec<f64>>)| {
            let mut random = Stream::new(seed, PURPOSE, number as u32);
            let count = scenes.len();
            let drawn: Vec<usize> = match count < LEAST_GROUPS {
                true => scenes.clone(),
                false => (0..count).map(|_| random.below(count as u32) as usize).collect(),
            };
            correlations(scores, values, &drawn)
        };
        let resampled: Vec<[f64; 2]> = self.resamples.iter().enumerate().filter_map(of_resample).collect();
        let groups =
            if scenes.len() < LEAST_GROUPS { self.observers } else { self.observers.min(scenes.len()) };
        let estimate = |value: f64, which: usize| {
            // Resamples without any correlation, whose scores or metric are all equal, are rare.
            let known = !self.resamples.is_empty() && resampled.len() * 40 >= self.resamples.len() * 39;
            let values = || resampled.iter().map(|r| r[which]).collect();
            Estimate { value, interval: known.then(|| percentiles(values(), groups)).flatten() }
        };
        let has_both = |scene: &usize| correlations(&scores, values, &[*scene]).is_some();
        Some(Agreement {
            spearman: estimate(spearman, 0),
            kendall: estimate(kendall, 1),
            scenes: scenes.iter().filter(|scene| has_both(scene)).count(),
        })
    }
}

/// The means over scenes of Spearman's and Kendall's correlation.
fn correlations(scores: &[Vec<f64>], values: &[Vec<f64>], scenes: &[usize]) -> Option<[f64; 2]> {
    let of = |&scene: &usize| {
        let (scores, values) = (scores.get(scene)?, values.get(scene)?);
        Some([spearman_rho(scores, values)?, kendall_tau_b(scores, values)?])
    };
    let found: Vec<[f64; 2]> = scenes.iter().filter_map(of).collect();
    let mean = |which: usize| found.iter().map(|f| f[which]).sum::<f64>() / found.len() as f64;
    (!found.is_empty()).then(|| [mean(0), mean(1)])
}
