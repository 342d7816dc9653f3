//! A plot: axes and layers.

use crate::layers::{Histogram, Line, Points};
use crate::layout::{Layout, layout};
use crate::scale::Scale;
use crate::{Figure, FigureError};

/// An axis as asked for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Asked {
    pub(crate) label: String,
    pub(crate) scale: Scale,
    pub(crate) range: Option<(f64, f64)>,
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
/// Histograms lie at the back, then clouds of points (mixed, so that no series hides another), lines, marks. More than
/// 6000 points in a figure are drawn as a picture within the SVG, of two pixels per pixel, so that files stay small;
/// the description says so.
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
    pub(crate) title: String,
    pub(crate) note: String,
    pub(crate) description: String,
    pub(crate) x: Asked,
    pub(crate) y: Asked,
    pub(crate) values: Asked,
    pub(crate) layers: Vec<Layer>,
    pub(crate) legend: bool,
    pub(crate) wavelengths: bool,
    pub(crate) bin_width: Option<f64>,
    pub(crate) size: (f64, f64),
}

impl Plot {
    /// An empty plot of 800 × 600 pixels. Labels name the quantity and its unit: `"MTF50 (cy/mm)"`.
    #[must_use]
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        let asked = |label: String| Asked { label, scale: Scale::Linear, range: None };
        Self {
            title: String::new(),
            note: String::new(),
            description: String::new(),
            x: asked(x_label.into()),
            y: asked(y_label.into()),
            values: asked(String::new()),
            layers: Vec::new(),
            legend: true,
            wavelengths: false,
            bin_width: None,
            size: (800.0, 600.0),
        }
    }

    /// A plot for curves over wavelength, with the colours of the spectrum under its axis. Add one [`Line`] per
    /// filter; [`crate::Rgb::of_transmittance`] gives each about its own colour.
    #[must_use]
    pub fn spectra(y_label: impl Into<String>) -> Self {
        let mut plot = Self::new("Wavelength (nm)", y_label);
        plot.wavelengths = true;
        plot
    }

    /// The title above.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// A note in small print below.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// What the figure shows, for those who do not see it; without it, axes and series are listed.
    #[must_use]
    pub fn description(mut self, description: impl Into<String>) -> Self {
        self.description = description.into();
        self
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.size = (width, height);
        self
    }

    /// The range of x, in place of that of the data. Points beyond are counted under the plot.
    #[must_use]
    pub fn x_range(mut self, low: f64, high: f64) -> Self {
        self.x.range = Some((low, high));
        self
    }

    /// The range of y, in place of that of the data. Points beyond are counted under the plot.
    #[must_use]
    pub fn y_range(mut self, low: f64, high: f64) -> Self {
        self.y.range = Some((low, high));
        self
    }

    /// How x is spread.
    #[must_use]
    pub fn x_scale(mut self, scale: Scale) -> Self {
        self.x.scale = scale;
        self
    }

    /// How y is spread.
    #[must_use]
    pub fn y_scale(mut self, scale: Scale) -> Self {
        self.y.scale = scale;
        self
    }

    /// Label of the colour bar of [`Points::values`].
    #[must_use]
    pub fn values(mut self, label: impl Into<String>) -> Self {
        self.values.label = label.into();
        self
    }

    /// The range of the colour bar, in place of that of the data; values beyond get the colour of its ends, and its
    /// labels say so.
    #[must_use]
    pub fn value_range(mut self, low: f64, high: f64) -> Self {
        self.values.range = Some((low, high));
        self
    }

    /// Width of the bins of histograms, at least a 400th of their range; without it, a round number that gives about 40.
    #[must_use]
    pub fn bin_width(mut self, width: f64) -> Self {
        self.bin_width = Some(width);
        self
    }

    /// Without a legend.
    #[must_use]
    pub fn without_legend(mut self) -> Self {
        self.legend = false;
        self
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

    /// The figure. A plot without a finite point is drawn empty, and says so.
    ///
    /// # Errors
    /// [`FigureError`] for columns of different length, bad ranges, and sizes without room for the labels.
    pub fn draw(&self) -> Result<Figure, FigureError> {
        layout(&Layout {
            title: &self.title,
            note: &self.note,
            description: &self.description,
            size: self.size,
            columns: 1,
            legend: self.legend,
            named_panels: false,
            panels: std::slice::from_ref(self),
        })
    }
}

/// Several plots side by side with shared axes and colours, one legend and one colour bar; labels, scales and ranges
/// are those of the first plot, the title of each stands above it.
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
    title: String,
    note: String,
    description: String,
    columns: usize,
    legend: bool,
    size: (f64, f64),
    panels: Vec<Plot>,
}

impl Panels {
    /// No panels yet, this many to a row, on 1200 × 800 pixels.
    #[must_use]
    pub fn new(columns: usize) -> Self {
        Self {
            title: String::new(),
            note: String::new(),
            description: String::new(),
            columns: columns.max(1),
            legend: true,
            size: (1200.0, 800.0),
            panels: Vec::new(),
        }
    }

    /// The title above all.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// A note in small print below.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// What the figure shows, for those who do not see it; without it, axes and series are listed.
    #[must_use]
    pub fn description(mut self, description: impl Into<String>) -> Self {
        self.description = description.into();
        self
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.size = (width, height);
        self
    }

    /// Without a legend.
    #[must_use]
    pub fn without_legend(mut self) -> Self {
        self.legend = false;
        self
    }

    /// Adds a panel.
    #[must_use]
    pub fn panel(mut self, plot: Plot) -> Self {
        self.panels.push(plot);
        self
    }

    /// The figure.
    ///
    /// # Errors
    /// As [`Plot::draw`], and [`FigureError::Nothing`] without a panel.
    pub fn draw(&self) -> Result<Figure, FigureError> {
        layout(&Layout {
            title: &self.title,
            note: &self.note,
            description: &self.description,
            size: self.size,
            columns: self.columns.min(self.panels.len().max(1)),
            legend: self.legend,
            named_panels: true,
            panels: &self.panels,
        })
    }
}
