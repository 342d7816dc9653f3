//! The datasheet of an item, before it is drawn.

use serde_json::Value;

use super::picture::Pixels;
use super::plot::Plot;
use super::tile::Tile;

/// The description of one item: text, drawings, and the same as JSON.
pub(super) struct Datasheet {
    /// Its name and kind.
    pub(super) title: String,
    /// Paragraphs.
    pub(super) about: Vec<String>,
    /// Parts below the paragraphs, in this order.
    pub(super) parts: Vec<Part>,
    pub(super) json: Value,
    /// Its TOML, if it has any.
    pub(super) toml: Option<String>,
}

pub(super) enum Part {
    /// Finished lines of text.
    Lines(String),
    Tile(Tile),
    Plot(Plot),
    Picture(Pixels),
}

/// Four significant digits without trailing zeros.
pub(super) fn four_digits(v: f64) -> String {
    if v == 0.0 || !v.is_finite() {
        return v.to_string();
    }
    let digits = (3 - v.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
