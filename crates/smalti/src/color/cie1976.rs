//! Chromaticity coordinates and CIELAB (CIE 15:2018; ISO/CIE 11664-4).
//!
//! X, Y, Z and the white share a scale, which is arbitrary: only their ratios matter.

use crate::numeric::elementary::cbrt_f64;

/// (6/29)³: below this value a line replaces the cube root.
const EPSILON: f64 = 216.0 / 24389.0;
/// (29/3)³: 100 times the slope of that line in L*.
const KAPPA: f64 = 24389.0 / 27.0;

/// Tristimulus values of a chromaticity at luminance `y_luminance`; `None` for y = 0.
#[must_use]
pub const fn xyz_from_xy(xy: [f64; 2], y_luminance: f64) -> Option<[f64; 3]> {
    let k = y_luminance / xy[1];
    if k.is_finite() { Some([k * xy[0], y_luminance, k * (1.0 - xy[0] - xy[1])]) } else { None }
}

/// u′, v′ (CIE 1976 UCS) of tristimulus values; `None` for black.
#[must_use]
pub fn upvp_from_xyz(xyz: [f64; 3]) -> Option<[f64; 2]> {
    ratio(4.0 * xyz[0], 9.0 * xyz[1], xyz[0] + 15.0 * xyz[1] + 3.0 * xyz[2])
}

/// u, v (CIE 1960 UCS, in which correlated colour temperature is defined); `None` for black.
#[must_use]
pub fn uv_from_xyz(xyz: [f64; 3]) -> Option<[f64; 2]> {
    upvp_from_xyz(xyz).map(|[u, v]| [u, v * 2.0 / 3.0])
}

fn ratio(a: f64, b: f64, sum: f64) -> Option<[f64; 2]> {
    let pair = [a / sum, b / sum];
    pair.iter().all(|v| v.is_finite()).then_some(pair)
}

/// CIELAB L*, a*, b* relative to a white. Compiled into a kernel, it has the same bits for every instruction set.
#[inline(always)]
#[must_use]
pub fn lab_from_xyz(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let f = |i: usize| {
        let t = xyz[i] / white[i];
        // The root of a number that has one, so that lanes compute both branches.
        let root = cbrt_f64(if t > EPSILON { t } else { 1.0 });
        if t > EPSILON { root } else { (KAPPA * t + 16.0) / 116.0 }
    };
    let (fx, fy, fz) = (f(0), f(1), f(2));
    [116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)]
}

/// Tristimulus values of CIELAB coordinates relative to a white, in the scale of the white.
#[must_use]
pub fn xyz_from_lab(lab: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let fy = (lab[0] + 16.0) / 116.0;
    let inverse = |f: f64| {
        let t = f * f * f;
        if t > EPSILON { t } else { (116.0 * f - 16.0) / KAPPA }
    };
    [white[0] * inverse(fy + lab[1] / 500.0), white[1] * inverse(fy), white[2] * inverse(fy - lab[2] / 200.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const D65: [f64; 3] = [95.047, 100.0, 108.883];

    fn close(a: &[f64], b: &[f64], tolerance: f64) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < tolerance), "{a:?} is not {b:?}");
    }

    #[test]
    fn white_and_black_lie_on_the_axis() {
        close(&lab_from_xyz(D65, D65), &[100.0, 0.0, 0.0], 1e-12);
        close(&lab_from_xyz([0.0; 3], D65), &[0.0, 0.0, 0.0], 1e-12);
        assert_eq!(upvp_from_xyz([0.0; 3]), None);
    }

    #[test]
    fn the_two_branches_meet() {
        let at = |k: f64| lab_from_xyz(D65.map(|w| w * EPSILON * k), D65)[0];
        assert!((at(1.0 + 1e-9) - at(1.0 - 1e-9)).abs() < 1e-6);
    }

    #[test]
    fn lab_round_trips() {
        for xyz in [[41.24, 21.26, 1.93], [0.1, 0.05, 0.2], [76.98, 92.78, 13.85]] {
            close(&xyz_from_lab(lab_from_xyz(xyz, D65), D65), &xyz, 1e-12);
        }
    }

    /// Expected values: colour-science 0.4.7 (`XYZ_to_Lab`, `Luv_to_uv`), which uses the
    /// same CIE 15 constants, so agreement is to the rounding of the digits printed here.
    #[test]
    fn agrees_with_colour_science() {
        let xyz = [20.654008, 12.197225, 5.136952];
        close(&lab_from_xyz(xyz, D65), &[41.5278752944, 52.6370994192, 26.9181411649], 1e-8);
        close(&upvp_from_xyz(xyz).unwrap(), &[0.3772021288, 0.5012026372], 1e-9);
    }
}
