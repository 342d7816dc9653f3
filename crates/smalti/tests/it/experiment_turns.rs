//! Comparisons that score scenes before all pipelines are learned.
#![allow(missing_docs, clippy::unwrap_used)]

use std::collections::HashMap;
use std::sync::Mutex;

use smalti::camera::{Camera, CameraDescription, ScoreSettings, TestScene, TrainingSettings};
use smalti::experiment::{
    Compared, ComparisonSettings, ExperimentError, ExposurePolicy, LitPipeline, PipelineSet, PipelineTask,
    Pipelines, Processing, Progress, Resources, Store, compare, compare_while_learning, contenders,
    pipelines, scene_lights,
};
use smalti::l3::{Quality, Statistics, Training};
use smalti::scene::{Setting, catalog};
use smalti::spectrum::Illuminant;

use crate::common::coarse_grid;

/// Records what a user is told: steps, and the scenes of preliminary results.
#[derive(Default)]
struct Recorder {
    told: Mutex<Vec<String>>,
    expected: Mutex<u64>,
    done: Mutex<u64>,
}

impl Progress for Recorder {
    fn expect(&self, steps: u64) {
        *self.expected.lock().unwrap() += steps;
    }

    fn begin(&self, step: &str) {
        self.told.lock().unwrap().push(step.to_owned());
    }

    fn done(&self) {
        *self.done.lock().unwrap() += 1;
    }

    fn preliminary(&self, table: &str) {
        self.told.lock().unwrap().push(table.lines().next().unwrap().to_owned());
    }
}

/// Keeps statistics.
#[derive(Default)]
struct KeptStatistics(Mutex<HashMap<String, Statistics>>);

impl Store for KeptStatistics {
    fn statistics(&self, key: &str) -> Option<Statistics> {
        self.0.lock().unwrap().get(key).cloned()
    }

    fn keep_statistics(&self, key: &str, statistics: &Statistics) {
        self.0.lock().unwrap().insert(key.to_owned(), statistics.clone());
    }
}

/// A scene in its own light, then a chart.
fn settings() -> ComparisonSettings {
    let setting = Setting { illuminant: Illuminant::A, grid: coarse_grid(), ..Setting::default() };
    let leaves = catalog::build_natural("dead-leaves?rows=96&cols=128&seed=1001", &setting).unwrap();
    ComparisonSettings {
        luminances_cd_m2: vec![80.0],
        illuminant: Illuminant::D65,
        scenes: vec![
            TestScene::in_own_light("warm", leaves).unwrap(),
            TestScene::built_in("macbeth?patch=24"),
        ],
        seed: 1,
        seed_count: 1,
        score: ScoreSettings::default(),
        exposure: ExposurePolicy::default(),
    }
}

fn figures(compared: &Compared) -> Vec<(String, Vec<[f64; 3]>)> {
    let outcomes = compared.outcomes.iter().flatten().flat_map(|outcome| &outcome.scenes);
    outcomes.map(|(name, scored)| (name.clone(), scored.by_seed.clone())).collect()
}

fn tables(sets: &[Option<PipelineSet>]) -> Vec<&LitPipeline> {
    sets.iter().flatten().flat_map(PipelineSet::iter).collect()
}

