//! What a search minimises.

use serde::{Deserialize, Serialize};

use crate::design::error::DesignError;
use crate::design::screen::{ExpectedError, FigureWeights, Figures};

/// Sharpness of the soft maximum of several costs, per unit. It lies below the maximum by at most the logarithm of their number divided by this.
const SHARPNESS: f64 = 20.0;

/// `objective` of a design: what is minimised, a weighted sum of the expected figures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Objective {
    /// Weight of a decibel of CPSNR.
    pub cpsnr_db: f64,
    /// Weight of a decibel of the signal-to-noise ratio of Y where the contrast is high.
    pub detail_db: f64,
    /// Weight of a unit of mean CIEDE2000.
    pub delta_e_2000: f64,
    /// Weight of a unit of the mean difference behind the opponent filters of S-CIELAB.
    pub scielab: f64,
    /// How the sums under several luminances and illuminants become one cost.
    pub over: Over,
}

/// How the costs under several conditions become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Over {
    /// Their mean.
    #[default]
    Mean,
    /// The worst change of any weighted figure under any condition from the camera's own array, as a soft maximum. An array that is better in every
    /// figure everywhere has a negative cost.
    Worst,
}

impl Default for Objective {
    /// A decibel of CPSNR counts as much as a colour difference of 1.
    fn default() -> Self {
        Self { cpsnr_db: 1.0, detail_db: 0.0, delta_e_2000: 1.0, scielab: 0.0, over: Over::Mean }
    }
}

impl Objective {
    /// Checks the weights.
    ///
    /// # Errors
    /// [`DesignError::Key`] when a weight is negative or not finite, or all are zero.
    pub fn validate(&self) -> Result<(), DesignError> {
        ensure_weights("objective", [self.cpsnr_db, self.detail_db, self.delta_e_2000, self.scielab])
    }

    /// The goal under some conditions, whose expected errors with the camera's own array are `own`.
    #[must_use]
    pub fn goal(&self, own: &[ExpectedError]) -> Goal {
        let none = FigureWeights::default();
        let figures = [
            FigureWeights { cpsnr_db: -self.cpsnr_db, ..none },
            FigureWeights { detail_db: -self.detail_db, ..none },
            FigureWeights { delta_e_2000: self.delta_e_2000, ..none },
            FigureWeights { scielab: self.scielab, ..none },
        ];
        let n = own.len();
        let aims = match self.over {
            Over::Mean => {
                vec![Aim::mean(figures.iter().fold(none, |sum, figure| sum.plus(figure)), n, |_| true)]
            }
            Over::Worst => {
                let of = |(at, figure): (usize, &FigureWeights)| {
                    let aim = Aim::mean(*figure, n, |c| c == at);
                    let offset = aim.value(own);
                    Aim { offset, ..aim }
                };
                let weighted = figures.iter().filter(|figure| **figure != none);
                weighted.flat_map(|figure| (0..n).map(move |at| (at, figure))).map(of).collect()
            }
        };
        Goal { aims }
    }
}

/// Checks the weights of CPSNR, detail, CIEDE2000 and S-CIELAB in a table.
fn ensure_weights(table: &str, weights: [f64; 4]) -> Result<(), DesignError> {
    let keys = ["cpsnr_db", "detail_db", "delta_e_2000", "scielab"];
    if let Some((key, value)) = keys.iter().zip(weights).find(|(_, w)| !(w.is_finite() && *w >= 0.0)) {
        return Err(DesignError::key(format!("{table}.{key}"), format!("{value}; expected 0 or more")));
    }
    if weights.iter().all(|w| *w == 0.0) {
        let message = "expected a weight above 0: cpsnr_db, detail_db, delta_e_2000 or scielab";
        return Err(DesignError::key(table, message));
    }
    Ok(())
}

