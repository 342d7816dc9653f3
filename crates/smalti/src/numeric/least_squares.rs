//! Linear least squares by singular value decomposition: the minimum-norm solution for a matrix of any rank.
//!
//! The decomposition is the one-sided Jacobi method ([hestenes1958]): rotations make the columns orthogonal, and their lengths are
//! the singular values. Sums have one order, so that every machine gives the same bits.
//!
//! [hestenes1958]: https://doi.org/10.1137/0106005

use thiserror::Error;

/// Errors of a least-squares problem.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LeastSquaresError {
    /// The number of values does not match the shape of a matrix.
    #[error("{matrix} is {rows} × {cols} and needs {expected} values, got {got}")]
    Shape {
        /// Which matrix.
        matrix: &'static str,
        /// Its rows.
        rows: usize,
        /// Its columns.
        cols: usize,
        /// Values that the shape requires (saturated where it overflows).
        expected: usize,
        /// Values that were given.
        got: usize,
    },
    /// This matrix holds NaN or infinity.
    #[error("{0} holds a value that is not finite")]
    NotFinite(&'static str),
    /// The singular value decomposition did not converge.
    #[error("the singular value decomposition of a {rows} × {cols} matrix did not converge")]
    NoConvergence {
        /// Its rows.
        rows: usize,
        /// Its columns.
        cols: usize,
    },
}

/// A borrowed row-major matrix.
#[derive(Debug, Clone, Copy)]
pub struct Matrix<'a> {
    rows: usize,
    cols: usize,
    values: &'a [f64],
}

impl<'a> Matrix<'a> {
    /// A matrix of `rows` × `cols` values in row order.
    #[must_use]
    pub fn new(rows: usize, cols: usize, values: &'a [f64]) -> Self {
        Self { rows, cols, values }
    }

    fn checked(self, matrix: &'static str, rows: usize, cols: usize) -> Result<Dense, LeastSquaresError> {
        let (expected, got) = (rows.saturating_mul(cols), self.values.len());
        if (self.rows, self.cols, got) != (rows, cols, expected) {
            return Err(LeastSquaresError::Shape { matrix, rows, cols, expected, got });
        }
        if self.values.iter().any(|v| !v.is_finite()) {
            return Err(LeastSquaresError::NotFinite(matrix));
        }
        Ok(Dense { rows, cols, values: self.values.to_vec() })
    }
}

/// The `x` (`a.cols` × `b.cols`, row-major) that minimises ‖A X − B‖; of several, the one with the smallest
/// ‖X‖.
///
/// Singular values below the largest times machine precision times the longer side count as zero. A
/// rank-deficient matrix (more channels than samples, or channels that are mixtures of others) is therefore
/// not an error.
///
/// # Errors
/// When shapes and values do not match, or a value is not finite.
pub fn lstsq(a: Matrix<'_>, b: Matrix<'_>) -> Result<Vec<f64>, LeastSquaresError> {
    let (a, b) = (a.checked("A", a.rows, a.cols)?, b.checked("B", a.rows, b.cols)?);
    Ok(pseudo_inverse(&a, 0.0)?.times(&b).values)
}

/// Like [`lstsq`], subject to the exact condition C X = D.
///
/// Contradictory conditions are met in the least-squares sense; they take precedence over A X = B.
///
/// # Errors
/// As [`lstsq`].
pub fn lstsq_constrained(
    a: Matrix<'_>,
    b: Matrix<'_>,
    c: Matrix<'_>,
    d: Matrix<'_>,
) -> Result<Vec<f64>, LeastSquaresError> {
    let (unknowns, columns) = (a.cols, b.cols);
    let (a, b) = (a.checked("A", a.rows, unknowns)?, b.checked("B", a.rows, columns)?);
    let (c, d) = (c.checked("C", c.rows, unknowns)?, d.checked("D", c.rows, columns)?);
    let c_inverse = pseudo_inverse(&c, 0.0)?;
    let fixed = c_inverse.times(&d);
    // The conditions leave the null space of C free, where A decides. Rounding in the projection leaves
    // singular values near machine precision instead of zero, so the cut-off is relative to A.
    let free = Dense::identity(unknowns).plus(-1.0, &c_inverse.times(&c));
    let residual = b.plus(-1.0, &a.times(&fixed));
    let norm = dot(&a.values, &a.values).sqrt();
    let x = fixed.plus(1.0, &pseudo_inverse(&a.times(&free), norm)?.times(&residual));
    // Where A is badly conditioned, X is large and its rounding violates the condition. One correction step
    // restores it.
    let miss = d.plus(-1.0, &c.times(&x));
    Ok(x.plus(1.0, &c_inverse.times(&miss)).values)
}

