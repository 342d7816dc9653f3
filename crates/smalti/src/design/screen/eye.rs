//! The error that the eye sees: S-CIELAB in closed form.
//!
//! S-CIELAB blurs pictures with the opponent filters of the eye before it compares them. Two parts of an error pass these filters
//! differently.
//!
//! - The *error of the signal* is what the best estimate leaves without noise. It is that of a surface or an edge, which is as large as
//!   the filters or larger, and passes as it is. (Aliasing passes in part only, so that this is an upper bound.)
//! - *Noise* is independent in every sample. A sample enters the estimates of all pixels around it, and the filters average over these.
//!   With the weights w of the estimates, the opponent filters k and the variance σ² of a sample, the variance that is left is
//!   Σ σ² (Σ k w)², summed over samples. Averaged over the positions of the filters on the tile, only the overlap of two displaced filters
//!   counts, Σ k(x) k(x + δ).

use super::lanes::{LANES, Lanes, ZERO, plus, plus_scaled};
use super::layout::Layout;
use crate::camera::{CameraError, ScoreSettings};
use crate::color::DeltaE;
use crate::color::matrix::Matrix3;
use crate::color::scielab::Scielab;
use crate::design::error::DesignError;
use crate::metrics::MetricError;

/// A number of X, Y, Z or of the opponent colours, in each lane.
type Triple = [Lanes; 3];

/// The opponent filters of the eye at the viewing distance of [`ScoreSettings`].
#[derive(Debug, Clone)]
pub(super) struct Eye {
    side: usize,
    /// Overlaps of displaced filters, by rows and columns of the displacement.
    overlaps: Vec<[f64; 6]>,
    opponent_from_xyz: Matrix3,
    xyz_from_opponent: Matrix3,
}

/// The noise of one group of classes under one condition.
pub(super) struct SampleNoise {
    /// Weights of the estimates of the opponent colours, by position and pixel.
    pub(super) weights: Vec<Triple>,
    /// Variances of the samples, by position and pixel.
    pub(super) variances: Vec<Lanes>,
}

impl SampleNoise {
    pub(super) fn new(layout: &Layout) -> Self {
        let count = layout.positions() * layout.taps();
        Self { weights: vec![[ZERO; 3]; count], variances: vec![ZERO; count] }
    }
}

impl Eye {
    /// The filters for patches of `side` × `side` pixels under a light of which X, Y, Z are `white`.
    pub(super) fn new(side: usize, white: [f64; 3]) -> Result<Self, DesignError> {
        let scielab = Scielab::new(ScoreSettings::default().samples_per_degree, DeltaE::Ciede2000);
        let failed = |e| CameraError::from(MetricError::from(e));
        let overlaps = scielab.overlaps(side - 1).map_err(failed)?;
        let [opponent_from_xyz, xyz_from_opponent] = scielab.opponent_matrices(white).map_err(failed)?;
        Ok(Self { side, overlaps, opponent_from_xyz, xyz_from_opponent })
    }

    /// Weights of the opponent colours from those of X, Y, Z.
    #[inline(always)]
    pub(super) fn opponent(&self, xyz: &Triple) -> Triple {
        map(&self.opponent_from_xyz, xyz)
    }

    /// Covariance of the noise of X, Y, Z behind the filters, mean over the positions: packed.
    #[inline(always)]
    pub(super) fn noise(&self, layout: &Layout, noise: &SampleNoise) -> [Lanes; 6] {
        let taps = layout.taps();
        let mut sums = [ZERO; 6];
        for position in 0..layout.positions() {
            for tap in 0..taps {
                let at = position * taps + tap;
                let own = scaled(&noise.weights[at], noise.variances[at]);
                for other in 0..taps {
                    let (overlap, place) = self.pair(layout, position, tap, other);
                    let seen = &noise.weights[place];
                    for ((sum, factor), (c, d)) in
                        sums.iter_mut().zip(overlap).zip(super::color_error::PACKED)
                    {
                        let product = plus(ZERO, own[c], seen[d]);
                        *sum = plus_scaled(*sum, *factor, product);
                    }
                }
            }
        }
        let share = 1.0 / layout.positions() as f64;
        congruence(&self.xyz_from_opponent, &unpacked(&sums, share))
    }

