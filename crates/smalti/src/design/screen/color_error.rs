//! The mean colour difference that normal errors cause about the colours of a class.

use crate::color::cie1976::lab_from_xyz;
use crate::color::difference::delta_e_2000;
use crate::numeric::simd::{Kernel, dispatch};

/// Row and column of the entries of a packed symmetric matrix.
pub(super) const PACKED: [(usize, usize); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];

/// Number of nodes of the mean over a normal vector in three dimensions.
const NODES: usize = 24;
/// Distances from the centre of the nodes, and the share of the first ones. They have the mean, the mean square and the mean cube of the
/// length of a normal vector in three dimensions, 2√(2/π), 3 and 8√(2/π), so that linear and quadratic functions of the length are exact.
const RADII: [f64; 2] = [1.066_298_511_131_054_1, 2.452_324_521_579_843];
const FIRST_SHARE: f64 = 0.617_993_741_471_535_2;
/// Corners of an icosahedron, a spherical design of degree 5: (0, ±1, ±φ) and its rotations, on the unit sphere.
const SHORT: f64 = 0.525_731_112_119_133_6;
const LONG: f64 = 0.850_650_808_352_039_9;
/// Step of the derivatives with respect to X, Y, Z, relative to white.
const STEP: f64 = 1e-6;
/// Smallest variance beside the largest one: covariances of errors may be singular.
const RIDGE: f64 = 1e-10;
/// Colours of a smaller share of the patches of a class are left out, because each costs as much time as a frequent one.
const LEAST_SHARE: f64 = 0.01;

/// A number of each node.
type Nodes = [f64; NODES];

/// The colours of a class, about which errors are distributed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ColorError {
    colors: Vec<Center>,
    white: [f64; 3],
}

/// A colour and its share of the class.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Center {
    xyz: [f64; 3],
    lab: [f64; 3],
    share: f64,
}

impl ColorError {
    /// About X, Y, Z relative to display white, each with its share; `white` is that of the illuminant with Y = 1.
    pub(super) fn new(colors: &[([f64; 3], f64)], white: [f64; 3]) -> Self {
        let frequent = colors.iter().filter(|(_, share)| *share >= LEAST_SHARE);
        let total: f64 = frequent.clone().map(|(_, share)| share).sum();
        let center = |(xyz, share): &([f64; 3], f64)| Center {
            xyz: *xyz,
            lab: lab_from_xyz(*xyz, white),
            share: share / total,
        };
        Self { colors: frequent.map(center).collect(), white }
    }

    /// The mean CIEDE2000 for normal errors of a packed covariance, over the colours and by a quadrature of 24 nodes.
    pub(super) fn mean(&self, error: &[f64; 6]) -> f64 {
        let Some(root) = Root::of(error) else { return 0.0 };
        let nodes = Normal::new();
        let differences = dispatch(Differences { of: self, offsets: &root.offsets(&nodes) });
        differences.iter().zip(&nodes.weights).map(|(d, w)| d * w).sum()
    }

    /// The derivative of [`ColorError::mean`] with respect to the covariance, as a symmetric matrix Φ: the change is Σ Φᵢⱼ dEᵢⱼ over all nine
    /// entries.
    pub(super) fn derivative(&self, error: &[f64; 6]) -> [[f64; 3]; 3] {
        let Some(root) = Root::of(error) else { return [[0.0; 3]; 3] };
        let nodes = Normal::new();
        let offsets = root.offsets(&nodes);
        let mut by_root = [[0.0; 3]; 3];
        for (i, row) in by_root.iter_mut().enumerate() {
            let step = STEP * self.white[i];
            let moved = |by: f64| {
                let mut offsets = offsets;
                offsets[i].iter_mut().for_each(|v| *v += by);
                dispatch(Differences { of: self, offsets: &offsets })
            };
            let (above, below) = (moved(step), moved(-step));
            for (at, weight) in nodes.weights.iter().enumerate() {
                let slope = weight * (above[at] - below[at]) / (2.0 * step);
                row.iter_mut().zip(&nodes.z).take(i + 1).for_each(|(sum, z)| *sum += slope * z[at]);
            }
        }
        root.by_matrix(&by_root)
    }
}

/// The mean difference over the colours at each node, whose offsets from a colour are X, Y, Z.
///
/// Pictures are scored as here ([`score_picture`](crate::camera::score_picture)): Y is limited at white and the chromaticity kept,
/// and negative values stay.
struct Differences<'a> {
    of: &'a ColorError,
    offsets: &'a [Nodes; 3],
}

