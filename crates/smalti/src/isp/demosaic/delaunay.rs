//! Weights of linear interpolation between the samples of one channel of a periodic mosaic.
//!
//! A pixel is interpolated in its Delaunay cell, the samples on the empty circle around it. In a triangular cell, the weights
//! are the barycentric coordinates of the pixel. Since the samples of a mosaic lie on a lattice, cells often have four or more
//! samples on one circle, and their triangulation is not unique. The weights are then the mean over the fan triangulations
//! from each corner, which keeps the symmetry of the cell. On Bayer mosaics this is bilinear interpolation.
//!
//! Linear functions are reproduced, and the samples are the nearest that enclose the pixel. All decisions use integers and do
//! not depend on rounding.

/// Search radius for samples, pixels.
pub(super) const MAX_REACH: i64 = 64;

/// A position relative to the pixel, (row, column).
type Offset = (i64, i64);

/// Twice the area of a triangle, positive when `a`, `b`, `c` turn from the row axis towards the column axis.
fn orient(a: Offset, b: Offset, c: Offset) -> i64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

/// Positive when `p` is inside the circle through `a`, `b`, `c` (which must turn positively), 0 on it.
fn in_circle(a: Offset, b: Offset, c: Offset, p: Offset) -> i64 {
    // With offsets up to 64 the terms stay below 2^34.
    let lift = |v: Offset| (v.0 - p.0, v.1 - p.1, (v.0 - p.0).pow(2) + (v.1 - p.1).pow(2));
    let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (lift(a), lift(b), lift(c));
    ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx)
}

/// Offsets and weights (sum 1) with which `is_sample`, a periodic set of pixels, gives the value at (0, 0).
/// `None` when no samples enclose it within [`MAX_REACH`].
pub(super) fn weights(is_sample: impl Fn(i64, i64) -> bool) -> Option<Vec<(Offset, f64)>> {
    if is_sample(0, 0) {
        return Some(vec![((0, 0), 1.0)]);
    }
    let mut reach = 4;
    while reach <= MAX_REACH {
        let square = (-reach..=reach).flat_map(|r| (-reach..=reach).map(move |c| (r, c)));
        let mut near: Vec<Offset> = square.filter(|&(r, c)| is_sample(r, c)).collect();
        near.sort_unstable_by_key(|&(r, c)| (r * r + c * c, r, c));
        if let Some(cell) = enclosing_cell(&near)
            && circle_within(&cell, reach)
        {
            return Some(fan_mean(&cell));
        }
        reach *= 2;
    }
    None
}

/// The corners, in turn, of the Delaunay cell that holds the origin; `near` is sorted by distance from it.
fn enclosing_cell(near: &[Offset]) -> Option<Vec<Offset>> {
    let origin = (0, 0);
    let &start = near.first()?;
    // The edge to the nearest neighbour belongs to every Delaunay triangulation.
    let distance = |p: Offset| (p.0 - start.0).pow(2) + (p.1 - start.1).pow(2);
    let &neighbour = near[1..].iter().min_by_key(|&&p| (distance(p), p))?;
    let edge = if orient(start, neighbour, origin) >= 0 { (start, neighbour) } else { (neighbour, start) };
    let mut cell = cell_left_of(near, edge.0, edge.1).or_else(|| cell_left_of(near, edge.1, edge.0))?;
    // The walk towards the origin never returns to a cell (Edelsbrunner 1990); the bound is a safeguard.
    for _ in 0..near.len() {
        let corners = cell.iter().zip(cell.iter().cycle().skip(1));
        match corners.map(|(&a, &b)| (a, b)).find(|&(a, b)| orient(a, b, origin) < 0) {
            Some((a, b)) => cell = cell_left_of(near, b, a)?,
            None => return Some(cell),
        }
    }
    None
}

/// The Delaunay cell on the positive side of its edge `a`–`b`; `None` at the hull.
fn cell_left_of(near: &[Offset], a: Offset, b: Offset) -> Option<Vec<Offset>> {
    let left = || near.iter().copied().filter(|&p| orient(a, b, p) > 0);
    let third = left().reduce(|best, p| if in_circle(a, b, best, p) > 0 { p } else { best })?;
    let mut cell: Vec<Offset> = left().filter(|&p| in_circle(a, b, third, p) == 0).collect();
    cell.push(b);
    cell.sort_unstable_by(|&p, &q| 0.cmp(&orient(a, p, q)));
    cell.insert(0, a);
    Some(cell)
}

