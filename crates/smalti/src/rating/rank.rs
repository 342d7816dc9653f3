//! Correlation of ranks.

/// The ranks of values, from 1; equal values share the mean of their ranks.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    for group in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let first = order.iter().position(|i| Some(i) == group.first()).unwrap_or_default();
        let mean = first as f64 + (group.len() + 1) as f64 / 2.0;
        group.iter().for_each(|&i| ranks[i] = mean);
    }
    ranks
}

/// Spearman's rank correlation, −1 to 1: the correlation of the ranks, where equal values share the mean of theirs. `None` if the
/// numbers of values differ, all values of one side are equal, or a value is not finite.
#[must_use]
pub fn spearman_rho(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.len() != b.len() || !a.iter().chain(b).all(|v| v.is_finite()) {
        return None;
    }
    let [a, b] = [ranks(a), ranks(b)];
    let mean = (a.len() + 1) as f64 / 2.0;
    let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - mean) * (y - mean)).sum::<f64>();
    let scale = (product(&a, &a) * product(&b, &b)).sqrt();
    (scale > 0.0).then(|| product(&a, &b) / scale)
}

/// Kendall's rank correlation τ-b, −1 to 1, which corrects for equal values ([kendall1945]). `None` as for [`spearman_rho`].
///
/// [kendall1945]: https://doi.org/10.1093/biomet/33.3.239
#[must_use]
pub fn kendall_tau_b(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.len() != b.len() || !a.iter().chain(b).all(|v| v.is_finite()) {
        return None;
    }
    let sign = |v: f64| if v > 0.0 { 1.0 } else { -f64::from(v < 0.0) };
    let (mut both, mut of_a, mut of_b) = (0.0, 0.0, 0.0);
    for i in 0..a.len() {
        for j in i + 1..a.len() {
            let (x, y) = (sign(a[i] - a[j]), sign(b[i] - b[j]));
            both += x * y;
            of_a += x * x;
            of_b += y * y;
        }
    }
    let scale = (of_a * of_b).sqrt();
    (scale > 0.0).then(|| both / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of `scipy.stats.spearmanr` and `kendalltau`, SciPy 1.17.1.
    #[test]
    fn correlations_agree_with_scipy() {
        let a = [1.0, 2.0, 2.0, 4.0, 5.0, 7.0];
        let b = [2.0, 1.0, 3.0, 3.0, 6.0, 5.0];
        assert!((spearman_rho(&a, &b).unwrap() - SPEARMAN).abs() < 1e-12, "{:?}", spearman_rho(&a, &b));
        assert!((kendall_tau_b(&a, &b).unwrap() - KENDALL).abs() < 1e-12, "{:?}", kendall_tau_b(&a, &b));
        let c: Vec<f64> = a.iter().map(|v| -v).collect();
        assert!((spearman_rho(&a, &c).unwrap() + 1.0).abs() < 1e-12);
        assert!((kendall_tau_b(&a, &c).unwrap() + 1.0).abs() < 1e-12);
    }
    const SPEARMAN: f64 = 0.808_823_529_411_764_7;
    const KENDALL: f64 = 0.642_857_142_857_142_9;

    #[test]
    fn what_has_no_ranks_has_no_correlation() {
        for (a, b) in
            [(&[1.0, 1.0][..], &[1.0, 2.0][..]), (&[1.0], &[1.0, 2.0]), (&[1.0, f64::NAN], &[1.0, 2.0])]
        {
            assert_eq!((spearman_rho(a, b), kendall_tau_b(a, b)), (None, None));
        }
        assert_eq!(spearman_rho(&[], &[]), None);
    }
}
