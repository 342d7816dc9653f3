//! Rankings of the designs of a group.

use std::cmp::Ordering;

use super::objective::rows;
use super::summary::{quantile_of_sorted, rows_per_group};
use super::{Objective, StatisticsError};

/// The ranking rule for the designs of a group, best first.
///
/// Reports use [`Rule::Keeping`] with least ΔE and median MTF50: the best design by one metric is often poor by another, and
/// weights between unlike units are arbitrary. The rule means "the best colour among the sharper half of the group".
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Rule<'a> {
    /// By `best`, among the designs whose `keep` is no worse than the median of the group.
    Keeping {
        /// The objective that ranks.
        best: Objective<'a>,
        /// The objective that must be no worse than the median.
        keep: Objective<'a>,
    },
    /// By the first objective, ties by the next. One objective alone ranks by that metric.
    Lexicographic(Vec<Objective<'a>>),
    /// By the weighted sum of the objectives, each as its difference from the median of the group divided by the range from
    /// the 5th to the 95th percentile. An objective without spread is ignored.
    Weighted(Vec<(Objective<'a>, f64)>),
}

/// The rows of the `count` best designs of each group, best first; groups ascending, equal designs by row. Designs with
/// a NaN in an objective of the rule are left out.
///
/// # Errors
/// [`StatisticsError::NoObjective`], [`StatisticsError::Lengths`] unless all columns have as many rows, and
/// [`StatisticsError::Weight`] for a weight that is negative or not finite.
pub fn best_per_group<G: Ord + Clone>(
    groups: &[G],
    rule: &Rule<'_>,
    count: usize,
) -> Result<Vec<(G, Vec<usize>)>, StatisticsError> {
    let objectives: Vec<Objective<'_>> = match rule {
        Rule::Keeping { best, keep } => vec![*best, *keep],
        Rule::Lexicographic(objectives) => objectives.clone(),
        Rule::Weighted(weighted) => {
            let bad =
                |(_, (_, weight)): &(usize, &(Objective<'_>, f64))| !(weight.is_finite() && *weight >= 0.0);
            if let Some((index, (_, value))) = weighted.iter().enumerate().find(bad) {
                return Err(StatisticsError::Weight { index, value: *value });
            }
            weighted.iter().map(|(objective, _)| *objective).collect()
        }
    };
    let per_group = rows_per_group(groups, rows(&objectives)?)?;
    Ok(per_group
        .into_iter()
        .map(|(group, mut members)| {
            members.retain(|row| objectives.iter().all(|o| o.cost(*row).is_some()));
            let mut ranked = order(rule, members);
            ranked.truncate(count);
            (group, ranked)
        })
        .collect())
}

/// The rows of one group, all without NaN, best first.
fn order(rule: &Rule<'_>, mut members: Vec<usize>) -> Vec<usize> {
    let costs = |objective: &Objective<'_>| -> Vec<f64> {
        let mut all: Vec<f64> = members.iter().filter_map(|row| objective.cost(*row)).collect();
        all.sort_unstable_by(f64::total_cmp);
        all
    };
    let by = |objective: &Objective<'_>, a: usize, b: usize| {
        objective.cost(a).partial_cmp(&objective.cost(b)).unwrap_or(Ordering::Equal)
    };
    // Rows ascend, and the sort is stable: equal designs stay in the order of their rows.
    match rule {
        Rule::Keeping { best, keep } => {
            // For an even number, the lower of the middle two; no value lies between it and the median.
            let kept = costs(keep);
            let median = kept.get(kept.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN);
            members.retain(|row| keep.cost(*row).is_some_and(|cost| cost <= median));
            members.sort_by(|a, b| by(best, *a, *b).then(by(keep, *a, *b)));
        }
        Rule::Lexicographic(objectives) => members.sort_by(|a, b| {
            objectives.iter().fold(Ordering::Equal, |sum, o| sum.then_with(|| by(o, *a, *b)))
        }),
        Rule::Weighted(weighted) => {
            let scales: Vec<(f64, f64)> = weighted
                .iter()
                .map(|(objective, weight)| {
                    let sorted = costs(objective);
                    let spread = quantile_of_sorted(&sorted, 0.95) - quantile_of_sorted(&sorted, 0.05);
                    let scale = Some(weight / spread).filter(|s| spread > 0.0 && s.is_finite());
                    (quantile_of_sorted(&sorted, 0.5), scale.unwrap_or(0.0))
                })
                .collect();
            let score = |row: usize| -> f64 {
                let terms = weighted.iter().zip(&scales).filter(|(_, (_, scale))| *scale > 0.0);
                terms.filter_map(|((o, _), (median, scale))| Some((o.cost(row)? - median) * scale)).sum()
            };
            let mut scored: Vec<(f64, usize)> = members.iter().map(|row| (score(*row), *row)).collect();
            scored.sort_by(|a, b| a.0.total_cmp(&b.0));
            members = scored.into_iter().map(|(_, row)| row).collect();
        }
    }
    members
}
