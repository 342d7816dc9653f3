//! Properties that the panels of a figure share: ranges, colours, bins.

use crate::FigureError;
use crate::color::{OKABE_ITO, Rgb};
use crate::plot::{AxisRequest, Layer, Plot};
use crate::scale::{Axis, Scale, round_step};

/// The most points that are drawn as shapes, which corresponds to a file of about 0.4 MB.
const SHAPES_LIMIT: usize = 6000;
/// The most bytes of all pictures of a figure; base64 in the SVG adds a third.
const PICTURES_LIMIT: usize = 690_000;
const BINS_LIMIT: f64 = 800.0;

/// Height of the marks of intervals above histograms, as a share of the axis.
pub(crate) const INTERVAL_SHARE: f64 = 0.075;

#[derive(Debug, Clone)]
pub(crate) struct Shared {
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// Range of the colour bar, if there is one.
    pub(crate) values: Option<Axis>,
    /// Whether values lie below and above the colour bar.
    pub(crate) beyond: (bool, bool),
    pub(crate) colors: Vec<(String, Rgb)>,
    pub(crate) bin: Option<(f64, f64)>,
    /// The most bytes of the picture of a cloud in a panel; `None` where clouds are drawn as shapes.
    pub(crate) picture_bytes: Option<usize>,
    /// Number of points in the panel with the most points.
    pub(crate) crowd: usize,
    pub(crate) empty: bool,
}

/// Spans of values below `TINY` vanish in rounding; beyond the other limits, spans and ratios overflow.
const TINY: f64 = 1e-290;
const HUGE: f64 = 1e300;
const LOG_HUGE: f64 = 1e100;

/// Whether an axis can contain a value.
fn fits(scale: Scale, value: f64) -> bool {
    match scale {
        Scale::Linear => value.abs() <= HUGE,
        Scale::Log => (1.0 / LOG_HUGE..=LOG_HUGE).contains(&value),
    }
}

/// Least and greatest of the finite values; positive ones on a logarithmic axis.
#[derive(Debug, Clone, Copy)]
struct Extent {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Extent {
    fn new(scale: Scale) -> Self {
        Self { scale, low: f64::INFINITY, high: f64::NEG_INFINITY }
    }

    fn add(&mut self, value: f64) {
        let value = if value.abs() < TINY { 0.0 } else { value };
        if fits(self.scale, value) {
            self.low = self.low.min(value);
            self.high = self.high.max(value);
        }
    }

