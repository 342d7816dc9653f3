//! Scoring the trials of a study.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::error::DesignError;
use super::pipeline_trainer::PipelineTrainer;
use super::scores::{Metric, Scores};
use super::study::{Trial, TrialProcessing, Trials};
use super::targets::Targets;
use crate::camera::{Camera, CameraError, EvaluationSettings, OpticalImages};
use crate::sensor::Mosaic;

/// Revision of the scores. It increases whenever scores change; a table must not mix revisions.
pub const SCORES_REVISION: u32 = 10;

/// A trial and its scores.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredTrial {
    /// The trial.
    pub trial: Trial,
    /// Its scores, or the error that prevented all of them, such as filters that pass no light.
    pub scores: Result<Scores, CameraError>,
}

impl ScoredTrial {
    /// As [`Scores::value`].
    #[must_use]
    pub fn value(&self, metric: Metric, scene: usize) -> Option<f64> {
        self.scores.as_ref().ok()?.value(metric, scene)
    }

    /// The errors of the measurements as text; empty when none failed. Equal errors of several targets appear once.
    #[must_use]
    pub fn problem(&self) -> String {
        let scores = match &self.scores {
            Ok(scores) => scores,
            Err(e) => return e.to_string(),
        };
        let mut messages: Vec<String> = Vec::new();
        for (target, e) in scores.problems() {
            let e = e.to_string();
            if !messages.iter().any(|s| s.ends_with(&e)) {
                messages.push(format!("{target}: {e}"));
            }
        }
        messages.join("; ")
    }
}

/// Scores the trials of a study. It prepares a condition when the first of its trials is scored and keeps it until
/// another condition is needed.
pub struct Sweep<'a> {
    trials: Cow<'a, Trials>,
    images: OpticalImages<'a>,
    prepared: Mutex<Option<(usize, Arc<PreparedCondition>)>>,
}

/// The camera, the targets and the training light of one condition.
struct PreparedCondition {
    camera: Camera,
    targets: Targets,
    /// `None` when no trial of the study has a learned pipeline.
    trainer: Option<PipelineTrainer>,
}

impl<'a> Sweep<'a> {
    /// A sweep over borrowed trials; `images` may cache optical images, as in [`evaluate`](crate::camera::evaluate).
    #[must_use]
    pub fn new(trials: &'a Trials, images: OpticalImages<'a>) -> Self {
        Self { trials: Cow::Borrowed(trials), images, prepared: Mutex::new(None) }
    }

    /// A sweep that owns its trials, for callers that cannot lend them.
    #[must_use]
    pub fn owning(trials: Trials, images: OpticalImages<'a>) -> Self {
        Self { trials: Cow::Owned(trials), images, prepared: Mutex::new(None) }
    }

    /// The trials of the study.
    #[must_use]
    pub fn trials(&self) -> &Trials {
        &self.trials
    }

