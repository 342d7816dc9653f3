//! Pareto fronts: the designs that no other design dominates.

use std::collections::BTreeMap;

use super::objective::rows;
use super::{Objective, StatisticsError};

/// The Pareto front of a set of designs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParetoFront {
    /// Rows of the front, ascending. Of designs that are equal in every objective, all or none are on the front.
    pub rows: Vec<usize>,
    /// Number of rows left out because one of their objectives is NaN.
    pub left_out: usize,
}

/// The rows that no other row dominates, that is, is at least as good in every objective and better in one.
///
/// Infinite values are compared like others. Up to three objectives take n log n operations ([kung1975]). With more, rows are
/// sorted by the sum of their ranks and compared with the front found so far ([chomicki2003]): n times the size of the front.
///
/// [kung1975]: https://doi.org/10.1145/321906.321910
/// [chomicki2003]: https://doi.org/10.1109/ICDE.2003.1260846
///
/// # Errors
/// [`StatisticsError::NoObjective`], and [`StatisticsError::Lengths`] unless all have as many rows.
pub fn pareto_front(objectives: &[Objective<'_>]) -> Result<ParetoFront, StatisticsError> {
    let all = rows(objectives)?;
    let mut front = match objectives {
        [a] => sweep(all, [a, a, a]),
        [a, b] => sweep(all, [a, b, b]),
        [a, b, c] => sweep(all, [a, b, c]),
        _ => filter(all, objectives),
    };
    front.rows.sort_unstable();
    Ok(front)
}

/// A number as an integer of the same order; −0 equals 0.
fn key(cost: f64) -> u64 {
    let bits = (cost + 0.0).to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

/// Sweeps over three objectives. In ascending order of the first, a row is dominated when an earlier row is no worse in the
/// other two. A staircase holds the least third cost up to each second cost. One or two objectives repeat the last.
fn sweep(all: usize, objectives: [&Objective<'_>; 3]) -> ParetoFront {
    let mut order: Vec<([u64; 3], usize)> = Vec::with_capacity(all);
    for row in 0..all {
        let costs = objectives.map(|o| o.cost(row).map(key));
        if let [Some(a), Some(b), Some(c)] = costs {
            order.push(([a, b, c], row));
        }
    }
    let left_out = all - order.len();
    order.sort_unstable();
    let mut stairs: BTreeMap<u64, u64> = BTreeMap::new();
    let mut rows = Vec::new();
    let mut previous: Option<([u64; 3], bool)> = None;
    for (costs, row) in order {
        let [_, b, c] = costs;
        let on_front = match previous {
            Some((same, verdict)) if same == costs => verdict,
            _ => stairs.range(..=b).next_back().is_none_or(|(_, least)| *least > c),
        };
        previous = Some((costs, on_front));
        if on_front {
            rows.push(row);
            while let Some((&worse, _)) = stairs.range(b..).next().filter(|(_, third)| **third >= c) {
                stairs.remove(&worse);
            }
            stairs.insert(b, c);
        }
    }
    ParetoFront { rows, left_out }
}

/// Filters by any number of objectives. A dominating row has a smaller sum of ranks, so that in this order a row is on the
/// front unless a row of the front dominates it.
fn filter(all: usize, objectives: &[Objective<'_>]) -> ParetoFront {
    let valid: Vec<usize> =
        (0..all).filter(|row| objectives.iter().all(|o| o.cost(*row).is_some())).collect();
    let width = objectives.len();
    let mut ranks = vec![0u32; valid.len() * width];
    let mut sums = vec![0u64; valid.len()];
    for (column, objective) in objectives.iter().enumerate() {
        let mut order: Vec<(u64, usize)> = valid
            .iter()
            .enumerate()
            .filter_map(|(place, row)| Some((key(objective.cost(*row)?), place)))
            .collect();
        order.sort_unstable();
        let (mut rank, mut previous) = (0u32, None);
        for (cost, place) in order {
            rank += u32::from(previous.is_some_and(|p| p != cost));
            previous = Some(cost);
            if let (Some(slot), Some(sum)) = (ranks.get_mut(place * width + column), sums.get_mut(place)) {
                *slot = rank;
                *sum += u64::from(rank);
            }
        }
    }
    let mut order: Vec<(u64, usize)> = sums.iter().enumerate().map(|(place, sum)| (*sum, place)).collect();
    order.sort_unstable();
    let mut rows = Vec::new();
    // The ranks of the front are contiguous, because comparisons with them take most of the time.
    let mut front: Vec<u32> = Vec::new();
    for (_, place) in order {
        let Some(own) = ranks.get(place * width..(place + 1) * width) else { continue };
        let dominates = |other: &[u32]| other.iter().zip(own).all(|(o, s)| o <= s) && other != own;
        if !front.chunks_exact(width).any(dominates) {
            front.extend_from_slice(own);
            rows.extend(valid.get(place));
        }
    }
    ParetoFront { rows, left_out: all - valid.len() }
}
