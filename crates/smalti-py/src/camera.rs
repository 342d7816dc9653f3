//! Cameras: descriptions and captures.

use std::path::{Path, PathBuf};

use numpy::IntoPyArray;
use numpy::PyArrayMethods;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use smalti::camera::{Camera, ScoreSettings};
use smalti::experiment::{SimulationSettings, capture};
use smalti::isp::WhiteBalance;
use smalti::sensor::{Exposure, NoiseMode};
use smalti::spectrum::{Observer, Spectrum, WavelengthGrid};
use smalti_io::dng::DngInfo;
use smalti_io::{Override, TomlSource, cameras, memory};

use crate::cfa::PyCfa;
use crate::error::{OrRaise, one_of, short, wrong};
use crate::image::PyImage;
use crate::json::dict_of;
use crate::photograph::PyPhotograph;
use crate::pipeline::PyPipeline;
use crate::raw::PyRawImage;
use crate::scene::{PyOpticalImage, PyScene};
use crate::spectrum::{grid_of, light, wavelengths};
use crate::work::watched;

/// A camera: lens, sensor and processing.
///
/// Args:
///     source: a built-in camera ("bayer", "rgbw", "phone", …; see `smalti.cameras()`) or a TOML file. "bayer@quad-bayer" has another
///         mosaic, of the catalogue (`smalti.cfas()`) or of a TOML file, with the filters of the camera.
///     set: keys of the description to replace, such as {"sensor.pixel.pitch_um": 1.4}; `smalti list camera-keys` prints all keys.
///     wavelengths_nm: sampling wavelengths of its curves, nm, even steps; default those that it states, else 400, 410, … 700. A
///         scene on other wavelengths is simulated on the wavelengths of the scene.
///
/// Raises:
///     FileNotFoundError: when there is no such file.
///     SmaltiError: when there is no such camera, or a key or value is invalid; the message contains the line.
#[pyclass(name = "Camera", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyCamera {
    pub(crate) camera: Camera,
    /// What was recognised or supplied while the camera was read, list[str]: percent in a CSV file, a filter of the catalogue, and others.
    #[pyo3(get)]
    notes: Vec<String>,
}

#[pymethods]
impl PyCamera {
    #[new]
    #[pyo3(signature = (source, set=None, wavelengths_nm=None))]
    fn py_new(
        source: PathBuf,
        set: Option<&Bound<'_, PyDict>>,
        wavelengths_nm: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (overrides, grid) = (overrides(set)?, grid_of(wavelengths_nm)?);
        let name = source.to_string_lossy();
        let loaded = cameras::load_with_notes(&name, &overrides, grid);
        let loaded = loaded.map_err(|e| diagnosed(&name, &e.to_string()))?;
        Ok(Self { camera: loaded.camera, notes: loaded.notes })
    }

    /// A camera from the text of a TOML file.
    ///
    /// Args:
    ///     text: the description.
    ///     set: keys to replace, as for `Camera`.
    ///     wavelengths_nm: as for `Camera`.
    ///     folder: folder of the files that the text names.
    #[staticmethod]
    #[pyo3(signature = (text, set=None, wavelengths_nm=None, folder=None))]
    fn from_toml(
        text: String,
        set: Option<&Bound<'_, PyDict>>,
        wavelengths_nm: Option<&Bound<'_, PyAny>>,
        folder: Option<PathBuf>,
    ) -> PyResult<Self> {
        let (overrides, grid) = (overrides(set)?, grid_of(wavelengths_nm)?);
        Self::from_text(text, folder.unwrap_or_default(), &overrides, grid)
    }

    /// The name.
    #[getter]
    fn name(&self) -> &str {
        &self.camera.description().name
    }

