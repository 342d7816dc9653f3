//! The smooth correction that gives a pixel its colour.

use crate::color::sigmoid::Fit;
use crate::numeric::elementary::inverse_sqrt_f32;
use crate::numeric::simd::{Kernel, dispatch};

/// Pixels that are computed together.
pub(super) const LANES: usize = 16;
/// Values of each of the pixels.
pub(super) type Lanes = [f32; LANES];

/// Steps of Newton's method. Two suffice for most pixels.
const STEPS: usize = 3;
/// Where a correction starts to be limited: one of this size turns grey into a saturated colour.
const LONGEST: f32 = 3.0;

/// One wavelength, in single precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wavelength {
    /// Normalised: −1 at 400 nm, 1 at 700 nm.
    pub(super) position: f32,
    /// Weights in X, Y and Z under D65, relative to white.
    pub(super) weights: [f32; 3],
}

impl Wavelength {
    /// The wavelengths of a fit whose grid has so many.
    pub(super) fn all(fit: &Fit, count: usize) -> Vec<Self> {
        let lanes = fit.blocks.iter().flat_map(|b| {
            (0..b.position.len()).map(|l| Self {
                position: b.position[l] as f32,
                weights: [0, 1, 2].map(|c| b.weights[c][l] as f32),
            })
        });
        lanes.take(count).collect()
    }
}

/// Newton's method for the coefficients a, b, c with which σ(β + a p² + b p + c) has the XYZ of a target. `base` holds
/// the reflectances σ(β) on entry and the corrected ones afterwards; the coefficients and the largest relative error of
/// a component are returned.
pub(super) struct Closure<'a> {
    pub(super) wavelengths: &'a [Wavelength],
    pub(super) base: &'a mut [Lanes],
    pub(super) target: [Lanes; 3],
}

/// Bounds of base reflectances, beyond which their β would be lost in single precision.
pub(super) const DARKEST: f32 = 2e-5;
pub(super) const LIGHTEST: f32 = 0.999;

impl Kernel for Closure<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn run(self) -> Lanes {
        for lanes in self.base.iter_mut() {
            for r in lanes.iter_mut() {
                let v = r.clamp(DARKEST, LIGHTEST);
                *r = (v - 0.5) * inverse_sqrt_f32(v * (1.0 - v));
            }
        }
        let mut coefficients = [[0.0f32; LANES]; 3];
        for _ in 0..STEPS {
            let mut sums = [[0.0f32; LANES]; 3];
            let mut slopes = [[[0.0f32; LANES]; 3]; 3];
            for (w, base) in self.wavelengths.iter().zip(self.base.iter()) {
                let p = w.position;
                for l in 0..LANES {
                    let x = base[l] + (coefficients[0][l] * p + coefficients[1][l]) * p + coefficients[2][l];
                    let root = inverse_sqrt_f32(1.0 + x * x);
                    let (s, ds) = (0.5 + 0.5 * x * root, 0.5 * root * root * root);
                    for c in 0..3 {
                        sums[c][l] += w.weights[c] * s;
                        let k = w.weights[c] * ds;
                        slopes[c][0][l] += k * p * p;
                        slopes[c][1][l] += k * p;
                        slopes[c][2][l] += k;
                    }
                }
            }
            for l in 0..LANES {
                let m = [0, 1, 2].map(|c| [0, 1, 2].map(|i| slopes[c][i][l]));
                let r = [0, 1, 2].map(|c| self.target[c][l] - sums[c][l]);
                let step = solved(m, r);
                let length = (step[0].abs() + step[1].abs() + step[2].abs()).max(LONGEST);
                for i in 0..3 {
                    coefficients[i][l] += step[i] * (LONGEST / length);
                }
            }
        }
        let mut sums = [[0.0f32; LANES]; 3];
        for (w, base) in self.wavelengths.iter().zip(self.base.iter_mut()) {
            let p = w.position;
            for l in 0..LANES {
                let x = base[l] + (coefficients[0][l] * p + coefficients[1][l]) * p + coefficients[2][l];
                let s = 0.5 + 0.5 * x * inverse_sqrt_f32(1.0 + x * x);
                base[l] = s;
                for (sum, weight) in sums.iter_mut().zip(w.weights) {
                    sum[l] += weight * s;
                }
            }
        }
        let mut error = [0.0f32; LANES];
        for l in 0..LANES {
            for (sum, target) in sums.iter().zip(&self.target) {
                let e = (sum[l] - target[l]).abs() / (target[l] + 0.02);
                // A step into infinity leaves NaN, which must not count as a small error.
                error[l] = if e < f32::MAX { error[l].max(e) } else { f32::MAX };
            }
        }
        error
    }
}

