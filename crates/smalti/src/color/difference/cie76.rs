//! The colour difference of CIE 1976.

/// ΔE*ab: the Euclidean distance in CIELAB (ISO/CIE 11664-4).
#[inline(always)]
#[must_use]
pub fn delta_e_76(lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
    (0..3).map(|i| (lab1[i] - lab2[i]).powi(2)).sum::<f64>().sqrt()
}
