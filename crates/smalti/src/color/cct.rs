//! Correlated colour temperature as defined in CIE 15:2018, 9.5: the temperature of the Planckian radiator
//! nearest in the CIE 1960 (u, v) diagram.
//!
//! The search evaluates Planck's law itself, rather than a table of isotherms (Robertson 1968) or of the
//! locus (Ohno 2013). It yields the same quantities (CCT and signed D_uv) without interpolation error.

use thiserror::Error;

use super::cie1976::uv_from_xyz;
use crate::spectrum::{Illuminant, Observer, Spectrum, SpectrumError, WavelengthGrid};

/// Correlated colour temperature and distance from the Planckian locus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cct {
    /// Correlated colour temperature, K.
    pub cct_k: f64,
    /// Distance in CIE 1960 u, v; positive above the locus (towards green).
    pub duv: f64,
}

/// Errors of a correlated colour temperature.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CctError {
    /// Black, or not finite.
    #[error("X, Y, Z = {0:?} have no chromaticity")]
    NoChromaticity([f64; 3]),
    /// The colour is too far from the locus for a correlated colour temperature (CIE 15: |D_uv| ≤ 0.05), or
    /// outside 1000–100 000 K.
    #[error(
        "the colour is {duv:.4} from the Planckian locus at {cct_k:.0} K; a correlated colour temperature needs at most 0.05, and 1000 to 100000 K"
    )]
    FarFromLocus {
        /// Nearest temperature in the searched range, K.
        cct_k: f64,
        /// Distance in u, v.
        duv: f64,
    },
    /// The observer's data could not be computed.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}

/// The Planckian locus of an observer.
#[derive(Debug, Clone)]
pub struct PlanckianLocus {
    matching: [Spectrum; 3],
}

/// Range of the search in reciprocal temperature, mired (10⁶/K): 100 000 K to 1000 K.
const MIRED: (f64, f64) = (10.0, 1000.0);

impl PlanckianLocus {
    /// The locus of an observer, integrated over 360–830 nm in steps of 5 nm.
    ///
    /// # Errors
    /// Never for the observers of this crate.
    pub fn new(observer: Observer) -> Result<Self, SpectrumError> {
        let grid = WavelengthGrid::new(360.0, 5.0, 95)?;
        Ok(Self { matching: observer.matching_functions(grid)? })
    }

    /// CIE 1960 u, v of the Planckian radiator at a temperature from 100 K.
    ///
    /// # Errors
    /// When the temperature is out of range.
    pub fn uv(&self, temperature_k: f64) -> Result<[f64; 2], CctError> {
        let grid = self.matching[0].grid();
        let power = Illuminant::Blackbody { temperature_k }.energy(grid)?;
        let dot = |m: &Spectrum| m.values().iter().zip(power.values()).map(|(a, b)| a * b).sum::<f64>();
        let xyz = [dot(&self.matching[0]), dot(&self.matching[1]), dot(&self.matching[2])];
        uv_from_xyz(xyz).ok_or(CctError::NoChromaticity(xyz))
    }

    /// Correlated colour temperature and D_uv of tristimulus values, 1000–100 000 K.
    ///
    /// # Errors
    /// When the colour has no chromaticity, or lies too far from the locus.
    pub fn cct(&self, xyz: [f64; 3]) -> Result<Cct, CctError> {
        let [u, v] = uv_from_xyz(xyz).ok_or(CctError::NoChromaticity(xyz))?;
        let offset = |mired: f64| -> Result<[f64; 2], CctError> {
            let p = self.uv(1e6 / mired)?;
            Ok([u - p[0], v - p[1]])
        };
        let distance = |mired: f64| offset(mired).map(|d| d[0].hypot(d[1]));

        // Steps of 10 mired resolve the curvature of the locus; a golden-section search then refines the
        // bracket.
        let steps = ((MIRED.1 - MIRED.0) / 10.0) as usize;
        let mut best = (f64::INFINITY, MIRED.0);
        for i in 0..=steps {
            let mired = MIRED.0 + 10.0 * i as f64;
            let d = distance(mired)?;
            if d < best.0 {
                best = (d, mired);
            }
        }
        let (mut low, mut high) = ((best.1 - 10.0).max(MIRED.0), (best.1 + 10.0).min(MIRED.1));
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        while high - low > 1e-6 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if distance(a)? < distance(b)? {
                high = b;
            } else {
                low = a;
            }
        }
        let mired = 0.5 * (low + high);
        let d = offset(mired)?;
        let cct_k = 1e6 / mired;
        // Along the locus u increases with the reciprocal temperature; points to the left of this direction
        // lie above it.
        let (ahead, behind) = (self.uv(1e6 / (mired + 0.1))?, self.uv(1e6 / (mired - 0.1))?);
        let along = [ahead[0] - behind[0], ahead[1] - behind[1]];
        let duv = d[0].hypot(d[1]) * (along[0] * d[1] - along[1] * d[0]).signum();
        let at_an_end = mired - MIRED.0 < 1e-4 || MIRED.1 - mired < 1e-4;
        if duv.abs() > 0.05 || at_an_end {
            return Err(CctError::FarFromLocus { cct_k, duv });
        }
        Ok(Cct { cct_k, duv })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::cie1976::xyz_from_xy;

