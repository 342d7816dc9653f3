//! Learned pipelines: train, keep, render.

use std::path::PathBuf;

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use serde_json::json;
use smalti::camera::{Camera, LevelRule, TrainingScene, TrainingSettings, TrainingTarget, training_scenes};
use smalti::color::{ColorSpace, Image};
use smalti::l3::{
    Alpha, KernelForm, Origin, Pair, PerceptualWeights, Pipeline, Rendered, Solver, Statistics, Textures,
    Training,
};
use smalti::sensor::{Channel, ColorArchitecture};
use smalti::spectrum::Illuminant;
use smalti_io::l3;

use crate::arrays;
use crate::camera::PyCamera;
use crate::error::{OrRaise, wrong};
use crate::image::PyImage;
use crate::raw::PyRawImage;
use crate::scene::PyScene;
use crate::spectrum::light;
use crate::work::watched;

/// A learned pipeline: a table of linear operators, one for each class of patches. `train` makes one.
#[pyclass(name = "Pipeline", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyPipeline(pub(crate) Pipeline);

#[pymethods]
impl PyPipeline {
    /// A pipeline from an .l3 file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        watched(py, None, |_| Ok(Self(l3::read_table(&path).or_raise()?)))
    }

    /// Writes the pipeline, by the ending of the name: .l3 (exactly; `read` reads it), .npz (arrays for NumPy), or .h (C99 in fixed
    /// point).
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let extension =
            path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        watched(py, None, |_| match extension.as_str() {
            "l3" => l3::write_table(&path, &self.0).or_raise(),
            "npz" => l3::write_npz(&path, &self.0).or_raise(),
            "h" => {
                let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
                let plain: String =
                    stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
                let letter = plain.starts_with(|c: char| c.is_ascii_alphabetic());
                let prefix = if letter { plain } else { format!("l3_{plain}") };
                l3::write_c_header(&path, &self.0, &prefix).or_raise()
            }
            _ => Err(wrong(format!("{}: expected a name that ends in .l3, .npz or .h", path.display()))),
        })
    }

    /// The picture of a raw image, in XYZ under the light it was learned for; its channels are matched by their names.
    ///
    /// Args:
    ///     raw: a raw image of the mosaic it was learned for.
    ///     fixed_point: in 16-bit arithmetic as in a camera's firmware; digital numbers only.
    ///
    /// Raises:
    ///     SmaltiError: when the image has another mosaic or other levels, or the outputs are no picture (`render_outputs`).
    #[pyo3(signature = (raw, *, fixed_point=false))]
    fn render(&self, py: Python<'_>, raw: &PyRawImage, fixed_point: bool) -> PyResult<PyImage> {
        if self.0.outputs() != ["X", "Y", "Z"] {
            let outputs = self.0.outputs().join(", ");
            return Err(wrong(format!(
                "the pipeline gives {outputs}, which is no picture; render_outputs gives them as they are"
            )));
        }
        let rendered = self.rendered(py, raw, fixed_point)?;
        Ok(PyImage::new(Image::new(ColorSpace::Xyz, rendered.planes).or_raise()?, self.0.white()))
    }

    /// What the pipeline makes of a raw image, float32 [rows, columns, outputs], and how many pixels were unlike what was trained
    /// with, by name; those have the nearest class.
    #[pyo3(signature = (raw, *, fixed_point=false))]
    fn render_outputs<'py>(
        &self,
        py: Python<'py>,
        raw: &PyRawImage,
        fixed_point: bool,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyDict>)> {
        let Rendered { planes, outside } = self.rendered(py, raw, fixed_point)?;
        let unlike = PyDict::new(py);
        unlike.set_item("darker", outside.darker)?;
        unlike.set_item("brighter", outside.brighter)?;
        unlike.set_item("saturation", outside.saturation)?;
        let (rows, cols, count) = (planes.rows(), planes.cols(), planes.count());
        let flat = planes.into_data().into_pyarray(py);
        let array = flat.call_method1("reshape", ((count, rows, cols),))?;
        Ok((array.call_method1("transpose", (1, 2, 0))?, unlike))
    }

    /// Names of the outputs, X, Y, Z for pictures.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.0.outputs().to_vec()
    }

    /// Names of the mosaic's channels.
    #[getter]
    fn channel_names(&self) -> Vec<String> {
        self.0.channel_names().to_vec()
    }

    /// X, Y, Z of white in the light it was learned for, Y = 1; None where outputs are no picture.
    #[getter]
    fn white(&self) -> Option<[f64; 3]> {
        self.0.white()
    }

    /// The kernels, float32 [positions, saturations, levels, textures, outputs, side, side]: a view, not writeable.
    #[getter]
    fn weights<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let p = &slf.get().0;
        let axes = p.axes();
        let shape = [
            axes.positions(),
            p.saturations().len(),
            axes.level_count(),
            axes.textures().count(),
            p.outputs().len(),
            axes.side(),
            axes.side(),
        ];
        arrays::slice_view(slf.as_any().clone(), &shape, &p.kernels().weights)
    }

    /// The offsets, float32 [positions, saturations, levels, textures, outputs]: a view, not writeable.
    #[getter]
    fn offsets<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let p = &slf.get().0;
        let axes = p.axes();
        let shape = [
            axes.positions(),
            p.saturations().len(),
            axes.level_count(),
            axes.textures().count(),
            p.outputs().len(),
        ];
        arrays::slice_view(slf.as_any().clone(), &shape, &p.kernels().offsets)
    }

    /// Names of the textures that are told apart.
    #[getter]
    fn textures(&self) -> Vec<&'static str> {
        self.0.axes().textures().names().to_vec()
    }

    /// How it was learned: version, camera, settings, scenes.
    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.0.provenance(),))
    }

    /// One record for each class: position, level, texture, patches, where its kernel comes from. For a data frame.
    fn classes<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let names = self.0.axes().textures().names();
        let record = |(i, class): (usize, &smalti::l3::Class)| {
            let (key, record) = (self.0.key(i), PyDict::new(py));
            record.set_item("position", key.position)?;
            record.set_item("clipped", clipped(key.saturation, self.0.channel_names()))?;
            record.set_item("level", key.level)?;
            record.set_item("texture", names.get(usize::from(key.texture)))?;
            record.set_item("patches", class.count)?;
            record.set_item("origin", class.origin.name())?;
            Ok(record)
        };
        self.0.classes().iter().enumerate().map(record).collect()
    }

    fn __repr__(&self) -> String {
        let (s, axes) = (self.0.summary(), self.0.axes());
        let learned: usize = s.positions.iter().map(|p| p.by_origin[Origin::Learned as usize]).sum();
        format!(
            "<smalti.Pipeline: {} × {} mosaic, patches of {side} × {side}, {} classes ({learned} learned from {} patches) to {}>",
            axes.mosaic().rows(),
            axes.mosaic().cols(),
            s.classes,
            s.patches,
            self.0.outputs().join(", "),
            side = axes.side(),
        )
    }
}