/// A matrix in row order.
#[derive(Debug, Clone)]
struct Dense {
    rows: usize,
    cols: usize,
    values: Vec<f64>,
}

impl Dense {
    fn zeros(rows: usize, cols: usize) -> Self {
        Self { rows, cols, values: vec![0.0; rows * cols] }
    }

    fn identity(size: usize) -> Self {
        let mut eye = Self::zeros(size, size);
        eye.values.iter_mut().step_by(size + 1).for_each(|v| *v = 1.0);
        eye
    }

    fn transposed(&self) -> Self {
        let values = (0..self.cols).flat_map(|c| self.values.iter().skip(c).step_by(self.cols).copied());
        Self { rows: self.cols, cols: self.rows, values: values.collect() }
    }

    fn times(&self, right: &Self) -> Self {
        let mut out = Self::zeros(self.rows, right.cols);
        if right.cols > 0 && self.cols > 0 {
            let rows = self.values.chunks_exact(self.cols).zip(out.values.chunks_exact_mut(right.cols));
            for (row, out) in rows {
                for (&factor, line) in row.iter().zip(right.values.chunks_exact(right.cols)) {
                    out.iter_mut().zip(line).for_each(|(o, v)| *o += factor * v);
                }
            }
        }
        out
    }

    fn plus(mut self, factor: f64, other: &Self) -> Self {
        self.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a += factor * b);
        self
    }
}

