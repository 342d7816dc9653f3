//! Dense symmetric systems of a few hundred unknowns at most, as row-major slices.

use super::simd::{Kernel, dispatch};

/// Cholesky factorisation A = Uᵀ U in place, on the upper triangle. Returns false when a pivot is not above
/// `least`, that is, when the matrix is singular to the precision of its entries.
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

/// Solves Uᵀ U x = b in place of `b`.
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
    /// Ascending.
    pub(crate) values: Vec<f64>,
    /// Eigenvectors, concatenated.
    pub(crate) vectors: Vec<f64>,
}

impl Eigen {
    /// Decomposes a symmetric matrix; `None` when a value is not finite or the iteration does not converge.
    ///
    /// Householder reflections make the matrix tridiagonal; the implicit QL iteration with Wilkinson's shift makes it diagonal
    /// ([golub2013], sections 8.3.1 and 8.3.3). Sums have one order, so that every machine gives the same bits.
    ///
    /// [golub2013]: https://doi.org/10.56021/9781421407944
    pub(crate) fn of(a: &[f64], size: usize) -> Option<Self> {
        if size == 0 || a.len() != size * size || a.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let (mut values, vectors) = dispatch(Diagonalisation { a, size })?;
        let mut order: Vec<usize> = (0..size).collect();
        order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
        let sorted = order.iter().flat_map(|&i| vectors[i * size..(i + 1) * size].iter().copied()).collect();
        values.sort_by(f64::total_cmp);
        let finite = |v: &f64| v.is_finite();
        let found = Self { values, vectors: sorted };
        found.values.iter().chain(&found.vectors).all(finite).then_some(found)
    }

    /// The eigenvalues above a bound, with their eigenvectors.
    pub(crate) fn above(&self, bound: f64) -> impl Iterator<Item = (f64, &[f64])> {
        let vectors = self.vectors.chunks_exact(self.values.len().max(1));
        self.values.iter().copied().zip(vectors).filter(move |&(d, _)| d > bound)
    }

    /// The minimum-norm solution x of min ‖A x − b‖² + λ ‖x‖², in place of `b`. Eigenvalues up to `bound` count as
    /// zero.
    pub(crate) fn solve(&self, bound: f64, lambda: f64, b: &mut [f64]) {
        let mut x = vec![0.0; b.len()];
        for (d, v) in self.above(bound) {
            let along = dot(v, b) / (d + lambda);
            x.iter_mut().zip(v).for_each(|(x, v)| *x += along * v);
        }
        b.copy_from_slice(&x);
    }
}

/// Eigenvalues and eigenvectors, not sorted.
struct Diagonalisation<'a> {
    a: &'a [f64],
    size: usize,
}

impl Kernel for Diagonalisation<'_> {
    type Output = Option<(Vec<f64>, Vec<f64>)>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let (mut values, mut off, mut vectors) = tridiagonal(self.a.to_vec(), self.size);
        diagonalise(&mut values, &mut off, &mut vectors)?;
        Some((values, vectors))
    }
}