    /// All keys of its description, in the units of their names.
    #[getter]
    fn description<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dict_of(py, self.camera.description())
    }

    /// Its description as the text of a TOML file.
    fn to_toml(&self) -> PyResult<String> {
        if self.camera.has_other_cfa() {
            return Err(wrong(
                "the description does not contain the Cfa of with_cfa; write its filters to files",
            ));
        }
        toml::to_string(self.camera.description()).or_raise()
    }

    /// Its colour filter array.
    #[getter]
    fn cfa(&self) -> PyCfa {
        PyCfa(self.camera.sensor.cfa.clone())
    }

    /// Rows and columns of pixels; with binning, of samples.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.camera.sensor.rows, self.camera.sensor.cols)
    }

    /// Distance between the centres of neighbouring pixels, m; with binning, of samples.
    #[getter]
    fn pitch_m(&self) -> f64 {
        self.camera.sensor.pixel.pitch_m
    }

    /// The sampling wavelengths of its curves, nm, float64 [wavelengths].
    #[getter]
    fn wavelengths_nm<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        wavelengths(py, self.camera.grid())
    }

    /// Electrons per photon on the pixel, the product of filter and quantum efficiency, float64 [channels, wavelengths].
    fn spectral_responsivity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let curves = self.camera.sensor.spectral_responsivity_on(self.camera.grid()).or_raise()?;
        let values: Vec<f64> = curves.iter().flat_map(|c| c.values()).copied().collect();
        Ok(values.into_pyarray(py).reshape((curves.len(), self.camera.grid().len()))?.into_any())
    }

    /// The same camera with another colour filter array, with binning that of the samples. Its description does not change.
    fn with_cfa(&self, cfa: &PyCfa) -> PyResult<Self> {
        let cfa = cfa.0.on_grid(self.camera.grid()).or_raise()?;
        Ok(Self { camera: self.camera.with_cfa(cfa), notes: self.notes.clone() })
    }

    /// The same camera with another number of pixels; with binning, of samples.
    fn with_size(&self, rows: usize, cols: usize) -> PyResult<Self> {
        let camera = self.camera.with_size(rows, cols);
        camera.sensor.validate().or_raise()?;
        Ok(Self { camera, notes: self.notes.clone() })
    }

    /// The scene with a field of view that fits the sensor. Scenes from files and arrays do not cover more pixels than they have samples.
    fn fitted(&self, scene: &PyScene) -> PyResult<PyScene> {
        let fitted = self.camera.fitted(scene.scene.clone(), scene.is_file).or_raise()?;
        Ok(PyScene { scene: fitted, fov_stated: true, ..scene.clone() })
    }

    /// The irradiance of a scene on the sensor. Scenes whose field of view was not stated are `fitted`.
    fn optical_image(&self, py: Python<'_>, scene: &PyScene) -> PyResult<PyOpticalImage> {
        let (camera, scene) = self.before(scene, false)?;
        watched(py, None, |_| Ok(PyOpticalImage(camera.optics.image(&scene.scene).or_raise()?)))
    }

    /// The integration time for an optical image, s: stated in the description, or determined by its exposure rule.
    fn exposure_time_s(&self, py: Python<'_>, optical_image: &PyOpticalImage) -> PyResult<f64> {
        let camera = self.camera.on_grid(optical_image.0.irradiance().grid()).or_raise()?;
        py.detach(|| camera.exposure(&optical_image.0)).or_raise().map(|e| e.time_s)
    }

    /// The raw image of an optical image.
    ///
    /// Args:
    ///     optical_image: irradiance on the sensor.
    ///     noise: "all", "shot" (photon noise only) or "none".
    ///     seed: seed of the noise of this capture; the same seed gives the same bits.
    ///     time_s: integration time, s; default `exposure_time_s`.
    #[pyo3(signature = (optical_image, *, noise="all", seed=1, time_s=None))]
    fn capture(
        &self,
        py: Python<'_>,
        optical_image: &PyOpticalImage,
        noise: &str,
        seed: u64,
        time_s: Option<f64>,
    ) -> PyResult<PyRawImage> {
        let noise = noise_mode(noise)?;
        let camera = self.camera.on_grid(optical_image.0.irradiance().grid()).or_raise()?;
        let raw = watched(py, None, |_| {
            let exposure = exposure(&camera, optical_image, time_s)?;
            camera.sensor.capture(&optical_image.0, &exposure, noise, seed).or_raise()
        })?;
        Ok(PyRawImage { raw, notes: Vec::new(), info: None })
    }

    /// Renders a raw image by the camera's own processing (demosaicking, colour matrix) to XYZ under the illuminant.
    ///
    /// Args:
    ///     raw: a raw image with the mosaic of this camera.
    ///     illuminant: illuminant of the colour matrix: a `Scene`, a name, a CSV file or a `Spectrum` of relative power.
    ///     white_balance: "none" (XYZ under the illuminant; `Image.shown` adapts white) or "camera" (as in the description).
    #[pyo3(signature = (raw, illuminant, *, white_balance="none"))]
    fn render(
        &self,
        py: Python<'_>,
        raw: &PyRawImage,
        illuminant: &Bound<'_, PyAny>,
        white_balance: &str,
    ) -> PyResult<PyImage> {
        let (light, white) = self.light(illuminant)?;
        let camera = self.camera.on_grid(light.grid()).or_raise()?;
        let known = [("none", (WhiteBalance::None, Some(white))), ("camera", (camera.white_balance(), None))];
        let (balance, white) = one_of("white_balance", white_balance, &known)?;
        watched(py, None, |_| {
            let image =
                smalti::isp::Isp::render(&camera.isp(&light, balance).or_raise()?, &raw.raw).or_raise()?;
            Ok(PyImage::new(image, white))
        })
    }

    /// The noise-free picture of the standard observer through the same lens and pixels, in XYZ on the scale of `render`.
    ///
    /// Args:
    ///     optical_image: irradiance on the sensor.
    ///     illuminant: as for `render`.
    ///     time_s: integration time, s; default `exposure_time_s`.
    #[pyo3(signature = (optical_image, illuminant, *, time_s=None))]
    fn reference(
        &self,
        py: Python<'_>,
        optical_image: &PyOpticalImage,
        illuminant: &Bound<'_, PyAny>,
        time_s: Option<f64>,
    ) -> PyResult<PyImage> {
        let (light, white) = self.light(illuminant)?;
        let camera = self.camera.on_grid(light.grid()).or_raise()?;
        watched(py, None, |_| {
            let exposure = exposure(&camera, optical_image, time_s)?;
            let image = camera.reference_as_exposed(&optical_image.0, &exposure, &light).or_raise()?;
            Ok(PyImage::new(image, Some(white)))
        })
    }

    /// Simulates one capture of a scene, as `smalti simulate` does.
    ///
    /// Args:
    ///     scene: the scene; `fitted` unless its field of view was stated.
    ///     noise: "all", "shot" (photon noise only) or "none".
    ///     seed: seed of the noise of this capture.
    ///     full_frame: read out all pixels, not only those that the scene covers.
    ///     pipeline: a learned pipeline that renders the picture, of a scene at the wavelengths of the camera (`wavelengths_nm`); default the
    ///         camera's own processing.
    #[pyo3(signature = (scene, *, noise="all", seed=1, full_frame=false, pipeline=None))]
    fn photograph(
        &self,
        py: Python<'_>,
        scene: &PyScene,
        noise: &str,
        seed: u64,
        full_frame: bool,
        pipeline: Option<&PyPipeline>,
    ) -> PyResult<PyPhotograph> {
        let pipeline = pipeline.map(|p| &p.0);
        let settings =
            SimulationSettings { noise: noise_mode(noise)?, seed, score: ScoreSettings::default() };
        let (mut camera, scene) = self.before(scene, pipeline.is_some())?;
        let white = scene.white()?;
        watched(py, None, |watch| {
            if !full_frame {
                camera.sensor.window = Some(camera.window_on(&scene.scene).or_raise()?);
            }
            let light = scene.scene.illuminant().clone();
            let photo =
                capture((&camera, pipeline), scene.scene, &settings, watch, memory::available_bytes())
                    .or_raise()?;
            let info = DngInfo::of_camera(&camera, &light).or_raise()?;
            let balanced = camera.white_balance() != WhiteBalance::None;
            Ok(PyPhotograph {
                optical_image: PyOpticalImage(photo.optical_image),
                raw: PyRawImage { raw: photo.raw, notes: Vec::new(), info: Some(info) },
                picture: PyImage::new(photo.picture, (!balanced).then_some(white)),
                exposure: photo.exposure,
                light,
                white,
                settings,
                camera,
                pipeline: pipeline.cloned(),
            })
        })
    }

    fn __repr__(&self) -> String {
        let (c, d) = (&self.camera, self.camera.description());
        format!(
            "<smalti.Camera '{}': {} × {} pixels of {} µm, f/{}, {}, {}>",
            d.name,
            c.sensor.rows,
            c.sensor.cols,
            short(c.sensor.pixel.pitch_m * 1e6),
            d.optics.f_number,
            c.sensor.cfa.name(),
            c.grid(),
        )
    }

    fn _repr_svg_(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(Bound::new(py, self.cfa())?.call_method0("_repr_svg_")?.unbind())
    }
}