    fn locus() -> PlanckianLocus {
        PlanckianLocus::new(Observer::Cie1931).unwrap()
    }

    #[test]
    fn a_blackbody_has_its_own_temperature() {
        let grid = WavelengthGrid::new(360.0, 5.0, 95).unwrap();
        for temperature_k in [1200.0, 2856.0, 5000.0, 6504.0, 20_000.0, 60_000.0] {
            let light = Illuminant::Blackbody { temperature_k }.photons(grid).unwrap();
            let got = locus().cct(Observer::Cie1931.xyz_from_photons(&light).unwrap()).unwrap();
            assert!((got.cct_k / temperature_k - 1.0).abs() < 1e-6 && got.duv.abs() < 1e-9, "{got:?}");
        }
    }

    /// CIE daylight lies 0.003 above the locus; the formula recovers its nominal temperature to a few kelvin.
    #[test]
    fn daylight_has_the_temperature_it_is_named_by() {
        let grid = WavelengthGrid::new(360.0, 5.0, 95).unwrap();
        for cct_k in [4000.0, 5003.0, 6504.0, 7504.0, 12_000.0, 25_000.0] {
            let light = Illuminant::Daylight { cct_k }.photons(grid).unwrap();
            let got = locus().cct(Observer::Cie1931.xyz_from_photons(&light).unwrap()).unwrap();
            assert!((got.cct_k / cct_k - 1.0).abs() < 2e-3, "{cct_k}: {got:?}");
            assert!((0.0015..0.0045).contains(&got.duv), "{cct_k}: {got:?}");
        }
    }

    /// Expected: colour-science 0.4.7, `uv_to_CCT_Ohno2013`, which interpolates a table: 1e-3 in temperature.
    #[test]
    fn agrees_with_ohno_2013() {
        for (xy, cct_k, duv) in [
            ([0.4578, 0.4101], 2725.109, -0.0000096),
            ([0.31271, 0.32902], 6503.622, 0.003212),
            ([0.3, 0.3], 7739.124, -0.005345),
            ([0.45, 0.42], 2916.818, 0.004492),
            ([0.26, 0.27], 15345.232, 0.003956),
        ] {
            let got = locus().cct(xyz_from_xy(xy, 1.0).unwrap()).unwrap();
            assert!((got.cct_k / cct_k - 1.0).abs() < 1e-3, "{xy:?}: {got:?}, not {cct_k}");
            assert!((got.duv - duv).abs() < 1e-5, "{xy:?}: {got:?}, not {duv}");
        }
    }

    #[test]
    fn saturated_colours_have_none() {
        assert!(matches!(locus().cct([0.0; 3]), Err(CctError::NoChromaticity(_))));
        for xy in [[0.15, 0.06], [0.3, 0.6], [0.7, 0.3]] {
            let xyz = xyz_from_xy(xy, 1.0).unwrap();
            assert!(matches!(locus().cct(xyz), Err(CctError::FarFromLocus { .. })), "{xy:?}");
        }
    }

    /// Beyond either end of the range, the nearest temperature is that of the end, and no colour temperature.
    #[test]
    fn temperatures_beyond_the_range_are_refused() {
        let grid = WavelengthGrid::new(360.0, 5.0, 95).unwrap();
        for (temperature_k, end_k) in [(980.0, 1000.0), (130_000.0, 100_000.0)] {
            let light = Illuminant::Blackbody { temperature_k }.photons(grid).unwrap();
            let xyz = Observer::Cie1931.xyz_from_photons(&light).unwrap();
            let Err(CctError::FarFromLocus { cct_k, duv }) = locus().cct(xyz) else {
                panic!("{temperature_k} K is accepted");
            };
            assert!((cct_k / end_k - 1.0).abs() < 1e-4 && duv.abs() < 0.05, "{cct_k} K, {duv}");
        }
    }
}
