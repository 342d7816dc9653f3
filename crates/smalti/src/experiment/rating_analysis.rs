//! What the answers to a rating experiment show: which observers are kept, and the scale of the conditions with the agreement of each
//! metric, or the light of equal appearance.

use std::collections::BTreeMap;

use super::ExperimentError;
use crate::camera::PICTURE_METRICS;
use crate::metrics::{Better, metric_info};
use crate::rating::{
    Agreement, Level, ObserverChoices, PsychometricFit, Question, Scales, Screening, equality, scale, screen,
    summed,
};

/// A rating experiment with its answers, as plain values.
#[derive(Debug, Clone, PartialEq)]
pub struct RatingAnswers {
    /// The title.
    pub title: String,
    /// What is asked.
    pub question: Question,
    /// The seed of the experiment, from which intervals are resampled.
    pub seed: u64,
    /// The conditions, the same on every scene.
    pub conditions: Vec<AnsweredCondition>,
    /// The names of the scenes.
    pub scenes: Vec<String>,
    /// The metrics of the pictures by their names in the catalogue: for each scene a value per condition, NaN where it is not defined.
    pub metrics: BTreeMap<String, Vec<Vec<f64>>>,
    /// The observers.
    pub observers: Vec<AnsweredObserver>,
}

/// A condition of a rating experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct AnsweredCondition {
    /// Its unique name.
    pub name: String,
    /// The camera with its processing.
    pub contender: String,
    /// Light beyond the luminance of the condition, stops.
    pub stops: f64,
}

/// An observer of a rating experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct AnsweredObserver {
    /// The number, from 1.
    pub number: u32,
    /// Pairs that the observer has answered.
    pub answered: usize,
    /// Pairs of the whole session.
    pub pairs: usize,
    /// The choices.
    pub choices: ObserverChoices,
    /// Device pixels per CSS pixel.
    pub device_pixel_ratio: f64,
    /// The gamma of the display; `None` if the observer did not match it.
    pub gamma: Option<f64>,
}

/// The result of [`analyse_ratings`].
#[derive(Debug, Clone)]
pub struct RatingAnalysis {
    /// What was found about each observer.
    pub observers: Vec<JudgedObserver>,
    /// What the kept observers answered.
    pub result: RatingResult,
}

/// What was found about an observer.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedObserver {
    /// The screening.
    pub screening: Screening,
    /// Whether the choices count.
    pub is_kept: bool,
}

/// The answer to the question of an experiment.
#[derive(Debug, Clone)]
pub enum RatingResult {
    /// The scale of all conditions.
    Scale {
        /// The scales.
        scales: Scales,
        /// The agreement of each metric with the observers, those of the pictures first; `None` where it has no correlation.
        agreement: Vec<(String, Option<Agreement>)>,
    },
    /// How much light a camera needs to look like another.
    Light {
        /// The camera whose light varies, with its processing.
        varied: String,
        /// The standard, with its luminance.
        standard: String,
        /// The choices for the varied camera of all kept observers, in each amount of light in stops.
        levels: Vec<Level>,
        /// The psychometric function, if the choices have one.
        fit: Option<PsychometricFit>,
    },
}

impl RatingAnswers {
    /// The numbers of the conditions other than the standard, all if there is none.
    fn varied(&self) -> impl Iterator<Item = usize> + use<> {
        let standard = match self.question {
            Question::Scale => None,
            Question::Light { standard } => Some(standard),
        };
        (0..self.conditions.len()).filter(move |c| Some(*c) != standard)
    }

    /// The choices of an observer for the varied camera against the standard, in each amount of light in stops; empty for an experiment
    /// that asks for a scale.
    #[must_use]
    pub fn levels(&self, choices: &ObserverChoices) -> Vec<Level> {
        let Question::Light { standard } = self.question else { return Vec::new() };
        let of = |condition: usize| Level {
            level: self.conditions[condition].stops,
            chosen: choices.scenes.iter().map(|s| s.wins(condition, standard)).sum(),
            asked: choices.scenes.iter().map(|s| s.compared(condition, standard)).sum(),
        };
        self.varied().map(of).collect()
    }

    fn scaled(&self, kept: &[&ObserverChoices]) -> RatingResult {
        let scales = scale(kept, self.conditions.len(), self.seed);
        let mut metrics: Vec<(&String, &Vec<Vec<f64>>)> = self.metrics.iter().collect();
        let place =
            |name: &str| PICTURE_METRICS.iter().position(|m| *m == name).unwrap_or(PICTURE_METRICS.len());
        metrics.sort_by_key(|(name, _)| place(name));
        let agreement = |(name, values): (&String, &Vec<Vec<f64>>)| {
            // Larger is better.
            let sign = match metric_info(name).map(|info| info.better) {
                Ok(Better::Lower) => -1.0,
                _ => 1.0,
            };
            let values: Vec<Vec<f64>> =
                values.iter().map(|scene| scene.iter().map(|v| sign * v).collect()).collect();
            (name.clone(), scales.agreement(&values, self.seed))
        };
        let agreement = metrics.into_iter().map(agreement).collect();
        RatingResult::Scale { agreement, scales }
    }

    fn light(&self, kept: &[&ObserverChoices], standard: usize) -> RatingResult {
        let by_observer: Vec<Vec<Level>> = kept.iter().map(|choices| self.levels(choices)).collect();
        let varied = self.varied().next().and_then(|c| self.conditions.get(c));
        RatingResult::Light {
            varied: varied.map_or_else(String::new, |c| c.contender.clone()),
            standard: self.conditions.get(standard).map_or_else(String::new, |c| c.name.clone()),
            fit: equality(&by_observer, self.seed),
            levels: summed(&by_observer, &vec![1; by_observer.len()]),
        }
    }
}

