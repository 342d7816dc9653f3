//! Analytic filters in front of the sensor.
//!
//! The edges of interference and absorption filters resemble a logistic curve: T(λ) = 1 / (1 + exp(±(λ − λ₀)
//! / w)), with a transmittance of one half at the edge λ₀. The width is the distance between 10 % and 90 %, 2
//! ln 9 · w.

use super::error::{OpticsError, require};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// An infrared-cut filter for a colour sensor. It passes visible light, with a transmittance of one half at
/// 650 nm and a width (90 % to 10 %) of 30 nm.
#[must_use]
pub fn ir_cut(grid: WavelengthGrid) -> Spectrum {
    edge(grid, 650.0, 30.0, 1.0)
}

/// A filter that passes wavelengths below `edge_nm`; its transmittance falls from 90 % to 10 % within
/// `width_nm`.
///
/// # Errors
/// When a parameter is not positive and finite.
pub fn short_pass(grid: WavelengthGrid, edge_nm: f64, width_nm: f64) -> Result<Spectrum, OpticsError> {
    check(edge_nm, width_nm)?;
    Ok(edge(grid, edge_nm, width_nm, 1.0))
}

/// A filter that passes wavelengths above `edge_nm`; its transmittance rises from 10 % to 90 % within
/// `width_nm`.
///
/// # Errors
/// When a parameter is not positive and finite.
pub fn long_pass(grid: WavelengthGrid, edge_nm: f64, width_nm: f64) -> Result<Spectrum, OpticsError> {
    check(edge_nm, width_nm)?;
    Ok(edge(grid, edge_nm, width_nm, -1.0))
}

fn check(edge_nm: f64, width_nm: f64) -> Result<(), OpticsError> {
    require(edge_nm > 0.0, "edge_nm", edge_nm, "more than 0")?;
    require(width_nm > 0.0, "width_nm", width_nm, "more than 0")
}

fn edge(grid: WavelengthGrid, edge_nm: f64, width_nm: f64, sign: f64) -> Spectrum {
    let w = width_nm / (2.0 * 9f64.ln());
    Spectrum::from_fn(grid, |nm| 1.0 / (1.0 + (sign * (nm - edge_nm) / w).exp()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_where_they_say() {
        let grid = WavelengthGrid::new(400.0, 5.0, 121).unwrap();
        let t = ir_cut(grid);
        for (nm, want) in [(650.0, 0.5), (635.0, 0.9), (665.0, 0.1), (450.0, 1.0), (900.0, 0.0)] {
            assert!((t.at(nm).unwrap() - want).abs() < 1e-6);
        }
        let (s, l) = (short_pass(grid, 700.0, 20.0).unwrap(), long_pass(grid, 700.0, 20.0).unwrap());
        assert!(s.values().iter().zip(l.values()).all(|(a, b)| (a + b - 1.0).abs() < 1e-12));
        assert!(long_pass(grid, f64::NAN, 20.0).is_err() && short_pass(grid, 650.0, 0.0).is_err());
    }
}
