//! Scenes and optical images.

use std::path::PathBuf;

use numpy::IntoPyArray;
use pyo3::prelude::*;
use smalti::color::{ColorSpace, Image};
use smalti::optics::OpticalImage;
use smalti::scene::{Scene, Setting};
use smalti::spectrum::{Observer, SpectralCube, WavelengthGrid};
use smalti_io::scene_file::{
    self, Crop, Format, Quantity, ReadOptions, SpectralFile, Upsampling, Whole, WriteOptions,
};
use smalti_io::{SceneRequest, exr, matlab, spectral_tiff};

use crate::arrays;
use crate::error::{OrRaise, one_of, short, wrong};
use crate::image::PyImage;
use crate::spectrum::{PySpectrum, grid_of, grid_or_visible, light, wavelengths};
use crate::work::watched;

/// What values can be; radiance first.
const QUANTITIES: [(&str, Quantity); 4] = [
    ("photons", Quantity::Photons),
    ("energy", Quantity::Energy),
    ("relative-energy", Quantity::RelativeEnergy),
    ("reflectance", Quantity::Reflectance),
];

const UPSAMPLINGS: [(&str, Upsampling); 2] =
    [("smooth", Upsampling::Smooth), ("measured", Upsampling::Measured)];

/// A flat scene of spectral radiance in front of the camera.
///
/// Args:
///     source: a built-in scene, with its parameters if any ("macbeth", "zone-plate?size=400", …; see `smalti.scenes()`), or a file:
///         spectral EXR, MATLAB, HDF5, ENVI, NumPy, spectral TIFF, a folder of bands, or a picture (PNG, TIFF, JPEG, EXR), which is
///         upsampled to spectra.
///     luminance_cd_m2: mean luminance, cd/m²; default 100 for built-in scenes, else the value in the file.
///     illuminant: a name, a CSV file or a `Spectrum` of relative power; default D65, or the illuminant in the file.
///     distance_m: distance from the lens, m; default 1.2, or the value in the file.
///     fov_deg: full horizontal field of view, degrees; default 10, or the value in the file.
///     wavelengths_nm: nm, even steps; default 400, 410, … 700, or those of the file; needed for a file that states none.
///     quantity: quantity of a file that does not state it: "photons", "energy", "relative-energy" or "reflectance".
///     variable: variable, array or dataset of a file that holds the spectral cube.
///     crop: part of a file to read: (row, column, rows, columns).
///     clamp_negative: replace negative samples of a file by zero; otherwise they are an error.
///     upsampling: spectra of a picture: "smooth" (reflectances of three coefficients, by the colour of the pixel alone; the default) or
///         "measured" (mixtures of measured reflectances that are near in colour within a segment).
///
/// Raises:
///     OSError: when a file cannot be read.
///     SmaltiError: when there is no such scene, a parameter is out of range, or a file contains no scene.
#[pyclass(name = "Scene", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyScene {
    pub(crate) scene: Scene,
    /// The name or file that was requested.
    pub(crate) source: String,
    /// Whether the field of view was stated and must be kept.
    pub(crate) fov_stated: bool,
    /// Whether it comes from a file, so that it has no more detail than its samples.
    pub(crate) is_file: bool,
}

