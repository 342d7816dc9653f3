//! A capture of a camera.

use pyo3::prelude::*;
use smalti::camera::Camera;
use smalti::experiment::{SimulationSettings, score_capture};
use smalti::l3::Pipeline;
use smalti::sensor::Exposure;
use smalti::spectrum::Spectrum;

use crate::error::{OrRaise, short};
use crate::image::PyImage;
use crate::json::dict_of;
use crate::raw::PyRawImage;
use crate::scene::PyOpticalImage;
use crate::work::watched;

/// A picture with the optical image and the raw image that it was made from.
#[pyclass(name = "Photograph", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyPhotograph {
    /// Irradiance on the sensor.
    #[pyo3(get)]
    pub(crate) optical_image: PyOpticalImage,
    /// The raw image.
    #[pyo3(get)]
    pub(crate) raw: PyRawImage,
    /// The picture in XYZ, with the white balance of the camera's description.
    #[pyo3(get)]
    pub(crate) picture: PyImage,
    pub(crate) exposure: Exposure,
    pub(crate) light: Spectrum,
    pub(crate) white: [f64; 3],
    pub(crate) settings: SimulationSettings,
    /// With the window that was read out.
    pub(crate) camera: Camera,
    /// What rendered the picture, if it was learned.
    pub(crate) pipeline: Option<Pipeline>,
}

#[pymethods]
impl PyPhotograph {
    /// Integration time, s.
    #[getter]
    fn exposure_time_s(&self) -> f64 {
        self.exposure.time_s
    }

    /// The noise-free picture of the standard observer through the same lens and pixels, in XYZ under the illuminant of the scene, on the
    /// scale of `Camera.render`.
    fn reference(&self, py: Python<'_>) -> PyResult<PyImage> {
        let reference = watched(py, None, |_| {
            self.camera.reference_as_exposed(&self.optical_image.0, &self.exposure, &self.light).or_raise()
        })?;
        Ok(PyImage::new(reference, Some(self.white)))
    }

    /// The difference between the centre of the picture, without white balance, and `reference`, as `smalti simulate` scores it: cpsnr_db, pixel_delta_e_2000_mean, pixel_delta_e_2000_p95, scielab_mean and others; None without light.
    fn scores<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let (image, exposure) = (&self.optical_image.0, &self.exposure);
        let processed = (&self.camera, self.pipeline.as_ref());
        let scored = watched(py, None, |_| {
            score_capture(processed, &self.light, image, exposure, &self.settings).or_raise()
        })?;
        scored.map(|s| dict_of(py, &s.scores)).transpose()
    }

    fn __repr__(&self) -> String {
        let (rows, cols) = (self.picture.image.rows(), self.picture.image.cols());
        format!(
            "<smalti.Photograph: {rows} × {cols} pixels, exposed {} ms>",
            short(self.exposure.time_s * 1e3)
        )
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.picture.png_as_shown(py)
    }
}
