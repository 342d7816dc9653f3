//! Scores of cameras on built-in targets and on scenes.

use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use smalti::camera::{
    Evaluation, EvaluationSettings, LightGainSettings, ScoreSettings, TestScene, score_picture, test_scenes,
};
use smalti::experiment::{Contender, PipelineSet, Resources, light_gain_between, score_scene};
use smalti::numeric::Planes;
use smalti::spectrum::{Illuminant, Observer};
use smalti_io::SceneRequest;
use smalti_io::cache::Cache;
use smalti_io::test_scenes::test_scene;

use crate::arrays;
use crate::camera::PyCamera;
use crate::error::{OrRaise, wrong};
use crate::image::PyImage;
use crate::json::dict_of;
use crate::pipeline::PyPipeline;
use crate::scene::PyScene;
use crate::spectrum::light;
use crate::work::{Told, watched};

pub(crate) fn cache(keep: bool) -> PyResult<Cache> {
    if keep { Cache::open(None).or_raise() } else { Ok(Cache::disabled()) }
}

/// The scores of a camera on three targets, as `smalti evaluate` computes them: colour and noise on the ColorChecker, resolution on a
/// slanted edge, aliasing on a zone plate.
#[pyclass(name = "Evaluation", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyEvaluation {
    /// Mean CIEDE2000 between the patches of the picture and the ColorChecker, with the white patch at Y = 100.
    #[pyo3(get)]
    delta_e_2000: f64,
    /// The same with ΔE*ab of 1976.
    #[pyo3(get)]
    delta_e_76: f64,
    /// Frequency at which the SFR of a slanted edge falls to one half, cycles per mm on the sensor.
    #[pyo3(get)]
    mtf50_cy_per_mm: f64,
    /// The same in cycles per pixel.
    #[pyo3(get)]
    mtf50_cy_per_px: f64,
    /// Whether this MTF50 can be trusted as a resolution: "reliable", "beyond-nyquist", "plateau" or "no-edge".
    #[pyo3(get)]
    mtf50_reliability: &'static str,
    /// MTF50 of an edge of contrast 4:1, cycles per mm on the sensor.
    #[pyo3(get)]
    mtf50_low_contrast_cy_per_mm: f64,
    /// Share of the space of the colour matching functions that the spectral sensitivities span, 0 to 1.
    #[pyo3(get)]
    vora_value: f64,
    /// Sensitivity metamerism index (ISO 17321-1) under the illuminant, at most 100.
    #[pyo3(get)]
    sensitivity_metamerism_index: f64,
    /// Range of X, Y, Z of the reflectances that the sensor cannot tell from a mid grey, percent of the range of all objects.
    #[pyo3(get)]
    metamer_mismatch_percent: f64,
    /// Mean over the grey patches of 100 · std(Y) / mean(Y), percent.
    #[pyo3(get)]
    luminance_noise_percent: f64,
    /// Median over the grey patches of the reciprocal of the visible noise.
    #[pyo3(get)]
    visual_snr: f64,
    /// Share of the energy in the picture of the zone plate that the zone plate does not contain, percent.
    #[pyo3(get)]
    aliasing_percent: f64,
    /// Share of saturated raw samples of the chart, percent.
    #[pyo3(get)]
    saturated_percent: f64,
    /// Dynamic range from the dark noise to saturation, dB (EMVA 1288).
    #[pyo3(get)]
    dynamic_range_db: f64,
    scores: Evaluation,
    camera: String,
    pictures: [(&'static str, PyImage); 3],
    aliasing: Planes,
}

#[pymethods]
impl PyEvaluation {
    /// All scores, also for each patch, with the names of `smalti evaluate --json`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dict_of(py, &self.scores)
    }

    /// The pictures of the targets in XYZ: "macbeth" with all noise, "edge" and "zone-plate" without.
    #[getter]
    fn pictures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.pictures.clone().into_py_dict(py)
    }

    /// The difference of the picture of the zone plate from the zone plate, linear sRGB, float32 [rows, columns, 3]: a view.
    #[getter]
    fn aliasing<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        arrays::planes_view(slf.as_any().clone(), &slf.get().aliasing)
    }

    fn __repr__(&self) -> String {
        format!(
            "<smalti.Evaluation of '{}' at {} cd/m²: ΔE2000 {:.2}, MTF50 {:.1} cy/mm, noise {:.2} %, aliasing {:.1} %>",
            self.camera,
            self.scores.luminance_cd_m2,
            self.scores.delta_e_2000.mean,
            self.scores.mtf50_cy_per_mm,
            self.scores.luminance_noise_percent.mean,
            self.scores.aliasing_percent,
        )
    }
}