#[pymethods]
impl PyScene {
    #[new]
    #[pyo3(signature = (source, *, luminance_cd_m2=None, illuminant=None, distance_m=None, fov_deg=None, wavelengths_nm=None,
        quantity=None, variable=None, crop=None, clamp_negative=false, upsampling=None))]
    #[expect(clippy::too_many_arguments, reason = "keywords in Python")]
    fn new(
        py: Python<'_>,
        source: PathBuf,
        luminance_cd_m2: Option<f64>,
        illuminant: Option<&Bound<'_, PyAny>>,
        distance_m: Option<f64>,
        fov_deg: Option<f64>,
        wavelengths_nm: Option<&Bound<'_, PyAny>>,
        quantity: Option<&str>,
        variable: Option<String>,
        crop: Option<(usize, usize, usize, usize)>,
        clamp_negative: bool,
        upsampling: Option<&str>,
    ) -> PyResult<Self> {
        let name = source.to_string_lossy().into_owned();
        let grid = grid_of(wavelengths_nm)?;
        let fov_stated = fov_deg.is_some() || name.contains("fov=");
        let is_file = scene_file::is_meant(&name);
        let of_files = quantity.is_some()
            || variable.is_some()
            || crop.is_some()
            || clamp_negative
            || upsampling.is_some();
        if !is_file && of_files {
            let options = "quantity, variable, crop, clamp_negative and upsampling";
            return Err(wrong(format!("{name}: {options} apply to files, and this is a built-in scene")));
        }
        let request = SceneRequest {
            luminance_cd_m2,
            distance_m,
            horizontal_fov_deg: fov_deg,
            illuminant: illuminant.map(light).transpose()?,
            grid,
            read: ReadOptions {
                clamp_negative,
                grid,
                quantity: quantity.map(|q| one_of("quantity", q, &QUANTITIES)).transpose()?,
                variable,
                crop: crop.map(|(row, col, rows, cols)| Crop { row, col, rows, cols }),
                upsampling: upsampling.map(|u| one_of("upsampling", u, &UPSAMPLINGS)).transpose()?,
                ..ReadOptions::default()
            },
        };
        let scene = watched(py, None, |_| smalti_io::scenes::load(&name, &request).or_raise())?;
        Ok(Self { scene, source: name, fov_stated, is_file })
    }

    /// A scene from spectral radiance.
    ///
    /// Args:
    ///     radiance: [rows, columns, wavelengths], finite and not negative, in `unit`.
    ///     wavelengths_nm: nm, even steps, as many as the last axis has; default 400, 410, … 700.
    ///     unit: "photons" (s⁻¹ m⁻² sr⁻¹ nm⁻¹), "energy" (W m⁻² sr⁻¹ nm⁻¹), or "relative-energy" (up to a factor; scaled to
    ///         `luminance_cd_m2`).
    ///     illuminant: illuminant of the scene: a name or a `Spectrum` of relative power. Its level is chosen so that white is as
    ///         bright as the brightest percent of the scene.
    ///     luminance_cd_m2: mean luminance to scale to, cd/m²; default: not scaled (100 for relative energy).
    ///     distance_m: distance from the lens, m.
    ///     fov_deg: full horizontal field of view, degrees; default: fits the sensor of the camera.
    ///     name: name of the scene.
    #[staticmethod]
    #[pyo3(signature = (radiance, wavelengths_nm=None, *, unit="photons", illuminant=None, luminance_cd_m2=None, distance_m=1.2, fov_deg=None, name="array"))]
    #[allow(clippy::too_many_arguments)]
    fn from_radiance(
        radiance: &Bound<'_, PyAny>,
        wavelengths_nm: Option<&Bound<'_, PyAny>>,
        unit: &str,
        illuminant: Option<&Bound<'_, PyAny>>,
        luminance_cd_m2: Option<f64>,
        distance_m: f64,
        fov_deg: Option<f64>,
        name: &str,
    ) -> PyResult<Self> {
        let quantity = one_of("unit", unit, &QUANTITIES[..3])?;
        let cube = cube(radiance, "radiance", wavelengths_nm)?;
        Self::from_cube(cube, quantity, illuminant, luminance_cd_m2, distance_m, fov_deg, name)
    }

    /// A scene from reflectances and an illuminant.
    ///
    /// Args:
    ///     reflectance: [rows, columns, wavelengths], finite and not negative; 1 is a perfect white diffuser.
    ///     wavelengths_nm: nm, even steps, as many as the last axis has; default 400, 410, … 700.
    ///     illuminant: a name, a CSV file or a `Spectrum` of relative power; default D65.
    ///     luminance_cd_m2: mean luminance of the scene, cd/m².
    ///     distance_m: distance from the lens, m.
    ///     fov_deg: full horizontal field of view, degrees; default: fits the sensor of the camera.
    ///     name: name of the scene.
    #[staticmethod]
    #[pyo3(signature = (reflectance, wavelengths_nm=None, *, illuminant=None, luminance_cd_m2=100.0, distance_m=1.2, fov_deg=None, name="array"))]
    fn from_reflectance(
        reflectance: &Bound<'_, PyAny>,
        wavelengths_nm: Option<&Bound<'_, PyAny>>,
        illuminant: Option<&Bound<'_, PyAny>>,
        luminance_cd_m2: f64,
        distance_m: f64,
        fov_deg: Option<f64>,
        name: &str,
    ) -> PyResult<Self> {
        let cube = cube(reflectance, "reflectance", wavelengths_nm)?;
        Self::from_cube(
            cube,
            Quantity::Reflectance,
            illuminant,
            Some(luminance_cd_m2),
            distance_m,
            fov_deg,
            name,
        )
    }

    /// Spectral radiance, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹, float32 [rows, columns, wavelengths]: a view, not writeable.
    #[getter]
    fn radiance<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        arrays::planes_view(slf.as_any().clone(), slf.get().scene.radiance().planes())
    }

    /// Radiance of a perfect white diffuser under the illuminant of the scene, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹.
    #[getter]
    fn illuminant_photons(&self) -> PySpectrum {
        PySpectrum(self.scene.illuminant().clone())
    }

    /// The wavelengths, nm, float64 [wavelengths].
    #[getter]
    fn wavelengths_nm<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        wavelengths(py, self.scene.radiance().grid())
    }

    /// Rows, columns, wavelengths.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let cube = self.scene.radiance();
        (cube.rows(), cube.cols(), cube.grid().len())
    }

    /// The name.
    #[getter]
    fn name(&self) -> &str {
        self.scene.name()
    }

    /// Distance from the lens, m.
    #[getter]
    fn distance_m(&self) -> f64 {
        self.scene.distance_m()
    }

    /// Full horizontal field of view, degrees.
    #[getter]
    fn fov_deg(&self) -> f64 {
        self.scene.horizontal_fov_deg()
    }

    /// Mean luminance, cd/m² (CIE 1931).
    #[getter]
    fn mean_luminance_cd_m2(&self) -> PyResult<f64> {
        self.scene.mean_luminance_cd_m2().or_raise()
    }

    /// Luminance of every pixel, cd/m² (CIE 1931), float32 [rows, columns].
    fn luminance_cd_m2<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = py.detach(|| self.scene.luminance_cd_m2()).or_raise()?;
        let cube = self.scene.radiance();
        values.into_pyarray(py).call_method1("reshape", ((cube.rows(), cube.cols()),))
    }

    /// The picture of the CIE 1931 standard observer: an `Image` in absolute XYZ, Y in cd/m².
    fn xyz(&self, py: Python<'_>) -> PyResult<PyImage> {
        let planes = py.detach(|| self.scene.xyz()).or_raise()?;
        Ok(PyImage::new(Image::new(ColorSpace::Xyz, planes).or_raise()?, Some(self.white()?)))
    }

    /// The scene under another illuminant (name, CSV file or `Spectrum` of relative power), with the same mean luminance.
    fn relit(&self, illuminant: &Bound<'_, PyAny>) -> PyResult<Self> {
        let light = light(illuminant)?;
        Ok(Self { scene: self.scene.clone().relit(&light).or_raise()?, ..self.clone() })
    }

    /// The scene with another mean luminance (cd/m²), distance (m) or field of view (degrees).
    #[pyo3(signature = (*, luminance_cd_m2=None, distance_m=None, fov_deg=None))]
    fn replaced(
        &self,
        luminance_cd_m2: Option<f64>,
        distance_m: Option<f64>,
        fov_deg: Option<f64>,
    ) -> PyResult<Self> {
        let request =
            SceneRequest { luminance_cd_m2, distance_m, horizontal_fov_deg: fov_deg, ..Default::default() };
        let scene = request.applied_to(self.scene.clone()).or_raise()?;
        Ok(Self { scene, fov_stated: self.fov_stated || fov_deg.is_some(), ..self.clone() })
    }

    /// The scene on other wavelengths (nm, even steps, within its range), interpolated linearly.
    fn resampled(&self, wavelengths_nm: &Bound<'_, PyAny>) -> PyResult<Self> {
        let grid = grid_or_visible(Some(wavelengths_nm))?;
        Ok(Self { scene: self.scene.clone().resampled(grid).or_raise()?, ..self.clone() })
    }

    /// The part of `rows` × `cols` pixels that begins at `row`, `col`.
    fn cropped(&self, row: usize, col: usize, rows: usize, cols: usize) -> PyResult<Self> {
        Ok(Self { scene: self.scene.clone().cropped(row, col, rows, cols).or_raise()?, ..self.clone() })
    }

    /// Writes a spectral file in the format of the extension: .exr, .mat (for ISETCam), .h5, .hdr (ENVI), .npz, .npy (photons only) or
    /// .tif.
    ///
    /// Args:
    ///     path: the file.
    ///     layout: for .exr "fichet2021" (channels `S0.400,0nm` with units) or "pbrt" (`Radiance.C01`); for .mat "v5" or "v7.3"; for
    ///         .tif "pages" or "samples". Default the first of each.
    #[pyo3(signature = (path, layout=None))]
    fn write(&self, py: Python<'_>, path: PathBuf, layout: Option<&str>) -> PyResult<()> {
        let mut options = WriteOptions::default();
        match (Format::of(&path), layout) {
            (_, None) => {}
            (Some(Format::Exr), Some("fichet2021")) => options.exr = Some(exr::Layout::Fichet2021),
            (Some(Format::Exr), Some("pbrt")) => options.exr = Some(exr::Layout::Pbrt),
            (Some(Format::Mat), Some("v5")) => options.matlab = Some(matlab::Version::V5),
            (Some(Format::Mat), Some("v7.3")) => options.matlab = Some(matlab::Version::V73),
            (Some(Format::Tiff), Some("pages")) => options.tiff.layout = spectral_tiff::Layout::Pages,
            (Some(Format::Tiff), Some("samples")) => options.tiff.layout = spectral_tiff::Layout::Samples,
            (_, Some(other)) => {
                let expected = "fichet2021 or pbrt for .exr, v5 or v7.3 for .mat, pages or samples for .tif";
                return Err(wrong(format!("{}: layout is '{other}'; expected {expected}", path.display())));
            }
        }
        watched(py, None, |_| {
            let file = SpectralFile::of_scene(&self.scene);
            scene_file::write(&path, &Whole::new(&file), &options).or_raise().map(drop)
        })
    }

    fn __repr__(&self) -> PyResult<String> {
        let cube = self.scene.radiance();
        Ok(format!(
            "<smalti.Scene '{}': {} × {} pixels, {}, photons/(s m² sr nm), mean {} cd/m², {} m away, {}° wide>",
            self.scene.name(),
            cube.rows(),
            cube.cols(),
            cube.grid(),
            short(self.mean_luminance_cd_m2()?),
            short(self.scene.distance_m()),
            short(self.scene.horizontal_fov_deg()),
        ))
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.xyz(py)?.png_as_shown(py)
    }
}

