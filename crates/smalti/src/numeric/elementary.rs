//! Logarithm, exponential, cube root, sine and arc tangent in plain arithmetic, without branches or calls into a maths library. A
//! loop over them compiles to vector code, and every instruction set, machine and lane gives the same bits.
//!
//! The cube root and the reciprocal square root are iterations, and whole parts are exact. All others are truncated Taylor series
//! with exact rational coefficients after a range reduction. The truncation error is below the rounding error of the type. Each
//! function states the range of arguments it accepts.

use std::f32::consts as f32c;
use std::f64::consts as f64c;

/// Natural logarithm of a positive normal number.
#[inline(always)]
#[must_use]
pub fn ln_f64(x: f64) -> f64 {
    // x = 2^e · m with m in [√½, √2). Offsetting the exponent by the bits of √½ splits x with one
    // subtraction.
    const SQRT_HALF: u64 = 0x3FE6_A09E_667F_3BCD;
    let offset = x.to_bits().wrapping_sub(SQRT_HALF);
    // Adding a signed 12-bit exponent to the mantissa of 1.5 · 2^52 converts it to a floating-point number.
    let exponent = (offset as i64 >> 52) as u64;
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    let e = f64::from_bits(MAGIC.to_bits().wrapping_add(exponent)) - MAGIC;
    let m = f64::from_bits((offset & 0x000F_FFFF_FFFF_FFFF).wrapping_add(SQRT_HALF));
    // ln m = 2 artanh s, |s| ≤ 0.1716.
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let mut sum = 1.0 / 21.0;
    for k in [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        sum = sum * z + 1.0 / k;
    }
    e * f64c::LN_2 + (2.0 * s + 2.0 * s * z * sum)
}

/// Natural logarithm of a positive normal number.
#[inline(always)]
#[must_use]
pub fn ln_f32(x: f32) -> f32 {
    const SQRT_HALF: u32 = 0x3F35_04F3;
    let offset = x.to_bits().wrapping_sub(SQRT_HALF);
    let e = (offset as i32 >> 23) as f32;
    let m = f32::from_bits((offset & 0x007F_FFFF).wrapping_add(SQRT_HALF));
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let sum = (((z * (1.0 / 9.0) + 1.0 / 7.0) * z + 1.0 / 5.0) * z + 1.0 / 3.0) * z;
    e * f32c::LN_2 + (2.0 * s + 2.0 * s * sum)
}

/// The whole part of `x` in 0..2²². Other arguments, NaN included, give an arbitrary number. A cast saturates, so that compilers do not
/// vectorise it.
#[inline(always)]
#[must_use]
pub fn whole_part_f32(x: f32) -> u32 {
    // From 2²³ to 2²⁴, the spacing of the numbers is 1, so that the sum is rounded to a whole number.
    const MAGIC: f32 = 8_388_608.0;
    let shifted = x + MAGIC;
    let rounded_up = shifted - MAGIC > x;
    shifted.to_bits().wrapping_sub(MAGIC.to_bits()).wrapping_sub(u32::from(rounded_up))
}

/// `exp(x)` for `x` in −700..=700.
#[inline(always)]
#[must_use]
pub fn exp_f64(x: f64) -> f64 {
    // ln 2 in two parts. The first is short enough that its multiples below 2^11 are exact.
    const LN2_HIGH: f64 = 0.693_147_180_369_123_8;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    let shifted = x * f64c::LOG2_E + MAGIC;
    let n = shifted - MAGIC;
    let r = (x - n * LN2_HIGH) - n * LN2_LOW;
    // |r| ≤ 0.347: r^14/14! < 5e-18.
    let mut sum = 1.0;
    for k in [13.0, 12.0, 11.0, 10.0, 9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0] {
        sum = 1.0 + r * sum * (1.0 / k);
    }
    let power = shifted.to_bits().wrapping_sub(MAGIC.to_bits()).wrapping_add(1023) << 52;
    sum * f64::from_bits(power)
}