/// Whether the circle through the corners lies within the search radius.
fn circle_within(cell: &[Offset], reach: i64) -> bool {
    let &[a, b, c, ..] = cell else { return false };
    let (bx, by, cx, cy) = (b.0 - a.0, b.1 - a.1, c.0 - a.0, c.1 - a.1);
    let (b2, c2) = ((bx * bx + by * by) as f64, (cx * cx + cy * cy) as f64);
    let d = 2.0 * orient(a, b, c) as f64;
    let (x, y) = ((cy as f64 * b2 - by as f64 * c2) / d, (bx as f64 * c2 - cx as f64 * b2) / d);
    let radius = x.hypot(y);
    let centre = (x + a.0 as f64).abs().max((y + a.1 as f64).abs());
    // Samples outside the search radius are at least reach + 1 away.
    centre + radius < reach as f64 + 1.0 - 1e-6
}

/// Barycentric coordinates of the origin, averaged over the fan triangulations from each corner of a convex cell.
fn fan_mean(cell: &[Offset]) -> Vec<(Offset, f64)> {
    let (origin, n) = ((0, 0), cell.len());
    let mut sum = vec![0.0; n];
    for apex in 0..n {
        let triangle = (1..n - 1)
            .map(|k| [apex, (apex + k) % n, (apex + k + 1) % n])
            .find(|t| (0..3).all(|i| orient(cell[t[i]], cell[t[(i + 1) % 3]], origin) >= 0));
        let Some(t) = triangle else { continue };
        let area = orient(cell[t[0]], cell[t[1]], cell[t[2]]) as f64;
        for i in 0..3 {
            let opposite = orient(cell[t[(i + 1) % 3]], cell[t[(i + 2) % 3]], origin);
            sum[t[i]] += opposite as f64 / area / n as f64;
        }
    }
    cell.iter().copied().zip(sum).filter(|&(_, w)| w > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;
    use approx::assert_abs_diff_eq;

    fn sorted(mut w: Vec<(Offset, f64)>) -> Vec<(Offset, f64)> {
        w.sort_by_key(|w| w.0);
        w
    }

    #[test]
    fn bayer_is_bilinear() {
        let red = |r: i64, c: i64| r.rem_euclid(2) == 0 && c.rem_euclid(2) == 0;
        let at = |row: i64, col: i64| sorted(weights(|r, c| red(r + row, c + col)).unwrap());
        assert_eq!(at(0, 0), [((0, 0), 1.0)]);
        assert_eq!(at(0, 1), [((0, -1), 0.5), ((0, 1), 0.5)]);
        assert_eq!(at(1, 0), [((-1, 0), 0.5), ((1, 0), 0.5)]);
        assert_eq!(at(1, 1), [((-1, -1), 0.25), ((-1, 1), 0.25), ((1, -1), 0.25), ((1, 1), 0.25)]);
        let green = sorted(weights(|r, c| (r + c).rem_euclid(2) == 1).unwrap());
        assert_eq!(green, [((-1, 0), 0.25), ((0, -1), 0.25), ((0, 1), 0.25), ((1, 0), 0.25)]);
    }

    /// One sample in 3 × 3: the mean of the two diagonals of the square.
    #[test]
    fn square_of_three() {
        let w = sorted(weights(|r, c| (r + 1).rem_euclid(3) == 0 && (c + 1).rem_euclid(3) == 0).unwrap());
        let expected = [((-1, -1), 0.5), ((-1, 2), 1.0 / 6.0), ((2, -1), 1.0 / 6.0), ((2, 2), 1.0 / 6.0)];
        for (got, expected) in w.iter().zip(expected) {
            assert_eq!(got.0, expected.0);
            assert_abs_diff_eq!(got.1, expected.1, epsilon = 1e-15);
        }
    }

    #[test]
    fn linear_functions_are_reproduced() {
        let mut random = Stream::new(1, 0, 0);
        for _ in 0..300 {
            let (rows, cols) = (1 + i64::from(random.below(9)), 1 + i64::from(random.below(9)));
            let mut tile: Vec<bool> = (0..rows * cols).map(|_| random.below(4) == 0).collect();
            tile[random.below((rows * cols) as u32) as usize] = true;
            let sample = |r: i64, c: i64| tile[(r.rem_euclid(rows) * cols + c.rem_euclid(cols)) as usize];
            for (row, col) in (0..rows).flat_map(|r| (0..cols).map(move |c| (r, c))) {
                let w = weights(|r, c| sample(r + row, c + col)).unwrap();
                let sum = |f: fn(Offset) -> i64| w.iter().map(|&(o, w)| f(o) as f64 * w).sum::<f64>();
                assert_abs_diff_eq!(sum(|_| 1), 1.0, epsilon = 1e-12);
                assert_abs_diff_eq!(sum(|o| o.0), 0.0, epsilon = 1e-12);
                assert_abs_diff_eq!(sum(|o| o.1), 0.0, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn a_channel_too_sparse_is_seen() {
        assert!(weights(|r, c| r == 3 && c == 3).is_none());
        assert!(weights(|_, _| false).is_none());
        assert!(weights(|r, c| r.rem_euclid(200) == 100 && c.rem_euclid(200) == 100).is_none());
        assert!(weights(|_, c| c.rem_euclid(40) == 20).is_some());
    }
}
