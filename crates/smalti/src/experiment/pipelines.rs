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
    of: Vec<CameraLight>,
}

/// The number of a camera, and the light and wavelengths of a pipeline.
type CameraLight = (usize, Illuminant, WavelengthGrid);

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
    /// Pipelines that are all learned, for cameras and their labels.
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

    /// Learns what is still to be learned. Each training scene is a step of progress.
    ///
    /// # Errors
    /// As [`Pipelines::begin`].
    pub fn learn_rest(&self, resources: Resources<'_>) -> Result<(), ExperimentError> {
        let rest = self.rest.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(Rest { mut lessons, of }) = rest else { return Ok(()) };
        let learned = lessons.learn_next(of.len(), resources)?;
        self.keep(of.into_iter().zip(learned));
        Ok(())
    }

    fn keep(&self, learned: impl Iterator<Item = (CameraLight, Pipeline)>) {
        for ((number, illuminant, grid), pipeline) in learned {
            if let Some(Some(set)) = self.sets.get(number) {
                set.learned(LitPipeline { illuminant, grid, pipeline });
            }
        }
    }

    /// Learns under the first `at_first` lights. All of a camera's pipelines are its set, the first of them that for the first light.
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
        // Light by light, so that those of the first lights come first.
        let (mut of, mut trainings): (Vec<CameraLight>, Vec<DefaultTraining>) = (Vec::new(), Vec::new());
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
                let light = (number, illuminant.clone(), on_grid.grid());
                if !of.contains(&light) {
                    of.push(light);
                    let (label, light) = (label.clone(), illuminant.clone());
                    trainings.push(DefaultTraining { camera: on_grid, label, light });
                }
            }
            if place < at_first {
                count_at_first = of.len();
            }
        }
        let mut lessons = DefaultLessons::new(trainings, learning, resources)?;
        let learned = lessons.learn_next(count_at_first, resources)?;
        let later = of.split_off(count_at_first);
        let mut others = Vec::new();
        for ((number, illuminant, grid), pipeline) in of.into_iter().zip(learned) {
            match &mut sets[number] {
                none @ None => *none = Some(PipelineSet::single(LitPipeline { illuminant, grid, pipeline })),
                Some(set) => {
                    set.expect(illuminant.clone(), grid);
                    others.push(((number, illuminant, grid), pipeline));
                }
            }
        }
        for (number, illuminant, grid) in &later {
            sets[*number].iter_mut().for_each(|set| set.expect(illuminant.clone(), *grid));
        }
        let rest = (!later.is_empty()).then_some(Rest { lessons, of: later });
        let pipelines = Self { sets, rest: Mutex::new(rest) };
        pipelines.keep(others.into_iter());
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