/// Reciprocal of the square root of a positive normal number, to a relative error of 2⁻²². A square root and a division take several times as
/// long.
#[inline(always)]
#[must_use]
pub fn inverse_sqrt_f32(x: f32) -> f32 {
    // Halved and negated bits halve and negate the logarithm: right to 1/29. The constant is that of Quake III Arena.
    let mut y = f32::from_bits(0x5F37_59DF_u32.wrapping_sub(x.to_bits() >> 1));
    // Chebyshev's method cubes the relative error: 1e-4, then below rounding.
    for _ in 0..2 {
        let rest = 1.0 - x * y * y;
        y += y * (rest * (0.5 + 0.375 * rest));
    }
    y
}

/// Cube root of a positive normal number.
#[inline(always)]
#[must_use]
pub fn cbrt_f64(x: f64) -> f64 {
    // A third of the exponent and, linearly, of the mantissa: right to 1/23 [Kahan's constant, as in FreeBSD's cbrt].
    let third = ((x.to_bits() >> 32) * 0x5555_5556) >> 32;
    let mut t = f64::from_bits((third + 715_094_163) << 32);
    // Halley's method cubes the relative error: 5e-5, then 1e-13.
    for _ in 0..2 {
        let cube = t * t * t;
        t *= (cube + 2.0 * x) / (2.0 * cube + x);
    }
    // A step of Newton's method as a small correction, so that the result is right to rounding.
    t + (x / (t * t) - t) * (1.0 / 3.0)
}

/// Sine of an angle of −π/3 to π/3.
#[inline(always)]
#[must_use]
pub fn sin_f64(x: f64) -> f64 {
    let z = x * x;
    // (π/3)^21/21! = 5e-20.
    let mut sum = 1.0;
    for k in [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        sum = 1.0 - sum * z * (1.0 / (k * (k - 1.0)));
    }
    x * sum
}

