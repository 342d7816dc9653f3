//! CIEDE2000 (ISO/CIE 11664-6), in the notation of Sharma, Wu and Dalal (2005), "The CIEDE2000 color-difference
//! formula: implementation notes, supplementary test data, and mathematical observations", *Color Res. Appl.* 30.

use std::f64::consts::{FRAC_PI_3, SQRT_2};

use crate::numeric::elementary::{atan2_f64, exp_f64, sin_f64};

const POW25_7: f64 = 6_103_515_625.0;

/// ΔE₀₀ with k_L = k_C = k_H = 1.
///
/// Hues enter as unit vectors and not as angles, so that the formula needs no trigonometric function except in the narrow
/// rotation term, and has no branches: a loop over it becomes vector code.
#[inline(always)]
#[must_use]
pub fn delta_e_2000(lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
    let ([l1, a1, b1], [l2, a2, b2]) = (lab1, lab2);
    let length = |a: f64, b: f64| (a * a + b * b).sqrt();

    // The factor 1 + G by which a′ exceeds a; written with a positive sign, 1 − √(…) stays accurate far from
    // the neutral axis.
    let stretch = 1.0 + 0.5 * (1.0 - saturating((length(a1, b1) + length(a2, b2)) / 2.0));
    let (a1, a2) = (a1 * stretch, a2 * stretch);
    let (c1, c2) = (length(a1, b1), length(a2, b2));
    let (dl, dc) = (l2 - l1, c2 - c1);
    let (l_mean, c_mean) = ((l1 + l2) / 2.0, (c1 + c2) / 2.0);

    let (dh, [cos, sin]) = hues([a1, b1, c1], [a2, b2, c2]);
    let (cos2, sin2) = (cos * cos - sin * sin, 2.0 * sin * cos);
    let (cos3, sin3) = (cos2 * cos - sin2 * sin, sin2 * cos + cos2 * sin);
    let (cos4, sin4) = (cos2 * cos2 - sin2 * sin2, 2.0 * sin2 * cos2);
    // Cosines of h − 30°, 2 h, 3 h + 6° and 4 h − 63°.
    let t = 1.0 - 0.17 * (cos * COS_30 + sin * 0.5) + 0.24 * cos2 + 0.32 * (cos3 * COS_6 - sin3 * SIN_6)
        - 0.20 * (cos4 * COS_63 + sin4 * SIN_63);
    let l50 = (l_mean - 50.0) * (l_mean - 50.0);
    let sl = 1.0 + 0.015 * l50 / (20.0 + l50).sqrt();
    let sc = 1.0 + 0.045 * c_mean;
    let sh = 1.0 + 0.015 * c_mean * t;

    // The angle from 275° to the mean hue. The formula takes it from a mean hue of 0° to 360°, so that hues from 0° on, 85° away,
    // are far.
    let off = atan2_f64(sin * COS_275 - cos * SIN_275, cos * COS_275 + sin * SIN_275);
    let steps = off * (180.0 / std::f64::consts::PI / 25.0);
    // Twice Δθ is at most 60°.
    let turn = if steps < 85.0 / 25.0 { FRAC_PI_3 * exp_f64(-(steps * steps)) } else { 0.0 };
    let rotation = -2.0 * saturating(c_mean) * sin_f64(turn);

    let (x, y, z) = (dl / sl, dc / sc, dh / sh);
    let square = x * x + y * y + z * z + rotation * y * z;
    (if square > 0.0 { square } else { 0.0 }).sqrt()
}

const COS_30: f64 = 0.866_025_403_784_438_6;
const COS_6: f64 = 0.994_521_895_368_273_3;
const SIN_6: f64 = 0.104_528_463_267_653_47;
const COS_63: f64 = 0.453_990_499_739_546_8;
const SIN_63: f64 = 0.891_006_524_188_367_9;
const COS_275: f64 = 0.087_155_742_747_658_17;
const SIN_275: f64 = -0.996_194_698_091_745_5;

