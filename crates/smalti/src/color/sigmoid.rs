//! The fit of a smooth reflectance to a colour: a sigmoid of a polynomial in wavelength, or of a given reflectance
//! and a polynomial.

use super::cie1976::lab_from_xyz;
use super::display::Matrices;
use super::matrix::{Matrix3, apply, inverse};
use crate::numeric::require;
use crate::numeric::simd::{Kernel, dispatch};
use crate::spectrum::{Extrapolation, Illuminant, Observer, SpectrumError, WavelengthGrid};

/// Reflectances σ(β(λ) + a p² + b p + c) with σ(x) = ½ + x / (2 √(1 + x²)) and p = (λ − 550 nm) / 150 nm, and their
/// colours under D65. The base β is 0 at every wavelength unless another one was set.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// The wavelengths in blocks of four.
    pub(super) blocks: Vec<Block>,
    /// XYZ relative to white from linear sRGB.
    pub(super) relative_xyz_from_rgb: Matrix3,
}

/// Four wavelengths, for SIMD. Wavelengths beyond the end of the grid have zero weight.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Block {
    /// Normalised wavelengths: −1 at 400 nm, 1 at 700 nm.
    pub(super) position: [f64; LANES],
    /// Weights in X, Y and Z under D65, relative to white.
    pub(super) weights: [[f64; LANES]; 3],
    base: [f64; LANES],
}

pub(super) const LANES: usize = 4;

/// The integrals of XYZ over all blocks, in lanes, and their derivatives by the coefficients.
struct Integrals<'a> {
    blocks: &'a [Block],
    coefficients: [f64; 3],
}

impl Kernel for Integrals<'_> {
    type Output = ([[f64; LANES]; 3], [[[f64; LANES]; 3]; 3]);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let mut sums = [[0.0; LANES]; 3];
        let mut slopes = [[[0.0; LANES]; 3]; 3];
        for block in self.blocks {
            for l in 0..LANES {
                let p = block.position[l];
                let x = block.base[l] + polynomial(self.coefficients, p);
                let root = 1.0 / (1.0 + x * x).sqrt();
                let (s, ds) = (0.5 + 0.5 * x * root, 0.5 * root * root * root);
                for ((sum, slope), w) in sums.iter_mut().zip(&mut slopes).zip(&block.weights) {
                    sum[l] += w[l] * s;
                    let k = w[l] * ds;
                    slope[0][l] += k * p * p;
                    slope[1][l] += k * p;
                    slope[2][l] += k;
                }
            }
        }
        (sums, slopes)
    }
}

impl Fit {
    /// For an observer and a grid that covers the visible range; the white is D65.
    ///
    /// # Errors
    /// When the grid does not overlap the observer's sensitivity.
    pub(super) fn new(grid: WavelengthGrid, observer: Observer) -> Result<Self, SpectrumError> {
        // D65 is not defined beyond 830 nm, where the observer's sensitivity is negligible.
        let d65 = Illuminant::D65
            .energy(WavelengthGrid::new(360.0, 1.0, 471)?)?
            .resampled(grid, Extrapolation::Zero)?;
        let [x, y, z] = observer.matching_functions(grid)?;
        let weights: Vec<[f64; 3]> =
            (0..grid.len()).map(|i| [&x, &y, &z].map(|m| m.values()[i] * d65.values()[i])).collect();
        let white = [0, 1, 2].map(|c| weights.iter().map(|w| w[c]).sum::<f64>());
        for w in white {
            let name = "the observer's response to D65 on the wavelength grid";
            require(w > 0.0, name, w, "a grid that covers the visible range")?;
        }
        let mut blocks = vec![Block::default(); grid.len().div_ceil(LANES)];
        for (i, (nm, w)) in grid.wavelengths_nm().zip(&weights).enumerate() {
            let block = &mut blocks[i / LANES];
            block.position[i % LANES] = position(nm);
            for c in 0..3 {
                block.weights[c][i % LANES] = w[c] / white[c];
            }
        }
        let relative_xyz_from_rgb = Matrices::SRGB.xyz_from_rgb.map(|row| {
            let white = row[0] + row[1] + row[2];
            row.map(|v| v / white)
        });
        Ok(Self { blocks, relative_xyz_from_rgb })
    }

    /// The same with another base; it has a value for every wavelength of the grid.
    pub(super) fn on(&self, base: impl Iterator<Item = f64>) -> Self {
        let mut fit = self.clone();
        for (lane, value) in fit.blocks.iter_mut().flat_map(|b| &mut b.base).zip(base) {
            *lane = value;
        }
        fit
    }

    /// XYZ of a linear sRGB colour, relative to white.
    pub(super) fn xyz(&self, rgb: [f64; 3]) -> [f64; 3] {
        apply(&self.relative_xyz_from_rgb, rgb)
    }

