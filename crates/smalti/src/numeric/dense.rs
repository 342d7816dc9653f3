//! Small symmetric systems on slices: matrices in row order, a side of at most a few hundred.

use faer::{MatRef, Side};

/// A = Uᵀ U in place of A, of which only what is on and above the diagonal is read and written. False as soon as a pivot is
/// not above `least`: the matrix is then singular to the precision of its entries.
pub(crate) fn cholesky(a: &mut [f64], size: usize, least: f64) -> bool {
    for k in 0..size {
        let (above, below) = a.split_at_mut((k + 1) * size);
        let row = &mut above[k * size + k..];
        // Written so that NaN fails.
        if !(row[0] > least && row[0].is_finite()) {
            return false;
        }
        let scale = 1.0 / row[0].sqrt();
        row.iter_mut().for_each(|v| *v *= scale);
        for (i, line) in below.chunks_exact_mut(size).enumerate() {
            let from_here = &row[i + 1..];
            let factor = from_here[0];
            line[k + 1 + i..].iter_mut().zip(from_here).for_each(|(x, &u)| *x -= factor * u);
        }
    }
    true
}

/// x of Uᵀ U x = b, in place of b.
pub(crate) fn substitute(u: &[f64], size: usize, b: &mut [f64]) {
    for (k, row) in u.chunks_exact(size).enumerate() {
        let value = b[k] / row[k];
        b[k] = value;
        b[k + 1..].iter_mut().zip(&row[k + 1..]).for_each(|(x, &u)| *x -= u * value);
    }
    for (k, row) in u.chunks_exact(size).enumerate().rev() {
        let known: f64 = row[k + 1..].iter().zip(&b[k + 1..]).map(|(u, x)| u * x).sum();
        b[k] = (b[k] - known) / row[k];
    }
}

/// Eigenvalues and eigenvectors of a symmetric matrix.
#[derive(Debug)]
pub(crate) struct Eigen {
    pub(crate) values: Vec<f64>,
    /// One after the other.
    pub(crate) vectors: Vec<f64>,
}

impl Eigen {
    /// Of a symmetric matrix; `None` when a value is not finite or the iteration does not end.
    pub(crate) fn of(a: &[f64], size: usize) -> Option<Self> {
        if size == 0 || a.len() != size * size || a.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let eigen = MatRef::from_row_major_slice(a, size, size).self_adjoint_eigen(Side::Upper).ok()?;
        let values: Vec<f64> = eigen.S().column_vector().iter().copied().collect();
        let vectors: Vec<f64> =
            eigen.U().col_iter().flat_map(|v| v.iter().copied().collect::<Vec<_>>()).collect();
        values.iter().chain(&vectors).all(|v| v.is_finite()).then_some(Self { values, vectors })
    }

    /// Eigenvalues above a bound with their vectors.
    pub(crate) fn above(&self, bound: f64) -> impl Iterator<Item = (f64, &[f64])> {
        let vectors = self.vectors.chunks_exact(self.values.len().max(1));
        self.values.iter().copied().zip(vectors).filter(move |&(d, _)| d > bound)
    }

    /// The x of minimum norm with the least ‖A x − b‖, where eigenvalues up to a bound count as zero; in place of b.
    pub(crate) fn solve(&self, bound: f64, b: &mut [f64]) {
        let mut x = vec![0.0; b.len()];
        for (d, v) in self.above(bound) {
            let along = dot(v, b) / d;
            x.iter_mut().zip(v).for_each(|(x, v)| *x += along * v);
        }
        b.copy_from_slice(&x);
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    /// A Aᵀ of a random A of `size` × `rank`, and a right side.
    fn system(size: usize, rank: usize) -> (Vec<f64>, Vec<f64>) {
        let mut random = Stream::new(5, 6, 7);
        let a: Vec<f64> = (0..size * rank).map(|_| random.uniform() - 0.5).collect();
        let row = |i: usize| &a[i * rank..(i + 1) * rank];
        let gram = (0..size * size).map(|at| dot(row(at / size), row(at % size))).collect();
        (gram, (0..size).map(|_| random.uniform()).collect())
    }

    #[test]
    fn both_ways_solve() {
        for size in [1, 2, 9, 25, 122] {
            let (a, b) = system(size, size + 5);
            let mut u = a.clone();
            assert!(cholesky(&mut u, size, 0.0));
            let (mut x, mut y) = (b.clone(), b.clone());
            substitute(&u, size, &mut x);
            Eigen::of(&a, size).unwrap().solve(0.0, &mut y);
            for i in 0..size {
                // The condition of these matrices is below 10⁵.
                let back = dot(&a[i * size..(i + 1) * size], &x);
                assert!((back - b[i]).abs() < 1e-9 && (x[i] - y[i]).abs() < 1e-8 * x[i].abs().max(1.0));
            }
        }
    }

    #[test]
    fn what_is_singular_is_told_and_solved_with_the_smallest_norm() {
        let (a, mut b) = system(8, 3);
        assert!(!cholesky(&mut a.clone(), 8, 1e-12));
        let eigen = Eigen::of(&a, 8).unwrap();
        assert_eq!(eigen.above(1e-12).count(), 3);
        eigen.solve(1e-12, &mut b);
        // Nothing of x lies in the null space.
        for v in eigen.vectors.chunks_exact(8).take(5) {
            assert!(dot(v, &b).abs() < 1e-9);
        }
        assert!(Eigen::of(&[f64::NAN], 1).is_none() && !cholesky(&mut [f64::NAN], 1, 0.0));
    }
}
