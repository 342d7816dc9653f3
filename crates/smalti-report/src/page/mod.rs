//! Pages: one HTML file that needs nothing else, works without a network and prints.
//!
//! ```
//! use smalti_report::page::{Page, Table, el};
//! let table = Table::new("Two cameras").text("camera").number("ΔE").row(["bayer", "3.00"], false).row(["rgbw", "2.84"], true);
//! let html = Page::new("Comparison")
//!     .lead(el("p").child("Which one?"))
//!     .section("scores", "Scores", table)
//!     .html();
//! assert!(html.starts_with("<!doctype html>") && html.contains("Content-Security-Policy"));
//! ```
//!
//! | part | by |
//! |---|---|
//! | text, escaped; elements | [`Markup`], [`el`] |
//! | tables | [`Table`] |
//! | figures as inline SVG | `Markup::from(&Figure)`, [`figure`] |
//! | pictures | [`DataUri`] |
//! | numbers for programs, small | [`packed`], [`runs`], [`words`], [`whole_pictures`], [`Page::data`] |
//! | text to copy | [`copyable`] |
//! | programs and styles of a kind of page | [`Piece`]: [`SWEEP`], [`COMPARE`] |
//!
//! A page states a content security policy: no network, no frames, no forms, and only the very scripts and styles written here,
//! by their hashes. Scripts put text into the page as text, never as HTML. Text for a page without scripts is in its
//! HTML: sections, tables, figures.

mod columns;
mod markup;
mod picture;
mod shell;
mod table;
#[cfg(test)]
pub(crate) mod tests;

pub use columns::{packed, runs, whole_pictures, words};
pub use markup::{Element, Markup, el};
pub use picture::DataUri;
pub use shell::Page;
pub use table::Table;

use crate::Figure;

/// Styles and a program for a kind of page. They are files of this crate: nothing else can be one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Piece {
    css: &'static str,
    js: &'static str,
    /// Credit for work that is not our own, printed at the end of the page.
    credit: &'static str,
}

impl Piece {
    const fn new(css: &'static str, js: &'static str) -> Self {
        Self { css, js, credit: "" }
    }
}

/// The plots of a page: uPlot's release as it is on npm, behind its licence. vendor/uplot/README.md states its origin.
const UPLOT: Piece = Piece {
    css: include_str!("../../vendor/uplot/uPlot.min.css"),
    js: concat!(
        "/*\n",
        include_str!("../../vendor/uplot/LICENSE"),
        "\n*/\n",
        include_str!("../../vendor/uplot/uPlot.iife.min.js"),
        "\n"
    ),
    credit: "Plots are drawn by uPlot 1.6.32, © 2022 Leon Sorokin, MIT licence: its text is in the source of this page.",
};

/// What every page has: look, light and dark, tables that sort, text to copy.
const SHELL: Piece = Piece::new(include_str!("shell.css"), include_str!("shell.js"));

/// What a page of many designs is made of, in this order.
pub const SWEEP: &[Piece] = &[
    Piece::new("", include_str!("data.js")),
    Piece::new("", include_str!("viridis.js")),
    Piece::new("", include_str!("color.js")),
    UPLOT,
    Piece::new("", include_str!("axes.js")),
    Piece::new("", include_str!("cloud.js")),
    Piece::new(include_str!("scatter.css"), include_str!("scatter.js")),
    Piece::new("", include_str!("histogram.js")),
    Piece::new("", include_str!("simulator.js")),
    Piece::new(include_str!("design.css"), include_str!("design.js")),
    Piece::new(include_str!("filters.css"), include_str!("filters.js")),
    Piece::new(include_str!("sweep.css"), include_str!("sweep.js")),
];

/// The simulator as WebAssembly, deflated: `crates/smalti-wasm`, made by `just wasm`.
const SIMULATOR: &[u8] = include_bytes!("../../vendor/smalti-wasm/smalti.wasm.deflate");
/// Bytes that the simulator takes in a page.
pub const SIMULATOR_BYTES: usize = SIMULATOR.len().div_ceil(3) * 4;

/// What a page of pictures side by side is made of, in this order.
pub const COMPARE: &[Piece] = &[
    Piece::new("", include_str!("data.js")),
    Piece::new("", include_str!("viridis.js")),
    Piece::new(include_str!("kernels.css"), include_str!("kernels.js")),
    Piece::new(include_str!("compare.css"), include_str!("compare.js")),
];

/// What a page of a design is made of: the look of a comparison, without its viewer.
pub const DESIGN: &[Piece] = &[Piece::new(include_str!("compare.css"), "")];

/// A figure, in the colours of the page. Its title and note are in it.
#[must_use]
pub fn figure(drawing: &Figure) -> Markup {
    el("figure").class("drawing").child(drawing).into()
}

/// A paragraph of a class.
pub(crate) fn paragraph(class: &str, text: impl Into<Markup>) -> Markup {
    el("p").class(class).child(text).into()
}

/// The foot of a page: the version that made it.
pub(crate) fn foot() -> Markup {
    let version = env!("CARGO_PKG_VERSION");
    el("p").child(format!("Made by Smalti {version}. This page needs no network and sends nothing.")).into()
}

/// A text, of one line or several, with a button that copies it.
#[must_use]
pub fn copyable(text: &str, what: &str) -> Markup {
    el("div")
        .class("copyable")
        .child(el("pre").attr("tabindex", "0").child(Markup::lines(text)))
        .child(el("button").attr("type", "button").attr("data-copy", "").child(format!("Copy {what}")))
        .into()
}