    fn is_empty(&self) -> bool {
        self.low > self.high
    }
}

/// The axis of the range that is requested, else of the extent of the data with some air around it.
fn axis(request: &AxisRequest, extent: Extent, air: f64, name: &'static str) -> Result<Axis, FigureError> {
    if let Some((low, high)) = request.range {
        let wide = high - low > 1e-9 * low.abs().max(high.abs()) && high - low > TINY;
        if !(wide && fits(request.scale, low) && fits(request.scale, high)) {
            return Err(FigureError::Range { axis: name, low, high });
        }
        return Ok(Axis { scale: request.scale, low, high });
    }
    if extent.is_empty() {
        let (low, high) = if request.scale == Scale::Log { (1.0, 10.0) } else { (0.0, 1.0) };
        return Ok(Axis { scale: request.scale, low, high });
    }
    Ok(Axis::around(request.scale, extent.low, extent.high, air))
}

pub(crate) fn shared(first: &Plot, panels: &[Plot]) -> Result<Shared, FigureError> {
    let layers = || panels.iter().flat_map(|p| &p.layers);
    for layer in layers() {
        match layer {
            Layer::Points(p) => p.check()?,
            Layer::Line(l) => l.check()?,
            Layer::Histogram(_) => {}
        }
    }
    let bin = bins(panels);
    let (mut x, mut y) = (Extent::new(first.x.scale), Extent::new(first.y.scale));
    let mut values = Extent::new(first.values.scale);
    let mut air = 0.0;
    for layer in layers() {
        let (all_x, all_y) = match layer {
            Layer::Points(p) => {
                air = 0.04;
                p.values.iter().flatten().for_each(|v| values.add(*v));
                p.x_intervals.iter().flatten().for_each(|(a, b)| [*a, *b].into_iter().for_each(|v| x.add(v)));
                p.y_intervals.iter().flatten().for_each(|(a, b)| [*a, *b].into_iter().for_each(|v| y.add(v)));
                (&p.x, &p.y)
            }
            Layer::Line(l) => (&l.x, &l.y),
            Layer::Histogram(h) => {
                air = 0.03;
                let Some((start, width)) = bin else { continue };
                let counts = counts(&h.values, start, width);
                let top = counts.iter().copied().max().unwrap_or(0) as f64;
                x.add(start);
                x.add(start + width * counts.len() as f64);
                y.add(0.0);
                y.add(top);
                continue;
            }
        };
        for (px, py) in all_x.iter().zip(all_y).filter(|(a, b)| a.is_finite() && b.is_finite()) {
            x.add(*px);
            y.add(*py);
        }
    }
    let empty = x.is_empty() || y.is_empty();
    let mut y_axis = axis(&first.y, y, 0.04, "y")?;
    if first.y.range.is_none() && y_axis.scale == Scale::Linear {
        // Space above the bars for the marks of intervals.
        let marks = |p: &Plot| {
            p.layers.iter().filter(|l| matches!(l, Layer::Histogram(h) if h.interval.is_some())).count()
        };
        let rows = panels.iter().map(marks).max().unwrap_or(0).min(8);
        y_axis.high +=
            (y_axis.high - y_axis.low) * rows as f64 * INTERVAL_SHARE / (1.0 - rows as f64 * INTERVAL_SHARE);
    }
    let cloud = |p: &Plot| {
        let sizes = p.layers.iter().map(|l| match l {
            Layer::Points(p) if !p.marks => p.x.len(),
            _ => 0,
        });
        sizes.sum::<usize>()
    };
    let value_axis = axis(&first.values, values, 0.0, "the colour bar")?;
    let narrowed = first.values.range.is_some();
    Ok(Shared {
        x: axis(&first.x, x, air, "x")?,
        y: y_axis,
        beyond: (narrowed && values.low < value_axis.low, narrowed && values.high > value_axis.high),
        values: (!values.is_empty()).then_some(value_axis),
        colors: colors(layers()),
        bin,
        picture_bytes: (panels.iter().map(cloud).sum::<usize>() > SHAPES_LIMIT)
            .then(|| PICTURES_LIMIT / panels.len().max(1)),
        crowd: panels.iter().map(cloud).max().unwrap_or(0),
        empty,
    })
}

/// The colour of each name, the same in all panels.
fn colors<'a>(layers: impl Iterator<Item = &'a Layer>) -> Vec<(String, Rgb)> {
    let mut colors: Vec<(String, Rgb)> = Vec::new();
    for layer in layers {
        let (own, valued) = match layer {
            Layer::Points(p) => (p.color, p.values.is_some()),
            Layer::Line(l) => (l.color, false),
            Layer::Histogram(h) => (h.color, false),
        };
        if valued || own.is_some() || colors.iter().any(|(name, _)| name == layer.name()) {
            continue;
        }
        colors.push((layer.name().to_owned(), OKABE_ITO[colors.len() % OKABE_ITO.len()]));
    }
    colors
}

/// The first edge and the width of bins.
fn bins(panels: &[Plot]) -> Option<(f64, f64)> {
    let mut extent = Extent::new(Scale::Linear);
    for layer in panels.iter().flat_map(|p| &p.layers) {
        if let Layer::Histogram(h) = layer {
            h.values.iter().for_each(|v| extent.add(*v));
        }
    }
    if extent.is_empty() {
        return None;
    }
    let span = (extent.high - extent.low).max(1e-9 * extent.high.abs()).max(f64::MIN_POSITIVE * 1e16);
    let width = round_step(span, 40);
    Some((libm::floor(extent.low / width) * width, width))
}

/// The number of values in each bin, up to the last bin that is not empty.
pub(crate) fn counts(values: &[f64], start: f64, width: f64) -> Vec<usize> {
    let mut counts: Vec<usize> = Vec::new();
    for value in values.iter().filter(|v| v.is_finite()) {
        let index = ((value - start) / width).clamp(0.0, BINS_LIMIT) as usize;
        if counts.len() <= index {
            counts.resize(index + 1, 0);
        }
        if let Some(count) = counts.get_mut(index) {
            *count += 1;
        }
    }
    counts
}
