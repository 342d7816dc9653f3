//! Which pair an observer sees next: an order of ratings, hidden repeats and traps that depends on the seed and the observer, and pairs
//! that depend on the answers so far.

use serde::{Deserialize, Serialize};

use super::active::Posterior;
use super::counts::Counts;
use crate::numeric::philox::Stream;

/// Separate the random numbers of one seed.
const ROLES: u32 = 0x726f_6c65;
const SIDES: u32 = 0x7369_6465;
const SCENES: u32 = 0x7363_6e65;
const PAIRS: u32 = 0x7061_6972;
/// The smallest number of trials between a pair and its hidden repeat.
const REPEAT_DISTANCE: usize = 4;

/// What an experiment asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Question {
    /// A scale of all conditions: any two of them are compared.
    Scale,
    /// The light at which the other conditions, in several amounts of light, look like the standard: each is compared with the standard
    /// alone (method of constant stimuli).
    Light {
        /// The number of the standard condition.
        standard: usize,
    },
}

/// Why a pair is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Training, which does not count.
    Training,
    /// A rating.
    Rating,
    /// A rating for the second time, with the sides exchanged.
    Repeat,
    /// The reference itself against a coarse picture, to find observers who do not look.
    Trap,
}

/// What is shown on a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shown {
    /// The picture of a condition.
    Condition(usize),
    /// The reference.
    Reference,
    /// The picture that is plainly worse.
    Coarse,
}

/// A side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Left, also the first.
    Left,
    /// Right, also the second.
    Right,
}

/// A pair of pictures of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trial {
    /// Why it is shown.
    pub role: Role,
    /// The number of the scene.
    pub scene: usize,
    /// The picture on the left.
    pub left: Shown,
    /// The picture on the right.
    pub right: Shown,
}

impl Trial {
    /// The picture on a side.
    #[must_use]
    pub fn on(&self, side: Side) -> Shown {
        match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
    }

    /// The two conditions, in ascending order; `None` for a trap.
    #[must_use]
    pub fn pair(&self) -> Option<(usize, usize)> {
        match (self.left, self.right) {
            (Shown::Condition(a), Shown::Condition(b)) => Some((a.min(b), a.max(b))),
            _ => None,
        }
    }
}

/// The schedule of an experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Schedule {
    /// Ratings of each observer, hidden repeats and traps not counted.
    pub ratings: usize,
    /// Hidden repeats.
    pub repeats: usize,
    /// Traps.
    pub traps: usize,
    /// Training trials before all others.
    pub training: usize,
    /// Trials between breaks.
    pub break_every: usize,
}

impl Schedule {
    /// All trials of an observer.
    #[must_use]
    pub fn trials(&self) -> usize {
        self.training + self.ratings + self.repeats + self.traps
    }

    /// The roles of an observer's trials. Repeats and traps are anywhere but among the first ratings.
    fn roles(&self, seed: u64, observer: u32) -> Vec<Role> {
        let mut random = Stream::new(seed, ROLES, observer);
        let first = (REPEAT_DISTANCE + 1).min(self.ratings);
        let mut rest: Vec<Role> = std::iter::repeat_n(Role::Rating, self.ratings - first)
            .chain(std::iter::repeat_n(Role::Repeat, self.repeats))
            .chain(std::iter::repeat_n(Role::Trap, self.traps))
            .collect();
        shuffle(&mut rest, &mut random);
        let training = std::iter::repeat_n(Role::Training, self.training);
        training.chain(std::iter::repeat_n(Role::Rating, first)).chain(rest).collect()
    }

    /// The next trial of an observer: `own` are the trials so far, answered or not, and `answers` the counts of all observers on each
    /// scene. `pending` are pairs that other observers look at now; they are avoided while others are left. `None` after the last trial.
    #[must_use]
    pub fn next(
        &self,
        question: Question,
        (seed, observer): (u64, u32),
        own: &[Trial],
        answers: &[Counts],
        pending: &[(usize, (usize, usize))],
    ) -> Option<Trial> {
        let number = own.len();
        let role = *self.roles(seed, observer).get(number)?;
        let scenes = answers.len();
        let conditions = answers.first()?.conditions();
        let rated = own.iter().filter(|t| t.role == Role::Rating).count();
        let mut random = Stream::new(seed, SIDES ^ observer, number as u32);
        let (scene, left, right) = match role {
            Role::Trap => (random.below(scenes as u32) as usize, Shown::Reference, Shown::Coarse),
            Role::Repeat => {
                let repeat = repeated(own, &mut random)?;
                // The other side: an observer who prefers a side is inconsistent.
                return Some(Trial { role, left: repeat.right, right: repeat.left, ..repeat });
            }
            Role::Training | Role::Rating => {
                let (scene, (a, b)) = match (question, role) {
                    (Question::Light { standard }, Role::Rating) => {
                        constant_stimulus((seed, observer), rated, (scenes, conditions, standard))?
                    }
                    (Question::Light { standard }, _) => {
                        let others: Vec<usize> = (0..conditions).filter(|c| *c != standard).collect();
                        let other = *others.get(random.below(others.len() as u32) as usize)?;
                        (random.below(scenes as u32) as usize, (standard, other))
                    }
                    (Question::Scale, _) => {
                        let compared =
                            own.iter().filter(|t| matches!(t.role, Role::Training | Role::Rating)).count();
                        let scene = scene_of((seed, observer), compared, scenes);
                        (scene, active_pair((seed, observer), scene, own, &answers[scene], pending)?)
                    }
                };
                (scene, Shown::Condition(a), Shown::Condition(b))
            }
        };
        let (left, right) = if random.below(2) == 0 { (left, right) } else { (right, left) };
        Some(Trial { role, scene, left, right })
    }
}

