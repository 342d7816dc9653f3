//! What can be wrong with a camera.

use thiserror::Error;

use crate::color::ImageError;
use crate::color::jakob_hanika2019::UpliftError;
use crate::isp::IspError;
use crate::l3::L3Error;
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
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// The sensor refused.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// The colour filter array is impossible.
    #[error(transparent)]
    Cfa(#[from] CfaError),
    /// A raw image is impossible.
    #[error(transparent)]
    Raw(#[from] RawError),
    /// The processing refused.
    #[error(transparent)]
    Isp(#[from] IspError),
    /// A learned pipeline refused.
    #[error(transparent)]
    L3(#[from] L3Error),
    /// A reflectance cannot be lifted from RGB.
    #[error(transparent)]
    Uplift(#[from] UpliftError),
    /// A scene is impossible.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A metric cannot be computed.
    #[error(transparent)]
    Metric(#[from] MetricError),
    /// A picture is impossible.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// Spectral data do not fit.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}
