//! Location of the edge: lines of samples across it, the centroid on each line, and the straight line through the centroids.

use std::f64::consts::PI;

use super::options::{CentroidWindow, EdgeOrientation};
use crate::metrics::error::at_least;
use crate::metrics::{MetricError, Rect};

/// Least number of pixels of a region in each direction, for two plateaus and an edge.
const MINIMUM_SIDE: usize = 8;

/// Lines of samples across the edge.
pub(super) struct Lines {
    /// For each line the positions along the line, pixels, and the values. A line may be empty.
    pub(super) lines: Vec<Vec<(f64, f64)>>,
    /// Number of pixels along a line, including those without samples.
    pub(super) width: usize,
}

/// A straight edge at `intercept + slope * y` on line `y`, pixels.
pub(super) struct EdgeLine {
    pub(super) intercept: f64,
    pub(super) slope: f64,
    pub(super) residual_rms: f64,
}

/// The samples of a region as lines across its edge: rows for a vertical edge, columns for a horizontal one.
pub(super) fn gather(
    rect: Rect,
    value: impl Fn(usize, usize) -> Option<f64>,
) -> Result<(EdgeOrientation, Lines), MetricError> {
    at_least("pixels along the shorter side of the edge region", MINIMUM_SIDE, rect.rows.min(rect.cols))?;
    // Sums and counts of the outer thirds: left, right, top, bottom. Their larger difference gives the direction across the
    // edge.
    let mut outer = [(0.0, 0usize); 4];
    for row in 0..rect.rows {
        for col in 0..rect.cols {
            let Some(v) = value(rect.row + row, rect.col + col) else { continue };
            if !v.is_finite() {
                let index = row * rect.cols + col;
                return Err(MetricError::NotFinite { what: "the edge region", index });
            }
            let (h, w) = (rect.rows / 3, rect.cols / 3);
            let inside = [col < w, col >= rect.cols - w, row < h, row >= rect.rows - h];
            for (sum, _) in outer.iter_mut().zip(inside).filter(|(_, inside)| *inside) {
                *sum = (sum.0 + v, sum.1 + 1);
            }
        }
    }
    let mean = |(sum, count): (f64, usize)| sum / count.max(1) as f64;
    let [left, right, top, bottom] = outer.map(mean);
    let vertical = (left - right).abs() >= (top - bottom).abs();
    let (orientation, count, width) = if vertical {
        (EdgeOrientation::Vertical, rect.rows, rect.cols)
    } else {
        (EdgeOrientation::Horizontal, rect.cols, rect.rows)
    };
    let sample = |line: usize, x: usize| {
        let (row, col) = if vertical { (line, x) } else { (x, line) };
        value(rect.row + row, rect.col + col).map(|v| (x as f64, v))
    };
    let lines = (0..count).map(|line| (0..width).filter_map(|x| sample(line, x)).collect()).collect();
    Ok((orientation, Lines { lines, width }))
}

/// The straight edge through the centroids of the lines: once with a window on the middle of the region, once
/// with windows centred on the first fit.
pub(super) fn fit(lines: &Lines, windows: CentroidWindow) -> Result<EdgeLine, MetricError> {
    let middle = (lines.width - 1) as f64 / 2.0;
    // sfrmat counts positions from 1 and places its window on differences that lie half a pixel earlier.
    let (shift, ahead) = match windows {
        CentroidWindow::OnEdge => (0.0, 0.0),
        CentroidWindow::Sfrmat => (-0.5, 1.0),
    };
    let first = fit_once(lines, windows, |_| middle + shift)?;
    let fit = fit_once(lines, windows, |y| first.intercept + first.slope * (y + ahead) + shift)?;
    let at_middle = fit.intercept + fit.slope * (lines.lines.len() - 1) as f64 / 2.0;
    if !(0.0..=(lines.width - 1) as f64).contains(&at_middle) {
        return Err(MetricError::NoEdge("the fitted line misses the middle of the region"));
    }
    if fit.residual_rms > lines.width as f64 / 8.0 {
        return Err(MetricError::NoEdge("its lines do not agree on a straight edge"));
    }
    Ok(fit)
}

