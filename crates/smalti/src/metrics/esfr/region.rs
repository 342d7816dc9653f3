//! Finding the slanted edge in a picture.

use super::{EsfrOptions, MetricError, Rect, edge_sfr};
use crate::metrics::error::{at_least, finite};
use crate::metrics::patch::{check_plane, check_region};
use crate::numeric::Planes;

/// Pixels of the border that are ignored, because demosaicking is least accurate there.
const BORDER: usize = 3;
/// Maximum number of lines for the rough location of the edge, evenly spaced.
const MAXIMUM_LINES: usize = 256;
/// Largest distance of the steepest position of a line from the edge for the line to agree with it, pixels.
const TOLERANCE_PX: f64 = 2.0;

/// Finds a region for [`edge_sfr`] around the one long slanted edge of a picture (the slanted-bar chart). The edge crosses the
/// centre of the region and its short sides, and both plateaus have at least 8 pixels.
///
/// The steepest position of every line across the edge is found, and a straight line is fitted to them by medians of slopes
/// ([theil1950]), which tolerates up to a quarter of outliers.
///
/// # Errors
/// When the plane does not exist or is too small, a value is not finite, or no such edge is found.
///
/// [theil1950]: https://doi.org/10.1007/978-94-011-2546-8_20
pub fn find_edge_region(planes: &Planes, plane: usize) -> Result<Rect, MetricError> {
    check_plane(planes.count(), plane)?;
    let (rows, cols, data) = (planes.rows(), planes.cols(), planes.plane(plane)?);
    at_least("pixels along the shorter side of the picture", 2 * BORDER + 16, rows.min(cols))?;
    finite("the picture", data.iter().copied())?;
    let at = |row: usize, col: usize| f64::from(data[row * cols + col]);
    let (mut across, mut along) = (0.0, 0.0);
    for row in BORDER..rows - BORDER {
        for col in BORDER..cols - BORDER {
            across += (at(row, col + 1) - at(row, col - 1)).abs();
            along += (at(row + 1, col) - at(row - 1, col)).abs();
        }
    }
    let vertical = across >= along;
    let (length, width) = if vertical { (rows, cols) } else { (cols, rows) };
    let sample = |y: usize, x: usize| if vertical { at(y, x) } else { at(x, y) };

    let edge = locate(length, width, sample)?;
    let (y0, y1) = (edge.first as f64, edge.last as f64);
    let middle_y = (y0 + y1) / 2.0;
    let middle_x = edge.intercept + edge.slope * middle_y;
    let room = (middle_x - BORDER as f64).min((width - BORDER) as f64 - middle_x);
    let plateau = (0.15 * width as f64).clamp(8.0, 32.0);
    // The edge may span the width without the plateaus; a strongly slanted edge makes the region short.
    let run = (2.0 * (room - plateau) / edge.slope.abs()).min(y1 - y0);
    if room < plateau || run.is_nan() || run < 8.0 {
        return Err(MetricError::NoEdge("the longest edge is too close to the border"));
    }
    let half_width = (0.5 * edge.slope.abs() * run + plateau).min(room);
    let rect_along = ((middle_y - run / 2.0).ceil() as usize, run as usize);
    let rect_across = ((middle_x - half_width).ceil() as usize, (2.0 * half_width) as usize);
    let ((row, rows_in), (col, cols_in)) =
        if vertical { (rect_along, rect_across) } else { (rect_across, rect_along) };
    let rect = Rect { row, col, rows: rows_in, cols: cols_in };
    check_region(rect, rows, cols)?;
    edge_sfr(planes, plane, rect, &EsfrOptions::default()).map(|_| rect)
}

/// An edge at `intercept + slope * y` on the lines `first` to `last`.
struct LocatedEdge {
    intercept: f64,
    slope: f64,
    first: usize,
    last: usize,
}

fn locate(
    length: usize,
    width: usize,
    sample: impl Fn(usize, usize) -> f64,
) -> Result<LocatedEdge, MetricError> {
    let step = (length / MAXIMUM_LINES).max(1);
    let steepest = |y: usize| {
        let slope = |x: usize| (sample(y, x + 1) - sample(y, x - 1)).abs();
        (BORDER..width - BORDER).map(|x| (slope(x), x)).fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
    };
    let all: Vec<(usize, f64, usize)> = (BORDER..length - BORDER)
        .step_by(step)
        .map(|y| (y, steepest(y)))
        .map(|(y, (s, x))| (y, s, x))
        .collect();
    let largest = all.iter().fold(0.0f64, |m, l| m.max(l.1));
    let places: Vec<(f64, f64)> =
        all.iter().filter(|l| l.1 > 0.3 * largest).map(|l| (l.0 as f64, l.2 as f64)).collect();
    let slopes = (0..places.len())
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .map(|(i, j)| (places[i].1 - places[j].1) / (places[i].0 - places[j].0));
    let slope = median(slopes.collect());
    let intercept = median(places.iter().map(|p| p.1 - slope * p.0).collect());
    let agrees = |p: &&(f64, f64)| (p.1 - intercept - slope * p.0).abs() <= TOLERANCE_PX;
    let (first, last) = (places.iter().find(agrees), places.iter().rfind(agrees));
    let agreeing = places.iter().filter(agrees).count();
    match (first, last) {
        (Some(first), Some(last)) if largest > 0.0 && 4 * agreeing > all.len() && slope.abs() <= 1.0 => {
            Ok(LocatedEdge { intercept, slope, first: first.0 as usize, last: last.0 as usize })
        }
        _ => Err(MetricError::NoEdge("the steepest places do not lie on one straight line")),
    }
}

/// The median; 0 without values.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
