//! Confidence intervals of many means that all hold together.
//!
//! Of 200 intervals of 95 %, about ten miss their mean. The intervals here contain all means of a family with a confidence of 95 %: those
//! of the largest deviation in standard errors ([romano2005], in a single step). The bootstrap draws the deviation of each mean from its
//! value, in standard errors, and the 0.95 quantile of the largest of them is the half width of every interval. All means share the
//! resamples, so that quantities that vary together, such as the scores of similar cameras on the same scenes, widen the intervals
//! less than independent ones. The quantile is widened as that of one mean is ([`Resamples::interval`]): the intervals have the quantile of Student's
//! distribution at the tail probability that the resamples have under a normal one.
//!
//! Fewer than [`LEAST_GROUPS`] groups have no resamples. Their intervals are those of Student's distribution with Bonferroni's bound, which
//! holds for any dependence.
//!
//! [romano2005]: https://doi.org/10.1198/016214504000000539

use rayon::prelude::*;

use super::bootstrap::{CONFIDENCE, Interval, LEAST_GROUPS, Resamples, mean};

/// Halvings of the search for a quantile.
const HALVINGS: usize = 100;

/// A mean with its standard error.
#[derive(Debug, Clone, Copy)]
struct Mean {
    value: f64,
    error: f64,
}

impl Resamples {
    /// Intervals of the means of several quantities, each with the values of all members, group by group, that contain all true means with a
    /// confidence of [`CONFIDENCE`]. `None` for a quantity with a single value, another number of values than there are members, or a value
    /// that is not finite; it does not widen the intervals of the others.
    #[must_use]
    pub fn simultaneous(&self, family: &[Vec<f64>]) -> Vec<Option<Interval>> {
        let usable = |values: &&Vec<f64>| {
            values.len() == self.groups * self.members && values.iter().all(|v| v.is_finite())
        };
        let units = |values: &Vec<f64>| match self.groups {
            1 => values.clone(),
            _ => values.chunks_exact(self.members).map(mean).collect(),
        };
        let means: Vec<Option<Mean>> =
            family.iter().map(|v| Some(v).filter(usable).and_then(|v| Mean::of(&units(v)))).collect();
        let varying =
            || family.iter().zip(&means).filter_map(|(v, m)| Some((v, m.filter(|m| m.error > 0.0)?)));
        let count = varying().count();
        let half_width = if count == 0 {
            0.0
        } else if self.groups < LEAST_GROUPS {
            let freedom = if self.groups == 1 { self.members } else { self.groups } - 1;
            student_quantile((1.0 - CONFIDENCE) / count as f64, freedom)
        } else {
            self.half_width(&varying().collect::<Vec<_>>())
        };
        let around = |m: Mean| {
            // An infinite half width of a mean without error is none.
            let half = if m.error > 0.0 { half_width * m.error } else { 0.0 };
            Interval { low: m.value - half, high: m.value + half }
        };
        means.into_iter().map(|m| m.map(around)).collect()
    }

    /// The half width of the intervals in standard errors.
    fn half_width(&self, family: &[(&Vec<f64>, Mean)]) -> f64 {
        let deviation = |weights: &[f64]| {
            let of = |(values, mean): &(&Vec<f64>, Mean)| {
                let resampled: f64 = weights.iter().zip(*values).map(|(w, v)| w * v).sum();
                (resampled - mean.value).abs() / mean.error
            };
            family.iter().map(of).fold(0.0, f64::max)
        };
        let mut largest: Vec<f64> =
            self.weights.par_chunks_exact(self.groups * self.members).map(deviation).collect();
        largest.sort_unstable_by(f64::total_cmp);
        let n = self.groups as f64;
        let at = (CONFIDENCE * largest.len().saturating_sub(1) as f64).ceil() as usize;
        let quantile = largest.get(at).copied().unwrap_or(f64::INFINITY) * (n / (n - 1.0)).sqrt();
        student_quantile(libm::erfc(quantile / std::f64::consts::SQRT_2), self.groups - 1)
    }
}

impl Mean {
    /// Of independent values, at least two.
    fn of(values: &[f64]) -> Option<Self> {
        let freedom = values.len().checked_sub(1).filter(|n| *n > 0)?;
        let value = mean(values);
        let squares: f64 = values.iter().map(|v| (v - value) * (v - value)).sum();
        Some(Self { value, error: (squares / (freedom * values.len()) as f64).sqrt() })
    }
}

/// The value that Student's t exceeds in magnitude with a probability, by bisection.
fn student_quantile(probability: f64, freedom: usize) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while 1.0 - student_within(high, freedom) > probability && high < 1e15 {
        high *= 2.0;
    }
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        *(if 1.0 - student_within(middle, freedom) > probability { &mut low } else { &mut high }) = middle;
    }
    high
}

