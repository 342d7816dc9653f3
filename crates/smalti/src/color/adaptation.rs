//! Chromatic adaptation: the change of tristimulus values with the white point.

use super::matrix::{Matrix3, apply, diagonal, inverse, product};

/// The space in which chromatic adaptation is a gain per channel (von Kries).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Adaptation {
    /// Bradford, linear part (Lam 1985; ICC.1:2022 annex E).
    #[default]
    Bradford,
    /// CAT16 (Li et al. 2017), full adaptation.
    Cat16,
    /// Cones of Hunt, Pointer and Estévez, normalised to D65.
    VonKries,
    /// X, Y, Z themselves ("wrong von Kries").
    XyzScaling,
}

impl Adaptation {
    /// Cone-like responses from XYZ.
    #[must_use]
    pub fn cone_from_xyz(self) -> Matrix3 {
        match self {
            Self::Bradford => {
                [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
            }
            Self::Cat16 => [
                [0.401288, 0.650173, -0.051461],
                [-0.250268, 1.204414, 0.045854],
                [-0.002079, 0.048952, 0.953127],
            ],
            Self::VonKries => [[0.40024, 0.7076, -0.08081], [-0.2263, 1.16532, 0.0457], [0.0, 0.0, 0.91822]],
            Self::XyzScaling => super::matrix::IDENTITY,
        }
    }

    /// The matrix that carries XYZ seen under `white_from` to XYZ that looks the same under `white_to`; it maps one
    /// white onto the other. The scales of the whites count. `None` unless both whites have finite cone responses above 0.
    #[must_use]
    pub fn matrix(self, white_to: [f64; 3], white_from: [f64; 3]) -> Option<Matrix3> {
        let cone_from_xyz = self.cone_from_xyz();
        let (to, from) = (apply(&cone_from_xyz, white_to), apply(&cone_from_xyz, white_from));
        if !to.iter().chain(&from).all(|v| v.is_finite() && *v > 0.0) {
            return None;
        }
        let gain = diagonal([to[0] / from[0], to[1] / from[1], to[2] / from[2]]);
        let m = product(&inverse(&cone_from_xyz)?, &product(&gain, &cone_from_xyz));
        m.as_flattened().iter().all(|v| v.is_finite()).then_some(m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::cie1976::xyz_from_xy;

    const ALL: [Adaptation; 4] =
        [Adaptation::Bradford, Adaptation::Cat16, Adaptation::VonKries, Adaptation::XyzScaling];

    fn whites() -> ([f64; 3], [f64; 3]) {
        (xyz_from_xy([0.3127, 0.3290], 1.0).unwrap(), xyz_from_xy([0.44758, 0.40745], 1.0).unwrap())
    }

    #[test]
    fn maps_white_onto_white_and_back() {
        let (d65, a) = whites();
        for method in ALL {
            let there = method.matrix(d65, a).unwrap();
            let got = apply(&there, a);
            assert!(got.iter().zip(d65).all(|(g, w)| (g - w).abs() < 1e-12), "{method:?}");
            let back = method.matrix(a, d65).unwrap();
            let same = product(&back, &there);
            for (g, w) in same.as_flattened().iter().zip(crate::color::matrix::IDENTITY.as_flattened()) {
                assert!((g - w).abs() < 1e-12, "{method:?}");
            }
            assert_eq!(method.matrix(d65, [0.0; 3]), None);
            assert_eq!(method.matrix(d65, [f64::NAN; 3]), None);
            // So blue that its long-wavelength or its luminance response is negative.
            assert_eq!(method.matrix([-0.2, 0.1, 20.0], d65), None);
            assert_eq!(method.matrix(d65, [0.1, -0.1, 20.0]), None);
        }
    }

    /// Expected: colour-science 0.4.7, `matrix_chromatic_adaptation_VonKries` from A to D65, ten digits.
    #[test]
    fn agrees_with_colour_science() {
        let (d65, a) = whites();
        let expected = [
            (
                Adaptation::Bradford,
                [
                    [0.844668978, -0.1179500901, 0.3950133855],
                    [-0.1366496579, 1.1041266253, 0.1292354308],
                    [0.0798936922, -0.1349778597, 3.1935882646],
                ],
            ),
            (
                Adaptation::Cat16,
                [
                    [0.95068146421, -0.18740609972, 0.26292248778],
                    [-0.025669886638, 1.0323135659, -0.011566769476],
                    [-0.0027424281439, 0.091014391099, 2.8135491680],
                ],
            ),
            (
                Adaptation::VonKries,
                [
                    [0.9394862435, -0.2339632603, 0.4283392774],
                    [-0.0256992047, 1.0263883201, 0.0051771333],
                    [0.0, 0.0, 3.0608855663],
                ],
            ),
        ];
        for (method, matrix) in expected {
            let got = method.matrix(d65, a).unwrap();
            for (g, w) in got.as_flattened().iter().zip(matrix.as_flattened()) {
                assert!((g - w).abs() < 1e-9, "{method:?}: {g} is not {w}");
            }
        }
    }
}