/// `front` of a design: the best compromises between several aims.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Front {
    /// The aims, two or three.
    pub aims: Vec<FrontAim>,
    /// Number of compromises between each pair of aims, with both ends, 3 to 50.
    #[serde(default = "default_points")]
    pub points: usize,
    /// Whether the number of filters, each a coating more to apply, is an aim as well: the compromises are searched for each number in `colors`, and an array
    /// with fewer filters stays beside a better one with more.
    #[serde(default)]
    pub filters: bool,
}

fn default_points() -> usize {
    7
}

/// An aim of a front: a weighted sum of figures under some of the luminances.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FrontAim {
    /// Its name, such as "noise in the dark".
    pub name: String,
    /// Weight of a decibel of CPSNR.
    #[serde(default)]
    pub cpsnr_db: f64,
    /// Weight of a decibel of the signal-to-noise ratio of Y where the contrast is high.
    #[serde(default)]
    pub detail_db: f64,
    /// Weight of a unit of mean CIEDE2000.
    #[serde(default)]
    pub delta_e_2000: f64,
    /// Weight of a unit of the mean difference behind the opponent filters of S-CIELAB.
    #[serde(default)]
    pub scielab: f64,
    /// The luminances that it is about, cd/m². The default is all of the design.
    pub luminances_cd_m2: Option<Vec<f64>>,
}

impl Front {
    /// Checks the aims against the luminances of the design.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the first aim that is empty or not of the design.
    pub fn validate(&self, luminances_cd_m2: &[f64]) -> Result<(), DesignError> {
        if !(2..=3).contains(&self.aims.len()) {
            let message = format!("{} aims; expected 2 or 3", self.aims.len());
            return Err(DesignError::key("front.aims", message));
        }
        if !(3..=50).contains(&self.points) {
            return Err(DesignError::key("front.points", format!("{}; expected 3 to 50", self.points)));
        }
        for (at, aim) in self.aims.iter().enumerate() {
            let table = format!("front.aims[{at}]");
            ensure_weights(&table, [aim.cpsnr_db, aim.detail_db, aim.delta_e_2000, aim.scielab])?;
            let asked = aim.luminances_cd_m2.as_deref();
            let unknown = asked.and_then(|l| l.iter().find(|v| !luminances_cd_m2.contains(v)));
            if let Some(other) = unknown {
                let message =
                    format!("{other} is not among the luminances of the design, {luminances_cd_m2:?}");
                return Err(DesignError::key(format!("{table}.luminances_cd_m2"), message));
            }
            if asked.is_some_and(<[f64]>::is_empty) {
                let message = "expected at least one luminance";
                return Err(DesignError::key(format!("{table}.luminances_cd_m2"), message));
            }
        }
        Ok(())
    }

    /// The shares of the aims in each compromise, which sum to 1: the corners first.
    #[must_use]
    pub fn shares(&self) -> Vec<Vec<f64>> {
        let (count, steps) = (self.aims.len(), self.points - 1);
        let mut all: Vec<Vec<usize>> = vec![Vec::new()];
        for place in 0..count {
            let extended = |part: Vec<usize>| {
                let left = steps - part.iter().sum::<usize>();
                let least = if place + 1 == count { left } else { 0 };
                (least..=left).map(move |n| part.iter().copied().chain([n]).collect::<Vec<usize>>())
            };
            all = all.into_iter().flat_map(extended).collect();
        }
        let mut corners: Vec<Vec<usize>> = Vec::new();
        all.retain(|part| {
            let is_corner = part.contains(&steps);
            if is_corner {
                corners.push(part.clone());
            }
            !is_corner
        });
        corners.sort_by(|a, b| b.cmp(a));
        corners.append(&mut all);
        corners.into_iter().map(|p| p.into_iter().map(|n| n as f64 / steps as f64).collect()).collect()
    }
}

impl FrontAim {
    /// The goal of this aim alone, for conditions of the given luminances.
    #[must_use]
    pub fn goal(&self, luminances_cd_m2: &[f64]) -> Goal {
        let figures = FigureWeights {
            cpsnr_db: -self.cpsnr_db,
            detail_db: -self.detail_db,
            delta_e_2000: self.delta_e_2000,
            scielab: self.scielab,
        };
        let asked = self.luminances_cd_m2.as_deref();
        let counts = |c: usize| asked.is_none_or(|l| luminances_cd_m2.get(c).is_some_and(|v| l.contains(v)));
        Goal { aims: vec![Aim::mean(figures, luminances_cd_m2.len(), counts)] }
    }
}

