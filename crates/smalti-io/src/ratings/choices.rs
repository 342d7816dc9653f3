//! The answers of observers as counts of choices.

use smalti::rating::{Counts, Level, ObserverChoices, Question, Role, Shown, Side};

use super::answers::{Answered, Observer};
use super::manifest::Manifest;

/// The preferred and the other picture of an answered pair.
fn preferred(answered: &Answered) -> Option<(Shown, Shown)> {
    let (choice, _) = answered.answer?;
    Some(match choice {
        Side::Left => (answered.trial.left, answered.trial.right),
        Side::Right => (answered.trial.right, answered.trial.left),
    })
}

/// The choices of an observer. Training does not count.
#[must_use]
pub fn choices(manifest: &Manifest, observer: &Observer) -> ObserverChoices {
    let mut scenes = vec![Counts::new(manifest.conditions.len()); manifest.scenes.len()];
    let (mut repeats, mut traps) = ([0, 0], [0, 0]);
    for (number, answered) in observer.trials.iter().enumerate() {
        let (trial, Some(found)) = (answered.trial, preferred(answered)) else { continue };
        match trial.role {
            Role::Training => continue,
            Role::Trap => {
                traps[0] += u32::from(found.0 == Shown::Reference);
                traps[1] += 1;
                continue;
            }
            Role::Repeat => {
                let is_first = |t: &&Answered| {
                    t.trial.role == Role::Rating
                        && (t.trial.scene, t.trial.pair()) == (trial.scene, trial.pair())
                };
                let first = observer.trials[..number].iter().rev().find(is_first).and_then(preferred);
                repeats[0] += u32::from(first.is_some_and(|(before, _)| before == found.0));
                repeats[1] += u32::from(first.is_some());
            }
            Role::Rating => {}
        }
        if let ((Shown::Condition(a), Shown::Condition(b)), Some(counts)) =
            (found, scenes.get_mut(trial.scene))
        {
            counts.add(a, b, 1.0);
        }
    }
    ObserverChoices { scenes, repeats, traps }
}

/// The choices for the varied camera against the standard in each amount of light; empty for an experiment that asks for a scale.
#[must_use]
pub fn levels(manifest: &Manifest, choices: &ObserverChoices) -> Vec<Level> {
    let Question::Light { standard } = manifest.question else { return Vec::new() };
    let of = |condition: usize| Level {
        level: manifest.conditions.get(condition).map_or(0.0, |c| c.stops),
        chosen: choices.scenes.iter().map(|s| s.wins(condition, standard)).sum(),
        asked: choices.scenes.iter().map(|s| s.compared(condition, standard)).sum(),
    };
    manifest.levels().into_iter().map(of).collect()
}
