//! One panel: grid, histograms, clouds, lines, marks, axes.

use plotters::coord::cartesian::Cartesian2d;
use plotters::prelude::{
    AreaSeries, ChartBuilder, ChartContext, EmptyElement, IntoDrawingArea, LabelAreaPosition, LineSeries,
    PathElement, ShapeStyle,
};

use crate::FigureError;
use crate::backend::{Backend, Canvas, pixels, style, text_style, units};
use crate::cloud::{Dot, draw_cloud};
use crate::color::Rgb;
use crate::figure::encode;
use crate::layers::{Corner, Histogram, Line, Points, Symbol};
use crate::layout::{LABEL, TICK};
use crate::plot::{Layer, Plot};
use crate::scale::{Axis, Beyond, Tick};
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

/// Where series are drawn.
type Chart<'a> = ChartContext<'a, Backend, Cartesian2d<Beyond, Beyond>>;

/// A bar with caps, which reach as far to both sides as `cap` says.
fn bar(
    chart: &mut Chart<'_>,
    ends: [(f64, f64); 2],
    cap: (f64, f64),
    look: ShapeStyle,
) -> Result<(), FigureError> {
    chart.draw_series([PathElement::new(ends, look)])?;
    let (x, y) = (units(cap.0), units(cap.1));
    chart.draw_series(ends.map(|end| EmptyElement::at(end) + PathElement::new([(-x, -y), (x, y)], look)))?;
    Ok(())
}

