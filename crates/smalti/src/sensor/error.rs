//! What can be wrong with a sensor, an exposure or the light it is shown.

use thiserror::Error;

use super::{CfaError, RawError};
use crate::numeric::{Rect, ShapeError};
use crate::spectrum::SpectrumError;

/// A sensor or an exposure that cannot be, or does not fit the image it is shown.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SensorError {
    /// Spectra gathered on other pixels than those that are read.
    #[error(
        "{} × {} pixels from ({}, {}) are read, but light is known for {} × {} from ({}, {}); expected rows among them, \
         the same columns, and a sensor of the same size and crosstalk",
        window.rows, window.cols, window.row, window.col, gathered.rows, gathered.cols, gathered.row, gathered.col
    )]
    OtherPixels {
        /// The pixels that are read.
        window: Rect,
        /// The pixels whose light is known.
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
    /// The window reaches beyond the sensor.
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
    /// The pixel pitch is not that of a pixel.
    #[error("pitch_m is {value}; expected 1e-9 to 1e-2 m")]
    Pitch {
        /// The value.
        value: f64,
    },
    /// The fill factor is not a fraction of the pixel.
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
    /// The voltage swing leaves no range.
    #[error("voltage_swing_v is {value}; expected 1e-6 to 1e3 V")]
    VoltageSwing {
        /// The value.
        value: f64,
    },
    /// The well holds nothing.
    #[error("full_well_e is {value}; expected 1 to 1e12 electrons")]
    FullWell {
        /// The value.
        value: f64,
    },
    /// Dark voltage is negative or not a number.
    #[error("dark_voltage_v_per_s is {value}; expected 0 to 1e3 V/s")]
    DarkVoltage {
        /// The value.
        value: f64,
    },
    /// Read noise is negative or not a number.
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
    /// The black level leaves no range to the converter.
    #[error(
        "black_level_dn is {value}; expected 0 or more, and below {limit} (nine tenths of the range; 0 without a converter)"
    )]
    BlackLevel {
        /// The value.
        value: f64,
        /// The bound.
        limit: f64,
    },
    /// The crosstalk kernel creates or loses light.
    #[error("the crosstalk kernel needs entries of 0 or more that sum to 1; they sum to {sum}")]
    Crosstalk {
        /// Its sum.
        sum: f64,
    },
    /// A sensitivity is not a fraction.
    #[error("{what} at {wavelength_nm} nm is {value}; expected 0 to 1")]
    Fraction {
        /// Quantum efficiency or IR-cut filter.
        what: &'static str,
        /// Where.
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
    /// The analog offset is out of its range, or pushes all signal out of the swing.
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
    /// The sensor sees no light to set an exposure by.
    #[error("no exposure time can be chosen: the sensor sees no light where the rule looks for it")]
    NoLight,
    /// Spectral data do not fit.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The colour filter array does not fit.
    #[error(transparent)]
    Cfa(#[from] CfaError),
    /// The raw image does not fit.
    #[error(transparent)]
    Raw(#[from] RawError),
    /// The shape does not fit.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}
