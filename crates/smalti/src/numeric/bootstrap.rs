//! Confidence intervals of means over groups by the paired bootstrap ([efron1993], [hesterberg2015]).
//!
//! Scores come in groups (scenes) with several members each (seeds of the noise). A resample draws as many groups as there are,
//! with replacement, and within each of them as many members as it has. Every statistic uses the same resamples, so differences
//! between quantities that were scored on the same members are paired.
//!
//! With few groups the percentiles of resampled means are too narrow. The interval therefore takes wider percentiles
//! (Hesterberg's expanded percentile interval): the tail probability is Φ(−t √(n / (n − 1))) for n groups, with the quantile t of
//! Student's distribution of n − 1 degrees of freedom.
//!
//! [efron1993]: https://doi.org/10.1201/9780429246593
//! [hesterberg2015]: https://doi.org/10.1080/00031305.2015.1089789

use super::philox::Stream;

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
    /// Its interval; `None` where it rests on one value, or is not defined for most resamples.
    pub interval: Option<Interval>,
}

impl Estimate {
    /// The mean difference of values of the same members, `a − b`.
    #[must_use]
    pub fn of_difference(a: &[f64], b: &[f64], resamples: Option<&Resamples>) -> Self {
        let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        let interval = resamples.and_then(|r| r.interval(|weights| weighted(weights, &differences)));
        Self { value: mean(&differences), interval }
    }
}

/// The mean of values; 0 without any.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The resamples of groups of members, as the weights of the members in each; the weights of a resample sum to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Resamples {
    groups: usize,
    members: usize,
    weights: Vec<f64>,
}

impl Resamples {
    /// Resamples of `groups` × `members`, at least one each. Equal arguments give equal resamples.
    #[must_use]
    pub fn new(groups: usize, members: usize, seed: u64) -> Self {
        let (groups, members) = (groups.max(1), members.max(1));
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

    /// The interval of a statistic, a function of the weights of all members, group by group. Resamples without a value (NaN)
    /// are left out; `None` if fewer than half of them have one.
    pub fn interval(&self, statistic: impl Fn(&[f64]) -> f64) -> Option<Interval> {
        let resamples = self.weights.chunks_exact(self.groups * self.members);
        let mut values: Vec<f64> = resamples.map(statistic).filter(|v| !v.is_nan()).collect();
        if 2 * values.len() < RESAMPLES {
            return None;
        }
        values.sort_unstable_by(f64::total_cmp);
        let last = values.len() - 1;
        let tail = (tail_probability(self.groups) * last as f64).floor() as usize;
        Some(Interval { low: values[tail], high: values[last - tail] })
    }
}

/// The weighted sum of values, which is their mean where the weights sum to 1.
#[must_use]
pub fn weighted(weights: &[f64], values: &[f64]) -> f64 {
    weights.iter().zip(values).map(|(w, v)| w * v).sum()
}

/// The share of resamples below the interval, and above it. With one group only its members vary, and the usual share applies.
fn tail_probability(groups: usize) -> f64 {
    let z = match groups {
        0 | 1 => NORMAL,
        n => student(n - 1) * (n as f64 / (n - 1) as f64).sqrt(),
    };
    0.5 * libm::erfc(z / std::f64::consts::SQRT_2)
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
        let interval = Resamples::new(5, 3, 1).interval(|w| weighted(w, &[2.0; 15])).unwrap();
        assert!((interval.low - 2.0).abs() < 1e-12 && (interval.high - 2.0).abs() < 1e-12);
        assert_eq!(Resamples::new(5, 3, 1).interval(|_| f64::NAN), None);
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

    /// In 95 of 100 experiments with normal scores the interval contains the true mean, also with few groups.
    #[test]
    fn intervals_cover_the_mean_as_often_as_they_state() {
        for groups in [5usize, 12] {
            let (experiments, members) = (400u32, 3usize);
            let covers = |e: &u32| {
                let mut values = Vec::new();
                for g in 0..groups as u32 {
                    let w = philox4x32([*e, g, groups as u32, 0], [11, 12]);
                    let scene = f64::from(normal_pair(w[0], w[1]).0);
                    for m in 0..members as u32 {
                        let w = philox4x32([*e, g, groups as u32, 1 + m], [11, 12]);
                        values.push(scene + 0.2 * f64::from(normal_pair(w[0], w[1]).0));
                    }
                }
                let interval =
                    Resamples::new(groups, members, u64::from(*e)).interval(|w| weighted(w, &values));
                interval.unwrap().contains(0.0)
            };
            let covered = (0..experiments).filter(covers).count() as f64 / f64::from(experiments);
            // Four standard errors of a share of 0.95 in 400 are 0.044.
            assert!((covered - CONFIDENCE).abs() < 0.044, "{groups} groups: {covered}");
        }
    }
}
