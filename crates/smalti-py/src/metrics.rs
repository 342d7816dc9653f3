//! Metrics on arrays and images.

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use smalti::metrics::aliasing::aliasing as measure_aliasing;
use smalti::metrics::esfr::{
    EdgeSfr, EsfrOptions, Mtf50Reliability, NYQUIST_CY_PER_PX, edge_sfr as measure_edge, raw_channel_sfr,
};
use smalti::metrics::luminance_noise::luminance_noise as measure_noise;
use smalti::metrics::psnr::psnr as measure_psnr;
use smalti::metrics::visual_snr::visual_snr as measure_visual_snr;
use smalti::metrics::{Better, CATALOG, MetricInfo, Rect};
use smalti::numeric::Planes;

use crate::arrays;
use crate::error::{OrRaise, wrong};
use crate::image::PyImage;
use crate::raw::PyRawImage;
use crate::work::watched;

/// A rectangle of pixels: row, column, rows, columns.
type Region = (usize, usize, usize, usize);

fn rect((row, col, rows, cols): Region) -> Rect {
    Rect { row, col, rows, cols }
}

fn region_of(region: Option<Region>, planes: &Planes) -> Rect {
    region.map_or_else(|| Rect::whole(planes.rows(), planes.cols()), rect)
}

/// The response to a slanted edge (e-SFR, ISO 12233).
#[pyclass(name = "EdgeResponse", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyEdge(EdgeSfr);

#[pymethods]
impl PyEdge {
    /// Frequencies from 0 to at least 1 cycle per pixel, float64 [frequencies]: a view.
    #[getter]
    fn frequency_cy_per_px<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let values = &slf.get().0.frequency_cy_per_px;
        arrays::slice_view(slf.as_any().clone(), &[values.len()], values)
    }

    /// Response at these frequencies, 1 at frequency 0, float64 [frequencies]: a view.
    #[getter]
    fn sfr<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let values = &slf.get().0.sfr;
        arrays::slice_view(slf.as_any().clone(), &[values.len()], values)
    }

    /// The first frequency at which the response is one half, cycles per pixel; None if the response stays above.
    #[getter]
    fn mtf50_cy_per_px(&self) -> Option<f64> {
        self.0.mtf50_cy_per_px
    }

    /// Whether MTF50 can be trusted as a resolution: "reliable", "beyond-nyquist" (of the pixel grid) or "plateau"; None without MTF50.
    #[getter]
    fn mtf50_reliability(&self) -> Option<&'static str> {
        self.0.mtf50_reliability(NYQUIST_CY_PER_PX).map(Mtf50Reliability::name)
    }

    /// MTF50 in cycles per mm on a sensor with this pixel pitch in m.
    fn mtf50_cy_per_mm(&self, pitch_m: f64) -> Option<f64> {
        self.0.mtf50_cy_per_mm(pitch_m)
    }

    /// The first frequency at which the response falls to `level`, cycles per pixel; None if the response stays above.
    fn frequency_at(&self, level: f64) -> Option<f64> {
        self.0.frequency_at(level)
    }

    /// Area under the response from half a cycle per pixel upwards, percent of the whole.
    #[getter]
    fn aliasing_percent(&self) -> f64 {
        self.0.aliasing_percent
    }

    /// Angle of the edge to the columns or rows, degrees, −45 to 45.
    #[getter]
    fn edge_angle_deg(&self) -> f64 {
        self.0.edge_angle_deg
    }

    /// Michelson contrast of the plateaus, 0 to 1.
    #[getter]
    fn contrast(&self) -> f64 {
        self.0.contrast
    }

    /// The profile of the edge in steps of a quarter pixel, float64: a view.
    #[getter]
    fn esf<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let values = &slf.get().0.esf;
        arrays::slice_view(slf.as_any().clone(), &[values.len()], values)
    }

    fn __repr__(&self) -> String {
        let mtf50 = self.0.mtf50_cy_per_px.map_or_else(|| "none".into(), |f| format!("{f:.4} cy/px"));
        format!("<smalti.EdgeResponse: MTF50 {mtf50}, edge at {:.2}°>", self.0.edge_angle_deg)
    }
}

/// Measures the response to a slanted edge.
///
/// Args:
///     image: linear values: an array [rows, columns] or [rows, columns, planes], an `Image` (in XYZ: its Y), or a `RawImage` (the
///         samples of one channel).
///     plane: the plane, or the channel of a `RawImage`; default 0, or 1 for an `Image`.
///     region: row, column, rows, columns; default the whole image.
///     isetcam: use the method of ISETCam's ISO12233 of 2021, for comparison with published values.
#[pyfunction]
#[pyo3(signature = (image, *, plane=None, region=None, isetcam=false))]
pub(crate) fn edge_sfr(
    py: Python<'_>,
    image: &Bound<'_, PyAny>,
    plane: Option<usize>,
    region: Option<Region>,
    isetcam: bool,
) -> PyResult<PyEdge> {
    let options = if isetcam { EsfrOptions::isetcam() } else { EsfrOptions::default() };
    if let Ok(raw) = image.cast::<PyRawImage>() {
        let raw = &raw.get().raw;
        let region = region.map_or_else(|| Rect::whole(raw.rows(), raw.cols()), rect);
        return watched(py, None, |_| {
            Ok(PyEdge(raw_channel_sfr(raw, plane.unwrap_or(0), region, &options).or_raise()?))
        });
    }
    let default = usize::from(image.is_instance_of::<PyImage>());
    let planes = planes(image, "image")?;
    let region = region_of(region, &planes);
    watched(py, None, |_| {
        Ok(PyEdge(measure_edge(&planes, plane.unwrap_or(default), region, &options).or_raise()?))
    })
}