/// Scenes under the illuminant of the comparison are scored before the pipelines of other lights are learned, and all results are those of
/// pipelines that were learned together.
#[test]
fn the_first_scores_precede_the_pipelines_of_other_lights_and_nothing_else_changes() {
    let camera = Camera::new(CameraDescription::default(), coarse_grid()).unwrap();
    let (cameras, labels) = ([camera], ["a".to_owned()]);
    let settings = settings();
    let lights = scene_lights(&settings.illuminant, &settings.scenes).unwrap();
    assert_eq!(lights.len(), 2);
    let learned_from = TrainingSettings { exposures: vec![0.5], ..TrainingSettings::default() };
    let training = Training { quality: Quality::Best, ..Training::default() };
    let task = || PipelineTask::learned((&cameras, &labels), (&learned_from, &training), &lights);

    let together = pipelines(task(), Resources::default()).unwrap();
    let (all, _) = contenders(&cameras, &labels, &together, &[Processing::L3]).unwrap();
    let expected = compare(&all, &settings, Resources::default()).unwrap();

    let (recorder, store) = (Recorder::default(), KeptStatistics::default());
    let resources = Resources { progress: &recorder, store: &store, ..Resources::default() };
    let in_turns = Pipelines::begin(task(), resources).unwrap();
    assert_eq!(tables(in_turns.sets()).len(), 1);
    let (some, _) = contenders(&cameras, &labels, in_turns.sets(), &[Processing::L3]).unwrap();
    let refused = compare(&some, &settings, Resources::default());
    assert!(matches!(refused, Err(ExperimentError::NoPipeline { camera }) if camera == "a"));
    // As if the work had been stopped here and begun again.
    assert_eq!(store.0.lock().unwrap().len(), 1);
    let again = pipelines(task(), Resources { store: &store, ..Resources::default() }).unwrap();
    store.0.lock().unwrap().clear();
    let found = compare_while_learning(&some, &in_turns, &settings, resources).unwrap();

    assert_eq!(figures(&found), figures(&expected));
    let (its, other) = (tables(in_turns.sets()), tables(&together));
    assert_eq!(its.len(), 2);
    for ((its, other), again) in its.iter().zip(&other).zip(tables(&again)) {
        assert_eq!((&its.illuminant, its.grid), (&other.illuminant, other.grid));
        assert!(its.pipeline == other.pipeline, "{}", its.illuminant.name());
        assert!(again.pipeline == other.pipeline, "{} after a stop", its.illuminant.name());
    }
    let told = recorder.told.into_inner().unwrap();
    let first = told.iter().position(|t| t.starts_with("Means over 1 of 2 scenes")).unwrap();
    let second = told.iter().position(|t| t.starts_with("Means over 2 of 2 scenes")).unwrap();
    let trainings = |told: &[String]| told.iter().filter(|t| t.starts_with("training ")).count();
    let scenes = trainings(&told[..first]);
    assert!(scenes > 0 && scenes == trainings(&told[first..second]), "{told:#?}");
    assert_eq!(recorder.expected.into_inner().unwrap(), recorder.done.into_inner().unwrap());
}

/// Cameras with different lenses share no images, and sharp targets have images of their own. Learned in turns, the pipelines have the same
/// bits.
#[test]
fn lenses_and_sharp_targets_learn_the_same_in_turns() {
    let with_lens = |f_number| {
        let mut description = CameraDescription::default();
        description.optics.f_number = f_number;
        Camera::new(description, coarse_grid()).unwrap()
    };
    let (cameras, labels) = ([4.0, 8.0].map(with_lens), ["wide", "narrow"].map(str::to_owned));
    let settings = settings();
    let lights = scene_lights(&settings.illuminant, &settings.scenes).unwrap();
    let training = Training::default();
    for sharp in [false, true] {
        let learned_from = TrainingSettings { exposures: vec![0.5], sharp, ..TrainingSettings::default() };
        let task = || PipelineTask::learned((&cameras, &labels), (&learned_from, &training), &lights);
        let together = pipelines(task(), Resources::default()).unwrap();
        let in_turns = Pipelines::begin(task(), Resources::default()).unwrap();
        assert_eq!(tables(in_turns.sets()).len(), 2);
        in_turns.learn_rest(Resources::default()).unwrap();
        let (its, other) = (tables(in_turns.sets()), tables(&together));
        assert_eq!(its.len(), 4);
        assert!(its[0].pipeline != its[2].pipeline, "the lenses make a difference");
        for (its, other) in its.iter().zip(&other) {
            assert_eq!((&its.illuminant, its.grid), (&other.illuminant, other.grid));
            assert!(its.pipeline == other.pipeline, "{}, sharp: {sharp}", its.illuminant.name());
        }
    }
}
