//! The mean colour difference that normal errors cause about a colour.

use crate::color::cie1976::lab_from_xyz;
use crate::color::difference::delta_e_2000;

/// Row and column of the entries of a packed symmetric matrix.
pub(super) const PACKED: [(usize, usize); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];

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

/// A colour about which errors are distributed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ColorError {
    xyz: [f64; 3],
    lab: [f64; 3],
    white: [f64; 3],
}

impl ColorError {
    /// About X, Y, Z relative to display white; `white` is that of the illuminant with Y = 1.
    pub(super) fn new(xyz: [f64; 3], white: [f64; 3]) -> Self {
        Self { xyz, lab: lab_from_xyz(xyz, white), white }
    }

    /// CIEDE2000 of a colour, limited to X, Y, Z of at least 0.
    fn difference(&self, xyz: [f64; 3]) -> f64 {
        delta_e_2000(self.lab, lab_from_xyz(xyz.map(|v| v.max(0.0)), self.white))
    }

    /// The mean CIEDE2000 for normal errors of a packed covariance, by a quadrature of 24 nodes.
    pub(super) fn mean(&self, error: &[f64; 6]) -> f64 {
        let Some(root) = Root::of(error) else { return 0.0 };
        nodes().map(|(z, weight)| weight * self.difference(root.apply(self.xyz, z))).sum()
    }

    /// The derivative of [`ColorError::mean`] with respect to the covariance, as a symmetric matrix Φ: the change is Σ Φᵢⱼ dEᵢⱼ over all nine
    /// entries.
    pub(super) fn derivative(&self, error: &[f64; 6]) -> [[f64; 3]; 3] {
        let Some(root) = Root::of(error) else { return [[0.0; 3]; 3] };
        let mut by_root = [[0.0; 3]; 3];
        for (z, weight) in nodes() {
            let at = root.apply(self.xyz, z);
            for (i, row) in by_root.iter_mut().enumerate() {
                let step = STEP * self.white[i];
                let moved = |by: f64| {
                    let mut at = at;
                    at[i] += by;
                    self.difference(at)
                };
                let slope = (moved(step) - moved(-step)) / (2.0 * step);
                row.iter_mut().zip(z).take(i + 1).for_each(|(sum, z)| *sum += weight * slope * z);
            }
        }
        root.by_matrix(&by_root)
    }
}

/// Nodes and weights of the mean over a normal vector in three dimensions.
fn nodes() -> impl Iterator<Item = ([f64; 3], f64)> {
    let shells = RADII.into_iter().zip([FIRST_SHARE, 1.0 - FIRST_SHARE]);
    shells.flat_map(|(radius, share)| {
        (0..12).map(move |corner| {
            let sign = |bit: usize| if corner >> bit & 1 == 0 { radius } else { -radius };
            let mut z = [0.0; 3];
            z[corner / 4] = sign(0) * SHORT;
            z[(corner / 4 + 1) % 3] = sign(1) * LONG;
            (z, share / 12.0)
        })
    })
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

    fn apply(&self, center: [f64; 3], z: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| center[i] + (0..=i).map(|j| self.factor[i][j] * z[j]).sum::<f64>())
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

    /// The mean over 40 000 drawn errors.
    fn sampled(color: &ColorError, error: &[f64; 6]) -> f64 {
        let root = Root::of(error).unwrap();
        let mut random = Stream::new(3, 4, 5);
        let mut pair = || {
            let mut word = || (random.uniform() * 4_294_967_295.0) as u32;
            let (a, b) = normal_pair(word(), word());
            [f64::from(a), f64::from(b)]
        };
        let count = 40_000;
        let draw = |_| {
            let ([x, y], [z, _]) = (pair(), pair());
            color.difference(root.apply(color.xyz, [x, y, z]))
        };
        (0..count).map(draw).sum::<f64>() / f64::from(count)
    }

    /// The quadrature is within 5 % of the sampled mean for errors of 0.3 to 20 ΔE. The drawn means have a standard error of 0.4 %.
    #[test]
    fn errors_have_the_mean_difference_that_was_sampled() {
        for xyz in [[0.2, 0.2, 0.2], [0.3, 0.2, 0.05], [0.02, 0.02, 0.04]] {
            for relative in [0.01f64, 0.1, 0.4] {
                let color = ColorError::new(xyz, WHITE);
                let error = ERROR.map(|e| e * (0.5 * relative * xyz[1]).powi(2));
                let (sampled, mean) = (sampled(&color, &error), color.mean(&error));
                assert!((mean / sampled - 1.0).abs() < 0.05, "{xyz:?}, {relative}: {mean} and {sampled}");
            }
        }
    }

    #[test]
    fn nodes_have_the_moments_of_a_normal_vector() {
        let mean = |f: &dyn Fn([f64; 3]) -> f64| nodes().map(|(z, w)| w * f(z)).sum::<f64>();
        let length = |z: [f64; 3]| z.iter().map(|v| v * v).sum::<f64>().sqrt();
        assert!((mean(&|_| 1.0) - 1.0).abs() < 1e-14);
        assert!((mean(&length) - 2.0 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-12);
        for i in 0..3 {
            assert!(mean(&|z| z[i]).abs() < 1e-14 && mean(&|z| z[i] * z[(i + 1) % 3]).abs() < 1e-14);
            assert!((mean(&|z| z[i] * z[i]) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_derivative_is_that_of_finite_differences() {
        for scale in [1e-5, 1e-3] {
            let color = ColorError::new([0.3, 0.2, 0.15], WHITE);
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
