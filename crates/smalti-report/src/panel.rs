//! One panel: axes, histograms, clouds of points, lines, marks.

use crate::FigureError;
use crate::axes::{Edges, draw_axes, draw_spectrum};
use crate::cloud::{Dot, draw_cloud};
use crate::color::Rgb;
use crate::layers::{Corner, Histogram, Line, Points, Symbol};
use crate::plot::{Layer, Plot};
use crate::scale::Axis;
use crate::shared::{INTERVAL_SHARE, Shared, counts};
use crate::svg::{Anchor, Area, GRID, INK, Paint, SOFT, Svg, path_of};
use crate::text::LABEL;

const WHITE: Rgb = Rgb(255, 255, 255);

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
    let paint = Paint { stroke: edge.then_some((WHITE, 1.6)), ..Paint::fill(color, 1.0) };
    match symbol.outline(at, radius) {
        None => svg.circle(at, radius, &paint.attributes()),
        Some(corners) => svg.path(&path_of(&corners, true), paint),
    }
}

/// A bar with caps, which extend by `cap` to both sides of its ends.
fn draw_bar(svg: &mut Svg, ends: [(f64, f64); 2], cap: (f64, f64), color: Rgb, width: f64) {
    svg.line(ends[0], ends[1], color, width);
    for (x, y) in ends {
        svg.line((x - cap.0, y - cap.1), (x + cap.0, y + cap.1), color, width);
    }
}

/// The head of an arrow at the end of a line, no longer than its last segment.
fn draw_arrowhead(svg: &mut Svg, run: &[(f64, f64)], color: Rgb, width: f64) {
    let [.., (x0, y0), (x1, y1)] = *run else { return };
    let (dx, dy) = (x1 - x0, y1 - y0);
    let length = dx.hypot(dy);
    if length < 1.0 {
        return;
    }
    let long = (4.0 * width).min(length);
    let (ux, uy) = (dx / length * long, dy / length * long);
    let corner = |side: f64| (x1 - ux - 0.45 * side * uy, y1 - uy + 0.45 * side * ux);
    svg.path(&path_of(&[(x1, y1), corner(1.0), corner(-1.0)], true), Paint::fill(color, 1.0));
}

