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
//! The SVG is written here, on a small module of axes; three plotting crates were measured. kuva 0.6 writes every point
//! of a cloud as a shape of 58 bytes, NaN as a coordinate, and no title or description. plotters 0.3 knows whole pixels
//! only, draws NaN on the axis, its legend over the points, and no tick on a logarithmic axis from 1.2 to 8.7; the same
//! figures through a backend of ours took 269 lines more than without it. charton 0.9 makes 22 MB of 100 000 points,
//! labels that axis at its ends only, and writes NaN as a coordinate where a value is infinite. PNGs are drawn by `resvg`
//! from the very SVG.
//!
//! [okabe2008]: https://jfly.uni-koeln.de/color/
//! [smith2015]: https://bids.github.io/colormap/

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
