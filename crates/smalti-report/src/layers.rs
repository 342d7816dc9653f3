//! The layers of a plot: points, lines, histograms.

use crate::FigureError;
use crate::color::Rgb;
use crate::figure::setters;

/// The symbol of a point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Symbol {
    /// A disc.
    #[default]
    Circle,
    /// A square with horizontal sides.
    Square,
    /// A square that stands on a corner.
    Diamond,
    /// A triangle, point up.
    TriangleUp,
    /// A triangle, point down.
    TriangleDown,
    /// A star of five points.
    Star,
}

impl Symbol {
    /// The corners around a place, for about the area of a disc of this radius; `None` for the disc.
    pub(crate) fn outline(self, (x, y): (f64, f64), radius: f64) -> Option<Vec<(f64, f64)>> {
        // Corners of the regular pentagon, from the top clockwise, y down.
        const PENTAGON: [(f64, f64); 5] = [
            (0.0, -1.0),
            (0.951_056_5, -0.309_017),
            (0.587_785_3, 0.809_017),
            (-0.587_785_3, 0.809_017),
            (-0.951_056_5, -0.309_017),
        ];
        let (points, size): (Vec<(f64, f64)>, f64) = match self {
            Self::Circle => return None,
            Self::Square => (vec![(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], 0.89),
            Self::Diamond => (vec![(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)], 1.25),
            Self::TriangleUp => (vec![(0.0, -1.1), (1.0, 0.65), (-1.0, 0.65)], 1.3),
            Self::TriangleDown => (vec![(0.0, 1.1), (1.0, -0.65), (-1.0, -0.65)], 1.3),
            Self::Star => {
                // The inner corners lie opposite the outer ones.
                let inner = PENTAGON.iter().cycle().skip(3).map(|p| (-0.5 * p.0, -0.5 * p.1));
                (PENTAGON.into_iter().zip(inner).flat_map(|(outer, inner)| [outer, inner]).collect(), 1.5)
            }
        };
        Some(points.into_iter().map(|(dx, dy)| (x + dx * size * radius, y + dy * size * radius)).collect())
    }
}

/// A series of points: a cloud of dots, or a few emphasised marks above it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Points {
    pub(crate) name: String,
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) values: Option<Vec<f64>>,
    pub(crate) color: Option<Rgb>,
    pub(crate) symbol: Symbol,
    pub(crate) radius: Option<f64>,
    pub(crate) marks: bool,
    pub(crate) x_intervals: Option<Vec<(f64, f64)>>,
    pub(crate) y_intervals: Option<Vec<(f64, f64)>>,
}

impl Points {
    /// Points at (x, y). A name that is not empty appears in the legend. Points that are not finite are not drawn but counted
    /// below the plot.
    #[must_use]
    pub fn new(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self { name: name.into(), x: x.to_vec(), y: y.to_vec(), ..Self::default() }
    }

    setters! {
        /// Colours each point by its value, with viridis and a colour bar; see [`crate::Plot::values`].
        values(values: &[f64]) { values = Some(values.to_vec()) }
        /// Sets one colour for all points, instead of the next colour of the palette.
        color(color: Rgb) { color = Some(color) }
        /// The symbol of all points.
        symbol(symbol: Symbol) { symbol = symbol }
        /// Sets the radius in pixels; by default it decreases with the number of points.
        radius(radius: f64) { radius = Some(radius) }
        /// Draws large marks with a white edge above clouds and lines, such as means or selected designs.
        marks() { marks = true }
        /// Adds an interval (low, high) of x to each point, which is drawn as a bar; the points become marks.
        x_intervals(intervals: &[(f64, f64)]) { x_intervals = Some(intervals.to_vec()); marks = true }
        /// Adds an interval (low, high) of y to each point, which is drawn as a bar; the points become marks.
        y_intervals(intervals: &[(f64, f64)]) { y_intervals = Some(intervals.to_vec()); marks = true }
    }

    pub(crate) fn check(&self) -> Result<(), FigureError> {
        let columns = [
            ("values of y", Some(self.y.len())),
            ("values to colour by", self.values.as_ref().map(Vec::len)),
            ("intervals of x", self.x_intervals.as_ref().map(Vec::len)),
            ("intervals of y", self.y_intervals.as_ref().map(Vec::len)),
        ];
        same_length(&self.name, self.x.len(), &columns)
    }
}

/// The connection between two points of a line.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Corner {
    /// A straight line.
    #[default]
    Straight,
    /// First along y, then along x: the boundary of the region that a front dominates, where x is higher-is-better and y
    /// lower-is-better, with points by rising x.
    YFirst,
}

/// A line through points in the given order, such as a spectrum or a Pareto front.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Line {
    pub(crate) name: String,
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) color: Option<Rgb>,
    pub(crate) width: f64,
    pub(crate) dashed: bool,
    pub(crate) corner: Corner,
    pub(crate) filled: bool,
    pub(crate) arrow: bool,
}

impl Line {
    /// A line through (x, y). A name that is not empty appears in the legend. The line is interrupted where a point is not finite.
    #[must_use]
    pub fn new(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self { name: name.into(), x: x.to_vec(), y: y.to_vec(), width: 2.4, ..Self::default() }
    }

    setters! {
        /// Sets the colour, instead of the next colour of the palette.
        color(color: Rgb) { color = Some(color) }
        /// Sets the width in pixels.
        width(width: f64) { width = width }
        /// Draws a dashed line.
        dashed() { dashed = true }
        /// Sets the connection between points.
        corner(corner: Corner) { corner = corner }
        /// Fills the area between the line and the bottom of the plot with a tint.
        filled() { filled = true }
        /// Draws an arrowhead at the last point, and the line above all marks.
        arrow() { arrow = true }
    }

    pub(crate) fn check(&self) -> Result<(), FigureError> {
        same_length(&self.name, self.x.len(), &[("values of y", Some(self.y.len()))])
    }
}

/// A histogram of values. All histograms of a figure share their bins.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    pub(crate) name: String,
    pub(crate) values: Vec<f64>,
    pub(crate) color: Option<Rgb>,
    pub(crate) interval: Option<(f64, f64, f64)>,
}

impl Histogram {
    /// The histogram of values; values that are not finite are not drawn but counted below the plot.
    #[must_use]
    pub fn new(name: impl Into<String>, values: &[f64]) -> Self {
        Self { name: name.into(), values: values.to_vec(), color: None, interval: None }
    }

    setters! {
        /// Sets the colour, instead of the next colour of the palette.
        color(color: Rgb) { color = Some(color) }
        /// Marks an interval and a centre above the bars, such as the 5th and 95th percentile and the mean.
        interval(low: f64, center: f64, high: f64) { interval = Some((low, center, high)) }
    }
}

/// Refuses a series with a column, where there is one, of another length than that of x.
fn same_length(
    series: &str,
    expected: usize,
    columns: &[(&'static str, Option<usize>)],
) -> Result<(), FigureError> {
    let wrong = columns.iter().find_map(|(what, got)| Some((*what, got.filter(|got| *got != expected)?)));
    let Some((what, got)) = wrong else { return Ok(()) };
    Err(FigureError::Lengths { series: crate::text::clean(series), what, expected, got })
}
