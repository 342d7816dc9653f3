//! A picture as a camera took it.

use pyo3::prelude::*;
use smalti::camera::Camera;
use smalti::sensor::Exposure;
use smalti::spectrum::Spectrum;

use crate::error::{OrRaise, short};
use crate::image::PyImage;
use crate::raw::PyRawImage;
use crate::scene::PyOpticalImage;
use crate::work::watched;

/// A picture with all that led to it.
#[pyclass(name = "Photograph", module = "smalti", frozen)]
#[derive(Debug, Clone)]
pub(crate) struct PyPhotograph {
    pub(crate) optical_image: PyOpticalImage,
    pub(crate) raw: PyRawImage,
    pub(crate) picture: PyImage,
    pub(crate) exposure: Exposure,
    pub(crate) light: Spectrum,
    pub(crate) white: [f64; 3],
    /// With the window that was read.
    pub(crate) camera: Camera,
}

#[pymethods]
impl PyPhotograph {
    /// Irradiance on the sensor.
    #[getter]
    fn optical_image(&self) -> PyOpticalImage {
        self.optical_image.clone()
    }

    /// The raw image.
    #[getter]
    fn raw(&self) -> PyRawImage {
        self.raw.clone()
    }

    /// The picture in XYZ, white-balanced as the camera's description says.
    #[getter]
    fn picture(&self) -> PyImage {
        self.picture.clone()
    }

    /// Integration time, s.
    #[getter]
    fn exposure_time_s(&self) -> f64 {
        self.exposure.time_s
    }

    /// What the standard observer would see through the same lens and pixels, without noise: in XYZ as they are under the light of the
    /// scene, on the scale of `Camera.render`.
    fn reference(&self, py: Python<'_>) -> PyResult<PyImage> {
        let reference = watched(py, None, |_| {
            self.camera.reference_as_exposed(&self.optical_image.0, &self.exposure, &self.light).or_raise()
        })?;
        Ok(PyImage::new(reference, Some(self.white)))
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
