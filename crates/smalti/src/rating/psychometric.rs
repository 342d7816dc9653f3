//! Psychometric functions: the share of choices for a stimulus against its level, and the level of equality.
//!
//! The function is λ + (1 − 2 λ) Φ((x − e) / s) with the point of subjective equality e, the spread s and the share λ of lapses, which
//! go either way ([wichmann2001]). All three are estimated by maximum likelihood, with λ up to [`MAX_LAPSE`].
//!
//! [wichmann2001]: https://doi.org/10.3758/BF03194544

use rayon::prelude::*;
use serde::Serialize;

use super::intervals::{IntervalBasis, ObserverResamples, percentiles};
use super::model::{normal_cdf, normal_density};
use crate::numeric::bootstrap::{Estimate, Interval};
use crate::numeric::philox::Stream;

/// The largest share of lapses. Beyond it, lapses and a shallow function cannot be told apart.
pub const MAX_LAPSE: f64 = 0.05;
/// The shares of lapses that are tried.
const LAPSES: usize = 6;
/// Resamples of an interval.
const RESAMPLES: usize = 1000;
/// Separates these random numbers from others of the same seed.
const PURPOSE: u32 = 0x7073_7963;

/// The choices at a level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Level {
    /// The level, such as stops of light.
    pub level: f64,
    /// Choices for the stimulus whose level varies.
    pub chosen: f64,
    /// All choices.
    pub asked: f64,
}

/// A psychometric function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Psychometric {
    /// The level at which both stimuli are chosen equally often.
    pub equality: f64,
    /// The standard deviation of the normal distribution, in the unit of the level.
    pub spread: f64,
    /// The share of lapses.
    pub lapse: f64,
}

impl Psychometric {
    /// The probability that the stimulus is chosen at a level.
    #[must_use]
    pub fn probability(&self, level: f64) -> f64 {
        self.lapse + (1.0 - 2.0 * self.lapse) * normal_cdf((level - self.equality) / self.spread)
    }

    /// The function under which choices are the most likely. `None` if the share of choices does not rise with the level, or with
    /// fewer than two levels.
    #[must_use]
    pub fn fit(levels: &[Level]) -> Option<Self> {
        let lapse = |i: usize| MAX_LAPSE * i as f64 / (LAPSES - 1) as f64;
        let fits = (0..LAPSES).filter_map(|i| of_lapse(levels, lapse(i)));
        fits.reduce(|best, next| if next.1 > best.1 + 1e-9 { next } else { best }).map(|(f, _)| f)
    }

    /// Twice the difference between the log-likelihood of the shares themselves and that of the function. With a good fit it is near
    /// the number of levels less two.
    #[must_use]
    pub fn deviance(&self, levels: &[Level]) -> f64 {
        let part = |k: f64, p: f64, n: f64| if k > 0.0 { k * libm::log(k / n / p) } else { 0.0 };
        let of = |l: &Level| {
            let p = self.probability(l.level).clamp(1e-12, 1.0 - 1e-12);
            part(l.chosen, p, l.asked) + part(l.asked - l.chosen, 1.0 - p, l.asked)
        };
        2.0 * levels.iter().filter(|l| l.asked > 0.0).map(of).sum::<f64>()
    }
}