    /// Adds to `by_weights` and `by_variances` the derivatives of Σ `phi`ᵢⱼ Nᵢⱼ over all nine entries of the covariance N of [`Eye::noise`].
    #[inline(always)]
    pub(super) fn derivative(
        &self,
        layout: &Layout,
        noise: &SampleNoise,
        phi: &[Triple; 3],
        by_weights: &mut [Triple],
        by_variances: &mut [Lanes],
    ) {
        let taps = layout.taps();
        let share = 1.0 / layout.positions() as f64;
        // Φ with respect to the opponent colours; an entry off the diagonal stands for two.
        let transposed: Matrix3 =
            std::array::from_fn(|i| std::array::from_fn(|j| self.xyz_from_opponent[j][i]));
        let packed = congruence(&transposed, phi);
        let mut psi = [ZERO; 6];
        for ((psi, value), (c, d)) in psi.iter_mut().zip(packed).zip(super::color_error::PACKED) {
            *psi = plus_scaled(ZERO, if c == d { share } else { 2.0 * share }, value);
        }
        for position in 0..layout.positions() {
            for tap in 0..taps {
                let at = position * taps + tap;
                let (own, variance) = (noise.weights[at], noise.variances[at]);
                let (mut by_own, mut by_variance) = ([ZERO; 3], ZERO);
                for other in 0..taps {
                    let (overlap, place) = self.pair(layout, position, tap, other);
                    let seen = noise.weights[place];
                    for (entry, (c, d)) in super::color_error::PACKED.into_iter().enumerate() {
                        let slope = plus_scaled(ZERO, overlap[entry], psi[entry]);
                        by_own[c] = plus(by_own[c], slope, seen[d]);
                        by_variance = plus(by_variance, slope, plus(ZERO, own[c], seen[d]));
                        let of_seen = plus(ZERO, slope, variance);
                        by_weights[place][d] = plus(by_weights[place][d], of_seen, own[c]);
                    }
                }
                for (sum, own) in by_weights[at].iter_mut().zip(by_own) {
                    *sum = plus(*sum, own, variance);
                }
                for lane in 0..LANES {
                    by_variances[at][lane] += by_variance[lane];
                }
            }
        }
        // From the weights of the opponent colours to those of X, Y, Z.
        let transposed: Matrix3 =
            std::array::from_fn(|i| std::array::from_fn(|j| self.opponent_from_xyz[j][i]));
        by_weights.iter_mut().for_each(|w| *w = map(&transposed, w));
    }

    /// The overlap of the filters of two pixels that see one sample, as pixel `tap` of the patch at `position` and as pixel `other` of its own
    /// patch; and the place of the latter.
    #[inline(always)]
    fn pair(&self, layout: &Layout, position: usize, tap: usize, other: usize) -> (&[f64; 6], usize) {
        let side = self.side;
        let (rows, cols) = ((tap / side, other / side), (tap % side, other % side));
        let overlap = &self.overlaps[rows.0.abs_diff(rows.1) * side + cols.0.abs_diff(cols.1)];
        // The pixel lies as much further as the sample lies nearer.
        let down = rows.0 + side - 1 - rows.1;
        let right = cols.0 + side - 1 - cols.1;
        (overlap, layout.displaced(position, down, right) * layout.taps() + other)
    }
}

/// A matrix times a vector.
#[inline(always)]
fn map(m: &Matrix3, v: &Triple) -> Triple {
    let mut out = [ZERO; 3];
    for (out, row) in out.iter_mut().zip(m) {
        for (factor, v) in row.iter().zip(v) {
            *out = plus_scaled(*out, *factor, *v);
        }
    }
    out
}

#[inline(always)]
fn scaled(v: &Triple, by: Lanes) -> Triple {
    [plus(ZERO, v[0], by), plus(ZERO, v[1], by), plus(ZERO, v[2], by)]
}

/// A symmetric matrix from its packed entries times a factor.
#[inline(always)]
fn unpacked(packed: &[Lanes; 6], factor: f64) -> [Triple; 3] {
    let mut out = [[ZERO; 3]; 3];
    for ((c, d), value) in super::color_error::PACKED.into_iter().zip(packed) {
        out[c][d] = plus_scaled(ZERO, factor, *value);
        out[d][c] = out[c][d];
    }
    out
}

