//! 3 × 3 row-major matrices, named target first: `xyz_from_rgb` applied to rgb gives xyz.

/// Rows of a 3 × 3 matrix.
pub type Matrix3 = [[f64; 3]; 3];

/// The identity.
pub const IDENTITY: Matrix3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A diagonal matrix.
#[must_use]
pub const fn diagonal(d: [f64; 3]) -> Matrix3 {
    [[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]]
}

/// The matrix-vector product.
#[must_use]
pub const fn apply(m: &Matrix3, v: [f64; 3]) -> [f64; 3] {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

const fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Rows and columns exchanged.
const fn transposed(m: &Matrix3) -> Matrix3 {
    let [a, b, c] = *m;
    [[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]]
}

/// The product `a b`: it applies `b` first, then `a`.
#[must_use]
pub const fn product(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    let columns = transposed(b);
    [apply(&columns, a[0]), apply(&columns, a[1]), apply(&columns, a[2])]
}

/// The inverse; `None` when the matrix is singular or not finite.
#[must_use]
pub const fn inverse(m: &Matrix3) -> Option<Matrix3> {
    let cofactors = [
        [cofactor(m, 0, 0), cofactor(m, 0, 1), cofactor(m, 0, 2)],
        [cofactor(m, 1, 0), cofactor(m, 1, 1), cofactor(m, 1, 2)],
        [cofactor(m, 2, 0), cofactor(m, 2, 1), cofactor(m, 2, 2)],
    ];
    let determinant = dot(m[0], cofactors[0]);
    let mut inverse = transposed(&cofactors);
    let mut i = 0;
    while i < 9 {
        inverse[i / 3][i % 3] /= determinant;
        if !inverse[i / 3][i % 3].is_finite() {
            return None;
        }
        i += 1;
    }
    Some(inverse)
}

const fn cofactor(m: &Matrix3, r: usize, c: usize) -> f64 {
    let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
    m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
}

/// The matrix of a constant. A singular matrix is a compile-time error.
pub(super) const fn known(m: Option<Matrix3>) -> Matrix3 {
    assert!(m.is_some(), "the matrix of a constant is singular");
    match m {
        Some(m) => m,
        None => IDENTITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_times_matrix_is_identity() {
        let m = [[2.0, 1.0, 0.5], [-1.0, 3.0, 0.0], [0.25, 0.0, 1.0]];
        let p = product(&inverse(&m).unwrap(), &m);
        for (got, want) in p.as_flattened().iter().zip(IDENTITY.as_flattened()) {
            assert!((got - want).abs() < 1e-14);
        }
        assert_eq!(inverse(&[[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0]]), None);
    }
}
