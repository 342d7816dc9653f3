//! The answers of observers as counts of choices.

use std::collections::BTreeSet;

use smalti::experiment::{AnsweredCondition, AnsweredObserver, RatingAnswers};
use smalti::rating::{Counts, ObserverChoices, Role, Shown, Side};

use super::answers::{Answered, Observer};
use super::manifest::{Condition, Manifest, SceneFiles};

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

impl Manifest {
    /// The experiment with the answers of observers, for [`analyse_ratings`](smalti::experiment::analyse_ratings).
    #[must_use]
    pub fn answers(&self, observers: &[Observer]) -> RatingAnswers {
        let condition = |c: &Condition| AnsweredCondition {
            name: c.name.clone(),
            contender: format!("{} {}", c.camera, c.processing),
            stops: c.stops,
        };
        let names: BTreeSet<&String> =
            self.scenes.iter().flat_map(|s| &s.pictures).flat_map(|p| p.metrics.keys()).collect();
        let of_scene = |scene: &SceneFiles, name: &String| -> Vec<f64> {
            scene.pictures.iter().map(|p| p.metrics.get(name).copied().unwrap_or(f64::NAN)).collect()
        };
        let metric = |name: &String| {
            (name.clone(), self.scenes.iter().map(|scene| of_scene(scene, name)).collect::<Vec<_>>())
        };
        let observer = |o: &Observer| AnsweredObserver {
            number: o.number,
            answered: o.trials.iter().filter(|t| t.answer.is_some()).count(),
            pairs: self.schedule.trials(),
            choices: choices(self, o),
            device_pixel_ratio: o.display.device_pixel_ratio,
            gamma: o.display.gamma,
        };
        RatingAnswers {
            title: self.title.clone(),
            question: self.question,
            seed: self.seed,
            conditions: self.conditions.iter().map(condition).collect(),
            scenes: self.scenes.iter().map(|s| s.name.clone()).collect(),
            metrics: names.into_iter().map(metric).collect(),
            observers: observers.iter().map(observer).collect(),
        }
    }
}