/// The angle of the vector (x, y), −π to π; 0 for the vector (0, 0). Both must be finite.
#[inline(always)]
#[must_use]
pub fn atan2_f64(y: f64, x: f64) -> f64 {
    const TAN_EIGHTH: f64 = 0.414_213_562_373_095_03;
    let (along, up) = (x.abs(), y.abs());
    let (least, most) = if up > along { (along, up) } else { (up, along) };
    // The angle to the nearest of 0 and π/4, whose tangent is at most tan π/8.
    let is_middle = least > TAN_EIGHTH * most;
    let (top, bottom) = if is_middle { (least - most, least + most) } else { (least, most) };
    let t = top / if bottom > 0.0 { bottom } else { 1.0 };
    let z = t * t;
    // 0.1716^23/47 < 1e-18.
    let mut sum = 1.0 / 45.0;
    for k in [
        43.0, 41.0, 39.0, 37.0, 35.0, 33.0, 31.0, 29.0, 27.0, 25.0, 23.0, 21.0, 19.0, 17.0, 15.0, 13.0, 11.0,
        9.0, 7.0, 5.0, 3.0,
    ] {
        sum = 1.0 / k - sum * z;
    }
    let angle = t - t * z * sum + if is_middle { f64c::FRAC_PI_4 } else { 0.0 };
    let angle = if up > along { f64c::FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { f64c::PI - angle } else { angle };
    if y < 0.0 { -angle } else { angle }
}

/// Sine and cosine of `2π · turn · 2⁻³²`.
#[inline(always)]
#[must_use]
pub fn sin_cos_turn(turn: u32) -> (f32, f32) {
    // The nearest quarter turn and the remainder, −⅛ to ⅛ of a turn.
    let quarter = turn.wrapping_add(1 << 29) >> 30;
    let rest = turn.wrapping_sub(quarter << 30) as i32;
    let x = rest as f32 * (f32c::TAU / 4_294_967_296.0);
    let z = x * x;
    let s = x + x * z * (-1.0 / 6.0 + z * (1.0 / 120.0 + z * (-1.0 / 5040.0 + z * (1.0 / 362_880.0))));
    let c = 1.0
        + z * (-0.5 + z * (1.0 / 24.0 + z * (-1.0 / 720.0 + z * (1.0 / 40_320.0 - z * (1.0 / 3_628_800.0)))));
    let (a, b) = if quarter & 1 == 1 { (c, s) } else { (s, c) };
    let flip_sin = (quarter & 2) << 30;
    let flip_cos = (quarter.wrapping_add(1) & 2) << 30;
    (f32::from_bits(a.to_bits() ^ flip_sin), f32::from_bits(b.to_bits() ^ flip_cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_right_to_rounding() {
        for i in 0..20_000 {
            let x = 1e-12 * 1.003f64.powi(i);
            let scale = x.ln().abs().max(1.0);
            assert!((ln_f64(x) - x.ln()).abs() <= 4e-16 * scale, "{x}");
            let y = x as f32;
            assert!((f64::from(ln_f32(y)) - f64::from(y).ln()).abs() <= 1.5e-7 * scale, "{y}");
        }
        // Near 1 the logarithm itself is small, so the relative error is tested.
        for i in 1..1000 {
            let x = 1.0 + f64::from(i) * 1e-5;
            assert!((ln_f64(x) / x.ln() - 1.0).abs() < 1e-15);
        }
        assert_eq!((ln_f64(1.0), ln_f32(1.0)), (0.0, 0.0));
    }

    #[test]
    fn exponentials_are_right_to_rounding() {
        for i in -6000..6000 {
            let x = f64::from(i) * 0.1;
            assert!((exp_f64(x) / x.exp() - 1.0).abs() < 5e-16, "{x}");
        }
    }

    #[test]
    fn whole_parts_are_those_of_a_cast() {
        let ends = [0.0, 0.5, 0.999_999_9, 1.0, 1.5, 2.5, 65_534.5, 65_535.5, 4_194_303.5];
        for x in ends.into_iter().chain((0..20_000).map(|i| 1e-3 * 1.001_107f64.powi(i))) {
            let single = x as f32;
            assert_eq!(whole_part_f32(single), single as u32, "{single}");
        }
    }

    #[test]
    fn reciprocal_square_roots_are_right_to_rounding() {
        for i in 0..20_000 {
            let x = 1e-12 * 1.0028f32.powi(i);
            let expected = f64::from(x).sqrt().recip();
            assert!(
                (f64::from(inverse_sqrt_f32(x)) / expected - 1.0).abs() <= 2.0 * f64::from(f32::EPSILON),
                "{x}"
            );
        }
    }

    #[test]
    fn cube_roots_are_right_to_rounding() {
        for i in 0..20_000 {
            let x = 1e-12 * 1.0031f64.powi(i);
            assert!((cbrt_f64(x) / x.cbrt() - 1.0).abs() <= 4.5e-16, "{x}");
        }
        assert_eq!((cbrt_f64(1.0), cbrt_f64(8.0)), (1.0, 2.0));
    }

    #[test]
    fn angles_and_their_sines_are_right_to_rounding() {
        for i in -50_000..=50_000 {
            let x = f64::from(i) * (f64c::FRAC_PI_3 / 50_000.0);
            assert!((sin_f64(x) - x.sin()).abs() <= 3e-16 * x.abs(), "{x}");
            let angle = 3.0 * x;
            let (y, x) = angle.sin_cos();
            let length = 1e3f64.powi(i % 7);
            let expected = (y * length).atan2(x * length);
            assert!((atan2_f64(y * length, x * length) - expected).abs() <= 9e-16, "{angle}");
        }
        for (y, x) in [(0.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (1.0, 1.0)] {
            assert_eq!(atan2_f64(y, x), f64::atan2(y, x));
        }
    }

    #[test]
    fn sines_are_right_to_rounding() {
        for i in 0..100_000u32 {
            let turn = i.wrapping_mul(42_949).wrapping_add(i);
            let angle = f64::from(turn) / 4_294_967_296.0 * f64c::TAU;
            let (s, c) = sin_cos_turn(turn);
            assert!((f64::from(s) - angle.sin()).abs() < 1.2e-7, "{turn}");
            assert!((f64::from(c) - angle.cos()).abs() < 1.2e-7, "{turn}");
        }
    }
}
