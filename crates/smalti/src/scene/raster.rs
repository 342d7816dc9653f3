//! Polygon rasterisation with exact area coverage of each pixel.

/// Grey values of an image. Pixel `(r, c)` covers `c..c+1` × `r..r+1` in the (x, y) coordinates of the
/// shapes.
#[derive(Debug, Clone)]
pub(super) struct Canvas {
    rows: usize,
    cols: usize,
    values: Vec<f32>,
}

/// A closed polygon: its corners (x, y) in order.
pub(super) type Contour = Vec<[f64; 2]>;

impl Canvas {
    /// A uniform canvas.
    pub(super) fn new(rows: usize, cols: usize, value: f32) -> Self {
        Self { rows, cols, values: vec![value; rows * cols] }
    }

    /// The grey values in row order.
    pub(super) fn values(&self) -> &[f32] {
        &self.values
    }

    /// Fills the inside of the contours. Contours may touch, and a contour of the opposite direction inside
    /// another is a hole. Other overlaps are not allowed.
    pub(super) fn fill(&mut self, contours: &[Contour], value: f32) {
        let points = || contours.iter().flatten();
        if !points().all(|p| p[0].is_finite() && p[1].is_finite()) {
            return;
        }
        let range = |axis: usize, size: usize| {
            let low = points().fold(f64::INFINITY, |m, p| m.min(p[axis])).floor().clamp(0.0, size as f64);
            let high = points().fold(0.0f64, |m, p| m.max(p[axis])).ceil().clamp(low, size as f64);
            (low as usize, high as usize)
        };
        let ((left, right), (top, bottom)) = (range(0, self.cols), range(1, self.rows));
        if left == right || top == bottom {
            return;
        }
        let width = right - left;
        // One extra column holds the area to the right of an edge in the last pixel.
        let mut change = vec![0.0f64; (width + 1) * (bottom - top)];
        for contour in contours {
            for (i, &a) in contour.iter().enumerate() {
                let b = contour[(i + 1) % contour.len()];
                add_edge(
                    &mut change,
                    width,
                    [a[0] - left as f64, a[1] - top as f64],
                    [b[0] - left as f64, b[1] - top as f64],
                );
            }
        }
        for (r, change) in change.chunks_exact(width + 1).enumerate() {
            let at = (top + r) * self.cols + left;
            let mut covered = 0.0f64;
            for (v, d) in self.values[at..at + width].iter_mut().zip(change) {
                covered += d;
                let share = covered.abs().min(1.0) as f32;
                *v += (value - *v) * share;
            }
        }
    }
}

/// Adds an edge to the coverage differences between pixels. Their sum along a row up to a pixel is the signed
/// area of that pixel to the right of the edges.
fn add_edge(change: &mut [f64], width: usize, a: [f64; 2], b: [f64; 2]) {
    let (sign, a, b) = if a[1] <= b[1] { (1.0, a, b) } else { (-1.0, b, a) };
    let rows = change.len() / (width + 1);
    let slope = (b[0] - a[0]) / (b[1] - a[1]);
    let (top, bottom) = (a[1].max(0.0), b[1].min(rows as f64));
    if top >= bottom {
        return;
    }
    for row in top as usize..(bottom.ceil() as usize).min(rows) {
        let (y0, y1) = (top.max(row as f64), bottom.min(row as f64 + 1.0));
        let (x0, x1) = (a[0] + (y0 - a[1]) * slope, a[0] + (y1 - a[1]) * slope);
        let line = &mut change[row * (width + 1)..(row + 1) * (width + 1)];
        add_piece(line, x0.min(x1), x0.max(x1), sign * (y1 - y0));
    }
}

/// The part of an edge within one row, from `x0` to `x1 >= x0`, with the signed height `height`.
fn add_piece(line: &mut [f64], x0: f64, x1: f64, height: f64) {
    let width = line.len() - 1;
    let share = |from: f64, to: f64| if x1 > x0 { (to - from) / (x1 - x0) } else { 1.0 };
    if x0 < 0.0 {
        line[0] += height * share(x0, x1.min(0.0));
        if x1 <= 0.0 {
            return;
        }
    }
    let mut from = x0.max(0.0);
    while from < width as f64 {
        let col = (from as usize).min(width - 1);
        let to = x1.min(col as f64 + 1.0);
        let part = height * share(from, to);
        let right = (from + to) / 2.0 - col as f64;
        line[col] += part * (1.0 - right);
        line[col + 1] += part * right;
        if to >= x1 {
            break;
        }
        from = to;
    }
}

