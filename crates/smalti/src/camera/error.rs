//! Errors of cameras and their pictures.

use thiserror::Error;

use super::exposure_fault::{ExposureFault, Told};
use crate::color::ImageError;
use crate::color::jakob_hanika2019::UpliftError;
use crate::isp::IspError;
use crate::l3::L3Error;
use crate::metrics::MetricError;
use crate::numeric::ShapeError;
use crate::optics::OpticsError;
use crate::scene::SceneError;
use crate::sensor::{CfaError, RawError, SensorError};
use crate::spectrum::SpectrumError;

/// An error of a camera or of one of its pictures.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A key of the description has an invalid value.
    #[error("`{key}`: {message}")]
    Key {
        /// Dotted path of the key, such as `sensor.pixel.fill_factor`.
        key: String,
        /// What is wrong, and what was expected.
        message: String,
    },
    /// A value cannot be written as text.
    #[error("the settings cannot be written as text: {message}")]
    Text {
        /// Why.
        message: String,
    },
    /// A scene of a comparison cannot be loaded, for this reason.
    #[error("{0}")]
    DeferredScene(String),
    /// A training scene from a file cannot be loaded.
    #[error("training scene {name}: {reason}")]
    StoredScene {
        /// Its name.
        name: String,
        /// Why.
        reason: String,
    },
    /// A design cannot be learned from statistics of light, because the training scene saturates a channel.
    #[error(
        "`l3.statistics`: the training scene saturates the channel {channel}, which \"light\" does not describe; expose less, or use \"patches\""
    )]
    TrainingSaturates {
        /// Its name.
        channel: String,
    },
    /// A channel gets no light, and fewer than three others see it.
    #[error(
        "the channel {channel} gets no light: its response to white is {percent:.2} % of that of the brightest channel, and fewer than three channels \
         remain to measure colour; choose a broader illuminant, with power at the wavelengths of the channel, or another filter (sensor.cfa.filters.{channel})"
    )]
    DarkChannel {
        /// The name of the channel.
        channel: String,
        /// Its response to white, percent of that of the brightest channel.
        percent: f64,
    },
    /// Colour differences are not defined under a light of one colour.
    #[error(
        "the light covers too little of the visible range: {primary} of its white is {percent:.2} % of the largest of X, Y and Z, so that colours \
         cannot be compared under it; choose a broader illuminant"
    )]
    NarrowLight {
        /// X, Y or Z.
        primary: &'static str,
        /// Its value, percent of the largest.
        percent: f64,
    },
    /// An error of the optics.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// An error of the sensor.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// The colour filter array is invalid.
    #[error(transparent)]
    Cfa(#[from] CfaError),
    /// A raw image is invalid.
    #[error(transparent)]
    Raw(#[from] RawError),
    /// An error of the processing.
    #[error(transparent)]
    Isp(#[from] IspError),
    /// An error of a learned pipeline or its training.
    #[error(transparent)]
    L3(#[from] L3Error),
    /// A reflectance cannot be computed from RGB.
    #[error(transparent)]
    Uplift(#[from] UpliftError),
    /// A target of an evaluation cannot be measured with its exposure.
    #[error("{}", Told(target, *time_s, fault))]
    Exposure {
        /// The target.
        target: &'static str,
        /// Its exposure time, s.
        time_s: f64,
        /// What is wrong with the exposure.
        fault: ExposureFault,
        /// The error of the metric.
        metric: Box<MetricError>,
    },
    /// A scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A metric cannot be computed.
    #[error(transparent)]
    Metric(#[from] MetricError),
    /// A picture is invalid.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The number of values does not match the shape of an image, or a plane does not exist.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Spectral data are invalid.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}
