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
//! | numbers for programs, small | [`packed`], [`runs`], [`words`], [`Page::data`] |
//! | text to copy | [`copyable`] |
//! | programs and styles of a kind of page | [`Piece`]: [`SWEEP`], [`COMPARE`] |
//!
//! A page states a content security policy: no network, no frames, no forms, and only the very scripts and styles written here,
//! by their hashes. Scripts put text into the page as text, never as HTML. What the page does without scripts stands in its
//! HTML: sections, tables, figures.

mod columns;
mod markup;
mod picture;
mod shell;
mod table;
#[cfg(test)]
mod tests;

pub use columns::{packed, runs, words};
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
}

/// What every page has: look, light and dark, tables that sort, text to copy.
const SHELL: Piece = Piece { css: include_str!("shell.css"), js: include_str!("shell.js") };

/// What a page of many designs is made of, in this order.
pub const SWEEP: &[Piece] = &[
    Piece { css: "", js: include_str!("data.js") },
    Piece { css: "", js: include_str!("viridis.js") },
    Piece { css: "", js: include_str!("color.js") },
    Piece { css: "", js: include_str!("scale.js") },
    Piece { css: include_str!("scatter.css"), js: include_str!("scatter.js") },
    Piece { css: "", js: include_str!("histogram.js") },
    Piece { css: include_str!("design.css"), js: include_str!("design.js") },
    Piece { css: include_str!("filters.css"), js: include_str!("filters.js") },
    Piece { css: include_str!("sweep.css"), js: include_str!("sweep.js") },
];

/// What a page of pictures side by side is made of, in this order.
pub const COMPARE: &[Piece] = &[
    Piece { css: "", js: include_str!("data.js") },
    Piece { css: "", js: include_str!("viridis.js") },
    Piece { css: include_str!("kernels.css"), js: include_str!("kernels.js") },
    Piece { css: include_str!("compare.css"), js: include_str!("compare.js") },
];

/// A figure, in the colours of the page. Its title and note are in it.
#[must_use]
pub fn figure(drawing: &Figure) -> Markup {
    el("figure").class("drawing").child(drawing).into()
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
