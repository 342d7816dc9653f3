//! Errors of the processing from raw image to picture.

use thiserror::Error;

use crate::color::ImageError;
use crate::numeric::ShapeError;
use crate::numeric::least_squares::LeastSquaresError;
use crate::spectrum::SpectrumError;

/// The reason why a raw image cannot be processed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum IspError {
    /// The method is not defined for this mosaic.
    #[error(
        "{method} is defined for Bayer mosaics (2 × 2, three channels, one of them twice on a diagonal); this one is {rows} × {cols} with {channels} channels; bilinear takes any"
    )]
    UnsupportedCfa {
        /// Rows of the tile.
        rows: usize,
        /// Columns of the tile.
        cols: usize,
        /// Channels.
        channels: usize,
        /// The method.
        method: &'static str,
    },
    /// A channel has no samples near some pixel.
    #[error(
        "channel {channel} has too few samples around cell ({row}, {col}) of the mosaic (all counted from 0): within {reach} pixels none enclose it"
    )]
    SparseChannel {
        /// The channel.
        channel: usize,
        /// Row of the cell.
        row: usize,
        /// Column of the cell.
        col: usize,
        /// Search radius, pixels.
        reach: usize,
    },
    /// The image is so small that it has no sample of a channel.
    #[error("an image of {rows} × {cols} pixels holds no sample of channel {channel} (counted from 0)")]
    ChannelNotSeen {
        /// The channel.
        channel: usize,
        /// Rows of the image.
        rows: usize,
        /// Columns of the image.
        cols: usize,
    },
    /// The demosaicker is for another mosaic than that of the image.
    #[error("the mosaic of the image is not the one for which the demosaicker was made")]
    Mosaic,
    /// A number of channels is wrong.
    #[error("{what} has {got} channels, expected {expected}")]
    Channels {
        /// The data with the wrong number.
        what: &'static str,
        /// Expected number of channels.
        expected: usize,
        /// Actual number of channels.
        got: usize,
    },
    /// The caller stopped the pipeline.
    #[error("stopped")]
    Stopped,
    /// This list for the fit of a colour matrix is empty.
    #[error("a colour matrix needs at least one of {0}")]
    Empty(&'static str),
    /// The camera or the observer does not respond to the illuminant.
    #[error(
        "{0} has no response to the illuminant, so its white point is undefined; choose an illuminant with power at the wavelengths of the camera"
    )]
    NoResponse(&'static str),
    /// A parameter is out of its range.
    #[error("{name} is {value}; expected {expected}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range.
        expected: &'static str,
    },
    /// A learned pipeline does not match the raw image, or does not render pictures: the message of its error.
    #[error("{0}")]
    Learned(String),
    /// A buffer does not match its shape.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Spectral data are invalid.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The colour matrix could not be computed.
    #[error(transparent)]
    LeastSquares(#[from] LeastSquaresError),
    /// The picture is invalid.
    #[error(transparent)]
    Image(#[from] ImageError),
}
