//! Where title, legend, panels, colour bar and labels stand.

use crate::backend::Canvas;
use crate::figure::check_size;
use crate::legend::{Entry, draw_entries, entries, rows};
use crate::panel::{Edges, Panel};
use crate::plot::{Layer, Plot};
use crate::scale::Axis;
use crate::shared::{Shared, shared};
use crate::svg::{Anchor, Area, FRAME, INK, SOFT, Svg};
use crate::text::{Font, bold, clean, fit, plain, width, wrap};
use crate::{Figure, FigureError};

pub(crate) const TICK: Font = plain(17.0);
pub(crate) const LABEL: Font = plain(19.0);
pub(crate) const TITLE: Font = bold(22.0);
pub(crate) const NAME: Font = bold(18.0);
pub(crate) const NOTE: Font = plain(14.0);
const MARGIN: f64 = 18.0;
const BAR: f64 = 18.0;

pub(crate) struct Layout<'a> {
    pub(crate) title: &'a str,
    pub(crate) note: &'a str,
    pub(crate) description: &'a str,
    pub(crate) size: (f64, f64),
    pub(crate) columns: usize,
    pub(crate) legend: bool,
    pub(crate) named_panels: bool,
    pub(crate) panels: &'a [Plot],
}

pub(crate) fn layout(asked: &Layout<'_>) -> Result<Figure, FigureError> {
    let (full_width, full_height) = asked.size;
    check_size(full_width, full_height)?;
    let first = asked.panels.first().ok_or(FigureError::Nothing { what: "panel" })?;
    let shared = shared(first, asked.panels)?;
    let canvas = Canvas::default();
    let mut svg = canvas.borrow_mut();
    let inner = full_width - 2.0 * MARGIN;

    // Top: title, legend.
    let mut top = MARGIN;
    for line in wrap(asked.title, TITLE, inner, 2) {
        top += TITLE.size * 1.2;
        svg.text((MARGIN, top - 6.0), Anchor::Start, TITLE, INK, &line);
    }
    let legend = if asked.legend { entries(asked.panels, &shared) } else { Vec::new() };
    if !legend.is_empty() {
        top = draw_legend(&mut svg, &legend, top + 4.0, inner);
    }
    top += 12.0;

    // Bottom, from below: notes, label, ticks.
    let notes = notes(asked, &shared);
    let mut bottom = full_height - MARGIN + 4.0;
    let mut lines: Vec<String> = notes.iter().flat_map(|note| wrap(note, NOTE, inner, 4)).collect();
    lines.truncate(8);
    for line in lines.iter().rev() {
        svg.text((MARGIN, bottom - 4.0), Anchor::Start, NOTE, SOFT, line);
        bottom -= NOTE.size * 1.3;
    }
    if !lines.is_empty() {
        bottom -= 6.0;
    }
    let x_label_at = bottom - 6.0;
    bottom -= LABEL.size * 1.2 + 8.0;
    bottom -= TICK.size + 10.0 + if first.wavelengths { 10.0 } else { 0.0 };

    // The widest tick label sets the left margin; ticks depend on the height, so it is estimated with most of them.
    let columns = asked.columns.max(1);
    let row_count = asked.panels.len().div_ceil(columns);
    let widest = |axis: &Axis, count: usize| {
        axis.ticks(count).iter().map(|(_, label)| width(label, TICK)).fold(0.0, f64::max)
    };
    let left = MARGIN + LABEL.size * 1.35 + widest(&shared.y, 10).max(20.0) + 12.0;
    let right = match &shared.values {
        Some(axis) => 22.0 + BAR + 8.0 + widest(axis, 10) + 14.0 + LABEL.size * 1.35 + MARGIN - 6.0,
        None => MARGIN.max(0.5 * widest(&shared.x, 10) + 4.0),
    };
    let head = if asked.named_panels { NAME.size * 1.55 } else { 0.0 };
    let (gap_x, gap_y) = (24.0, 16.0);
    let panel_width = ((full_width - left - right - (columns - 1) as f64 * gap_x) / columns as f64).floor();
    let panel_height =
        ((bottom - top - (row_count.max(1) - 1) as f64 * gap_y) / row_count.max(1) as f64 - head).floor();
    if panel_width < 60.0 || panel_height < 60.0 {
        let reason = format!("leaves no room for {} panels and their labels", asked.panels.len());
        return Err(FigureError::Size { width: full_width, height: full_height, reason });
    }
    let area_of = |i: usize| Area {
        x: left.round() + (i % columns) as f64 * (panel_width + gap_x),
        y: (top + head + (i / columns) as f64 * (panel_height + gap_y + head)).round(),
        width: panel_width,
        height: panel_height,
    };
    for (i, plot) in asked.panels.iter().enumerate() {
        let area = area_of(i);
        if asked.named_panels {
            let name = fit(&clean(&plot.title), NAME, area.width);
            svg.text((area.x, area.y - 9.0), Anchor::Start, NAME, INK, &name);
        }
        let edges = Edges { left: i % columns == 0, bottom: i + columns >= asked.panels.len() };
        drop(svg);
        Panel { plot, area, shared: &shared, edges }.draw(&canvas)?;
        svg = canvas.borrow_mut();
    }
    let last = area_of((row_count.max(1) - 1) * columns);
    let middle_x = left + 0.5 * (full_width - left - right);
    let (span, end) = (full_width - left - right, last.y + last.height);
    svg.text((middle_x, x_label_at), Anchor::Middle, LABEL, INK, &fit(&clean(&first.x.label), LABEL, span));
    let middle_y = 0.5 * (area_of(0).y + end);
    let y_label = fit(&clean(&first.y.label), LABEL, full_height - 2.0 * MARGIN);
    svg.text_up((MARGIN + LABEL.size * 0.8, middle_y), LABEL, INK, &y_label);
    if let Some(values) = &shared.values {
        let x = (full_width - right + 22.0).round();
        let height = (end - area_of(0).y).min(520.0);
        let bar = Area { x, y: (middle_y - 0.5 * height).round(), width: BAR, height };
        draw_values(&mut svg, bar, values, shared.beyond, &first.values.label, full_width - MARGIN);
    }
    let (title, description) =
        (title(asked, first), described(asked, first, shared.picture_bytes.is_some(), &notes));
    drop(svg);
    Figure::new(canvas.take(), full_width, full_height, &title, &description)
}

