//! The colour difference of CIE 1994.

/// ΔE*94 (CIE 116-1995) with the weights of graphic arts: K₁ = 0.045, K₂ = 0.015, k_L = k_C = k_H = 1. The
/// formula is not symmetric: the first colour is the standard.
#[inline(always)]
#[must_use]
pub fn delta_e_94(lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
    let (c1, c2) = (lab1[1].hypot(lab1[2]), lab2[1].hypot(lab2[2]));
    let (dl, da, db) = (lab1[0] - lab2[0], lab1[1] - lab2[1], lab1[2] - lab2[2]);
    let dc = c1 - c2;
    let dh2 = (da * da + db * db - dc * dc).max(0.0);
    let (sc, sh) = (1.0 + 0.045 * c1, 1.0 + 0.015 * c1);
    (dl * dl + (dc / sc).powi(2) + dh2 / (sh * sh)).sqrt()
}
