//! Orthonormal bases by the Gram–Schmidt process with pivoting ([golub2013], section 5.2.7).
//!
//! [golub2013]: https://doi.org/10.56021/9781421407944

/// A vector whose distance from the space of the others is below this share of its length lies in that space.
const DEPENDENT: f64 = 1e-9;

/// Orthonormal vectors that span the same space as the given ones, which have equal lengths. Vectors that are sums of
/// others to nine digits add none.
pub(crate) fn orthonormal_basis(vectors: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut rest: Vec<(f64, Vec<f64>)> = vectors
        .iter()
        .map(|v| (dot(v, v).sqrt(), v.clone()))
        .filter(|(length, _)| *length > 0.0)
        .map(|(length, v)| (1.0, v.iter().map(|x| x / length).collect()))
        .collect();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    // The vector farthest from the space so far comes next, so that nearly dependent ones come last.
    while let Some(next) = (0..rest.len()).max_by(|&a, &b| rest[a].0.total_cmp(&rest[b].0)) {
        let (_, mut v) = rest.swap_remove(next);
        // Twice, because the first pass leaves rounding errors that are large beside a short remainder.
        for known in basis.iter().chain(&basis) {
            let along = dot(known, &v);
            v.iter_mut().zip(known).for_each(|(x, k)| *x -= along * k);
        }
        let length = dot(&v, &v).sqrt();
        if length <= DEPENDENT {
            break;
        }
        v.iter_mut().for_each(|x| *x /= length);
        for (left, other) in &mut rest {
            *left = (*left - dot(&v, other).powi(2)).max(0.0);
        }
        basis.push(v);
    }
    basis
}

/// The scalar product.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_is_orthonormal_and_spans_the_vectors() {
        let vectors = vec![vec![3.0, 0.0, 4.0, 0.0], vec![1.0, 1.0, 1.0, 0.0], vec![0.0, 2.0, 0.0, 1e-6]];
        let basis = orthonormal_basis(&vectors);
        assert_eq!(basis.len(), 3);
        for (i, a) in basis.iter().enumerate() {
            for (j, b) in basis.iter().enumerate() {
                assert!((dot(a, b) - f64::from(u8::from(i == j))).abs() < 1e-14, "{i} {j}");
            }
        }
        for v in &vectors {
            let projected: f64 = basis.iter().map(|b| dot(b, v).powi(2)).sum();
            assert!((projected - dot(v, v)).abs() < 1e-13);
        }
    }

    #[test]
    fn sums_of_others_add_nothing() {
        let (a, b) = (vec![1.0, 2.0, 3.0], vec![0.0, 1.0, 1.0]);
        let sum = a.iter().zip(&b).map(|(a, b)| 0.3 * a + 7.0 * b).collect();
        assert_eq!(orthonormal_basis(&[a, sum, b, vec![0.0; 3]]).len(), 2);
        assert!(orthonormal_basis(&[]).is_empty());
    }
}
