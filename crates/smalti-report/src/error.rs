//! Why a figure cannot be drawn.

use thiserror::Error;

/// A figure that cannot be drawn from what was given.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FigureError {
    /// Columns of one series that differ in length.
    #[error("series `{series}`: {expected} values of x, but {got} {what}")]
    Lengths {
        /// Name of the series.
        series: String,
        /// The column that differs.
        what: &'static str,
        /// Values of x.
        expected: usize,
        /// Values of the other column.
        got: usize,
    },
    /// A range that is empty, not finite, or not positive (1e-100 to 1e100) on a logarithmic axis.
    #[error(
        "range of {axis}: {low} to {high} must be finite and rise; on a logarithmic axis both must be positive"
    )]
    Range {
        /// What it is the range of.
        axis: &'static str,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A figure too small to hold its labels, or too large.
    #[error("a figure of {width} × {height} pixels: {reason}")]
    Size {
        /// Width in pixels.
        width: f64,
        /// Height in pixels.
        height: f64,
        /// What limit it breaks.
        reason: String,
    },
    /// A picture whose buffer has not three bytes for each of its pixels.
    #[error("picture `{caption}`: {width} × {height} pixels need {expected} bytes (8-bit RGB), got {got}")]
    Picture {
        /// Its caption.
        caption: String,
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
        /// Bytes needed.
        expected: usize,
        /// Bytes given.
        got: usize,
    },
    /// A mosaic that is no rectangle of cells, or too large to see.
    #[error("mosaic `{caption}`: {cells} cells in rows of {cols} (at most {limit} cells)")]
    Mosaic {
        /// Its caption.
        caption: String,
        /// Cells given.
        cells: usize,
        /// Columns given.
        cols: usize,
        /// The most cells that are drawn.
        limit: usize,
    },
    /// A figure of several parts without a part.
    #[error("a figure needs at least one {what}")]
    Nothing {
        /// The part.
        what: &'static str,
    },
    /// The plotting crate could not draw.
    #[error("cannot draw the plot")]
    Plot(#[from] plotters::drawing::DrawingAreaErrorKind<std::convert::Infallible>),
    /// The SVG could not be drawn as a picture.
    #[error("cannot draw the SVG")]
    Render(#[from] resvg::usvg::Error),
    /// A PNG could not be encoded.
    #[error("cannot encode the PNG")]
    Encode(#[from] png::EncodingError),
}