/// Scores a camera on the built-in targets.
///
/// Args:
///     camera: the camera.
///     luminance_cd_m2: mean luminance of every target, cd/m².
///     illuminant: illuminant of the targets: a name, a CSV file or a `Spectrum` of relative power; default D65.
///     pipeline: a learned pipeline that renders the pictures; default the camera's own processing.
///     seed: seed of the noise.
///     cache: keep optical images between runs, in the cache of the command.
#[pyfunction]
#[pyo3(signature = (camera, *, luminance_cd_m2=75.0, illuminant=None, pipeline=None, seed=1, cache=true))]
pub(crate) fn evaluate(
    py: Python<'_>,
    camera: &PyCamera,
    luminance_cd_m2: f64,
    illuminant: Option<&Bound<'_, PyAny>>,
    pipeline: Option<&PyPipeline>,
    seed: u64,
    cache: bool,
) -> PyResult<PyEvaluation> {
    let illuminant = illuminant.map_or(Ok(Illuminant::D65), light)?;
    let white = Observer::Cie1931.white(&illuminant.photons(camera.camera.grid()).or_raise()?).or_raise()?;
    let settings = EvaluationSettings { luminance_cd_m2, illuminant, seed, ..EvaluationSettings::default() };
    let name = camera.camera.description().name.clone();
    let pipelines =
        pipeline.map(|p| PipelineSet::of_any_light(&settings.illuminant, &camera.camera, p.0.clone()));
    let contender = Contender::with_pipelines(&camera.camera, &name, pipelines.as_ref());
    let (scores, pictures) = watched(py, None, |watch| {
        let store = self::cache(cache)?;
        let resources = Resources { store: &store, progress: watch, ..Resources::default() };
        contender.evaluate(&settings, resources).or_raise()
    })?;
    let shown = |image| PyImage::new(image, Some(white));
    Ok(PyEvaluation {
        delta_e_2000: scores.delta_e_2000.mean,
        delta_e_76: scores.delta_e_76.mean,
        mtf50_cy_per_mm: scores.mtf50_cy_per_mm,
        mtf50_cy_per_px: scores.mtf50_cy_per_px,
        mtf50_reliability: scores.mtf50_reliability.name(),
        mtf50_low_contrast_cy_per_mm: scores.mtf50_low_contrast_cy_per_mm,
        vora_value: scores.sensor.vora_value,
        sensitivity_metamerism_index: scores.sensor.sensitivity_metamerism_index,
        metamer_mismatch_percent: scores.sensor.metamer_mismatch_percent,
        luminance_noise_percent: scores.luminance_noise_percent.mean,
        visual_snr: scores.visual_snr.median,
        aliasing_percent: scores.aliasing_percent,
        saturated_percent: scores.saturated_percent,
        dynamic_range_db: scores.dynamic_range_db,
        scores,
        camera: name.clone(),
        pictures: [
            ("macbeth", shown(pictures.macbeth)),
            ("edge", shown(pictures.edge)),
            ("zone-plate", shown(pictures.zone_plate)),
        ],
        aliasing: pictures.aliasing,
    })
}

/// The scores of a picture of a scene against the picture of the standard observer.
#[pyclass(name = "SceneScores", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PySceneScores {
    /// Ratio of white to the RMS difference over X, Y and Z, dB.
    #[pyo3(get)]
    cpsnr_db: f64,
    /// Mean CIEDE2000 of the pixels.
    #[pyo3(get)]
    pixel_delta_e_2000_mean: f64,
    /// Mean S-CIELAB difference (ΔE 1976 after the spatial filtering of the eye).
    #[pyo3(get)]
    scielab_mean: f64,
    scores: smalti::camera::SceneScores,
    processing: &'static str,
    scene: String,
    luminance_cd_m2: f64,
}