/// A weighted sum of figures, from a value that it should reach, in some unit.
#[derive(Debug, Clone, PartialEq)]
struct Aim {
    /// By condition.
    weights: Vec<FigureWeights>,
    /// The value that counts as 0.
    offset: f64,
    /// The factor of what lies above it.
    scale: f64,
}

impl Aim {
    /// The mean over those of `n` conditions that count.
    fn mean(figures: FigureWeights, n: usize, counts: impl Fn(usize) -> bool) -> Self {
        let share = 1.0 / (0..n).filter(|c| counts(*c)).count().max(1) as f64;
        let of = |c: usize| if counts(c) { figures.scaled(share) } else { FigureWeights::default() };
        Self { weights: (0..n).map(of).collect(), offset: 0.0, scale: 1.0 }
    }

    fn value(&self, expected: &[ExpectedError]) -> f64 {
        let sum: f64 = self.weights.iter().zip(expected).map(|(w, e)| w.of(e)).sum();
        (sum - self.offset) * self.scale
    }
}

/// What is minimised: the weighted sum of an aim, or the soft maximum of several.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    aims: Vec<Aim>,
}

impl Goal {
    /// The greatest of several goals, each by what it lies above its `best` value in units of `span`, times its share: a point of a front
    /// that weighted sums may miss ([miettinen1998], section 3.4).
    ///
    /// [miettinen1998]: https://doi.org/10.1007/978-1-4615-5563-6
    #[must_use]
    pub fn compromise(goals: &[Self], shares: &[f64], best: &[f64], span: &[f64]) -> Self {
        let mut aims = Vec::new();
        for (((goal, share), best), span) in goals.iter().zip(shares).zip(best).zip(span) {
            // Without a small share, an aim of share 0 would be free to be as bad as it likes.
            let scale = share.max(1e-3) / span.max(f64::MIN_POSITIVE);
            aims.extend(goal.aims.iter().map(|aim| Aim { offset: *best, scale, ..aim.clone() }));
        }
        Self { aims }
    }

    /// The cost of expected errors: less is better.
    #[must_use]
    pub fn cost(&self, expected: &[ExpectedError]) -> f64 {
        self.differentiated(expected).0
    }

    /// The figures that count.
    pub(super) fn figures(&self) -> Figures {
        let has = |of: fn(&FigureWeights) -> f64| {
            self.aims.iter().flat_map(|aim| &aim.weights).any(|w| of(w) != 0.0)
        };
        match (has(|w| w.scielab), has(|w| w.delta_e_2000)) {
            (true, _) => Figures::All,
            (false, true) => Figures::Color,
            (false, false) => Figures::Cpsnr,
        }
    }

