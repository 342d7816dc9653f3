//! Cameras scored on the built-in targets and scenes.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use smalti::camera::{
    CameraError, Contender, Evaluation, EvaluationSettings, LightGainSettings, ScoreSettings, Setup,
    compare_on, evaluate_with, light_gains, score_picture, test_scenes,
};
use smalti::isp::{Isp, WhiteBalance};
use smalti::numeric::Planes;
use smalti::scene::Setting;
use smalti::spectrum::{Illuminant, Observer, Spectrum};
use smalti_io::SceneRequest;
use smalti_io::cache::Cache;

use crate::arrays;
use crate::camera::PyCamera;
use crate::error::{OrRaise, wrong};
use crate::image::PyImage;
use crate::l3::PyPipeline;
use crate::scene::PyScene;
use crate::spectrum::light;
use crate::work::{InSteps, Watch, watched};

pub(crate) fn cache(keep: bool) -> Cache {
    if keep { Cache::open(None) } else { Cache::disabled() }
}

/// The scores of a camera on three targets, as `smalti evaluate` computes them: colour and noise on the ColorChecker, resolution on a
/// slanted edge, aliasing on a zone plate.
#[pyclass(name = "Evaluation", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyEvaluation {
    scores: Evaluation,
    camera: String,
    pictures: [(&'static str, PyImage); 3],
    aliasing: Planes,
}

#[pymethods]
impl PyEvaluation {
    /// Mean CIEDE2000 of the ColorChecker's patches from the chart itself, white patch at Y = 100.
    #[getter]
    fn delta_e_2000(&self) -> f64 {
        self.scores.delta_e_2000.mean
    }

    /// Mean ΔE*ab of 1976, likewise.
    #[getter]
    fn delta_e_76(&self) -> f64 {
        self.scores.delta_e_76.mean
    }

    /// Frequency at which the response to an edge falls to one half, cycles per mm on the sensor.
    #[getter]
    fn mtf50_cy_per_mm(&self) -> f64 {
        self.scores.mtf50_cy_per_mm
    }

    /// The same, cycles per pixel.
    #[getter]
    fn mtf50_cy_per_px(&self) -> f64 {
        self.scores.mtf50_cy_per_px
    }

    /// 100 · std(Y) / mean(Y) on the grey patches, mean, percent.
    #[getter]
    fn luminance_noise_percent(&self) -> f64 {
        self.scores.luminance_noise_percent.mean
    }

    /// Reciprocal of the noise of the grey patches as it is seen, median.
    #[getter]
    fn visual_snr(&self) -> f64 {
        self.scores.visual_snr.median
    }

    /// Energy in the picture of the zone plate that is not in the zone plate, percent.
    #[getter]
    fn aliasing_percent(&self) -> f64 {
        self.scores.aliasing_percent
    }

    /// Share of the chart's raw samples that are saturated, percent.
    #[getter]
    fn saturated_percent(&self) -> f64 {
        self.scores.saturated_percent
    }

    /// From the smallest signal above the dark noise to saturation, dB (EMVA 1288).
    #[getter]
    fn dynamic_range_db(&self) -> f64 {
        self.scores.dynamic_range_db
    }

    /// All figures, patch by patch, under the names that `smalti evaluate --json` has.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dict_of(py, &self.scores)
    }

    /// The pictures of the targets in XYZ: "macbeth" with all noise, "edge" and "zone-plate" without.
    #[getter]
    fn pictures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let pictures = PyDict::new(py);
        for (name, picture) in &self.pictures {
            pictures.set_item(name, Bound::new(py, picture.clone())?)?;
        }
        Ok(pictures)
    }

    /// What of the zone plate's picture is not in the zone plate, signed, linear sRGB, float32 [rows, columns, 3]: a view.
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
///     illuminant: their light: a name, a CSV file or a `Spectrum` of relative power; default D65.
///     pipeline: a learned pipeline that makes the pictures; default the camera's own processing.
///     seed: names the noise.
///     cache: keep optical images between runs, where the command keeps them.
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
    let settings = EvaluationSettings { luminance_cd_m2, illuminant, seed };
    let name = camera.camera.description().name.clone();
    let own = &camera.camera;
    let (scores, pictures) = watched(py, None, |watch| {
        let cache = self::cache(cache);
        let isp = |light: &Spectrum| processing(own, pipeline, light, watch);
        let images = |key: &str, make: &dyn Fn() -> _| cache.optical_image(key, make);
        evaluate_with(own, &settings, &images, &isp)
            .or_raise_about(format!("{name} at {luminance_cd_m2} cd/m²"))
    })?;
    let shown = |image| PyImage::new(image, Some(white));
    Ok(PyEvaluation {
        scores,
        camera: name,
        pictures: [
            ("macbeth", shown(pictures.macbeth)),
            ("edge", shown(pictures.edge)),
            ("zone-plate", shown(pictures.zone_plate)),
        ],
        aliasing: pictures.aliasing,
    })
}

