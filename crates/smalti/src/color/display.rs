//! Display colour spaces: matrices derived from primaries and white, and the sRGB transfer function.

use super::cie1976::xyz_from_xy;
use super::matrix::{Matrix3, apply, diagonal, inverse, known, product};

/// Chromaticities (x, y) of the primaries of an additive display and of its white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primaries {
    /// Red.
    pub red: [f64; 2],
    /// Green.
    pub green: [f64; 2],
    /// Blue.
    pub blue: [f64; 2],
    /// White: R = G = B = 1.
    pub white: [f64; 2],
}

/// D65 as rounded in display standards (IEC 61966-2-1, ITU-R BT.709).
pub const D65_XY: [f64; 2] = [0.3127, 0.3290];

/// X, Y, Z of that white, Y = 1.
pub(crate) const D65_XYZ: [f64; 3] = match xyz_from_xy(D65_XY, 1.0) {
    Some(white) => white,
    None => [0.0; 3],
};
const _: () = assert!(D65_XYZ[1] == 1.0);

impl Primaries {
    /// sRGB (IEC 61966-2-1), with the primaries of ITU-R BT.709.
    pub const SRGB: Self = Self { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: D65_XY };
    /// Display P3: the primaries of SMPTE EG 432-1 with D65 white.
    pub const DISPLAY_P3: Self =
        Self { red: [0.680, 0.320], green: [0.265, 0.690], blue: [0.150, 0.060], white: D65_XY };
    /// ITU-R BT.2020 with D65 white. Its primaries are spectral colours.
    pub const BT2020: Self =
        Self { red: [0.708, 0.292], green: [0.170, 0.797], blue: [0.131, 0.046], white: D65_XY };
    /// ROMM RGB (ISO 22028-2), with the white D50.
    pub const ROMM: Self = Self {
        red: [0.7347, 0.2653],
        green: [0.1596, 0.8404],
        blue: [0.0366, 0.0001],
        white: [0.3457, 0.3585],
    };

    /// X, Y, Z of the white at Y = 1; `None` when its y is zero.
    #[must_use]
    pub const fn white_xyz(&self) -> Option<[f64; 3]> {
        xyz_from_xy(self.white, 1.0)
    }

    /// The matrix to XYZ (white at Y = 1) from linear RGB; `None` when the primaries are collinear or have no
    /// luminance.
    #[must_use]
    pub const fn xyz_from_rgb(&self) -> Option<Matrix3> {
        let (Some(r), Some(g), Some(b), Some(white)) = (
            xyz_from_xy(self.red, 1.0),
            xyz_from_xy(self.green, 1.0),
            xyz_from_xy(self.blue, 1.0),
            self.white_xyz(),
        ) else {
            return None;
        };
        let columns = [[r[0], g[0], b[0]], [r[1], g[1], b[1]], [r[2], g[2], b[2]]];
        match inverse(&columns) {
            Some(inverse) => Some(product(&columns, &diagonal(apply(&inverse, white)))),
            None => None,
        }
    }

    /// The matrix to linear RGB from XYZ (white at Y = 1); `None` under the conditions of
    /// [`Primaries::xyz_from_rgb`].
    #[must_use]
    pub const fn rgb_from_xyz(&self) -> Option<Matrix3> {
        match self.xyz_from_rgb() {
            Some(m) => inverse(&m),
            None => None,
        }
    }
}

/// XYZ from linear RGB and its inverse, white at Y = 1, for the built-in spaces.
#[derive(PartialEq)]
pub(crate) struct Matrices {
    pub(crate) xyz_from_rgb: Matrix3,
    pub(crate) rgb_from_xyz: Matrix3,
}

impl Matrices {
    pub(crate) const SRGB: Self = Self::of(&Primaries::SRGB);
    pub(crate) const DISPLAY_P3: Self = Self::of(&Primaries::DISPLAY_P3);
    pub(crate) const BT2020: Self = Self::of(&Primaries::BT2020);

    const fn of(primaries: &Primaries) -> Self {
        Self { xyz_from_rgb: known(primaries.xyz_from_rgb()), rgb_from_xyz: known(primaries.rgb_from_xyz()) }
    }
}

/// Linear value at which the linear segment of the sRGB curve meets the power segment.
pub(super) const LINEAR_KNEE: f64 = 0.0031308;
/// The encoded value at that point.
pub(super) const ENCODED_KNEE: f64 = 0.04045;

/// Encodes linear light, clipped to 0–1, with the curve of IEC 61966-2-1. NaN stays NaN.
#[must_use]
pub fn encode_srgb(linear: f64) -> f64 {
    let v = linear.clamp(0.0, 1.0);
    if v <= LINEAR_KNEE { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 }
}

/// Decodes a value, clipped to 0–1, to linear light with the curve of IEC 61966-2-1. NaN stays NaN.
#[must_use]
pub fn decode_srgb(encoded: f64) -> f64 {
    let v = encoded.clamp(0.0, 1.0);
    if v <= ENCODED_KNEE { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_one_one_one() {
        for p in [Primaries::SRGB, Primaries::DISPLAY_P3] {
            let rgb = apply(&p.rgb_from_xyz().unwrap(), p.white_xyz().unwrap());
            assert!(rgb.iter().all(|v| (v - 1.0).abs() < 1e-12), "{rgb:?}");
        }
    }

    /// IEC 61966-2-1 prints its matrix with four decimals. The matrix of Display P3 is from colour-science
    /// 0.4.7.
    #[test]
    fn matrices_are_the_published_ones() {
        let srgb = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
        let p3 = [
            [0.48657094865, 0.26566769317, 0.19821728523],
            [0.22897456407, 0.69173852184, 0.079286914094],
            [0.0, 0.045113381859, 1.0439443689],
        ];
        for (primaries, expected, tolerance) in
            [(Primaries::SRGB, srgb, 0.6e-4), (Primaries::DISPLAY_P3, p3, 1e-9)]
        {
            let got = primaries.xyz_from_rgb().unwrap();
            for (g, e) in got.as_flattened().iter().zip(expected.as_flattened()) {
                assert!((g - e).abs() < tolerance, "{g} is not {e}");
            }
        }
    }

    #[test]
    fn the_curve_inverts_and_meets_at_the_knee() {
        for i in 0..=1000 {
            let v = f64::from(i) / 1000.0;
            // The rounded constants of the standard leave a step of 3e-8.
            assert!((decode_srgb(encode_srgb(v)) - v).abs() < 1e-7);
        }
        assert!(encode_srgb(f64::NAN).is_nan() && decode_srgb(f64::NAN).is_nan());
        assert!((encode_srgb(1.5) - 1.0).abs() < 1e-15);
        // 18 % grey in 8-bit sRGB is 118.
        assert_eq!((encode_srgb(0.18) * 255.0).round(), 118.0);
    }

    #[test]
    fn primaries_on_a_line_have_no_matrix() {
        let flat = Primaries { green: [0.4, 0.2], red: [0.6, 0.3], blue: [0.2, 0.1], white: D65_XY };
        assert!(flat.xyz_from_rgb().is_none_or(|m| m.as_flattened().iter().all(|v| v.is_finite())));
        assert_eq!(Primaries { blue: [0.2, 0.0], ..Primaries::SRGB }.xyz_from_rgb(), None);
    }
}