    /// Scores the trials of a range, in their order. Calls `done` after each, from any thread, and stops once it returns false.
    ///
    /// # Errors
    /// When a condition cannot be prepared or a design cannot be built; [`DesignError::Stopped`]. A trial without scores is not an
    /// error.
    pub fn score(
        &self,
        range: Range<u64>,
        done: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<ScoredTrial>, DesignError> {
        let mut rows = Vec::new();
        let mut at = range.start;
        while at < range.end {
            let end = self.trials.end_of_condition(at).min(range.end);
            rows.extend(self.score_under(self.trials.condition_of(at), (at..end).into_par_iter(), done)?);
            at = end;
        }
        Ok(rows)
    }

    /// Scores trials of one condition, which is that of the first number.
    ///
    /// # Errors
    /// As [`Sweep::score`].
    pub fn score_numbers(
        &self,
        numbers: &[u64],
        done: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<ScoredTrial>, DesignError> {
        let Some(&first) = numbers.first() else { return Ok(Vec::new()) };
        self.score_under(self.trials.condition_of(first), numbers.par_iter().copied(), done)
    }

    fn score_under(
        &self,
        condition: usize,
        numbers: impl ParallelIterator<Item = u64>,
        done: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<ScoredTrial>, DesignError> {
        let prepared = self.condition(condition)?;
        let trials = numbers.map(|number| self.trials.trial(number)).collect::<Result<Vec<_>, _>>()?;
        if let Some(trainer) = &prepared.trainer {
            // Trials of a mosaic mostly follow each other. An error is that of each trial.
            let learned = trials.iter().filter(|t| t.processing == TrialProcessing::L3);
            let mosaics: Vec<&Mosaic> = learned.map(|t| &t.design.mosaic).collect();
            mosaics.chunk_by(|a, b| a == b).for_each(|same| drop(trainer.prepare(same[0])));
        }
        let score = |trial: Trial| {
            let scored = prepared.score(trial);
            if done() { Ok(scored) } else { Err(DesignError::Stopped) }
        };
        trials.into_par_iter().map(score).collect()
    }

    fn condition(&self, index: usize) -> Result<Arc<PreparedCondition>, DesignError> {
        let mut kept = self.prepared.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, prepared)) = kept.as_ref().filter(|(i, _)| *i == index) {
            return Ok(prepared.clone());
        }
        // Drop the old condition first: two at once would need twice the memory.
        *kept = None;
        let made = Arc::new(self.prepare(index)?);
        *kept = Some((index, made.clone()));
        Ok(made)
    }

    fn prepare(&self, index: usize) -> Result<PreparedCondition, DesignError> {
        let study = self.trials.study();
        let condition = study.conditions.get(index).ok_or(DesignError::NoSuchCondition { index })?;
        let camera = condition.camera()?;
        let settings = EvaluationSettings {
            luminance_cd_m2: condition.luminance_cd_m2,
            illuminant: condition.illuminant.clone(),
            seed: study.seed,
            ..EvaluationSettings::default()
        };
        let targets = Targets::new(&camera, &settings, &study.metrics, &study.scenes, self.images)?;
        let learns = study.processing.contains(&TrialProcessing::L3);
        let trainer = learns.then(|| PipelineTrainer::new(&targets, &study.l3, self.images)).transpose()?;
        Ok(PreparedCondition { camera, targets, trainer })
    }
}

impl PreparedCondition {
    fn score(&self, trial: Trial) -> ScoredTrial {
        let score = || {
            let cfa = trial.design.cfa(self.camera.grid())?;
            match &self.trainer {
                Some(trainer) if trial.processing == TrialProcessing::L3 => {
                    let (pipeline, reach) = trainer.pipeline(&cfa)?;
                    // One renderer serves all pictures of the trial.
                    self.targets.score_with(&cfa, &pipeline.renderer(), reach)
                }
                _ => self.targets.score(&cfa),
            }
        };
        ScoredTrial { scores: score(), trial }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::filters::FilterSet;
    use crate::design::scores::{ColorScores, SceneFigures};
    use crate::design::study::Design;

    fn error(message: &str) -> CameraError {
        CameraError::Key { key: "key".into(), message: message.into() }
    }

    fn scored(scores: Result<Scores, CameraError>) -> ScoredTrial {
        let filters = FilterSet { label: String::new(), filters: Vec::new() };
        let design = Design { filters, mosaic: Mosaic::new(1, 1, vec![0]).unwrap() };
        let trial = Trial { number: 7, condition: 0, processing: TrialProcessing::Classic, design };
        ScoredTrial { trial, scores }
    }

    /// A trial has the values of its scores, and states each of their errors once.
    #[test]
    fn trials_have_the_values_and_the_errors_of_their_scores() {
        let figures = SceneFigures {
            cpsnr_db: 31.5,
            pixel_delta_e_2000_mean: 2.25,
            scielab_mean: 1.75,
            saturated_percent: 0.0,
        };
        let scores = Scores {
            sensor: None,
            colors: Some(Ok(ColorScores { delta_e_76: 4.5, delta_e_2000: 3.5 })),
            luminance_noise_percent: Some(Err(error("too dark"))),
            edge: Some(Err(error("no edge"))),
            zone_plate: Some(Err(error("too dark"))),
            scenes: vec![Err(error("no edge")), Ok(figures)],
            macbeth_time_s: 0.01,
            macbeth_saturated_percent: 0.0,
        };
        let trial = scored(Ok(scores));
        for (metric, scene, value) in [
            (Metric::DeltaE76, 0, Some(4.5)),
            (Metric::DeltaE2000, 5, Some(3.5)),
            (Metric::Cpsnr, 1, Some(31.5)),
            (Metric::Scielab, 1, Some(1.75)),
            (Metric::Cpsnr, 0, None),
            (Metric::Cpsnr, 2, None),
            (Metric::LuminanceNoise, 0, None),
            (Metric::VoraValue, 0, None),
        ] {
            assert_eq!(trial.value(metric, scene), value, "{} {scene}", metric.name());
        }
        assert_eq!(trial.problem(), "noise: `key`: too dark; edge: `key`: no edge");
        let failed = scored(Err(error("no light")));
        assert_eq!(failed.value(Metric::DeltaE76, 0), None);
        assert_eq!(failed.problem(), "`key`: no light");
    }
}
