//! The designs of a study, scored.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::error::DesignError;
use super::learned::Lessons;
use super::study::{Design, Designs, Processing};
use super::targets::{AliasingScores, Scores, Targets};
use crate::camera::{Camera, CameraError, EvaluationSettings, OpticalImages};

/// Raised whenever scores change: results of two revisions do not belong in one table.
pub const SCORES_REVISION: u32 = 1;

/// A design and what it scored.
#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    /// The design.
    pub design: Design,
    /// Its scores, or why it has none: a filter set that sees no light, an edge without contrast.
    pub scores: Result<Scores, CameraError>,
    /// Its aliasing, where the study asks for it.
    pub aliasing: Option<AliasingScores>,
}

/// A study at work. What a condition needs is prepared when its first design is scored, and kept until another comes.
pub struct Sweep<'a> {
    designs: &'a Designs,
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
        Self { designs, images, ready: Mutex::new(None) }
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
        let mut targets = Targets::new(&camera, &settings, self.images)?;
        if study.aliasing {
            targets = targets.with_zone_plate(self.images)?;
        }
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
                    let renderer = pipeline.renderer();
                    let scores = self.targets.score_with(&cfa, &renderer, reach)?;
                    Ok((scores, self.targets.aliasing_with(&cfa, &renderer)?))
                }
                _ => Ok((self.targets.score(&cfa)?, self.targets.aliasing(&cfa)?)),
            }
        };
        let (scores, aliasing) = match score() {
            Ok((scores, aliasing)) => (Ok(scores), aliasing),
            Err(e) => (Err(e), None),
        };
        Scored { design, scores, aliasing }
    }
}
