//! The names of series beside their last points.

use crate::color::Rgb;
use crate::layers::Symbol;
use crate::panel::{draw_symbol, series_color};
use crate::plot::{Layer, Plot};
use crate::shared::Shared;
use crate::svg::{Anchor, Area, INK, Svg};
use crate::text::{TICK, clean, fit, width};

/// The distance of two lines of text, pixels.
const LINE: f64 = 1.2 * TICK.size;
/// From the end of the axes to the symbol, from there to the text, and from there to the end of the figure, pixels.
const LEADER: f64 = 16.0;
const SIGN: f64 = 22.0;
const MARGIN: f64 = 6.0;
/// More than sums of widths are rounded by, pixels.
const ROUNDING: f64 = 1e-6;

/// The name of a series.
struct EndLabel {
    name: String,
    color: Rgb,
    symbol: Option<Symbol>,
    /// The place of its last point, 0 to 1 along x and y.
    place: (f64, f64),
}

/// The names of all series of a plot.
#[derive(Default)]
pub(crate) struct EndLabels(Vec<EndLabel>);

impl EndLabels {
    /// Of the series with a name and a point that has a place, from the top down.
    pub(crate) fn of(plot: &Plot, shared: &Shared) -> Self {
        let label = |layer: &Layer| {
            let (name, x, y, color, symbol) = match layer {
                Layer::Points(p) => (&p.name, &p.x, &p.y, p.color, Some(p.symbol)),
                Layer::Line(l) => (&l.name, &l.x, &l.y, l.color, None),
                Layer::Histogram(_) => return None,
            };
            let places =
                x.iter().zip(y).filter_map(|(x, y)| Some((shared.x.place(*x)?, shared.y.place(*y)?)));
            let place = places.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|_| !name.is_empty())?;
            Some(EndLabel { name: clean(name), color: series_color(shared, name, color), symbol, place })
        };
        let mut labels: Vec<EndLabel> = plot.layers.iter().filter_map(label).collect();
        labels.sort_by(|a, b| b.place.1.total_cmp(&a.place.1));
        Self(labels)
    }

    /// The room right of the axes that all names need, pixels.
    pub(crate) fn width(&self) -> f64 {
        let widest = self.0.iter().map(|l| width(&l.name, TICK)).fold(0.0, f64::max);
        if self.0.is_empty() { 0.0 } else { LEADER + SIGN + widest + MARGIN }
    }

    /// Draws the names right of the axes, in `room` pixels, with lines that lead to them.
    pub(crate) fn draw(&self, svg: &mut Svg, area: Area, room: f64) {
        let wanted: Vec<f64> = self.0.iter().map(|l| area.y + area.height * (1.0 - l.place.1)).collect();
        let placed = apart(&wanted, (area.y, area.y + area.height));
        let right = area.x + area.width;
        for ((label, from), y) in self.0.iter().zip(&wanted).zip(placed) {
            let x = area.x + area.width * label.place.0;
            // A point at the end of the axes needs no line, one further left or a name that was moved does.
            svg.line((x, *from), (right + LEADER - 8.0, y), label.color, 1.0);
            if let Some(symbol) = label.symbol {
                draw_symbol(svg, symbol, (right + LEADER, y), 5.5, label.color, true);
            }
            // The widest name needs all of the room, whose sum was rounded.
            let name = fit(&label.name, TICK, room - LEADER - SIGN - MARGIN + ROUNDING);
            svg.text((right + LEADER + 10.0, y + 0.36 * TICK.size), Anchor::Start, TICK, INK, &name);
        }
    }
}

/// Ascending places, moved as little as they must be to lie a line of text apart within a range.
fn apart(wanted: &[f64], (low, high): (f64, f64)) -> Vec<f64> {
    let mut placed = Vec::with_capacity(wanted.len());
    let mut least = low;
    for y in wanted {
        let y = y.max(least);
        placed.push(y);
        least = y + LINE;
    }
    let mut most = high;
    for y in placed.iter_mut().rev() {
        *y = y.min(most);
        most = *y - LINE;
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_touch() {
        assert_eq!(apart(&[10.0, 100.0], (0.0, 200.0)), [10.0, 100.0]);
        let placed = apart(&[150.0, 150.0, 198.0, 199.0], (0.0, 200.0));
        assert!(placed.windows(2).all(|p| p[1] - p[0] >= LINE - 1e-9), "{placed:?}");
        assert!(placed[3] <= 200.0 && placed[0] > 100.0, "{placed:?}");
    }
}
