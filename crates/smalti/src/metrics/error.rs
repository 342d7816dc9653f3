//! Errors of metrics.

use thiserror::Error;

use super::Rect;
use crate::color::ImageError;
use crate::color::scielab::ScielabError;
use crate::numeric::ShapeError;
use crate::spectrum::SpectrumError;

/// The reason why a metric cannot be computed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MetricError {
    /// No metric has this name.
    #[error("no metric is called '{0}'")]
    UnknownMetric(String),
    /// A region is empty or extends beyond the image.
    #[error(
        "the region of {} × {} pixels at row {}, column {} (counted from 0) must have pixels and lie within the image of {rows} × {cols}",
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
    /// A plane or channel does not exist.
    #[error("there is no plane {index}; the image has {count} (counted from 0)")]
    Plane {
        /// Its index.
        index: usize,
        /// Number of planes.
        count: usize,
    },
    /// A number of items is wrong.
    #[error("{what}: expected {expected}, got {got}")]
    Count {
        /// What was counted.
        what: &'static str,
        /// Expected number.
        expected: usize,
        /// Actual number.
        got: usize,
    },
    /// There are too few items for a measurement.
    #[error("{what}: at least {minimum} are needed, got {got}")]
    TooFew {
        /// What was counted.
        what: &'static str,
        /// Least number.
        minimum: usize,
        /// Actual number.
        got: usize,
    },
    /// A value is NaN or infinite.
    #[error("{what}: value {index} (counted from 0) is not finite")]
    NotFinite {
        /// The data that contain it.
        what: &'static str,
        /// Its index in row order, from 0.
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
    /// No straight edge crosses the region: the missing property.
    #[error("no edge crosses the region: {0}")]
    NoEdge(&'static str),
    /// The contrast of the edge is too low.
    #[error("the contrast of the edge (Michelson) is {contrast:.3}; at least {minimum:.3} is needed")]
    LowContrast {
        /// (high − low) / (high + low).
        contrast: f64,
        /// The least accepted contrast.
        minimum: f64,
    },
    /// The angle of the edge is too small or too large for subpixel sampling.
    #[error("the angle of the edge to the pixel grid is {:.2}°; expected {expected}", angle_deg.abs())]
    EdgeAngle {
        /// Its angle to the nearer axis of the grid.
        angle_deg: f64,
        /// The range.
        expected: &'static str,
    },
    /// The angle of the edge makes its samples coincide at a few phases.
    #[error(
        "the samples across the edge (at {:.2}°) leave gaps of {gap_px:.2} px, at most {maximum_px:.2} are \
         allowed: choose another angle or a longer edge", angle_deg.abs()
    )]
    EdgeSampling {
        /// Largest gap between neighbouring samples of the edge profile, pixels.
        gap_px: f64,
        /// The largest accepted gap, pixels.
        maximum_px: f64,
        /// Angle of the edge to the nearer axis of the grid.
        angle_deg: f64,
    },
    /// The metric is undefined: a divisor vanishes or no sample lies in the range.
    #[error("{quantity} is not defined here: {reason}")]
    Undefined {
        /// The quantity.
        quantity: &'static str,
        /// The reason.
        reason: &'static str,
    },
    /// The image has the wrong colour space or shape.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The number of values of a map does not match its size.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Spectral curves do not fit each other.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// S-CIELAB cannot be computed.
    #[error(transparent)]
    Scielab(#[from] ScielabError),
}

impl MetricError {
    /// Whether a picture shows no edge that can be measured: none at all, one of too little contrast, or one at an unsuitable angle.
    #[must_use]
    pub fn is_about_edge(&self) -> bool {
        matches!(
            self,
            Self::NoEdge(_) | Self::LowContrast { .. } | Self::EdgeAngle { .. } | Self::EdgeSampling { .. }
        )
    }
}

/// Checks that there are as many items as a measurement needs.
pub(super) fn at_least(what: &'static str, minimum: usize, got: usize) -> Result<(), MetricError> {
    if got >= minimum { Ok(()) } else { Err(MetricError::TooFew { what, minimum, got }) }
}

/// Checks that no value is NaN or infinite.
pub(super) fn finite(
    what: &'static str,
    values: impl IntoIterator<Item = impl Into<f64>>,
) -> Result<(), MetricError> {
    match values.into_iter().position(|v| !v.into().is_finite()) {
        Some(index) => Err(MetricError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Checks that a parameter is a finite number not below 0.
pub(super) fn not_negative(name: &'static str, value: f64) -> Result<(), MetricError> {
    let expected = "a finite number not below 0";
    let fits = value >= 0.0 && value.is_finite();
    if fits { Ok(()) } else { Err(MetricError::Parameter { name, value, expected }) }
}
