//! Directions of edges by the structure tensor of a patch.

use super::classify::{vector, vectors_of};
use super::lattice::Shift;
use super::window::{LANES, Window};
use super::MAX_SIDE;

/// Edges count as such when their structure tensor is this coherent: (λ₁ − λ₂) / (λ₁ + λ₂) of its eigenvalues.
const COHERENT: f32 = 0.5;

/// Sums down the columns of the patches of the tensor's entries: down · down, down · right, right · right.
#[derive(Debug, Default)]
pub(super) struct Tensor([Vec<f32>; 3]);

/// How gradients are taken from differences between samples of like channels, along two shifts of the mosaic. At every pixel
/// of a patch both differences are taken around that pixel (to half a pixel), so that they see one place of the scene; they
/// reach beyond the patch by half a shift.
#[derive(Debug, Clone)]
pub(super) struct Orientation {
    half: usize,
    /// The ends of the two differences, relative to the pixel.
    ends: [[Shift; 2]; 2],
    /// From differences along the two shifts to those along rows and columns, per pixel.
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
        // The shifts are the rows of a matrix that takes gradients to differences; this is its inverse.
        Self { half, ends: shifts.map(ends), gradient: [[d / det, -b / det], [-c / det, a / det]] }
    }

    /// How far beyond the centre samples are read, in rows and columns.
    pub(super) fn reach(&self) -> [usize; 2] {
        let far = |axis: usize| self.ends.iter().flatten().map(|end| end[axis].unsigned_abs()).max();
        [0, 1].map(|axis| self.half + far(axis).unwrap_or(0))
    }

    /// Adds 1 to 4 to textures whose structure tensor has a direction. `local` is a multiple of `kinds` where a patch is flat,
    /// one more where it is texture.
    #[inline(always)]
    pub(super) fn row(&self, window: &Window, row: isize, tensor: &mut Tensor, kinds: u32, local: &mut [u32]) {
        self.columns(window, row, tensor);
        let Tensor([dd, dr, rr]) = tensor;
        for (x, local) in local.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let mut sums = [[0.0f32; LANES]; 3];
            for tap in 0..=2 * self.half {
                let at = x * LANES + tap;
                let parts = [vector(dd, at), vector(dr, at), vector(rr, at)];
                for i in 0..LANES {
                    sums[0][i] += parts[0][i];
                    sums[1][i] += parts[1][i];
                    sums[2][i] += parts[2][i];
                }
            }
            for i in 0..LANES {
                let [dd, dr, rr] = [sums[0][i], sums[1][i], sums[2][i]];
                let (difference, twice, all) = (rr - dd, 2.0 * dr, COHERENT * (dd + rr));
                // Both sides of λ₁ − λ₂ > COHERENT (λ₁ + λ₂) squared. Without any gradient there is no direction.
                let edge = difference * difference + twice * twice > all * all;
                let textured = local[i] % kinds != 0;
                // The gradient's direction is half the angle of (difference, twice).
                local[i] += if edge & textured { 1 + direction(difference, twice) } else { 0 };
            }
        }
    }

    #[inline(always)]
    fn columns(&self, window: &Window, row: isize, tensor: &mut Tensor) {
        let half = self.half as isize;
        let mut lines = [[&[] as &[f32]; 4]; MAX_SIDE];
        let lines = &mut lines[..2 * self.half + 1];
        let [[p0, p1], [q0, q1]] = self.ends;
        for (entry, r) in lines.iter_mut().zip(row - half..) {
            *entry = [p0, p1, q0, q1].map(|end| window.line(r + end[0]));
        }
        // The window's margin is as wide as the reach, so that none is negative.
        let first = window.margin[1] as isize - half;
        let from = [p0, p1, q0, q1].map(|end| (first + end[1]).max(0) as usize);
        let [[g00, g01], [g10, g11]] = self.gradient;
        let len = window.cols.next_multiple_of(LANES) + 2 * self.half;
        let Tensor([dd, dr, rr]) = tensor;
        let sums = vectors_of(dd, len).zip(vectors_of(dr, len)).zip(vectors_of(rr, len));
        for (((at, dd), (_, dr)), (_, rr)) in sums {
            let mut totals = [[0.0f32; LANES]; 3];
            for line in lines.iter() {
                let p = [vector(line[0], from[0] + at), vector(line[1], from[1] + at)];
                let q = [vector(line[2], from[2] + at), vector(line[3], from[3] + at)];
                for i in 0..LANES {
                    let (along_p, along_q) = (p[1][i] - p[0][i], q[1][i] - q[0][i]);
                    let down = g00 * along_p + g01 * along_q;
                    let right = g10 * along_p + g11 * along_q;
                    totals[0][i] += down * down;
                    totals[1][i] += down * right;
                    totals[2][i] += right * right;
                }
            }
            [*dd, *dr, *rr] = totals;
        }
    }
}

/// Which of the four directions 0°, 45°, 90°, 135° (from right towards down) is nearest to half the angle of (`cos`, `sin`).
#[inline(always)]
fn direction(cos: f32, sin: f32) -> u32 {
    // Doubled, the directions lie at 0°, 90°, 180° and 270°.
    let along = if cos >= 0.0 { 0 } else { 2 };
    let slanted = if sin > 0.0 { 1 } else { 3 };
    if cos.abs() >= sin.abs() { along } else { slanted }
}
