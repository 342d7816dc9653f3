//! Comparisons of cameras.

use pyo3::prelude::*;
use smalti::camera::{Camera, PICTURE_METRICS, ScoreSettings, TrainingSettings};
use smalti::experiment::{
    self, ComparisonSettings, EqualExposure, ExposurePolicy, PipelineTask, Pipelines, Processing, Resources,
    numbered, scene_lights,
};
use smalti::l3::Training;
use smalti::spectrum::Illuminant;
use smalti_io::memory;
use smalti_io::test_scenes::TestSet;

use crate::camera::PyCamera;
use crate::error::{OrRaise, one_of};
use crate::evaluate::{NameOrScene, cache};
use crate::json::dict_of;
use crate::l3::training_sets;
use crate::pipeline::PyPipeline;
use crate::spectrum::light;
use crate::work::{Told, watched};

/// The comparison; see `smalti.compare`.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    cameras: Vec<PyRef<'py, PyCamera>>,
    pipelines: Vec<Option<PyRef<'py, PyPipeline>>>,
    processing: Vec<String>,
    scenes: SetOrScenes,
    luminances_cd_m2: Vec<f64>,
    illuminant: Option<&Bound<'py, PyAny>>,
    exposure: (TimeOrPolicy, f64, f64),
    training_set: &str,
    seeds: (u64, u64),
    cache: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Vec<Bound<'py, PyAny>>, Bound<'py, PyAny>)> {
    let illuminant = illuminant.map_or(Ok(Illuminant::D65), light)?;
    let (exposure, saturated_share, longest_s) = exposure;
    let (seed, seed_count) = seeds;
    let exposure = exposure.policy(EqualExposure { saturated_share, longest_s })?;
    let known: Vec<_> = Processing::all().into_iter().map(|p| (p.name(), p)).collect();
    let processing: Vec<Processing> =
        processing.iter().map(|name| one_of("processing", name, &known)).collect::<PyResult<_>>()?;
    let given = pipelines.iter().map(|p| p.as_ref().map(|p| p.0.clone())).collect();
    let cameras: Vec<Camera> = cameras.iter().map(|c| c.camera.clone()).collect();
    experiment::ensure_any_defined(&cameras, &processing).or_raise()?;
    let labels = numbered(cameras.iter().map(|c| c.description().name.clone()).collect());
    let scenes = match scenes {
        SetOrScenes::Set(name) => one_of("scenes", &name, &sets())?.scenes(&illuminant).or_raise()?,
        SetOrScenes::Scenes(scenes) => {
            scenes.iter().map(|s| s.test_scene(Some(&illuminant))).collect::<PyResult<_>>()?
        }
    };
    let settings = ComparisonSettings {
        luminances_cd_m2,
        illuminant,
        scenes,
        seed,
        seed_count,
        score: ScoreSettings::default(),
        exposure,
    };
    let training_set = one_of("training_set", training_set, &training_sets())?;
    let training = TrainingSettings { seed, ..TrainingSettings::default() };
    let lights = scene_lights(&settings.illuminant, &settings.scenes).or_raise()?;
    let (names, compared) = watched(py, progress.map(Told::Steps), |watch| {
        let store = self::cache(cache)?;
        let resources = Resources {
            store: &store,
            training_scenes: training_set.stored(),
            progress: watch,
            memory_bytes: memory::available_bytes(),
        };
        let (luminances, light) = (&settings.luminances_cd_m2, &settings.illuminant);
        exposure.ensure_targets_show_something(&cameras, &labels, luminances, light, resources).or_raise()?;
        let learning = (&training, &Training::default());
        let task = PipelineTask {
            given,
            processing: &processing,
            ..PipelineTask::learned((&cameras, &labels), learning, &lights)
        };
        let learned = Pipelines::begin(task, resources).or_raise()?;
        let (contenders, _) =
            experiment::contenders(&cameras, &labels, learned.sets(), &processing).or_raise()?;
        let compared = experiment::compare_while_learning(&contenders, &learned, &settings, resources);
        let compared = compared.or_raise()?;
        let names: Vec<_> = contenders.iter().map(|c| (c.label.to_owned(), c.processing.name())).collect();
        Ok((names, compared))
    })?;
    let mut records = Vec::new();
    for ((camera, processing), outcomes) in names.iter().zip(&compared.outcomes) {
        for outcome in outcomes {
            for (scene, scored) in &outcome.scenes {
                let record = dict_of(py, &scored.scores)?;
                for (metric, mean) in PICTURE_METRICS.iter().zip(scored.means()) {
                    record.set_item(metric, mean)?;
                }
                record.set_item("seeds", scored.by_seed.len())?;
                record.set_item("camera", camera)?;
                record.set_item("processing", processing)?;
                record.set_item("scene", scene)?;
                record.set_item("luminance_cd_m2", outcome.luminance_cd_m2)?;
                record.set_item("mtf50_cy_per_mm", outcome.targets.mtf50_cy_per_mm)?;
                record.set_item("mtf50_reliability", outcome.targets.mtf50_reliability.name())?;
                let low_contrast = outcome.targets.mtf50_low_contrast_cy_per_mm;
                record.set_item("mtf50_low_contrast_cy_per_mm", low_contrast)?;
                record.set_item("visual_snr", outcome.targets.visual_snr.median)?;
                record.set_item("luminance_noise_percent", outcome.targets.luminance_noise_percent.mean)?;
                records.push(record);
            }
        }
    }
    let verdict = dict_of(py, &compared.verdict)?;
    let contenders: Vec<String> = names.iter().map(|(camera, kind)| format!("{camera} {kind}")).collect();
    verdict.set_item("contenders", contenders)?;
    Ok((records, verdict))
}

/// The sets of test scenes by name.
fn sets() -> Vec<(&'static str, TestSet)> {
    TestSet::NAMED.iter().map(|(name, _, set)| (*name, *set)).collect()
}

/// The name of a set of test scenes, or scenes.
#[derive(FromPyObject)]
pub(crate) enum SetOrScenes {
    Set(String),
    Scenes(Vec<NameOrScene>),
}

/// An exposure time, s, or the name of an exposure policy.
#[derive(FromPyObject)]
pub(crate) enum TimeOrPolicy {
    Time(f64),
    Policy(String),
}

impl TimeOrPolicy {
    fn policy(&self, limits: EqualExposure) -> PyResult<ExposurePolicy> {
        match self {
            Self::Time(time_s) => Ok(ExposurePolicy::Time(*time_s)),
            Self::Policy(name) => one_of("exposure", name, &ExposurePolicy::named(limits)),
        }
    }
}
