//! The layout of a figure: title, legend, panels, colour bar, labels and notes.

use crate::axes::Edges;
use crate::end_labels::EndLabels;
use crate::figure::check_size;
use crate::legend::{draw_entries, entries, rows};
use crate::panel::Panel;
use crate::plot::{Frame, Layer, Panels, Plot};
use crate::scale::Axis;
use crate::shared::{Shared, shared};
use crate::svg::{Anchor, Area, FRAME, INK, SOFT, Svg};
use crate::text::{Font, LABEL, TICK, bold, clean, fit, plain, width, wrap};
use crate::{Figure, FigureError};

const TITLE: Font = bold(22.0);
const NAME: Font = bold(18.0);
const NOTE: Font = plain(14.0);
const MARGIN: f64 = 18.0;
const BAR: f64 = 18.0;

impl Plot {
    /// The figure. A plot without a finite point is drawn empty, with a note that states this.
    ///
    /// # Errors
    /// [`FigureError`] for columns of different length, bad ranges, and sizes without room for the labels.
    pub fn draw(&self) -> Result<Figure, FigureError> {
        let panels = std::slice::from_ref(self);
        Layout { frame: &self.frame, columns: 1, named_panels: false, panels }.draw()
    }
}

impl Panels {
    /// The figure.
    ///
    /// # Errors
    /// As [`Plot::draw`], and [`FigureError::Nothing`] without a panel.
    pub fn draw(&self) -> Result<Figure, FigureError> {
        let columns = self.columns.min(self.panels.len().max(1));
        Layout { frame: &self.frame, columns, named_panels: true, panels: &self.panels }.draw()
    }
}

/// The parts of a figure.
struct Layout<'a> {
    frame: &'a Frame,
    columns: usize,
    /// Whether each panel has its title above it.
    named_panels: bool,
    panels: &'a [Plot],
}