/// The probability that Student's t is within ±`t`: [abramowitz1964], 26.7.3 and 26.7.4.
///
/// [abramowitz1964]: https://www.nist.gov/publications/handbook-mathematical-functions-formulas-graphs-and-mathematical-tables
fn student_within(t: f64, freedom: usize) -> f64 {
    let angle = libm::atan(t / (freedom as f64).sqrt());
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let odd = freedom % 2 == 1;
    let (mut term, mut sum, mut power) = if odd { (cos, 0.0, 1) } else { (1.0, 0.0, 0) };
    while power + 2 <= freedom {
        sum += term;
        term *= cos * cos * (power + 1) as f64 / (power + 2) as f64;
        power += 2;
    }
    if odd { 2.0 / std::f64::consts::PI * (angle + sin * sum) } else { sin * sum }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::normal::normal_pair;
    use crate::numeric::philox::philox4x32;

    /// Of the table of Student's distribution: 95 % and 99.9 %.
    #[test]
    fn quantiles_of_student() {
        for (probability, freedom, quantile) in [
            (0.05, 1, 12.706),
            (0.05, 2, 4.303),
            (0.05, 3, 3.182),
            (0.05, 4, 2.776),
            (0.05, 13, 2.160),
            (0.001, 4, 8.610),
            (0.001, 7, 5.408),
            (0.001, 13, 4.221),
        ] {
            let found = student_quantile(probability, freedom);
            assert!((found - quantile).abs() < 6e-4, "{probability}, {freedom}: {found}");
        }
    }

    fn normal(counter: [u32; 4]) -> f64 {
        let w = philox4x32(counter, [21, 22]);
        f64::from(normal_pair(w[0], w[1]).0)
    }

    /// Quantities on the same scenes: half of their variance is common to all.
    fn family(experiment: u32, quantities: u32, [groups, members]: [u32; 2]) -> Vec<Vec<f64>> {
        let of = |k: u32| {
            let value = |g: u32, m: u32| {
                let (common, own) = (normal([experiment, g, 0, 0]), normal([experiment, g, k + 1, 0]));
                common + own + 0.3 * normal([experiment, g, k + 1, m + 1])
            };
            (0..groups).flat_map(|g| (0..members).map(move |m| (g, m))).map(|(g, m)| value(g, m)).collect()
        };
        (0..quantities).map(of).collect()
    }

    /// The shares of experiments in which all intervals contain their means, 0, and in which those for one mean alone do.
    fn coverage(quantities: u32, size: [u32; 2]) -> [f64; 2] {
        let experiments = 400;
        let mut covered = [0; 2];
        for e in 0..experiments {
            let family = family(e, quantities, size);
            let resamples = Resamples::new(size[0] as usize, size[1] as usize, u64::from(e));
            let together = resamples.simultaneous(&family);
            let alone: Vec<_> = family.iter().map(|v| resamples.interval(v)).collect();
            for (covered, all) in covered.iter_mut().zip([together, alone]) {
                *covered += usize::from(all.iter().all(|i| i.is_some_and(|i| i.contains(0.0))));
            }
        }
        covered.map(|c| c as f64 / f64::from(experiments))
    }

    /// In 95 of 100 experiments all intervals of a family contain their means. Intervals for one mean alone do so in far fewer.
    #[test]
    fn families_are_covered_as_often_as_they_state() {
        for (quantities, size) in [(1, [14, 5]), (12, [14, 2]), (40, [14, 1]), (12, [8, 3]), (12, [3, 2])] {
            let [together, alone] = coverage(quantities, size);
            // Four standard errors of a share of 0.95 in 400 are 0.044.
            assert!((together - CONFIDENCE).abs() < 0.05, "{quantities} of {size:?}: {together}");
            assert!(quantities == 1 || alone < 0.85, "{quantities} of {size:?}: {alone} alone");
        }
    }

    #[test]
    fn a_quantity_without_an_interval_leaves_the_others_as_they_are() {
        let family = family(7, 3, [8, 2]);
        let resamples = Resamples::new(8, 2, 1);
        let alone = resamples.simultaneous(&family);
        let mut more = family.clone();
        more.extend([vec![f64::NAN; 16], vec![2.0; 16], vec![1.0]]);
        let with_others = resamples.simultaneous(&more);
        assert_eq!(with_others[..3], alone[..]);
        assert_eq!(with_others[3], None);
        assert_eq!(with_others[4], Some(Interval { low: 2.0, high: 2.0 }));
        assert_eq!(with_others[5], None);
        assert!(resamples.simultaneous(&[]).is_empty());
    }
}
