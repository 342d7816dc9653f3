//! What can go wrong in learning and using a pipeline.

use thiserror::Error;

use crate::isp::IspError;
use crate::numeric::{ShapeError, first_invalid};

/// A pipeline that cannot be learned, or not be used as asked.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum L3Error {
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
    /// Processing with a learned pipeline lacks the pipeline.
    #[error("there is no learned pipeline for the camera")]
    NoPipeline,
    /// This axis of classes has no members.
    #[error("the class axis '{0}' has no members; at least one is needed")]
    EmptyAxis(&'static str),
    /// The cut points of the levels do not fit, for this reason.
    #[error("cut points of levels: {0}")]
    Levels(String),
    /// No patch of this side, pixels, has been seen.
    #[error("there is nothing to learn from: the training data contain no patch of {0} × {0} pixels")]
    Empty(usize),
    /// A scene to learn from gives no response, however long the exposure.
    #[error("the scene is dark to the sensor: no exposure time gives a response from which to learn")]
    Dark,
    /// A position of the mosaic has not been seen, not even by symmetry.
    #[error("the training data contain no patch around cell ({row}, {col}) of the mosaic (counted from 0)")]
    UnseenPosition {
        /// Row of the cell.
        row: usize,
        /// Column of the cell.
        col: usize,
    },
    /// The raw image samples every channel at every pixel.
    #[error("the raw image has every channel at every pixel; learned pipelines are for mosaics")]
    NoMosaic,
    /// The raw image has another mosaic than the pipeline was learned for.
    #[error("the raw image has a mosaic of {got}, the pipeline is for {expected}")]
    Mosaic {
        /// Size and channels of the pipeline's tile.
        expected: String,
        /// Size and channels of the image's tile.
        got: String,
    },
    /// The raw image is smaller than the patch or the tile.
    #[error("the image is {} × {} pixels; at least {} × {} are needed (patch and tile)", size[0], size[1], least[0], least[1])]
    Size {
        /// Its rows and columns.
        size: [usize; 2],
        /// Rows and columns needed.
        least: [usize; 2],
    },
    /// Black or white level are not those that the pipeline was learned for.
    #[error(
        "the raw image has black level {} and white level {}; the pipeline was learned for {} and {}; expected a pipeline that was learned for \
         this camera (smalti train)",
        got[0], got[1], expected[0], expected[1]
    )]
    RawLevels {
        /// Black and white level of the pipeline.
        expected: [f64; 2],
        /// Black and white level of the image.
        got: [f64; 2],
    },
    /// The fixed-point path reads digital numbers.
    #[error("the fixed-point path needs digital numbers; this raw image is in volts")]
    NotDigital,
    /// The pipeline has no fixed-point form, for this reason.
    #[error("the pipeline has no fixed-point form: {0}")]
    NoFixedPoint(&'static str),
    /// Best quality is asked of a pipeline that was learned for fast quality.
    #[error(
        "the pipeline has one stage; expected quality fast, or a pipeline that was learned for quality best"
    )]
    NoSecondStage,
    /// Two images of a pair differ in size.
    #[error("the raw image is {} × {} pixels, {what} {} × {}", size[0], size[1], got[0], got[1])]
    PairSize {
        /// The other image.
        what: &'static str,
        /// Rows and columns of the raw image.
        size: [usize; 2],
        /// Rows and columns of the other.
        got: [usize; 2],
    },
    /// The number of planes of the target is not that of the outputs.
    #[error("the target has {got} planes; {expected} outputs are learned")]
    Outputs {
        /// Outputs.
        expected: usize,
        /// Planes.
        got: usize,
    },
    /// A value is NaN or infinite.
    #[error("{what} is {value} at row {row}, column {col} (counted from 0); a finite number was expected")]
    Value {
        /// Where it stands: the target's plane, or the raw image.
        what: String,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        col: usize,
        /// The value.
        value: f32,
    },
    /// Statistics or tables that differ in this: axes, outputs or noise.
    #[error("the statistics cannot be combined: their {0} differ")]
    Mismatch(&'static str),
    /// The raw image and the image that determines its classes have different mosaics.
    #[error("the raw image and the image that determines its classes have different mosaics")]
    Mosaics,
    /// The parts of a table do not fit each other, for this reason.
    #[error("the learned table is inconsistent: {0}")]
    Table(String),
    /// The class of this index has no positive definite system, even after regularisation.
    #[error("the normal equations of class {0} (counted from 0) cannot be solved")]
    Singular(usize),
    /// A pipeline renders pictures only with the outputs X, Y, Z, not with these.
    #[error("the outputs of the pipeline are {0}; a picture needs X, Y, Z")]
    NoPicture(String),
    /// A pipeline renders pictures only with three outputs, not with this number.
    #[error("the pipeline has {0} outputs; a picture has three: use `render_raw`")]
    NotAPicture(usize),
    /// A buffer does not match its shape.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The raw image cannot be processed.
    #[error(transparent)]
    Isp(#[from] IspError),
}

/// Checks that the values of a plane with `cols` columns are finite; `what` is its name in the error.
pub(super) fn ensure_finite(what: &str, values: &[f32], cols: usize) -> Result<(), L3Error> {
    first_invalid(values, f32::is_finite).map_or(Ok(()), |i| {
        Err(L3Error::Value { what: what.to_owned(), row: i / cols, col: i % cols, value: values[i] })
    })
}

/// Checks that an image has the rows and columns of the raw image; `what` is its name in the error.
pub(super) fn ensure_same_size(what: &'static str, size: [usize; 2], got: [usize; 2]) -> Result<(), L3Error> {
    if size == got { Ok(()) } else { Err(L3Error::PairSize { what, size, got }) }
}

/// Checks that a number lies within a range.
pub(super) fn within(
    name: &'static str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    expected: &'static str,
) -> Result<f64, L3Error> {
    if range.contains(&value) { Ok(value) } else { Err(L3Error::Parameter { name, value, expected }) }
}
