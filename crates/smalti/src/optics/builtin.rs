//! Analytic filters in front of the sensor.

use crate::spectrum::{Spectrum, SpectrumError, WavelengthGrid};

/// An infrared-cut filter for a colour sensor. It passes visible light, with a transmittance of one half at 650 nm and a width
/// (90 % to 10 %) of 30 nm. The edge is a logistic curve, which that of an interference or absorption filter resembles:
/// T(λ) = 1 / (1 + exp((λ − λ₀) / w)), whose width is 2 ln 9 · w.
///
/// # Errors
/// Never, because the curve is finite at every wavelength.
pub fn ir_cut(grid: WavelengthGrid) -> Result<Spectrum, SpectrumError> {
    let w = 30.0 / (2.0 * 9f64.ln());
    Spectrum::from_fn(grid, |nm| 1.0 / (1.0 + ((nm - 650.0) / w).exp()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_where_they_say() {
        let grid = WavelengthGrid::new(400.0, 5.0, 121).unwrap();
        let t = ir_cut(grid).unwrap();
        for (nm, want) in [(650.0, 0.5), (635.0, 0.9), (665.0, 0.1), (450.0, 1.0), (900.0, 0.0)] {
            assert!((t.at(nm).unwrap() - want).abs() < 1e-6);
        }
    }
}