impl PyCamera {
    pub(crate) fn from_text(
        text: String,
        folder: PathBuf,
        overrides: &[Override],
        grid: Option<WavelengthGrid>,
    ) -> PyResult<Self> {
        let source = TomlSource { name: "camera".into(), folder, text };
        let loaded = cameras::from_source_with_notes(&source, overrides, grid).or_raise()?;
        Ok(Self { camera: loaded.camera, notes: loaded.notes })
    }

    /// Camera and scene on one wavelength grid, with the scene fitted to the sensor: that of the scene, or that of the camera if the picture `is_learned`, since its pipeline is.
    fn before(&self, scene: &PyScene, is_learned: bool) -> PyResult<(Camera, PyScene)> {
        let mut scene = if scene.fov_stated { scene.clone() } else { self.fitted(scene)? };
        if is_learned {
            scene.scene = scene.scene.resampled(self.camera.grid()).or_raise()?;
        }
        Ok((self.camera.on_grid(scene.scene.radiance().grid()).or_raise()?, scene))
    }

    /// The spectrum of an illuminant in photons, and its white point.
    fn light(&self, value: &Bound<'_, PyAny>) -> PyResult<(Spectrum, [f64; 3])> {
        let photons = match value.cast::<PyScene>() {
            Ok(scene) => scene.get().scene.illuminant().clone(),
            Err(_) => light(value)?.photons(self.camera.grid()).or_raise()?,
        };
        let white = Observer::Cie1931.white(&photons).or_raise()?;
        Ok((photons, white))
    }
}

