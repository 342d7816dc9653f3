//! Confidence intervals of means over groups ([efron1993], [hesterberg2015]).
//!
//! Scores come in groups (scenes) with several members each (seeds of the noise). Differences between quantities that were scored
//! on the same members are paired.
//!
//! From [`LEAST_GROUPS`] groups on, the interval is that of the bootstrap. A resample draws as many groups as there are, with
//! replacement, and within each of them as many members as it has. With few groups the percentiles of resampled means are too
//! narrow. The interval therefore takes wider percentiles (Hesterberg's expanded percentile interval): the tail probability is
//! Φ(−t √(n / (n − 1))) for n groups, with the quantile t of Student's distribution of n − 1 degrees of freedom.
//!
//! Fewer groups have too few distinct resamples. Their interval is that of Student's distribution for the means of the groups, and
//! with a single group for its members, which then describes further members of this group only.
//!
//! [efron1993]: https://doi.org/10.1201/9780429246593
//! [hesterberg2015]: https://doi.org/10.1080/00031305.2015.1089789

use super::philox::Stream;

/// The smallest number of groups that is resampled.
pub const LEAST_GROUPS: usize = 5;
/// Number of resamples.
const RESAMPLES: usize = 4000;
/// Separates these random numbers from others of the same seed.
const PURPOSE: u32 = 0x626f_6f74;
/// The 0.975 quantiles of Student's distribution of 1 to 12 degrees of freedom (ISO 3534-1, rounded to three decimals).
const STUDENT: [f64; 12] =
    [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179];
/// The 0.975 quantile of the normal distribution.
const NORMAL: f64 = 1.959_964;

/// The confidence of the intervals.
pub const CONFIDENCE: f64 = 0.95;

/// An interval of [`CONFIDENCE`].
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Whether a value lies within the interval or on its ends.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

/// A quantity with its interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// The quantity.
    pub value: f64,
    /// Its interval; `None` where it rests on one value or is not defined.
    pub interval: Option<Interval>,
}

impl Estimate {
    /// The mean of the values of all members.
    #[must_use]
    pub fn of_mean(values: &[f64], resamples: Option<&Resamples>) -> Self {
        Self { value: mean(values), interval: resamples.and_then(|r| r.interval(values)) }
    }

    /// The mean difference of values of the same members, `a − b`.
    #[must_use]
    pub fn of_difference(a: &[f64], b: &[f64], resamples: Option<&Resamples>) -> Self {
        let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        Self::of_mean(&differences, resamples)
    }
}

/// The mean of values; 0 without any.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The resamples of groups of members, as the weights of the members in each; the weights of a resample sum to 1. Fewer than
/// [`LEAST_GROUPS`] groups have none.
#[derive(Debug, Clone, PartialEq)]
pub struct Resamples {
    pub(super) groups: usize,
    pub(super) members: usize,
    pub(super) weights: Vec<f64>,
}

impl Resamples {
    /// Resamples of `groups` × `members`, at least one each. Equal arguments give equal resamples.
    #[must_use]
    pub fn new(groups: usize, members: usize, seed: u64) -> Self {
        let (groups, members) = (groups.max(1), members.max(1));
        if groups < LEAST_GROUPS {
            return Self { groups, members, weights: Vec::new() };
        }
        let each = 1.0 / (groups * members) as f64;
        let mut weights = vec![0.0; RESAMPLES * groups * members];
        for (resample, weights) in weights.chunks_exact_mut(groups * members).enumerate() {
            let mut random = Stream::new(seed, PURPOSE, resample as u32);
            for _ in 0..groups {
                let group = random.below(groups as u32) as usize;
                for _ in 0..members {
                    weights[group * members + random.below(members as u32) as usize] += each;
                }
            }
        }
        Self { groups, members, weights }
    }

    /// The interval of the mean of the values of all members, group by group. `None` for a single value, a number of values that is
    /// not that of the members, and values that are not finite.
    #[must_use]
    pub fn interval(&self, values: &[f64]) -> Option<Interval> {
        let count = self.groups * self.members;
        if values.len() != count || !values.iter().all(|v| v.is_finite()) {
            return None;
        }
        match self.groups {
            1 => by_student(values),
            few if few < LEAST_GROUPS => {
                by_student(&values.chunks_exact(self.members).map(mean).collect::<Vec<_>>())
            }
            groups => {
                let resamples = self.weights.chunks_exact(count);
                let mut means: Vec<f64> = resamples.map(|weights| weighted(weights, values)).collect();
                means.sort_unstable_by(f64::total_cmp);
                let last = means.len().checked_sub(1)?;
                let tail = (tail_probability(groups) * last as f64).floor() as usize;
                Some(Interval { low: means[tail], high: means[last - tail] })
            }
        }
    }
}

/// The weighted sum of values, which is their mean where the weights sum to 1.
fn weighted(weights: &[f64], values: &[f64]) -> f64 {
    weights.iter().zip(values).map(|(w, v)| w * v).sum()
}