fn fit_once(
    lines: &Lines,
    windows: CentroidWindow,
    centre: impl Fn(f64) -> f64,
) -> Result<EdgeLine, MetricError> {
    let last = (lines.width - 1) as f64;
    let located: Vec<(f64, f64)> = lines
        .lines
        .iter()
        .enumerate()
        .filter_map(|(i, line)| {
            let y = i as f64;
            centroid(line, windows, centre(y), last).filter(|x| (0.0..=last).contains(x)).map(|x| (y, x))
        })
        .collect();
    let with_samples = lines.lines.iter().filter(|l| !l.is_empty()).count();
    if located.len() < 4 || 2 * located.len() < with_samples {
        return Err(MetricError::NoEdge("most lines show no step"));
    }
    let n = located.len() as f64;
    let (mean_y, mean_x) = located.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let (yy, xy) = located.iter().fold((0.0, 0.0), |s, &(y, x)| {
        (s.0 + (y - mean_y) * (y - mean_y), s.1 + (y - mean_y) * (x - mean_x))
    });
    let slope = xy / yy;
    let intercept = mean_x - slope * mean_y;
    let squares: f64 = located.iter().map(|&(y, x)| (x - intercept - slope * y).powi(2)).sum();
    Ok(EdgeLine { intercept, slope, residual_rms: (squares / n).sqrt() })
}

/// Centroid of the differences between neighbouring samples under a Hamming window that peaks at `centre` and
/// ends at the farther end of the line. The sign of the edge cancels. `None` for a constant line.
fn centroid(line: &[(f64, f64)], windows: CentroidWindow, centre: f64, last: f64) -> Option<f64> {
    let differences = line.windows(2).filter_map(|pair| match *pair {
        [(x0, v0), (x1, v1)] => Some(((x0 + x1) / 2.0, v1 - v0)),
        _ => None,
    });
    let (margin, repeated) = match windows {
        CentroidWindow::OnEdge => (0.0, None),
        // sfrmat keeps the number of values by repeating the first difference.
        CentroidWindow::Sfrmat => (0.5, differences.clone().next().map(|(x, d)| (x - 1.0, d))),
    };
    let half_width = (centre + margin).max(last - margin - centre);
    let (mut sum, mut moment, mut size) = (0.0, 0.0, 0.0);
    for (x, difference) in repeated.into_iter().chain(differences) {
        let weighted = difference * hamming(x - centre, half_width);
        sum += weighted;
        moment += weighted * x;
        size += weighted.abs();
    }
    (sum.abs() > 1e-9 * size).then(|| moment / sum)
}