    /// The cost and its derivatives with respect to the figures of each condition.
    pub(super) fn differentiated(&self, expected: &[ExpectedError]) -> (f64, Vec<FigureWeights>) {
        if let [aim] = &self.aims[..] {
            let weights = aim.weights.iter().map(|w| w.scaled(aim.scale)).collect();
            return (aim.value(expected), weights);
        }
        let values: Vec<f64> = self.aims.iter().map(|aim| aim.value(expected)).collect();
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let powers: Vec<f64> = values.iter().map(|v| libm::exp(SHARPNESS * (v - most))).collect();
        let sum: f64 = powers.iter().sum();
        let mut weights = vec![FigureWeights::default(); expected.len()];
        for (aim, power) in self.aims.iter().zip(&powers) {
            let share = power / sum * aim.scale;
            weights.iter_mut().zip(&aim.weights).for_each(|(w, of_aim)| *w = w.plus(&of_aim.scaled(share)));
        }
        (most + libm::log(sum / powers.len() as f64) / SHARPNESS, weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expected(cpsnr_db: f64, delta_e_2000: f64) -> ExpectedError {
        ExpectedError {
            cpsnr_db,
            detail_db: cpsnr_db + 3.0,
            delta_e_2000,
            scielab: 0.5 * delta_e_2000,
            time_s: 0.1,
        }
    }

    #[test]
    fn the_worst_change_counts() {
        let own = [expected(25.0, 9.0), expected(35.0, 3.0)];
        let objective = Objective { over: Over::Worst, ..Objective::default() };
        let goal = objective.goal(&own);
        assert!(goal.cost(&own).abs() < 1e-12);
        // Better by 3 in the dark, worse by 1 in the light.
        let cost = goal.cost(&[expected(28.0, 9.0), expected(34.0, 3.0)]);
        assert!((1.0 - 4f64.ln() / SHARPNESS - 1e-9..=1.0).contains(&cost), "{cost}");
        // A gain in one figure does not make up for a loss in another.
        let cost = goal.cost(&[expected(28.0, 10.0), expected(38.0, 3.0)]);
        assert!((1.0 - 4f64.ln() / SHARPNESS - 1e-9..=1.0).contains(&cost), "{cost}");
        // The mean would have preferred it.
        assert!(
            Objective::default().goal(&own).cost(&own) > {
                Objective::default().goal(&own).cost(&[expected(28.0, 9.0), expected(34.0, 3.0)])
            }
        );
    }

    /// CPSNR alone, under all conditions.
    fn aim(name: &str) -> FrontAim {
        FrontAim {
            name: name.into(),
            cpsnr_db: 1.0,
            detail_db: 0.0,
            delta_e_2000: 0.0,
            scielab: 0.0,
            luminances_cd_m2: None,
        }
    }

    /// The derivatives of a goal are those of finite differences.
    fn assert_derivatives(goal: &Goal, at: [ExpectedError; 2]) {
        let (_, weights) = goal.differentiated(&at);
        for condition in 0..2 {
            let slope = |change: &dyn Fn(&mut ExpectedError, f64)| {
                let moved = |by: f64| {
                    let mut at = at;
                    change(&mut at[condition], by);
                    goal.cost(&at)
                };
                (moved(1e-6) - moved(-1e-6)) / 2e-6
            };
            assert!((slope(&|e, by| e.cpsnr_db += by) - weights[condition].cpsnr_db).abs() < 1e-7);
            assert!((slope(&|e, by| e.detail_db += by) - weights[condition].detail_db).abs() < 1e-7);
            assert!((slope(&|e, by| e.delta_e_2000 += by) - weights[condition].delta_e_2000).abs() < 1e-7);
            assert!((slope(&|e, by| e.scielab += by) - weights[condition].scielab).abs() < 1e-7);
        }
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let own = [expected(25.0, 9.0), expected(35.0, 3.0)];
        let objective = Objective { detail_db: 0.5, scielab: 0.7, over: Over::Worst, ..Objective::default() };
        let goal = objective.goal(&own);
        let at = [expected(25.02, 9.0), expected(35.03, 3.01)];
        assert_derivatives(&goal, at);
    }

    #[test]
    fn a_front_has_its_corners_first_and_shares_that_sum_to_one() {
        let two = Front { aims: vec![aim("a"), aim("b")], points: 5, filters: false };
        assert_eq!(two.shares()[..3], [vec![1.0, 0.0], vec![0.0, 1.0], vec![0.25, 0.75]]);
        let three = Front { aims: vec![aim("a"), aim("b"), aim("c")], points: 4, filters: false };
        let shares = three.shares();
        assert_eq!(shares.len(), 10);
        assert_eq!(shares[..3], [vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0], vec![0.0, 0.0, 1.0]]);
        assert!(shares.iter().all(|s| (s.iter().sum::<f64>() - 1.0).abs() < 1e-12));
    }

    #[test]
    fn impossible_objectives_name_the_key() {
        let key = |found: Result<(), DesignError>| match found {
            Err(DesignError::Key { key, .. }) => key,
            other => panic!("{other:?}"),
        };
        let none = Objective { cpsnr_db: 0.0, delta_e_2000: 0.0, ..Objective::default() };
        assert_eq!(key(none.validate()), "objective");
        let negative = Objective { detail_db: -1.0, ..Objective::default() };
        assert_eq!(key(negative.validate()), "objective.detail_db");
        let aim = FrontAim { luminances_cd_m2: Some(vec![7.0]), ..aim("a") };
        let front = Front { aims: vec![aim.clone(), aim], points: 5, filters: false };
        assert_eq!(key(front.validate(&[1.0, 10.0])), "front.aims[0].luminances_cd_m2");
    }

    /// A compromise is the greatest of its goals, each above its best value in units of its span and times its share, to the softness
    /// of the maximum, and its derivatives are those of finite differences.
    #[test]
    fn a_compromise_follows_the_greatest_of_its_goals() {
        let dark = FrontAim { luminances_cd_m2: Some(vec![1.0]), ..aim("dark") };
        let seen = FrontAim { cpsnr_db: 0.0, delta_e_2000: 1.0, scielab: 0.5, detail_db: 0.2, ..aim("seen") };
        let goals = [dark, seen].map(|aim| aim.goal(&[1.0, 10.0]));
        let (shares, best, span) = ([0.3, 0.7], [-30.0, -3.5], [2.0, 4.0]);
        let goal = Goal::compromise(&goals, &shares, &best, &span);
        assert_eq!(goal.figures(), Figures::All);
        for decibels in [20.0, 25.0, 30.0, 33.0] {
            let at = [expected(decibels, 9.0), expected(35.0, 3.0)];
            // The first is of one condition, the second the mean of both.
            let sums = [
                -decibels,
                0.5 * (9.0 + 0.5 * 4.5 - 0.2 * (decibels + 3.0)) + 0.5 * (3.0 + 0.5 * 1.5 - 0.2 * 38.0),
            ];
            let values = [0, 1].map(|i| shares[i] * (sums[i] - best[i]) / span[i]);
            let most = values[0].max(values[1]);
            let cost = goal.cost(&at);
            assert!((most - 2f64.ln() / SHARPNESS - 1e-9..=most).contains(&cost), "{cost} {values:?}");
            assert_derivatives(&goal, at);
        }
    }

    /// A unit of a figure under one of two conditions moves the mean by half its weight, and the worst change by its weight, to the softness
    /// of the maximum. Only the figures with a weight are computed.
    #[test]
    fn every_figure_counts_by_its_weight() {
        let own = [expected(25.0, 9.0), expected(35.0, 3.0)];
        let moves: [fn(&mut ExpectedError); 4] =
            [|e| e.cpsnr_db -= 1.0, |e| e.detail_db -= 1.0, |e| e.delta_e_2000 += 1.0, |e| e.scielab += 1.0];
        let figures = [Figures::Cpsnr, Figures::Cpsnr, Figures::Color, Figures::All];
        let of = |[cpsnr_db, detail_db, delta_e_2000, scielab]: [f64; 4], over| {
            Objective { cpsnr_db, detail_db, delta_e_2000, scielab, over }.goal(&own)
        };
        let weights = [1.0, 0.5, 2.0, 3.0];
        for (at, worsen) in moves.iter().enumerate() {
            let mut worse = own;
            worsen(&mut worse[1]);
            let all = of(weights, Over::Mean);
            let change = all.cost(&worse) - all.cost(&own);
            assert!((change - 0.5 * weights[at]).abs() < 1e-12, "{at}: {change}");
            let worst = of(weights, Over::Worst).cost(&worse);
            assert!(
                (weights[at] - 8f64.ln() / SHARPNESS - 1e-9..=weights[at]).contains(&worst),
                "{at}: {worst}"
            );
            let mut one = [0.0; 4];
            one[at] = weights[at];
            let alone = [Over::Mean, Over::Worst].map(|over| of(one, over).figures());
            assert_eq!(alone, [figures[at]; 2]);
        }
    }
}
