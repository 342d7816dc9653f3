//! The pipelines of the cameras of a comparison: given, or learned on the default set under each light of the scenes.

use std::sync::{Mutex, PoisonError};

use super::default_set::DefaultTraining;
use super::default_training::DefaultLessons;
use super::error::StageContext;
use super::lights::{LitPipeline, PipelineSet, SceneLight, ensure_lights_suffice};
use super::training_statistics::ensure_mosaic;
use super::{ExperimentError, Processing, Resources};
use crate::camera::{Camera, TrainingSettings};
use crate::l3::{Pipeline, Training};
use crate::spectrum::{Illuminant, WavelengthGrid};

/// The pipelines of each camera of a comparison, which are learned in two turns: first those for the illuminant of the comparison, so that
/// the first scores come early, then those for the lights of all other scenes.
pub struct Pipelines {
    sets: Vec<Option<PipelineSet>>,
    rest: Mutex<Option<Rest>>,
}

/// The pipelines of the second turn.
struct Rest {
    lessons: DefaultLessons,
    learned_for: Vec<CameraLight>,
}

/// What a pipeline is learned for.
#[derive(PartialEq)]
struct CameraLight {
    /// The number of the camera.
    camera: usize,
    illuminant: Illuminant,
    grid: WavelengthGrid,
}

/// The cameras of a comparison and what their pipelines are to be.
pub struct PipelineTask<'a> {
    /// The cameras.
    pub cameras: &'a [Camera],
    /// Their unique names in progress and errors.
    pub labels: &'a [String],
    /// A given pipeline of each camera, for every light. There may be fewer than cameras.
    pub given: Vec<Option<Pipeline>>,
    /// What is compared. Pipelines are learned for [`Processing::L3`] alone.
    pub processing: &'a [Processing],
    /// How to learn.
    pub learning: (&'a TrainingSettings, &'a Training),
    /// The lights, as [`scene_lights`](super::scene_lights) returns them. The first is that of given pipelines.
    pub lights: &'a [SceneLight],
}

impl<'a> PipelineTask<'a> {
    /// The task for cameras and their labels whose pipelines are all to be learned.
    #[must_use]
    pub fn learned(
        (cameras, labels): (&'a [Camera], &'a [String]),
        learning: (&'a TrainingSettings, &'a Training),
        lights: &'a [SceneLight],
    ) -> Self {
        Self { cameras, labels, given: Vec::new(), processing: &[Processing::L3], learning, lights }
    }
}

impl Pipelines {
    /// Learns under the first light alone. Each training scene is a step of progress.
    ///
    /// # Errors
    /// As [`learn_default`](super::learn_default), with the label of the camera; [`ExperimentError::NoScene`] without lights.
    pub fn begin(task: PipelineTask<'_>, resources: Resources<'_>) -> Result<Self, ExperimentError> {
        Self::learn(task, 1, resources)
    }

    /// The pipelines of each camera, some of them still to be learned; `None` without learned pipelines.
    #[must_use]
    pub fn sets(&self) -> &[Option<PipelineSet>] {
        &self.sets
    }

    /// Learns what is still to be learned. Each training scene is a step of progress. After an error, nothing more can be learned.
    ///
    /// # Errors
    /// As [`Pipelines::begin`].
    pub fn learn_rest(&self, resources: Resources<'_>) -> Result<(), ExperimentError> {
        let rest = self.rest.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(Rest { mut lessons, learned_for }) = rest else { return Ok(()) };
        let learned = lessons.learn_next(learned_for.len(), resources)?;
        self.keep(learned_for.into_iter().zip(learned));
        Ok(())
    }

    /// Takes pipelines that the sets expect.
    fn keep(&self, learned: impl Iterator<Item = (CameraLight, Pipeline)>) {
        for (CameraLight { camera, illuminant, grid }, pipeline) in learned {
            if let Some(Some(set)) = self.sets.get(camera) {
                set.learned(LitPipeline { illuminant, grid, pipeline });
            }
        }
    }

    /// Learns under the first `at_first` lights, at least one.
    fn learn(
        task: PipelineTask<'_>,
        at_first: usize,
        resources: Resources<'_>,
    ) -> Result<Self, ExperimentError> {
        let PipelineTask { cameras, labels, given, processing, learning, lights } = task;
        let first = lights.first().ok_or(ExperimentError::NoScene)?;
        let learns = processing.contains(&Processing::L3);
        let labelled = || cameras.iter().zip(labels);
        ensure_lights_suffice(labelled().map(|(camera, label)| (label.as_str(), camera)), lights)?;
        if learns {
            labelled().try_for_each(|(camera, label)| ensure_mosaic(camera, label))?;
        }
        let given = cameras.iter().zip(given.into_iter().chain(std::iter::repeat(None)));
        let of_given = |(camera, given): (&Camera, Option<Pipeline>)| {
            given.map(|given| PipelineSet::of_any_light(&first.illuminant, camera, given))
        };
        let mut sets: Vec<Option<PipelineSet>> = given.map(of_given).collect();
        // Light by light, so that the pipelines of the first turn come first, and of these the main one of each camera.
        let mut main: Vec<CameraLight> = Vec::new();
        let mut others: Vec<CameraLight> = Vec::new();
        let mut trainings: Vec<DefaultTraining> = Vec::new();
        let mut count_at_first = 0;
        for (place, SceneLight { illuminant, grid }) in lights.iter().enumerate() {
            for (number, (camera, label)) in labelled().enumerate() {
                if !learns || sets[number].is_some() {
                    continue;
                }
                let on_grid = match grid.filter(|grid| *grid != camera.grid()) {
                    Some(grid) => camera.on_grid(grid).in_context(|| label.to_owned())?,
                    None => camera.clone(),
                };
                let light =
                    CameraLight { camera: number, illuminant: illuminant.clone(), grid: on_grid.grid() };
                if main.contains(&light) || others.contains(&light) {
                    continue;
                }
                if place == 0 {
                    main.push(light)
                } else {
                    others.push(light)
                }
                let (label, light) = (label.clone(), illuminant.clone());
                trainings.push(DefaultTraining { camera: on_grid, label, light });
            }
            if place < at_first {
                count_at_first = trainings.len();
            }
        }
        let mut lessons = DefaultLessons::new(&trainings, learning, resources)?;
        let mut learned = lessons.learn_next(count_at_first, resources)?.into_iter();
        let later = others.split_off(count_at_first - main.len());
        for (CameraLight { camera, illuminant, grid }, pipeline) in main.into_iter().zip(&mut learned) {
            sets[camera] = Some(PipelineSet::single(LitPipeline { illuminant, grid, pipeline }));
        }
        for CameraLight { camera, illuminant, grid } in others.iter().chain(&later) {
            sets[*camera].iter_mut().for_each(|set| set.expect(illuminant.clone(), *grid));
        }
        let rest = (!later.is_empty()).then_some(Rest { lessons, learned_for: later });
        let pipelines = Self { sets, rest: Mutex::new(rest) };
        pipelines.keep(others.into_iter().zip(learned));
        Ok(pipelines)
    }
}

/// The pipelines of each camera of a comparison, for all lights.
///
/// # Errors
/// As [`Pipelines::begin`].
pub fn pipelines(
    task: PipelineTask<'_>,
    resources: Resources<'_>,
) -> Result<Vec<Option<PipelineSet>>, ExperimentError> {
    let all = task.lights.len();
    Ok(Pipelines::learn(task, all, resources)?.sets)
}