#[pymethods]
impl PySceneScores {
    /// All scores, with the names of `smalti compare --json`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let dict = dict_of(py, &self.scores)?;
        dict.set_item("processing", self.processing)?;
        dict.set_item("scene", &self.scene)?;
        dict.set_item("luminance_cd_m2", self.luminance_cd_m2)?;
        Ok(dict)
    }

    /// The picture in XYZ under the illuminant of the scene.
    #[getter]
    fn picture(&self) -> PyImage {
        PyImage::new(self.scores.picture.clone(), Some(self.scores.white))
    }

    /// The picture of the standard observer, on the scale of the picture.
    #[getter]
    fn reference(&self) -> PyImage {
        PyImage::new(self.scores.reference.clone(), Some(self.scores.white))
    }

    fn __repr__(&self) -> String {
        format!(
            "<smalti.SceneScores of '{}' at {} cd/m²: {:.2} dB, ΔE2000 {:.2}, S-CIELAB {:.2}>",
            self.scene, self.luminance_cd_m2, self.cpsnr_db, self.pixel_delta_e_2000_mean, self.scielab_mean
        )
    }
}

/// Scores a camera on scenes as `smalti compare` does. The exposure is determined for each luminance.
///
/// Args:
///     camera: the camera.
///     scenes: built-in scenes with their parameters, or `Scene` objects; default `smalti.test_scenes()`, which are not used for
///         training. A pixel covers 2 × 2 samples of a built-in scene, and one sample of a `Scene`.
///     luminances_cd_m2: mean luminances of the scenes, cd/m².
///     illuminant: illuminant of the scenes; default D65 for built-in scenes. A `Scene` is relit only if this is given.
///     pipeline: a learned pipeline; default the camera's own processing.
///     seed: seed of the noise.
///     progress: called with the number of pictures scored so far.
#[pyfunction]
#[pyo3(signature = (camera, *, scenes=None, luminances_cd_m2=vec![75.0], illuminant=None, pipeline=None, seed=1, progress=None))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn score_scenes(
    py: Python<'_>,
    camera: &PyCamera,
    scenes: Option<Vec<NameOrScene>>,
    luminances_cd_m2: Vec<f64>,
    illuminant: Option<&Bound<'_, PyAny>>,
    pipeline: Option<&PyPipeline>,
    seed: u64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<PySceneScores>> {
    let relit = illuminant.map(light).transpose()?;
    let illuminant = relit.clone().unwrap_or(Illuminant::D65);
    let built_in = || test_scenes().iter().map(|s| NameOrScene::Name((*s).to_owned())).collect();
    let scenes = scenes.unwrap_or_else(built_in);
    let name = &camera.camera.description().name;
    let pipelines = pipeline.map(|p| PipelineSet::of_any_light(&illuminant, &camera.camera, p.0.clone()));
    let contender = Contender::with_pipelines(&camera.camera, name, pipelines.as_ref());
    let score = ScoreSettings::default();
    watched(py, progress.map(Told::Pictures), |watch| {
        let mut all = Vec::new();
        for scene in &scenes {
            watch.check()?;
            let scene = scene.test_scene(relit.as_ref())?;
            let setup = scene.before(contender.camera, &illuminant).or_raise()?;
            for &luminance_cd_m2 in &luminances_cd_m2 {
                let light = (luminance_cd_m2, None);
                let scored =
                    score_scene(&contender, &setup, light, seed..seed.saturating_add(1), &score, watch);
                let scores = scored.or_raise_about(scene.name())?.scores;
                all.push(PySceneScores {
                    cpsnr_db: scores.scores.cpsnr_db,
                    pixel_delta_e_2000_mean: scores.scores.pixel_delta_e_2000_mean,
                    scielab_mean: scores.scores.scielab_mean,
                    scores,
                    processing: contender.processing.name(),
                    scene: scene.name().to_owned(),
                    luminance_cd_m2,
                });
            }
        }
        Ok(all)
    })
}