impl PyPipeline {
    fn rendered(&self, py: Python<'_>, raw: &PyRawImage, fixed_point: bool) -> PyResult<Rendered> {
        watched(py, None, |_| {
            let raw = raw.raw.clone().with_channels(self.0.channel_names());
            if fixed_point {
                self.0.render_fixed(&raw).or_raise()
            } else {
                self.0.render_raw(&raw).or_raise()
            }
        })
    }
}

/// What pipelines are solved from: moments of patches and targets, class by class. They can be added up.
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

    /// Writes an .l3s file, exactly.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        watched(py, None, |_| l3::write_statistics(&path, &self.0).or_raise())
    }

    /// These and others, of the same classes and targets.
    fn merged(&self, py: Python<'_>, other: &Self) -> PyResult<Self> {
        let mut sum = self.0.clone();
        py.detach(|| sum.merge(&other.0)).or_raise()?;
        Ok(Self(sum))
    }

    /// Number of patches seen.
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

/// Gathers statistics; see `smalti.gather`.
#[pyfunction]
#[pyo3(signature = (camera, scenes, pairs, illuminants, target, target_illuminant, exposures, patch, levels, level_rule, textures, sharp, seed, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn gather_statistics(
    py: Python<'_>,
    camera: &PyCamera,
    scenes: Option<Vec<Bound<'_, PyScene>>>,
    pairs: Option<Vec<(Bound<'_, PyRawImage>, Bound<'_, PyImage>)>>,
    illuminants: Vec<Bound<'_, PyAny>>,
    target: &Bound<'_, PyAny>,
    target_illuminant: Option<&Bound<'_, PyAny>>,
    exposures: Vec<f64>,
    patch: usize,
    levels: usize,
    level_rule: &str,
    textures: &str,
    sharp: bool,
    seed: u64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(PyStatistics, String)> {
    let own = &camera.camera;
    ensure_mosaic(own)?;
    let settings = TrainingSettings {
        side: patch,
        levels,
        level_rule: one_of(
            "level_rule",
            level_rule,
            &[("logarithmic", LevelRule::Logarithmic), ("noise-steps", LevelRule::NoiseSteps)],
        )?,
        textures: one_of(
            "textures",
            textures,
            &[
                ("none", Textures::None),
                ("flat-texture", Textures::FlatTexture),
                ("oriented", Textures::Oriented),
            ],
        )?,
        target: target_of(target)?,
        target_light: target_illuminant.map(light).transpose()?,
        sharp,
        exposures,
        seed,
    };
    let lights = illuminants.iter().map(light).collect::<PyResult<Vec<Illuminant>>>()?;
    let pairs = pairs.unwrap_or_default();
    let default = scenes.is_none() && pairs.is_empty();
    let scenes =
        scenes.unwrap_or_default().iter().map(|s| fitted(camera, s.get())).collect::<PyResult<Vec<_>>>()?;
    let pairs: Vec<(PyRawImage, PyImage)> =
        pairs.iter().map(|(r, i)| (r.get().clone(), i.get().clone())).collect();
    let (statistics, sources) = watched(py, progress, |watch| {
        let first = match scenes.first() {
            Some(scene) => scene.scene.illuminant().clone(),
            None => lights.first().unwrap_or(&Illuminant::D65).photons(own.grid()).or_raise()?,
        };
        let mut statistics = own.training_statistics(&settings, &first).or_raise()?;
        let mut sources = Vec::new();
        if !pairs.is_empty() {
            if !scenes.is_empty() {
                return Err(wrong(
                    "raw files hold their noise and scenes do not: learn from pairs or from scenes",
                ));
            }
            // Real raw files hold their noise.
            statistics = Statistics::new(statistics.axes().clone(), statistics.outputs().to_vec(), true)
                .or_raise()?
                .with_white(Some(smalti::color::SRGB_WHITE));
        }
        let names: Vec<String> = own.sensor.cfa.channels().iter().map(|c| c.name.clone()).collect();
        for (i, (raw, target)) in pairs.iter().enumerate() {
            watch.check()?;
            let raw = raw.raw.clone().with_channels(&names);
            let wanted = target.image.converted(ColorSpace::Xyz).or_raise()?;
            let pair = Pair { raw: &raw, seen: None, target: wanted.planes() };
            statistics.add(&pair).or_raise_about(format!("pair {i}"))?;
            sources.push(format!("pair {i}"));
            watch.step();
        }
        for (place, scene) in scenes.iter().enumerate() {
            watch.check()?;
            let before = scenes.iter().take(place).filter(|s| s.source == scene.source).count();
            let item = item_of(&scene.source, before);
            own.train_on(&mut statistics, &scene.scene, &settings, item).or_raise_about(&scene.source)?;
            sources.push(scene.source.clone());
            watch.step();
        }
        if default {
            for (item, of_set) in training_scenes(&lights).iter().enumerate() {
                watch.check()?;
                let scene = of_set.build(own).or_raise_about(&of_set.spec)?;
                own.train_on(&mut statistics, &scene, &settings, item as u64).or_raise_about(&of_set.spec)?;
                sources.push(name(of_set));
                watch.step();
            }
        }
        Ok((statistics, sources))
    })?;
    let story = json!({"camera": own.description(), "settings": format!("{settings:?}"), "scenes": sources});
    Ok((PyStatistics(statistics), story.to_string()))
}

