//! The verdict of a comparison: which camera is better at which light, by how much, and how certainly.
//!
//! Scores are means over scenes and seeds of the noise. A difference of means has a 95 % interval ([`crate::numeric::bootstrap`]),
//! from the paired bootstrap over scenes and seeds, or for fewer than five scenes from Student's distribution. The interval describes
//! other scenes of the same kind, and with a single scene only other seeds. Where it contains 0, these scenes show no difference.
//! A difference below [`smallest_relevant`] counts as none, with or without an interval. Intervals of several comparisons are not
//! corrected for their number; those of a proof are ([`super::prove`]).

mod crossover;
mod equal_quality;

use serde::Serialize;

pub use crossover::Crossover;
pub(super) use equal_quality::QualityAtMoreLight;
pub use equal_quality::{LightStops, MoreLight, StopsInterval};

use super::outcome::Outcome;
use crate::camera::PICTURE_METRICS;
use crate::metrics::{Better, metric_info, smallest_relevant};
pub use crate::numeric::bootstrap::Estimate;
use crate::numeric::bootstrap::{Resamples, mean};
use crossover::{changes, equal_at};

/// The metric whose differences are also stated as light.
pub(super) const LIGHT_METRIC: usize = 0;

/// The difference of a contender from itself.
const NO_DIFFERENCE: Estimate = Estimate { value: 0.0, interval: None };

/// The verdict of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// Number of scenes.
    pub scenes: usize,
    /// Number of seeds of the noise for each scene.
    pub seeds: usize,
    /// For each luminance, in the order of the settings.
    pub lights: Vec<LightVerdict>,
    /// Luminances at which the lead of one of two contenders changes, for each metric and pair.
    pub crossovers: Vec<Crossover>,
}

impl Verdict {
    /// Whether differences have intervals: a single picture has none.
    #[must_use]
    pub fn has_intervals(&self) -> bool {
        self.scenes * self.seeds > 1
    }
}

/// The verdict at one luminance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightVerdict {
    /// Mean luminance of the scenes, cd/m².
    pub luminance_cd_m2: f64,
    /// For each of [`PICTURE_METRICS`].
    pub metrics: Vec<MetricVerdict>,
}

/// The verdict by one metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetricVerdict {
    /// Its name in the catalogue.
    pub metric: &'static str,
    /// The number of the contender with the best mean.
    pub best: usize,
    /// By how much the best contender is better than each contender; 0 for itself.
    pub leads: Vec<Lead>,
    /// The mean of each contender minus that of the first one, in the unit of the metric, so that a difference below 0 is better
    /// where lower figures are; 0 for the first.
    pub from_first: Vec<Estimate>,
}

/// What the difference of two means shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Finding {
    /// The interval contains 0: these scenes show no difference.
    NoDifference,
    /// The difference is smaller than [`smallest_relevant`].
    Negligible,
    /// A lead, with certainty where there is an interval.
    Lead,
}

impl Finding {
    /// What a difference in a metric shows.
    pub(super) fn of(by: &Estimate, metric: &str) -> Self {
        match by.interval {
            Some(interval) if interval.contains(0.0) => Self::NoDifference,
            _ if smallest_relevant(metric).is_relevant(by.value, 0.0) => Self::Lead,
            _ => Self::Negligible,
        }
    }
}

/// The lead of the best contender over another one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lead {
    /// The difference of the means, in the unit of the metric; not negative.
    pub by: Estimate,
    /// What the difference shows.
    pub finding: Finding,
    /// How much more light the other contender needs for the same mean, for CPSNR where the lead has an interval.
    pub light: Option<MoreLight>,
}

impl Lead {
    /// Whether there is no difference, or only a negligible one.
    #[must_use]
    pub fn is_tie(&self) -> bool {
        self.finding != Finding::Lead
    }
}

impl MetricVerdict {
    /// Whether a contender is the best one, or does not differ from it.
    #[must_use]
    pub fn is_among_best(&self, contender: usize) -> bool {
        contender == self.best || self.leads.get(contender).is_some_and(Lead::is_tie)
    }
}

/// Means and their resamples for all contenders in all lights.
pub(super) struct Scores<'a> {
    outcomes: &'a [Vec<Outcome>],
    resamples: Option<Resamples>,
}

