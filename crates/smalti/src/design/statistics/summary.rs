//! How a metric spreads over the designs of a group, and how well the designs drawn tell it.

use std::collections::BTreeMap;

use super::StatisticsError;
use super::distribution::{normal_z, quantile_ranks, student_t};

/// A figure and its confidence interval, in the unit of the column.
///
/// `value` is NaN where too few designs define it. `low` and `high` are −∞ and ∞ where too few designs bound it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Lower end of its confidence interval.
    pub low: f64,
    /// Upper end of its confidence interval.
    pub high: f64,
}

impl Estimate {
    fn unbounded(value: f64) -> Self {
        Self { value, low: f64::NEG_INFINITY, high: f64::INFINITY }
    }
}

/// One metric over one group of designs.
///
/// `p05` and `p95` bound the interval that holds 90 % of the designs, as in the seed study's table of means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Designs with a finite value; the figures below are theirs.
    pub count: usize,
    /// Designs without one.
    pub left_out: usize,
    /// Arithmetic mean; its interval by Student's t, near enough for the hundreds of designs of a study whatever
    /// their distribution.
    pub mean: Estimate,
    /// Standard deviation, of n − 1; its interval after [bonett2006], which holds without normality. From 5 designs.
    ///
    /// [bonett2006]: https://doi.org/10.1016/j.csda.2004.10.003
    pub standard_deviation: Estimate,
    /// Median. This and the percentiles are interpolated linearly between order statistics, NumPy's default
    /// (type 7 of [hyndman1996]); their intervals lie between order statistics chosen by the binomial distribution
    /// ([thompson1936]), which holds for any continuous distribution.
    ///
    /// [hyndman1996]: https://doi.org/10.1080/00031305.1996.10473566
    /// [thompson1936]: https://doi.org/10.1214/aoms/1177732502
    pub median: Estimate,
    /// 5th percentile.
    pub p05: Estimate,
    /// 95th percentile.
    pub p95: Estimate,
}

/// The summary of one column. Values that are not finite are left out and counted. The order of the values does not
/// matter, to the last bit.
///
/// `confidence` is that of each interval by itself, 0.95 by custom.
///
/// # Errors
/// [`StatisticsError::Confidence`] unless it lies between 0 and 1.
pub fn summarize(values: &[f64], confidence: f64) -> Result<Summary, StatisticsError> {
    if !(confidence > 0.0 && confidence < 1.0) {
        return Err(StatisticsError::Confidence { value: confidence });
    }
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let count = sorted.len();
    let moments: Moments = sorted.iter().copied().collect();
    let mean = moments.mean();
    let half = match count {
        0 | 1 => f64::INFINITY,
        _ => student_t(confidence, count) * moments.standard_deviation() / (count as f64).sqrt(),
    };
    let quantile = |probability: f64| {
        let (lower, upper) = quantile_ranks(count, probability, confidence);
        let ranked = |rank: Option<usize>| rank.and_then(|r| sorted.get(r.checked_sub(1)?)).copied();
        Estimate {
            value: quantile_of_sorted(&sorted, probability),
            low: ranked(lower).unwrap_or(f64::NEG_INFINITY),
            high: ranked(upper).unwrap_or(f64::INFINITY),
        }
    };
    Ok(Summary {
        count,
        left_out: values.len() - count,
        mean: if count == 0 {
            Estimate::unbounded(f64::NAN)
        } else {
            Estimate { value: mean, low: mean - half, high: mean + half }
        },
        standard_deviation: standard_deviation(&sorted, &moments, confidence),
        median: quantile(0.5),
        p05: quantile(0.05),
        p95: quantile(0.95),
    })
}

/// The summary of a column for each group, ascending. A group without a finite value stays, with `count` 0.
///
/// # Errors
/// [`StatisticsError::Lengths`] unless the columns are of one length, [`StatisticsError::Confidence`] as in
/// [`summarize`].
pub fn summarize_groups<G: Ord + Clone>(
    groups: &[G],
    values: &[f64],
    confidence: f64,
) -> Result<Vec<(G, Summary)>, StatisticsError> {
    let rows = rows_per_group(groups, values.len())?;
    let column = |rows: Vec<usize>| rows.iter().filter_map(|r| values.get(*r)).copied().collect::<Vec<f64>>();
    rows.into_iter().map(|(group, rows)| Ok((group, summarize(&column(rows), confidence)?))).collect()
}

