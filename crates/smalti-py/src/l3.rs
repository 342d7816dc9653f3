//! Training of learned pipelines: statistics and their solution.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyString;
use smalti::camera::{Camera, LevelRule, TrainingSettings, TrainingTarget};
use smalti::experiment::{
    ExperimentError, Gathered, NamedScene, RawAndPicture, TrainingPair, TrainingRecord, TrainingSources,
    gather, refine, solve,
};
use smalti::l3::{Alpha, KernelForm, PerceptualWeights, Quality, Solver, Statistics, Textures, Training};
use smalti_io::rendered::TrainingSet;
use smalti_io::{l3, memory};

use crate::camera::PyCamera;
use crate::error::{OrRaise, one_of, wrong};
use crate::image::PyImage;
use crate::pipeline::PyPipeline;
use crate::raw::PyRawImage;
use crate::scene::PyScene;
use crate::spectrum::light;
use crate::work::{Told, watched};

const LEVEL_RULES: [(&str, LevelRule); 2] =
    [("logarithmic", LevelRule::Logarithmic), ("noise-steps", LevelRule::NoiseSteps)];
const TEXTURES: [(&str, Textures); 3] =
    [("none", Textures::None), ("flat-texture", Textures::FlatTexture), ("oriented", Textures::Oriented)];

/// The built-in training sets by name.
pub(crate) fn training_sets() -> Vec<(&'static str, TrainingSet)> {
    TrainingSet::NAMED.iter().map(|(name, _, set)| (*name, *set)).collect()
}

/// The statistics that pipelines are solved from: moments of patches and targets for each class. Statistics can be merged.
#[pyclass(name = "Statistics", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyStatistics(pub(crate) Statistics);

#[pymethods]
impl PyStatistics {
    /// Statistics from an .l3s file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        watched(py, None, |_| Ok(Self(l3::read_statistics(&path).or_raise()?)))
    }

    /// Writes an .l3s file without loss.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        watched(py, None, |_| l3::write_statistics(&path, &self.0).or_raise())
    }

    /// The sum of these statistics and others of the same classes and targets.
    fn merged(&self, py: Python<'_>, other: &Self) -> PyResult<Self> {
        let mut sum = self.0.clone();
        py.detach(|| sum.merge(&other.0)).or_raise()?;
        Ok(Self(sum))
    }

    /// Number of patches.
    #[getter]
    fn patches(&self) -> u64 {
        self.0.count()
    }

    /// Names of the targets.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.0.outputs().to_vec()
    }

    fn __repr__(&self) -> String {
        format!(
            "<smalti.Statistics: {} patches in {} classes, targets {}>",
            self.0.count(),
            self.0.classes().len(),
            self.0.outputs().join(", ")
        )
    }
}

/// The camera, settings and sources of statistics, for the provenance of pipelines.
#[pyclass(name = "TrainingRecord", module = "smalti._smalti", frozen)]
#[derive(Debug)]
pub(crate) struct PyTrainingRecord(TrainingRecord);

/// What is learned from.
fn sources<'a>(
    own: &Camera,
    scenes: Option<Vec<Bound<'_, PyScene>>>,
    pairs: Option<Vec<(Bound<'_, PyRawImage>, Bound<'_, PyImage>)>>,
    align: bool,
    illuminants: &[Bound<'_, PyAny>],
    training_set: &str,
) -> PyResult<TrainingSources<'a, Box<ExperimentError>>> {
    let scene = |s: Bound<'_, PyScene>| {
        let PyScene { scene, source, fov_stated, is_file } = s.get().clone();
        NamedScene::for_camera(own, source, scene, is_file, fov_stated).or_raise()
    };
    let pair = |(i, (raw, picture)): (usize, (Bound<'_, PyRawImage>, Bound<'_, PyImage>))| {
        let (raw, picture) = (raw.get().raw.clone(), picture.get().image.clone());
        let read = move || {
            let (raw, picture) = (raw.clone(), picture.clone());
            Ok(RawAndPicture { raw, default_crop: None, picture })
        };
        TrainingPair { name: format!("pair {i}"), align, read: Box::new(read) }
    };
    Ok(TrainingSources {
        scenes: scenes.map(|all| all.into_iter().map(scene).collect::<PyResult<_>>()).transpose()?,
        illuminants: illuminants.iter().map(light).collect::<PyResult<_>>()?,
        stored_scenes: one_of("training_set", training_set, &training_sets())?.stored(),
        pairs: pairs.unwrap_or_default().into_iter().enumerate().map(pair).collect(),
        saved: Vec::new(),
    })
}