/// √(c⁷ / (c⁷ + 25⁷)).
#[inline(always)]
fn saturating(c: f64) -> f64 {
    let c3 = c * c * c;
    let c7 = c3 * c3 * c;
    (c7 / (c7 + POW25_7)).sqrt()
}

/// ΔH′, and the cosine and sine of the mean hue, of two colours, each with its a′, b′ and chroma. The mean hue of a neutral
/// colour and another is that of the other.
#[inline(always)]
fn hues([a1, b1, c1]: [f64; 3], [a2, b2, c2]: [f64; 3]) -> (f64, [f64; 2]) {
    // Sine and cosine of the difference of hue, times both chromas.
    let (cross, dot, product) = (a1 * b2 - a2 * b1, a1 * a2 + b1 * b2, c1 * c2);
    // 2 √(C₁ C₂) sin(Δh/2), without cancellation for near and for opposite hues. Of opposite hues, the smaller angle precedes.
    let is_near = dot >= 0.0;
    let upper = b1 > 0.0 || (b1 == 0.0 && a1 > 0.0);
    let is_ahead = cross > 0.0 || (cross == 0.0 && upper);
    let sum = product + dot;
    let near = cross * SQRT_2 / (if sum > 0.0 { sum } else { 1.0 }).sqrt();
    let opposite = (2.0 * (product - dot)).abs().sqrt();
    let dh = if is_near {
        near
    } else if is_ahead {
        opposite
    } else {
        -opposite
    };
    // The direction halfway: along the sum of the unit vectors, or perpendicular to their difference.
    let inverse = |c: f64| if c > 0.0 { 1.0 / c } else { 0.0 };
    let (i1, i2) = (inverse(c1), inverse(c2));
    let ([x1, y1], [x2, y2]) = ([a1 * i1, b1 * i1], [a2 * i2, b2 * i2]);
    let sign = if is_ahead { 1.0 } else { -1.0 };
    let (x, y) = if is_near { (x1 + x2, y1 + y2) } else { ((y2 - y1) * sign, (x1 - x2) * sign) };
    let length = (x * x + y * y).sqrt();
    let scale = inverse(length);
    (dh, [if length > 0.0 { x * scale } else { 1.0 }, y * scale])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    /// Table 1 of Sharma, Wu and Dalal (2005): two colours and their difference, printed with four decimals.
    #[rustfmt::skip]
    const PAIRS: [([f64; 3], [f64; 3], f64); 34] = [
        ([50.0000, 2.6772, -79.7751], [50.0000, 0.0000, -82.7485], 2.0425),
        ([50.0000, 3.1571, -77.2803], [50.0000, 0.0000, -82.7485], 2.8615),
        ([50.0000, 2.8361, -74.0200], [50.0000, 0.0000, -82.7485], 3.4412),
        ([50.0000, -1.3802, -84.2814], [50.0000, 0.0000, -82.7485], 1.0000),
        ([50.0000, -1.1848, -84.8006], [50.0000, 0.0000, -82.7485], 1.0000),
        ([50.0000, -0.9009, -85.5211], [50.0000, 0.0000, -82.7485], 1.0000),
        ([50.0000, 0.0000, 0.0000], [50.0000, -1.0000, 2.0000], 2.3669),
        ([50.0000, -1.0000, 2.0000], [50.0000, 0.0000, 0.0000], 2.3669),
        ([50.0000, 2.4900, -0.0010], [50.0000, -2.4900, 0.0009], 7.1792),
        ([50.0000, 2.4900, -0.0010], [50.0000, -2.4900, 0.0010], 7.1792),
        ([50.0000, 2.4900, -0.0010], [50.0000, -2.4900, 0.0011], 7.2195),
        ([50.0000, 2.4900, -0.0010], [50.0000, -2.4900, 0.0012], 7.2195),
        ([50.0000, -0.0010, 2.4900], [50.0000, 0.0009, -2.4900], 4.8045),
        ([50.0000, -0.0010, 2.4900], [50.0000, 0.0010, -2.4900], 4.8045),
        ([50.0000, -0.0010, 2.4900], [50.0000, 0.0011, -2.4900], 4.7461),
        ([50.0000, 2.5000, 0.0000], [50.0000, 0.0000, -2.5000], 4.3065),
        ([50.0000, 2.5000, 0.0000], [73.0000, 25.0000, -18.0000], 27.1492),
        ([50.0000, 2.5000, 0.0000], [61.0000, -5.0000, 29.0000], 22.8977),
        ([50.0000, 2.5000, 0.0000], [56.0000, -27.0000, -3.0000], 31.9030),
        ([50.0000, 2.5000, 0.0000], [58.0000, 24.0000, 15.0000], 19.4535),
        ([50.0000, 2.5000, 0.0000], [50.0000, 3.1736, 0.5854], 1.0000),
        ([50.0000, 2.5000, 0.0000], [50.0000, 3.2972, 0.0000], 1.0000),
        ([50.0000, 2.5000, 0.0000], [50.0000, 1.8634, 0.5757], 1.0000),
        ([50.0000, 2.5000, 0.0000], [50.0000, 3.2592, 0.3350], 1.0000),
        ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
        ([63.0109, -31.0961, -5.8663], [62.8187, -29.7946, -4.0864], 1.2630),
        ([61.2901, 3.7196, -5.3901], [61.4292, 2.2480, -4.9620], 1.8731),
        ([35.0831, -44.1164, 3.7933], [35.0232, -40.0716, 1.5901], 1.8645),
        ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
        ([36.4612, 47.8580, 18.3852], [36.2715, 50.5065, 21.2231], 1.4146),
        ([90.8027, -2.0831, 1.4410], [91.1528, -1.6435, 0.0447], 1.4441),
        ([90.9257, -0.5406, -0.9208], [88.6381, -0.8985, -0.7239], 1.5381),
        ([6.7747, -0.2908, -2.4247], [5.8714, -0.0985, -2.2286], 0.6377),
        ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
    ];

    #[test]
    fn the_34_pairs_of_sharma() {
        for (lab1, lab2, expected) in PAIRS {
            for got in [delta_e_2000(lab1, lab2), delta_e_2000(lab2, lab1)] {
                assert!((got - expected).abs() < 1e-4, "{lab1:?}, {lab2:?}: {got} is not {expected}");
            }
        }
    }

    /// The formula as printed, with angles.
    fn printed(lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
        let ([l1, a1, b1], [l2, a2, b2]) = (lab1, lab2);

        let c_mean = (a1.hypot(b1) + a2.hypot(b2)) / 2.0;
        let c_mean7 = c_mean.powi(7);
        // The factor 1 + G by which a′ exceeds a; written with a positive sign, 1 − √(…) stays accurate far from
        // the neutral axis.
        let stretch = 1.0 + 0.5 * (1.0 - (c_mean7 / (c_mean7 + POW25_7)).sqrt());
        let (ap1, ap2) = (a1 * stretch, a2 * stretch);
        let (cp1, cp2) = (ap1.hypot(b1), ap2.hypot(b2));
        let (hp1, hp2) = (hue_degrees(ap1, b1), hue_degrees(ap2, b2));

        let chromatic = cp1 * cp2 != 0.0;
        let dh = if !chromatic {
            0.0
        } else if (hp2 - hp1).abs() <= 180.0 {
            hp2 - hp1
        } else if hp2 > hp1 {
            hp2 - hp1 - 360.0
        } else {
            hp2 - hp1 + 360.0
        };
        let h_mean = if !chromatic {
            hp1 + hp2
        } else if (hp1 - hp2).abs() <= 180.0 {
            (hp1 + hp2) / 2.0
        } else if hp1 + hp2 < 360.0 {
            (hp1 + hp2 + 360.0) / 2.0
        } else {
            (hp1 + hp2 - 360.0) / 2.0
        };
        let (dl, dc) = (l2 - l1, cp2 - cp1);
        let dh = 2.0 * (cp1 * cp2).sqrt() * (dh / 2.0).to_radians().sin();

        let (l_mean, cp_mean) = ((l1 + l2) / 2.0, (cp1 + cp2) / 2.0);
        let cos = |degrees: f64| degrees.to_radians().cos();
        let t = 1.0 - 0.17 * cos(h_mean - 30.0) + 0.24 * cos(2.0 * h_mean) + 0.32 * cos(3.0 * h_mean + 6.0)
            - 0.20 * cos(4.0 * h_mean - 63.0);
        let l50 = (l_mean - 50.0).powi(2);
        let sl = 1.0 + 0.015 * l50 / (20.0 + l50).sqrt();
        let sc = 1.0 + 0.045 * cp_mean;
        let sh = 1.0 + 0.015 * cp_mean * t;
        let turn = 30.0 * (-((h_mean - 275.0) / 25.0).powi(2)).exp();
        let cp_mean7 = cp_mean.powi(7);
        let rotation = -2.0 * (cp_mean7 / (cp_mean7 + POW25_7)).sqrt() * (2.0 * turn).to_radians().sin();

        let (x, y, z) = (dl / sl, dc / sc, dh / sh);
        (x * x + y * y + z * z + rotation * y * z).max(0.0).sqrt()
    }

    /// Hue in [0, 360); 0 on the axis.
    fn hue_degrees(a: f64, b: f64) -> f64 {
        let h = b.atan2(a).to_degrees();
        if h < 0.0 { h + 360.0 } else { h }
    }

    /// Colours of all hues, near and far, and neutral ones.
    #[test]
    fn vectors_of_hue_give_the_printed_formula() {
        let mut random = Stream::new(3, 0, 1);
        let mut uniform =
            |low: f64, high: f64| low + (high - low) * f64::from(random.below(1 << 30)) / f64::from(1 << 30);
        for i in 0..60_000 {
            let lab1 = [uniform(0.0, 100.0), uniform(-90.0, 90.0), uniform(-90.0, 90.0)];
            let far = [100.0, 10.0, 0.1, 1e-5][i % 4];
            let mut lab2 = lab1.map(|v| v + uniform(-far, far));
            if i % 11 == 0 {
                lab2 = [lab1[0], uniform(-1.5, -0.5) * lab1[1], uniform(-1.5, -0.5) * lab1[2]];
            }
            if i % 101 == 0 {
                lab2[1] = 0.0;
                lab2[2] = 0.0;
            }
            let (got, expected) = (delta_e_2000(lab1, lab2), printed(lab1, lab2));
            assert!(
                (got - expected).abs() <= 1e-9 + 3e-5 * f64::from(u8::from(far > 1.0)),
                "{lab1:?}, {lab2:?}: {got} is not {expected}"
            );
        }
    }

    #[test]
    fn equal_colours_do_not_differ() {
        for (lab1, lab2, _) in PAIRS {
            assert_eq!((delta_e_2000(lab1, lab1), delta_e_2000(lab2, lab2)), (0.0, 0.0));
        }
    }

    /// Hues of 0° and 180°, and of 90° and 270°, are 180° apart exactly: their mean hue is the printed one, 90° or 180°, and not its opposite.
    #[test]
    fn exactly_opposite_hues_have_the_printed_mean() {
        for (near, far) in
            [([40.0, 0.0], [-20.0, 0.0]), ([0.0, 40.0], [0.0, -20.0]), ([3.0, 0.0], [-70.0, 0.0])]
        {
            let [lab1, lab2] = [near, far].map(|[a, b]| [50.0, a, b]);
            for (from, to) in [(lab1, lab2), (lab2, lab1)] {
                let (got, expected) = (delta_e_2000(from, to), printed(from, to));
                assert!((got - expected).abs() < 1e-9, "{from:?}, {to:?}: {got} is not {expected}");
            }
        }
    }
}
