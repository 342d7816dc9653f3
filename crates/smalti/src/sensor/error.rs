//! Errors of sensors, exposures and captures.

use thiserror::Error;

use super::{CfaError, RawError};
use crate::numeric::{Rect, ShapeError};
use crate::spectrum::SpectrumError;

/// Errors of a sensor, an exposure, or the light on a sensor.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SensorError {
    /// The spectra belong to other pixels than the window.
    #[error(
        "{} × {} pixels from ({}, {}) are read, but light is known for {} × {} from ({}, {}); expected rows among them, \
         the same columns, and a sensor of the same size and crosstalk",
        window.rows, window.cols, window.row, window.col, gathered.rows, gathered.cols, gathered.row, gathered.col
    )]
    OtherPixels {
        /// The window.
        window: Rect,
        /// The pixels of the spectra.
        gathered: Rect,
    },
    /// The sensor has no pixels.
    #[error("a sensor has at least one row and one column, got {rows} × {cols}")]
    Empty {
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
    },
    /// The capture would not fit in memory.
    #[error("{rows} × {cols} pixels in {planes} planes exceed the limit of {limit} samples per capture")]
    TooLarge {
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
        /// Planes of samples.
        planes: usize,
        /// [`MAX_SAMPLES`](super::MAX_SAMPLES).
        limit: usize,
    },
    /// The window extends beyond the sensor.
    #[error(
        "the window of {window_rows} × {window_cols} pixels at ({row}, {col}) must be non-empty and lie within the sensor of {rows} × {cols}"
    )]
    Window {
        /// First row of the window.
        row: usize,
        /// First column of the window.
        col: usize,
        /// Rows of the window.
        window_rows: usize,
        /// Columns of the window.
        window_cols: usize,
        /// Rows of the sensor.
        rows: usize,
        /// Columns of the sensor.
        cols: usize,
    },
    /// The pixel pitch is out of range.
    #[error("pitch_m is {value}; expected 1e-9 to 1e-2 m")]
    Pitch {
        /// The value.
        value: f64,
    },
    /// The fill factor is out of range.
    #[error("fill_factor is {value}; expected more than 0 and at most 1")]
    FillFactor {
        /// The value.
        value: f64,
    },
    /// The conversion gain is out of its range.
    #[error("conversion_gain_v_per_e is {value}; expected 1e-12 to 1 V")]
    ConversionGain {
        /// The value.
        value: f64,
    },
    /// The voltage swing is out of range.
    #[error("voltage_swing_v is {value}; expected 1e-6 to 1e3 V")]
    VoltageSwing {
        /// The value.
        value: f64,
    },
    /// The full-well capacity is out of range.
    #[error("full_well_e is {value}; expected 1 to 1e12 electrons")]
    FullWell {
        /// The value.
        value: f64,
    },
    /// The dark voltage is negative or not a number.
    #[error("dark_voltage_v_per_s is {value}; expected 0 to 1e3 V/s")]
    DarkVoltage {
        /// The value.
        value: f64,
    },
    /// The read noise is negative or not a number.
    #[error("read_noise_v is {value}; expected 0 to 1e3 V")]
    ReadNoise {
        /// The value.
        value: f64,
    },
    /// A parameter of the temperature dependence is out of its range.
    #[error("{field} is {value}; expected {expected}")]
    Temperature {
        /// Its name.
        field: &'static str,
        /// The value.
        value: f64,
        /// The range.
        expected: &'static str,
    },
    /// A non-uniformity is out of its range.
    #[error("{field} is {value}; expected {expected}")]
    NonUniformity {
        /// Its name.
        field: &'static str,
        /// The value.
        value: f64,
        /// The range.
        expected: &'static str,
    },
    /// The converter has too many bits.
    #[error("adc bits is {bits}; expected 0 (no converter) to 16")]
    AdcBits {
        /// The bits.
        bits: u32,
    },
    /// The black level leaves no range for the signal.
    #[error(
        "black_level_dn is {value}; expected 0 or more, and below {limit} (nine tenths of the range; 0 without a converter)"
    )]
    BlackLevel {
        /// The value.
        value: f64,
        /// The upper bound.
        limit: f64,
    },
    /// The crosstalk kernel does not conserve light.
    #[error("the crosstalk kernel needs entries of 0 or more that sum to 1; they sum to {sum}")]
    Crosstalk {
        /// The sum of its entries.
        sum: f64,
    },
    /// A quantum efficiency or transmittance is not within 0–1.
    #[error("{what} at {wavelength_nm} nm is {value}; expected 0 to 1")]
    Fraction {
        /// Quantum efficiency or IR-cut filter.
        what: &'static str,
        /// The wavelength.
        wavelength_nm: f64,
        /// The value.
        value: f64,
    },
    /// A spectral curve of the sensor does not cover the wavelengths of the image.
    #[error(
        "{what} covers {have_start_nm}–{have_end_nm} nm, but the light spans {need_start_nm}–{need_end_nm} nm"
    )]
    Coverage {
        /// The curve.
        what: String,
        /// First wavelength of the curve.
        have_start_nm: f64,
        /// Last wavelength of the curve.
        have_end_nm: f64,
        /// First wavelength of the light.
        need_start_nm: f64,
        /// Last wavelength of the light.
        need_end_nm: f64,
    },
    /// The exposure time is out of its range.
    #[error("time_s is {value}; expected 0 (a bias frame) to 1e9 s")]
    ExposureTime {
        /// The value.
        value: f64,
    },
    /// The analog gain is out of its range.
    #[error("analog_gain is {value}; expected 1e-6 to 1e6")]
    AnalogGain {
        /// The value.
        value: f64,
    },
    /// The analog offset is out of range, or leaves the signal no swing.
    #[error("analog_offset_v is {value}; expected −1e3 to 1e3 V that leave the swing some signal")]
    AnalogOffset {
        /// The value.
        value: f64,
    },
    /// A parameter of automatic exposure is out of its range.
    #[error("{field} is {value}; expected {expected}")]
    AutoExposure {
        /// Its name.
        field: &'static str,
        /// The value.
        value: f64,
        /// The range.
        expected: &'static str,
    },
    /// There is no light to determine an exposure time.
    #[error("no exposure time can be chosen: the sensor sees no light where the rule looks for it")]
    NoLight,
    /// Spectral data are invalid.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The colour filter array is invalid.
    #[error(transparent)]
    Cfa(#[from] CfaError),
    /// The raw image is invalid.
    #[error(transparent)]
    Raw(#[from] RawError),
    /// The shape is invalid.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}