impl Layout<'_> {
    fn draw(&self) -> Result<Figure, FigureError> {
        let (full_width, full_height) = self.frame.size;
        check_size(full_width, full_height)?;
        let first = self.panels.first().ok_or(FigureError::Nothing { what: "panel" })?;
        let shared = shared(first, self.panels)?;
        let mut svg = Svg::default();
        let inner = full_width - 2.0 * MARGIN;

        // Top: title, legend.
        let mut top = MARGIN;
        for line in wrap(&self.frame.title, TITLE, inner, 2) {
            top += TITLE.size * 1.2;
            svg.text((MARGIN, top - 6.0), Anchor::Start, TITLE, INK, &line);
        }
        let legend = if self.frame.legend { entries(self.panels, &shared) } else { Vec::new() };
        if !legend.is_empty() {
            top += 4.0;
        }
        for row in rows(&legend, inner) {
            top += 26.0;
            draw_entries(&mut svg, row, (MARGIN, top - 7.0), inner);
        }
        top += 12.0;

        // Bottom, from below: notes, label, ticks.
        let notes = self.notes(&shared);
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
        let columns = self.columns.max(1);
        let row_count = self.panels.len().div_ceil(columns);
        let widest = |axis: &Axis, count: usize| {
            axis.ticks(count).iter().map(|(_, label)| width(label, TICK)).fold(0.0, f64::max)
        };
        let left = MARGIN + LABEL.size * 1.35 + widest(&shared.y, 10).max(20.0) + 12.0;
        let right = match &shared.values {
            Some(axis) => 22.0 + BAR + 8.0 + widest(axis, 10) + 14.0 + LABEL.size * 1.35 + MARGIN - 6.0,
            None => MARGIN.max(0.5 * widest(&shared.x, 10) + 4.0),
        };
        let labels = if self.frame.end_labels { EndLabels::of(first, &shared) } else { EndLabels::default() };
        let right = right.max(labels.width().min(0.45 * full_width));
        let head = if self.named_panels { NAME.size * 1.55 } else { 0.0 };
        let (gap_x, gap_y) = (24.0, 16.0);
        let panel_width =
            ((full_width - left - right - (columns - 1) as f64 * gap_x) / columns as f64).floor();
        let panel_height =
            ((bottom - top - (row_count.max(1) - 1) as f64 * gap_y) / row_count.max(1) as f64 - head).floor();
        if panel_width < 60.0 || panel_height < 60.0 {
            let reason = format!("leaves no room for {} panels and their labels", self.panels.len());
            return Err(FigureError::Size { width: full_width, height: full_height, reason });
        }
        let area_of = |i: usize| Area {
            x: left.round() + (i % columns) as f64 * (panel_width + gap_x),
            y: (top + head + (i / columns) as f64 * (panel_height + gap_y + head)).round(),
            width: panel_width,
            height: panel_height,
        };
        for (i, plot) in self.panels.iter().enumerate() {
            let area = area_of(i);
            if self.named_panels {
                let name = fit(&clean(&plot.frame.title), NAME, area.width);
                svg.text((area.x, area.y - 9.0), Anchor::Start, NAME, INK, &name);
            }
            let edges = Edges { left: i % columns == 0, bottom: i + columns >= self.panels.len() };
            Panel { plot, area, shared: &shared, edges }.draw(&mut svg)?;
        }
        labels.draw(&mut svg, area_of(0), right);
        let last = area_of((row_count.max(1) - 1) * columns);
        let middle_x = left + 0.5 * (full_width - left - right);
        let (span, end) = (full_width - left - right, last.y + last.height);
        let x_label = fit(&clean(&first.x.label), LABEL, span);
        svg.text((middle_x, x_label_at), Anchor::Middle, LABEL, INK, &x_label);
        let middle_y = 0.5 * (area_of(0).y + end);
        let y_label = fit(&clean(&first.y.label), LABEL, full_height - 2.0 * MARGIN);
        svg.text_up((MARGIN + LABEL.size * 0.8, middle_y), LABEL, INK, &y_label);
        if let Some(values) = &shared.values {
            let x = (full_width - right + 22.0).round();
            let height = (end - area_of(0).y).min(520.0);
            let bar = Area { x, y: (middle_y - 0.5 * height).round(), width: BAR, height };
            draw_values(&mut svg, bar, values, shared.beyond, &first.values.label, full_width - MARGIN);
        }
        let title = match self.frame.title.as_str() {
            "" => format!("{} against {}", first.y.label, first.x.label),
            title => title.to_owned(),
        };
        let description = self.description(first, shared.picture_bytes.is_some(), &notes);
        Figure::new(svg, full_width, full_height, &title, &description)
    }

    /// The small print: the note of the caller, and how many values are not drawn.
    fn notes(&self, shared: &Shared) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.frame.note.is_empty() {
            notes.push(self.frame.note.clone());
        }
        let (mut all, mut holes, mut beyond, mut noun) = (0usize, 0usize, 0usize, "marks");
        let inside = |axis: &Axis, v: f64| axis.place(v).map(|t| (-1e-9..=1.0 + 1e-9).contains(&t));
        for layer in self.panels.iter().flat_map(|p| &p.layers) {
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
                    noun = "values";
                    all += h.values.len();
                    holes += h.values.iter().filter(|v| !v.is_finite()).count();
                    beyond += h.values.iter().filter(|v| inside(&shared.x, **v) == Some(false)).count();
                }
                Layer::Line(_) => {}
            }
        }
        let missing = [(holes, "have no place on the axes"), (beyond, "lie beyond the axes")];
        let missing = missing.iter().filter(|(count, _)| *count > 0);
        let missing: Vec<_> = missing.map(|(count, why)| format!("{count} of {all} {noun} {why}")).collect();
        if !missing.is_empty() {
            notes.push(format!("Not drawn: {}.", missing.join("; ")));
        }
        notes
    }

    /// The figure in words.
    fn description(&self, first: &Plot, drawn_as_picture: bool, notes: &[String]) -> String {
        let mut sentences = vec![format!("{} against {}.", first.y.label, first.x.label)];
        for plot in self.panels {
            let series: Vec<String> = plot.layers.iter().map(described).collect();
            let series = if series.is_empty() { "empty".to_owned() } else { series.join(", ") };
            let name = &plot.frame.title;
            sentences.push(if self.named_panels { format!("{name}: {series}.") } else { series + "." });
        }
        let mut layers = self.panels.iter().flat_map(|p| &p.layers);
        if layers.any(|l| matches!(l, Layer::Points(p) if p.values.is_some())) {
            sentences.push(format!("Colour shows {}.", first.values.label));
        }
        if drawn_as_picture {
            sentences.push("The points are drawn as a picture.".to_owned());
        }
        sentences.extend_from_slice(notes);
        sentences.join(" ")
    }
}

/// A series in words.
fn described(layer: &Layer) -> String {
    match layer {
        Layer::Points(p) => format!("{} ({} points)", p.name, p.x.len()),
        Layer::Line(l) => format!("{} (line)", l.name),
        Layer::Histogram(h) => format!("{} (histogram of {} values)", h.name, h.values.len()),
    }
}

fn draw_values(svg: &mut Svg, bar: Area, axis: &Axis, beyond: (bool, bool), label: &str, right: f64) {
    svg.value_bar(bar);
    for (value, tick) in axis.ticks((bar.height / 60.0) as usize + 1) {
        let Some(t) = axis.place(value) else { continue };
        let y = bar.y + bar.height * (1.0 - t);
        svg.line((bar.x + bar.width, y), (bar.x + bar.width + 5.0, y), FRAME, 1.0);
        // The colour at an end may also stand for all values beyond it.
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
