//! Raw images, from and to arrays and DNG files.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use smalti::sensor::{RawImage, RawSamples, Sampling};
use smalti_io::Limits;
use smalti_io::dng::{self, DngInfo};

use crate::arrays;
use crate::cfa::{PyCfa, default_name, mosaic};
use crate::error::{OrRaise, wrong};
use crate::work::watched;

/// Raw samples with their mosaic and levels.
///
/// Args:
///     samples: [rows, columns] of a mosaic, or [rows, columns, channels] if every pixel has every channel. Integers are digital
///         numbers of at most 16 bits; floating-point values are volts.
///     tile: the channel of each cell of the mosaic's tile, whole numbers from 0 [rows, columns], or a `Cfa`; None if every pixel
///         has every channel.
///     black_level: the value of a sample without light, in the unit of the samples.
///     white_level: the value of a sample at saturation.
///     channel_names: default those of the `Cfa`, else A, B, C, …; learned pipelines match channels by name.
#[pyclass(name = "RawImage", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyRawImage {
    pub(crate) raw: RawImage,
    /// Notes on what the reader simplified or ignored.
    #[pyo3(get)]
    pub(crate) notes: Vec<String>,
    /// The metadata of a DNG.
    pub(crate) info: Option<DngInfo>,
}

#[pymethods]
impl PyRawImage {
    #[new]
    #[pyo3(signature = (samples, tile=None, *, black_level, white_level, channel_names=None))]
    fn py_new(
        samples: &Bound<'_, PyAny>,
        tile: Option<&Bound<'_, PyAny>>,
        black_level: f64,
        white_level: f64,
        channel_names: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let as_array = samples.py().import("numpy")?.call_method1("asarray", (samples,))?;
        let kind: String = as_array.getattr("dtype")?.getattr("kind")?.extract()?;
        let shape: Vec<usize> = as_array.getattr("shape")?.extract()?;
        let (rows, cols, planes) = match (shape.as_slice(), tile.is_some()) {
            (&[rows, cols], true) => (rows, cols, 1),
            (&[rows, cols, channels], false) => (rows, cols, channels),
            (_, true) => return Err(arrays::expected("samples", &["rows", "columns"], &shape)),
            (_, false) => {
                return Err(wrong(format!(
                    "samples: expected an array [rows, columns, channels], or a tile of channels; got shape {shape:?}"
                )));
            }
        };
        let samples = if kind == "f" {
            RawSamples::Analog(planar(&as_array)?)
        } else {
            let whole = arrays::array::<i64>(&as_array, "samples")?;
            if let Some(v) = whole.as_array().iter().find(|v| u16::try_from(**v).is_err()) {
                return Err(wrong(format!("samples: {v} is out of range; expected 0 to 65535")));
            }
            RawSamples::Digital(planar(&as_array)?)
        };
        let (sampling, names) = match tile {
            None => (Sampling::Full { channels: planes }, None),
            Some(tile) => match tile.cast::<PyCfa>() {
                Ok(cfa) => (Sampling::Mosaic(cfa.get().0.mosaic().clone()), Some(cfa.get().channel_names())),
                Err(_) => (Sampling::Mosaic(mosaic(tile)?), None),
            },
        };
        let names =
            channel_names.or(names).unwrap_or_else(|| (0..sampling.channels()).map(default_name).collect());
        let raw = RawImage::new(rows, cols, samples, sampling, names, black_level, white_level).or_raise()?;
        Ok(Self { raw, notes: Vec::new(), info: None })
    }

    /// A raw image from a DNG (uncompressed, lossless JPEG, Deflate or JPEG XL), cropped to its active area.
    ///
    /// Args:
    ///     path: the file.
    ///     cfa: its mosaic, if the file states none or a wrong one: a name (`smalti.cfas()`), or rows of letters that begin at the first
    ///         pixel of the active area, such as "GR/BG".
    #[staticmethod]
    #[pyo3(signature = (path, *, cfa=None))]
    fn read(py: Python<'_>, path: PathBuf, cfa: Option<&str>) -> PyResult<Self> {
        let stated = cfa.map(str::parse).transpose().map_err(|e: String| wrong(format!("cfa: {e}")))?;
        let read = watched(py, None, |_| dng::read_as(&path, Limits::default(), stated.as_ref()).or_raise())?;
        Ok(Self { raw: read.raw, notes: read.notes, info: Some(read.info) })
    }

