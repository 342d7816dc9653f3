//! The probability of a choice as a function of the difference of two scores.

use std::f64::consts::{PI, SQRT_2};

/// The standard deviation of the difference of two impressions, JOD: a normal distribution with it is 0.75 at 1.
pub const JOD_DEVIATION: f64 = 1.482_602_218_505_602;

/// Differences beyond this number of standard deviations count as this number, where the probabilities have no more digits.
const FAR: f64 = 30.0;

/// A model of choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Thurstone's Case V ([thurstone1927]): normal impressions of equal spread. Scores are in JOD.
    ///
    /// [thurstone1927]: https://doi.org/10.1037/h0070288
    ThurstoneCaseV,
    /// [bradley1952]: scores are natural logarithms of odds.
    ///
    /// [bradley1952]: https://doi.org/10.2307/2334029
    BradleyTerry,
}

/// The probability of a choice and what its estimation needs, at a difference of scores.
#[derive(Debug, Clone, Copy)]
pub(super) struct Choice {
    /// Natural logarithm of the probability of the choice, and of that of the other choice.
    pub(super) log_p: [f64; 2],
    /// Derivative of the probability.
    pub(super) slope: f64,
    /// Fisher information of one choice about the difference.
    pub(super) information: f64,
    /// Derivative of the information, divided by it.
    pub(super) relative_change: f64,
}

impl Model {
    /// The probability that a condition is preferred whose score exceeds that of the other by `difference`.
    #[must_use]
    pub fn probability(self, difference: f64) -> f64 {
        match self {
            Self::ThurstoneCaseV => normal_cdf(difference / JOD_DEVIATION),
            Self::BradleyTerry => 1.0 / (1.0 + libm::exp(-difference)),
        }
    }

    pub(super) fn choice(self, difference: f64) -> Choice {
        match self {
            Self::ThurstoneCaseV => {
                let x = (difference / JOD_DEVIATION).clamp(-FAR, FAR);
                let log_p = [libm::log(normal_cdf(x)), libm::log(normal_cdf(-x))];
                let density = normal_density(x);
                let log_density = libm::log(density);
                // φ / Φ on both sides, by logarithms: both may be tiny.
                let [above, below] = log_p.map(|log| libm::exp(log_density - log));
                Choice {
                    log_p,
                    slope: density / JOD_DEVIATION,
                    information: above * below / (JOD_DEVIATION * JOD_DEVIATION),
                    relative_change: (below - above - 2.0 * x) / JOD_DEVIATION,
                }
            }
            Self::BradleyTerry => {
                let x = difference.clamp(-FAR, FAR);
                let log_p = [-libm::log1p(libm::exp(-x)), -libm::log1p(libm::exp(x))];
                let [p, q] = log_p.map(libm::exp);
                Choice { log_p, slope: p * q, information: p * q, relative_change: q - p }
            }
        }
    }
}

/// The standard normal distribution function.
pub(super) fn normal_cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x / SQRT_2)
}

/// The standard normal density.
pub(super) fn normal_density(x: f64) -> f64 {
    libm::exp(-0.5 * x * x) / (2.0 * PI).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_jod_is_three_quarters() {
        assert!((Model::ThurstoneCaseV.probability(1.0) - 0.75).abs() < 1e-12);
        assert!((Model::BradleyTerry.probability(3.0f64.ln()) - 0.75).abs() < 1e-12);
    }

    /// Slope, information and its relative change are the derivatives that they are said to be, by central differences.
    #[test]
    fn derivatives_agree_with_differences() {
        for model in [Model::ThurstoneCaseV, Model::BradleyTerry] {
            for d in [-6.0, -1.3, 0.0, 0.4, 5.0] {
                let (h, here) = (1e-5, model.choice(d));
                let [after, before] = [d + h, d - h].map(|d| model.choice(d));
                let p = libm::exp(here.log_p[0]);
                let slope = (libm::exp(after.log_p[0]) - libm::exp(before.log_p[0])) / (2.0 * h);
                assert!((here.slope / slope - 1.0).abs() < 1e-5, "{model:?} {d}");
                let information = slope * slope / (p * libm::exp(here.log_p[1]));
                assert!((here.information / information - 1.0).abs() < 1e-4, "{model:?} {d}");
                let change = (after.information.ln() - before.information.ln()) / (2.0 * h);
                assert!((here.relative_change - change).abs() < 1e-5, "{model:?} {d}");
            }
            let far = model.choice(1e9);
            assert!(far.log_p.iter().all(|v| v.is_finite()) && far.information > 0.0);
        }
    }
}