impl PyScene {
    /// X, Y, Z of the illuminant of the scene, Y = 1.
    pub(crate) fn white(&self) -> PyResult<[f64; 3]> {
        Observer::Cie1931.white(self.scene.illuminant()).or_raise()
    }

    fn from_cube(
        cube: SpectralCube,
        quantity: Quantity,
        illuminant: Option<&Bound<'_, PyAny>>,
        luminance_cd_m2: Option<f64>,
        distance_m: f64,
        fov_deg: Option<f64>,
        name: &str,
    ) -> PyResult<Self> {
        let default = Setting::default();
        let grid = cube.grid();
        let given = illuminant.map(light).transpose()?;
        let defaults = Setting {
            luminance_cd_m2: luminance_cd_m2.unwrap_or(default.luminance_cd_m2),
            distance_m,
            horizontal_fov_deg: fov_deg.unwrap_or(default.horizontal_fov_deg),
            illuminant: given.clone().unwrap_or(default.illuminant),
            grid,
        };
        let relative = matches!(quantity, Quantity::Reflectance | Quantity::RelativeEnergy);
        // The illuminant of relative radiance is scaled with it.
        let illuminant = match (&given, quantity) {
            (Some(light), Quantity::Reflectance) => Some(light.photons(grid).or_raise()?),
            _ => None,
        };
        let file = SpectralFile {
            name: name.into(),
            cube,
            quantity,
            illuminant,
            distance_m: Some(distance_m),
            horizontal_fov_deg: fov_deg,
        };
        let scene = file.into_scene(&defaults).or_raise()?;
        let request =
            SceneRequest { luminance_cd_m2: luminance_cd_m2.filter(|_| !relative), ..Default::default() };
        let scene = request.applied_to(scene).or_raise()?;
        Ok(Self { scene, source: name.into(), fov_stated: fov_deg.is_some(), is_file: true })
    }
}