/// Sweeps of rotations after which the method has failed; six are usual.
const MAX_SWEEPS: usize = 60;
/// Parts of a sum that are added side by side, so that it becomes vector code.
const LANES: usize = 8;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        (0..LANES).for_each(|l| sums[l] += a[l] * b[l]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// The Moore-Penrose inverse. Singular values below `max(largest, scale)` times precision times size are zero.
fn pseudo_inverse(a: &Dense, scale: f64) -> Result<Dense, LeastSquaresError> {
    let (rows, cols) = (a.rows, a.cols);
    if rows == 0 || cols == 0 {
        return Ok(Dense::zeros(cols, rows));
    }
    if rows < cols {
        return Ok(pseudo_inverse(&a.transposed(), scale)?.transposed());
    }
    // Columns of A V as rows, and Vᵀ beside them.
    let (mut columns, mut v) = (a.transposed(), Dense::identity(cols));
    // Far from overflow and underflow; the inverse is scaled back.
    let unit = columns.values.iter().fold(0.0f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE);
    columns.values.iter_mut().for_each(|x| *x /= unit);
    let turned = |m: &mut Dense, [p, q]: [usize; 2], [cosine, sine]: [f64; 2]| {
        let (before, after) = m.values.split_at_mut(q * m.cols);
        for (x, y) in before[p * m.cols..(p + 1) * m.cols].iter_mut().zip(&mut after[..m.cols]) {
            (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
        }
    };
    let mut sweeps = 0;
    loop {
        let mut still = true;
        for p in 0..cols {
            for q in p + 1..cols {
                let (x, y) =
                    (&columns.values[p * rows..(p + 1) * rows], &columns.values[q * rows..(q + 1) * rows]);
                let (xx, yy, xy) = (dot(x, x), dot(y, y), dot(x, y));
                // Columns shorter than rounding of the longest teach nothing.
                if xy.abs() <= f64::EPSILON * (xx * yy).sqrt().max(f64::EPSILON) {
                    continue;
                }
                still = false;
                let half = (yy - xx) / (2.0 * xy);
                let tangent = 1.0 / (half.abs() + libm::hypot(half, 1.0)).copysign(half);
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                let rotation = [cosine, cosine * tangent];
                turned(&mut columns, [p, q], rotation);
                turned(&mut v, [p, q], rotation);
            }
        }
        if still {
            break;
        }
        sweeps += 1;
        if sweeps == MAX_SWEEPS {
            return Err(LeastSquaresError::NoConvergence { rows, cols });
        }
    }
    let squares: Vec<f64> = columns.values.chunks_exact(rows).map(|c| dot(c, c)).collect();
    let largest = squares.iter().fold(0.0f64, |m, s| m.max(s.sqrt())).max(scale / unit);
    let cut = largest * f64::EPSILON * rows.max(cols) as f64;
    let mut inverse = Dense::zeros(cols, rows);
    for ((column, square), v) in
        columns.values.chunks_exact(rows).zip(squares).zip(v.values.chunks_exact(cols))
    {
        if square.sqrt() > cut {
            for (line, v) in inverse.values.chunks_exact_mut(rows).zip(v) {
                let factor = v / square / unit;
                line.iter_mut().zip(column).for_each(|(o, c)| *o += factor * c);
            }
        }
    }
    Ok(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_line_through_points() {
        // y = 1 + 2 t with residuals orthogonal to both columns.
        let a = [1.0, 0.0, 1.0, 1.0, 1.0, 2.0, 1.0, 3.0];
        let b = [1.0 + 0.5, 3.0 - 1.5, 5.0 + 1.5, 7.0 - 0.5];
        let x = lstsq(Matrix::new(4, 2, &a), Matrix::new(4, 1, &b)).unwrap();
        assert_abs_diff_eq!(x[0], 1.0, epsilon = 1e-12);
        assert_abs_diff_eq!(x[1], 2.0, epsilon = 1e-12);
    }

    #[test]
    fn the_smallest_solution_where_many_fit() {
        let x = lstsq(Matrix::new(1, 2, &[3.0, 4.0]), Matrix::new(1, 1, &[25.0])).unwrap();
        assert_abs_diff_eq!(x[0], 3.0, epsilon = 1e-12);
        assert_abs_diff_eq!(x[1], 4.0, epsilon = 1e-12);
        let twice = [1.0, 1.0, 2.0, 2.0, -1.0, -1.0];
        let x = lstsq(Matrix::new(3, 2, &twice), Matrix::new(3, 1, &[2.0, 4.0, -2.0])).unwrap();
        assert_abs_diff_eq!(x[0], x[1], epsilon = 1e-12);
        assert_abs_diff_eq!(x[0], 1.0, epsilon = 1e-12);
    }

    #[test]
    fn a_condition_holds_exactly_and_the_rest_is_optimal() {
        let a = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let b = [1.0, 2.0, 3.0];
        let ones = [1.0, 1.0, 1.0];
        let x = lstsq_constrained(
            Matrix::new(3, 3, &a),
            Matrix::new(3, 1, &b),
            Matrix::new(1, 3, &ones),
            Matrix::new(1, 1, &[0.0]),
        )
        .unwrap();
        // Projection of (1, 2, 3) on the plane through the origin normal to (1, 1, 1).
        for (x, e) in x.iter().zip([-1.0, 0.0, 1.0]) {
            assert_abs_diff_eq!(*x, e, epsilon = 1e-12);
        }
    }

    #[test]
    fn conditions_that_fix_everything_leave_nothing_to_fit() {
        let eye = [1.0, 0.0, 0.0, 1.0];
        let x = lstsq_constrained(
            Matrix::new(2, 2, &[5.0, 1.0, 2.0, 7.0]),
            Matrix::new(2, 1, &[1.0, 1.0]),
            Matrix::new(2, 2, &eye),
            Matrix::new(2, 1, &[3.0, 4.0]),
        )
        .unwrap();
        assert_abs_diff_eq!(x[0], 3.0, epsilon = 1e-12);
        assert_abs_diff_eq!(x[1], 4.0, epsilon = 1e-12);
    }

    #[test]
    fn bad_shapes_and_values_are_named() {
        let m = |rows, cols, v| Matrix::new(rows, cols, v);
        let one = &[1.0][..];
        assert!(matches!(
            lstsq(m(2, 1, one), m(1, 1, one)),
            Err(LeastSquaresError::Shape { matrix: "A", .. })
        ));
        assert!(matches!(
            lstsq(m(1, 1, one), m(2, 1, &[1.0, 1.0])),
            Err(LeastSquaresError::Shape { matrix: "B", .. })
        ));
        assert!(matches!(lstsq(m(1, 1, &[f64::NAN]), m(1, 1, one)), Err(LeastSquaresError::NotFinite("A"))));
        assert!(matches!(
            lstsq_constrained(m(1, 1, one), m(1, 1, one), m(1, 2, &[1.0, 1.0]), m(1, 1, one)),
            Err(LeastSquaresError::Shape { matrix: "C", .. })
        ));
        assert!(lstsq(m(0, 2, &[]), m(0, 1, &[])).unwrap().iter().all(|&x| x == 0.0));
        assert!(lstsq(m(usize::MAX, 2, one), m(usize::MAX, 1, one)).is_err());
    }
    #[test]
    fn no_columns_have_no_solution() {
        let (a, none) = ([1.0, 2.0, 3.0, 5.0], []);
        let empty = |rows| Matrix::new(rows, 0, &none);
        assert_eq!(lstsq(Matrix::new(2, 2, &a), empty(2)), Ok(Vec::new()));
        assert_eq!(lstsq(empty(4), Matrix::new(4, 1, &a)), Ok(Vec::new()));
        let condition = Matrix::new(1, 2, &a[..2]);
        assert_eq!(lstsq_constrained(Matrix::new(2, 2, &a), empty(2), condition, empty(1)), Ok(Vec::new()));
    }
}
