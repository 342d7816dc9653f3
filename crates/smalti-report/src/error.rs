//! Errors of drawing.

use thiserror::Error;

/// The reason why a figure cannot be drawn.
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
        /// The axis.
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
        /// The limit that is violated.
        reason: String,
    },
    /// A picture whose buffer does not have three bytes per pixel.
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
    /// A mosaic whose cells are not a rectangle, or that has too many cells.
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
    /// A figure without any part.
    #[error("a figure needs at least one {what}")]
    Nothing {
        /// The part.
        what: &'static str,
    },
    /// The SVG could not be rendered.
    #[error("cannot draw the SVG")]
    Render(#[from] resvg::usvg::Error),
    /// A PNG could not be encoded.
    #[error("cannot encode the PNG")]
    Encode(#[from] png::EncodingError),
}
