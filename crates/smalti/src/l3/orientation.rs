//! Orientation of edges from the structure tensor of a patch.

use super::blocks::{Columns, LANES, add_taps, each, values, values_mut};
use super::lattice::Shift;
use super::window::Strip;
use super::{MAX_SIDE, Textures};

/// Minimum coherence of the structure tensor of an edge: (λ₁ − λ₂) / (λ₁ + λ₂) of its eigenvalues.
const COHERENT: f32 = Textures::EDGE_COHERENCE as f32;

/// Column sums of the tensor's entries over the patches: down · down, down · right, right · right.
#[derive(Debug, Default)]
pub(super) struct Tensor([Vec<f32>; 3]);

/// Estimation of gradients from differences between samples of equal channels, along two translations of the
/// mosaic. At every pixel of a patch both differences are centred on that pixel (to half a pixel), so that
/// they describe the same point of the scene. They extend beyond the patch by half a translation.
#[derive(Debug, Clone)]
pub(super) struct Orientation {
    half: usize,
    /// End points of the two differences, relative to the pixel.
    ends: [[Shift; 2]; 2],
    /// Matrix from the differences along the two translations to the gradient along rows and columns, per
    /// pixel.
    gradient: [[f32; 2]; 2],
}

impl Orientation {
    pub(super) fn new(shifts: [Shift; 2], half: usize) -> Self {
        let [[a, b], [c, d]] = shifts.map(|s| s.map(|v| v as f32));
        let det = a * d - b * c;
        let ends = |s: Shift| {
            let start = s.map(|v| -v.div_euclid(2));
            [start, [start[0] + s[0], start[1] + s[1]]]
        };
        // The translations are the rows of a matrix that maps gradients to differences; this is its inverse.
        Self { half, ends: shifts.map(ends), gradient: [[d / det, -b / det], [-c / det, a / det]] }
    }

    /// Distance from the centre of the farthest sample read, in rows and columns.
    pub(super) fn reach(&self) -> [usize; 2] {
        let far = |axis: usize| self.ends.iter().flatten().map(|end| end[axis].unsigned_abs()).max();
        [0, 1].map(|axis| self.half + far(axis).unwrap_or(0))
    }

    /// Adds 1 to 4 to textures with a dominant orientation. `local` is a multiple of `kinds` where a patch is
    /// flat, and one more where it is texture.
    #[inline(always)]
    pub(super) fn row(&self, strip: &Strip<'_>, tensor: &mut Tensor, kinds: u32, local: &mut [u32]) {
        let half = self.half as isize;
        let ends = self.ends.as_flattened();
        let mut lines = [[&[] as &[f32]; 4]; MAX_SIDE];
        let lines = &mut lines[..2 * self.half + 1];
        for (entry, r) in lines.iter_mut().zip(strip.row - half..) {
            for (line, end) in entry.iter_mut().zip(ends) {
                *line = strip.window.line(r + end[0]);
            }
        }
        let mut from = [0; 4];
        for (from, end) in from.iter_mut().zip(ends) {
            *from = strip.at(end[1] - half);
        }
        let len = (strip.len + 2 * self.half).next_multiple_of(LANES);
        tensor.0.iter_mut().for_each(|sums| sums.resize(len, 0.0));
        each(len, &mut Sums { lines, from, gradient: self.gradient, tensor });
        each(strip.len, &mut Directions { tensor, side: 2 * self.half + 1, kinds, local });
    }
}

/// Column sums of the tensor.
struct Sums<'a> {
    /// For each row of the patch, the lines of the end points of both differences.
    lines: &'a [[&'a [f32]; 4]],
    from: [usize; 4],
    gradient: [[f32; 2]; 2],
    tensor: &'a mut Tensor,
}

