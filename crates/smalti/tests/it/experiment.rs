//! Experiments: progress and errors tell cameras of equal names apart, and memory is checked.
#![allow(missing_docs, clippy::unwrap_used)]

use std::sync::Mutex;

use smalti::camera::{Camera, CameraDescription, ScoreSettings, TrainingSettings};
use smalti::experiment::{
    ExperimentError, PipelineTask, Progress, Resources, Silent, SimulationSettings, capture, numbered,
    pipelines, scene_lights,
};
use smalti::l3::Training;
use smalti::scene::{Setting, uniform};
use smalti::sensor::NoiseMode;
use smalti::spectrum::{Illuminant, WavelengthGrid};

/// Records the names of the steps.
#[derive(Default)]
struct Recorder {
    begun: Mutex<Vec<String>>,
    stops: bool,
}

impl Progress for Recorder {
    fn begin(&self, step: &str) {
        self.begun.lock().unwrap().push(step.to_owned());
    }

    fn is_stopped(&self) -> bool {
        self.stops
    }
}

/// The error of learning the pipelines of two cameras of one name.
fn refused(progress: &Recorder, memory_bytes: Option<u64>) -> ExperimentError {
    let camera = Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap();
    let name = camera.description().name.clone();
    let cameras = [camera.clone(), camera];
    let learning = (&TrainingSettings::default(), &Training::default());
    let resources = Resources { progress, memory_bytes, ..Resources::default() };
    let labels = numbered(vec![name.clone(), name]);
    let lights = scene_lights(&Illuminant::D65, &[]).unwrap();
    pipelines(PipelineTask::learned((&cameras, &labels), learning, &lights), resources).unwrap_err()
}

#[test]
fn an_error_of_learning_states_the_label_of_the_camera() {
    let recorder = Recorder::default();
    let name = CameraDescription::default().name;
    let error = refused(&recorder, Some(1));
    assert!(error.to_string().starts_with(&format!("1-{name}: a table of ")), "{error}");
    assert!(recorder.begun.lock().unwrap().is_empty());
}

#[test]
fn stopped_learning_is_no_error_of_a_camera() {
    let recorder = Recorder { stops: true, ..Recorder::default() };
    assert!(matches!(refused(&recorder, None), ExperimentError::Stopped));
}

/// 64 × 96 pixels of 120 bytes take 720 KiB.
#[test]
fn a_capture_larger_than_memory_is_refused() {
    let mut description = CameraDescription::default();
    (description.sensor.rows, description.sensor.cols) = (64, 96);
    let camera = Camera::new(description, WavelengthGrid::VISIBLE).unwrap();
    let settings = SimulationSettings { noise: NoiseMode::All, seed: 1, score: ScoreSettings::default() };
    let captured = |memory_bytes| {
        let scene = camera.fitted(uniform(64, 96, &Setting::default()).unwrap(), false).unwrap();
        capture((&camera, None), scene, &settings, &Silent, memory_bytes).map(drop).map_err(|e| e.to_string())
    };
    let error = captured(Some(700 << 10)).unwrap_err();
    assert!(error.contains("64 × 96 pixels") && error.contains("memory"), "{error}");
    assert_eq!((captured(Some(720 << 10)), captured(None)), (Ok(()), Ok(())));
}