/// The function for a share of lapses with its log-likelihood: probit regression by Fisher's scoring.
fn of_lapse(levels: &[Level], lapse: f64) -> Option<(Psychometric, f64)> {
    let asked = || levels.iter().filter(|l| l.asked > 0.0);
    let (low, high) =
        asked().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), l| (a.min(l.level), b.max(l.level)));
    let range = high - low;
    if !(range > 0.0 && range.is_finite()) {
        return None;
    }
    let middle = 0.5 * (low + high);
    // The steepest function that is told from a step: its spread is a fiftieth of the range.
    let steepest = 50.0 / range;
    let log_likelihood = |a: f64, b: f64| -> f64 {
        let of = |l: &Level| {
            let p = lapse + (1.0 - 2.0 * lapse) * normal_cdf(a + b * (l.level - middle));
            let p = p.clamp(1e-12, 1.0 - 1e-12);
            l.chosen * libm::log(p) + (l.asked - l.chosen) * libm::log(1.0 - p)
        };
        asked().map(of).sum()
    };
    let (mut a, mut b) = (0.0, 2.0 / range);
    let mut best = log_likelihood(a, b);
    for _ in 0..100 {
        let (mut g, mut h) = ([0.0; 2], [0.0; 3]);
        for l in asked() {
            let x = l.level - middle;
            let eta = a + b * x;
            let p = (lapse + (1.0 - 2.0 * lapse) * normal_cdf(eta)).clamp(1e-12, 1.0 - 1e-12);
            let slope = (1.0 - 2.0 * lapse) * normal_density(eta);
            let score = slope * (l.chosen - l.asked * p) / (p * (1.0 - p));
            let weight = l.asked * slope * slope / (p * (1.0 - p));
            g = [g[0] + score, g[1] + score * x];
            h = [h[0] + weight, h[1] + weight * x, h[2] + weight * x * x];
        }
        // Levenberg's term keeps the step finite where all choices are decided.
        let damped = [h[0] * (1.0 + 1e-9) + 1e-9, h[1], h[2] * (1.0 + 1e-9) + 1e-9];
        let determinant = damped[0] * damped[2] - damped[1] * damped[1];
        let step = [
            (damped[2] * g[0] - damped[1] * g[1]) / determinant,
            (damped[0] * g[1] - damped[1] * g[0]) / determinant,
        ];
        let (mut share, mut moved) = (1.0, false);
        while share > 1e-8 && !moved {
            let (next_a, next_b) = (a + share * step[0], (b + share * step[1]).min(steepest));
            let next = log_likelihood(next_a, next_b);
            if next >= best - 1e-12 {
                moved = next > best + 1e-10;
                (a, b, best) = (next_a, next_b, next);
                break;
            }
            share *= 0.5;
        }
        if !moved {
            break;
        }
    }
    // Shallower than this over the range, a function is flat.
    let flat = 0.02 / range;
    (b > flat).then(|| (Psychometric { equality: middle - a / b, spread: 1.0 / b, lapse }, best))
}

/// A psychometric function with intervals.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PsychometricFit {
    /// The function.
    pub function: Psychometric,
    /// The point of subjective equality. It has no interval where too many resamples have no function.
    pub equality: Estimate,
    /// The spread.
    pub spread: Estimate,
    /// [`Psychometric::deviance`].
    pub deviance: f64,
    /// What the intervals describe.
    pub basis: IntervalBasis,
    /// Whether the point of equality lies within the levels that were asked.
    pub is_within: bool,
    /// The share of resamples that have a function.
    pub resolved: f64,
}

/// The psychometric function of observers, each with the choices at the same levels, and its intervals: observers are resampled, or,
/// with fewer than five, answers are drawn from the function.
#[must_use]
pub fn equality(observers: &[Vec<Level>], seed: u64) -> Option<PsychometricFit> {
    let all = summed(observers, &vec![1; observers.len()]);
    let function = Psychometric::fit(&all)?;
    let by_observer = ObserverResamples::new(observers.len(), RESAMPLES, seed);
    let basis = if by_observer.is_some() { IntervalBasis::Observers } else { IntervalBasis::Answers };
    let fits: Vec<Option<Psychometric>> = match &by_observer {
        Some(resamples) => {
            let all: Vec<&[u32]> = resamples.iter().collect();
            all.par_iter().map(|times| Psychometric::fit(&summed(observers, times))).collect()
        }
        None => (0..RESAMPLES as u32)
            .into_par_iter()
            .map(|resample| Psychometric::fit(&drawn(&function, &all, seed, resample)))
            .collect(),
    };
    let resolved = fits.iter().flatten().count() as f64 / fits.len() as f64;
    let groups = if by_observer.is_some() { observers.len() } else { 1000 };
    // Resamples without a function would lie outside any interval. With more than one in forty the ends are among them.
    let interval = |of: fn(&Psychometric) -> f64| -> Option<Interval> {
        (resolved >= 0.975).then(|| percentiles(fits.iter().flatten().map(of).collect(), groups)).flatten()
    };
    let levels = all.iter().filter(|l| l.asked > 0.0).map(|l| l.level);
    let (low, high) = levels.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), l| (a.min(l), b.max(l)));
    Some(PsychometricFit {
        function,
        equality: Estimate { value: function.equality, interval: interval(|f| f.equality) },
        spread: Estimate { value: function.spread, interval: interval(|f| f.spread) },
        deviance: function.deviance(&all),
        basis,
        is_within: (low..=high).contains(&function.equality),
        resolved,
    })
}

