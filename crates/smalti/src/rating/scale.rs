//! Scores from counts of choices, by maximum likelihood.

use thiserror::Error;

use super::counts::Counts;
use super::model::Model;
use crate::numeric::dense::{cholesky, substitute};

/// Iterations after which a fit counts as failed.
const MAX_ITERATIONS: usize = 200;
/// Change of the scores at which the iteration ends.
const CONVERGED: f64 = 1e-9;

/// What is added to the likelihood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Penalty {
    /// Nothing: scores are infinite where all choices agree.
    None,
    /// Half the logarithm of the determinant of the Fisher information, which is Jeffreys' prior. Scores are finite for any choices, and
    /// their bias with few choices is smaller ([kosmidis2021]).
    ///
    /// [kosmidis2021]: https://doi.org/10.1093/biomet/asaa052
    Jeffreys,
}

/// Scores of conditions.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// The score of each condition; their mean is 0. JOD or the logarithm of odds, as the model states.
    pub scores: Vec<f64>,
    /// The covariance of the scores, row by row, from the Fisher information.
    pub covariance: Vec<f64>,
    /// Natural logarithm of the likelihood of the choices, without the penalty.
    pub log_likelihood: f64,
}

impl Scale {
    /// The standard error of the difference of two scores.
    #[must_use]
    pub fn standard_error(&self, a: usize, b: usize) -> f64 {
        let (n, c) = (self.scores.len(), &self.covariance);
        (c[a * n + a] + c[b * n + b] - 2.0 * c[a * n + b]).max(0.0).sqrt()
    }
}

/// Choices that have no scale.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ScaleError {
    /// There are fewer than two conditions.
    #[error("a scale needs at least two conditions")]
    TooFew,
    /// A condition has no chain of comparisons to the first one.
    #[error("no chain of comparisons connects condition {0} with condition 0")]
    Unconnected(usize),
    /// The likelihood has no maximum: some conditions won or lost all comparisons with the others.
    #[error("the likelihood has no maximum; expected choices both ways between all groups of conditions")]
    Unbounded,
}

/// The scores under which choices are the most likely. Their mean is 0.
///
/// # Errors
/// See [`ScaleError`].
pub fn fit(counts: &Counts, model: Model, penalty: Penalty) -> Result<Scale, ScaleError> {
    fit_from(counts, model, penalty, &vec![0.0; counts.conditions()])
}

/// [`fit`] from initial scores, one for each condition.
///
/// # Errors
/// See [`ScaleError`].
pub fn fit_from(
    counts: &Counts,
    model: Model,
    penalty: Penalty,
    initial: &[f64],
) -> Result<Scale, ScaleError> {
    let n = counts.conditions();
    if n < 2 || initial.len() != n {
        return Err(ScaleError::TooFew);
    }
    if let Some(condition) = counts.unconnected() {
        return Err(ScaleError::Unconnected(condition));
    }
    let pairs: Vec<Pair> = counts
        .pairs()
        .map(|(a, b)| Pair { a, b, wins: [counts.wins(a, b), counts.wins(b, a)] })
        .filter(|pair| pair.total() > 0.0)
        .collect();
    let mut at = State::new(&pairs, model, penalty, initial.to_vec()).ok_or(ScaleError::Unbounded)?;
    for _ in 0..MAX_ITERATIONS {
        let step = at.step(&pairs, model, penalty);
        let largest = step.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        if largest < CONVERGED {
            let log_likelihood = at.log_likelihood;
            return Ok(Scale { covariance: at.covariance(), scores: at.scores, log_likelihood });
        }
        // Half the step until the objective rises. A step of many units is cut, since the curvature is not that of the maximum.
        let mut share = (4.0 / largest).min(1.0);
        let mut next = None;
        while next.is_none() && share > 1e-10 {
            let scores = at.scores.iter().zip(&step).map(|(q, s)| q + share * s).collect();
            next = State::new(&pairs, model, penalty, scores)
                .filter(|n| n.objective >= at.objective - 1e-12 * at.objective.abs());
            share *= 0.5;
        }
        match next {
            Some(next) => at = next,
            None => break,
        }
    }
    Err(ScaleError::Unbounded)
}

