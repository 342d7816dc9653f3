//! Observers whose choices the others do not explain.

use serde::Serialize;

use super::counts::Counts;
use super::model::Model;
use super::scale::{Penalty, fit};

/// The distance from which on an observer counts as an outlier ([perezortiz2017], section 9).
///
/// [perezortiz2017]: https://arxiv.org/abs/1712.03686
pub const OUTLIER_DISTANCE: f64 = 1.5;

/// How probable the choices of an observer are under the scale of all others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Likelihood {
    /// Mean decimal logarithm of the probability of the choices, over the compared pairs.
    pub mean_log10: f64,
    /// How far it lies below the first quartile of all observers, in interquartile ranges; 0 above it.
    pub distance: f64,
}

/// The likelihoods of observers. `choices` has for each observer the counts of each scene; scenes have scales of their own. `None` for
/// an observer without choices, or whose choices the others cannot predict because they compared too little.
#[must_use]
pub fn likelihoods(choices: &[Vec<Counts>]) -> Vec<Option<Likelihood>> {
    let means: Vec<Option<f64>> = (0..choices.len()).map(|observer| mean_log10(choices, observer)).collect();
    let mut sorted: Vec<f64> = means.iter().copied().flatten().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (first, third) = (quantile(&sorted, 0.25), quantile(&sorted, 0.75));
    let of = |mean: f64| {
        let below = (first - mean).max(0.0);
        let distance = if below > 0.0 { below / (third - first).max(f64::MIN_POSITIVE) } else { 0.0 };
        Likelihood { mean_log10: mean, distance }
    };
    means.into_iter().map(|mean| mean.map(of)).collect()
}

fn mean_log10(choices: &[Vec<Counts>], observer: usize) -> Option<f64> {
    let (mut sum, mut pairs) = (0.0, 0.0);
    for (scene, own) in choices.get(observer)?.iter().enumerate() {
        if own.total() == 0.0 {
            continue;
        }
        let mut others = Counts::new(own.conditions());
        for (_, of) in choices.iter().enumerate().filter(|(number, _)| *number != observer) {
            if let Some(counts) = of.get(scene) {
                others.merge(counts, 1.0);
            }
        }
        let scale = fit(&others, Model::ThurstoneCaseV, Penalty::Jeffreys).ok()?;
        for (a, b) in own.pairs().filter(|&(a, b)| own.compared(a, b) > 0.0) {
            let log_p = Model::ThurstoneCaseV.choice(scale.scores[a] - scale.scores[b]).log_p;
            let [k, l] = [own.wins(a, b), own.wins(b, a)];
            let ways = libm::lgamma(k + l + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(l + 1.0);
            sum += (ways + k * log_p[0] + l * log_p[1]) / std::f64::consts::LN_10;
            pairs += 1.0;
        }
    }
    (pairs > 0.0).then(|| sum / pairs)
}

/// The quantile of sorted values, interpolated between the points (i − ½) / n of the i-th value ([hyndman1996], definition 5).
///
/// [hyndman1996]: https://doi.org/10.1080/00031305.1996.10473566
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = (share * sorted.len() as f64 - 0.5).clamp(0.0, last as f64);
    let (below, part) = (at.floor() as usize, at.fract());
    sorted[below] + part * (sorted[(below + 1).min(last)] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    /// One of ten observers chooses the worse picture.
    #[test]
    fn an_observer_who_chooses_the_worse_one_is_an_outlier() {
        let truth = [0.0, 1.0, 2.0, 3.0];
        let observers: Vec<Vec<Counts>> = (0..10u32)
            .map(|observer| {
                let mut random = Stream::new(5, 1, observer);
                let mut counts = Counts::new(4);
                for (a, b) in counts.clone().pairs() {
                    for _ in 0..3 {
                        let p = Model::ThurstoneCaseV.probability(truth[a] - truth[b]);
                        let prefers_a = (random.uniform() < p) != (observer == 4);
                        if prefers_a { counts.add(a, b, 1.0) } else { counts.add(b, a, 1.0) }
                    }
                }
                vec![counts]
            })
            .collect();
        let found = likelihoods(&observers);
        let outliers: Vec<usize> =
            (0..10).filter(|&o| found[o].unwrap().distance > OUTLIER_DISTANCE).collect();
        assert_eq!(outliers, [4], "{found:?}");
        let none = likelihoods(&[vec![Counts::new(4)], observers[0].clone()]);
        assert_eq!(none, [None, None]);
    }

    #[test]
    fn quantiles_are_interpolated() {
        assert_eq!(quantile(&[1.0, 2.0, 3.0, 4.0], 0.25), 1.5);
        assert_eq!(quantile(&[1.0], 0.75), 1.0);
    }
}
