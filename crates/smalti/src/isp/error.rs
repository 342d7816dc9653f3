//! What can go wrong between raw samples and a picture.

use thiserror::Error;

use crate::color::ImageError;
use crate::numeric::ShapeError;
use crate::numeric::least_squares::LeastSquaresError;
use crate::spectrum::SpectrumError;

/// A raw image that cannot be processed as asked.
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
    /// A channel appears nowhere near some pixel.
    #[error(
        "channel {channel} has too few samples around cell ({row}, {col}) of the mosaic: within {reach} pixels none enclose it"
    )]
    SparseChannel {
        /// The channel.
        channel: usize,
        /// Row of the cell.
        row: usize,
        /// Column of the cell.
        col: usize,
        /// How far samples are looked for, pixels.
        reach: usize,
    },
    /// The image is so small that it holds no sample of a channel.
    #[error("an image of {rows} × {cols} pixels holds no sample of channel {channel}")]
    ChannelNotSeen {
        /// The channel.
        channel: usize,
        /// Rows of the image.
        rows: usize,
        /// Columns of the image.
        cols: usize,
    },
    /// A plan made for one mosaic was given an image of another.
    #[error("the image has another mosaic than the demosaicker was made for")]
    Mosaic,
    /// Two things that meet have different numbers of channels.
    #[error("{what} has {got} channels, expected {expected}")]
    Channels {
        /// The one that is wrong.
        what: &'static str,
        /// Channels it should have.
        expected: usize,
        /// Channels it has.
        got: usize,
    },
    /// A pipeline that its user can stop has been stopped.
    #[error("stopped")]
    Stopped,
    /// A list that a colour matrix is learned from is empty.
    #[error("a colour matrix needs at least one of {what}")]
    Empty {
        /// The list.
        what: &'static str,
    },
    /// The camera, or the eye, does not see the illuminant.
    #[error("{what} does not respond to the illuminant, so white has no place")]
    NoResponse {
        /// Which of the two.
        what: &'static str,
    },
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
    /// A learned pipeline is not made for the raw image, or not for pictures.
    #[error("{reason}")]
    Learned {
        /// What its own error says.
        reason: String,
    },
    /// A buffer does not match its shape.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Spectral data do not fit.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The colour matrix could not be computed.
    #[error(transparent)]
    LeastSquares(#[from] LeastSquaresError),
    /// The picture could not be made.
    #[error(transparent)]
    Image(#[from] ImageError),
}