/// Screens the observers and answers the question of the experiment from the choices of those who are kept: with `keep_all`, all who have
/// rated.
///
/// # Errors
/// When there are no answers, or no observer with ratings is kept.
pub fn analyse_ratings(answers: &RatingAnswers, keep_all: bool) -> Result<RatingAnalysis, ExperimentError> {
    if answers.observers.iter().all(|o| o.answered == 0) {
        return Err(ExperimentError::NoAnswers);
    }
    let choices: Vec<ObserverChoices> = answers.observers.iter().map(|o| o.choices.clone()).collect();
    let judge = |(screening, choices): (Screening, &ObserverChoices)| {
        let has_rated = choices.scenes.iter().any(|s| s.total() > 0.0);
        JudgedObserver { is_kept: has_rated && (keep_all || screening.reasons.is_empty()), screening }
    };
    let observers: Vec<JudgedObserver> = screen(&choices).into_iter().zip(&choices).map(judge).collect();
    let kept: Vec<&ObserverChoices> =
        choices.iter().zip(&observers).filter(|(_, o)| o.is_kept).map(|(c, _)| c).collect();
    if kept.is_empty() {
        return Err(ExperimentError::NoObserver);
    }
    let result = match answers.question {
        Question::Scale => answers.scaled(&kept),
        Question::Light { standard } => answers.light(&kept, standard),
    };
    Ok(RatingAnalysis { observers, result })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rating::Counts;

    /// An observer who prefers the later of three conditions on one scene, a number of times each.
    fn observer(number: u32, times: f64, traps: [u32; 2]) -> AnsweredObserver {
        let mut counts = Counts::new(3);
        for (a, b) in counts.clone().pairs() {
            counts.add(b, a, 2.0 * times);
            counts.add(a, b, times);
        }
        AnsweredObserver {
            number,
            answered: 9,
            pairs: 12,
            choices: ObserverChoices { scenes: vec![counts], repeats: [0, 0], traps },
            device_pixel_ratio: 1.0,
            gamma: None,
        }
    }

    fn answers(question: Question, observers: Vec<AnsweredObserver>) -> RatingAnswers {
        let condition = |stops: f64| AnsweredCondition {
            name: format!("camera {stops}"),
            contender: "camera".into(),
            stops,
        };
        let metrics = [("visual_snr", [1.0, 2.0, 3.0]), ("scielab_mean", [3.0, 1.0, 2.0])];
        RatingAnswers {
            title: "test".into(),
            question,
            seed: 1,
            conditions: [0.0, -1.0, 1.0].map(condition).to_vec(),
            scenes: vec!["scene".into()],
            metrics: metrics.map(|(name, values)| (name.to_owned(), vec![values.to_vec()])).into(),
            observers,
        }
    }

    #[test]
    fn observers_are_left_out_unless_all_are_kept() {
        let two = answers(Question::Scale, vec![observer(1, 2.0, [3, 3]), observer(2, 2.0, [0, 3])]);
        let kept = |keep_all| -> Vec<bool> {
            analyse_ratings(&two, keep_all).unwrap().observers.iter().map(|o| o.is_kept).collect()
        };
        assert_eq!(kept(false), [true, false]);
        assert_eq!(kept(true), [true, true]);
        let of = |observers| analyse_ratings(&answers(Question::Scale, observers), false).unwrap_err();
        assert!(matches!(of(Vec::new()), ExperimentError::NoAnswers));
        assert!(matches!(of(vec![observer(1, 2.0, [0, 3])]), ExperimentError::NoObserver));
        // Who has answered traps and training alone has not rated.
        let without = analyse_ratings(&answers(Question::Scale, vec![observer(1, 0.0, [3, 3])]), true);
        assert!(matches!(without.unwrap_err(), ExperimentError::NoObserver));
    }

    /// The metric of pictures comes first, and of S-CIELAB less is better: its order is the second, the third, the first.
    #[test]
    fn metrics_are_compared_in_the_direction_of_better() {
        let found =
            analyse_ratings(&answers(Question::Scale, vec![observer(1, 2.0, [3, 3])]), false).unwrap();
        let RatingResult::Scale { agreement, .. } = found.result else { panic!("no scale") };
        let spearman: Vec<(&str, f64)> =
            agreement.iter().map(|(name, a)| (name.as_str(), a.unwrap().spearman.value)).collect();
        assert_eq!(spearman, [("scielab_mean", 0.5), ("visual_snr", 1.0)]);
    }

    #[test]
    fn the_light_of_equal_appearance_counts_choices_against_the_standard_alone() {
        let two = vec![observer(1, 2.0, [3, 3]), observer(2, 1.0, [3, 3])];
        let found = analyse_ratings(&answers(Question::Light { standard: 0 }, two), false).unwrap();
        let RatingResult::Light { varied, standard, levels, .. } = found.result else { panic!("no light") };
        assert_eq!((varied.as_str(), standard.as_str()), ("camera", "camera 0"));
        let levels: Vec<[f64; 3]> = levels.iter().map(|l| [l.level, l.chosen, l.asked]).collect();
        assert_eq!(levels, [[-1.0, 6.0, 9.0], [1.0, 6.0, 9.0]]);
    }
}
