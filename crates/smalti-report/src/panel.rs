//! One panel: grid, histograms, clouds, lines, marks, axes.

use crate::FigureError;
use crate::cloud::{Dot, draw_cloud};
use crate::color::Rgb;
use crate::figure::encode;
use crate::layers::{Corner, Histogram, Line, Points, Symbol};
use crate::layout::{LABEL, TICK};
use crate::plot::{Layer, Plot};
use crate::shared::{INTERVAL_SHARE, Shared, counts};
use crate::svg::{Anchor, Area, FRAME, GRID, INK, Paint, SOFT, Svg, path_of};
use crate::text::width;

/// Which tick labels a panel carries.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edges {
    pub(crate) left: bool,
    pub(crate) bottom: bool,
}

pub(crate) struct Panel<'a> {
    pub(crate) plot: &'a Plot,
    pub(crate) area: Area,
    pub(crate) shared: &'a Shared,
    pub(crate) edges: Edges,
}

/// The colour of a series: its own, or that of its name.
pub(crate) fn series_color(shared: &Shared, name: &str, own: Option<Rgb>) -> Rgb {
    let named = || shared.colors.iter().find(|(n, _)| n == name).map(|(_, color)| *color);
    own.or_else(named).unwrap_or(INK)
}

/// A symbol; marks have a white edge.
pub(crate) fn draw_symbol(
    svg: &mut Svg,
    symbol: Symbol,
    at: (f64, f64),
    radius: f64,
    color: Rgb,
    edge: bool,
) {
    let stroke = edge.then_some((Rgb(255, 255, 255), 1.6));
    let paint = Paint { fill: Some((color, 1.0)), stroke, dashed: false };
    match symbol.outline(radius) {
        None => svg.circle(at, radius, &Svg::paint(paint)),
        Some(corners) => {
            let corners: Vec<(f64, f64)> = corners.into_iter().map(|(x, y)| (at.0 + x, at.1 + y)).collect();
            svg.path(&path_of(&corners, true), paint);
        }
    }
}