/// Diagonal, off-diagonal and Qᵀ of Qᵀ A Q = T.
#[inline(always)]
fn tridiagonal(mut a: Vec<f64>, size: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut off = vec![0.0; size];
    // Of each reflection I − β v vᵀ: β, and v in the row of the matrix that it made zero.
    let mut factors = vec![0.0; size];
    let mut image = vec![0.0; size];
    for k in 0..size.saturating_sub(1) {
        let (above, below) = a.split_at_mut((k + 1) * size);
        let (v, p) = (&mut above[k * size + k + 1..], &mut image[k + 1..]);
        let scale = v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let rest = v[1..].iter().fold(0.0f64, |m, x| m.max(x.abs()));
        if rest == 0.0 {
            off[k] = v[0];
            continue;
        }
        v.iter_mut().for_each(|x| *x /= scale);
        let norm = dot(v, v).sqrt().copysign(v[0]);
        off[k] = -norm * scale;
        v[0] += norm;
        let factor = 1.0 / (norm * v[0]);
        factors[k] = factor;
        // p = β A v, with A's rows below the diagonal read in order; then A − v wᵀ − w vᵀ.
        p.fill(0.0);
        for (line, &x) in below.chunks_exact(size).zip(v.iter()) {
            p.iter_mut().zip(&line[k + 1..]).for_each(|(p, a)| *p += x * a);
        }
        p.iter_mut().for_each(|p| *p *= factor);
        let along = 0.5 * factor * dot(v, p);
        p.iter_mut().zip(v.iter()).for_each(|(w, x)| *w -= along * x);
        for ((line, &x), &w) in below.chunks_exact_mut(size).zip(v.iter()).zip(p.iter()) {
            let pairs = v.iter().zip(p.iter());
            line[k + 1..].iter_mut().zip(pairs).for_each(|(a, (vj, wj))| *a -= x * wj + w * vj);
        }
    }
    let diagonal = (0..size).map(|i| a[i * size + i]).collect();
    // Q of the reflections, from the last to the first; then its transpose.
    let mut q = vec![0.0; size * size];
    (0..size).for_each(|i| q[i * size + i] = 1.0);
    for k in (0..size.saturating_sub(1)).rev().filter(|&k| factors[k] != 0.0) {
        let (v, sums) = (&a[k * size + k + 1..(k + 1) * size], &mut image[k + 1..]);
        sums.fill(0.0);
        let lines = &mut q[(k + 1) * size..];
        for (line, &x) in lines.chunks_exact(size).zip(v) {
            sums.iter_mut().zip(&line[k + 1..]).for_each(|(s, q)| *s += x * q);
        }
        for (line, &x) in lines.chunks_exact_mut(size).zip(v) {
            let share = factors[k] * x;
            line[k + 1..].iter_mut().zip(sums.iter()).for_each(|(q, s)| *q -= share * s);
        }
    }
    let transposed = (0..size * size).map(|at| q[at % size * size + at / size]).collect();
    (diagonal, off, transposed)
}

/// Turns of the QL iteration for one eigenvalue; two or three are usual.
const MAX_TURNS: usize = 60;