/// A rectangle of `width` × `height` about `centre`, rotated by `angle_rad` from x to y.
pub(super) fn rectangle(centre: [f64; 2], width: f64, height: f64, angle_rad: f64) -> Contour {
    let (s, c) = angle_rad.sin_cos();
    [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
        .map(|(u, v)| {
            let (u, v) = (u * width, v * height);
            [centre[0] + c * u - s * v, centre[1] + s * u + c * v]
        })
        .to_vec()
}

/// A sector of an annulus about `centre` between two radii and two angles, rad.
pub(super) fn sector(centre: [f64; 2], radii: [f64; 2], angles_rad: [f64; 2]) -> Contour {
    let arc = |radius: f64, from: f64, to: f64| {
        let n = arc_pieces(radius, (to - from).abs());
        (0..=n).map(move |i| {
            let (s, c) = (from + (to - from) * i as f64 / n as f64).sin_cos();
            [centre[0] + radius * c, centre[1] + radius * s]
        })
    };
    let [from, to] = angles_rad;
    arc(radii[1], from, to).chain(arc(radii[0], to, from)).collect()
}

/// A disc, approximated by a regular polygon.
pub(super) fn disc(centre: [f64; 2], radius: f64) -> Contour {
    let turn = std::f64::consts::TAU;
    let n = arc_pieces(radius, turn);
    (0..n)
        .map(|i| (turn * i as f64 / n as f64).sin_cos())
        .map(|(s, c)| [centre[0] + radius * c, centre[1] + radius * s])
        .collect()
}

/// A ring: the outer circle and, as a hole, the inner one.
pub(super) fn ring(centre: [f64; 2], inner: f64, outer: f64) -> [Contour; 2] {
    let mut hole = disc(centre, inner);
    hole.reverse();
    [disc(centre, outer), hole]
}

/// Number of segments for which the distance between chord and arc is at most 0.002 pixels.
fn arc_pieces(radius: f64, angle_rad: f64) -> usize {
    let step = (8.0 * 0.002 / radius.max(0.01)).sqrt().min(0.5);
    ((angle_rad / step).ceil() as usize).clamp(1, 1 << 14)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(rows: usize, cols: usize, contours: &[Contour]) -> f64 {
        let mut canvas = Canvas::new(rows, cols, 0.0);
        canvas.fill(contours, 1.0);
        assert!(canvas.values().iter().all(|v| (0.0..=1.0).contains(v)));
        canvas.values().iter().map(|&v| f64::from(v)).sum()
    }

    #[test]
    fn covers_the_area_of_the_shape() {
        // Values are in single precision, so areas agree to about 1e-6 of the number of pixels covered.
        let turned = rectangle([10.3, 9.8], 7.0, 4.5, 0.3);
        assert!((area(20, 20, &[turned]) - 31.5).abs() < 1e-4);
        let circle = disc([10.2, 10.1], 6.0);
        assert!((area(20, 20, &[circle]) / (std::f64::consts::PI * 36.0) - 1.0).abs() < 1e-3);
        let hollow = ring([10.0, 10.0], 3.0, 6.0);
        assert!((area(20, 20, &hollow) / (std::f64::consts::PI * 27.0) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn shares_of_a_pixel_are_exact() {
        let mut canvas = Canvas::new(1, 2, 0.0);
        canvas.fill(&[vec![[0.25, 0.0], [1.5, 0.0], [1.5, 0.5], [0.25, 0.5]]], 1.0);
        assert_eq!(canvas.values(), &[0.375, 0.25]);
        let mut canvas = Canvas::new(1, 1, 0.0);
        canvas.fill(&[vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]], 1.0);
        assert_eq!(canvas.values(), &[0.5]);
    }

    #[test]
    fn what_lies_outside_is_cut_off() {
        let big = rectangle([5.0, 5.0], 1e6, 1e6, 0.7);
        assert!((area(10, 10, &[big]) - 100.0).abs() < 1e-4);
        assert_eq!(area(10, 10, &[rectangle([-20.0, 5.0], 4.0, 4.0, 0.1)]), 0.0);
        assert_eq!(area(10, 10, &[rectangle([5.0, 40.0], 4.0, 4.0, 0.1)]), 0.0);
        // Half of a disc that is centred on the border.
        let half = area(20, 20, &[disc([0.0, 10.0], 5.0)]);
        assert!((half / (std::f64::consts::PI * 12.5) - 1.0).abs() < 1e-3);
        assert_eq!(area(4, 4, &[vec![[f64::NAN, 0.0], [1.0, 0.0], [0.0, 1.0]]]), 0.0);
        assert_eq!(area(4, 4, &[]), 0.0);
    }
}