/// M A Mᵀ of a symmetric matrix A, packed.
#[inline(always)]
fn congruence(m: &Matrix3, a: &[Triple; 3]) -> [Lanes; 6] {
    let mut out = [ZERO; 6];
    for (out, (c, d)) in out.iter_mut().zip(super::color_error::PACKED) {
        for i in 0..3 {
            for j in 0..3 {
                *out = plus_scaled(*out, m[c][i] * m[d][j], a[i][j]);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{ColorSpace, Image};
    use crate::numeric::Planes;
    use crate::numeric::philox::Stream;
    use crate::sensor::Mosaic;

    const SIDE: usize = 3;
    const SIZE: usize = 96;
    /// A warm lamp.
    const WHITE: [f64; 3] = [1.0985, 1.0, 0.35585];

    fn random_noise(layout: &Layout, mosaic: &Mosaic) -> (SampleNoise, Vec<[f64; 3]>, Vec<f64>) {
        let mut stream = Stream::new(5, 6, 7);
        let mut noise = SampleNoise::new(layout);
        let eye = Eye::new(SIDE, WHITE).unwrap();
        let of_filter: Vec<f64> = (0..mosaic.channels()).map(|_| stream.uniform() + 0.2).collect();
        let xyz: Vec<[f64; 3]> =
            (0..noise.weights.len()).map(|_| [(); 3].map(|()| stream.uniform() - 0.3)).collect();
        for (at, xyz) in xyz.iter().enumerate() {
            let filter = layout.at(at / layout.taps())[at % layout.taps()];
            noise.weights[at] = eye.opponent(&xyz.map(|v| [v; LANES]));
            noise.variances[at] = [of_filter[usize::from(filter)]; LANES];
        }
        (noise, xyz, of_filter)
    }

    /// The covariance is that of pictures of single samples that S-CIELAB itself has blurred.
    #[test]
    fn noise_is_that_of_pictures_behind_the_filters_of_scielab() {
        let mosaic = Mosaic::new(2, 3, vec![0, 1, 2, 3, 1, 0]).unwrap();
        let layout = Layout::new(SIDE, 0, &mosaic);
        let (noise, xyz, of_filter) = random_noise(&layout, &mosaic);
        let found = Eye::new(SIDE, WHITE).unwrap().noise(&layout, &noise);
        let scielab = Scielab::new(ScoreSettings::default().samples_per_degree, DeltaE::Ciede2000);
        let mut expected = [0.0; 6];
        for cell in 0..6 {
            // A sample of this place in the tile, in the middle of a picture, and the pixels that it enters.
            let (row, col) = (SIZE / 2 + cell / 3, SIZE / 2 + cell % 3);
            let mut planes = Planes::zeros(SIZE, SIZE, 3);
            for tap in 0..SIDE * SIDE {
                let (r, c) = (row + 1 - tap / SIDE, col + 1 - tap % SIDE);
                let position = r % 2 * 3 + c % 3;
                for i in 0..3 {
                    planes.plane_mut(i).unwrap()[r * SIZE + c] = xyz[position * SIDE * SIDE + tap][i] as f32;
                }
            }
            let seen = scielab.filtered(&Image::new(ColorSpace::Xyz, planes).unwrap(), WHITE).unwrap();
            let variance = of_filter[mosaic.channel_at(row, col)];
            for (sum, (c, d)) in expected.iter_mut().zip(super::super::color_error::PACKED) {
                let products = seen[c].iter().zip(&seen[d]).map(|(a, b)| f64::from(*a) * f64::from(*b));
                *sum += variance * products.sum::<f64>() / 6.0;
            }
        }
        for (found, expected) in found.iter().zip(expected) {
            assert!((found[0] - expected).abs() < 1e-5 * expected.abs() + 1e-8, "{} {expected}", found[0]);
        }
    }

    #[test]
    fn the_derivative_is_that_of_finite_differences() {
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 2, 1]).unwrap();
        let layout = Layout::new(SIDE, 0, &mosaic);
        let (noise, xyz, _) = random_noise(&layout, &mosaic);
        let eye = Eye::new(SIDE, WHITE).unwrap();
        let phi = [[1.0, 0.3, -0.2], [0.3, 2.0, 0.5], [-0.2, 0.5, 0.7]];
        let value = |noise: &SampleNoise| {
            let n = unpacked(&eye.noise(&layout, noise), 1.0);
            (0..9).map(|at| phi[at / 3][at % 3] * n[at / 3][at % 3][0]).sum::<f64>()
        };
        let count = layout.positions() * layout.taps();
        let (mut by_weights, mut by_variances) = (vec![[ZERO; 3]; count], vec![ZERO; count]);
        let lanes = phi.map(|row| row.map(|v| [v; LANES]));
        eye.derivative(&layout, &noise, &lanes, &mut by_weights, &mut by_variances);
        for (at, c) in [(0, 0), (7, 1), (13, 2), (30, 0), (35, 1)] {
            let moved = |by: f64| {
                let mut changed =
                    SampleNoise { weights: noise.weights.clone(), variances: noise.variances.clone() };
                let mut w = xyz[at];
                w[c] += by;
                changed.weights[at] = eye.opponent(&w.map(|v| [v; LANES]));
                value(&changed)
            };
            let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            assert!((slope / by_weights[at][c][0] - 1.0).abs() < 1e-7, "{slope} {}", by_weights[at][c][0]);
            let moved = |by: f64| {
                let mut changed =
                    SampleNoise { weights: noise.weights.clone(), variances: noise.variances.clone() };
                changed.variances[at] = noise.variances[at].map(|v| v + by);
                value(&changed)
            };
            let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            assert!((slope / by_variances[at][0] - 1.0).abs() < 1e-7, "{slope} {}", by_variances[at][0]);
        }
    }
}
