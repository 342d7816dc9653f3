//! What can be wrong with a camera.

use thiserror::Error;

use crate::color::ImageError;
use crate::isp::IspError;
use crate::metrics::MetricError;
use crate::optics::OpticsError;
use crate::scene::SceneError;
use crate::sensor::{CfaError, RawError, SensorError};
use crate::spectrum::SpectrumError;

/// What can be wrong with a camera or with one of its pictures.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A key of the description has an impossible value.
    #[error("`{key}`: {message}")]
    Key {
        /// Dotted path of the key, such as `sensor.pixel.fill_factor`.
        key: String,
        /// What is wrong, and what was expected.
        message: String,
    },
    /// Optics refused.
    #[error("optics: {0}")]
    Optics(#[from] OpticsError),
    /// The sensor refused.
    #[error("sensor: {0}")]
    Sensor(#[from] SensorError),
    /// The colour filter array is impossible.
    #[error("colour filter array: {0}")]
    Cfa(#[from] CfaError),
    /// A raw image is impossible.
    #[error("raw image: {0}")]
    Raw(#[from] RawError),
    /// The processing refused.
    #[error("processing: {0}")]
    Isp(#[from] IspError),
    /// A scene is impossible.
    #[error("scene: {0}")]
    Scene(#[from] SceneError),
    /// A metric cannot be computed.
    #[error("metric: {0}")]
    Metric(#[from] MetricError),
    /// A picture is impossible.
    #[error("picture: {0}")]
    Image(#[from] ImageError),
    /// Spectral data do not fit.
    #[error("spectrum: {0}")]
    Spectrum(#[from] SpectrumError),
}