/// The legend, in rows from the left; returns where it ends.
fn draw_legend(svg: &mut Svg, legend: &[Entry], mut top: f64, inner: f64) -> f64 {
    for row in rows(legend, inner) {
        top += 26.0;
        draw_entries(svg, row, (MARGIN, top - 7.0), inner);
    }
    top
}

fn draw_values(svg: &mut Svg, bar: Area, axis: &Axis, beyond: (bool, bool), label: &str, right: f64) {
    svg.value_bar(bar);
    for (value, tick) in axis.ticks((bar.height / 60.0) as usize + 1) {
        let Some(t) = axis.place(value) else { continue };
        let y = bar.y + bar.height * (1.0 - t);
        svg.line((bar.x + bar.width, y), (bar.x + bar.width + 5.0, y), FRAME, 1.0);
        // A value at an end that stands for all beyond it says so.
        let sign = match beyond {
            (true, _) if t < 1e-6 => "≤ ",
            (_, true) if t > 1.0 - 1e-6 => "≥ ",
            _ => "",
        };
        let text = format!("{sign}{tick}");
        svg.text((bar.x + bar.width + 9.0, y + TICK.size * 0.36), Anchor::Start, TICK, INK, &text);
    }
    let label = fit(&clean(label), LABEL, bar.height);
    svg.text_up((right, bar.y + 0.5 * bar.height), LABEL, INK, &label);
}

/// What is said in small print: what the caller says, what is not drawn, how much is drawn as a picture.
fn notes(asked: &Layout<'_>, shared: &Shared) -> Vec<String> {
    let mut notes = Vec::new();
    if !asked.note.is_empty() {
        notes.push(asked.note.to_owned());
    }
    let (mut all, mut holes, mut beyond) = (0usize, 0usize, 0usize);
    let inside = |axis: &Axis, v: f64| axis.place(v).map(|t| (-1e-9..=1.0 + 1e-9).contains(&t));
    for layer in asked.panels.iter().flat_map(|p| &p.layers) {
        match layer {
            Layer::Points(p) => {
                all += p.x.len();
                for (i, (x, y)) in p.x.iter().zip(&p.y).enumerate() {
                    let value = p.values.as_ref().and_then(|v| v.get(i)).copied().unwrap_or(0.0);
                    match (inside(&shared.x, *x), inside(&shared.y, *y)) {
                        (Some(_), Some(_)) if value.is_nan() => holes += 1,
                        (Some(a), Some(b)) => beyond += usize::from(!(a && b)),
                        _ => holes += 1,
                    }
                }
            }
            Layer::Histogram(h) => {
                all += h.values.len();
                holes += h.values.iter().filter(|v| !v.is_finite()).count();
                beyond += h.values.iter().filter(|v| inside(&shared.x, **v) == Some(false)).count();
            }
            Layer::Line(_) => {}
        }
    }
    let mut missing = Vec::new();
    if holes > 0 {
        missing.push(format!("{holes} of {all} have no place on the axes"));
    }
    if beyond > 0 {
        missing.push(format!("{beyond} of {all} lie beyond the axes"));
    }
    if !missing.is_empty() {
        notes.push(format!("Not drawn: {}.", missing.join("; ")));
    }
    notes
}

fn title(asked: &Layout<'_>, first: &Plot) -> String {
    if asked.title.is_empty() {
        format!("{} against {}", first.y.label, first.x.label)
    } else {
        asked.title.to_owned()
    }
}

/// The figure in words.
fn described(asked: &Layout<'_>, first: &Plot, drawn_as_picture: bool, notes: &[String]) -> String {
    let mut out = if asked.description.is_empty() {
        let mut out = format!("{} against {}.", first.y.label, first.x.label);
        for plot in asked.panels {
            let series: Vec<String> = plot
                .layers
                .iter()
                .map(|layer| match layer {
                    Layer::Points(p) => format!("{} ({} points)", p.name, p.x.len()),
                    Layer::Line(l) => format!("{} (line)", l.name),
                    Layer::Histogram(h) => format!("{} (histogram of {} values)", h.name, h.values.len()),
                })
                .collect();
            let name = if asked.named_panels { format!(" {}:", plot.title) } else { String::new() };
            out.push_str(&format!(
                "{name} {}.",
                if series.is_empty() { "empty".to_owned() } else { series.join(", ") }
            ));
        }
        if asked
            .panels
            .iter()
            .flat_map(|p| &p.layers)
            .any(|l| matches!(l, Layer::Points(p) if p.values.is_some()))
        {
            out.push_str(&format!(" Colour shows {}.", first.values.label));
        }
        out
    } else {
        asked.description.to_owned()
    };
    if drawn_as_picture {
        out.push_str(" The points are drawn as a picture.");
    }
    for note in notes {
        out.push(' ');
        out.push_str(note);
    }
    out
}
