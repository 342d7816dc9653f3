//! Colour filter arrays.

use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict, PyString};
use smalti::sensor::cfa;
use smalti::sensor::{Cfa, Channel, Mosaic};
use smalti::spectrum::{Extrapolation, Spectrum, WavelengthGrid};
use smalti_report::{Cell, Mosaics, Rgb};

use crate::arrays;
use crate::error::{OrRaise, wrong};
use crate::spectrum::{PySpectrum, filter, grid_or_visible, wavelengths};

/// A colour filter array: a tile of cells, repeated over the sensor, and the transmittance of each channel.
///
/// Args:
///     pattern: the name of a built-in array ("bayer", "random?channels=4&seed=1", …; see `smalti.cfas()`), or the rows of a tile in
///         letters, such as ["RG", "GB"].
///     filters: filter of each letter: a `Spectrum`, the name of a built-in filter (`smalti.filters()`) or a CSV file, a number
///         (the same at every wavelength), or a formula as in camera files, such as
///         {"gaussian": {"center_nm": 550, "sigma_nm": 30}}. They replace the filters of a built-in array.
///     wavelengths_nm: sampling wavelengths of the filters, nm, even steps; default 400, 410, … 700.
///     name: name of the array; default the pattern.
#[pyclass(name = "Cfa", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyCfa(pub(crate) Cfa);

#[pymethods]
impl PyCfa {
    #[new]
    #[pyo3(signature = (pattern, filters=None, wavelengths_nm=None, name=None))]
    fn new(
        pattern: &Bound<'_, PyAny>,
        filters: Option<&Bound<'_, PyDict>>,
        wavelengths_nm: Option<&Bound<'_, PyAny>>,
        name: Option<String>,
    ) -> PyResult<Self> {
        let grid = grid_or_visible(wavelengths_nm)?;
        let filters = filters.map(|f| letters(f, grid)).transpose()?.unwrap_or_default();
        let cfa = if let Ok(known) = pattern.cast::<PyString>() {
            cfa::builtin_with(known.to_str()?, grid, &filters).or_raise()?
        } else {
            let rows: Vec<String> = pattern
                .extract()
                .map_err(|_| wrong("pattern: expected a name or rows of letters such as [\"RG\", \"GB\"]"))?;
            let name = name.clone().unwrap_or_else(|| rows.join("/"));
            Cfa::from_pattern(name, &rows, &filters).or_raise()?
        };
        Ok(Self(match name {
            Some(name) => Cfa::new(name, cfa.mosaic().clone(), cfa.channels().to_vec()).or_raise()?,
            None => cfa,
        }))
    }

    /// A colour filter array from arrays.
    ///
    /// Args:
    ///     tile: the channel of each cell, whole numbers from 0 [rows, columns].
    ///     transmittances: one row for each channel, 0 to 1 [channels, wavelengths].
    ///     wavelengths_nm: nm, even steps; default 400, 410, … 700.
    ///     channel_names: default A, B, C, …
    ///     name: name of the array.
    #[staticmethod]
    #[pyo3(signature = (tile, transmittances, wavelengths_nm=None, channel_names=None, name="custom"))]
    fn from_arrays(
        tile: &Bound<'_, PyAny>,
        transmittances: &Bound<'_, PyAny>,
        wavelengths_nm: Option<&Bound<'_, PyAny>>,
        channel_names: Option<Vec<String>>,
        name: &str,
    ) -> PyResult<Self> {
        let mosaic = mosaic(tile)?;
        let grid = grid_or_visible(wavelengths_nm)?;
        let curves = arrays::array::<f64>(transmittances, "transmittances")?;
        arrays::expect_axes(curves.shape(), "transmittances", &["channels", "wavelengths"])?;
        let count = curves.shape().first().copied().unwrap_or(0);
        let names = channel_names.unwrap_or_else(|| (0..count).map(default_name).collect());
        if names.len() != count {
            return Err(wrong(format!("channel_names: {} names for {count} channels", names.len())));
        }
        let channel = |(name, values): (String, numpy::ndarray::ArrayViewD<'_, f64>)| {
            let transmittance =
                Spectrum::new(grid, values.iter().copied().collect()).or_raise_about(&name)?;
            if let Some(v) = transmittance.values().iter().find(|v| !(0.0..=1.0).contains(*v)) {
                return Err(wrong(format!("transmittances: {v} in channel {name}; expected 0 to 1")));
            }
            Ok(Channel { name, transmittance })
        };
        let curves = curves.as_array();
        let channels = names.into_iter().zip(curves.outer_iter()).map(channel).collect::<PyResult<_>>()?;
        Ok(Self(Cfa::new(name, mosaic, channels).or_raise()?))
    }

