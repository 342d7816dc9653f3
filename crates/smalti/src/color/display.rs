//! Display colour spaces: matrices derived from primaries and white, and the curve of sRGB.

use super::cie1976::xyz_from_xy;
use super::matrix::{IDENTITY, Matrix3, apply, diagonal, inverse, product};

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

/// D65 as display standards round it (IEC 61966-2-1, ITU-R BT.709).
pub const D65_XY: [f64; 2] = [0.3127, 0.3290];

impl Primaries {
    /// sRGB (IEC 61966-2-1), those of ITU-R BT.709.
    pub const SRGB: Self = Self { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: D65_XY };
    /// Display P3: the primaries of SMPTE EG 432-1 with D65 white.
    pub const DISPLAY_P3: Self =
        Self { red: [0.680, 0.320], green: [0.265, 0.690], blue: [0.150, 0.060], white: D65_XY };

    /// X, Y, Z of white at Y = 1; `None` when its y is zero.
    #[must_use]
    pub fn white_xyz(&self) -> Option<[f64; 3]> {
        xyz_from_xy(self.white, 1.0)
    }

    /// XYZ (white at Y = 1) from linear RGB; `None` when the primaries lie on a line or have no luminance.
    #[must_use]
    pub fn xyz_from_rgb(&self) -> Option<Matrix3> {
        let (r, g, b) =
            (xyz_from_xy(self.red, 1.0)?, xyz_from_xy(self.green, 1.0)?, xyz_from_xy(self.blue, 1.0)?);
        let columns = [0, 1, 2].map(|i| [r[i], g[i], b[i]]);
        let luminance = apply(&inverse(&columns)?, self.white_xyz()?);
        Some(product(&columns, &diagonal(luminance)))
    }

    /// Linear RGB from XYZ (white at Y = 1); `None` as for [`Primaries::xyz_from_rgb`].
    #[must_use]
    pub fn rgb_from_xyz(&self) -> Option<Matrix3> {
        inverse(&self.xyz_from_rgb()?)
    }
}

/// Both matrices of a space that is known to be sound.
pub(super) fn matrices(primaries: &Primaries) -> (Matrix3, Matrix3) {
    let pair = || Some((primaries.xyz_from_rgb()?, primaries.rgb_from_xyz()?));
    pair().unwrap_or((IDENTITY, IDENTITY))
}

/// Linear light at which the line of the sRGB curve meets its power.
pub(super) const LINEAR_KNEE: f64 = 0.0031308;
/// The encoded value there.
pub(super) const ENCODED_KNEE: f64 = 0.04045;

/// Linear light, clipped to 0–1, encoded by the curve of IEC 61966-2-1. NaN stays NaN.
#[must_use]
pub fn encode_srgb(linear: f64) -> f64 {
    let v = linear.clamp(0.0, 1.0);
    if v <= LINEAR_KNEE { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// Linear light of a value encoded by the curve of IEC 61966-2-1, clipped to 0–1. NaN stays NaN.
#[must_use]
pub fn decode_srgb(encoded: f64) -> f64 {
    let v = encoded.clamp(0.0, 1.0);
    if v <= ENCODED_KNEE { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
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

    /// IEC 61966-2-1 prints its matrix with four decimals; Display P3's is colour-science 0.4.7's, derived as here.
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
            // The standard's rounded knees leave a step of 3e-8.
            assert!((decode_srgb(encode_srgb(v)) - v).abs() < 1e-7);
        }
        assert!(encode_srgb(f64::NAN).is_nan() && decode_srgb(f64::NAN).is_nan());
        assert!((encode_srgb(1.5) - 1.0).abs() < 1e-15);
        // 18 % grey, as printed in every table of sRGB: 118/255.
        assert_eq!((encode_srgb(0.18) * 255.0).round(), 118.0);
    }

    #[test]
    fn primaries_on_a_line_have_no_matrix() {
        let flat = Primaries { green: [0.4, 0.2], red: [0.6, 0.3], blue: [0.2, 0.1], white: D65_XY };
        assert!(flat.xyz_from_rgb().is_none_or(|m| m.as_flattened().iter().all(|v| v.is_finite())));
        assert_eq!(Primaries { blue: [0.2, 0.0], ..Primaries::SRGB }.xyz_from_rgb(), None);
    }
}