/// Hamming window: 1 at 0, 0.08 at `half_width`, 0 beyond.
pub(super) fn hamming(distance: f64, half_width: f64) -> f64 {
    if distance.abs() > half_width { 0.0 } else { 0.54 + 0.46 * (PI * distance / half_width).cos() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines of 40 pixels across a step at a place of each line.
    fn lines(count: usize, place: impl Fn(usize) -> f64) -> Lines {
        let value = |x: usize, at: f64| (x as f64 - at).clamp(-0.5, 0.5);
        let line = |y: usize| (0..40).map(|x| (x as f64, value(x, place(y)))).collect();
        Lines { lines: (0..count).map(line).collect(), width: 40 }
    }

    /// Also where the edge enters and leaves the region through its long sides.
    #[test]
    fn a_straight_edge_is_found() {
        for windows in [CentroidWindow::OnEdge, CentroidWindow::Sfrmat] {
            for (count, intercept, slope) in
                [(24, 18.3, 0.13), (24, 26.0, -0.31), (60, -5.2, 0.84), (60, 44.1, -0.8)]
            {
                let line = lines(count, |y| intercept + slope * y as f64);
                let fit = fit(&line, windows).unwrap();
                let middle = |intercept: f64, slope: f64| intercept + slope * (count - 1) as f64 / 2.0;
                let off = (middle(fit.intercept, fit.slope) - middle(intercept, slope)).abs();
                // A pixel on the border of the region shows where the edge is to half a pixel.
                assert!((fit.slope - slope).abs() < 0.02 && off < 0.2, "{slope}: {} {off}", fit.slope);
                assert!(fit.residual_rms < 1.0, "{slope}: {}", fit.residual_rms);
            }
        }
    }

    #[test]
    fn an_inverted_step_lies_at_the_same_place() {
        let upright = lines(30, |y| 17.0 + 0.2 * y as f64);
        let turned = |line: &Vec<(f64, f64)>| line.iter().map(|&(x, v)| (x, 3.0 - 2.0 * v)).collect();
        let inverted = Lines { lines: upright.lines.iter().map(turned).collect(), width: 40 };
        for windows in [CentroidWindow::OnEdge, CentroidWindow::Sfrmat] {
            let [a, b] = [&upright, &inverted].map(|lines| fit(lines, windows).unwrap());
            assert!((a.intercept - b.intercept).abs() < 1e-9 && (a.slope - b.slope).abs() < 1e-9);
        }
    }

    #[test]
    fn what_is_no_straight_edge_says_why() {
        let reason = |lines: &Lines| match fit(lines, CentroidWindow::OnEdge) {
            Err(MetricError::NoEdge(reason)) => reason,
            _ => panic!("an edge"),
        };
        // Steps in turn far to the left and to the right.
        let torn = lines(24, |y| if y % 4 == 0 || y % 4 == 3 { 10.0 } else { 29.0 });
        assert!(reason(&torn).contains("do not agree"));
        let flat = Lines { lines: vec![(0..40).map(|x| (f64::from(x), 0.7)).collect(); 24], width: 40 };
        assert!(reason(&flat).contains("no step"));
        // The line through the few samples that there are leaves the region before its middle.
        let mut part = lines(60, |y| 2.0 + 2.2 * y as f64);
        part.lines[17..].iter_mut().for_each(Vec::clear);
        assert!(reason(&part).contains("misses the middle"));
    }

    #[test]
    fn regions_are_read_across_their_edge() {
        let rect = Rect { row: 2, col: 3, rows: 9, cols: 12 };
        let (orientation, found) = gather(rect, |_, col| (col % 2 == 1).then_some(col as f64)).unwrap();
        assert_eq!((orientation, found.lines.len(), found.width), (EdgeOrientation::Vertical, 9, 12));
        let expected: Vec<(f64, f64)> = (0..6).map(|i| (f64::from(2 * i), f64::from(2 * i + 3))).collect();
        assert!(found.lines.iter().all(|line| *line == expected));
        let (orientation, found) = gather(rect, |row, _| Some(row as f64)).unwrap();
        assert_eq!((orientation, found.lines.len(), found.width), (EdgeOrientation::Horizontal, 12, 9));
        assert!(found.lines.iter().all(|l| l.iter().all(|(x, v)| *v == x + 2.0) && l.len() == 9));
    }

    #[test]
    fn a_single_step_has_its_centroid_there_and_a_constant_line_has_none() {
        for at in [3.0, 19.0, 30.0] {
            let line: Vec<(f64, f64)> =
                (0..40).map(|x| (f64::from(x), if f64::from(x) < at { 0.2 } else { 0.9 })).collect();
            for windows in [CentroidWindow::OnEdge, CentroidWindow::Sfrmat] {
                for centre in [10.0, 19.5] {
                    let found = centroid(&line, windows, centre, 39.0).unwrap();
                    assert!((found - (at - 0.5)).abs() < 1e-12, "{at}: {found}");
                    let constant: Vec<(f64, f64)> = line.iter().map(|p| (p.0, 0.7)).collect();
                    assert_eq!(centroid(&constant, windows, centre, 39.0), None);
                }
            }
        }
    }
}
