//! CIEDE2000 (ISO/CIE 11664-6), in the notation of Sharma, Wu and Dalal (2005), "The CIEDE2000 color-difference
//! formula: implementation notes, supplementary test data, and mathematical observations", *Color Res. Appl.* 30.

/// ΔE₀₀ with k_L = k_C = k_H = 1.
#[must_use]
pub fn delta_e_2000(lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
    const POW25_7: f64 = 6_103_515_625.0;
    let ([l1, a1, b1], [l2, a2, b2]) = (lab1, lab2);

    let c_mean = (a1.hypot(b1) + a2.hypot(b2)) / 2.0;
    let c_mean7 = c_mean.powi(7);
    // The share a′ takes of a near the neutral axis; 1 − √(…) keeps far from it.
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