/// The sums over observers, each counted a number of times.
pub(crate) fn summed(observers: &[Vec<Level>], times: &[u32]) -> Vec<Level> {
    let Some(first) = observers.first() else { return Vec::new() };
    let mut all: Vec<Level> = first.iter().map(|l| Level { chosen: 0.0, asked: 0.0, ..*l }).collect();
    for (own, times) in observers.iter().zip(times) {
        for (sum, level) in all.iter_mut().zip(own) {
            sum.chosen += f64::from(*times) * level.chosen;
            sum.asked += f64::from(*times) * level.asked;
        }
    }
    all
}

/// Choices drawn from a function, as many as were asked.
fn drawn(function: &Psychometric, levels: &[Level], seed: u64, resample: u32) -> Vec<Level> {
    let mut random = Stream::new(seed, PURPOSE, resample);
    let draw = |level: &Level| {
        let p = function.probability(level.level);
        let chosen = (0..level.asked as u64).filter(|_| random.uniform() < p).count() as f64;
        Level { chosen, ..*level }
    };
    levels.iter().map(draw).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: Psychometric = Psychometric { equality: 0.4, spread: 0.6, lapse: 0.02 };
    const STOPS: [f64; 7] = [-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0];

    fn asked(each: f64) -> Vec<Level> {
        STOPS.map(|level| Level { level, chosen: 0.0, asked: each }).to_vec()
    }

    #[test]
    fn exact_shares_give_the_function_back() {
        let exact: Vec<Level> =
            asked(1e6).into_iter().map(|l| Level { chosen: 1e6 * TRUTH.probability(l.level), ..l }).collect();
        let found = Psychometric::fit(&exact).unwrap();
        assert!((found.equality - 0.4).abs() < 1e-4 && (found.spread - 0.6).abs() < 1e-3, "{found:?}");
        assert!((found.lapse - 0.02).abs() < 1e-9 && found.deviance(&exact) < 1.0);
    }

    #[test]
    fn shares_that_do_not_rise_have_no_function() {
        let flat: Vec<Level> = asked(20.0).into_iter().map(|l| Level { chosen: 10.0, ..l }).collect();
        assert_eq!(Psychometric::fit(&flat), None);
        let falling: Vec<Level> = asked(20.0)
            .into_iter()
            .enumerate()
            .map(|(i, l)| Level { chosen: 18.0 - 2.0 * i as f64, ..l })
            .collect();
        assert_eq!(Psychometric::fit(&falling), None);
        assert_eq!(Psychometric::fit(&asked(20.0)[..1]), None);
        assert_eq!(Psychometric::fit(&[]), None);
    }

    /// A step is as steep as can be told, and lies between the levels where the choices change.
    #[test]
    fn a_step_lies_between_its_levels() {
        let step: Vec<Level> = asked(20.0)
            .into_iter()
            .map(|l| Level { chosen: if l.level > 0.2 { 20.0 } else { 0.0 }, ..l })
            .collect();
        let found = Psychometric::fit(&step).unwrap();
        assert!(found.equality > 0.0 && found.equality < 0.5 && found.spread < 0.3, "{found:?}");
    }

    /// The share of 200 experiments whose interval contains the point of equality. Observers differ in it by a standard deviation.
    fn coverage(observers: u32, differ: f64) -> f64 {
        let experiments = 200u32;
        let covered = (0..experiments).into_par_iter().filter(|experiment| {
            let of = |observer: u32| {
                let w = crate::numeric::philox::philox4x32([*experiment, observer, 0, 0], [21, 22]);
                let shift = differ * f64::from(crate::numeric::normal::normal_pair(w[0], w[1]).0);
                let own = Psychometric { equality: TRUTH.equality + shift, ..TRUTH };
                drawn(&own, &asked(10.0), 77, experiment * 100 + observer)
            };
            let fit = equality(&(0..observers).map(of).collect::<Vec<_>>(), u64::from(*experiment)).unwrap();
            fit.equality.interval.is_some_and(|i| i.contains(TRUTH.equality))
        });
        covered.count() as f64 / f64::from(experiments)
    }

    /// Intervals over observers contain the point of equality as often as they state, 95 %. Three standard errors of a share of 0.95
    /// among 200 are 0.046.
    #[test]
    fn intervals_cover_the_point_of_equality_as_often_as_they_state() {
        for (observers, differ) in [(8, 0.2), (2, 0.0)] {
            let covered = coverage(observers, differ);
            assert!((covered - 0.95).abs() < 0.046, "{observers} observers: {covered}");
        }
    }
}