/// Number of scenes of the default training set.
#[pyfunction]
pub(crate) fn training_set_len() -> usize {
    training_scenes(&[]).len()
}

/// Solves statistics; see `smalti.solve`.
#[pyfunction]
#[pyo3(signature = (statistics, story, solver, alpha_flat, alpha_texture, linear, symmetry, smoothing))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn solve_statistics(
    py: Python<'_>,
    statistics: &PyStatistics,
    story: &str,
    solver: &str,
    alpha_flat: Option<(f64, f64)>,
    alpha_texture: Option<(f64, f64)>,
    linear: bool,
    symmetry: bool,
    smoothing: f64,
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
        // Weights that were given are meant.
        solver: if stated { Solver::Perceptual(weights) } else { one_of("solver", solver, &solvers)? },
        kernel: if linear { KernelForm::Linear } else { KernelForm::Affine },
        symmetry,
        smoothing,
        ..Training::default()
    };
    let known: serde_json::Value = serde_json::from_str(story).unwrap_or_default();
    let part = |key: &str| known.get(key).cloned().unwrap_or_default();
    // The keys of `smalti train`, in its order.
    let story = json!({
        "smalti_version": env!("CARGO_PKG_VERSION"),
        "camera": part("camera"),
        "settings": part("settings"),
        "training": format!("{training:?}"),
        "scenes": part("scenes"),
        "patches": statistics.0.count(),
    });
    watched(py, None, |_| Ok(PyPipeline(training.solve(&statistics.0, story.to_string()).or_raise()?)))
}

