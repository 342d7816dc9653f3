//! Errors of sensors, exposures and captures.

use thiserror::Error;

use super::{CfaError, RawError};
use crate::numeric::{OutOfRange, Rect, ShapeError};
use crate::spectrum::SpectrumError;

/// Errors of a sensor, an exposure, or the light on a sensor.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SensorError {
    /// The spectra belong to other pixels than the window.
    #[error(
        "{} × {} pixels from ({}, {}) are read, but light is known for {} × {} from ({}, {}); expected rows within these, \
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
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] OutOfRange),
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
    /// Samples of two conversion gains cannot be averaged.
    #[error(
        "digital binning averages readings of one conversion gain, and two are combined; expected charge binning, or the high or the low gain alone"
    )]
    CombinedBinning,
    /// There is no light to determine an exposure time.
    #[error(
        "no exposure time can be chosen: the part of the image that the rule measures is dark to the sensor"
    )]
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
