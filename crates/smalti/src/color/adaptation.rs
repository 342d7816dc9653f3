//! Chromatic adaptation: the change of tristimulus values with the white point.

use super::matrix::{Matrix3, apply, diagonal, inverse, product};

/// Cone-like responses from XYZ: Bradford, linear part (Lam 1985; ICC.1:2022 annex E).
const CONE_FROM_XYZ: Matrix3 =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// The matrix that carries XYZ seen under `white_from` to XYZ that looks the same under `white_to`, with a gain per cone-like
/// response; it maps one white onto the other. The scales of the whites count. `None` unless both whites have finite responses
/// above 0.
#[must_use]
pub fn bradford(white_to: [f64; 3], white_from: [f64; 3]) -> Option<Matrix3> {
    let (to, from) = (apply(&CONE_FROM_XYZ, white_to), apply(&CONE_FROM_XYZ, white_from));
    if !to.iter().chain(&from).all(|v| v.is_finite() && *v > 0.0) {
        return None;
    }
    let gain = diagonal([to[0] / from[0], to[1] / from[1], to[2] / from[2]]);
    let m = product(&inverse(&CONE_FROM_XYZ)?, &product(&gain, &CONE_FROM_XYZ));
    m.as_flattened().iter().all(|v| v.is_finite()).then_some(m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::cie1976::xyz_from_xy;

    fn whites() -> ([f64; 3], [f64; 3]) {
        (xyz_from_xy([0.3127, 0.3290], 1.0).unwrap(), xyz_from_xy([0.44758, 0.40745], 1.0).unwrap())
    }

    #[test]
    fn maps_white_onto_white_and_back() {
        let (d65, a) = whites();
        let there = bradford(d65, a).unwrap();
        let got = apply(&there, a);
        assert!(got.iter().zip(d65).all(|(g, w)| (g - w).abs() < 1e-12));
        let same = product(&bradford(a, d65).unwrap(), &there);
        for (g, w) in same.as_flattened().iter().zip(crate::color::matrix::IDENTITY.as_flattened()) {
            assert!((g - w).abs() < 1e-12);
        }
        assert_eq!(bradford(d65, [0.0; 3]), None);
        assert_eq!(bradford(d65, [f64::NAN; 3]), None);
        // So blue that its long-wavelength or its luminance response is negative.
        assert_eq!(bradford([-0.2, 0.1, 20.0], d65), None);
        assert_eq!(bradford(d65, [0.1, -0.1, 20.0]), None);
    }

    /// Expected: colour-science 0.4.7, `matrix_chromatic_adaptation_VonKries` from A to D65, ten digits.
    #[test]
    fn agrees_with_colour_science() {
        let (d65, a) = whites();
        let expected: Matrix3 = [
            [0.844668978, -0.1179500901, 0.3950133855],
            [-0.1366496579, 1.1041266253, 0.1292354308],
            [0.0798936922, -0.1349778597, 3.1935882646],
        ];
        let got = bradford(d65, a).unwrap();
        for (g, w) in got.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((g - w).abs() < 1e-9, "{g} is not {w}");
        }
    }
}