/// 100 · std / mean (divisor n − 1) of each uniform patch, percent.
///
/// Args:
///     luminance: linear values [rows, columns], or an `Image` in XYZ (its Y).
///     patches: row, column, rows, columns of each patch.
#[pyfunction]
pub(crate) fn luminance_noise_percent<'py>(
    py: Python<'py>,
    luminance: &Bound<'py, PyAny>,
    patches: Vec<Region>,
) -> PyResult<Bound<'py, PyAny>> {
    let plane = usize::from(luminance.is_instance_of::<PyImage>());
    let planes = planes(luminance, "luminance")?;
    let patches: Vec<Rect> = patches.into_iter().map(rect).collect();
    let noise = py.detach(|| measure_noise(&planes, plane, &patches)).or_raise()?;
    Ok(noise.percent.into_pyarray(py).into_any())
}

/// Peak signal-to-noise ratio over all planes, dB.
///
/// Args:
///     image: [rows, columns] or [rows, columns, planes], or an `Image`.
///     reference: the same shape.
///     peak: the largest possible value.
///     region: row, column, rows, columns; default the whole image.
#[pyfunction]
#[pyo3(signature = (image, reference, *, peak=1.0, region=None))]
pub(crate) fn cpsnr_db(
    py: Python<'_>,
    image: &Bound<'_, PyAny>,
    reference: &Bound<'_, PyAny>,
    peak: f64,
    region: Option<Region>,
) -> PyResult<f64> {
    let (image, reference) = (planes(image, "image")?, planes(reference, "reference")?);
    let region = region_of(region, &image);
    py.detach(|| measure_psnr(&image, &reference, region, peak)).or_raise().map(|p| p.cpsnr_db)
}

/// The share of the energy of a picture that its reference, the same scene without a mosaic, does not contain. Both are linear and without
/// noise.
///
/// Args:
///     picture: [rows, columns, planes], at least 16 × 16 pixels, or an `Image`.
///     reference: the same shape.
///     luminance_weights: Y of the primary of each plane; default linear sRGB.
///
/// Returns:
///     luminance_percent, color_percent, total_percent: percent of the energy of the picture, 0 to 100.
#[pyfunction]
#[pyo3(signature = (picture, reference, luminance_weights=vec![0.2126, 0.7152, 0.0722]))]
pub(crate) fn aliasing<'py>(
    py: Python<'py>,
    picture: &Bound<'py, PyAny>,
    reference: &Bound<'py, PyAny>,
    luminance_weights: Vec<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let (picture, reference) = (planes(picture, "picture")?, planes(reference, "reference")?);
    let found = watched(py, None, |_| measure_aliasing(&picture, &reference, &luminance_weights).or_raise())?;
    let dict = PyDict::new(py);
    dict.set_item("luminance_percent", found.luminance_percent)?;
    dict.set_item("color_percent", found.color_percent)?;
    dict.set_item("total_percent", found.total_percent)?;
    Ok(dict)
}

/// Reciprocal of the visible noise of a uniform region, in units of ΔE 1976 (Farrell et al. 2010).
///
/// Args:
///     picture: in XYZ.
///     region: row, column, rows, columns.
///     white: X, Y, Z of white on the scale of the picture.
///     samples_per_degree: viewing condition, pixels per degree of visual angle, 1 to 2000.
#[pyfunction]
#[pyo3(signature = (picture, region, white, samples_per_degree=60.0))]
pub(crate) fn visual_snr(
    py: Python<'_>,
    picture: &PyImage,
    region: Region,
    white: [f64; 3],
    samples_per_degree: f64,
) -> PyResult<f64> {
    watched(py, None, |_| {
        measure_visual_snr(&picture.image, rect(region), white, samples_per_degree).or_raise()
    })
}

/// All metrics: name, unit, better direction ("lower", "higher" or None), meaning, source.
#[pyfunction]
pub(crate) fn metrics(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let record = |m: &MetricInfo| {
        let better = match m.better {
            Better::Lower => Some("lower"),
            Better::Higher => Some("higher"),
            Better::Neither => None,
        };
        let [name, unit, doc, source] = [m.name, m.unit, m.doc, m.source].map(Some);
        [("name", name), ("unit", unit), ("better", better), ("doc", doc), ("source", source)]
            .into_py_dict(py)
    };
    CATALOG.iter().map(record).collect()
}

fn planes(value: &Bound<'_, PyAny>, what: &str) -> PyResult<Planes> {
    if let Ok(image) = value.cast::<PyImage>() {
        return Ok(image.get().image.planes().clone());
    }
    let planes = arrays::planes(value, what, "planes")?;
    match planes.data().iter().all(|v| v.is_finite()) {
        true => Ok(planes),
        false => Err(wrong(format!("{what}: expected finite numbers"))),
    }
}
