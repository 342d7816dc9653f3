//! Solution of the moments of a class for its kernels.

mod golub1979;
#[cfg(test)]
mod tests;

use crate::numeric::dense::{self, Eigen, cholesky, substitute};
use golub1979::Ridge;

use super::{Alpha, KernelForm, L3Error, Moments, Solver, Statistics};
use crate::color::matrix::{Matrix3, inverse};
use crate::color::scielab::Opponent;
use crate::sensor::SignalNoise;

/// Eigenvalues up to this fraction of the summed second moments of the patch count as rounding errors.
/// Single-precision samples have rounding errors of about 10⁻¹⁵ of their squares; double-precision sums of
/// products, from which the means are subtracted, add a few dozen times 2·10⁻¹⁶. A direction in which the
/// patches vary less (standard deviation below 10⁻⁷ of the response) carries only rounding errors.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// The kernels of one class in double precision.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solution {
    /// Outputs × taps.
    pub(super) weights: Vec<f64>,
    /// One per output.
    pub(super) offsets: Vec<f64>,
}

impl Solution {
    /// The weighted sum of solutions.
    pub(super) fn mixed(parts: &[(f64, &Self)]) -> Option<Self> {
        let sum = |of: fn(&Self) -> &[f64]| {
            let mut sum = vec![0.0; of(parts.first()?.1).len()];
            for (share, part) in parts {
                sum.iter_mut().zip(of(part)).for_each(|(s, v)| *s += share * v);
            }
            Some(sum)
        };
        Some(Self { weights: sum(|s| &s.weights)?, offsets: sum(|s| &s.offsets)? })
    }
}

/// Solves the kernels of one class at a time, with parameters that all classes share.
#[derive(Debug)]
pub(super) struct ClassSolver<'a> {
    solver: &'a Solver,
    form: KernelForm,
    noise: SignalNoise,
    noisy: bool,
    side: usize,
    outputs: usize,
    opponent: Option<OpponentSpace>,
}

/// Indices of X, Y, Z among the outputs, and the matrices to opponent colours and back.
#[derive(Debug)]
struct OpponentSpace {
    places: [usize; 3],
    opponent_from_xyz: Matrix3,
    xyz_from_opponent: Matrix3,
}

impl OpponentSpace {
    fn of(outputs: &[String]) -> Option<Self> {
        let place = |name: &str| outputs.iter().position(|o| o == name);
        let opponent_from_xyz = Opponent::Degrees2.matrix();
        Some(Self {
            places: [place("X")?, place("Y")?, place("Z")?],
            opponent_from_xyz,
            xyz_from_opponent: inverse(&opponent_from_xyz)?,
        })
    }
}

impl<'a> ClassSolver<'a> {
    pub(super) fn new(solver: &'a Solver, form: KernelForm, statistics: &Statistics) -> Self {
        Self {
            solver,
            form,
            noise: *statistics.axes().noise(),
            noisy: statistics.noisy(),
            side: statistics.axes().side(),
            outputs: statistics.outputs().len(),
            opponent: OpponentSpace::of(statistics.outputs()),
        }
    }

    /// The kernels of a class; `class` is its index, for error messages.
    pub(super) fn solve(&self, moments: &Moments, flat: bool, class: usize) -> Result<Solution, L3Error> {
        let normal = Normal::new(moments, self.side * self.side, self.outputs, self.form);
        let mut weights = normal.cross.clone();
        self.weights(&normal, moments, flat, &mut weights)
            .filter(|()| weights.iter().all(|w| w.is_finite()))
            .ok_or(L3Error::Singular(class))?;
        Ok(normal.solution(weights))
    }

    /// Weights in place of the cross-products.
    fn weights(&self, normal: &Normal, moments: &Moments, flat: bool, rows: &mut [f64]) -> Option<()> {
        let taps = normal.taps;
        match self.solver {
            Solver::LeastSquares => {
                let eigen = Eigen::of(&normal.gram, taps)?;
                rows.chunks_exact_mut(taps).for_each(|row| eigen.solve(normal.cut, 0.0, row));
            }
            Solver::Ridge => {
                let eigen = Eigen::of(&normal.gram, taps)?;
                let (cut, count) = (normal.cut, normal.count);
                let offset = f64::from(u8::from(self.form == KernelForm::Affine));
                for (row, &power) in rows.chunks_exact_mut(taps).zip(&normal.power) {
                    let lambda = Ridge { eigen: &eigen, cut, count, offset, power }.lambda(row);
                    eigen.solve(cut, lambda, row);
                }
            }
            Solver::Wiener => self.loaded(normal, moments, 1.0)?.solve_rows(rows),
            Solver::Perceptual(weights) => {
                let alpha = if flat { weights.flat } else { weights.texture };
                self.perceptual(normal, moments, alpha, rows)?;
            }
        }
        Some(())
    }

