//! A learned pipeline: its file, its kernels, and rendering with it.

use std::path::PathBuf;

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use smalti::color::{ColorSpace, Image};
use smalti::l3::{Origin, Pipeline, Quality, Rendered};
use smalti_io::l3::{self, CArithmetic};

use crate::arrays;
use crate::error::{OrRaise, one_of, wrong};
use crate::image::PyImage;
use crate::json::{dict_of, loads};
use crate::raw::PyRawImage;
use crate::work::watched;

/// A learned pipeline: a table of kernels, one for each class of patches and output. `train` makes one.
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

    /// Writes the pipeline in the format of the extension: .l3 (exact, for `read`), .npz (NumPy arrays) or .h (C99).
    ///
    /// Args:
    ///     arithmetic: numbers of a .h file: "integers" (fixed point) or "float", which renders the same bits as `render`.
    #[pyo3(signature = (path, *, arithmetic="integers"))]
    fn write(&self, py: Python<'_>, path: PathBuf, arithmetic: &str) -> PyResult<()> {
        let numbers = [("integers", CArithmetic::Integers), ("float", CArithmetic::SinglePrecision)];
        let arithmetic = one_of("arithmetic", arithmetic, &numbers)?;
        let extension =
            path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        watched(py, None, |_| match extension.as_str() {
            "l3" => l3::write_table(&path, &self.0).or_raise(),
            "npz" => l3::write_npz(&path, &self.0).or_raise(),
            "h" => l3::write_c_header(&path, &self.0, &l3::c_prefix(&path), arithmetic).or_raise(),
            _ => Err(wrong(format!("{}: expected a name that ends in .l3, .npz or .h", path.display()))),
        })
    }

    /// The pipeline with the stages of a quality: one of "best" also renders with its first stage alone, "fast".
    ///
    /// Raises:
    ///     SmaltiError: when "best" is asked of a pipeline of one stage.
    fn at_quality(&self, quality: &str) -> PyResult<Self> {
        let quality = one_of("quality", quality, &Quality::ALL.map(|q| (q.name(), q)))?;
        Ok(Self(self.0.clone().at_quality(quality).or_raise()?))
    }

    /// "fast" for one stage, "best" for two.
    #[getter]
    fn quality(&self) -> &'static str {
        self.0.quality().name()
    }

    /// Renders a raw image to XYZ under the illuminant of the training. Channels are matched by name.
    ///
    /// Args:
    ///     raw: a raw image with the mosaic of the training.
    ///     fixed_point: compute with 16-bit kernels as an image signal processor does; needs digital numbers.
    ///
    /// Raises:
    ///     SmaltiError: when the image has another mosaic or other levels, or the outputs are not a picture (see `render_outputs`).
    #[pyo3(signature = (raw, *, fixed_point=false))]
    fn render(&self, py: Python<'_>, raw: &PyRawImage, fixed_point: bool) -> PyResult<PyImage> {
        if self.0.outputs() != ["X", "Y", "Z"] {
            let outputs = self.0.outputs().join(", ");
            return Err(wrong(format!(
                "the outputs of the pipeline are {outputs}, not a picture; use render_outputs"
            )));
        }
        let rendered = self.rendered(py, raw, fixed_point)?;
        Ok(PyImage::new(Image::new(ColorSpace::Xyz, rendered.planes).or_raise()?, self.0.white()))
    }

    /// The outputs for a raw image, float32 [rows, columns, outputs], and the numbers of pixels that are "darker" or "brighter" than the
    /// training data, or clipped unlike them ("saturation"). These pixels are rendered with the nearest class.
    #[pyo3(signature = (raw, *, fixed_point=false))]
    fn render_outputs<'py>(
        &self,
        py: Python<'py>,
        raw: &PyRawImage,
        fixed_point: bool,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyDict>)> {
        let Rendered { planes, outside } = self.rendered(py, raw, fixed_point)?;
        let unlike =
            [("darker", outside.darker), ("brighter", outside.brighter), ("saturation", outside.saturation)];
        let (rows, cols, count) = (planes.rows(), planes.cols(), planes.count());
        let flat = planes.into_data().into_pyarray(py);
        let array = flat.call_method1("reshape", ((count, rows, cols),))?;
        Ok((array.call_method1("transpose", (1, 2, 0))?, unlike.into_py_dict(py)?))
    }

    /// Names of the outputs, X, Y, Z for pictures.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.0.outputs().to_vec()
    }

    /// Names of the channels of the mosaic.
    #[getter]
    fn channel_names(&self) -> Vec<String> {
        self.0.channel_names().to_vec()
    }

    /// X, Y, Z of the illuminant of the training, Y = 1; None where the outputs are not a picture.
    #[getter]
    fn white(&self) -> Option<[f64; 3]> {
        self.0.white()
    }

    /// The kernels, float32 [positions, saturations, levels, textures, outputs, side, side]: a view, not writeable.
    #[getter]
    fn weights<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (p, side) = (&slf.get().0, slf.get().0.axes().side());
        let shape = [&slf.get().shape()[..], &[side, side]].concat();
        arrays::slice_view(slf.as_any().clone(), &shape, &p.kernels().weights)
    }

    /// The offsets, float32 [positions, saturations, levels, textures, outputs]: a view, not writeable.
    #[getter]
    fn offsets<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        arrays::slice_view(slf.as_any().clone(), &slf.get().shape(), &slf.get().0.kernels().offsets)
    }

    /// Names of the texture classes.
    #[getter]
    fn textures(&self) -> Vec<&'static str> {
        self.0.axes().textures().names().to_vec()
    }

    /// The training: version, camera, settings, scenes.
    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        loads(py, self.0.provenance())
    }

    /// A record for each class, ready for a data frame: position, clipped channels, level, texture, patches, origin of its kernel.
    fn classes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dict_of(py, &self.0.class_records())
    }

    fn __repr__(&self) -> String {
        let (s, axes) = (self.0.summary(), self.0.axes());
        let learned: usize = s.positions.iter().map(|p| p.by_origin[Origin::Learned as usize]).sum();
        format!(
            "<smalti.Pipeline of quality {}: {} × {} mosaic, patches of {side} × {side}, {} classes ({learned} learned from {} patches) to {}>",
            self.0.quality().name(),
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
    /// Numbers of positions, saturations, levels, textures and outputs.
    fn shape(&self) -> [usize; 5] {
        let (p, axes) = (&self.0, self.0.axes());
        let saturations = p.saturations().len();
        [axes.positions(), saturations, axes.level_count(), axes.textures().count(), p.outputs().len()]
    }

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
