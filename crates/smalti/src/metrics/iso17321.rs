//! The sensitivity metamerism index of a sensor (SMI, ISO 17321-1:2012, annex on the DSC/SMI, [iso17321]).
//!
//! SMI = 100 − 5.5 · mean ΔE*ab
//!
//! over the 18 colour patches of the ColorChecker. ΔE*ab (CIE 1976) is the difference between the colour of a patch for the CIE 1931
//! observer and the colour that the best 3 × N matrix computes from the N channels of the sensor. 100 is a sensor that fulfils the
//! Luther condition. The index has no lower limit and is negative for a mean ΔE*ab above 18.
//!
//! What the standard leaves to the user is chosen as follows. The light is stated by the caller, and is the white of CIELAB. The matrix
//! minimises the mean ΔE*ab itself, without a constraint on white, so that the index is the largest that the sensor
//! can reach under this light. The search begins at the least squares of X, Y, Z and iterates Gauss–Newton steps of
//! Levenberg and Marquardt, with patches weighted by 1 / ΔE*ab. The channels have no noise. Figures of DxOMark are measured on raw files of
//! cameras under other lights, D50 and A, and differ by several units.
//!
//! [iso17321]: https://www.iso.org/standard/56537.html

use super::MetricError;
use super::channels::{on_grid, weighted_basis};
use crate::color::lab_from_xyz;
use crate::numeric::dense::{cholesky, substitute};
use crate::numeric::least_squares::{Matrix, lstsq};
use crate::numeric::orthonormal::dot;
use crate::spectrum::{Observer, Spectrum, reflectance};

/// Colour patches of the ColorChecker; the grey series follows them.
const PATCHES: usize = 18;
/// The loss of the index per unit of ΔE*ab.
const SLOPE: f64 = 5.5;
/// ΔE*ab below which the weights of patches no longer grow.
const LEAST_DIFFERENCE: f64 = 1e-3;
/// The search ends when a step lowers the mean ΔE*ab by less than this share, or no step lowers it: the index is then within 0.01 of its
/// largest value.
const TOLERANCE: f64 = 1e-6;
const MAX_STEPS: usize = 300;
const DAMPING: [f64; 3] = [1e-12, 1e-4, 1e8];
/// Derivative of the linear part of CIELAB's cube root, and where it ends.
const LINEAR: (f64, f64) = (841.0 / 108.0, 216.0 / 24389.0);

/// The patches under one light, for the index of any sensor.
#[derive(Debug, Clone)]
pub struct MetamerismIndex {
    light: Spectrum,
    reflectances: Vec<Spectrum>,
    /// X, Y, Z of the patches, row after row, with Y = 100 for white.
    xyz: Vec<f64>,
    lab: Vec<[f64; 3]>,
    white: [f64; 3],
}

impl MetamerismIndex {
    /// The patches under a light (photons per nm, in any unit).
    ///
    /// # Errors
    /// When the light is dark to the observer.
    pub fn new(light: &Spectrum) -> Result<Self, MetricError> {
        let white = Observer::Cie1931.xyz_from_photons(light)?;
        if white.iter().any(|v| *v <= 0.0) {
            let reason = "the light is dark to the observer";
            return Err(MetricError::Undefined { quantity: "the sensitivity metamerism index", reason });
        }
        let scale = 100.0 / white[1];
        let white = white.map(|v| v * scale);
        let reflectances: Vec<Spectrum> =
            reflectance::colorchecker(light.grid())?.into_iter().take(PATCHES).map(|(_, s)| s).collect();
        let xyz = |s: &Spectrum| Ok(Observer::Cie1931.xyz_from_photons(&s.times(light)?)?.map(|v| v * scale));
        let xyz = reflectances.iter().map(xyz).collect::<Result<Vec<_>, MetricError>>()?;
        let lab = xyz.iter().map(|&p| lab_from_xyz(p, white)).collect();
        Ok(Self { light: light.clone(), reflectances, xyz: xyz.concat(), lab, white })
    }

    /// The index of channels, given as response per photon up to a factor.
    ///
    /// # Errors
    /// When there is no channel, a grid is not that of the light, no channel responds, or the solver fails.
    pub fn of(&self, channels: &[Spectrum]) -> Result<f64, MetricError> {
        on_grid(channels, self.light.grid())?;
        // Any basis of the channels gives the same colours. With an orthonormal one, the steps do not depend on their scale.
        let basis = weighted_basis("channels", channels, &self.light)?;
        let camera: Vec<f64> =
            self.reflectances.iter().flat_map(|r| basis.iter().map(|b| dot(b, r.values()))).collect();
        let count = basis.len();
        let start = lstsq(Matrix::new(PATCHES, count, &camera), Matrix::new(PATCHES, 3, &self.xyz)).map_err(
            |_| MetricError::Undefined {
                quantity: "the sensitivity metamerism index",
                reason: "the least squares of the colour matrix did not converge",
            },
        )?;
        // Row after row for X, Y, Z.
        let start: Vec<f64> =
            (0..3).flat_map(|j| start.iter().skip(j).step_by(3).copied().collect::<Vec<_>>()).collect();
        Ok(100.0 - SLOPE * self.least_mean(&camera, count, start))
    }

