//! Spectra, and arguments that are resolved to spectra.

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use smalti::sensor::Filter;
use smalti::spectrum::{Extrapolation, Illuminant, Spectrum, WavelengthGrid};
use smalti_io::{lights, spectrum_csv};

use crate::arrays;
use crate::error::{OrRaise, one_of, short, wrong};

/// Values at evenly spaced wavelengths, such as a transmittance, a reflectance or an illuminant.
///
/// Args:
///     values: one number for each wavelength, float64 [wavelengths], in the unit of the quantity.
///     wavelengths_nm: ascending in even steps, nm; default 400, 410, … 700.
///
/// Raises:
///     SmaltiError: when the lengths differ, the steps are uneven or a value is not finite.
#[pyclass(name = "Spectrum", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PySpectrum(pub(crate) Spectrum);

#[pymethods]
impl PySpectrum {
    #[new]
    #[pyo3(signature = (values, wavelengths_nm=None))]
    fn new(values: &Bound<'_, PyAny>, wavelengths_nm: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let values = arrays::numbers(values, "values")?;
        Ok(Self(Spectrum::new(grid_or_visible(wavelengths_nm)?, values).or_raise()?))
    }

    /// A spectrum from a CSV file: nm and values, comma-separated, optionally with a header.
    ///
    /// Args:
    ///     path: the file; `file.csv#column` selects a column by its name.
    #[staticmethod]
    fn read(path: std::path::PathBuf) -> PyResult<Self> {
        Ok(Self(spectrum_csv::read_spectrum(&path.to_string_lossy()).or_raise()?))
    }

    /// The values, float64 [wavelengths]: a view, not writeable.
    #[getter]
    fn values<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let values = slf.get().0.values();
        arrays::slice_view(slf.as_any().clone(), &[values.len()], values)
    }

    /// The wavelengths, nm, float64 [wavelengths].
    #[getter]
    fn wavelengths_nm<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        wavelengths(py, self.0.grid())
    }

    /// The value at a wavelength in nm, linear between samples; None outside.
    fn at(&self, wavelength_nm: f64) -> Option<f64> {
        self.0.at(wavelength_nm)
    }

    /// The sum of the values times the step in nm.
    fn integral(&self) -> f64 {
        self.0.integral()
    }

    /// The spectrum on other wavelengths (nm, even steps), linear between samples.
    ///
    /// Args:
    ///     wavelengths_nm: the new wavelengths.
    ///     outside: the value outside the spectrum: "error", "zero" or "hold" (the value at the end).
    #[pyo3(signature = (wavelengths_nm, outside="error"))]
    fn resampled(&self, wavelengths_nm: &Bound<'_, PyAny>, outside: &str) -> PyResult<Self> {
        let known =
            [("error", Extrapolation::Error), ("zero", Extrapolation::Zero), ("hold", Extrapolation::Hold)];
        let outside = one_of("outside", outside, &known)?;
        let grid = arrays::grid(&arrays::numbers(wavelengths_nm, "wavelengths_nm")?)?;
        Ok(Self(self.0.resampled(grid, outside).or_raise()?))
    }

    fn __len__(&self) -> usize {
        self.0.values().len()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        let (values, grid) = (self.0.values(), self.0.grid());
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        format!("<smalti.Spectrum: {grid}, {} to {}>", short(least), short(self.0.max()))
    }
}

/// The relative spectral power of an illuminant, in units of energy as in the tables of the CIE.
///
/// Args:
///     name: a built-in illuminant ("D65", "A", "LED", "blackbody:3000", …; see `smalti.illuminants()`) or a CSV file.
///     wavelengths_nm: sampling wavelengths, nm, even steps; default 400, 410, … 700.
#[pyfunction]
#[pyo3(signature = (name, wavelengths_nm=None))]
pub(crate) fn illuminant(
    py: Python<'_>,
    name: &str,
    wavelengths_nm: Option<&Bound<'_, PyAny>>,
) -> PyResult<PySpectrum> {
    let (light, note) = lights::load_with_note(name, std::path::Path::new("")).or_raise()?;
    warn(py, note)?;
    Ok(PySpectrum(light.energy(grid_or_visible(wavelengths_nm)?).or_raise()?))
}