/// Makes a tridiagonal matrix diagonal, and turns the rows of `vectors` with it.
#[inline(always)]
fn diagonalise(diagonal: &mut [f64], off: &mut [f64], vectors: &mut [f64]) -> Option<()> {
    let size = diagonal.len();
    for first in 0..size {
        for turn in 0.. {
            let split = |i: &usize| {
                let around = diagonal[*i].abs() + diagonal[i + 1].abs();
                off[*i].abs() <= f64::EPSILON * around
            };
            let last = (first..size - 1).find(split).unwrap_or(size - 1);
            if last == first {
                break;
            }
            if turn == MAX_TURNS {
                return None;
            }
            let half = (diagonal[first + 1] - diagonal[first]) / (2.0 * off[first]);
            let root = libm::hypot(half, 1.0).copysign(half);
            let mut bulge = diagonal[last] - diagonal[first] + off[first] / (half + root);
            let (mut sine, mut cosine, mut shift) = (1.0, 1.0, 0.0);
            let mut whole = true;
            for i in (first..last).rev() {
                let (f, b) = (sine * off[i], cosine * off[i]);
                let length = libm::hypot(f, bulge);
                off[i + 1] = length;
                if length == 0.0 {
                    // The matrix has come apart before the end of the sweep.
                    diagonal[i + 1] -= shift;
                    off[last] = 0.0;
                    whole = false;
                    break;
                }
                (sine, cosine) = (f / length, bulge / length);
                let at = diagonal[i + 1] - shift;
                let sum = (diagonal[i] - at) * sine + 2.0 * cosine * b;
                shift = sine * sum;
                diagonal[i + 1] = at + shift;
                bulge = cosine * sum - b;
                let (above, below) = vectors.split_at_mut((i + 1) * size);
                for (x, y) in above[i * size..].iter_mut().zip(&mut below[..size]) {
                    (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
                }
            }
            if whole {
                diagonal[first] -= shift;
                off[first] = bulge;
                off[last] = 0.0;
            }
        }
    }
    Some(())
}

#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    /// Returns A Aᵀ for a random A of `size` × `rank`, and a right-hand side.
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
            Eigen::of(&a, size).unwrap().solve(0.0, 0.0, &mut y);
            for i in 0..size {
                // The condition of these matrices is below 10⁵.
                let back = dot(&a[i * size..(i + 1) * size], &x);
                assert!((back - b[i]).abs() < 1e-9 && (x[i] - y[i]).abs() < 1e-8 * x[i].abs().max(1.0));
            }
        }
    }

    #[test]
    fn vectors_are_orthonormal_and_make_the_matrix_again() {
        for (size, rank) in [(1, 1), (2, 2), (3, 1), (25, 30), (40, 12), (122, 130)] {
            let (a, _) = system(size, rank);
            let Eigen { values, vectors } = Eigen::of(&a, size).unwrap();
            assert!(values.is_sorted());
            let largest = values[size - 1];
            let row = |i: usize| &vectors[i * size..(i + 1) * size];
            for i in 0..size {
                for j in 0..size {
                    let unit = f64::from(u8::from(i == j));
                    assert!((dot(row(i), row(j)) - unit).abs() < 1e-13, "{size}: {i}, {j}");
                    let made: f64 = (0..size).map(|k| values[k] * row(k)[i] * row(k)[j]).sum();
                    assert!((made - a[i * size + j]).abs() < 1e-13 * largest, "{size}: {i}, {j}");
                }
            }
        }
        // Diagonal and equal values, and a matrix of zeros.
        assert_eq!(
            Eigen::of(&[3.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 3.0], 3).unwrap().values,
            [1.0, 3.0, 3.0]
        );
        assert_eq!(Eigen::of(&[0.0; 16], 4).unwrap().values, [0.0; 4]);
    }

    #[test]
    fn what_is_singular_is_told_and_solved_with_the_smallest_norm() {
        let (a, mut b) = system(8, 3);
        assert!(!cholesky(&mut a.clone(), 8, 1e-12));
        let eigen = Eigen::of(&a, 8).unwrap();
        assert_eq!(eigen.above(1e-12).count(), 3);
        eigen.solve(1e-12, 0.0, &mut b);
        // x has no component in the null space.
        for v in eigen.vectors.chunks_exact(8).take(5) {
            assert!(dot(v, &b).abs() < 1e-9);
        }
        assert!(Eigen::of(&[f64::NAN], 1).is_none() && !cholesky(&mut [f64::NAN], 1, 0.0));
    }

    /// Rotations of the smallest numbers that there are vanish within a sweep.
    #[test]
    fn the_smallest_numbers_have_the_eigenvalues_of_whole_ones() {
        let unit = f64::from_bits(1);
        for ([a, b, c], [d, e]) in [
            ([-2.0, -2.0, 3.0], [-2.0, -4.0]),
            ([1.0, 2.0, 4.0], [-2.0, -3.0]),
            ([5.0, -4.0, -2.0], [-1.0, -4.0]),
            ([1.0, 2.0, -2.0], [-5.0, 2.0]),
        ] {
            let whole = [a, d, 0.0, d, b, e, 0.0, e, c];
            let expected = Eigen::of(&whole, 3).unwrap().values;
            let found = Eigen::of(&whole.map(|v| v * unit), 3).unwrap().values;
            // Every number is rounded to a unit.
            let near = found.iter().zip(&expected).all(|(found, v)| (found / unit - v).abs() <= 2.0);
            assert!(near, "{found:?} for {expected:?} units");
        }
    }
}
