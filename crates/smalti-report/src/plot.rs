//! A plot: axes and layers.

use crate::figure::setters;
use crate::layers::{Histogram, Line, Points};
use crate::scale::Scale;

/// The label, scale and range that an axis is to have.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisRequest {
    pub(crate) label: String,
    pub(crate) scale: Scale,
    /// `None`: the range of the data.
    pub(crate) range: Option<(f64, f64)>,
}

/// What surrounds the panels of a figure.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Frame {
    pub(crate) title: String,
    pub(crate) note: String,
    pub(crate) legend: bool,
    /// Whether names stand beside the right ends of the series instead of in a legend.
    pub(crate) end_labels: bool,
    /// Width and height in pixels.
    pub(crate) size: (f64, f64),
}

impl Frame {
    fn of_size(width: f64, height: f64) -> Self {
        Self {
            title: String::new(),
            note: String::new(),
            legend: true,
            end_labels: false,
            size: (width, height),
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Layer {
    Points(Points),
    Line(Line),
    Histogram(Histogram),
}

impl Layer {
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Points(p) => &p.name,
            Self::Line(l) => &l.name,
            Self::Histogram(h) => &h.name,
        }
    }
}

/// A plot, alone or as one of several [`crate::Panels`].
///
/// The layers are drawn from back to front: histograms, clouds of points (shuffled, so that no series hides another), lines,
/// marks, arrows. More than 6000 points are drawn as a picture within the SVG, with two pixels per pixel, so that files remain small; the
/// description states this.
///
/// ```
/// use smalti_report::{Corner, Line, Plot, Points, Symbol};
///
/// let figure = Plot::new("MTF50 (cy/mm)", "mean ΔE*ab")
///     .title("Colour against resolution")
///     .points(Points::new("3 colours", &[70.0, 75.0, 62.0], &[5.0, 6.5, 4.0]))
///     .points(Points::new("mean", &[69.0], &[5.2]).symbol(Symbol::Square).y_intervals(&[(4.0, 6.4)]))
///     .line(Line::new("Pareto front", &[62.0, 70.0, 75.0], &[4.0, 5.0, 6.5]).corner(Corner::YFirst))
///     .draw()?;
/// assert!(figure.svg().contains("MTF50 (cy/mm)"));
/// assert!(figure.png(1.0)?.starts_with(b"\x89PNG"));
/// # Ok::<(), smalti_report::FigureError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    pub(crate) frame: Frame,
    pub(crate) x: AxisRequest,
    pub(crate) y: AxisRequest,
    pub(crate) values: AxisRequest,
    pub(crate) layers: Vec<Layer>,
    pub(crate) wavelengths: bool,
    /// Ticks of the x axis; empty for round values.
    pub(crate) x_ticks: Vec<f64>,
}

impl Plot {
    /// An empty plot of 800 × 600 pixels. Labels name the quantity and its unit: `"MTF50 (cy/mm)"`.
    #[must_use]
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        let axis = |label: String| AxisRequest { label, scale: Scale::Linear, range: None };
        Self {
            frame: Frame::of_size(800.0, 600.0),
            x: axis(x_label.into()),
            y: axis(y_label.into()),
            values: axis(String::new()),
            layers: Vec::new(),
            wavelengths: false,
            x_ticks: Vec::new(),
        }
    }

    /// A plot for curves over wavelength, with the colours of the spectrum below its axis. Add one [`Line`] per
    /// filter; [`crate::Rgb::of_transmittance`] returns the approximate colour of a filter.
    #[must_use]
    pub fn spectra(y_label: impl Into<String>) -> Self {
        let mut plot = Self::new("Wavelength (nm)", y_label);
        plot.wavelengths = true;
        plot
    }

    setters! {
        /// Sets the title above the plot.
        title(title: impl Into<String>) { frame.title = title.into() }
        /// Sets a note in small print below.
        note(note: impl Into<String>) { frame.note = note.into() }
        /// Sets width and height in pixels.
        size(width: f64, height: f64) { frame.size = (width, height) }
        /// Writes the name of each series beside its last point, instead of a legend above the plot.
        direct_labels() { frame.legend = false; frame.end_labels = true }
        /// Sets the range of x, instead of that of the data. Points outside are counted below the plot.
        x_range(low: f64, high: f64) { x.range = Some((low, high)) }
        /// Sets the range of y, instead of that of the data. Points outside are counted below the plot.
        y_range(low: f64, high: f64) { y.range = Some((low, high)) }
        /// Sets ticks of x at these values, such as all that were measured, instead of at round ones. Of labels that would touch, the
        /// first is shown.
        x_ticks(values: &[f64]) { x_ticks = values.to_vec() }
        /// Sets the scale of x.
        x_scale(scale: Scale) { x.scale = scale }
        /// Sets the scale of y.
        y_scale(scale: Scale) { y.scale = scale }
        /// Sets the label of the colour bar of [`Points::values`].
        values(label: impl Into<String>) { values.label = label.into() }
        /// Sets the range of the colour bar, instead of that of the data. Values outside have the colour of the nearer end, whose label
        /// shows ≤ or ≥.
        value_range(low: f64, high: f64) { values.range = Some((low, high)) }
    }

    /// Adds points.
    #[must_use]
    pub fn points(mut self, points: Points) -> Self {
        self.layers.push(Layer::Points(points));
        self
    }

    /// Adds a line.
    #[must_use]
    pub fn line(mut self, line: Line) -> Self {
        self.layers.push(Layer::Line(line));
        self
    }

    /// Adds a histogram.
    #[must_use]
    pub fn histogram(mut self, histogram: Histogram) -> Self {
        self.layers.push(Layer::Histogram(histogram));
        self
    }
}

/// Several plots side by side with shared axes and colours, one legend and one colour bar. Labels, scales and ranges
/// are those of the first plot, and each plot has its title above it.
///
/// ```
/// use smalti_report::{Panels, Plot, Points};
///
/// let panel = |n: u32, delta_e: f64| {
///     Plot::new("MTF50 (cy/mm)", "ΔE*ab")
///         .title(format!("{n} colours"))
///         .points(Points::new("designs", &[60.0, 70.0], &[delta_e, 2.0 * delta_e]))
/// };
/// let figure = Panels::new(2).title("By number of colours").panel(panel(3, 3.0)).panel(panel(4, 2.0)).draw()?;
/// assert!(figure.svg().contains("4 colours"));
/// # Ok::<(), smalti_report::FigureError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Panels {
    pub(crate) frame: Frame,
    pub(crate) columns: usize,
    pub(crate) panels: Vec<Plot>,
}

impl Panels {
    /// A figure of 1200 × 800 pixels without panels, with `columns` panels per row.
    #[must_use]
    pub fn new(columns: usize) -> Self {
        Self { frame: Frame::of_size(1200.0, 800.0), columns: columns.max(1), panels: Vec::new() }
    }

    setters! {
        /// Sets the title above all panels.
        title(title: impl Into<String>) { frame.title = title.into() }
        /// Sets a note in small print below.
        note(note: impl Into<String>) { frame.note = note.into() }
        /// Omits the legend.
        without_legend() { frame.legend = false }
    }

    /// Adds a panel.
    #[must_use]
    pub fn panel(mut self, plot: Plot) -> Self {
        self.panels.push(plot);
        self
    }
}