fn name(scene: &TrainingScene) -> String {
    format!("{} under {}", scene.spec, scene.light.name())
}

/// The number that a scene's noise is keyed by, from its name as for the command (FNV-1a, 32 bits): the same whether it is learned
/// from alone, in parts or with others. Further scenes of one name have numbers of their own.
fn item_of(name: &str, before: usize) -> u64 {
    let hash = name.bytes().fold(0x811c_9dc5, |h: u64, b| ((h ^ u64::from(b)) * 0x0100_0193) & 0xffff_ffff);
    hash.wrapping_add(before as u64) & 0xffff_ffff
}

/// A scene on the camera's wavelengths and sensor.
fn fitted(camera: &PyCamera, scene: &PyScene) -> PyResult<PyScene> {
    let grid = camera.camera.grid();
    let scene = if scene.scene.radiance().grid() == grid {
        scene.clone()
    } else {
        PyScene { scene: scene.scene.clone().resampled(grid).or_raise_about(&scene.source)?, ..scene.clone() }
    };
    if scene.fov_stated { Ok(scene) } else { camera.on_sensor(&scene) }
}

/// What should come out: XYZ, or what another camera sees.
fn target_of(value: &Bound<'_, PyAny>) -> PyResult<TrainingTarget> {
    if let Ok(camera) = value.cast::<PyCamera>() {
        let camera = &camera.get().camera;
        let curves = camera.sensor.spectral_responsivity_on(camera.grid()).or_raise()?;
        let channels = camera.sensor.cfa.channels().iter().zip(curves);
        let channel = |(c, curve): (&Channel, _)| Channel { name: c.name.clone(), transmittance: curve };
        return Ok(TrainingTarget::Channels(channels.map(channel).collect()));
    }
    match value.cast::<PyString>().map(|s| s.to_string().to_ascii_lowercase()).as_deref() {
        Ok("xyz") => Ok(TrainingTarget::Xyz),
        _ => Err(wrong("target: expected \"xyz\" or a Camera")),
    }
}

/// That a camera is one that pipelines are learned for.
fn ensure_mosaic(camera: &Camera) -> PyResult<()> {
    let architecture = match camera.sensor.architecture {
        ColorArchitecture::Mosaic => return Ok(()),
        ColorArchitecture::Prism => "prism",
        ColorArchitecture::FieldSequential => "field-sequential",
    };
    let name = &camera.description().name;
    Err(wrong(format!(
        "{name}: `sensor.architecture` is {architecture}: every pixel sees every channel; learned pipelines are for mosaics"
    )))
}

fn one_of<T: Clone>(what: &str, name: &str, known: &[(&str, T)]) -> PyResult<T> {
    let found = known.iter().find(|(n, _)| *n == name).map(|(_, v)| v.clone());
    let names = || known.iter().map(|(n, _)| *n).collect::<Vec<_>>().join(", ");
    found.ok_or_else(|| wrong(format!("{what} is '{name}'; expected one of {}", names())))
}

/// Names of the channels of a combination.
fn clipped(mask: u32, names: &[String]) -> String {
    if mask == 0 {
        return "none".into();
    }
    let set = names.iter().enumerate().filter(|(c, _)| mask >> c & 1 == 1);
    set.map(|(_, n)| n.as_str()).collect::<Vec<_>>().join("")
}