impl Kernel for Differences<'_> {
    type Output = Nodes;

    #[inline(always)]
    fn run(self) -> Nodes {
        let (white, [x, y, z]) = (self.of.white, self.offsets);
        let mut out = [0.0; NODES];
        for center in &self.of.colors {
            for i in 0..NODES {
                let at = [center.xyz[0] + x[i], center.xyz[1] + y[i], center.xyz[2] + z[i]];
                let limit = if at[1] > 1.0 { 1.0 / at[1] } else { 1.0 };
                let lab = lab_from_xyz([at[0] * limit, at[1] * limit, at[2] * limit], white);
                out[i] += center.share * delta_e_2000(center.lab, lab);
            }
        }
        out
    }
}

/// Nodes and weights of the mean over a normal vector in three dimensions.
struct Normal {
    z: [Nodes; 3],
    weights: Nodes,
}

impl Normal {
    fn new() -> Self {
        let (mut z, mut weights) = ([[0.0; NODES]; 3], [0.0; NODES]);
        for node in 0..NODES {
            let (shell, corner) = (node / 12, node % 12);
            let sign = |bit: usize| if corner >> bit & 1 == 0 { RADII[shell] } else { -RADII[shell] };
            z[corner / 4][node] = sign(0) * SHORT;
            z[(corner / 4 + 1) % 3][node] = sign(1) * LONG;
            weights[node] = [FIRST_SHARE, 1.0 - FIRST_SHARE][shell] / 12.0;
        }
        Self { z, weights }
    }
}

/// The Cholesky factor of a covariance.
struct Root {
    factor: [[f64; 3]; 3],
}

impl Root {
    /// `None` for a covariance of zero.
    fn of(error: &[f64; 6]) -> Option<Self> {
        let [a, b, c, d, e, f] = *error;
        let ridge = RIDGE * a.max(c).max(f);
        if ridge.is_nan() || ridge <= 0.0 {
            return None;
        }
        let above = |pivot: f64| pivot.max(0.0) + ridge;
        let l00 = above(a).sqrt();
        let (l10, l20) = (b / l00, d / l00);
        let l11 = above(c - l10 * l10).sqrt();
        let l21 = (e - l20 * l10) / l11;
        let l22 = above(f - l20 * l20 - l21 * l21).sqrt();
        Some(Self { factor: [[l00, 0.0, 0.0], [l10, l11, 0.0], [l20, l21, l22]] })
    }

    /// The factor times each node.
    fn offsets(&self, nodes: &Normal) -> [Nodes; 3] {
        let of = |i: usize, at: usize| (0..=i).map(|j| self.factor[i][j] * nodes.z[j][at]).sum::<f64>();
        std::array::from_fn(|i| std::array::from_fn(|at| of(i, at)))
    }

