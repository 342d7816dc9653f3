//! Means over the width of a pixel.

/// Mean of `f` over `i..i+1` by two panels of five-point Gauss-Legendre quadrature. For a wave of two cycles
/// per pixel, the highest frequency of the charts, the error is below 10⁻⁴; for half a cycle it is below
/// 10⁻¹⁰.
pub(super) fn mean_over_pixel(i: usize, f: impl Fn(f64) -> f64) -> f64 {
    let root = 2.0 * (10.0f64 / 7.0).sqrt();
    let (near, far) = ((5.0 - root).sqrt() / 3.0, (5.0 + root).sqrt() / 3.0);
    let spread = 13.0 * 70.0f64.sqrt();
    let (w_near, w_far) = ((322.0 + spread) / 900.0, (322.0 - spread) / 900.0);
    let nodes = [(0.0, 128.0 / 225.0), (-near, w_near), (near, w_near), (-far, w_far), (far, w_far)];
    // Each panel is half a pixel wide; the weights of one sum to 2.
    let panel = |centre: f64| nodes.iter().map(|(x, w)| w * f(centre + x / 4.0)).sum::<f64>() / 4.0;
    panel(i as f64 + 0.25) + panel(i as f64 + 0.75)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn the_mean_of_a_wave_is_its_sinc() {
        for (frequency, tolerance) in [(0.5, 1e-10), (1.0, 1e-6), (2.0, 1e-4)] {
            let mean = mean_over_pixel(3, |x| (TAU * frequency * (x - 3.3)).cos());
            let x: f64 = PI * frequency;
            let expected = x.sin() / x * (TAU * frequency * 0.2).cos();
            assert!((mean - expected).abs() < tolerance, "{frequency}: {mean} {expected}");
        }
    }
}