/// A built-in scene by name, or a `Scene`.
#[derive(FromPyObject)]
pub(crate) enum NameOrScene {
    Name(String),
    Scene(Py<PyScene>),
}

impl NameOrScene {
    /// The scene at a mean luminance of 1 cd/m², relit if an illuminant is given.
    pub(crate) fn test_scene(&self, illuminant: Option<&Illuminant>) -> PyResult<TestScene> {
        match self {
            Self::Name(name) => test_scene(name, illuminant.unwrap_or(&Illuminant::D65)).or_raise_about(name),
            Self::Scene(scene) => {
                let PyScene { scene, source: name, .. } = scene.get();
                let request = SceneRequest {
                    luminance_cd_m2: Some(1.0),
                    illuminant: illuminant.cloned(),
                    ..Default::default()
                };
                let scene = request.applied_to(scene.clone()).or_raise_about(name)?;
                Ok(TestScene::relit(name.clone(), scene, 1))
            }
        }
    }
}

/// The light gain; see `smalti.light_gain`.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn light_gain<'py>(
    py: Python<'py>,
    camera: &PyCamera,
    other: &PyCamera,
    pipelines: (Option<PyRef<'py, PyPipeline>>, Option<PyRef<'py, PyPipeline>>),
    scenes: Option<Vec<String>>,
    luminance_cd_m2: f64,
    illuminant: Option<&Bound<'py, PyAny>>,
    seed: u64,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let default = LightGainSettings::default();
    let settings = LightGainSettings {
        luminance_cd_m2,
        illuminant: illuminant.map_or(Ok(Illuminant::D65), light)?,
        seed,
        scenes: scenes.map_or(default.scenes, |names| names.into_iter().map(TestScene::BuiltIn).collect()),
        ..LightGainSettings::default()
    };
    let set = |pipeline: Option<PyRef<'py, PyPipeline>>| {
        pipeline.map(|p| PipelineSet::of_any_light(&settings.illuminant, &camera.camera, p.0.clone()))
    };
    let (of, than) = (set(pipelines.0), set(pipelines.1));
    let a = Contender::with_pipelines(&camera.camera, &camera.camera.description().name, of.as_ref());
    let b = Contender::with_pipelines(&other.camera, &other.camera.description().name, than.as_ref());
    let gains = watched(py, progress.map(Told::Pictures), |watch| {
        light_gain_between(&a, &b, &settings, watch).or_raise()
    })?;
    dict_of(py, &gains)
}

/// Names of the test scenes, which are not used for training.
#[pyfunction(name = "test_scenes")]
pub(crate) fn test_scene_names() -> Vec<&'static str> {
    test_scenes().to_vec()
}

/// The difference of a picture from a reference on the same scale, both in XYZ under the illuminant of the scene.
///
/// Args:
///     picture: the picture.
///     reference: the target, such as `Camera.reference`; its `white` must be known.
///     samples_per_degree: viewing condition, pixels per degree of visual angle, 1 to 2000.
///     highlight_share: share of the reference's pixels, 0 to below 1, that may be brighter than white.
///
/// Returns:
///     cpsnr_db, pixel_delta_e_2000_mean, pixel_delta_e_2000_p95, scielab_mean, white_y.
#[pyfunction(name = "score_picture")]
#[pyo3(signature = (picture, reference, *, samples_per_degree=60.0, highlight_share=0.005))]
pub(crate) fn score_pictures<'py>(
    py: Python<'py>,
    picture: &PyImage,
    reference: &PyImage,
    samples_per_degree: f64,
    highlight_share: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let white = reference
        .white
        .ok_or_else(|| wrong("reference: its white is not known; state it as Image(…, white=…)"))?;
    let settings = ScoreSettings { samples_per_degree, highlight_share };
    let scores =
        watched(py, None, |_| score_picture(&picture.image, &reference.image, white, &settings).or_raise())?;
    dict_of(py, &scores)
}
