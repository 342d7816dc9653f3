//! Distributions for confidence intervals, from the regularised incomplete beta function.

/// Regularised incomplete beta function I_x(a, b) for a, b > 0, by its continued fraction ([dlmf2024], 8.17.22)
/// evaluated after Lentz.
pub(super) fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    // The fraction converges fast on this side of the mean; symmetry gives the other side.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let ln_beta = libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b);
    let front = libm::exp(a * libm::log(x) + b * libm::log1p(-x) - ln_beta) / a;
    const TINY: f64 = 1e-300;
    let nonzero = |v: f64| if v.abs() < TINY { TINY } else { v };
    let (mut c, mut d) = (1.0, 1.0 / nonzero(1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    // About √max(a, b) terms are needed; the limit suffices for a few hundred million designs.
    for i in 1..100_000u32 {
        let m = f64::from(i);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for term in [even, odd] {
            d = 1.0 / nonzero(1.0 + term * d);
            c = nonzero(1.0 + term / c);
            change *= c * d;
            fraction *= c * d;
        }
        if (change - 1.0).abs() < 1e-15 {
            break;
        }
    }
    (front * fraction).clamp(0.0, 1.0)
}

/// Probability of at most `k` successes in `n` trials.
fn binomial_cdf(k: usize, n: usize, probability: f64) -> f64 {
    if k >= n {
        return 1.0;
    }
    incomplete_beta(1.0 - probability, (n - k) as f64, k as f64 + 1.0)
}

/// The y in `0..=1` where an increasing function reaches `target`.
fn bisect(target: f64, increasing: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if increasing(middle) < target {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Two-sided quantile of Student's t with n − 1 degrees of freedom, n ≥ 2: half width of the confidence interval of a mean
/// in standard errors.
pub(super) fn student_t(confidence: f64, n: usize) -> f64 {
    let freedom = n as f64 - 1.0;
    // With y = t² / (ν + t²), P(|T| < t) = I_y(½, ν/2).
    let y = bisect(confidence, |y| incomplete_beta(y, 0.5, 0.5 * freedom));
    (freedom * y / (1.0 - y)).sqrt()
}

/// Two-sided quantile of the standard normal distribution.
pub(super) fn normal_z(confidence: f64) -> f64 {
    // The probability beyond 40 underflows an `f64`.
    40.0 * bisect(confidence, |y| libm::erf(40.0 * y * std::f64::consts::FRAC_1_SQRT_2))
}

/// Ranks (from 1) of the order statistics of `n` values that bound their quantile `probability` with at least the given
/// confidence, for any distribution; `None` where even the extreme value is no bound.
pub(super) fn quantile_ranks(n: usize, probability: f64, confidence: f64) -> (Option<usize>, Option<usize>) {
    let tail = 0.5 * (1.0 - confidence);
    // The first k in 0..n from which a condition holds.
    let first = |holds: &dyn Fn(usize) -> bool| {
        let (mut low, mut high) = (0, n);
        while low < high {
            let middle = low + (high - low) / 2;
            if holds(middle) {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        low
    };
    // The value of rank l exceeds the quantile when at most l − 1 values lie below it.
    let lower = first(&|k| binomial_cdf(k, n, probability) > tail);
    // The value of rank u is below the quantile when at least u values lie below it.
    let upper = first(&|k| binomial_cdf(k, n, probability) >= 1.0 - tail) + 1;
    (Some(lower).filter(|l| *l > 0), Some(upper).filter(|u| *u <= n))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SciPy 1.17, `special.betainc` and `stats.t.ppf`.
    #[test]
    fn scipy_constants() {
        for (x, a, b, expected) in [
            (0.3, 2.0, 3.0, 0.348_3),
            (0.05, 50.5, 900.0, 0.346_396_491_389_488_36),
            (0.5, 1e5, 1e5, 0.5),
            (0.951, 95_000.0, 5_001.0, 0.929_178_309_157_885_8),
        ] {
            let got = incomplete_beta(x, a, b);
            assert!((got - expected).abs() < 1e-9, "I_{x}({a}, {b}) = {got}, expected {expected}");
        }
        for (confidence, n, expected) in [
            (0.95, 2, 12.706_204_736_174_694),
            (0.95, 5, 2.776_445_105_197_793),
            (0.95, 200, 1.971_956_544_251_753),
            (0.99, 1000, 2.580_759_637_267_636),
            (0.90, 1_000_001, 1.644_855_150_722_04),
        ] {
            let got = student_t(confidence, n);
            assert!((got / expected - 1.0).abs() < 1e-8, "t({confidence}, {n}) = {got}, expected {expected}");
        }
        assert!((normal_z(0.95) - 1.959_963_984_540_054).abs() < 1e-12);
    }

    /// Ranks by SciPy's `stats.binom.cdf`.
    #[test]
    fn ranks_of_quantiles() {
        for (n, p, ranks) in [
            (200, 0.05, (4, 17)),
            (200, 0.5, (86, 115)),
            (200, 0.95, (184, 197)),
            (1000, 0.05, (37, 65)),
            (1000, 0.5, (469, 532)),
        ] {
            assert_eq!(quantile_ranks(n, p, 0.95), (Some(ranks.0), Some(ranks.1)), "n = {n}, p = {p}");
        }
        // 0.95^20 = 0.36: the smallest of 20 may well lie above the 5th percentile.
        assert_eq!(quantile_ranks(20, 0.05, 0.95).0, None);
        assert_eq!(quantile_ranks(0, 0.5, 0.95), (None, None));
    }
}