/// Names of the built-in scenes with their summaries; `smalti list scenes` lists their parameters.
#[pyfunction]
pub(crate) fn scenes() -> std::collections::BTreeMap<&'static str, &'static str> {
    smalti_io::scenes::names().collect()
}

/// An array \[rows, columns, wavelengths\] on its wavelengths.
fn cube(
    value: &Bound<'_, PyAny>,
    what: &str,
    wavelengths_nm: Option<&Bound<'_, PyAny>>,
) -> PyResult<SpectralCube> {
    let planes = arrays::planes(value, what, "wavelengths")?;
    let grid: WavelengthGrid = grid_or_visible(wavelengths_nm)?;
    if planes.count() != grid.len() {
        return Err(wrong(format!(
            "{what}: the last axis has {} wavelengths; wavelengths_nm has {}",
            planes.count(),
            grid.len()
        )));
    }
    SpectralCube::new(grid, planes).or_raise_about(what)
}

/// Spectral irradiance on the sensor: the image of a scene that the lens forms.
///
/// Args:
///     irradiance: photons s⁻¹ m⁻² nm⁻¹ [rows, columns, wavelengths], finite and not negative, centred on the optical axis.
///     sample_spacing_m: distance between neighbouring samples on the sensor, m.
///     wavelengths_nm: nm, even steps; default 400, 410, … 700.
#[pyclass(name = "OpticalImage", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyOpticalImage(pub(crate) OpticalImage);

