//! SVG with numbers in fixed notation, so that equal figures have equal bytes.

use std::fmt::Write;

use base64::Engine;

use crate::color::Rgb;
use crate::text::{self, Font};

pub(crate) const INK: Rgb = Rgb(38, 38, 38);
pub(crate) const SOFT: Rgb = Rgb(96, 96, 96);
pub(crate) const GRID: Rgb = Rgb(229, 229, 229);
pub(crate) const FRAME: Rgb = Rgb(120, 120, 120);

/// The alignment of a text to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A rectangle in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Area {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// Fill and stroke of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Paint {
    pub(crate) fill: Option<(Rgb, f64)>,
    pub(crate) stroke: Option<(Rgb, f64)>,
    pub(crate) dashed: bool,
}

impl Paint {
    pub(crate) fn fill(color: Rgb, opacity: f64) -> Self {
        Self { fill: Some((color, opacity)), stroke: None, dashed: false }
    }

    pub(crate) fn stroke(color: Rgb, width: f64) -> Self {
        Self { fill: None, stroke: Some((color, width)), dashed: false }
    }

    pub(crate) fn attributes(&self) -> String {
        let mut out = match self.fill {
            None => " fill=\"none\"".to_owned(),
            Some((color, opacity)) if opacity < 1.0 => {
                format!(" fill=\"{color}\" fill-opacity=\"{}\"", number(opacity))
            }
            Some((color, _)) => format!(" fill=\"{color}\""),
        };
        if let Some((color, width)) = self.stroke {
            let _ = write!(out, " stroke=\"{color}\" stroke-width=\"{}\"", number(width));
        }
        if self.dashed {
            out.push_str(" stroke-dasharray=\"7 5\"");
        }
        out
    }
}

/// A coordinate with at most two decimals, which exceeds the resolution of printers.
pub(crate) fn number(value: f64) -> String {
    let value = if value.is_finite() { value.clamp(-1e6, 1e6) } else { 0.0 };
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The path through points.
pub(crate) fn path_of(points: &[(f64, f64)], closed: bool) -> String {
    let mut out = String::new();
    for (i, (x, y)) in points.iter().enumerate() {
        let _ = write!(out, "{}{} {}", if i == 0 { 'M' } else { 'L' }, number(*x), number(*y));
    }
    if closed {
        out.push('Z');
    }
    out
}

/// The attributes of a rectangle.
fn placed(area: Area) -> String {
    let [x, y, width, height] = [area.x, area.y, area.width, area.height].map(number);
    format!("x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"")
}

/// The elements of a drawing. Later elements cover earlier ones.
#[derive(Debug, Clone, Default)]
pub(crate) struct Svg {
    body: String,
}

impl Svg {
    fn push(&mut self, text: &str) {
        self.body.push_str(text);
        self.body.push('\n');
    }

    pub(crate) fn line(&mut self, from: (f64, f64), to: (f64, f64), color: Rgb, width: f64) {
        let [x1, y1, x2, y2, width] = [from.0, from.1, to.0, to.1, width].map(number);
        self.push(&format!(
            "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" stroke=\"{color}\" stroke-width=\"{width}\"/>"
        ));
    }

    pub(crate) fn rect(&mut self, area: Area, paint: Paint) {
        self.push(&format!("<rect {}{}/>", placed(area), paint.attributes()));
    }

    pub(crate) fn circle(&mut self, center: (f64, f64), radius: f64, paint: &str) {
        let [x, y, radius] = [center.0, center.1, radius].map(number);
        self.push(&format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{paint}/>"));
    }

    pub(crate) fn path(&mut self, data: &str, paint: Paint) {
        let round = " stroke-linejoin=\"round\" stroke-linecap=\"round\"";
        self.raw_path(data, &(paint.attributes() + round));
    }

    pub(crate) fn raw_path(&mut self, data: &str, attributes: &str) {
        self.push(&format!("<path d=\"{data}\"{attributes}/>"));
    }

    pub(crate) fn text(&mut self, at: (f64, f64), anchor: Anchor, font: Font, color: Rgb, text: &str) {
        self.set(&format!("x=\"{}\" y=\"{}\"", number(at.0), number(at.1)), anchor, font, color, text);
    }

    /// Text that reads upwards, centred.
    pub(crate) fn text_up(&mut self, at: (f64, f64), font: Font, color: Rgb, text: &str) {
        let place = format!("transform=\"translate({} {}) rotate(-90)\"", number(at.0), number(at.1));
        self.set(&place, Anchor::Middle, font, color, text);
    }

    fn set(&mut self, place: &str, anchor: Anchor, font: Font, color: Rgb, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = if font.bold { " font-weight=\"600\"" } else { "" };
        self.push(&format!(
            "<text {place} font-size=\"{}\"{weight}{anchor} fill=\"{color}\">{}</text>",
            number(font.size),
            text::escape(text)
        ));
    }

    /// Embeds a PNG. `sharp` keeps its pixels square when it is enlarged.
    pub(crate) fn image(&mut self, area: Area, png: &[u8], sharp: bool) {
        let data = base64::engine::general_purpose::STANDARD.encode(png);
        // `optimizeSpeed` is the keyword of SVG 1.1, `pixelated` that of CSS.
        let rendering =
            if sharp { " image-rendering=\"optimizeSpeed\" style=\"image-rendering:pixelated\"" } else { "" };
        self.push(&format!(
            "<image {} preserveAspectRatio=\"none\"{rendering} href=\"data:image/png;base64,{data}\"/>",
            placed(area)
        ));
    }

    /// Opens a group with common attributes, whose title browsers show as a tooltip.
    pub(crate) fn open(&mut self, attributes: &str, title: &str) {
        self.push(&format!("<g{attributes}>"));
        if !title.is_empty() {
            self.push(&format!("<title>{}</title>", text::escape(title)));
        }
    }

    pub(crate) fn close(&mut self) {
        self.push("</g>");
    }

    /// Opens a clipping window. It needs no id, so that a page can contain several figures.
    pub(crate) fn open_window(&mut self, area: Area) {
        let [x, y, w, h] = [area.x, area.y, area.width, area.height].map(number);
        self.push(&format!("<svg {} viewBox=\"{x} {y} {w} {h}\" overflow=\"hidden\">", placed(area)));
    }

    pub(crate) fn close_window(&mut self) {
        self.push("</svg>");
    }

    /// A bar of viridis from the bottom up.
    pub(crate) fn value_bar(&mut self, area: Area) {
        // All figures define the same gradient under this id.
        self.push("<linearGradient id=\"smalti-viridis\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">");
        for i in 0..=17 {
            let t = f64::from(i) / 17.0;
            self.push(&format!("<stop offset=\"{t:.4}\" stop-color=\"{}\"/>", Rgb::viridis(t)));
        }
        self.push("</linearGradient>");
        self.push(&format!("<rect {} fill=\"url(#smalti-viridis)\"/>", placed(area)));
    }

    /// The document, with a white background.
    pub(crate) fn finish(self, width: f64, height: f64, title: &str, description: &str) -> String {
        let (w, h) = (number(width), number(height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             role=\"img\" font-family=\"{}\">\n<title>{}</title>\n<desc>{}</desc>\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            text::FAMILY,
            text::escape(title),
            text::escape(description),
            self.body
        )
    }
}