impl Columns for Sums<'_> {
    #[inline(always)]
    fn columns<const W: usize>(&mut self, at: usize) {
        let [[g00, g01], [g10, g11]] = self.gradient;
        let (mut dd, mut dr, mut rr) = ([0.0; W], [0.0; W], [0.0; W]);
        for line in self.lines {
            let [p0, p1, q0, q1] = [0, 1, 2, 3].map(|end| values::<f32, W>(line[end], self.from[end] + at));
            let (Some(p0), Some(p1), Some(q0), Some(q1)) = (p0, p1, q0, q1) else { return };
            for i in 0..W {
                let (along_p, along_q) = (p1[i] - p0[i], q1[i] - q0[i]);
                let down = g00 * along_p + g01 * along_q;
                let right = g10 * along_p + g11 * along_q;
                dd[i] += down * down;
                dr[i] += down * right;
                rr[i] += right * right;
            }
        }
        for (out, sums) in self.tensor.0.iter_mut().zip([dd, dr, rr]) {
            if let Some(out) = values_mut(out, at) {
                *out = sums;
            }
        }
    }
}

/// Classification by the tensor.
struct Directions<'a> {
    tensor: &'a Tensor,
    side: usize,
    kinds: u32,
    local: &'a mut [u32],
}

impl Columns for Directions<'_> {
    #[inline(always)]
    fn columns<const W: usize>(&mut self, at: usize) {
        let (mut dd, mut dr, mut rr) = ([0.0; W], [0.0; W], [0.0; W]);
        for (total, sums) in [&mut dd, &mut dr, &mut rr].into_iter().zip(&self.tensor.0) {
            add_taps(total, sums, at, self.side);
        }
        let Some(local) = values_mut::<u32, W>(self.local, at) else { return };
        for i in 0..W {
            let (difference, twice, all) = (rr[i] - dd[i], 2.0 * dr[i], COHERENT * (dd[i] + rr[i]));
            // λ₁ − λ₂ > COHERENT (λ₁ + λ₂), with both sides squared. The strict inequality excludes patches
            // without any gradient.
            let edge = difference * difference + twice * twice > all * all;
            let textured = local[i] % self.kinds != 0;
            // The angle of the gradient is half that of (difference, twice).
            local[i] += if edge & textured { 1 + direction(difference, twice) } else { 0 };
        }
    }
}

/// The index of the orientation (0°, 45°, 90°, 135°, from right towards down) nearest to half the angle of
/// (`cos`, `sin`).
#[inline(always)]
pub(super) fn direction(cos: f32, sin: f32) -> u32 {
    // Doubled, the orientations are 0°, 90°, 180° and 270°.
    let along = if cos >= 0.0 { 0 } else { 2 };
    let slanted = if sin > 0.0 { 1 } else { 3 };
    if cos.abs() >= sin.abs() { along } else { slanted }
}

/// The same for eight orientations, a multiple of 22.5° each.
#[inline(always)]
pub(super) fn fine_direction(cos: f32, sin: f32) -> u32 {
    /// The tangent of 22.5°.
    const TAN: f32 = std::f32::consts::SQRT_2 - 1.0;
    let (along, across) = (cos.abs(), sin.abs());
    // Doubled, the orientations are multiples of 45°: 0°, 45° or 90° from the axis of the cosine.
    let from_axis = u32::from(across > TAN * along) + u32::from(TAN * across >= along);
    let turned = if cos >= 0.0 { from_axis } else { 4 - from_axis };
    if sin > 0.0 { turned } else { (8 - turned) % 8 }
}

#[cfg(test)]
mod tests {
    use super::super::classify::{Classifier, RowClasses};
    use super::super::window::Window;
    use super::super::{Axes, Levels, Textures};
    use crate::isp::source::Source;
    use crate::sensor::{Mosaic, SignalNoise};

    fn mosaics() -> [Mosaic; 3] {
        [
            Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap(),
            Mosaic::new(3, 3, (0..9).collect()).unwrap(),
            // Repeats along a knight's move.
            Mosaic::new(5, 5, (0..25).map(|i| ((i % 5 + 3 * (i / 5)) % 5) as u8).collect()).unwrap(),
        ]
    }