    /// Mean ΔE*ab of a matrix.
    fn mean(&self, camera: &[f64], count: usize, matrix: &[f64]) -> f64 {
        let one = |(c, lab): (&[f64], &[f64; 3])| distance(*lab, self.lab_of(c, matrix).1);
        camera.chunks_exact(count).zip(&self.lab).map(one).sum::<f64>() / PATCHES as f64
    }

    /// X, Y, Z relative to white, and CIELAB, of a patch.
    fn lab_of(&self, camera: &[f64], matrix: &[f64]) -> ([f64; 3], [f64; 3]) {
        let mut xyz = [0.0; 3];
        for (v, row) in xyz.iter_mut().zip(matrix.chunks_exact(camera.len())) {
            *v = dot(row, camera);
        }
        let relative = [0, 1, 2].map(|i| xyz[i] / self.white[i]);
        (relative, lab_from_xyz(xyz, self.white))
    }

    /// The least mean ΔE*ab that the search reaches from a matrix.
    fn least_mean(&self, camera: &[f64], count: usize, mut matrix: Vec<f64>) -> f64 {
        let [least_damping, mut damping, most_damping] = DAMPING;
        let mut mean = self.mean(camera, count, &matrix);
        for _ in 0..MAX_STEPS {
            let (normal, slope) = self.normal_equations(camera, count, &matrix);
            let size = slope.len();
            let diagonal = normal.iter().step_by(size + 1).sum::<f64>() / size as f64;
            let next = loop {
                let mut damped = normal.clone();
                damped.iter_mut().step_by(size + 1).for_each(|v| *v += damping * diagonal);
                let mut step = slope.clone();
                if cholesky(&mut damped, size, 0.0) {
                    substitute(&damped, size, &mut step);
                    let moved: Vec<f64> = matrix.iter().zip(&step).map(|(m, s)| m - s).collect();
                    let there = self.mean(camera, count, &moved);
                    if there < mean {
                        break Some((moved, there));
                    }
                }
                damping *= 10.0;
                if damping > most_damping {
                    break None;
                }
            };
            let Some((moved, there)) = next else { break };
            let gain = mean - there;
            (matrix, mean) = (moved, there);
            if gain < TOLERANCE * mean {
                break;
            }
            damping = (damping / 10.0).max(least_damping);
        }
        mean
    }

    /// The upper triangle of JᵀWJ, and JᵀWr, with r the differences in CIELAB, J their derivatives by the matrix, and W = 1 / ΔE*ab.
    fn normal_equations(&self, camera: &[f64], count: usize, matrix: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let size = 3 * count;
        let (mut normal, mut slope) = (vec![0.0; size * size], vec![0.0; size]);
        for (c, expected) in camera.chunks_exact(count).zip(&self.lab) {
            let (relative, lab) = self.lab_of(c, matrix);
            let r = [0, 1, 2].map(|i| lab[i] - expected[i]);
            let weight = 1.0 / distance(lab, *expected).max(LEAST_DIFFERENCE);
            let [x, y, z] = [0, 1, 2].map(|i| root_slope(relative[i]) / self.white[i]);
            let by_xyz = [[0.0, 116.0 * y, 0.0], [500.0 * x, -500.0 * y, 0.0], [0.0, 200.0 * y, -200.0 * z]];
            let column = |j: usize| by_xyz.map(|row| row[j]);
            for j in 0..3 {
                let along = weight * dot(&column(j), &r);
                (0..count).for_each(|k| slope[j * count + k] += along * c[k]);
                // The solver reads the upper triangle.
                for l in j..3 {
                    let product = weight * dot(&column(j), &column(l));
                    for k in 0..count {
                        let row = &mut normal[(j * count + k) * size + l * count..][..count];
                        row.iter_mut().zip(c).for_each(|(v, m)| *v += product * c[k] * m);
                    }
                }
            }
        }
        (normal, slope)
    }
}

/// The derivative of CIELAB's cube root.
fn root_slope(t: f64) -> f64 {
    if t > LINEAR.1 { 1.0 / (3.0 * t.cbrt().powi(2)) } else { LINEAR.0 }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
