//! Learning from the default set for several cameras and lights, together or in turns.

use std::collections::VecDeque;

use serde::Serialize;

use super::default_set::{DefaultTraining, Gathering, Later, LitScenes, add_default_set};
use super::error::StageContext;
use super::learning::{TrainingRecord, solve};
use super::material::{TrainingMaterial, first_light};
use super::order::Order;
use super::training_statistics::{WhiteIn, ensure_mosaic, fresh_statistics, second_stage};
use super::{ExperimentError, Resources};
use crate::camera::stable_text::stable_text;
use crate::camera::{CameraDescription, StoredTrainingScenes, TRAINING_SET_REVISION, TrainingSettings};
use crate::l3::{self, Pipeline, Quality, Statistics, Training};
use crate::sensor::Channel;
use crate::spectrum::{Illuminant, Spectrum};

/// All inputs of training statistics, for the cache key.
#[derive(Serialize)]
struct StatisticsKey<'a> {
    smalti_version: &'a str,
    l3_revision: u32,
    training_set_revision: u32,
    stored_scenes: Vec<&'a str>,
    camera: &'a CameraDescription,
    /// Tile and filters of a colour filter array that differs from the description.
    other_cfa: Option<(usize, &'a [u8], &'a [Channel])>,
    light: &'a Spectrum,
    settings: &'a TrainingSettings,
}

impl DefaultTraining {
    fn key(
        &self,
        settings: &TrainingSettings,
        light: &Spectrum,
        stored: &dyn StoredTrainingScenes,
    ) -> Result<String, ExperimentError> {
        let cfa = &self.camera.sensor.cfa;
        let other_cfa =
            self.camera.has_other_cfa().then(|| (cfa.mosaic().cols(), cfa.mosaic().cells(), cfa.channels()));
        stable_text(&StatisticsKey {
            smalti_version: env!("CARGO_PKG_VERSION"),
            l3_revision: l3::REVISION,
            training_set_revision: TRAINING_SET_REVISION,
            stored_scenes: stored.names(),
            camera: self.camera.description(),
            other_cfa,
            light,
            settings,
        })
        .in_context(|| "learning".into())
    }
}

/// Trains pipelines on the default set, each for a camera and an illuminant. Statistics come from the store if it has them. Each
/// scene is one step of progress.
///
/// # Errors
/// When a camera has no mosaic, a setting is invalid, memory does not suffice, or the work is stopped; with the label of the camera.
pub fn learn_default(
    trainings: &[DefaultTraining],
    (settings, training): (&TrainingSettings, &Training),
    resources: Resources<'_>,
) -> Result<Vec<Pipeline>, ExperimentError> {
    let count = trainings.len();
    DefaultLessons::new(trainings, (settings, training), resources)?.learn_next(count, resources)
}

/// [`learn_default`] in turns.
pub(super) struct DefaultLessons {
    /// Those that are not learned yet.
    lessons: VecDeque<Lesson>,
    settings: TrainingSettings,
    training: Training,
}

/// The pipeline of a training before it is learned.
struct Lesson {
    of: DefaultTraining,
    /// The illuminant that its scenes are built under: that of the first of all trainings with the same optical images, of which some may
    /// be in the store, so that what is stored changes no bit.
    built_under: Illuminant,
    /// The illuminant, photons.
    light: Spectrum,
    statistics: Statistics,
    /// The key of the statistics.
    key: String,
    /// Whether the statistics are still to be gathered.
    is_new: bool,
    /// The pipeline of both stages, from the store.
    both: Option<Pipeline>,
    /// The key of this pipeline.
    key_of_both: String,
    /// The light of the scenes of the first and of the second stage.
    lit: [LitScenes; 2],
}