    /// Writes a DNG. A capture of a `Camera` contains its colour matrix; other raw images have none.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let info = self.info.clone().unwrap_or_default();
        watched(py, None, |_| dng::write(&path, &self.raw, &info).or_raise())
    }

    /// The samples: uint16 (digital numbers) or float32 (volts), [rows, columns] of a mosaic, else [rows, columns, channels]: a view,
    /// not writeable.
    #[getter]
    fn samples<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let raw = &slf.get().raw;
        let (rows, cols, planes) = (raw.rows(), raw.cols(), raw.sampling().planes());
        let owner = slf.as_any().clone();
        match (raw.samples(), raw.sampling()) {
            (RawSamples::Digital(v), Sampling::Mosaic(_)) => arrays::slice_view(owner, &[rows, cols], v),
            (RawSamples::Analog(v), Sampling::Mosaic(_)) => arrays::slice_view(owner, &[rows, cols], v),
            (RawSamples::Digital(v), _) => arrays::image_view(owner, v, rows, cols, planes),
            (RawSamples::Analog(v), _) => arrays::image_view(owner, v, rows, cols, planes),
        }
    }

    /// (samples − black) / (white − black), float32, of the shape of `samples`; negative where noise exceeds the signal.
    fn normalized<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let raw = &self.raw;
        let values = py.detach(|| raw.normalized()).into_pyarray(py);
        let (rows, cols, planes) = (raw.rows(), raw.cols(), raw.sampling().planes());
        match raw.sampling() {
            Sampling::Mosaic(_) => Ok(values.reshape((rows, cols))?.into_any()),
            Sampling::Full { .. } => {
                values.reshape((planes, rows, cols))?.call_method1("transpose", (1, 2, 0))
            }
        }
    }

    /// The channel of each cell of the tile, uint8 [rows, columns]; None if every pixel has every channel.
    #[getter]
    fn tile<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyAny>>> {
        match slf.get().raw.sampling() {
            Sampling::Mosaic(m) => {
                arrays::slice_view(slf.as_any().clone(), &[m.rows(), m.cols()], m.cells()).map(Some)
            }
            Sampling::Full { .. } => Ok(None),
        }
    }

    /// The shape of `samples`.
    #[getter]
    fn shape<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        Self::samples(slf)?.getattr("shape")
    }

    /// Names of the channels.
    #[getter]
    fn channel_names(&self) -> Vec<String> {
        self.raw.channel_names().to_vec()
    }

    /// The value of a sample without light, in the unit of the samples.
    #[getter]
    fn black_level(&self) -> f64 {
        self.raw.black_level()
    }

    /// The value of a sample at saturation.
    #[getter]
    fn white_level(&self) -> f64 {
        self.raw.white_level()
    }

    /// "digital numbers" or "V".
    #[getter]
    fn unit(&self) -> &'static str {
        match self.raw.samples() {
            RawSamples::Digital(_) => "digital numbers",
            RawSamples::Analog(_) => "V",
        }
    }

    /// Share of samples at or above the white level, percent.
    #[getter]
    fn saturated_percent(&self) -> f64 {
        self.raw.saturated_percent()
    }

    /// The same image with its channels in the order of these names; unchanged if the names differ from its own.
    fn with_channels(&self, names: Vec<String>) -> Self {
        Self { raw: self.raw.clone().with_channels(&names), ..self.clone() }
    }

    fn __repr__(&self) -> String {
        let raw = &self.raw;
        format!(
            "<smalti.RawImage: {} × {} pixels, channels {}, {} from {} (black) to {} (white)>",
            raw.rows(),
            raw.cols(),
            raw.channel_names().join(", "),
            self.unit(),
            raw.black_level(),
            raw.white_level(),
        )
    }
}

/// Samples in the order plane, row, column.
fn planar<T: numpy::Element + Copy>(array: &Bound<'_, PyAny>) -> PyResult<Vec<T>> {
    let array = arrays::array::<T>(array, "samples")?;
    let view = array.as_array();
    let view = if view.ndim() == 2 { view } else { view.permuted_axes(vec![2, 0, 1]) };
    Ok(view.iter().copied().collect())
}
