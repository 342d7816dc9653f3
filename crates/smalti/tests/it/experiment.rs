//! Experiments on several cameras: progress and errors tell cameras of equal names apart.
#![allow(missing_docs, clippy::unwrap_used)]

use std::sync::Mutex;

use smalti::camera::{Camera, CameraDescription, TrainingSettings};
use smalti::experiment::{ExperimentError, NoStore, Processing, Progress, Resources, numbered, pipelines};
use smalti::l3::Training;
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
    let resources = Resources { store: &NoStore, progress, memory_bytes };
    let labels = numbered(vec![name.clone(), name]);
    let given = Vec::new();
    pipelines(&cameras, &labels, given, &[Processing::L3], learning, &Illuminant::D65, resources).unwrap_err()
}

#[test]
fn an_error_of_learning_states_the_label_of_the_camera() {
    let recorder = Recorder::default();
    let name = CameraDescription::default().name;
    let error = refused(&recorder, Some(1));
    assert!(error.to_string().starts_with(&format!("1-{name}: a table of ")), "{error}");
    assert_eq!(*recorder.begun.lock().unwrap(), [format!("1-{name}: pipeline")]);
}

#[test]
fn stopped_learning_is_no_error_of_a_camera() {
    let recorder = Recorder { stops: true, ..Recorder::default() };
    assert!(matches!(refused(&recorder, None), ExperimentError::Stopped));
}