    fn perceptual(&self, normal: &Normal, moments: &Moments, alpha: Alpha, rows: &mut [f64]) -> Option<()> {
        let taps = normal.taps;
        let Some(space) = &self.opponent else {
            self.loaded(normal, moments, 1.0)?.solve_rows(rows);
            return Some(());
        };
        let others: Vec<usize> = (0..self.outputs).filter(|o| !space.places.contains(o)).collect();
        let row = |o: usize| o * taps..(o + 1) * taps;
        if !others.is_empty() {
            let plain = self.loaded(normal, moments, 1.0)?;
            others.into_iter().for_each(|o| plain.solve_rows(&mut rows[row(o)]));
        }
        let luminance = self.loaded(normal, moments, alpha.luminance)?;
        if alpha.luminance == alpha.chrominance {
            // With a single weight the colour space does not matter, and for 1 this is Wiener's solution bit
            // by bit.
            space.places.into_iter().for_each(|o| luminance.solve_rows(&mut rows[row(o)]));
            return Some(());
        }
        let chrominance = self.loaded(normal, moments, alpha.chrominance)?;
        let xyz = space.places.map(|o| rows[row(o)].to_vec());
        let mut opponent = space.opponent_from_xyz.map(|m| combined(&m, &xyz));
        luminance.solve_rows(&mut opponent[0]);
        opponent[1..].iter_mut().for_each(|w| chrominance.solve_rows(w));
        for (m, o) in space.xyz_from_opponent.iter().zip(space.places) {
            rows[row(o)].copy_from_slice(&combined(m, &opponent));
        }
        Some(())
    }

    /// The system C + α Σ. When the statistics are of noisy samples, C includes Σ already.
    fn loaded(&self, normal: &Normal, moments: &Moments, alpha: f64) -> Option<System> {
        let mut gram = normal.gram.clone();
        let load = if self.noisy { alpha - 1.0 } else { alpha };
        if load != 0.0 {
            add_noise(&mut gram, load, &self.noise, self.side, moments);
        }
        System::of(gram, normal.taps, normal.cut)
    }
}

/// Three rows multiplied by a row of a matrix and summed.
fn combined(m: &[f64; 3], rows: &[Vec<f64>; 3]) -> Vec<f64> {
    let [a, b, c] = rows;
    a.iter().zip(b).zip(c).map(|((a, b), c)| m[0] * a + m[1] * b + m[2] * c).collect()
}

/// Adds `load` times the noise covariance of patches with these moments: pixel noise on the diagonal, and row
/// and column noise where two taps share a row or a column.
fn add_noise(gram: &mut [f64], load: f64, noise: &SignalNoise, side: usize, moments: &Moments) {
    let taps = side * side;
    let share = 1.0 / moments.get(0, 0).max(1.0);
    for (i, line) in gram.chunks_exact_mut(taps).enumerate() {
        line[i] += load * noise.own(moments.get(0, 1 + i) * share, moments.get(1 + i, 1 + i) * share);
        if noise.row == 0.0 && noise.column == 0.0 {
            continue;
        }
        let first = i - i % side;
        line[first..first + side].iter_mut().for_each(|v| *v += load * noise.row);
        line.iter_mut().skip(i % side).step_by(side).for_each(|v| *v += load * noise.column);
    }
}

/// A factorised symmetric system.
enum System {
    /// Cholesky factor: Uᵀ U.
    Factored(Vec<f64>, usize),
    /// Eigendecomposition, where the matrix is singular.
    Spectral(Eigen, f64),
}

impl System {
    fn of(gram: Vec<f64>, size: usize, cut: f64) -> Option<Self> {
        let mut factor = gram.clone();
        if cholesky(&mut factor, size, cut) {
            return Some(Self::Factored(factor, size));
        }
        Eigen::of(&gram, size).map(|eigen| Self::Spectral(eigen, cut))
    }