/// A rating that was not repeated yet and lies far enough back, else any rating.
fn repeated(own: &[Trial], random: &mut Stream) -> Option<Trial> {
    let is_repeated =
        |t: &Trial| own.iter().any(|r| r.role == Role::Repeat && (r.scene, r.pair()) == (t.scene, t.pair()));
    let ratings = |until: usize| own[..until].iter().filter(|t| t.role == Role::Rating);
    let early = ratings(own.len().saturating_sub(REPEAT_DISTANCE - 1));
    let mut candidates: Vec<Trial> = early.filter(|t| !is_repeated(t)).copied().collect();
    if candidates.is_empty() {
        candidates = ratings(own.len()).copied().collect();
    }
    candidates.get(random.below(candidates.len() as u32) as usize).copied()
}

/// The scene of the rating or training trial after `compared` such trials: every scene once in each round, in an order of the round's own.
fn scene_of((seed, observer): (u64, u32), compared: usize, scenes: usize) -> usize {
    let round = compared / scenes.max(1);
    let mut order: Vec<usize> = (0..scenes).collect();
    shuffle(&mut order, &mut Stream::new(seed, SCENES ^ observer, round as u32));
    order.get(compared % scenes.max(1)).copied().unwrap_or_default()
}

/// The pair of a scene whose answer is expected to tell the most. Pairs that the observer has seen on this scene come last.
fn active_pair(
    (seed, observer): (u64, u32),
    scene: usize,
    own: &[Trial],
    answers: &Counts,
    pending: &[(usize, (usize, usize))],
) -> Option<(usize, usize)> {
    let posterior = Posterior::of(answers);
    let mut pairs: Vec<(usize, usize)> = answers.pairs().collect();
    shuffle(&mut pairs, &mut Stream::new(seed, PAIRS ^ observer, own.len() as u32));
    let times_seen = |pair: &(usize, usize)| {
        own.iter().filter(|t| t.scene == scene && t.pair().as_ref() == Some(pair)).count()
    };
    let least = pairs.iter().map(times_seen).min()?;
    let fresh: Vec<(usize, usize)> = pairs.into_iter().filter(|p| times_seen(p) == least).collect();
    let free = fresh.iter().copied().filter(|pair| !pending.contains(&(scene, *pair)));
    posterior.best_pair(free).or_else(|| posterior.best_pair(fresh))
}

/// The scene and the pair of a rating with the standard: each level on each scene once in each round, in an order of its own.
fn constant_stimulus(
    (seed, observer): (u64, u32),
    rated: usize,
    (scenes, conditions, standard): (usize, usize, usize),
) -> Option<(usize, (usize, usize))> {
    let levels = (0..conditions).filter(|c| *c != standard);
    let mut all: Vec<(usize, usize)> = levels.flat_map(|c| (0..scenes).map(move |s| (s, c))).collect();
    let round = rated.checked_div(all.len())?;
    shuffle(&mut all, &mut Stream::new(seed, PAIRS ^ observer, round as u32));
    let (scene, condition) = *all.get(rated % all.len())?;
    Some((scene, (standard, condition)))
}