/// Two conditions and how often each was preferred.
struct Pair {
    a: usize,
    b: usize,
    wins: [f64; 2],
}

impl Pair {
    fn total(&self) -> f64 {
        self.wins[0] + self.wins[1]
    }
}

/// Scores with the factorised Fisher information. Scores are determined up to a constant; the information of their mean is set to that of
/// the others, which leaves the differences as they are.
struct State {
    scores: Vec<f64>,
    factor: Vec<f64>,
    log_likelihood: f64,
    objective: f64,
}

impl State {
    /// `None` where the information is singular.
    fn new(pairs: &[Pair], model: Model, penalty: Penalty, scores: Vec<f64>) -> Option<Self> {
        let n = scores.len();
        let mut information = vec![0.0; n * n];
        let mut log_likelihood = 0.0;
        for pair in pairs {
            let choice = model.choice(scores[pair.a] - scores[pair.b]);
            log_likelihood += pair.wins[0] * choice.log_p[0] + pair.wins[1] * choice.log_p[1];
            let weight = pair.total() * choice.information;
            for (i, j, sign) in
                [(pair.a, pair.a, 1.0), (pair.b, pair.b, 1.0), (pair.a, pair.b, -1.0), (pair.b, pair.a, -1.0)]
            {
                information[i * n + j] += sign * weight;
            }
        }
        let mean = (0..n).map(|i| information[i * n + i]).sum::<f64>() / n as f64;
        information.iter_mut().for_each(|v| *v += mean / n as f64);
        let mut factor = information;
        if !cholesky(&mut factor, n, 1e-13 * mean) {
            return None;
        }
        let log_determinant: f64 = (0..n).map(|i| 2.0 * libm::log(factor[i * n + i])).sum();
        // Without the information of the mean.
        let penalised = match penalty {
            Penalty::None => 0.0,
            Penalty::Jeffreys => 0.5 * (log_determinant - libm::log(mean)),
        };
        Some(Self { scores, factor, log_likelihood, objective: log_likelihood + penalised })
    }

    /// The step of Fisher's scoring, with a mean of 0.
    fn step(&self, pairs: &[Pair], model: Model, penalty: Penalty) -> Vec<f64> {
        let n = self.scores.len();
        let mut gradient = vec![0.0; n];
        let covariance = (penalty == Penalty::Jeffreys).then(|| self.covariance());
        for pair in pairs {
            let choice = model.choice(self.scores[pair.a] - self.scores[pair.b]);
            let [log_p, log_q] = choice.log_p;
            let mut slope =
                choice.slope * (pair.wins[0] * libm::exp(-log_p) - pair.wins[1] * libm::exp(-log_q));
            if let Some(c) = &covariance {
                let (a, b) = (pair.a, pair.b);
                let variance = c[a * n + a] + c[b * n + b] - 2.0 * c[a * n + b];
                slope += 0.5 * pair.total() * choice.information * variance * choice.relative_change;
            }
            gradient[pair.a] += slope;
            gradient[pair.b] -= slope;
        }
        substitute(&self.factor, n, &mut gradient);
        let mean = gradient.iter().sum::<f64>() / n as f64;
        let own = self.scores.iter().sum::<f64>() / n as f64;
        gradient.iter().map(|g| g - mean - own).collect()
    }