    fn solve_rows(&self, rows: &mut [f64]) {
        match self {
            Self::Factored(u, size) => rows.chunks_exact_mut(*size).for_each(|row| substitute(u, *size, row)),
            Self::Spectral(eigen, cut) => {
                rows.chunks_exact_mut(eigen.values.len()).for_each(|row| eigen.solve(*cut, 0.0, row));
            }
        }
    }
}

/// Second moments of a class per patch: central moments for affine kernels, moments about zero for linear
/// ones.
struct Normal {
    taps: usize,
    form: KernelForm,
    count: f64,
    /// Taps × taps.
    gram: Vec<f64>,
    /// Outputs × taps.
    cross: Vec<f64>,
    /// Mean squares of the outputs.
    power: Vec<f64>,
    mean_patch: Vec<f64>,
    mean_target: Vec<f64>,
    /// Eigenvalues up to this value count as rounding errors.
    cut: f64,
}

impl Normal {
    fn new(m: &Moments, taps: usize, outputs: usize, form: KernelForm) -> Self {
        let count = m.get(0, 0);
        let share = 1.0 / count.max(1.0);
        let means: Vec<f64> = (0..m.size()).map(|i| m.get(0, i) * share).collect();
        let about = match form {
            KernelForm::Affine => 1.0,
            KernelForm::Linear => 0.0,
        };
        let mut gram = vec![0.0; taps * taps];
        let mut cross = vec![0.0; outputs * taps];
        let mut rows = m.sums().get(m.size()..).unwrap_or(&[]);
        for i in 0..taps {
            let (row, rest) = rows.split_at(m.size() - 1 - i);
            let (patch, target) = row.split_at(taps - i);
            let (mean, others) = (about * means[1 + i], &means[1 + i..]);
            let line = gram[i * taps + i..(i + 1) * taps].iter_mut();
            line.zip(patch).zip(others).for_each(|((g, v), other)| *g = v * share - mean * other);
            let column = cross.iter_mut().skip(i).step_by(taps);
            column
                .zip(target)
                .zip(&others[taps - i..])
                .for_each(|((c, v), other)| *c = v * share - mean * other);
            rows = rest;
        }
        for i in 1..taps {
            for j in 0..i {
                gram[i * taps + j] = gram[j * taps + i];
            }
        }
        let (patch, target) = (1..1 + taps, 1 + taps..1 + taps + outputs);
        let squares: f64 = patch.map(|i| m.get(i, i) * share).sum();
        Self {
            taps,
            form,
            count,
            gram,
            cross,
            power: target.map(|o| (m.get(o, o) * share - about * means[o] * means[o]).max(0.0)).collect(),
            // Above zero, so that a class of black patches has a solution.
            cut: (ROUNDING * squares).max(f64::MIN_POSITIVE),
            mean_target: means[1 + taps..].to_vec(),
            mean_patch: means[1..1 + taps].to_vec(),
        }
    }

    /// Completes the weights with their offsets.
    fn solution(&self, weights: Vec<f64>) -> Solution {
        let offset = |(row, mean): (&[f64], &f64)| match self.form {
            KernelForm::Affine => mean - dense::dot(row, &self.mean_patch),
            KernelForm::Linear => 0.0,
        };
        let offsets = weights.chunks_exact(self.taps).zip(&self.mean_target).map(offset).collect();
        Solution { weights, offsets }
    }
}

/// The kernels of least squared error over the patches of a class, with `load(i)` times the mean variance of the samples added to that
/// of sample i, and a covariance (taps × taps) to that of all; none if it is empty. `None` when there is no solution.
pub(super) fn regularised(
    moments: &Moments,
    taps: usize,
    outputs: usize,
    load: impl Fn(usize) -> f64,
    covariance: &[f64],
) -> Option<Solution> {
    let normal = Normal::new(moments, taps, outputs, KernelForm::Affine);
    let mut gram = normal.gram.clone();
    let mean = (0..taps).map(|i| gram[i * taps + i]).sum::<f64>() / taps.max(1) as f64;
    (0..taps).for_each(|i| gram[i * taps + i] += load(i) * mean);
    gram.iter_mut().zip(covariance).for_each(|(g, c)| *g += c);
    let mut weights = normal.cross.clone();
    System::of(gram, taps, normal.cut)?.solve_rows(&mut weights);
    weights.iter().all(|w| w.is_finite()).then(|| normal.solution(weights))
}
