//! The legend: names of series with their symbols.

use crate::color::Rgb;
use crate::layers::Symbol;
use crate::panel::{draw_symbol, series_color};
use crate::plot::{Layer, Plot};
use crate::shared::Shared;
use crate::svg::{Anchor, Area, FRAME, INK, Paint, Svg};
use crate::text::{TICK, clean, fit, width};

const GAP: f64 = 24.0;
/// The longest name in pixels.
const NAME_LIMIT: f64 = 320.0;

#[derive(Debug, Clone, PartialEq)]
enum Sign {
    Dot(Symbol, Rgb, bool),
    Line(Rgb, f64, bool),
    Area(Rgb),
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    name: String,
    sign: Sign,
}

impl Entry {
    /// Width of the symbol and the space before the name.
    fn sign_width(&self) -> f64 {
        if matches!(self.sign, Sign::Dot(..)) { 22.0 } else { 30.0 }
    }

    fn width(&self) -> f64 {
        self.sign_width() + width(&self.name, TICK)
    }
}

/// One entry per name, in the order of the layers.
pub(crate) fn entries(panels: &[Plot], shared: &Shared) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for layer in panels.iter().flat_map(|p| &p.layers).filter(|l| !l.name().is_empty()) {
        let name = fit(&clean(layer.name()), TICK, NAME_LIMIT);
        let sign = match layer {
            // Points coloured by value have no colour of their own.
            Layer::Points(p) if p.values.is_some() => Sign::Dot(p.symbol, FRAME, p.marks),
            Layer::Points(p) => Sign::Dot(p.symbol, series_color(shared, &p.name, p.color), p.marks),
            Layer::Line(l) => Sign::Line(series_color(shared, &l.name, l.color), l.width, l.dashed),
            Layer::Histogram(h) => Sign::Area(series_color(shared, &h.name, h.color)),
        };
        match (entries.iter_mut().find(|e| e.name == name).map(|e| &mut e.sign), sign) {
            (None, sign) => entries.push(Entry { name, sign }),
            // A name that occurs in several colours is shown by its symbol in grey.
            (Some(Sign::Dot(symbol, color, _)), Sign::Dot(s, c, _)) if s == *symbol && c != *color => {
                *color = FRAME;
            }
            _ => {}
        }
    }
    entries
}

/// The entries in rows of at most `limit` pixels.
pub(crate) fn rows(entries: &[Entry], limit: f64) -> Vec<&[Entry]> {
    let mut rows = Vec::new();
    let mut rest = entries;
    while !rest.is_empty() {
        let mut used = -GAP;
        let fitting = rest.iter().take_while(|e| {
            used += e.width() + GAP;
            used <= limit
        });
        let (row, after) = rest.split_at(fitting.count().max(1).min(rest.len()));
        rows.push(row);
        rest = after;
    }
    rows
}

/// Draws a row of entries on the baseline that begins at `at`.
pub(crate) fn draw_entries(svg: &mut Svg, row: &[Entry], at: (f64, f64), limit: f64) {
    let (mut x, y) = at;
    for entry in row {
        let middle = y - TICK.size * 0.36;
        match &entry.sign {
            Sign::Dot(symbol, color, marks) => {
                draw_symbol(svg, *symbol, (x + 8.0, middle), if *marks { 7.5 } else { 6.0 }, *color, *marks);
            }
            Sign::Line(color, width, dashed) => {
                let path = format!("M{} {}h22", crate::svg::number(x), crate::svg::number(middle));
                svg.path(&path, Paint { dashed: *dashed, ..Paint::stroke(*color, width.clamp(1.0, 5.0)) });
            }
            Sign::Area(color) => {
                let area = Area { x: x + 1.0, y: middle - 7.0, width: 20.0, height: 14.0 };
                svg.rect(area, Paint { stroke: Some((*color, 1.8)), ..Paint::fill(*color, 0.25) });
            }
        }
        let name = fit(&entry.name, TICK, limit - entry.sign_width());
        svg.text((x + entry.sign_width(), y), Anchor::Start, TICK, INK, &name);
        x += entry.width() + GAP;
    }
}