/// The solution of three equations, by Cramer's rule.
#[inline(always)]
fn solved(m: [[f32; 3]; 3], r: [f32; 3]) -> [f32; 3] {
    let cross = |a: [f32; 3], b: [f32; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let column = |i: usize| [m[0][i], m[1][i], m[2][i]];
    let (a, b, c) = (column(0), column(1), column(2));
    let bc = cross(b, c);
    let determinant = dot(a, bc);
    let scale = if determinant == 0.0 { 0.0 } else { 1.0 / determinant };
    [dot(r, bc) * scale, dot(a, cross(r, c)) * scale, dot(a, cross(b, r)) * scale]
}

/// Corrects pixels, as many as there are lanes.
pub(super) fn close(wavelengths: &[Wavelength], base: &mut [Lanes], target: [Lanes; 3]) -> Lanes {
    dispatch(Closure { wavelengths, base, target })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::sigmoid::{polynomial, sigmoid};
    use crate::spectrum::{Observer, WavelengthGrid};

    /// Solutions that are known, of matrices whose diagonal dominates: rounding alone remains, of a few units of single precision.
    #[test]
    fn three_equations_are_solved() {
        let number = |i: usize| libm::sin(1.7 * i as f64 + 0.3) as f32;
        for first in (0..240).step_by(12) {
            let m = [0, 1, 2].map(|row| {
                [0, 1, 2].map(|col| number(first + 3 * row + col) + if row == col { 4.0 } else { 0.0 })
            });
            let known = [9, 10, 11].map(|i| number(first + i));
            let r = m.map(|row| row[0] * known[0] + row[1] * known[1] + row[2] * known[2]);
            for (found, known) in solved(m, r).iter().zip(known) {
                assert!((found - known).abs() < 1e-5, "{m:?}: {found} {known}");
            }
        }
        assert_eq!(solved([[0.0; 3]; 3], [1.0; 3]), [0.0; 3]);
    }

    /// Reflectances whose correction is known come back, a different one in each lane, and the error is that of their colours.
    #[test]
    fn known_corrections_come_back() {
        let fit = Fit::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap();
        let wavelengths = Wavelength::all(&fit, WavelengthGrid::VISIBLE.len());
        assert_eq!(wavelengths.len(), WavelengthGrid::VISIBLE.len());
        let original = |l: usize, p: f64| 0.45 + 0.3 * libm::sin(3.0 * p + l as f64);
        let known = |l: usize, p: f64| {
            let size = 0.02 * l as f64;
            let coefficients = [size * libm::sin(l as f64), 0.1 - size, 0.5 * size];
            let r = original(l, p);
            sigmoid((r - 0.5) / (r * (1.0 - r)).sqrt() + polynomial(coefficients, p))
        };
        let positions: Vec<f64> = wavelengths.iter().map(|w| f64::from(w.position)).collect();
        let mut base: Vec<Lanes> =
            positions.iter().map(|p| std::array::from_fn(|l| original(l, *p) as f32)).collect();
        let colour = |l: usize| fit.xyz_of(&positions.iter().map(|p| known(l, *p)).collect::<Vec<_>>());
        let mut target = [0, 1, 2].map(|c| std::array::from_fn(|l| colour(l)[c] as f32));
        // No reflectance is as bright as this.
        const BRIGHT: usize = LANES - 1;
        target.iter_mut().for_each(|t| t[BRIGHT] = 2.0);
        let error = close(&wavelengths, &mut base, target);
        for l in 0..BRIGHT {
            for (found, p) in base.iter().zip(&positions) {
                let expected = known(l, *p);
                assert!((f64::from(found[l]) - expected).abs() < 1e-3, "{l} {p}: {} {expected}", found[l]);
            }
            // A tenth of what counts as the colour.
            assert!(error[l] < 1e-4, "{l}: {}", error[l]);
        }
        assert!(error[BRIGHT] > 0.4, "{}", error[BRIGHT]);
    }
}
