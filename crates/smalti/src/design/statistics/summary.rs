//! Summary statistics of a metric over a group of designs, with confidence intervals.

use std::collections::BTreeMap;

use super::StatisticsError;
use super::distribution::{normal_z, quantile_ranks, student_t};

/// An estimate and its confidence interval, in the unit of the column.
///
/// With too few designs, `value` is NaN, and `low` and `high` are −∞ and ∞.
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
/// `p05` and `p95` bound the central 90 % of the designs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Number of designs with a finite value, which the statistics are computed from.
    pub count: usize,
    /// Number of designs without a finite value.
    pub left_out: usize,
    /// Arithmetic mean. Its interval is by Student's t, which is accurate for the hundreds of designs of a study regardless of
    /// their distribution.
    pub mean: Estimate,
    /// Standard deviation with divisor n − 1. Its interval is by [bonett2006], does not assume normality, and needs 5 designs.
    ///
    /// [bonett2006]: https://doi.org/10.1016/j.csda.2004.10.003
    pub standard_deviation: Estimate,
    /// Median. The median and the percentiles are interpolated linearly between order statistics, as in NumPy by default
    /// (type 7 of [hyndman1996]). Their intervals are bounded by order statistics chosen by the binomial distribution
    /// ([thompson1936]), which is valid for any continuous distribution.
    ///
    /// [hyndman1996]: https://doi.org/10.1080/00031305.1996.10473566
    /// [thompson1936]: https://doi.org/10.1214/aoms/1177732502
    pub median: Estimate,
    /// 5th percentile.
    pub p05: Estimate,
    /// 95th percentile.
    pub p95: Estimate,
}

/// The summary of one column. Values that are not finite are left out and counted. The result does not depend on the order of
/// the values, to the last bit. `confidence` applies to each interval separately; 0.95 is common.
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
    let (mean, deviation) = moments(&sorted);
    let half = match count {
        0 | 1 => f64::INFINITY,
        _ => student_t(confidence, count) * deviation / (count as f64).sqrt(),
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
        standard_deviation: standard_deviation(&sorted, deviation, confidence),
        median: quantile(0.5),
        p05: quantile(0.05),
        p95: quantile(0.95),
    })
}

/// The summary of a column for each group, ascending. A group without a finite value has `count` 0.
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

/// The rows of each group; groups and rows ascend.
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

/// The quantile of ascending values, interpolated linearly; it equals that of NumPy (default method) to the last bit. NaN
/// without values. Probabilities outside 0 to 1 give the extremes.
#[must_use]
pub fn quantile_of_sorted(sorted: &[f64], probability: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let position = last as f64 * probability.clamp(0.0, 1.0);
    let index = (position as usize).min(last);
    let t = position - index as f64;
    let at = |i: usize| sorted.get(i.min(last)).copied().unwrap_or(f64::NAN);
    let (a, b) = (at(index), at(index + 1));
    // Interpolation from the nearer end makes the result monotone in t.
    if t < 0.5 { a + (b - a) * t } else { b - (b - a) * (1.0 - t) }
}

/// Bonett's interval: the logarithm of the variance is nearly normal, with a standard error that depends on the kurtosis. The
/// kurtosis is taken about a trimmed mean, which is robust against long tails.
fn standard_deviation(sorted: &[f64], value: f64, confidence: f64) -> Estimate {
    let n = sorted.len() as f64;
    let z = normal_z(confidence);
    if n < 5.0 || n <= z || value <= 0.0 {
        return Estimate::unbounded(value);
    }
    let trim = (n * 0.5 / (n - 4.0).sqrt()) as usize;
    let kept = sorted.get(trim..sorted.len() - trim).filter(|k| !k.is_empty()).unwrap_or(sorted);
    let center = moments(kept).0;
    let fourth: f64 = sorted.iter().map(|x| ((x - center) / value).powi(4)).sum();
    let kurtosis = n * fourth / ((n - 1.0) * (n - 1.0));
    let c = n / (n - z);
    let error = c * ((kurtosis - (n - 3.0) / n).max(0.0) / (n - 1.0)).sqrt();
    let end = |sign: f64| value * (c * libm::exp(sign * z * error)).sqrt();
    Estimate { value, low: end(-1.0), high: end(1.0) }
}

/// The mean, NaN without values, and the standard deviation with divisor n − 1, NaN for fewer than two values, in one pass
/// ([chan1983], updating).
///
/// [chan1983]: https://doi.org/10.1080/00031305.1983.10483115
fn moments(values: &[f64]) -> (f64, f64) {
    let (mut mean, mut squares, mut count) = (0.0, 0.0, 0.0);
    for value in values {
        count += 1.0;
        let before = value - mean;
        mean += before / count;
        squares += before * (value - mean);
    }
    let or_nan = |least: f64, value: f64| if count < least { f64::NAN } else { value };
    (or_nan(1.0, mean), or_nan(2.0, squares / (count - 1.0)).sqrt())
}
