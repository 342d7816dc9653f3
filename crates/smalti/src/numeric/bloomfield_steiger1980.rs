//! Least absolute deviations by descent along edges: Bloomfield and Steiger (1980), "Least absolute deviations curve-fitting",
//! *SIAM Journal on Scientific and Statistical Computing* 1(2), 290–301 ([bloomfield1980]).
//!
//! The sum Σ |b_i − a_i · x| is convex and linear between the planes a_i · x = b_i. It has a minimum at a point where as many of
//! them meet as there are unknowns. From such a point, the method follows the steepest of the lines that all but one of the
//! planes share. The minimum along a line is a weighted median and lies on another plane.
//!
//! [bloomfield1980]: https://doi.org/10.1137/0901019

use super::orthonormal::dot;

/// Relative shift of the right-hand sides, different for each, so that no more planes meet in a point than there are unknowns.
/// Otherwise the descent could stop early.
const SHIFT: f64 = 1e-10;
/// Slopes along an edge above this are no descent.
const LEVEL: f64 = 1e-9;

/// The least Σ |b_i − Σ_k columns\[k\]\[i\] x_k| over all x. The columns must be linearly independent and as long as `b`.
/// `None` for columns that are not.
pub(crate) fn least_absolute_sum(columns: &[Vec<f64>], b: &[f64]) -> Option<f64> {
    let unknowns = columns.len();
    let rows: Vec<Vec<f64>> = (0..b.len()).map(|i| columns.iter().map(|c| c[i]).collect()).collect();
    let largest = b.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    // Multiples of the golden ratio modulo 1 all differ.
    let shift = |i: usize| SHIFT * largest * ((i as f64 + 1.0) * 0.618_033_988_749_894_9).fract();
    let shifted: Vec<f64> = b.iter().enumerate().map(|(i, v)| v + shift(i)).collect();
    let sum = |b: &[f64], x: &[f64]| rows.iter().zip(b).map(|(a, b)| (b - dot(a, x)).abs()).sum::<f64>();

    let mut active = independent_rows(&rows, unknowns)?;
    let mut best = f64::INFINITY;
    let mut least = b.iter().map(|v| v.abs()).sum();
    loop {
        // Column k of the inverse leads along the line on which all active planes but the k-th meet.
        let edges = inverse(&active.iter().map(|&i| rows[i].clone()).collect::<Vec<_>>())?;
        let x: Vec<f64> = edges
            .iter()
            .map(|line| dot(line, &active.iter().map(|&i| shifted[i]).collect::<Vec<_>>()))
            .collect();
        let here = sum(&shifted, &x);
        if here.is_nan() || here >= best {
            return Some(least);
        }
        best = here;
        least = sum(b, &x);
        let residuals: Vec<f64> = rows.iter().zip(&shifted).map(|(a, b)| b - dot(a, &x)).collect();
        let along = |k: usize| -> Vec<f64> {
            let direction: Vec<f64> = edges.iter().map(|line| line[k]).collect();
            rows.iter().map(|a| dot(a, &direction)).collect()
        };
        let pull = |k: usize| {
            let all = along(k).into_iter().zip(&residuals).enumerate();
            all.filter(|(i, _)| !active.contains(i)).map(|(_, (h, r))| h * r.signum()).sum::<f64>()
        };
        let steepest = (0..unknowns).map(|k| (k, pull(k))).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some((leaving, _)) = steepest.filter(|(_, pull)| pull.abs() > 1.0 + LEVEL) else {
            return Some(least);
        };
        let Some(entering) = weighted_median(&along(leaving), &residuals, &active, leaving) else {
            return Some(least);
        };
        active[leaving] = entering;
    }
}

/// The row whose plane holds the minimum along a line: the median of residual / slope, weighted by the slopes.
fn weighted_median(slopes: &[f64], residuals: &[f64], active: &[usize], leaving: usize) -> Option<usize> {
    let others = (0..slopes.len()).filter(|i| active[leaving] == *i || !active.contains(i));
    let mut places: Vec<(f64, f64, usize)> = others
        .filter(|&i| slopes[i] != 0.0)
        .map(|i| {
            let residual = if active[leaving] == i { 0.0 } else { residuals[i] };
            (residual / slopes[i], slopes[i].abs(), i)
        })
        .collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = places.iter().map(|p| p.1).sum::<f64>() / 2.0;
    let mut passed = 0.0;
    places.iter().find_map(|p| {
        passed += p.1;
        (passed >= half).then_some(p.2)
    })
}