    /// XYZ of a reflectance under D65, relative to white.
    pub(super) fn xyz_of(&self, reflectance: &[f64]) -> [f64; 3] {
        let mut xyz = [0.0; 3];
        for (block, r) in self.blocks.iter().zip(reflectance.chunks(LANES)) {
            for (sum, w) in xyz.iter_mut().zip(&block.weights) {
                *sum += r.iter().zip(w).map(|(r, w)| r * w).sum::<f64>();
            }
        }
        xyz
    }

    /// CIELAB of a linear sRGB colour.
    pub(super) fn target(&self, rgb: &[f64; 3]) -> [f64; 3] {
        lab_from_xyz(self.xyz(*rgb), [1.0; 3])
    }

    /// CIELAB of the reflectance of a set of coefficients under D65.
    pub(super) fn lab(&self, coefficients: [f64; 3]) -> [f64; 3] {
        let mut sums = [[0.0; LANES]; 3];
        for block in &self.blocks {
            for l in 0..LANES {
                let s = sigmoid(block.base[l] + polynomial(coefficients, block.position[l]));
                for (sum, w) in sums.iter_mut().zip(&block.weights) {
                    sum[l] += w[l] * s;
                }
            }
        }
        lab_from_xyz(sums.map(|s| s.iter().sum()), [1.0; 3])
    }

    /// CIELAB of the reflectance under D65, and its Jacobian with one row each for L*, a*, b*.
    fn lab_and_jacobian(&self, coefficients: [f64; 3]) -> ([f64; 3], Matrix3) {
        let (sums, slopes) = dispatch(Integrals { blocks: &self.blocks, coefficients });
        let xyz: [f64; 3] = sums.map(|s| s.iter().sum());
        let slope: Matrix3 = slopes.map(|s| s.map(|s| s.iter().sum()));
        let lab = lab_from_xyz(xyz, [1.0; 3]);
        // Derivative of CIELAB's cube root, and of the linear segment near black.
        let df =
            xyz.map(|t| if t > 216.0 / 24389.0 { 1.0 / (3.0 * t.cbrt().powi(2)) } else { 841.0 / 108.0 });
        let jacobian = [0, 1, 2].map(|k| {
            let [fx, fy, fz] = [0, 1, 2].map(|c| df[c] * slope[c][k]);
            [116.0 * fy, 500.0 * (fx - fy), 200.0 * (fy - fz)]
        });
        // Transpose: the rows above are per coefficient.
        (lab, [0, 1, 2].map(|r| [jacobian[0][r], jacobian[1][r], jacobian[2][r]]))
    }

    /// Levenberg–Marquardt least squares until ΔE*ab is below `tolerance`.
    pub(super) fn solved(&self, target: [f64; 3], start: [f64; 3], tolerance: f64) -> [f64; 3] {
        let mut at = start;
        let (lab, mut jacobian) = self.lab_and_jacobian(at);
        let mut residual = minus(lab, target);
        let mut damping = 1e-4;
        for _ in 0..60 {
            let error = square(residual);
            if error < tolerance * tolerance || damping > 1e8 {
                break;
            }
            let Some(step) = step(&jacobian, residual, damping) else { break };
            let next = minus(at, step);
            let (lab, next_jacobian) = self.lab_and_jacobian(next);
            let next_residual = minus(lab, target);
            if square(next_residual) < error {
                (at, jacobian, residual) = (next, next_jacobian, next_residual);
                damping *= 0.1;
            } else {
                damping *= 10.0;
            }
        }
        at
    }
}

/// Normalised wavelength: −1 at 400 nm, 1 at 700 nm.
pub(super) fn position(wavelength_nm: f64) -> f64 {
    (wavelength_nm - 550.0) / 150.0
}

#[inline(always)]
pub(super) fn polynomial([a, b, c]: [f64; 3], p: f64) -> f64 {
    (a * p + b) * p + c
}

#[inline(always)]
pub(super) fn sigmoid(x: f64) -> f64 {
    0.5 + 0.5 * x / (1.0 + x * x).sqrt()
}

pub(super) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn square(v: [f64; 3]) -> f64 {
    v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
}

/// One damped Gauss–Newton step; `None` where the normal equations have no solution.
fn step(jacobian: &Matrix3, residual: [f64; 3], damping: f64) -> Option<[f64; 3]> {
    let j = jacobian;
    let normal = [0, 1, 2].map(|a| {
        [0, 1, 2].map(|b| {
            let v = j[0][a] * j[0][b] + j[1][a] * j[1][b] + j[2][a] * j[2][b];
            if a == b { v * (1.0 + damping) } else { v }
        })
    });
    let gradient = [0, 1, 2].map(|a| j[0][a] * residual[0] + j[1][a] * residual[1] + j[2][a] * residual[2]);
    Some(apply(&inverse(&normal)?, gradient))
}