#[pymethods]
impl PyOpticalImage {
    #[new]
    #[pyo3(signature = (irradiance, sample_spacing_m, wavelengths_nm=None))]
    fn new(
        irradiance: &Bound<'_, PyAny>,
        sample_spacing_m: f64,
        wavelengths_nm: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let cube = cube(irradiance, "irradiance", wavelengths_nm)?;
        Ok(Self(OpticalImage::new(cube, sample_spacing_m).or_raise()?))
    }

    /// Photons s⁻¹ m⁻² nm⁻¹, float32 [rows, columns, wavelengths]: a view, not writeable.
    #[getter]
    fn irradiance<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        arrays::planes_view(slf.as_any().clone(), slf.get().0.irradiance().planes())
    }

    /// The wavelengths, nm, float64 [wavelengths].
    #[getter]
    fn wavelengths_nm<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        wavelengths(py, self.0.irradiance().grid())
    }

    /// Distance between neighbouring samples on the sensor, m.
    #[getter]
    fn sample_spacing_m(&self) -> f64 {
        self.0.sample_spacing_m()
    }

    /// Rows, columns, wavelengths.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let cube = self.0.irradiance();
        (cube.rows(), cube.cols(), cube.grid().len())
    }

    /// The same image with its irradiance multiplied by a factor.
    fn scaled(&self, factor: f64) -> PyResult<Self> {
        Ok(Self(self.0.scaled(factor).or_raise()?))
    }

    /// Illuminance of every sample, lux (CIE 1931), float32 [rows, columns].
    fn illuminance_lux<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = py.detach(|| self.0.illuminance_lux()).or_raise()?;
        let cube = self.0.irradiance();
        values.into_pyarray(py).call_method1("reshape", ((cube.rows(), cube.cols()),))
    }

    fn __repr__(&self) -> String {
        let cube = self.0.irradiance();
        format!(
            "<smalti.OpticalImage: {} × {} samples of {} µm, {}, photons/(s m² nm)>",
            cube.rows(),
            cube.cols(),
            short(self.0.sample_spacing_m() * 1e6),
            cube.grid(),
        )
    }
}