impl<'a> Scores<'a> {
    /// `outcomes` are those of each contender, one per luminance, all with the same scenes and seeds.
    pub(super) fn new(outcomes: &'a [Vec<Outcome>], seed: u64) -> Self {
        let mut scores = Self { outcomes, resamples: None };
        let (scenes, seeds) = scores.size();
        // A single picture has no interval.
        scores.resamples = (scenes * seeds > 1).then(|| Resamples::new(scenes, seeds, seed));
        scores
    }

    /// Numbers of scenes and seeds.
    fn size(&self) -> (usize, usize) {
        let scenes = self.outcomes.first().and_then(|o| o.first()).map_or(&[][..], |o| &o.scenes);
        (scenes.len(), scenes.first().map_or(0, |(_, s)| s.by_seed.len()))
    }

    /// The intervals of means over the pictures; `None` for a single picture.
    pub(super) fn resamples(&self) -> Option<&Resamples> {
        self.resamples.as_ref()
    }

    /// The figures of a contender, better ones larger.
    fn figures(&self, contender: usize, light: usize, metric: usize) -> Vec<f64> {
        let sign = sign(metric);
        let outcome = self.outcomes.get(contender).and_then(|o| o.get(light));
        outcome.map_or_else(Vec::new, |o| o.figures(metric).iter().map(|v| sign * v).collect())
    }

    /// The verdict by a metric in one light, without leads in light.
    pub(super) fn by_metric(&self, light: usize, metric: usize) -> MetricVerdict {
        let all: Vec<Vec<f64>> =
            (0..self.outcomes.len()).map(|contender| self.figures(contender, light, metric)).collect();
        let means: Vec<f64> = all.iter().map(|figures| mean(figures)).collect();
        let best = (0..all.len()).max_by(|a, b| means[*a].total_cmp(&means[*b]).then(b.cmp(a))).unwrap_or(0);
        let resamples = self.resamples.as_ref();
        let lead = |contender: usize| {
            let by = if contender == best {
                NO_DIFFERENCE
            } else {
                Estimate::of_difference(&all[best], &all[contender], resamples)
            };
            let finding = match by.value {
                0.0 => Finding::NoDifference,
                _ => Finding::of(&by, PICTURE_METRICS[metric]),
            };
            Lead { by, finding, light: None }
        };
        // Figures are better where they are larger; differences keep the sign of the metric.
        let plain = |contender: usize| match (contender, sign(metric) > 0.0) {
            (0, _) => NO_DIFFERENCE,
            (_, true) => Estimate::of_difference(&all[contender], &all[0], resamples),
            (_, false) => Estimate::of_difference(&all[0], &all[contender], resamples),
        };
        MetricVerdict {
            metric: PICTURE_METRICS[metric],
            best,
            leads: (0..all.len()).map(lead).collect(),
            from_first: (0..all.len()).map(plain).collect(),
        }
    }

    /// The whole verdict. `more_light` measures [`LIGHT_METRIC`] of a contender (first) with more light (third), to equal another one
    /// (second).
    ///
    /// # Errors
    /// Those of `more_light`.
    pub(super) fn verdict<E>(
        &self,
        luminances_cd_m2: &[f64],
        mut more_light: impl FnMut(usize, usize, usize) -> Result<QualityAtMoreLight<'a>, E>,
    ) -> Result<Verdict, E> {
        let (scenes, seeds) = self.size();
        let mut lights = Vec::with_capacity(luminances_cd_m2.len());
        for (light, &luminance_cd_m2) in luminances_cd_m2.iter().enumerate() {
            let mut metrics: Vec<MetricVerdict> =
                (0..PICTURE_METRICS.len()).map(|metric| self.by_metric(light, metric)).collect();
            let by_light = &mut metrics[LIGHT_METRIC];
            let best = by_light.best;
            for (contender, lead) in by_light.leads.iter_mut().enumerate() {
                if !lead.is_tie() && lead.by.interval.is_some() {
                    lead.light = Some(more_light(contender, best, light)?.more_light());
                }
            }
            lights.push(LightVerdict { luminance_cd_m2, metrics });
        }
        let crossovers = self.crossovers(&lights);
        Ok(Verdict { scenes, seeds, lights, crossovers })
    }
}