    /// The name.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// The channel of each cell, uint8 [rows, columns]: a view, not writeable.
    #[getter]
    fn tile<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let mosaic = slf.get().0.mosaic();
        arrays::slice_view(slf.as_any().clone(), &[mosaic.rows(), mosaic.cols()], mosaic.cells())
    }

    /// The rows of the tile as letters; None if the name of a channel is longer than one letter.
    #[getter]
    fn letters(&self) -> Option<Vec<String>> {
        self.0.letters()
    }

    /// Names of the channels, in the order of their numbers in `tile`.
    #[getter]
    pub(crate) fn channel_names(&self) -> Vec<String> {
        self.0.channels().iter().map(|c| c.name.clone()).collect()
    }

    /// The transmittance of each channel, 0 to 1, by the name of the channel.
    #[getter]
    fn channels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.0.channels().iter().map(|c| (&c.name, PySpectrum(c.transmittance.clone()))).into_py_dict(py)
    }

    /// The sampling wavelengths of the filters, nm, float64 [wavelengths].
    #[getter]
    fn wavelengths_nm<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        let grid = self.0.channels().first().map(|c| c.transmittance.grid()).unwrap_or_default();
        wavelengths(py, grid)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        let mosaic = self.0.mosaic();
        let tile = self.0.letters().map_or_else(String::new, |rows| format!(" {}", rows.join("/")));
        format!(
            "<smalti.Cfa '{}': {} × {} cells{tile}, {} channels ({})>",
            self.0.name(),
            mosaic.rows(),
            mosaic.cols(),
            self.0.channels().len(),
            self.channel_names().join(", "),
        )
    }

    /// The tiles in the colours of their filters, as SVG.
    fn _repr_svg_(&self) -> PyResult<String> {
        let looks = |c: &Channel| -> PyResult<Cell> {
            let seen = c.transmittance.resampled(WavelengthGrid::VISIBLE, Extrapolation::Zero).or_raise()?;
            let nm: Vec<f64> = seen.grid().wavelengths_nm().collect();
            let letter = if c.name.chars().count() <= 2 { c.name.clone() } else { String::new() };
            Ok(Cell { letter, color: Rgb::of_transmittance(&nm, seen.values()) })
        };
        let channels = self.0.channels().iter().map(looks).collect::<PyResult<Vec<_>>>()?;
        let mosaic = self.0.mosaic();
        let cells: Vec<Cell> =
            mosaic.cells().iter().filter_map(|&c| channels.get(usize::from(c)).cloned()).collect();
        let drawn = Mosaics::new().mosaic(self.0.name(), mosaic.cols(), &cells).draw().or_raise()?;
        Ok(drawn.svg().to_owned())
    }
}

/// Names of the built-in colour filter arrays.
#[pyfunction]
pub(crate) fn cfas() -> Vec<&'static str> {
    cfa::names().iter().map(|c| c.name).collect()
}

/// Names of the built-in filters.
#[pyfunction]
pub(crate) fn filters() -> Vec<&'static str> {
    cfa::builtin_filters().iter().map(|f| f.name).collect()
}

/// A tile argument: whole numbers [rows, columns].
pub(crate) fn mosaic(tile: &Bound<'_, PyAny>) -> PyResult<Mosaic> {
    let tile = arrays::array::<i64>(tile, "tile")?;
    arrays::expect_axes(tile.shape(), "tile", &["rows", "columns"])?;
    let cell = |&v: &i64| {
        u8::try_from(v).map_err(|_| wrong(format!("tile: {v} is not a channel; expected 0 to 255")))
    };
    let cells = tile.as_array().iter().map(cell).collect::<PyResult<Vec<u8>>>()?;
    let (rows, cols) = (tile.shape().first().copied(), tile.shape().get(1).copied());
    Mosaic::new(rows.unwrap_or(0), cols.unwrap_or(0), cells).or_raise()
}

/// A, B, … Z, then numbers.
pub(crate) fn default_name(channel: usize) -> String {
    match u8::try_from(channel) {
        Ok(n) if n < 26 => char::from(b'A' + n).to_string(),
        _ => (channel + 1).to_string(),
    }
}

fn letters(filters: &Bound<'_, PyDict>, grid: WavelengthGrid) -> PyResult<Vec<(char, Spectrum)>> {
    let one = |(letter, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let letter: char = letter
            .extract()
            .map_err(|_| wrong("filters: expected single letters, such as {\"R\": \"red\"}"))?;
        Ok((letter, filter(&value, &format!("filters[{letter:?}]"), grid)?))
    };
    filters.iter().map(one).collect()
}
