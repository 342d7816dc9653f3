//! The designs of a study, scored.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::error::DesignError;
use super::learned::Lessons;
use super::scores::{Metric, Scores};
use super::study::{Design, Designs, Processing};
use super::targets::Targets;
use crate::camera::{Camera, CameraError, EvaluationSettings, OpticalImages};

/// Raised whenever scores change: results of two revisions do not belong in one table.
pub const SCORES_REVISION: u32 = 3;

/// A design and what it scored.
#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    /// The design.
    pub design: Design,
    /// Its scores, or why it has none: a set of filters that sees no light.
    pub scores: Result<Scores, CameraError>,
}

impl Scored {
    /// As [`Scores::value`].
    #[must_use]
    pub fn value(&self, metric: Metric, scene: usize) -> Option<f64> {
        self.scores.as_ref().ok()?.value(metric, scene)
    }

    /// Why scores are missing, in words; empty where none is. What failed on several targets in one way is said once.
    #[must_use]
    pub fn problem(&self) -> String {
        let scores = match &self.scores {
            Ok(scores) => scores,
            Err(e) => return e.to_string(),
        };
        let mut said: Vec<String> = Vec::new();
        for (target, e) in scores.problems() {
            let e = e.to_string();
            if !said.iter().any(|s| s.ends_with(&e)) {
                said.push(format!("{target}: {e}"));
            }
        }
        said.join("; ")
    }
}

/// A study at work. What a condition needs is prepared when its first design is scored, and kept until another comes.
pub struct Sweep<'a> {
    designs: Cow<'a, Designs>,
    images: OpticalImages<'a>,
    ready: Mutex<Option<(usize, Arc<Ready>)>>,
}

/// A condition, ready for designs.
struct Ready {
    camera: Camera,
    targets: Targets,
    /// Where the study has designs that are learned for.
    lessons: Option<Lessons>,
}

impl<'a> Sweep<'a> {
    /// A study; `images` may keep optical images, as for [`evaluate`](crate::camera::evaluate).
    #[must_use]
    pub fn new(designs: &'a Designs, images: OpticalImages<'a>) -> Self {
        Self { designs: Cow::Borrowed(designs), images, ready: Mutex::new(None) }
    }

    /// The same with a study that it keeps, for one that outlives who began it.
    #[must_use]
    pub fn owning(designs: Designs, images: OpticalImages<'a>) -> Self {
        Self { designs: Cow::Owned(designs), images, ready: Mutex::new(None) }
    }

    /// The designs that it scores.
    #[must_use]
    pub fn designs(&self) -> &Designs {
        &self.designs
    }

    /// Scores the designs of a range, in their order. Calls `done` after each, from any thread.
    ///
    /// # Errors
    /// When a condition cannot be prepared, or a design cannot be made. That a design has no score is not an error.
    pub fn score(&self, range: Range<u64>, done: &(dyn Fn() + Sync)) -> Result<Vec<Scored>, DesignError> {
        let mut rows = Vec::new();
        let mut at = range.start;
        while at < range.end {
            let end = self.designs.end_of_condition(at).min(range.end);
            rows.extend(self.score_under(self.designs.condition_of(at), (at..end).into_par_iter(), done)?);
            at = end;
        }
        Ok(rows)
    }

    /// Scores designs of one condition, that of the first.
    ///
    /// # Errors
    /// As [`Sweep::score`].
    pub fn score_numbers(
        &self,
        numbers: &[u64],
        done: &(dyn Fn() + Sync),
    ) -> Result<Vec<Scored>, DesignError> {
        let Some(&first) = numbers.first() else { return Ok(Vec::new()) };
        self.score_under(self.designs.condition_of(first), numbers.par_iter().copied(), done)
    }

    fn score_under(
        &self,
        condition: usize,
        numbers: impl ParallelIterator<Item = u64>,
        done: &(dyn Fn() + Sync),
    ) -> Result<Vec<Scored>, DesignError> {
        let prepared = self.condition(condition)?;
        let score = |number: u64| {
            let scored = prepared.score(self.designs.design(number)?);
            done();
            Ok(scored)
        };
        numbers.map(score).collect()
    }

    fn condition(&self, index: usize) -> Result<Arc<Ready>, DesignError> {
        let mut kept = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, prepared)) = kept.as_ref().filter(|(i, _)| *i == index) {
            return Ok(prepared.clone());
        }
        // Two conditions at once would need twice the memory.
        *kept = None;
        let made = Arc::new(self.prepare(index)?);
        *kept = Some((index, made.clone()));
        Ok(made)
    }

    fn prepare(&self, index: usize) -> Result<Ready, DesignError> {
        let study = self.designs.study();
        let condition = study.conditions.get(index).ok_or(DesignError::NoSuchCondition { index })?;
        let grid = condition.camera.grid()?;
        let camera = Camera::new(condition.camera.clone(), grid)?;
        let settings = EvaluationSettings {
            luminance_cd_m2: condition.luminance_cd_m2,
            illuminant: condition.illuminant.clone(),
            seed: study.seed,
        };
        let targets = Targets::new(&camera, &settings, &study.metrics, &study.scenes, self.images)?;
        let learns = study.processing.contains(&Processing::L3);
        let lessons = learns.then(|| Lessons::new(&targets, &study.l3, self.images)).transpose()?;
        Ok(Ready { camera, targets, lessons })
    }
}

impl Ready {
    fn score(&self, design: Design) -> Scored {
        let score = || {
            let cfa = design.cfa(self.camera.grid())?;
            match &self.lessons {
                Some(lessons) if design.processing == Processing::L3 => {
                    let (pipeline, reach) = lessons.pipeline(&cfa)?;
                    // Planned once for all pictures of the design.
                    self.targets.score_with(&cfa, &pipeline.renderer(), reach)
                }
                _ => self.targets.score(&cfa),
            }
        };
        Scored { scores: score(), design }
    }
}