/// Rows that are linearly independent, as many as unknowns, by elimination with full pivoting.
fn independent_rows(rows: &[Vec<f64>], unknowns: usize) -> Option<Vec<usize>> {
    let mut left = rows.to_vec();
    let mut chosen = Vec::with_capacity(unknowns);
    for _ in 0..unknowns {
        let places = (0..left.len()).flat_map(|i| (0..unknowns).map(move |k| (i, k)));
        let (i, k) = places.max_by(|&(i, k), &(j, l)| left[i][k].abs().total_cmp(&left[j][l].abs()))?;
        let pivot = left[i].clone();
        if pivot[k] == 0.0 || pivot[k].is_nan() {
            return None;
        }
        for row in &mut left {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(&pivot).for_each(|(v, p)| *v -= factor * p);
            row[k] = 0.0;
        }
        chosen.push(i);
    }
    Some(chosen)
}

/// The inverse of a square matrix by elimination with row pivoting; `None` when it is singular.
fn inverse(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let size = matrix.len();
    let unit = |i: usize| (0..size).map(move |k| f64::from(u8::from(i == k)));
    let mut work: Vec<Vec<f64>> =
        matrix.iter().enumerate().map(|(i, row)| row.iter().copied().chain(unit(i)).collect()).collect();
    for k in 0..size {
        let pivot = (k..size).max_by(|&a, &b| work[a][k].abs().total_cmp(&work[b][k].abs()))?;
        work.swap(k, pivot);
        let scale = work[k][k];
        if scale == 0.0 || scale.is_nan() {
            return None;
        }
        work[k].iter_mut().for_each(|v| *v /= scale);
        let row = work[k].clone();
        for (_, other) in work.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = other[k];
            other.iter_mut().zip(&row).for_each(|(v, p)| *v -= factor * p);
        }
    }
    Some(work.into_iter().map(|row| row[size..].to_vec()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    fn random(seed: u64, count: usize) -> Vec<f64> {
        let mut stream = Stream::new(seed, 0, 0);
        (0..count).map(|_| stream.uniform() - 0.3).collect()
    }

    #[test]
    fn one_constant_is_a_median() {
        // Medians of these values are 3: |1 − 3| + |2 − 3| + 0 + |10 − 3| + |30 − 3|.
        let sum = least_absolute_sum(&[vec![1.0; 5]], &[1.0, 30.0, 3.0, 10.0, 2.0]).unwrap();
        assert!((sum - 37.0).abs() < 1e-7, "{sum}");
    }

    #[test]
    fn what_the_columns_explain_leaves_nothing() {
        let columns: Vec<Vec<f64>> = (0..4).map(|s| random(s, 31)).collect();
        let b: Vec<f64> =
            (0..31).map(|i| columns[0][i] - 2.0 * columns[2][i] + 0.1 * columns[3][i]).collect();
        assert!(least_absolute_sum(&columns, &b).unwrap() < 1e-7);
    }

    /// `metrics_colorimetry` compares sums with those of a linear programme.
    #[test]
    fn the_sum_is_the_least() {
        for seed in 0..20 {
            let unknowns = 2 + seed as usize % 5;
            let columns: Vec<Vec<f64>> = (0..unknowns as u64).map(|s| random(100 * seed + s, 40)).collect();
            let b = random(7000 + seed, 40);
            let least = least_absolute_sum(&columns, &b).unwrap();
            let mut stream = Stream::new(seed, 1, 0);
            for _ in 0..2000 {
                let x: Vec<f64> = (0..unknowns).map(|_| 2.0 * stream.uniform() - 1.0).collect();
                let sum: f64 = (0..40)
                    .map(|i| (b[i] - columns.iter().zip(&x).map(|(c, x)| c[i] * x).sum::<f64>()).abs())
                    .sum();
                assert!(sum >= least - 1e-7, "{sum} {least}");
            }
        }
    }

    #[test]
    fn dependent_columns_are_refused() {
        assert_eq!(least_absolute_sum(&[vec![0.0; 3]], &[1.0, 2.0, 3.0]), None);
        assert_eq!(least_absolute_sum(&[], &[1.0, -2.0]), Some(3.0));
    }
}
