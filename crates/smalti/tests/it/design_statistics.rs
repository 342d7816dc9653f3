//! Summaries against NumPy and by simulation, Pareto fronts and rankings by their definitions.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use smalti::design::statistics::{
    Estimate, Objective, Rule, StatisticsError, best_per_group, pareto_front, quantile_of_sorted, summarize,
    summarize_groups,
};
use smalti::numeric::philox::Stream;

/// 200 values that a line of Python gives as well: `((i*7919)%1009)/100 + ((i*i)%37)*0.05`.
fn column() -> Vec<f64> {
    (0..200).map(|i| f64::from((i * 7919) % 1009) / 100.0 + f64::from((i * i) % 37) * 0.05).collect()
}

fn close(got: f64, expected: f64) {
    assert!((got - expected).abs() <= 1e-12 * expected.abs(), "got {got}, expected {expected}");
}

/// NumPy 2.4: `mean`, `std(ddof=1)`, `median`, `percentile(5)`, `percentile(95)`; SciPy's t(0.975, 199).
#[test]
fn figures_are_numpys() {
    let summary = summarize(&column(), 0.95).unwrap();
    close(summary.mean.value, 5.9601);
    close(summary.standard_deviation.value, 3.015_798_600_036_133);
    close(summary.median.value, 5.795);
    close(summary.p05.value, 1.079_5);
    close(summary.p95.value, 10.612_5);
    let half = 1.971_956_544_251_753 * 3.015_798_600_036_133 / 200f64.sqrt();
    assert!((summary.mean.high - summary.mean.value - half).abs() < 1e-9);
    let few = summarize(&[3.5, 1.25, 9.0, 2.0, 7.75], 0.95).unwrap();
    close(few.mean.value, 4.7);
    close(few.standard_deviation.value, 3.479_403_684_541_361);
    close(few.p05.value, 1.4);
    close(few.p95.value, 8.75);
    // Five values bound their median with 94 % at most: an honest interval is endless.
    assert_eq!((few.median.low, few.median.high), (f64::NEG_INFINITY, f64::INFINITY));
}

#[test]
fn what_is_missing_is_counted() {
    let holes = [f64::NAN, 2.0, f64::INFINITY, 4.0, f64::NEG_INFINITY];
    let summary = summarize(&holes, 0.9).unwrap();
    assert_eq!((summary.count, summary.left_out, summary.mean.value), (2, 3, 3.0));
    let empty = summarize(&[f64::NAN], 0.9).unwrap();
    assert_eq!((empty.count, empty.left_out), (0, 1));
    assert!([empty.mean, empty.standard_deviation, empty.median].iter().all(|e| e.value.is_nan()));
    let one = summarize(&[7.0], 0.9).unwrap();
    assert_eq!((one.mean.value, one.mean.high, one.median.value), (7.0, f64::INFINITY, 7.0));
    assert!(one.standard_deviation.value.is_nan());
    let same = summarize(&[7.0; 50], 0.9).unwrap();
    assert_eq!((same.mean.low, same.mean.high, same.standard_deviation.value), (7.0, 7.0, 0.0));
    let groups = summarize_groups(&["b", "a", "b"], &[1.0, f64::NAN, 3.0], 0.9).unwrap();
    assert_eq!(groups.iter().map(|(g, s)| (*g, s.count)).collect::<Vec<_>>(), [("a", 0), ("b", 2)]);
}

#[test]
fn bad_questions_are_refused() {
    for value in [0.0, 1.0, -0.5, f64::NAN] {
        let error = summarize(&[1.0], value).unwrap_err();
        assert!(matches!(error, StatisticsError::Confidence { .. }), "{error}");
    }
    assert_eq!(
        summarize_groups(&[1, 2], &[1.0], 0.9).unwrap_err(),
        StatisticsError::Lengths { expected: 2, got: 1 }
    );
    assert_eq!(pareto_front(&[]).unwrap_err(), StatisticsError::NoObjective);
    let (long, short) = ([1.0, 2.0], [1.0]);
    assert_eq!(
        pareto_front(&[Objective::lower(&long), Objective::lower(&short)]).unwrap_err(),
        StatisticsError::Lengths { expected: 2, got: 1 }
    );
    let weighted = Rule::Weighted(vec![(Objective::lower(&long), -1.0)]);
    assert_eq!(
        best_per_group(&[1, 1], &weighted, 1).unwrap_err(),
        StatisticsError::Weight { index: 0, value: -1.0 }
    );
    assert_eq!(
        best_per_group(&[1, 1], &Rule::Lexicographic(vec![]), 1).unwrap_err(),
        StatisticsError::NoObjective
    );
}