    fn textures(mosaic: &Mosaic, side: usize, image: &[f32], size: [usize; 2], band: usize) -> Vec<u32> {
        let noise = SignalNoise { constant: 1e-8, ..SignalNoise::default() };
        let axes = Axes::new(mosaic.clone(), side, Levels::new(vec![]).unwrap(), noise).unwrap();
        let classifier = Classifier::new(&axes.with_textures(Textures::Oriented));
        let (mut window, mut out, mut all) = (Window::default(), RowClasses::default(), Vec::new());
        let source = Source::normalized(image, size[0], size[1]);
        let tile = [mosaic.rows(), mosaic.cols()];
        for first in (0..size[0]).step_by(band) {
            let rows = band.min(size[0] - first);
            window.read(source, first, rows, classifier.margin(), tile);
            for row in 0..rows {
                classifier.row(&window, row, [first + row, 0], 0..size[1], &mut out);
                all.extend_from_slice(&out.local[..size[1]]);
            }
        }
        all
    }

    /// A grating is classified with its own orientation on any sampling lattice.
    #[test]
    fn gratings_lie_in_their_direction() {
        let size = [64, 80];
        for mosaic in mosaics() {
            for side in [5, 7] {
                for degrees in (0..180).step_by(15) {
                    // From right towards down; halfway between two orientations either is correct.
                    let nearest = (f64::from(degrees) / 45.0).round() as u32 % 4;
                    let (down, right) = f64::from(degrees).to_radians().sin_cos();
                    let at = |i: usize| {
                        let along = (i / size[1]) as f64 * down + (i % size[1]) as f64 * right;
                        (0.5 + 0.3 * (along * std::f64::consts::TAU / 14.0).sin()) as f32
                    };
                    let image: Vec<f32> = (0..size[0] * size[1]).map(at).collect();
                    let found = textures(&mosaic, side, &image, size, 64);
                    let inside = (10..54).flat_map(|r| (10..70).map(move |c| r * 80 + c));
                    let right = inside.clone().filter(|&i| found[i] == 2 + nearest).count();
                    let share = right as f64 / inside.count() as f64;
                    // The gradient is small at the crests of the wave, but its orientation is unchanged.
                    assert!(share > 0.95, "{share} at {degrees}°, {mosaic:?}, patch {side}");
                }
            }
        }
    }

    /// Noise-free flat patches and isotropic patches have no orientation.
    #[test]
    fn flat_and_round_have_none() {
        let size = [40, 48];
        for mosaic in mosaics() {
            let flat = textures(&mosaic, 5, &vec![0.25; 40 * 48], size, 40);
            assert!(flat.iter().all(|&t| t == 0));
            // Two gratings across each other.
            let wave = |x: usize| 0.15 * (x as f32 * std::f32::consts::TAU / 8.0).sin();
            let image: Vec<f32> = (0..40 * 48).map(|i| 0.5 + wave(i / 48) + wave(i % 48)).collect();
            let found = textures(&mosaic, 9, &image, size, 40);
            let plain = found.iter().filter(|&&t| t == 1).count();
            assert!(plain as f64 > 0.9 * found.len() as f64, "{plain} of {}", found.len());
        }
    }

    /// The classes of a row do not depend on where a band begins.
    #[test]
    fn bands_make_no_difference() {
        let size = [45, 37];
        let image: Vec<f32> =
            (0..45 * 37u64).map(|i| (((i * 2_654_435_761) >> 16) & 1023) as f32 / 1023.0).collect();
        for mosaic in mosaics() {
            let whole = textures(&mosaic, 5, &image, size, 45);
            for band in [1, 7, 32] {
                assert_eq!(textures(&mosaic, 5, &image, size, band), whole, "{mosaic:?}");
            }
        }
    }
}
