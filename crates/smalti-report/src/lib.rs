//! Figures of Smalti as SVG and PNG (scatter plots, spectra, histograms, mosaics, sheets of pictures) and pages of them as HTML.
//! No physics: plain numbers in, a picture or a page out, and no file is opened.
//!
//! | figure | type |
//! |---|---|
//! | points in series or coloured by value, marks with intervals, fronts, histograms | [`Plot`] |
//! | curves over wavelength | [`Plot::spectra`] |
//! | several plots with shared axes | [`Panels`] |
//! | mosaics as coloured tiles | [`Mosaics`] |
//! | pictures side by side | [`Sheet`] |
//! | an HTML page that needs nothing else | [`page::Page`] |
//!
//! Each is built up and drawn to a [`Figure`], which gives an SVG document and a PNG. Equal inputs give equal bytes, on
//! machines without fonts as well: the text of a PNG is set in Inter, which the crate brings along.
//!
//! The plots of a page that answer a hand are drawn in the browser by uPlot, which the crate brings along (`vendor/uplot`, MIT); the
//! figures of the table are drawn here.
//!
//! Colours of categories are those of [okabe2008], of values viridis ([smith2015]): both can be told apart with any
//! colour vision.
//!
//! Axes, grid and series of the figures are those of `plotters`; where ticks stand, legends and clouds are ours, and the
//! SVG is written here, by a backend of `plotters` (`backend.rs`): it takes hundredths of pixels for the crate's whole ones,
//! names figure and series for a screen reader, and measures text in the font that it brings. PNGs are drawn by `resvg`
//! from the very SVG. Of the crates measured, kuva 0.6 and charton 0.9 write each point of a cloud as a shape (22 MB for
//! 100 000 points with charton) and NaN as a coordinate; `plotters` draws a point at NaN on the axis and puts no tick on a
//! logarithmic axis from 1.2 to 8.7, so that points without a place are left out and ticks are chosen before it is asked.
//!
//! [okabe2008]: https://jfly.uni-koeln.de/color/
//! [smith2015]: https://bids.github.io/colormap/

mod backend;
mod cloud;
mod color;
mod error;
mod figure;
mod layers;
mod layout;
mod legend;
pub mod page;
mod panel;
mod plot;
mod scale;
mod shared;
mod sheet;
mod svg;
mod text;
mod tiles;

pub use color::{OKABE_ITO, Rgb};
pub use error::FigureError;
pub use figure::{Figure, SIDE_LIMIT};
pub use layers::{Corner, Histogram, Line, Points, Symbol};
pub use plot::{Panels, Plot};
pub use scale::Scale;
pub use sheet::Sheet;
pub use tiles::{Cell, Mosaics};