impl Panel<'_> {
    pub(crate) fn draw(&self, svg: &Canvas) -> Result<(), FigureError> {
        let area = self.area;
        if self.shared.empty {
            let mut svg = svg.borrow_mut();
            svg.rect(
                area,
                Paint { fill: Some((Rgb(250, 250, 250), 1.0)), stroke: Some((GRID, 1.0)), dashed: false },
            );
            let middle = (area.x + 0.5 * area.width, area.y + 0.5 * area.height);
            svg.text(middle, Anchor::Middle, LABEL, SOFT, "no data");
            return Ok(());
        }
        self.draw_axes(svg)?;
        let mut chart = self.chart(svg)?;
        svg.borrow_mut().open_window(Area {
            x: area.x - 1.0,
            y: area.y - 1.0,
            width: area.width + 2.0,
            height: area.height + 2.0,
        });
        let mut interval_row = 0;
        for layer in &self.plot.layers {
            if let Layer::Histogram(histogram) = layer {
                self.draw_histogram(svg, &mut chart, histogram, &mut interval_row)?;
            }
        }
        self.draw_clouds(svg, &chart)?;
        for layer in &self.plot.layers {
            if let Layer::Line(line) = layer {
                self.draw_line(svg, &mut chart, line)?;
            }
        }
        for layer in &self.plot.layers {
            if let Layer::Points(points) = layer
                && points.marks
            {
                self.draw_marks(svg, &mut chart, points)?;
            }
        }
        svg.borrow_mut().close_window();
        if self.plot.wavelengths {
            self.draw_wavelengths(&mut svg.borrow_mut())?;
        }
        Ok(())
    }

    /// The panel and what is around it, for series.
    fn chart(&self, svg: &Canvas) -> Result<Chart<'static>, FigureError> {
        let Area { width, height, .. } = self.area;
        // A hundredth more: the crate's last pixel is the end of the axis.
        let size = (width * Beyond::LENGTHS + 0.01, height * Beyond::LENGTHS + 0.01);
        let root = Backend { svg: svg.clone(), origin: self.origin(), size }.into_drawing_area();
        Ok(ChartBuilder::on(&root).build_cartesian_2d(Beyond(self.shared.x), Beyond(self.shared.y))?)
    }

    /// Where the chart of the series begins.
    fn origin(&self) -> (f64, f64) {
        let Area { x, y, width, height } = self.area;
        // Upwards there is what remains of the lengths.
        (x - Beyond::BEFORE * width, y - (Beyond::LENGTHS - 1.0 - Beyond::BEFORE) * height)
    }

    /// The place of a point in the drawing.
    fn place(&self, chart: &Chart<'_>, at: (f64, f64)) -> (f64, f64) {
        let ((left, top), (x, y)) = (self.origin(), pixels(chart.backend_coord(&at)));
        (left + x, top + y)
    }

    /// Grid and axes.
    fn draw_axes(&self, svg: &Canvas) -> Result<(), FigureError> {
        let Area { x, y, width: w, height: h } = self.area;
        let below = TICK.size + 26.0;
        let size = (x + w + 1.0, y + h + below + 1.0);
        let root = Backend { svg: svg.clone(), origin: (0.0, 0.0), size }.into_drawing_area();
        // One unit more: the crate's last pixel is the end of the axis.
        let room = root.shrink((0, units(y)), (units(x + w) + 1, units(h + below) + 1));
        let mut chart = ChartBuilder::on(&room)
            .set_label_area_size(LabelAreaPosition::Left, units(x))
            .set_label_area_size(LabelAreaPosition::Bottom, units(below))
            .build_cartesian_2d(self.shared.x, self.shared.y)?;
        let x_count = ((w / 95.0) as usize).clamp(2, 12);
        let y_count = ((h / 62.0) as usize).clamp(2, 12);
        let label = |ticks: &[Tick], shown: bool, v: f64| match ticks.iter().find(|t| t.0 == v) {
            Some((_, label)) if shown => label.clone(),
            _ => String::new(),
        };
        let mut x_ticks = self.shared.x.ticks(x_count);
        // Labels that would touch: every other tick.
        let widest = x_ticks.iter().map(|(_, l)| width(l, TICK)).fold(0.0, f64::max);
        let touching = x_ticks.len() as f64 * (widest + 14.0) > w + widest;
        let x_count = if touching { x_count / 2 } else { x_count };
        if touching {
            x_ticks = self.shared.x.ticks(x_count);
        }
        let y_ticks = self.shared.y.ticks(y_count);
        let x_label = |v: &f64| label(&x_ticks, self.edges.bottom, *v);
        let y_label = |v: &f64| label(&y_ticks, self.edges.left, *v);
        chart
            .configure_mesh()
            .max_light_lines(0)
            .bold_line_style(style(GRID, 1.0, 1.0))
            .axis_style(style(FRAME, 1.0, 1.4))
            .label_style(text_style(TICK))
            .set_tick_mark_size(LabelAreaPosition::Left, units(5.0))
            .set_tick_mark_size(
                LabelAreaPosition::Bottom,
                units(if self.plot.wavelengths { 10.0 } else { 5.0 }),
            )
            .x_labels(x_count)
            .y_labels(y_count)
            .x_label_formatter(&x_label)
            .y_label_formatter(&y_label)
            .draw()?;
        Ok(())
    }

    /// The point, if it has a place.
    fn point(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        (self.shared.x.place(x).is_some() && self.shared.y.place(y).is_some()).then_some((x, y))
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

    fn draw_histogram(
        &self,
        svg: &Canvas,
        chart: &mut Chart<'_>,
        histogram: &Histogram,
        interval_row: &mut usize,
    ) -> Result<(), FigureError> {
        let Some((start, bin)) = self.shared.bin else { return Ok(()) };
        let color = series_color(self.shared, &histogram.name, histogram.color);
        let floor = self.shared.y.low;
        svg.borrow_mut().open("", &histogram.name);
        // Each run of bins that hold something is an outline.
        let mut steps: Vec<(f64, f64)> = Vec::new();
        for (i, count) in counts(&histogram.values, start, bin).into_iter().chain([0]).enumerate() {
            let (x, y) = (start + bin * i as f64, count as f64);
            if count > 0 {
                let Some(step) = self.point(x, y) else { continue };
                steps.extend([(x, steps.last().map_or(floor, |p| p.1)), step]);
            } else if let Some(last) = steps.last().copied() {
                steps.extend([(x, last.1), (x, floor)]);
                let area =
                    AreaSeries::new(std::mem::take(&mut steps), floor, style(color, 0.22, 0.0).filled());
                chart.draw_series(area.border_style(style(color, 1.0, 1.8)))?;
            }
        }
        if let Some((low, center, high)) = histogram.interval {
            let share = (*interval_row as f64 + 0.6) * INTERVAL_SHARE;
            *interval_row += 1;
            let y = self.shared.y.value(1.0 - share);
            if [low, center, high].iter().all(|v| self.point(*v, y).is_some()) {
                bar(chart, [(low, y), (high, y)], (0.0, 7.0), style(color, 1.0, 2.6))?;
                let at = self.place(chart, (center, y));
                draw_symbol(&mut svg.borrow_mut(), Symbol::Circle, at, 6.5, color, true);
            }
        }
        svg.borrow_mut().close();
        Ok(())
    }

    fn draw_clouds(&self, svg: &Canvas, chart: &Chart<'_>) -> Result<(), FigureError> {
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
                let Some(at) = self.point(*x, *y) else { continue };
                let Some(color) = self.dot_color(points, i, color) else { continue };
                let (x, y) = self.place(chart, at);
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
        draw_cloud(&mut svg.borrow_mut(), self.area, dots, opacity, self.shared.picture_bytes)
    }

    /// The colour of a point; none where its value is NaN.
    fn dot_color(&self, points: &Points, index: usize, series: Rgb) -> Option<Rgb> {
        let Some(values) = &points.values else { return Some(series) };
        let value = values.get(index).copied().filter(|v| !v.is_nan())?;
        let axis = self.shared.values.as_ref()?;
        // What has no place lies beyond the low end: not positive on a logarithmic bar.
        Some(Rgb::viridis(axis.place(value).unwrap_or(if value > axis.high { 1.0 } else { 0.0 })))
    }

    fn draw_line(&self, svg: &Canvas, chart: &mut Chart<'_>, line: &Line) -> Result<(), FigureError> {
        let color = series_color(self.shared, &line.name, line.color);
        svg.borrow_mut().open("", &line.name);
        let mut run: Vec<(f64, f64)> = Vec::new();
        let places = line.x.iter().zip(&line.y).map(|(x, y)| self.point(*x, *y));
        // Each run of points with a place is a path.
        for point in places.chain([None]) {
            let Some(point) = point else {
                self.draw_run(svg, chart, line, color, std::mem::take(&mut run))?;
                continue;
            };
            match (line.corner, run.last().copied()) {
                (Corner::XFirst, Some(last)) => run.push((point.0, last.1)),
                (Corner::YFirst, Some(last)) => run.push((last.0, point.1)),
                _ => {}
            }
            run.push(point);
        }
        svg.borrow_mut().close();
        Ok(())
    }

    fn draw_run(
        &self,
        svg: &Canvas,
        chart: &mut Chart<'_>,
        line: &Line,
        color: Rgb,
        run: Vec<(f64, f64)>,
    ) -> Result<(), FigureError> {
        if run.is_empty() {
            return Ok(());
        }
        if line.filled {
            let tint = style(color, 0.16, 0.0).filled();
            chart.draw_series(AreaSeries::new(run.iter().copied(), self.shared.y.low, tint))?;
        }
        let width = line.width.clamp(0.2, 30.0);
        if line.dashed {
            // One path with dashes: the crate would write each dash as a shape.
            let points: Vec<_> = run.iter().map(|at| self.place(chart, *at)).collect();
            let paint = Paint { dashed: true, ..Paint::stroke(color, width) };
            svg.borrow_mut().path(&path_of(&points, false), paint);
        } else {
            chart.draw_series(LineSeries::new(run, style(color, 1.0, width)))?;
        }
        Ok(())
    }

    fn draw_marks(&self, svg: &Canvas, chart: &mut Chart<'_>, points: &Points) -> Result<(), FigureError> {
        let own = series_color(self.shared, &points.name, points.color);
        svg.borrow_mut().open("", &points.name);
        for (i, (x, y)) in points.x.iter().zip(&points.y).enumerate() {
            let (Some((x, y)), Some(color)) = (self.point(*x, *y), self.dot_color(points, i, own)) else {
                continue;
            };
            let ends = |interval: Option<&(f64, f64)>, axis: &Axis| {
                let placed = |v: f64| v.is_infinite() || axis.place(v).is_some();
                interval.copied().filter(|(low, high)| placed(*low) && placed(*high))
            };
            let along_x = ends(points.x_intervals.as_ref().and_then(|v| v.get(i)), &self.shared.x);
            let along_y = ends(points.y_intervals.as_ref().and_then(|v| v.get(i)), &self.shared.y);
            for look in [style(Rgb(255, 255, 255), 1.0, 5.0), style(color, 1.0, 2.2)] {
                if let Some((low, high)) = along_x {
                    bar(chart, [(low, y), (high, y)], (0.0, 5.0), look)?;
                }
                if let Some((low, high)) = along_y {
                    bar(chart, [(x, low), (x, high)], (5.0, 0.0), look)?;
                }
            }
            let radius = points.radius.unwrap_or(7.5).clamp(0.2, 50.0);
            let at = self.place(chart, (x, y));
            draw_symbol(&mut svg.borrow_mut(), points.symbol, at, radius, color, true);
        }
        svg.borrow_mut().close();
        Ok(())
    }
}
