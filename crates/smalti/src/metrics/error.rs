//! Why a metric cannot be computed.

use thiserror::Error;

use super::Rect;
use crate::color::ImageError;
use crate::color::scielab::ScielabError;

/// A measurement that cannot be made on what was given.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MetricError {
    /// A region has no pixels or leaves the image.
    #[error(
        "the region of {} × {} pixels at row {}, column {} must have pixels and lie within the image of {rows} × {cols}",
        rect.rows, rect.cols, rect.row, rect.col
    )]
    Region {
        /// The region.
        rect: Rect,
        /// Rows of the image.
        rows: usize,
        /// Columns of the image.
        cols: usize,
    },
    /// A plane or channel that is not there.
    #[error("plane {index} was asked for, but there are {count} (counted from 0)")]
    Plane {
        /// Its index.
        index: usize,
        /// Planes there are.
        count: usize,
    },
    /// Two things that belong together differ in number.
    #[error("{what}: expected {expected}, got {got}")]
    Count {
        /// What was counted.
        what: &'static str,
        /// How many were expected.
        expected: usize,
        /// How many came.
        got: usize,
    },
    /// Too little to measure on.
    #[error("{what}: at least {minimum} are needed, got {got}")]
    TooFew {
        /// What was counted.
        what: &'static str,
        /// How many are needed.
        minimum: usize,
        /// How many came.
        got: usize,
    },
    /// A value is NaN or infinite.
    #[error("{what}: value {index} is not finite")]
    NotFinite {
        /// What it belongs to.
        what: &'static str,
        /// Its place, in row order from 0.
        index: usize,
    },
    /// A number is out of its range.
    #[error("{name} is {value}; expected {expected}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range.
        expected: &'static str,
    },
    /// Two images that are compared differ in size.
    #[error("the images differ in size: {left:?} and {right:?} (rows, columns, planes)")]
    Size {
        /// Rows, columns and planes of the first.
        left: (usize, usize, usize),
        /// Rows, columns and planes of the second.
        right: (usize, usize, usize),
    },
    /// No straight edge crosses the region.
    #[error("no edge crosses the region: {reason}")]
    NoEdge {
        /// What was missing.
        reason: &'static str,
    },
    /// The two sides of the edge hardly differ.
    #[error("the contrast of the edge (Michelson) is {contrast:.3}; at least {minimum:.3} is needed")]
    LowContrast {
        /// (high − low) / (high + low).
        contrast: f64,
        /// The least that is accepted.
        minimum: f64,
    },
    /// The edge is too straight or too diagonal to be sampled finely.
    #[error("the edge stands at {angle_deg:.2}° to the pixel grid; expected {expected}")]
    EdgeAngle {
        /// Its angle to the nearer axis of the grid.
        angle_deg: f64,
        /// The range.
        expected: &'static str,
    },
    /// The angle of the edge is such that its samples fall on the same few places again and again.
    #[error(
        "the samples across the edge (at {angle_deg:.2}°) leave gaps of {gap_px:.2} px, at most {maximum_px:.2} are \
         allowed: choose another angle or a longer edge"
    )]
    EdgeSampling {
        /// Largest gap between neighbouring samples of the edge profile, pixels.
        gap_px: f64,
        /// The largest that is accepted, pixels.
        maximum_px: f64,
        /// Angle of the edge to the nearer axis of the grid.
        angle_deg: f64,
    },
    /// The measurement has no result: a divisor vanishes or no sample lies in the range.
    #[error("{quantity} is not defined here: {reason}")]
    Undefined {
        /// What was to be computed.
        quantity: &'static str,
        /// Why it cannot be.
        reason: &'static str,
    },
    /// The image is not of the kind that was expected.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// S-CIELAB does not apply.
    #[error(transparent)]
    Scielab(#[from] ScielabError),
}