/// Names of the built-in illuminants, besides `D:<kelvin>` (daylight) and `blackbody:<kelvin>`.
#[pyfunction]
pub(crate) fn illuminants() -> Vec<&'static str> {
    Illuminant::names().to_vec()
}

/// Wavelengths as an array.
pub(crate) fn wavelengths(py: Python<'_>, grid: WavelengthGrid) -> Bound<'_, PyAny> {
    grid.wavelengths_nm().collect::<Vec<f64>>().into_pyarray(py).into_any()
}

/// The grid of an optional argument; default the visible wavelengths.
pub(crate) fn grid_or_visible(wavelengths_nm: Option<&Bound<'_, PyAny>>) -> PyResult<WavelengthGrid> {
    Ok(grid_of(wavelengths_nm)?.unwrap_or_default())
}

/// The grid of an optional argument.
pub(crate) fn grid_of(wavelengths_nm: Option<&Bound<'_, PyAny>>) -> PyResult<Option<WavelengthGrid>> {
    wavelengths_nm.map(|w| arrays::grid(&arrays::numbers(w, "wavelengths_nm")?)).transpose()
}

/// An illuminant argument: a name, a CSV file, or relative spectral power (energy).
pub(crate) fn light(value: &Bound<'_, PyAny>) -> PyResult<Illuminant> {
    if let Ok(name) = value.cast::<PyString>() {
        let (light, note) = lights::load_with_note(name.to_str()?, std::path::Path::new("")).or_raise()?;
        warn(value.py(), note)?;
        return Ok(light);
    }
    let power = value.cast::<PySpectrum>().map_err(|_| {
        wrong("illuminant: expected a name, a CSV file or a smalti.Spectrum of relative power")
    })?;
    Ok(Illuminant::Measured { name: "given".into(), power: power.get().0.clone() })
}

/// Issues Python warnings about files.
pub(crate) fn warn(py: Python<'_>, notes: impl IntoIterator<Item = String>) -> PyResult<()> {
    notes.into_iter().try_for_each(|note| py.import("warnings")?.call_method1("warn", (note,)).map(drop))
}

/// A filter argument: a spectrum, the name of a built-in filter, a number (flat), or the table of a camera file.
pub(crate) fn filter(value: &Bound<'_, PyAny>, what: &str, grid: WavelengthGrid) -> PyResult<Spectrum> {
    if let Ok(spectrum) = value.cast::<PySpectrum>() {
        return spectrum.get().0.resampled(grid, Extrapolation::Error).or_raise_about(what);
    }
    let filter = if let Ok(name) = value.cast::<PyString>() {
        let name = name.to_str()?;
        if name.to_ascii_lowercase().ends_with(".csv") || name.contains(".csv#") {
            let (read, note) = spectrum_csv::read_transmittance(name).or_raise_about(what)?;
            warn(value.py(), note)?;
            return read.resampled(grid, Extrapolation::Error).or_raise_about(what);
        }
        Filter::Builtin(name.to_owned())
    } else if let Ok(flat) = value.extract::<f64>() {
        Filter::Flat(flat)
    } else if value.is_instance_of::<PyDict>() {
        let json: String = value.py().import("json")?.call_method1("dumps", (value,))?.extract()?;
        serde_json::from_str(&json).map_err(|e| wrong(format!("{what}: {e}")))?
    } else {
        return Err(wrong(format!(
            "{what}: expected a smalti.Spectrum, the name of a filter, a number or a table such as \
             {{\"gaussian\": {{\"center_nm\": 550, \"sigma_nm\": 30}}}}"
        )));
    };
    filter.spectrum(grid).or_raise_about(what)
}
