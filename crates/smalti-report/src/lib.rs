//! Figures of Smalti as SVG and PNG (scatter plots, spectra, histograms, mosaics, sheets of pictures), and reports as HTML pages, tables
//! and JSON. It takes plain data, has no physics of its own (pictures come from `smalti`) and opens no file.
//!
//! | figure or report | type |
//! |---|---|
//! | points in series or coloured by value, marks with intervals, fronts, histograms | [`Plot`] |
//! | curves over wavelength | [`Plot::spectra`] |
//! | several plots with shared axes | [`Panels`] |
//! | mosaics as coloured tiles | [`Mosaics`] |
//! | the patches of a colour chart, reference above rendering | [`SplitPatches`] |
//! | pictures side by side | [`Sheet`] |
//! | a self-contained HTML page | [`page::Page`] |
//! | the report of studies | [`study::Report`] |
//! | the report of a comparison, of evaluations | [`comparison::Comparison`], [`comparison::Evaluations`] |
//! | the page of a design | [`design::page`] |
//! | the report of a rating experiment | [`rating::RatingReport`] |
//!
//! Each is built step by step and drawn to a [`Figure`], which provides an SVG document and a PNG. Equal inputs give equal bytes, on
//! machines without fonts as well: the text of a PNG is set in Inter, which the crate contains.
//!
//! The interactive plots of a page are drawn in the browser by uPlot, which the crate contains (`vendor/uplot`, MIT).
//! This crate draws the figures in the table above and writes them as SVG; `resvg` renders a PNG from the same SVG.
//! A large cloud of points becomes one embedded picture, and points without a place on the axes are counted, not drawn.
//!
//! Categories have the colours of [okabe2008], and values those of viridis ([smith2015]): readers with any colour vision
//! can distinguish both.
//!
//! [okabe2008]: https://jfly.uni-koeln.de/color/
//! [smith2015]: https://bids.github.io/colormap/
#![forbid(unsafe_code)]

mod axes;
mod chart_colors;
mod cloud;
mod color;
pub mod comparison;
pub mod design;
mod end_labels;
mod error;
mod figure;
mod layers;
mod layout;
mod legend;
pub mod names;
pub mod page;
mod panel;
mod pictures;
mod plot;
pub mod rating;
mod reliability;
mod report_error;
mod scale;
mod shared;
mod sheet;
pub mod study;
mod svg;
mod text;
mod tiles;
mod words;

pub use chart_colors::SplitPatches;
pub use color::{OKABE_ITO, Rgb};
pub use error::FigureError;
pub use figure::{Figure, SIDE_LIMIT};
pub use layers::{Corner, Histogram, Line, Points, Symbol};
pub use pictures::filter_color;
pub use plot::{Panels, Plot};
pub use report_error::{ReportError, in_one_line};
pub use scale::Scale;
pub use sheet::Sheet;
pub use tiles::{Cell, Mosaics};
pub use words::TextTable;

/// Stores a file of a report, since this crate opens none: its path relative to the folder of the report, with `/` between folders,
/// and its content.
pub type FileSink<'a> = dyn FnMut(&str, &[u8]) -> Result<(), Box<dyn std::error::Error + Send + Sync>> + 'a;