    /// The covariance of the scores about their mean.
    fn covariance(&self) -> Vec<f64> {
        let n = self.scores.len();
        let mut covariance = vec![0.0; n * n];
        for (i, row) in covariance.chunks_exact_mut(n).enumerate() {
            // Unit vectors without their mean, so that the covariance is that of scores without theirs.
            row.iter_mut().enumerate().for_each(|(j, v)| *v = f64::from(i == j) - 1.0 / n as f64);
            substitute(&self.factor, n, row);
        }
        covariance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The scale of the first example of pwcmp: neighbours differ by 75 % of 100 choices, so by 1 JOD.
    #[test]
    fn three_quarters_are_one_unit_along_a_chain() {
        let mut counts = Counts::new(3);
        for (better, worse) in [(1, 0), (2, 1)] {
            counts.add(better, worse, 75.0);
            counts.add(worse, better, 25.0);
        }
        let scale = fit(&counts, Model::ThurstoneCaseV, Penalty::None).unwrap();
        for (score, expected) in scale.scores.iter().zip([-1.0, 0.0, 1.0]) {
            assert!((score - expected).abs() < 1e-6, "{:?}", scale.scores);
        }
        let odds = fit(&counts, Model::BradleyTerry, Penalty::None).unwrap();
        assert!((odds.scores[2] - odds.scores[1] - 3.0f64.ln()).abs() < 1e-6);
        // The information of 100 choices at p = 0.75: n φ² / (p q) for each link of the chain.
        let p: f64 = 0.75;
        let slope = Model::ThurstoneCaseV.choice(1.0).slope;
        let expected = (p * (1.0 - p) / (100.0 * slope * slope)).sqrt();
        assert!((scale.standard_error(1, 0) / expected - 1.0).abs() < 1e-6);
        assert!((scale.standard_error(2, 0) / (expected * 2.0f64.sqrt()) - 1.0).abs() < 1e-6);
    }

    /// With logistic choices between two conditions, Jeffreys' prior adds half a choice to each side.
    #[test]
    fn the_penalty_adds_half_a_choice_of_two_conditions() {
        let mut counts = Counts::new(2);
        counts.add(0, 1, 7.0);
        let scale = fit(&counts, Model::BradleyTerry, Penalty::Jeffreys).unwrap();
        assert!((scale.scores[0] - scale.scores[1] - (7.5f64 / 0.5).ln()).abs() < 1e-6, "{scale:?}");
        assert_eq!(fit(&counts, Model::BradleyTerry, Penalty::None), Err(ScaleError::Unbounded));
    }

    /// At the maximum no neighbour is better, and the scores do not depend on the start.
    #[test]
    fn the_scale_maximises_the_penalised_likelihood() {
        let mut counts = Counts::new(4);
        for (i, (a, b, wins, losses)) in
            [(0, 1, 5.0, 1.0), (1, 2, 6.0, 0.0), (2, 3, 3.0, 3.0), (0, 3, 4.0, 1.0)].into_iter().enumerate()
        {
            counts.add(a, b, wins + i as f64);
            counts.add(b, a, losses);
        }
        let pairs: Vec<Pair> = counts
            .pairs()
            .map(|(a, b)| Pair { a, b, wins: [counts.wins(a, b), counts.wins(b, a)] })
            .collect();
        for model in [Model::ThurstoneCaseV, Model::BradleyTerry] {
            let scale = fit(&counts, model, Penalty::Jeffreys).unwrap();
            let objective =
                |scores: Vec<f64>| State::new(&pairs, model, Penalty::Jeffreys, scores).unwrap().objective;
            let best = objective(scale.scores.clone());
            for i in 0..4 {
                for step in [-0.01, 0.01] {
                    let mut other = scale.scores.clone();
                    other[i] += step;
                    assert!(objective(other) < best, "{model:?} {i}");
                }
            }
            let again = fit_from(&counts, model, Penalty::Jeffreys, &[3.0, -2.0, 5.0, 0.0]).unwrap();
            for (a, b) in again.scores.iter().zip(&scale.scores) {
                assert!((a - b).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn what_has_no_scale_is_refused() {
        let mut counts = Counts::new(3);
        counts.add(0, 1, 1.0);
        let of = |c: &Counts| fit(c, Model::ThurstoneCaseV, Penalty::Jeffreys);
        assert_eq!(of(&counts), Err(ScaleError::Unconnected(2)));
        assert_eq!(of(&Counts::new(1)), Err(ScaleError::TooFew));
        counts.add(0, 2, 1000.0);
        assert!(of(&counts).unwrap().scores.iter().all(|s| s.is_finite()));
    }
}
