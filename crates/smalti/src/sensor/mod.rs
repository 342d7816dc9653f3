//! The image sensor: colour filter array, pixel, exposure, noise, analog-to-digital conversion.
//!
//! [`Sensor::capture`] turns an optical image into a [`RawImage`]. [`Cfa`] and [`RawImage`] are independent
//! of the simulation: the raw file of a real camera has the same type.

mod adc;
mod auto_exposure;
mod binned;
mod binning;
mod capture;
pub mod cfa;
#[cfg(test)]
mod clear_sensor;
mod collect;
mod conversion_gain;
mod device;
mod drawn_blocks;
mod electron_rates;
mod error;
mod exposure;
mod geometry;
mod noise_mode;
mod noise_model;
mod nonuniformity;
mod pattern;
mod pixel;
mod pixel_spectra;
mod quantum_efficiency;
mod raw;
mod raw_levels;
mod read_bands;
mod readout;
mod samples;
mod temporal_noise;

pub use adc::Adc;
pub use auto_exposure::AutoExposure;
pub use binning::{Binning, BinningMode};
pub use capture::Light;
pub use cfa::{Cfa, CfaError, Channel, Filter, Mosaic};
pub use conversion_gain::{ConversionGain, LowGain};
pub use device::{Aperture, ColorArchitecture, MAX_SAMPLES, Sensor};
pub use electron_rates::ElectronRates;
pub(crate) use electron_rates::FixedPattern;
pub use error::SensorError;
pub use exposure::Exposure;
pub use noise_mode::NoiseMode;
pub use noise_model::{NoiseAbove, NoiseVariance, SignalNoise};
pub use nonuniformity::NonUniformity;
pub use pixel::{DarkCurrentTemperature, Pixel};
pub use pixel_spectra::PixelSpectra;
pub use quantum_efficiency::{QuantumEfficiency, silicon_absorption_per_m};
pub use raw::{RawError, RawImage, RawSamples, Sampling};
pub use raw_levels::RawLevels;
pub(crate) use temporal_noise::TemporalNoise;

/// A rectangle of pixels of the sensor.
pub use crate::numeric::Rect as Window;