/// How well a scene came out, against what the standard observer sees of it.
#[pyclass(name = "SceneScores", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PySceneScores {
    scores: smalti::camera::SceneScores,
    scene: String,
    luminance_cd_m2: f64,
    white: [f64; 3],
}

#[pymethods]
impl PySceneScores {
    /// All figures, under the names that `smalti compare --json` has.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let dict = dict_of(py, &self.scores)?;
        dict.set_item("scene", &self.scene)?;
        dict.set_item("luminance_cd_m2", self.luminance_cd_m2)?;
        Ok(dict)
    }

    /// White over RMS difference of X, Y, Z together, dB.
    #[getter]
    fn cpsnr_db(&self) -> f64 {
        self.scores.scores.cpsnr_db
    }

    /// Mean CIEDE2000 of the pixels.
    #[getter]
    fn pixel_delta_e_2000_mean(&self) -> f64 {
        self.scores.scores.pixel_delta_e_2000_mean
    }

    /// Mean S-CIELAB difference (ΔE 1976 after the blur of the eye).
    #[getter]
    fn scielab_mean(&self) -> f64 {
        self.scores.scores.scielab_mean
    }

    /// The picture, XYZ under the scene's light.
    #[getter]
    fn picture(&self) -> PyImage {
        PyImage::new(self.scores.picture.clone(), Some(self.white))
    }

    /// What the standard observer sees, on the scale of the picture.
    #[getter]
    fn reference(&self) -> PyImage {
        PyImage::new(self.scores.reference.clone(), Some(self.white))
    }

    fn __repr__(&self) -> String {
        let s = &self.scores.scores;
        format!(
            "<smalti.SceneScores of '{}' at {} cd/m²: {:.2} dB, ΔE2000 {:.2}, S-CIELAB {:.2}>",
            self.scene, self.luminance_cd_m2, s.cpsnr_db, s.pixel_delta_e_2000_mean, s.scielab_mean
        )
    }
}