impl Scores<'_> {
    /// The crossovers of all pairs of contenders. Lights in which neither leads lie within. Differences without intervals, those of single
    /// pictures, prove none.
    fn crossovers(&self, lights: &[LightVerdict]) -> Vec<Crossover> {
        if self.resamples.is_none() {
            return Vec::new();
        }
        let mut order: Vec<usize> = (0..lights.len()).collect();
        order.sort_by(|a, b| lights[*a].luminance_cd_m2.total_cmp(&lights[*b].luminance_cd_m2));
        let cd_m2: Vec<f64> = order.iter().map(|light| lights[*light].luminance_cd_m2).collect();
        let contenders = self.outcomes.len();
        let mut found = Vec::new();
        for (metric, name) in PICTURE_METRICS.into_iter().enumerate() {
            // Figures of each contender, light by light.
            let figures: Vec<Vec<Vec<f64>>> = (0..contenders)
                .map(|contender| order.iter().map(|light| self.figures(contender, *light, metric)).collect())
                .collect();
            for (first, second) in (0..contenders).flat_map(|a| (a + 1..contenders).map(move |b| (a, b))) {
                let lead = |place: usize| {
                    let (a, b) = (&figures[first][place], &figures[second][place]);
                    let by = Estimate::of_difference(a, b, self.resamples.as_ref());
                    (Finding::of(&by, name) == Finding::Lead).then_some(by.value)
                };
                let leads: Vec<Option<f64>> = (0..order.len()).map(lead).collect();
                for [dim, bright] in changes(&leads) {
                    let is_first = leads[dim].is_some_and(|lead| lead > 0.0);
                    let (below, above) = if is_first { (first, second) } else { (second, first) };
                    let lead = |place: usize| {
                        let (a, b) = (&figures[above][place], &figures[below][place]);
                        (cd_m2[place], a.iter().zip(b).map(|(a, b)| a - b).collect())
                    };
                    let is_best =
                        |place: usize, who: usize| lights[order[place]].metrics[metric].is_among_best(who);
                    found.push(Crossover {
                        metric: name,
                        below,
                        above,
                        interpolated_cd_m2: equal_at((dim..=bright).map(lead)),
                        between_cd_m2: [dim, bright].map(|place| cd_m2[place]),
                        is_of_best: is_best(dim, below) && is_best(bright, above),
                    });
                }
            }
        }
        found
    }
}

/// 1 for a metric where higher is better, −1 for the others.
pub(super) fn sign(metric: usize) -> f64 {
    let info = PICTURE_METRICS.get(metric).and_then(|name| metric_info(name).ok());
    if info.is_some_and(|m| m.better == Better::Higher) { 1.0 } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::bootstrap::Interval;

    /// Scenes that differ by 40 dB, of which a second camera sees each 1 dB better, but for ±0.2 dB of noise.
    #[test]
    fn a_difference_is_paired_and_has_a_sign() {
        let first: Vec<f64> = (0..18).map(|i| 20.0 + 8.0 * f64::from(i / 3)).collect();
        let other: Vec<f64> =
            (0u32..18).map(|i| first[i as usize] + 1.0 + 0.2 * (f64::from(i * 7 % 5) - 2.0) / 2.0).collect();
        let resamples = Resamples::new(6, 3, 1);
        let ahead = Estimate::of_difference(&other, &first, Some(&resamples));
        let behind = Estimate::of_difference(&first, &other, Some(&resamples));
        let (up, down) = (ahead.interval.unwrap(), behind.interval.unwrap());
        assert!((ahead.value - mean(&other) + mean(&first)).abs() < 1e-12);
        assert!(up.contains(ahead.value) && up.low > 0.8 && up.high < 1.2, "{up:?}");
        assert!((ahead.value + behind.value).abs() < 1e-12);
        assert!((up.low + down.high).abs() < 1e-12 && (up.high + down.low).abs() < 1e-12);
        assert_eq!(Estimate::of_difference(&first, &other, None).interval, None);
    }

    /// "b3 leads bayer by 0.00 dB [0.00, 0.01]" is no lead.
    #[test]
    fn a_certain_difference_may_be_negligible() {
        let by = |value: f64, interval: Option<[f64; 2]>| {
            let interval = interval.map(|[low, high]| Interval { low, high });
            Finding::of(&Estimate { value, interval }, "cpsnr_db")
        };
        assert_eq!(by(0.004, Some([0.001, 0.01])), Finding::Negligible);
        assert_eq!(by(0.4, Some([-0.1, 0.9])), Finding::NoDifference);
        assert_eq!(by(0.4, Some([0.1, 0.7])), Finding::Lead);
        // A single picture.
        assert_eq!((by(0.01, None), by(0.4, None)), (Finding::Negligible, Finding::Lead));
    }
}
