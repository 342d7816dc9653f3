//! The image sensor: colour filter array, pixel, exposure, noise, analog-to-digital conversion.
//!
//! [`Sensor::capture`] turns an optical image into a [`RawImage`]. [`Cfa`] and [`RawImage`] know nothing of the
//! simulator: the raw file of a real camera is the same type.

mod adc;
mod capture;
pub mod cfa;
mod collect;
mod device;
mod error;
mod exposure;
mod geometry;
mod noise_model;
mod nonuniformity;
mod pixel;
mod pixel_spectra;
mod quantum_efficiency;
mod raw;
mod raw_levels;
mod readout;

pub use adc::Adc;
pub use capture::{Light, NoiseMode};
pub use cfa::{Cfa, CfaError, Channel, Filter, Mosaic};
pub use device::{Aperture, ColorArchitecture, MAX_SAMPLES, Sensor};
pub use error::SensorError;
pub use exposure::{AutoExposure, Exposure};
pub use noise_model::{NoiseVariance, SignalNoise};
pub use nonuniformity::NonUniformity;
pub use pixel::{DarkCurrentTemperature, Pixel};
pub use pixel_spectra::PixelSpectra;
pub use quantum_efficiency::{QuantumEfficiency, silicon_absorption_per_m};
pub use raw::{RawError, RawImage, RawSamples, Sampling};
pub use raw_levels::RawLevels;

/// A part of the sensor is a rectangle of pixels.
pub use crate::numeric::Rect as Window;