/// Fisher and Yates.
fn shuffle<T>(items: &mut [T], random: &mut Stream) {
    for last in (1..items.len()).rev() {
        items.swap(last, random.below(last as u32 + 1) as usize);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCHEDULE: Schedule = Schedule { ratings: 24, repeats: 4, traps: 3, training: 2, break_every: 10 };

    fn run(question: Question, seed: u64, observer: u32, answers: &mut [Counts]) -> Vec<Trial> {
        let mut own = Vec::new();
        while let Some(trial) = SCHEDULE.next(question, (seed, observer), &own, answers, &[]) {
            if let (Role::Rating, Shown::Condition(a), Shown::Condition(b)) =
                (trial.role, trial.left, trial.right)
            {
                answers[trial.scene].add(a.max(b), a.min(b), 1.0);
            }
            own.push(trial);
        }
        own
    }

    fn scenes() -> Vec<Counts> {
        vec![Counts::new(4); 3]
    }

    #[test]
    fn a_schedule_has_its_trials_and_depends_on_seed_and_observer() {
        let all = run(Question::Scale, 1, 1, &mut scenes());
        assert_eq!(all.len(), SCHEDULE.trials());
        let count = |role| all.iter().filter(|t| t.role == role).count();
        assert_eq!([Role::Training, Role::Rating, Role::Repeat, Role::Trap].map(count), [2, 24, 4, 3]);
        assert!(all[..2].iter().all(|t| t.role == Role::Training));
        assert_eq!(all, run(Question::Scale, 1, 1, &mut scenes()));
        assert_ne!(all, run(Question::Scale, 1, 2, &mut scenes()));
        assert_ne!(all, run(Question::Scale, 2, 1, &mut scenes()));
        for (i, trial) in all.iter().enumerate().filter(|(_, t)| t.role == Role::Repeat) {
            let earlier = all[..i + 1 - REPEAT_DISTANCE].iter().find(|t| {
                t.role == Role::Rating && (t.scene, t.left, t.right) == (trial.scene, trial.right, trial.left)
            });
            assert!(earlier.is_some(), "{i}");
        }
    }

    /// Ratings and training show every scene once in each round of three, whatever repeats and traps lie between them.
    #[test]
    fn every_scene_is_judged_once_in_each_round() {
        for observer in 0..20 {
            let all = run(Question::Scale, 1, observer, &mut scenes());
            let compared: Vec<usize> = all
                .iter()
                .filter(|t| matches!(t.role, Role::Training | Role::Rating))
                .map(|t| t.scene)
                .collect();
            for round in compared.chunks_exact(3) {
                let mut round = round.to_vec();
                round.sort_unstable();
                assert_eq!(round, [0, 1, 2], "observer {observer}: {compared:?}");
            }
        }
    }

    /// The reference of a trap is on either side by chance. Among 300 traps of 100 observers, three standard errors of a share of a half
    /// are 0.087.
    #[test]
    fn the_reference_of_a_trap_is_on_both_sides() {
        let traps: Vec<Trial> = (0..100)
            .flat_map(|observer| run(Question::Scale, 1, observer, &mut scenes()))
            .filter(|t| t.role == Role::Trap)
            .collect();
        let left = traps.iter().filter(|t| t.left == Shown::Reference).count();
        let share = left as f64 / traps.len() as f64;
        assert_eq!(traps.len(), 300);
        assert!((share - 0.5).abs() < 0.087, "{share}");
    }

    #[test]
    fn nobody_sees_a_pair_twice_before_all_others() {
        let all = run(Question::Scale, 3, 1, &mut scenes());
        for scene in 0..3 {
            let seen: Vec<_> = all
                .iter()
                .filter(|t| matches!(t.role, Role::Rating | Role::Training) && t.scene == scene)
                .collect();
            let mut first: Vec<_> = seen.iter().take(6).map(|t| t.pair()).collect();
            first.sort();
            first.dedup();
            assert_eq!(first.len(), 6.min(seen.len()));
        }
    }

    #[test]
    fn pairs_that_others_look_at_are_avoided() {
        let answers = scenes();
        let next = |pending: &[(usize, (usize, usize))]| {
            SCHEDULE.next(Question::Scale, (1, 1), &[], &answers, pending).unwrap()
        };
        let first = next(&[]);
        let pair = (first.scene, first.pair().unwrap());
        assert_ne!(next(&[pair]).pair(), first.pair());
        let all: Vec<_> = answers[0].pairs().map(|p| (first.scene, p)).collect();
        assert_eq!(next(&all).pair(), first.pair());
    }

    #[test]
    fn constant_stimuli_show_the_standard_and_each_level_equally_often() {
        let all = run(Question::Light { standard: 2 }, 1, 1, &mut scenes());
        let rated: Vec<_> = all.iter().filter(|t| t.role == Role::Rating).collect();
        for level in [0, 1, 3] {
            for scene in 0..3 {
                let pair = Some((level.min(2), level.max(2)));
                let times = rated.iter().filter(|t| t.scene == scene && t.pair() == pair).count();
                // 24 ratings of 9 combinations.
                assert!((2..=3).contains(&times), "{level} on {scene}: {times}");
            }
        }
        let lefts = rated.iter().filter(|t| t.left == Shown::Condition(2)).count();
        assert!((6..=18).contains(&lefts), "{lefts}");
    }
}