/// The rows of each group, ascending in both.
pub(super) fn rows_per_group<G: Ord + Clone>(
    groups: &[G],
    rows: usize,
) -> Result<BTreeMap<G, Vec<usize>>, StatisticsError> {
    if groups.len() != rows {
        return Err(StatisticsError::Lengths { expected: groups.len(), got: rows });
    }
    let mut map = BTreeMap::new();
    for (row, group) in groups.iter().enumerate() {
        match map.get_mut(group) {
            None => drop(map.insert(group.clone(), vec![row])),
            Some(rows) => rows.push(row),
        }
    }
    Ok(map)
}

/// The value below which the share `probability` of ascending values lies, linearly interpolated, as NumPy's default
/// does to the last bit; NaN without values. Probabilities beyond 0 and 1 give the extremes.
#[must_use]
pub fn quantile_of_sorted(sorted: &[f64], probability: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let position = last as f64 * probability.clamp(0.0, 1.0);
    let index = (position as usize).min(last);
    let t = position - index as f64;
    let at = |i: usize| sorted.get(i.min(last)).copied().unwrap_or(f64::NAN);
    let (a, b) = (at(index), at(index + 1));
    // From the nearer end, so that the result is monotone in t.
    if t < 0.5 { a + (b - a) * t } else { b - (b - a) * (1.0 - t) }
}

/// Bonett's interval: the logarithm of the variance is near normal, with a spread that the kurtosis sets. The kurtosis
/// is taken about a trimmed mean, which a long tail moves less.
fn standard_deviation(sorted: &[f64], moments: &Moments, confidence: f64) -> Estimate {
    let value = moments.standard_deviation();
    let n = sorted.len() as f64;
    let z = normal_z(confidence);
    if n < 5.0 || n <= z || value <= 0.0 {
        return Estimate::unbounded(value);
    }
    let trim = (n * 0.5 / (n - 4.0).sqrt()) as usize;
    let kept = sorted.get(trim..sorted.len() - trim).filter(|k| !k.is_empty()).unwrap_or(sorted);
    let center = kept.iter().copied().collect::<Moments>().mean();
    let fourth: f64 = sorted.iter().map(|x| ((x - center) / value).powi(4)).sum();
    let kurtosis = n * fourth / ((n - 1.0) * (n - 1.0));
    let c = n / (n - z);
    let error = c * ((kurtosis - (n - 3.0) / n).max(0.0) / (n - 1.0)).sqrt();
    let end = |sign: f64| value * (c * libm::exp(sign * z * error)).sqrt();
    Estimate { value, low: end(-1.0), high: end(1.0) }
}

/// Count, mean and variance of values seen one by one, or of parts joined: memory for three numbers.
///
/// Joining parts gives the same as one pass up to rounding, so for equal bits join the same parts in the same order.
/// After [chan1983].
///
/// [chan1983]: https://doi.org/10.1080/00031305.1983.10483115
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    squares: f64,
}

impl Moments {
    /// Adds a value.
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    /// Both parts together.
    #[must_use]
    pub fn merge(self, other: Self) -> Self {
        if self.count == 0 || other.count == 0 {
            return if self.count == 0 { other } else { self };
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let apart = other.mean - self.mean;
        Self {
            count: self.count + other.count,
            mean: self.mean + apart * (b / (a + b)),
            squares: self.squares + other.squares + apart * apart * (a * b / (a + b)),
        }
    }

    /// How many values were added.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean; NaN without one.
    #[must_use]
    pub fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// Their variance, of n − 1; NaN below two.
    #[must_use]
    pub fn variance(&self) -> f64 {
        if self.count < 2 { f64::NAN } else { self.squares / (self.count - 1) as f64 }
    }

    /// The root of the variance.
    #[must_use]
    pub fn standard_deviation(&self) -> f64 {
        self.variance().sqrt()
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::default();
        values.into_iter().for_each(|v| moments.push(v));
        moments
    }
}