impl DefaultLessons {
    /// As [`learn_default`], before anything is learned.
    pub(super) fn new(
        trainings: &[DefaultTraining],
        (settings, training): (&TrainingSettings, &Training),
        resources: Resources<'_>,
    ) -> Result<Self, ExperimentError> {
        let lesson = |of: DefaultTraining| -> Result<Lesson, ExperimentError> {
            let first = trainings.iter().find(|first| first.shares_images_with(&of));
            let built_under = first.map_or(&of.light, |first| &first.light).clone();
            ensure_mosaic(&of.camera, &of.label)?;
            let light = first_light(std::slice::from_ref(&of.light), &of.camera)?;
            let key = of.key(settings, &light, resources.training_scenes)?;
            let (statistics, is_new) = match resources.store.statistics(&key) {
                Some(stored) => (stored, false),
                None => (fresh_statistics(&of.camera, settings, &light, resources.memory_bytes)?, true),
            };
            let key_of_both = stable_text(&(l3::REFINEMENT_REVISION, &key, training));
            let key_of_both = key_of_both.in_context(|| "learning".into())?;
            let both = match training.quality {
                Quality::Fast => None,
                Quality::Best => resources.store.pipeline(&key_of_both),
            };
            let lit = Default::default();
            Ok(Lesson { of, built_under, light, statistics, key, is_new, both, key_of_both, lit })
        };
        let lesson = |of: DefaultTraining| {
            let label = of.label.clone();
            lesson(of).map_err(|e| e.of_camera(&label))
        };
        let lessons = trainings.iter().cloned().map(lesson).collect::<Result<_, _>>()?;
        Ok(Self { lessons, settings: settings.clone(), training: training.clone() })
    }

    /// Learns the pipelines of the next trainings, at most `count`. Those after them keep the light of the scenes for their turn.
    ///
    /// # Errors
    /// As [`learn_default`].
    pub(super) fn learn_next(
        &mut self,
        count: usize,
        resources: Resources<'_>,
    ) -> Result<Vec<Pipeline>, ExperimentError> {
        let Self { lessons, settings, training } = self;
        let mut now: Vec<Lesson> = lessons.drain(..count.min(lessons.len())).collect();
        let new = now.iter_mut().filter(|lesson| lesson.is_new).map(|lesson| {
            let Lesson { of, built_under, statistics, lit: [lit, _], .. } = lesson;
            Gathering::new(of, built_under, statistics, std::mem::take(lit))
        });
        let later = lessons.iter_mut().filter(|lesson| lesson.is_new).map(|lesson| {
            let Lesson { of, lit: [lit, _], .. } = lesson;
            Later { of, lit }
        });
        add_default_set(new.collect(), later.collect(), settings, resources)?;
        for lesson in now.iter().filter(|lesson| lesson.is_new) {
            resources.store.keep_statistics(&lesson.key, &lesson.statistics);
        }
        let stored = resources.training_scenes;
        let solved = Order::Parallel.map(&now, |Lesson { of, statistics, .. }| {
            let names = TrainingMaterial::DefaultSet(std::slice::from_ref(&of.light), stored).names();
            let record = TrainingRecord::new(&of.camera, settings, names);
            solve(statistics, training, Some(&record)).map_err(|e| e.of_camera(&of.label))
        })?;
        if training.quality == Quality::Fast {
            return Ok(solved);
        }
        let mut stages = Vec::with_capacity(now.len());
        for (lesson, first) in now.iter_mut().zip(&solved).filter(|(lesson, _)| lesson.both.is_none()) {
            let Lesson { of, light, .. } = lesson;
            let stage = second_stage(&of.camera, WhiteIn::Light(light), first);
            stages.push((stage.map_err(|e| e.of_camera(&of.label))?, lesson));
        }
        let missing = stages.iter_mut().map(|(stage, lesson)| {
            let Lesson { of, built_under, lit: [_, lit], .. } = &mut **lesson;
            Gathering::new(of, built_under, stage, std::mem::take(lit))
        });
        let later = lessons.iter_mut().filter(|lesson| lesson.both.is_none()).map(|lesson| {
            let Lesson { of, lit: [_, lit], .. } = lesson;
            Later { of, lit }
        });
        add_default_set(missing.collect(), later.collect(), settings, resources)?;
        Order::Parallel.map(stages, |(stage, lesson)| {
            let both = stage.solve().in_context(|| "learning".into());
            let both = both.map_err(|e: ExperimentError| e.of_camera(&lesson.of.label))?;
            resources.store.keep_pipeline(&lesson.key_of_both, &both);
            lesson.both = Some(both);
            Ok::<_, ExperimentError>(())
        })?;
        Ok(now.into_iter().filter_map(|lesson| lesson.both).collect())
    }
}