/// Learns the second stage of a pipeline; see `smalti.train`.
#[pyfunction]
#[pyo3(signature = (pipeline, camera, scenes, pairs, align, illuminants, target_illuminant, exposures, sharp, training_set, seed, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn refine_pipeline(
    py: Python<'_>,
    pipeline: &PyPipeline,
    camera: &PyCamera,
    scenes: Option<Vec<Bound<'_, PyScene>>>,
    pairs: Option<Vec<(Bound<'_, PyRawImage>, Bound<'_, PyImage>)>>,
    align: bool,
    illuminants: Vec<Bound<'_, PyAny>>,
    target_illuminant: Option<&Bound<'_, PyAny>>,
    exposures: Vec<f64>,
    sharp: bool,
    training_set: &str,
    seed: u64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyPipeline> {
    let own = &camera.camera;
    let target_light = target_illuminant.map(light).transpose()?;
    let settings = TrainingSettings { target_light, sharp, exposures, seed, ..TrainingSettings::default() };
    let sources = sources(own, scenes, pairs, align, &illuminants, training_set)?;
    watched(py, progress.map(Told::Steps), |watch| {
        Ok(PyPipeline(refine(own, &settings, &pipeline.0, &sources, watch).or_raise()?))
    })
}

/// Gathers statistics; see `smalti.gather`.
#[pyfunction]
#[pyo3(signature = (camera, scenes, pairs, align, illuminants, target, target_illuminant, exposures, patch, levels, level_rule, textures, sharp, training_set, seed, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn gather_statistics(
    py: Python<'_>,
    camera: &PyCamera,
    scenes: Option<Vec<Bound<'_, PyScene>>>,
    pairs: Option<Vec<(Bound<'_, PyRawImage>, Bound<'_, PyImage>)>>,
    align: bool,
    illuminants: Vec<Bound<'_, PyAny>>,
    target: &Bound<'_, PyAny>,
    target_illuminant: Option<&Bound<'_, PyAny>>,
    exposures: Vec<f64>,
    patch: usize,
    levels: usize,
    level_rule: &str,
    textures: &str,
    sharp: bool,
    training_set: &str,
    seed: u64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(PyStatistics, PyTrainingRecord)> {
    let own = &camera.camera;
    let settings = TrainingSettings {
        side: patch,
        levels,
        level_rule: one_of("level_rule", level_rule, &LEVEL_RULES)?,
        textures: one_of("textures", textures, &TEXTURES)?,
        target: target_of(target)?,
        target_light: target_illuminant.map(light).transpose()?,
        sharp,
        exposures,
        seed,
    };
    let sources = sources(own, scenes, pairs, align, &illuminants, training_set)?;
    let Gathered { statistics, record, .. } = watched(py, progress.map(Told::Steps), |watch| {
        gather(own, &settings, &sources, watch, memory::available_bytes()).or_raise()
    })?;
    Ok((PyStatistics(statistics), PyTrainingRecord(record)))
}

/// Solves statistics; see `smalti.solve`.
#[pyfunction]
#[pyo3(signature = (statistics, story, solver, alpha_flat, alpha_texture, linear, symmetry, smoothing, quality))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn solve_statistics(
    py: Python<'_>,
    statistics: &PyStatistics,
    story: Option<&PyTrainingRecord>,
    solver: &str,
    alpha_flat: Option<(f64, f64)>,
    alpha_texture: Option<(f64, f64)>,
    linear: bool,
    symmetry: bool,
    smoothing: f64,
    quality: &str,
) -> PyResult<PyPipeline> {
    let default = PerceptualWeights::default();
    let alpha = |(luminance, chrominance)| Alpha { luminance, chrominance };
    let weights = PerceptualWeights {
        flat: alpha_flat.map_or(default.flat, alpha),
        texture: alpha_texture.map_or(default.texture, alpha),
    };
    let solvers = [
        ("wiener", Solver::Wiener),
        ("perceptual", Solver::Perceptual(weights)),
        ("ridge", Solver::Ridge),
        ("least-squares", Solver::LeastSquares),
    ];
    let stated = alpha_flat.is_some() || alpha_texture.is_some();
    let training = Training {
        // Given weights imply the perceptual solver.
        solver: if stated { Solver::Perceptual(weights) } else { one_of("solver", solver, &solvers)? },
        kernel: if linear { KernelForm::Linear } else { KernelForm::Affine },
        symmetry,
        smoothing,
        quality: one_of("quality", quality, &Quality::ALL.map(|q| (q.name(), q)))?,
        ..Training::default()
    };
    let story = story.map(|s| &s.0);
    watched(py, None, |_| Ok(PyPipeline(solve(&statistics.0, &training, story).or_raise()?)))
}

/// The training target: XYZ, or the channels of another camera.
fn target_of(value: &Bound<'_, PyAny>) -> PyResult<TrainingTarget> {
    if let Ok(camera) = value.cast::<PyCamera>() {
        return TrainingTarget::channels_of(&camera.get().camera).or_raise();
    }
    match value.cast::<PyString>().map(|s| s.to_string().to_ascii_lowercase()).as_deref() {
        Ok("xyz") => Ok(TrainingTarget::Xyz),
        _ => Err(wrong("target: expected \"xyz\" or a Camera")),
    }
}
