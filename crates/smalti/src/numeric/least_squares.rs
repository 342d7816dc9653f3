//! Linear least squares by the singular value decomposition: the solution of minimum norm, whatever the rank.

use faer::{Mat, MatRef};
use thiserror::Error;

/// A least-squares problem that cannot be solved.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LeastSquaresError {
    /// A matrix has another number of values than its shape asks for.
    #[error("{matrix} is {rows} × {cols} and needs {expected} values, got {got}")]
    Shape {
        /// Which matrix.
        matrix: &'static str,
        /// Its rows.
        rows: usize,
        /// Its columns.
        cols: usize,
        /// Values the shape asks for (saturated where it overflows).
        expected: usize,
        /// Values that came.
        got: usize,
    },
    /// A matrix holds NaN or infinity.
    #[error("{matrix} holds a value that is not finite")]
    NotFinite {
        /// Which matrix.
        matrix: &'static str,
    },
    /// The singular value decomposition did not converge.
    #[error("the singular value decomposition of a {rows} × {cols} matrix did not converge")]
    NoConvergence {
        /// Its rows.
        rows: usize,
        /// Its columns.
        cols: usize,
    },
}

/// A matrix in row order, lent to a solver.
#[derive(Debug, Clone, Copy)]
pub struct Matrix<'a> {
    rows: usize,
    cols: usize,
    values: &'a [f64],
}

impl<'a> Matrix<'a> {
    /// `rows` × `cols` values in row order.
    #[must_use]
    pub fn new(rows: usize, cols: usize, values: &'a [f64]) -> Self {
        Self { rows, cols, values }
    }

    fn checked(self, matrix: &'static str, rows: usize) -> Result<MatRef<'a, f64>, LeastSquaresError> {
        let expected = rows.saturating_mul(self.cols);
        if self.rows != rows || self.values.len() != expected {
            let got = self.values.len();
            return Err(LeastSquaresError::Shape { matrix, rows, cols: self.cols, expected, got });
        }
        if self.values.iter().any(|v| !v.is_finite()) {
            return Err(LeastSquaresError::NotFinite { matrix });
        }
        Ok(MatRef::from_row_major_slice(self.values, rows, self.cols))
    }
}

/// `x` (`a.cols` × `b.cols`, row order) with the smallest ‖A X − B‖, and among those with the smallest ‖X‖.
///
/// Singular values below the largest times machine precision times the longer side count as zero: a matrix of
/// lower rank than columns (more channels than samples, or channels that are mixtures of others) is no error.
///
/// # Errors
/// When shapes and values do not match, or a value is not finite.
pub fn lstsq(a: Matrix<'_>, b: Matrix<'_>) -> Result<Vec<f64>, LeastSquaresError> {
    let (a, b) = (a.checked("A", a.rows)?, b.checked("B", a.rows)?);
    Ok(row_major(pseudo_inverse(a, 0.0)? * b))
}

/// As [`lstsq`], under the exact condition C X = D.
///
/// Where the conditions contradict each other, they are met in the least-squares sense and come before A X = B.
///
/// # Errors
/// As [`lstsq`].
pub fn lstsq_constrained(
    a: Matrix<'_>,
    b: Matrix<'_>,
    c: Matrix<'_>,
    d: Matrix<'_>,
) -> Result<Vec<f64>, LeastSquaresError> {
    let unknowns = a.cols;
    if c.cols != unknowns {
        let expected = c.rows.saturating_mul(unknowns);
        return Err(LeastSquaresError::Shape {
            matrix: "C",
            rows: c.rows,
            cols: unknowns,
            expected,
            got: c.values.len(),
        });
    }
    if d.cols != b.cols {
        let expected = d.rows.saturating_mul(b.cols);
        return Err(LeastSquaresError::Shape {
            matrix: "D",
            rows: d.rows,
            cols: b.cols,
            expected,
            got: d.values.len(),
        });
    }
    let (a, b) = (a.checked("A", a.rows)?, b.checked("B", a.rows)?);
    let (c, d) = (c.checked("C", c.rows)?, d.checked("D", c.rows)?);
    let c_inverse = pseudo_inverse(c, 0.0)?;
    let fixed = &c_inverse * d;
    // What the conditions leave free is the null space of C; A restricted to it decides the rest. Rounding in the
    // projection leaves singular values near machine precision where there are none, so the cut is relative to A.
    let free = Mat::<f64>::identity(unknowns, unknowns) - &c_inverse * c;
    let residual = b - a * &fixed;
    let x = fixed + pseudo_inverse((a * free).as_ref(), a.norm_l2())? * residual;
    // Where A is badly conditioned X is large, and its rounding breaks the condition; one correction mends that.
    let miss = d - c * &x;
    let x = x + c_inverse * miss;
    Ok(row_major(x))
}

/// The Moore-Penrose inverse. Singular values below `max(largest, scale)` times precision times size are zero.
fn pseudo_inverse(a: MatRef<'_, f64>, scale: f64) -> Result<Mat<f64>, LeastSquaresError> {
    let (rows, cols) = a.shape();
    if rows == 0 || cols == 0 {
        return Ok(Mat::zeros(cols, rows));
    }
    let svd = a.thin_svd().map_err(|_| LeastSquaresError::NoConvergence { rows, cols })?;
    let sigma: Vec<f64> = svd.S().column_vector().iter().copied().collect();
    let largest = sigma.iter().copied().fold(scale, f64::max);
    let cut = largest * f64::EPSILON * rows.max(cols) as f64;
    let (u, v) = (svd.U(), svd.V());
    let scaled =
        Mat::from_fn(cols, sigma.len(), |i, j| if sigma[j] > cut { v[(i, j)] / sigma[j] } else { 0.0 });
    Ok(scaled * u.transpose())
}

fn row_major(x: Mat<f64>) -> Vec<f64> {
    (0..x.nrows()).flat_map(|i| (0..x.ncols()).map(move |j| (i, j))).map(|at| x[at]).collect()
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
        assert!(matches!(
            lstsq(m(1, 1, &[f64::NAN]), m(1, 1, one)),
            Err(LeastSquaresError::NotFinite { matrix: "A" })
        ));
        assert!(matches!(
            lstsq_constrained(m(1, 1, one), m(1, 1, one), m(1, 2, &[1.0, 1.0]), m(1, 1, one)),
            Err(LeastSquaresError::Shape { matrix: "C", .. })
        ));
        assert!(lstsq(m(0, 2, &[]), m(0, 1, &[])).unwrap().iter().all(|&x| x == 0.0));
        assert!(lstsq(m(usize::MAX, 2, one), m(usize::MAX, 1, one)).is_err());
    }
}