/// Names of the built-in cameras with their summaries.
#[pyfunction(name = "cameras")]
pub(crate) fn camera_names() -> std::collections::BTreeMap<&'static str, &'static str> {
    cameras::names().iter().map(|c| (c.name, c.summary)).collect()
}

fn exposure(camera: &Camera, image: &PyOpticalImage, time_s: Option<f64>) -> PyResult<Exposure> {
    match time_s {
        Some(time_s) => Ok(Exposure { time_s, ..camera.gain_and_offset() }),
        None => camera.exposure(&image.0).or_raise(),
    }
}

fn noise_mode(name: &str) -> PyResult<NoiseMode> {
    let known = [("all", NoiseMode::All), ("shot", NoiseMode::PhotonOnly), ("none", NoiseMode::None)];
    one_of("noise", name, &known)
}

/// The exception for a camera or study that cannot be loaded; a missing file is a FileNotFoundError.
pub(crate) fn diagnosed(name: &str, text: &str) -> PyErr {
    let is_toml = Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    const ENOENT: i32 = 2;
    if is_toml && !Path::new(name).exists() {
        PyOSError::new_err((ENOENT, text.to_owned()))
    } else {
        wrong(text)
    }
}

/// Keys and values in the form of the command.
pub(crate) fn overrides(set: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<Override>> {
    let one = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String =
            key.extract().map_err(|_| wrong("set: expected keys such as \"sensor.pixel.pitch_um\""))?;
        let value = toml_value(&value)
            .map_err(|_| wrong(format!("set[\"{key}\"]: {value} cannot be written as TOML")))?;
        Ok(Override { key, value: value.to_string() })
    };
    set.into_iter().flat_map(|set| set.iter()).map(one).collect()
}

/// Converts a value of Python or NumPy to TOML.
fn toml_value(value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(toml::Value::String(text.to_str()?.to_owned()));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(toml::Value::Boolean(value.extract()?));
    }
    if let Ok(table) = value.cast::<PyDict>() {
        let entry =
            |(k, v): (Bound<'_, PyAny>, Bound<'_, PyAny>)| Ok((k.extract::<String>()?, toml_value(&v)?));
        return Ok(toml::Value::Table(table.iter().map(entry).collect::<PyResult<_>>()?));
    }
    if let Ok(plain) = value.call_method0("tolist") {
        // NumPy's numbers and arrays.
        return toml_value(&plain);
    }
    if let Ok(whole) = value.extract::<i64>() {
        return Ok(toml::Value::Integer(whole));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(toml::Value::Float(number));
    }
    let items: Vec<Bound<'_, PyAny>> = value.try_iter()?.collect::<PyResult<_>>()?;
    Ok(toml::Value::Array(items.iter().map(toml_value).collect::<PyResult<_>>()?))
}