/// Of 4000 studies of 200 designs, how many intervals hold the truth. A gamma distribution of shape 4 (skewness 1), as
/// ΔE over a study is skewed: mean 4, variance 4, quantiles by SciPy 1.17's `gamma.ppf`.
#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    const STUDIES: u32 = 4000;
    let truths = [4.0, 2.0, 3.672_060_748_850_897, 1.366_318_396_749_831, 7.753_656_527_932_725];
    let mut held = [0u32; 5];
    for study in 0..STUDIES {
        let mut random = Stream::new(11, 0, study);
        let draws: Vec<f64> =
            (0..200).map(|_| -(0..4).map(|_| (1.0 - random.uniform()).ln()).sum::<f64>()).collect();
        let s = summarize(&draws, 0.9).unwrap();
        let estimates = [s.mean, s.standard_deviation, s.median, s.p05, s.p95];
        for ((count, truth), Estimate { low, high, .. }) in held.iter_mut().zip(truths).zip(estimates) {
            *count += u32::from(low <= truth && truth <= high);
        }
    }
    let share = held.map(|h| f64::from(h) / f64::from(STUDIES));
    // Four standard errors of a share of 0.9 are 0.019. Mean and deviation are approximate under skewness; order
    // statistics hold at least what they say and overshoot by the step between two ranks.
    assert!((share[0] - 0.9).abs() < 0.019, "mean {share:?}");
    assert!((0.87..0.92).contains(&share[1]), "deviation {share:?}");
    assert!(share[2..].iter().all(|s| (0.9 - 0.019..0.96).contains(s)), "quantiles {share:?}");
}

proptest! {
    #[test]
    fn order_does_not_matter(values in prop::collection::vec(-1e3..1e3f64, 0..100), turn in 0usize..100) {
        let mut turned = values.clone();
        turned.rotate_left(turn.min(values.len()));
        turned.reverse();
        // Text compares NaN as equal.
        prop_assert_eq!(
            format!("{:?}", summarize(&values, 0.9)), format!("{:?}", summarize(&turned, 0.9)));
    }

    #[test]
    fn quantiles_rise_within_the_extremes(
        mut values in prop::collection::vec(-1e3..1e3f64, 1..50), p in 0.0..1.0f64, q in 0.0..1.0f64,
    ) {
        values.sort_by(f64::total_cmp);
        let (low, high) = (quantile_of_sorted(&values, p.min(q)), quantile_of_sorted(&values, p.max(q)));
        prop_assert!(values[0] <= low && low <= high && high <= values[values.len() - 1]);
    }

    /// Few distinct values, so that ties and equal rows are common; a few holes.
    #[test]
    fn fronts_are_what_their_definition_says(
        rows in prop::collection::vec(prop::collection::vec(0u8..8, 5), 0..60),
        higher in prop::collection::vec(any::<bool>(), 5),
        objectives in 1usize..=5,
    ) {
        let value = |v: u8| [f64::NAN, -0.0, 0.0, 0.5, 1.0, 3.0, f64::INFINITY, -2.0][usize::from(v)];
        let columns: Vec<Vec<f64>> =
            (0..objectives).map(|k| rows.iter().map(|r| value(r[k])).collect()).collect();
        let asked: Vec<Objective<'_>> = columns.iter().zip(&higher)
            .map(|(c, h)| if *h { Objective::higher(c) } else { Objective::lower(c) }).collect();
        let valid: Vec<usize> =
            (0..rows.len()).filter(|&i| columns.iter().all(|c| !c[i].is_nan())).collect();
        let no_worse = |i: usize, j: usize| columns.iter().zip(&higher)
            .all(|(c, h)| if *h { c[i] >= c[j] } else { c[i] <= c[j] });
        let beats = |i: usize, j: usize| no_worse(i, j) && !no_worse(j, i);
        let expected: Vec<usize> =
            valid.iter().copied().filter(|&j| !valid.iter().any(|&i| beats(i, j))).collect();
        let front = pareto_front(&asked).unwrap();
        prop_assert_eq!(&front.rows, &expected);
        prop_assert_eq!(front.left_out, rows.len() - valid.len());
    }
}

#[test]
fn best_designs_by_each_rule() {
    let groups = [3, 3, 3, 3, 4, 4];
    let delta_e = [1.0, 2.0, 2.0, 5.0, 0.5, f64::NAN];
    let mtf50 = [30.0, 60.0, 70.0, 90.0, 50.0, 99.0];
    let (color, detail) = (Objective::lower(&delta_e), Objective::higher(&mtf50));
    let best = |rule: Rule<'_>| best_per_group(&groups, &rule, 2).unwrap();
    // The best colour of group 3 has the worst detail; of the sharper half the two that follow tie to the one of row 2.
    assert_eq!(best(Rule::Keeping { best: color, keep: detail }), [(3, vec![2, 3]), (4, vec![4])]);
    assert_eq!(best(Rule::Lexicographic(vec![color])), [(3, vec![0, 1]), (4, vec![4])]);
    assert_eq!(best(Rule::Lexicographic(vec![color, detail])), [(3, vec![0, 2]), (4, vec![4])]);
    assert_eq!(best(Rule::Weighted(vec![(color, 0.0), (detail, 1.0)])), [(3, vec![3, 2]), (4, vec![4])]);
    assert_eq!(best(Rule::Weighted(vec![(color, 1.0), (detail, 1.0)])), [(3, vec![2, 1]), (4, vec![4])]);
    // The unit of a column does not matter to a weighted sum.
    let in_lines: Vec<f64> = mtf50.iter().map(|m| m * 2000.0).collect();
    assert_eq!(
        best(Rule::Weighted(vec![(color, 1.0), (Objective::higher(&in_lines), 1.0)])),
        best(Rule::Weighted(vec![(color, 1.0), (detail, 1.0)]))
    );
    assert_eq!(
        best_per_group(&groups, &Rule::Lexicographic(vec![color]), 0).unwrap(),
        [(3, vec![]), (4, vec![])]
    );
}
