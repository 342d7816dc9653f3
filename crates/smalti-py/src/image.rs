//! Pictures.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use smalti::color::{ColorSpace, Image};
use smalti_io::picture::{self, Depth};
use smalti_io::scene_file::ReadOptions;

use crate::arrays;
use crate::error::{OrRaise, wrong};
use crate::work::{detached, watched};

const SPACES: [(&str, ColorSpace); 5] = [
    ("xyz", ColorSpace::Xyz),
    ("linear-srgb", ColorSpace::LinearSrgb),
    ("srgb", ColorSpace::Srgb),
    ("linear-display-p3", ColorSpace::LinearDisplayP3),
    ("display-p3", ColorSpace::DisplayP3),
];

/// A picture of three planes in a stated colour space.
///
/// Args:
///     array: [rows, columns, 3]; uint8 and uint16 are divided by 255 and 65535.
///     space: "xyz" (CIE 1931, relative), "linear-srgb", "srgb", "linear-display-p3" or "display-p3"; encoded values are 0 to 1.
///     white: X, Y, Z of the illuminant of a picture in XYZ, which `shown` adapts to the white of the display.
#[pyclass(name = "Image", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyImage {
    pub(crate) image: Image,
    /// X, Y, Z of the illuminant, Y = 1; None if it is unknown.
    #[pyo3(get)]
    pub(crate) white: Option<[f64; 3]>,
}

#[pymethods]
impl PyImage {
    #[new]
    #[pyo3(signature = (array, space="srgb", white=None))]
    fn py_new(array: &Bound<'_, PyAny>, space: &str, white: Option<[f64; 3]>) -> PyResult<Self> {
        let largest = match array.getattr("dtype").and_then(|d| d.str()).map(|d| d.to_string()).as_deref() {
            Ok("uint8") => 255.0,
            Ok("uint16") => 65535.0,
            _ => 1.0f32,
        };
        let mut planes = arrays::planes(array, "array", "3")?;
        if largest > 1.0 {
            planes.data_mut().iter_mut().for_each(|v| *v /= largest);
        }
        let white = match white {
            Some(w) if w.iter().all(|v| v.is_finite() && *v > 0.0) => Some(w.map(|v| v / w[1])),
            Some(w) => return Err(wrong(format!("white is {w:?}; expected three numbers above 0"))),
            None => None,
        };
        let image = Image::new(space_of(space)?, planes).or_raise()?;
        image.check_finite().or_raise()?;
        Ok(Self { image, white })
    }

    /// A picture from a file: PNG, TIFF, JPEG or OpenEXR RGB.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let picture = watched(py, None, |_| picture::read(&path, &ReadOptions::default()).or_raise())?;
        Ok(Self::new(picture.image, None))
    }

    /// Writes a PNG or TIFF, by the extension. Pictures in sRGB or Display P3 are written unchanged, others as `shown`.
    ///
    /// Args:
    ///     path: a name that ends in .png, .tif or .tiff.
    ///     bits: 8 or 16 for each sample.
    #[pyo3(signature = (path, bits=8))]
    fn write(&self, py: Python<'_>, path: PathBuf, bits: u8) -> PyResult<()> {
        let depth = match bits {
            8 => Depth::Eight,
            16 => Depth::Sixteen,
            other => return Err(wrong(format!("bits is {other}; expected 8 or 16"))),
        };
        watched(py, None, |_| picture::write(&path, &self.encoded()?, depth).or_raise())
    }

    /// The values, float32 [rows, columns, 3]: a view, not writeable.
    #[getter]
    fn array<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        arrays::planes_view(slf.as_any().clone(), slf.get().image.planes())
    }

    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        slf: &Bound<'py, Self>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let array = Self::array(slf)?;
        match (dtype, copy) {
            (None, Some(true)) => array.call_method0("copy"),
            (None, _) => Ok(array),
            (Some(dtype), _) => array.call_method1("astype", (dtype,)),
        }
    }

    /// The name of the colour space.
    #[getter]
    fn space(&self) -> &'static str {
        SPACES.iter().find(|(_, s)| *s == self.image.space()).map_or("", |(name, _)| name)
    }

    /// Rows, columns, 3.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        (self.image.rows(), self.image.cols(), 3)
    }

    /// The picture in another colour space, without chromatic adaptation.
    fn converted(&self, py: Python<'_>, space: &str) -> PyResult<Self> {
        let space = space_of(space)?;
        let image = py.detach(|| self.image.converted(space)).or_raise()?;
        Ok(Self { image, white: self.white })
    }

    /// The gain for display of a picture in XYZ: all but the brightest half percent of the pixels are within the range of the display.
    fn brightness_gain(&self) -> PyResult<f64> {
        let xyz = self.image.converted(ColorSpace::Xyz).or_raise()?;
        Ok(xyz.brightness_gain())
    }

    /// The picture in sRGB for display. If its illuminant is known, it is adapted to the white of the display (Bradford).
    ///
    /// Args:
    ///     gain: factor of the luminance; default `brightness_gain()`.
    #[pyo3(signature = (gain=None))]
    fn shown(&self, py: Python<'_>, gain: Option<f64>) -> PyResult<Self> {
        Ok(Self::new(detached(py, || self.as_shown(gain))?, None))
    }

    /// As `shown`, uint8 [rows, columns, 3], for `matplotlib.pyplot.imshow`.
    fn to_uint8<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let bytes = self.bytes()?;
        let (rows, cols) = (self.image.rows(), self.image.cols());
        Ok(bytes.into_pyarray(py).reshape((rows, cols, 3))?.into_any())
    }

    fn __repr__(&self) -> String {
        format!("<smalti.Image: {} × {} pixels, {}>", self.image.rows(), self.image.cols(), self.space())
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.png_as_shown(py)
    }
}

impl PyImage {
    pub(crate) fn new(image: Image, white: Option<[f64; 3]>) -> Self {
        Self { image, white }
    }

    /// PNG as `shown`.
    pub(crate) fn png_as_shown<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut out = Vec::new();
        let wrong = |e: png::EncodingError| wrong(e.to_string());
        let (rows, cols) = (self.image.rows() as u32, self.image.cols() as u32);
        let mut encoder = png::Encoder::new(&mut out, cols, rows);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let bytes = self.bytes()?;
        encoder.write_header().and_then(|mut w| w.write_image_data(&bytes)).map_err(wrong)?;
        Ok(PyBytes::new(py, &out).into_any())
    }

    /// In sRGB, with white adapted and luminance scaled by `gain`.
    fn as_shown(&self, gain: Option<f64>) -> PyResult<Image> {
        let gain = gain.map_or_else(|| self.brightness_gain(), Ok)?;
        let xyz = self.image.converted(ColorSpace::Xyz).or_raise()?;
        xyz.shown(self.white, gain).or_raise()
    }

    /// Encoded pictures unchanged, others as `shown`.
    fn encoded(&self) -> PyResult<Image> {
        match self.image.space() {
            ColorSpace::Srgb | ColorSpace::DisplayP3 => Ok(self.image.clone()),
            _ => self.as_shown(None),
        }
    }

    /// In sRGB, three bytes per pixel, row by row.
    fn bytes(&self) -> PyResult<Vec<u8>> {
        Ok(self.encoded()?.converted(ColorSpace::Srgb).or_raise()?.rgb8())
    }
}

/// A colour space by name.
pub(crate) fn space_of(name: &str) -> PyResult<ColorSpace> {
    let found = SPACES.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, s)| *s);
    let known = || SPACES.map(|(n, _)| n).join(", ");
    found.ok_or_else(|| wrong(format!("space is '{name}'; expected one of {}", known())))
}