/// The interval of the mean of normal values; `None` for fewer than two.
fn by_student(values: &[f64]) -> Option<Interval> {
    let freedom = values.len().checked_sub(1).filter(|n| *n > 0)?;
    let mean = mean(values);
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    let half = student(freedom) * (squares / (freedom * values.len()) as f64).sqrt();
    Some(Interval { low: mean - half, high: mean + half })
}

/// The share of resamples below the interval, and above it.
pub(crate) fn tail_probability(groups: usize) -> f64 {
    let n = groups as f64;
    0.5 * libm::erfc(student(groups - 1) * (n / (n - 1.0)).sqrt() / std::f64::consts::SQRT_2)
}

/// The 0.975 quantile of Student's distribution; beyond the table, the expansion of Fisher and Cornish (1960).
fn student(freedom: usize) -> f64 {
    STUDENT.get(freedom - 1).copied().unwrap_or_else(|| {
        let (z, n) = (NORMAL, freedom as f64);
        z + (z.powi(3) + z) / (4.0 * n) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::normal::normal_pair;
    use crate::numeric::philox::philox4x32;

    #[test]
    fn weights_sum_to_one_and_depend_on_the_seed_alone() {
        let r = Resamples::new(6, 3, 1);
        assert!(r.weights.chunks_exact(18).all(|w| (w.iter().sum::<f64>() - 1.0).abs() < 1e-12));
        assert_eq!(r, Resamples::new(6, 3, 1));
        assert_ne!(r, Resamples::new(6, 3, 2));
    }

    #[test]
    fn equal_values_have_an_interval_of_no_width() {
        for groups in 1..7 {
            let interval = Resamples::new(groups, 3, 1).interval(&vec![2.0; 3 * groups]).unwrap();
            assert!((interval.low - 2.0).abs() < 1e-12 && (interval.high - 2.0).abs() < 1e-12, "{groups}");
        }
        assert_eq!(Resamples::new(5, 3, 1).interval(&[f64::NAN; 15]), None);
        assert_eq!(Resamples::new(1, 1, 1).interval(&[2.0]), None);
        assert_eq!(Resamples::new(2, 3, 1).interval(&[2.0]), None);
    }

    /// Two differences d₁ and d₂: their mean ± 12.706 |d₁ − d₂| / 2.
    #[test]
    fn the_interval_of_two_scenes_is_that_of_student() {
        let interval = Resamples::new(2, 2, 1).interval(&[0.9, 1.1, 1.9, 2.1]).unwrap();
        assert!((interval.low - (1.5 - 6.353)).abs() < 1e-9 && (interval.high - (1.5 + 6.353)).abs() < 1e-9);
    }

    /// The expansion joins the table, and the table is that of the distribution for 1, 2 and 4 degrees of freedom, which have
    /// closed forms.
    #[test]
    fn quantiles_of_student() {
        let expansion = |n: f64| {
            let z = NORMAL;
            z + (z.powi(3) + z) / (4.0 * n) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
        };
        assert!((expansion(12.0) - STUDENT[11]).abs() < 2e-3);
        assert!((student(30) - 2.042).abs() < 1e-3);
        assert!((student(1) - (0.475 * std::f64::consts::PI).tan()).abs() < 1e-3);
        assert!((student(2) - 0.95 * (2.0f64 / (1.0 - 0.95 * 0.95)).sqrt()).abs() < 1e-3);
    }

    /// The share of experiments whose interval contains the true mean. Scenes differ with a standard deviation of 1, and `noise`
    /// is that of their seeds. With a single scene the mean is that of the scene.
    fn coverage(groups: usize, members: usize, noise: f64) -> f64 {
        let experiments = 400u32;
        let covers = |e: &u32| {
            let (mut values, mut truth) = (Vec::new(), 0.0);
            for g in 0..groups as u32 {
                let w = philox4x32([*e, g, groups as u32, 0], [11, 12]);
                let scene = f64::from(normal_pair(w[0], w[1]).0);
                if groups == 1 {
                    truth = scene;
                }
                for m in 0..members as u32 {
                    let w = philox4x32([*e, g, groups as u32, 1 + m], [11, 12]);
                    values.push(scene + noise * f64::from(normal_pair(w[0], w[1]).0));
                }
            }
            Resamples::new(groups, members, u64::from(*e)).interval(&values).unwrap().contains(truth)
        };
        (0..experiments).filter(covers).count() as f64 / f64::from(experiments)
    }

    /// In 95 of 100 experiments with normal scores the interval contains the true mean, with any number of scenes and seeds.
    #[test]
    fn intervals_cover_the_mean_as_often_as_they_state() {
        let sizes = [(1, 2), (1, 3), (2, 1), (2, 3), (3, 1), (3, 3), (4, 1), (4, 3), (5, 3), (12, 3)];
        for (groups, members) in sizes {
            for noise in [0.2, 1.0] {
                let covered = coverage(groups, members, noise);
                // Four standard errors of a share of 0.95 in 400 are 0.044. Resampling members as well as groups makes the interval of
                // the bootstrap wider than stated where the noise of the seeds is large.
                let most = if groups < LEAST_GROUPS { 0.044 } else { 0.05 };
                let error = covered - CONFIDENCE;
                assert!(error > -0.044 && error < most, "{groups} × {members}, noise {noise}: {covered}");
            }
        }
    }
}
