//! Transfer functions of a circular pupil, tabulated over frequency in units of the cut-off 1 / (λN).

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI, TAU};

/// Samples of the in-focus table. The error of linear interpolation is below 10⁻⁶.
const TABLE_LEN: usize = 1025;

/// The transfer function of a lens in focus: the overlap of two unit discs (Goodman 2005, section 6.4), with
/// `nu` in units of the cut-off.
pub(super) fn diffraction_limit(nu: f64) -> f64 {
    if nu >= 1.0 { 0.0 } else { FRAC_2_PI * (nu.acos() - nu * (1.0 - nu * nu).sqrt()) }
}

/// A table of [`diffraction_limit`].
pub(super) fn in_focus() -> Vec<f32> {
    table(TABLE_LEN, diffraction_limit)
}

/// A table for a defocused lens with a wavefront error of `rim_waves` (W₂₀ / λ) at the rim of the pupil
/// (Hopkins 1955).
///
/// The phases of two pupils at a distance `s` = 2ν differ by 4π W₂₀ s x over their overlap, whose height at
/// `x` is 2 √(1 − (|x| + ν)²). This gives one integral per frequency; the substitution x + ν = sin θ makes
/// its end point smooth.
pub(super) fn out_of_focus(rim_waves: f64) -> Vec<f32> {
    let waves = rim_waves.abs();
    if waves == 0.0 {
        return in_focus();
    }
    // With twelve intervals per cycle of the phase and 512 table entries per wave, both errors are below
    // 10⁻⁴.
    let intervals = 2 * (16 + (6.0 * waves).ceil() as usize);
    let len = TABLE_LEN + (512.0 * waves).ceil() as usize;
    table(len, |nu| {
        let start = nu.min(1.0).asin();
        let h = (FRAC_PI_2 - start) / intervals as f64;
        let k = 2.0 * TAU * waves * 2.0 * nu;
        let sum: f64 = (0..=intervals)
            .map(|i| {
                let (sin, cos) = (start + i as f64 * h).sin_cos();
                let simpson = if i == 0 || i == intervals { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
                simpson * cos * cos * (k * (sin - nu)).cos()
            })
            .sum();
        4.0 / PI * sum * h / 3.0
    })
}

fn table(len: usize, f: impl Fn(f64) -> f64) -> Vec<f32> {
    (0..len).map(|i| f(i as f64 / (len - 1) as f64) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limits_of_diffraction() {
        assert_eq!((diffraction_limit(0.0), diffraction_limit(1.0), diffraction_limit(2.0)), (1.0, 0.0, 0.0));
        // At half the cut-off: 2/π (π/3 − √3/4).
        let half = FRAC_2_PI * (PI / 3.0 - 3f64.sqrt() / 4.0);
        assert!((diffraction_limit(0.5) - half).abs() < 1e-15);
        // Slope at zero: −4/π.
        assert!(((diffraction_limit(1e-6) - 1.0) / 1e-6 + 4.0 / PI).abs() < 1e-5);
    }

    #[test]
    fn the_defocus_integral_without_defocus_is_the_limit() {
        let table = out_of_focus(1e-9);
        for (i, a) in table.iter().enumerate() {
            let b = diffraction_limit(i as f64 / (table.len() - 1) as f64) as f32;
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }

    #[test]
    fn strong_defocus_tends_to_the_geometrical_disc() {
        // A disc of radius 4 N W₂₀ has the transfer function 2 J₁(z) / z with z = 2π f r = 8π W ν; its first
        // zero is at 3.8317.
        let waves = 30.0;
        let t = out_of_focus(waves);
        let zero = t.iter().position(|&v| v < 0.0).unwrap() as f64 / (t.len() - 1) as f64;
        assert!((8.0 * PI * waves * zero / 3.8317 - 1.0).abs() < 0.02, "{zero}");
    }
}
