//! Ridge regression with generalised cross-validation.
//!
//! G. H. Golub, M. Heath and G. Wahba (1979), "Generalized cross-validation as a method for choosing a good
//! ridge parameter", *Technometrics* 21(2) [golub1979]: the λ that minimises V(λ) = n ‖(I − A(λ)) y‖² / tr(I
//! − A(λ))², where A(λ) maps the data to their fit. It is close to the λ with the smallest error on unseen
//! data, and requires no knowledge of the noise. All terms follow from the moments. With the eigenvalues d
//! and eigenvectors v of the Gram matrix and β = v · c, ‖(I − A) y‖² = yᵀy − Σ β²/d + Σ β²/d (λ / (d + λ))²
//! and tr A = Σ d / (d + λ).

use crate::numeric::dense::{Eigen, dot};

/// Steps of the coarse search for λ over the whole range of eigenvalues.
const STEPS: usize = 64;
/// Refinements of the bracket around the best step. They determine λ to a thousandth, more precisely than
/// needed.
const REFINEMENTS: usize = 16;

/// The problem of one output, normalised by the number of patches.
pub(super) struct Ridge<'a> {
    pub(super) eigen: &'a Eigen,
    /// Eigenvalues up to this value count as rounding errors.
    pub(super) cut: f64,
    /// Number of patches.
    pub(super) count: f64,
    /// Degrees of freedom of the offset: 1 or 0.
    pub(super) offset: f64,
    /// Mean square of the output.
    pub(super) power: f64,
}

impl Ridge<'_> {
    /// The λ, per patch, that minimises V.
    pub(super) fn lambda(&self, cross: &[f64]) -> f64 {
        let terms: Vec<[f64; 2]> =
            self.eigen.above(self.cut).map(|(d, v)| [d, dot(v, cross).powi(2) / d]).collect();
        let largest = terms.iter().map(|t| t[0]).fold(0.0, f64::max);
        if largest <= self.cut {
            return 0.0;
        }
        let explained: f64 = terms.iter().map(|t| t[1]).sum();
        // With an exact fit, rounding can make the residual negative.
        let rest = (self.power - explained).max(0.0);
        let score = |log: f64| {
            let lambda = libm::exp(log);
            let residual =
                rest + terms.iter().map(|&[d, b]| b * (lambda / (d + lambda)).powi(2)).sum::<f64>();
            let free = self.count - self.offset - terms.iter().map(|&[d, _]| d / (d + lambda)).sum::<f64>();
            if free > 0.0 { residual / (free * free) } else { f64::INFINITY }
        };
        let (low, high) = (libm::log(self.cut.max(largest * f64::EPSILON)), libm::log(largest) + 5.0);
        let step = (high - low) / STEPS as f64;
        let mut best = (f64::INFINITY, low);
        for i in 0..=STEPS {
            let at = low + step * i as f64;
            let value = score(at);
            // Of equal values, take the larger λ.
            if value <= best.0 {
                best = (value, at);
            }
        }
        let mut width = step;
        for _ in 0..REFINEMENTS {
            width *= 0.6;
            for at in [best.1 - width, best.1 + width] {
                let value = score(at);
                if value < best.0 {
                    best = (value, at);
                }
            }
        }
        libm::exp(best.1)
    }
}