impl Panel<'_> {
    pub(crate) fn draw(&self, svg: &mut Svg) -> Result<(), FigureError> {
        let area = self.area;
        if self.shared.empty {
            svg.rect(
                area,
                Paint { fill: Some((Rgb(250, 250, 250), 1.0)), stroke: Some((GRID, 1.0)), dashed: false },
            );
            let middle = (area.x + 0.5 * area.width, area.y + 0.5 * area.height);
            svg.text(middle, Anchor::Middle, LABEL, SOFT, "no data");
            return Ok(());
        }
        self.draw_axes(svg);
        svg.open_window(Area {
            x: area.x - 1.0,
            y: area.y - 1.0,
            width: area.width + 2.0,
            height: area.height + 2.0,
        });
        let mut interval_row = 0;
        for layer in &self.plot.layers {
            if let Layer::Histogram(histogram) = layer {
                self.draw_histogram(svg, histogram, &mut interval_row);
            }
        }
        self.draw_clouds(svg)?;
        for layer in &self.plot.layers {
            if let Layer::Line(line) = layer {
                self.draw_line(svg, line);
            }
        }
        for layer in &self.plot.layers {
            if let Layer::Points(points) = layer
                && points.marks
            {
                self.draw_marks(svg, points);
            }
        }
        svg.close_window();
        if self.plot.wavelengths {
            self.draw_wavelengths(svg)?;
        }
        Ok(())
    }

    fn x(&self, value: f64) -> Option<f64> {
        // Far outside is as good as a little outside, and keeps coordinates small.
        self.shared.x.place(value).map(|t| self.area.x + t.clamp(-2.0, 3.0) * self.area.width)
    }

    fn y(&self, value: f64) -> Option<f64> {
        self.shared.y.place(value).map(|t| self.area.y + (1.0 - t.clamp(-2.0, 3.0)) * self.area.height)
    }

    fn draw_axes(&self, svg: &mut Svg) {
        let Area { x, y, width: w, height: h } = self.area;
        let x_count = ((w / 95.0) as usize).clamp(2, 12);
        let mut x_ticks = self.shared.x.ticks(x_count);
        // Labels that would touch: every other tick.
        let widest = x_ticks.iter().map(|(_, l)| width(l, TICK)).fold(0.0, f64::max);
        if x_ticks.len() as f64 * (widest + 14.0) > w + widest {
            x_ticks = self.shared.x.ticks(x_count / 2);
        }
        let y_ticks = self.shared.y.ticks(((h / 62.0) as usize).clamp(2, 12));
        for at in x_ticks.iter().filter_map(|(v, _)| self.x(*v)) {
            svg.line((at, y), (at, y + h), GRID, 1.0);
        }
        for at in y_ticks.iter().filter_map(|(v, _)| self.y(*v)) {
            svg.line((x, at), (x + w, at), GRID, 1.0);
        }
        svg.path(&path_of(&[(x, y), (x, y + h), (x + w, y + h)], false), Paint::stroke(FRAME, 1.4));
        let strip = if self.plot.wavelengths { 11.0 } else { 0.0 };
        for (value, label) in &x_ticks {
            let Some(at) = self.x(*value) else { continue };
            svg.line((at, y + h), (at, y + h + 5.0), FRAME, 1.2);
            if self.edges.bottom {
                svg.text((at, y + h + strip + 9.0 + TICK.size), Anchor::Middle, TICK, INK, label);
            }
        }
        for (value, label) in &y_ticks {
            let Some(at) = self.y(*value) else { continue };
            svg.line((x - 5.0, at), (x, at), FRAME, 1.2);
            if self.edges.left {
                svg.text((x - 10.0, at + TICK.size * 0.36), Anchor::End, TICK, INK, label);
            }
        }
    }

    /// The spectrum as it looks, under the axis of wavelengths.
    fn draw_wavelengths(&self, svg: &mut Svg) -> Result<(), FigureError> {
        let area = Area { y: self.area.y + self.area.height + 5.0, height: 9.0, ..self.area };
        let (low, high) = (self.shared.x.low, self.shared.x.high);
        let columns = area.width as usize;
        let row: Vec<u8> = (0..columns)
            .map(|i| Rgb::of_wavelength(low + (i as f64 + 0.5) / columns as f64 * (high - low)))
            .flat_map(|c| [c.0, c.1, c.2])
            .collect();
        let png = encode(&row.repeat(2), columns as u32, 2, png::ColorType::Rgb)?;
        svg.image(area, &png, true);
        Ok(())
    }

    fn draw_histogram(&self, svg: &mut Svg, histogram: &Histogram, interval_row: &mut usize) {
        let Some((start, bin)) = self.shared.bin else { return };
        let color = series_color(self.shared, &histogram.name, histogram.color);
        let paint = Paint { fill: Some((color, 0.22)), stroke: Some((color, 1.8)), dashed: false };
        svg.open("", &histogram.name);
        // Each run of bins that hold something is an outline.
        let mut points: Vec<(f64, f64)> = Vec::new();
        for (i, count) in counts(&histogram.values, start, bin).into_iter().chain([0]).enumerate() {
            let (Some(x), Some(y)) = (self.x(start + bin * i as f64), self.y(count as f64)) else { continue };
            let floor = self.area.y + self.area.height;
            if count > 0 {
                let before = points.last().map_or(floor, |p| p.1);
                points.extend([(x, before), (x, y)]);
            } else if let Some(last) = points.last().copied() {
                points.extend([(x, last.1), (x, floor)]);
                svg.path(&path_of(&points, false), paint);
                points.clear();
            }
        }
        if let Some((low, center, high)) = histogram.interval {
            let y = self.area.y + (*interval_row as f64 + 0.6) * INTERVAL_SHARE * self.area.height;
            *interval_row += 1;
            if let [Some(a), Some(m), Some(b)] = [low, center, high].map(|v| self.x(v)) {
                svg.line((a, y), (b, y), color, 2.6);
                [a, b].into_iter().for_each(|end| svg.line((end, y - 7.0), (end, y + 7.0), color, 2.6));
                draw_symbol(svg, Symbol::Circle, (m, y), 6.5, color, true);
            }
        }
        svg.close();
    }

    fn draw_clouds(&self, svg: &mut Svg) -> Result<(), FigureError> {
        let mut dots = Vec::new();
        for (series, layer) in self.plot.layers.iter().enumerate() {
            let Layer::Points(points) = layer else { continue };
            if points.marks {
                continue;
            }
            let color = series_color(self.shared, &points.name, points.color);
            let radius = points.radius.unwrap_or(match self.shared.crowd {
                0..=300 => 4.6,
                301..=1500 => 3.6,
                1501..=6000 => 2.7,
                6001..=30_000 => 2.0,
                _ => 1.5,
            });
            for (i, (x, y)) in points.x.iter().zip(&points.y).enumerate() {
                let (Some(x), Some(y)) = (self.x(*x), self.y(*y)) else { continue };
                let Some(color) = self.dot_color(points, i, color) else { continue };
                dots.push(Dot {
                    x,
                    y,
                    radius: radius.clamp(0.2, 50.0),
                    color,
                    symbol: points.symbol,
                    series,
                    index: i,
                });
            }
        }
        let opacity = match (self.shared.values.is_some(), self.shared.crowd) {
            (_, 0..=300) => 0.85,
            (true, _) => 0.8,
            (false, 301..=1500) => 0.6,
            (false, 1501..=30_000) => 0.45,
            (false, _) => 0.35,
        };
        draw_cloud(svg, self.area, dots, opacity, self.shared.picture_bytes)
    }

    /// The colour of a point; none where its value is NaN.
    fn dot_color(&self, points: &Points, index: usize, series: Rgb) -> Option<Rgb> {
        let Some(values) = &points.values else { return Some(series) };
        let value = values.get(index).copied().filter(|v| !v.is_nan())?;
        let axis = self.shared.values.as_ref()?;
        // What has no place lies beyond the low end: not positive on a logarithmic bar.
        Some(Rgb::viridis(axis.place(value).unwrap_or(if value > axis.high { 1.0 } else { 0.0 })))
    }

    fn draw_line(&self, svg: &mut Svg, line: &Line) {
        let color = series_color(self.shared, &line.name, line.color);
        svg.open("", &line.name);
        let mut run: Vec<(f64, f64)> = Vec::new();
        let places = line.x.iter().zip(&line.y).map(|(x, y)| Some((self.x(*x)?, self.y(*y)?)));
        // Each run of points with a place is a path.
        for point in places.chain([None]) {
            match point {
                Some(point) => {
                    match (line.corner, run.last().copied()) {
                        (Corner::XFirst, Some(last)) => run.push((point.0, last.1)),
                        (Corner::YFirst, Some(last)) => run.push((last.0, point.1)),
                        _ => {}
                    }
                    run.push(point);
                }
                None => {
                    self.draw_run(svg, line, color, &run);
                    run.clear();
                }
            }
        }
        svg.close();
    }

    fn draw_run(&self, svg: &mut Svg, line: &Line, color: Rgb, run: &[(f64, f64)]) {
        let (Some(first), Some(last)) = (run.first(), run.last()) else { return };
        if line.filled {
            let floor = self.area.y + self.area.height;
            let outline: Vec<(f64, f64)> =
                [(first.0, floor)].iter().chain(run).copied().chain([(last.0, floor)]).collect();
            svg.path(
                &path_of(&outline, true),
                Paint { fill: Some((color, 0.16)), stroke: None, dashed: false },
            );
        }
        let paint = Paint { dashed: line.dashed, ..Paint::stroke(color, line.width.clamp(0.2, 30.0)) };
        svg.path(&path_of(run, false), paint);
    }

    fn draw_marks(&self, svg: &mut Svg, points: &Points) {
        let own = series_color(self.shared, &points.name, points.color);
        let white = Rgb(255, 255, 255);
        svg.open("", &points.name);
        for (i, (x, y)) in points.x.iter().zip(&points.y).enumerate() {
            let (Some(x), Some(y), Some(color)) = (self.x(*x), self.y(*y), self.dot_color(points, i, own))
            else {
                continue;
            };
            let bars = [
                points.x_intervals.as_ref().and_then(|v| v.get(i)).map(|v| (v, true)),
                points.y_intervals.as_ref().and_then(|v| v.get(i)).map(|v| (v, false)),
            ];
            for (color, thickness) in [(white, 5.0), (color, 2.2)] {
                for ((low, high), along_x) in bars.into_iter().flatten() {
                    // An endless interval leaves the panel.
                    let end = |v: f64, out: f64| {
                        if v.is_infinite() {
                            Some(out)
                        } else if along_x {
                            self.x(v)
                        } else {
                            self.y(v)
                        }
                    };
                    let (start, stop) = match along_x {
                        true => {
                            (end(*low, self.area.x - 20.0), end(*high, self.area.x + self.area.width + 20.0))
                        }
                        false => {
                            (end(*low, self.area.y + self.area.height + 20.0), end(*high, self.area.y - 20.0))
                        }
                    };
                    let (Some(start), Some(stop)) = (start, stop) else { continue };
                    let at = |along: f64, across: f64| {
                        if along_x { (along, y + across) } else { (x + across, along) }
                    };
                    svg.line(at(start, 0.0), at(stop, 0.0), color, thickness);
                    [start, stop]
                        .into_iter()
                        .for_each(|e| svg.line(at(e, -5.0), at(e, 5.0), color, thickness));
                }
            }
            draw_symbol(
                svg,
                points.symbol,
                (x, y),
                points.radius.unwrap_or(7.5).clamp(0.2, 50.0),
                color,
                true,
            );
        }
        svg.close();
    }
}