impl Panel<'_> {
    pub(crate) fn draw(&self, svg: &mut Svg) -> Result<(), FigureError> {
        let Area { x, y, width, height } = self.area;
        if self.shared.empty {
            svg.rect(self.area, Paint { stroke: Some((GRID, 1.0)), ..Paint::fill(Rgb(250, 250, 250), 1.0) });
            svg.text((x + 0.5 * width, y + 0.5 * height), Anchor::Middle, LABEL, SOFT, "no data");
            return Ok(());
        }
        let wavelengths = self.plot.wavelengths;
        let across = (&self.shared.x, &self.plot.x_ticks[..]);
        draw_axes(svg, self.area, across, &self.shared.y, self.edges, wavelengths);
        svg.open_window(Area { x: x - 1.0, y: y - 1.0, width: width + 2.0, height: height + 2.0 });
        let mut interval_row = 0;
        for layer in &self.plot.layers {
            if let Layer::Histogram(histogram) = layer {
                self.draw_histogram(svg, histogram, &mut interval_row);
            }
        }
        self.draw_clouds(svg)?;
        self.draw_lines(svg, |line| !line.arrow);
        for layer in &self.plot.layers {
            if let Layer::Points(points) = layer
                && points.marks
            {
                self.draw_marks(svg, points);
            }
        }
        // Arrows may be shorter than the marks that they begin at.
        self.draw_lines(svg, |line| line.arrow);
        svg.close_window();
        if wavelengths {
            draw_spectrum(svg, self.area, &self.shared.x)?;
        }
        Ok(())
    }

    /// The pixel of shares of the two axes. Far beyond the panel, which the window cuts, coordinates are limited.
    fn pixel(&self, x: f64, y: f64) -> (f64, f64) {
        let [x, y] = [x, 1.0 - y].map(|share| share.clamp(-2.0, 3.0));
        (self.area.x + self.area.width * x, self.area.y + self.area.height * y)
    }

    /// The pixel of a point; `None` where the axes have no place for it.
    fn place(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        Some(self.pixel(self.shared.x.place(x)?, self.shared.y.place(y)?))
    }

    fn draw_histogram(&self, svg: &mut Svg, histogram: &Histogram, interval_row: &mut usize) {
        let Some((start, bin)) = self.shared.bin else { return };
        let color = series_color(self.shared, &histogram.name, histogram.color);
        svg.open("", &histogram.name);
        // Each run of bins that hold something is an outline.
        let mut steps: Vec<(f64, f64)> = Vec::new();
        for (i, count) in counts(&histogram.values, start, bin).into_iter().chain([0]).enumerate() {
            let edge = start + bin * i as f64;
            let Some((x, floor)) = self.place(edge, self.shared.y.low) else { continue };
            if count > 0 {
                let Some((_, top)) = self.place(edge, count as f64) else { continue };
                steps.extend([(x, steps.last().map_or(floor, |p| p.1)), (x, top)]);
            } else if let Some(last) = steps.last().copied() {
                steps.extend([(x, last.1), (x, floor)]);
                svg.raw_path(&path_of(&steps, true), &Paint::fill(color, 0.22).attributes());
                svg.path(&path_of(&steps, false), Paint::stroke(color, 1.8));
                steps.clear();
            }
        }
        if let Some((low, center, high)) = histogram.interval {
            let y = 1.0 - (*interval_row as f64 + 0.6) * INTERVAL_SHARE;
            *interval_row += 1;
            if let [Some(low), Some(center), Some(high)] = [low, center, high].map(|v| self.shared.x.place(v))
            {
                draw_bar(svg, [self.pixel(low, y), self.pixel(high, y)], (0.0, 7.0), color, 2.6);
                draw_symbol(svg, Symbol::Circle, self.pixel(center, y), 6.5, color, true);
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
            let radius = radius.clamp(0.2, 50.0);
            for (index, (x, y)) in points.x.iter().zip(&points.y).enumerate() {
                let Some((x, y)) = self.place(*x, *y) else { continue };
                let Some(color) = self.dot_color(points, index, color) else { continue };
                dots.push(Dot { x, y, radius, color, symbol: points.symbol, series, index });
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
        // A value that a logarithmic bar has no place for is not positive and lies below its low end.
        Some(Rgb::viridis(axis.place(value).unwrap_or(if value > axis.high { 1.0 } else { 0.0 })))
    }

    fn draw_lines(&self, svg: &mut Svg, which: impl Fn(&Line) -> bool) {
        for layer in &self.plot.layers {
            if let Layer::Line(line) = layer
                && which(line)
            {
                self.draw_line(svg, line);
            }
        }
    }

    fn draw_line(&self, svg: &mut Svg, line: &Line) {
        let color = series_color(self.shared, &line.name, line.color);
        svg.open("", &line.name);
        let mut run: Vec<(f64, f64)> = Vec::new();
        let places = line.x.iter().zip(&line.y).map(|(x, y)| self.place(*x, *y));
        // Each run of points with a place is a path.
        for place in places.chain([None]) {
            let Some(at) = place else {
                self.draw_run(svg, line, color, std::mem::take(&mut run));
                continue;
            };
            if let (Corner::YFirst, Some(last)) = (line.corner, run.last()) {
                run.push((last.0, at.1));
            }
            run.push(at);
        }
        svg.close();
    }

    fn draw_run(&self, svg: &mut Svg, line: &Line, color: Rgb, mut run: Vec<(f64, f64)>) {
        let (Some(first), Some(last)) = (run.first().copied(), run.last().copied()) else { return };
        let outline = path_of(&run, false);
        let end = run.len();
        if line.filled {
            let floor = self.area.y + self.area.height;
            run.extend([(last.0, floor), (first.0, floor)]);
            svg.raw_path(&path_of(&run, true), &Paint::fill(color, 0.16).attributes());
        }
        let width = line.width.clamp(0.2, 30.0);
        svg.path(&outline, Paint { dashed: line.dashed, ..Paint::stroke(color, width) });
        if line.arrow {
            draw_arrowhead(svg, run.get(..end).unwrap_or_default(), color, width);
        }
    }

    fn draw_marks(&self, svg: &mut Svg, points: &Points) {
        let own = series_color(self.shared, &points.name, points.color);
        svg.open("", &points.name);
        for (i, (x, y)) in points.x.iter().zip(&points.y).enumerate() {
            let (Some(x), Some(y)) = (self.shared.x.place(*x), self.shared.y.place(*y)) else { continue };
            let Some(color) = self.dot_color(points, i, own) else { continue };
            // An end at infinity leaves the panel.
            let share = |axis: &Axis, v: f64| if v.is_infinite() { Some(v) } else { axis.place(v) };
            let ends = |intervals: &Option<Vec<(f64, f64)>>, axis: &Axis| {
                let (low, high) = *intervals.as_ref()?.get(i)?;
                Some((share(axis, low)?, share(axis, high)?))
            };
            let along_x = ends(&points.x_intervals, &self.shared.x);
            let along_y = ends(&points.y_intervals, &self.shared.y);
            for (color, width) in [(WHITE, 5.0), (color, 2.2)] {
                if let Some((low, high)) = along_x {
                    draw_bar(svg, [self.pixel(low, y), self.pixel(high, y)], (0.0, 5.0), color, width);
                }
                if let Some((low, high)) = along_y {
                    draw_bar(svg, [self.pixel(x, low), self.pixel(x, high)], (5.0, 0.0), color, width);
                }
            }
            let radius = points.radius.unwrap_or(7.5).clamp(0.2, 50.0);
            draw_symbol(svg, points.symbol, self.pixel(x, y), radius, color, true);
        }
        svg.close();
    }
}
