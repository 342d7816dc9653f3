//! Errors of registration.

use thiserror::Error;

use crate::isp::IspError;
use crate::numeric::ShapeError;
use crate::numeric::fft::FftError;
use crate::sensor::RawError;

/// Minimum correlation of a match.
pub const MIN_CORRELATION: f64 = 0.5;

/// The reason why an image cannot be registered with a raw image.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RegistrationError {
    /// The raw image cannot be interpolated.
    #[error(transparent)]
    Isp(#[from] IspError),
    /// The shape of an image is invalid.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The common part is not a valid raw image.
    #[error(transparent)]
    Raw(#[from] RawError),
    /// One of the images, or their common part, is too small.
    #[error("{rows} × {cols} pixels are too few for alignment; at least {least} × {least} are needed")]
    TooSmall {
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
        /// The least number of rows and of columns.
        least: usize,
    },
    /// A sample of the raw image, or the luminance of the image, is NaN or infinite.
    #[error("{what} is {value} at row {row}, column {col} (counted from 0); a finite number was expected")]
    Value {
        /// The image.
        what: &'static str,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        col: usize,
        /// The value.
        value: f32,
    },
    /// One of the images, or its part in common with the other, has the same value everywhere.
    #[error("{0} is uniform; an alignment needs structure")]
    Uniform(&'static str),
    /// Too little of the image lies on the raw image at any position.
    #[error("the image and the raw image do not overlap enough to be aligned")]
    NoOverlap,
    /// A Fourier transform failed.
    #[error(transparent)]
    Fft(#[from] FftError),
    /// No scale was given.
    #[error("no scale was given for the alignment")]
    NoScale,
    /// The scale, pixels of the raw image per pixel of the picture, is out of range.
    #[error("a pixel of the image spans {0} pixels of the raw image; expected 0.25 to 8")]
    Scale(f64),
    /// The image does not match the raw image at any position: the best correlation found.
    #[error(
        "the image does not match the raw image: their correlation is {0:.2}, expected at least {least}",
        least = MIN_CORRELATION
    )]
    NoMatch(f64),
}

impl RegistrationError {
    pub(super) fn too_small(rows: usize, cols: usize, least: usize) -> Self {
        Self::TooSmall { rows, cols, least }
    }

    /// Whether another scale may still match.
    pub(super) fn is_of_this_scale(&self) -> bool {
        matches!(self, Self::TooSmall { .. } | Self::Uniform(_) | Self::NoOverlap | Self::NoMatch(_))
    }
}