    /// The derivative with respect to the matrix from that with respect to its factor ([murray2016], section 3.1).
    ///
    /// [murray2016]: https://arxiv.org/abs/1602.07527
    fn by_matrix(&self, by_factor: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let l = &self.factor;
        // The lower triangle of Lᵀ times the derivative, with half its diagonal.
        let mut p = [[0.0; 3]; 3];
        for (i, row) in p.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate().take(i + 1) {
                let sum: f64 = (i..3).map(|k| l[k][i] * by_factor[k][j]).sum();
                *value = if i == j { 0.5 * sum } else { sum };
            }
        }
        // L⁻ᵀ P L⁻¹, by the inverse of the factor.
        let mut inverse = [[0.0; 3]; 3];
        for j in 0..3 {
            inverse[j][j] = 1.0 / l[j][j];
            for i in j + 1..3 {
                let sum: f64 = (j..i).map(|k| l[i][k] * inverse[k][j]).sum();
                inverse[i][j] = -sum / l[i][i];
            }
        }
        let at = |i: usize, j: usize| -> f64 {
            (0..3).map(|k| (0..3).map(|m| inverse[k][i] * p[k][m] * inverse[m][j]).sum::<f64>()).sum()
        };
        std::array::from_fn(|i| std::array::from_fn(|j| f64::midpoint(at(i, j), at(j, i))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::normal::normal_pair;
    use crate::numeric::philox::Stream;

    const WHITE: [f64; 3] = [0.9504, 1.0, 1.0888];
    const ERROR: [f64; 6] = [2.0, 1.2, 1.5, 0.3, -0.2, 3.0];

    fn one(xyz: [f64; 3]) -> ColorError {
        ColorError::new(&[(xyz, 1.0)], WHITE)
    }

    /// The mean over 40 000 drawn errors about one colour, without a limit at white.
    fn sampled(color: &ColorError, error: &[f64; 6]) -> f64 {
        let root = Root::of(error).unwrap();
        let center = color.colors[0];
        let mut random = Stream::new(3, 4, 5);
        let mut pair = || {
            let mut word = || (random.uniform() * 4_294_967_295.0) as u32;
            let (a, b) = normal_pair(word(), word());
            [f64::from(a), f64::from(b)]
        };
        let count = 40_000;
        let draw = |_| {
            let ([x, y], [z, _]) = (pair(), pair());
            let z = [x, y, z];
            let at = |i: usize| center.xyz[i] + (0..=i).map(|j| root.factor[i][j] * z[j]).sum::<f64>();
            delta_e_2000(center.lab, lab_from_xyz([at(0), at(1), at(2)], WHITE))
        };
        (0..count).map(draw).sum::<f64>() / f64::from(count)
    }

    /// The quadrature is within 5 % of the sampled mean for errors of 0.3 to 20 ΔE. The drawn means have a standard error of 0.4 %.
    #[test]
    fn errors_have_the_mean_difference_that_was_sampled() {
        for xyz in [[0.2, 0.2, 0.2], [0.3, 0.2, 0.05], [0.02, 0.02, 0.04]] {
            for relative in [0.01f64, 0.1, 0.4] {
                let color = one(xyz);
                let error = ERROR.map(|e| e * (0.5 * relative * xyz[1]).powi(2));
                let (sampled, mean) = (sampled(&color, &error), color.mean(&error));
                assert!((mean / sampled - 1.0).abs() < 0.05, "{xyz:?}, {relative}: {mean} and {sampled}");
            }
        }
    }

    #[test]
    fn nodes_have_the_moments_of_a_normal_vector() {
        let nodes = Normal::new();
        let mean = |f: &dyn Fn([f64; 3]) -> f64| -> f64 {
            let value = |at: usize| nodes.weights[at] * f([0, 1, 2].map(|i| nodes.z[i][at]));
            (0..NODES).map(value).sum()
        };
        let length = |z: [f64; 3]| z.iter().map(|v| v * v).sum::<f64>().sqrt();
        assert!((mean(&|_| 1.0) - 1.0).abs() < 1e-14);
        assert!((mean(&length) - 2.0 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-12);
        for i in 0..3 {
            assert!(mean(&|z| z[i]).abs() < 1e-14 && mean(&|z| z[i] * z[(i + 1) % 3]).abs() < 1e-14);
            assert!((mean(&|z| z[i] * z[i]) - 1.0).abs() < 1e-12);
        }
    }

    /// The mean over several colours is the mean of their means; rare colours do not count.
    #[test]
    fn frequent_colours_count_by_their_shares() {
        let (a, b, rare) = ([0.3, 0.2, 0.05], [0.05, 0.08, 0.02], [0.01, 0.9, 0.01]);
        let error = ERROR.map(|e| e * 1e-3);
        let both = ColorError::new(&[(a, 0.745), (b, 0.248), (rare, 0.007)], WHITE);
        let expected = (0.745 * one(a).mean(&error) + 0.248 * one(b).mean(&error)) / 0.993;
        assert!((both.mean(&error) - expected).abs() < 1e-12);
    }

    /// Display white plus errors: what is brighter than white is shown as white.
    #[test]
    fn errors_above_white_are_limited_as_in_scores() {
        let white = one(WHITE);
        let along = [WHITE[0] * WHITE[0], WHITE[0], 1.0, WHITE[0] * WHITE[2], WHITE[2], WHITE[2] * WHITE[2]];
        let grey = one(WHITE.map(|w| 0.5 * w));
        let error = along.map(|e| e * 1e-4);
        // Of errors of brightness alone, half lie above white and cause no difference.
        assert!(white.mean(&error) < 0.6 * grey.mean(&error) && white.mean(&error) > 0.0);
    }

    #[test]
    fn the_derivative_is_that_of_finite_differences() {
        for scale in [1e-5, 1e-3] {
            let color = ColorError::new(&[([0.3, 0.2, 0.15], 0.7), ([0.05, 0.08, 0.02], 0.3)], WHITE);
            let error = ERROR.map(|e| e * scale);
            let derivative = color.derivative(&error);
            for (at, (i, j)) in PACKED.into_iter().enumerate() {
                let change = |by: f64| {
                    let mut e = error;
                    e[at] += by;
                    color.mean(&e)
                };
                let step = 1e-4 * scale;
                let found = (change(step) - change(-step)) / (2.0 * step);
                let expected = if i == j { derivative[i][i] } else { derivative[i][j] + derivative[j][i] };
                assert!((found / expected - 1.0).abs() < 1e-5, "{i} {j}: {found} {expected}");
            }
        }
    }
}