/// A camera before built-in scenes, in each light, scored as `smalti compare` does: the exposure found anew for each luminance.
///
/// Args:
///     camera: the camera.
///     scenes: built-in scenes with their parameters, or `Scene` objects; default `smalti.test_scenes()`, which nothing is trained on. A
///         pixel sees two samples of a built-in scene in either direction, and one of a `Scene`.
///     luminances_cd_m2: mean luminances of the scenes, cd/m².
///     illuminant: their light; default D65. A `Scene` is re-lit if one is given.
///     pipeline: a learned pipeline; default the camera's own processing.
///     seed: names the noise.
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
    let asked = illuminant.map(light).transpose()?;
    let illuminant = asked.clone().unwrap_or(Illuminant::D65);
    let built_in = || test_scenes().iter().map(|s| NameOrScene::Name((*s).to_owned())).collect();
    let scenes = scenes.unwrap_or_else(built_in);
    let own = &camera.camera;
    watched(py, progress, |watch| {
        let mut all = Vec::new();
        for scene in &scenes {
            watch.check()?;
            let name = scene.name();
            let setup = match scene {
                NameOrScene::Name(name) => {
                    let setting = Setting {
                        luminance_cd_m2: 1.0,
                        illuminant: illuminant.clone(),
                        ..Setting::default()
                    };
                    Setup::of_test_scene(own, name, &setting).or_raise_about(name)?
                }
                NameOrScene::Scene(of) => {
                    let request = SceneRequest {
                        luminance_cd_m2: Some(1.0),
                        illuminant: asked.clone(),
                        ..Default::default()
                    };
                    let scene = request.applied_to(of.get().scene.clone()).or_raise_about(name)?;
                    let on_its_grid = camera.on(scene.radiance().grid())?;
                    Setup::new(&on_its_grid, scene, 1).or_raise_about(name)?
                }
            };
            let white = Observer::Cie1931.white(&setup.light).or_raise_about(name)?;
            for &luminance_cd_m2 in &luminances_cd_m2 {
                watch.check()?;
                let about = format!("{name} at {luminance_cd_m2} cd/m²");
                let lit = setup.in_light(luminance_cd_m2).and_then(|s| s.exposed()).or_raise_about(&about)?;
                let isp = processing(&lit.camera, pipeline, &lit.light, watch).or_raise_about(&about)?;
                let scores =
                    compare_on(&lit, &*isp, seed, &ScoreSettings::default()).or_raise_about(&about)?;
                all.push(PySceneScores { scores, scene: name.to_owned(), luminance_cd_m2, white });
            }
        }
        Ok(all)
    })
}

/// A built-in scene by its name, or any scene.
#[derive(FromPyObject)]
pub(crate) enum NameOrScene {
    Name(String),
    Scene(Py<PyScene>),
}

impl NameOrScene {
    fn name(&self) -> &str {
        match self {
            Self::Name(name) => name,
            Self::Scene(scene) => &scene.get().source,
        }
    }
}

/// The light gain; the words are in `_long.py`.
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
        scenes: scenes.unwrap_or(default.scenes),
        score: default.score,
    };
    let (of, than) = (pipelines.0.as_deref(), pipelines.1.as_deref());
    let (own, others) = (&camera.camera, &other.camera);
    let gains = watched(py, progress, |watch| {
        let (a, b) = (
            |light: &Spectrum| processing(own, of, light, watch),
            |light: &Spectrum| processing(others, than, light, watch),
        );
        let (a, b) = (Contender { camera: own, isp: &a }, Contender { camera: others, isp: &b });
        light_gains(a, b, &settings).or_raise()
    })?;
    dict_of(py, &gains)
}

/// Scenes to compare cameras on: nothing is trained on them.
#[pyfunction(name = "test_scenes")]
pub(crate) fn test_scene_names() -> Vec<&'static str> {
    test_scenes().to_vec()
}

/// The distance of a picture from a reference on the same scale, both in XYZ under the scene's light.
///
/// Args:
///     picture: the picture.
///     reference: what it should be, such as `Camera.reference`; its `white` must be known.
///     samples_per_degree: how fine pixels are to the eye, pixels per degree, 1 to 2000.
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

/// What makes pictures: a learned pipeline, else the camera's own processing, as they are under the light.
fn processing<'a>(
    camera: &'a smalti::camera::Camera,
    pipeline: Option<&'a PyPipeline>,
    light: &Spectrum,
    watch: &'a Watch,
) -> Result<Box<dyn Isp + 'a>, CameraError> {
    let isp: Box<dyn Isp> = match pipeline {
        Some(pipeline) => Box::new(&pipeline.0),
        None => Box::new(camera.isp(light, WhiteBalance::None)?),
    };
    Ok(Box::new(InSteps { isp, watch }))
}

/// What serialises to JSON, as a dict.
fn dict_of<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyAny>> {
    let json = serde_json::to_string(value).or_raise()?;
    py.import("json")?.call_method1("loads", (json,))
}
