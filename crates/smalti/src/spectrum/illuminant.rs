//! Light sources as relative spectral power.

use super::generated::{DAYLIGHT_BASIS, F2, F11, LED_B3};
use super::units::{BOLTZMANN_J_PER_K, LIGHT_M_PER_S, PLANCK_J_S, photons_per_joule};
use super::{Outside, Spectrum, SpectrumError, WavelengthGrid};

/// A light source. Its spectral power is relative; scenes set the luminance.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Illuminant {
    /// CIE standard illuminant A (ISO/CIE 11664-2), a Planckian radiator with c₂ = 1.435e-2 m K at 2848 K.
    A,
    /// Equal energy.
    E,
    /// CIE daylight of a correlated colour temperature, 4000–25000 K.
    Daylight {
        /// Correlated colour temperature, K.
        cct_k: f64,
    },
    /// CIE FL2, cool white fluorescent.
    F2,
    /// CIE FL11, narrow-band fluorescent.
    F11,
    /// CIE LED-B3, phosphor white LED near 4100 K.
    Led,
    /// Planckian radiator.
    Blackbody {
        /// Temperature, K.
        temperature_k: f64,
    },
    /// Measured relative power, energy units.
    Measured {
        /// What it is called.
        name: String,
        /// Relative spectral power.
        power: Spectrum,
    },
}

impl Illuminant {
    /// Daylight of 6504 K. The CIE names D-illuminants with the c₂ of 1931; D65 is 6500 K × 1.4388/1.4380.
    pub const D65: Self = Self::Daylight { cct_k: 6500.0 * 1.4388 / 1.4380 };

    /// Relative spectral power per nm, 100 at 560 nm where the source is defined by a formula.
    ///
    /// # Errors
    /// When a temperature is out of range, or tabulated data do not cover the grid.
    pub fn energy(&self, grid: WavelengthGrid) -> Result<Spectrum, SpectrumError> {
        match self {
            Self::A => Ok(planck_relative(grid, 2848.0, 1.435e-2)),
            Self::E => Ok(Spectrum::constant(grid, 100.0)),
            Self::Daylight { cct_k } => daylight(grid, *cct_k),
            Self::F2 => F2.spectrum(0, grid, Outside::Error),
            Self::F11 => F11.spectrum(0, grid, Outside::Error),
            Self::Led => LED_B3.spectrum(0, grid, Outside::Error),
            Self::Blackbody { temperature_k } => {
                if !(temperature_k.is_finite() && *temperature_k >= 100.0) {
                    return Err(SpectrumError::Parameter {
                        name: "temperature_k",
                        value: *temperature_k,
                        expected: "at least 100 K",
                    });
                }
                Ok(planck_relative(grid, *temperature_k, PLANCK_J_S * LIGHT_M_PER_S / BOLTZMANN_J_PER_K))
            }
            Self::Measured { power, .. } => power.resampled(grid, Outside::Error),
        }
    }

    /// Relative photons per nm: [`Illuminant::energy`] times wavelength, up to a constant.
    ///
    /// # Errors
    /// As [`Illuminant::energy`].
    pub fn photons(&self, grid: WavelengthGrid) -> Result<Spectrum, SpectrumError> {
        Ok(self.energy(grid)?.map(|nm, v| v * photons_per_joule(nm)))
    }
}

/// Planck's law scaled to 100 at 560 nm.
fn planck_relative(grid: WavelengthGrid, temperature_k: f64, c2_m_k: f64) -> Spectrum {
    let exponent = |nm: f64| c2_m_k / (nm * 1e-9 * temperature_k);
    let at_560 = exponent(560.0).exp_m1();
    Spectrum::from_fn(grid, |nm| 100.0 * (560.0 / nm).powi(5) * (at_560 / exponent(nm).exp_m1()))
}

/// CIE daylight, CIE 15:2018 section 4.1.2.
fn daylight(grid: WavelengthGrid, cct_k: f64) -> Result<Spectrum, SpectrumError> {
    let t = cct_k;
    let x = if (4000.0..=7000.0).contains(&t) {
        0.244063 + 0.09911e3 / t + 2.9678e6 / (t * t) - 4.6070e9 / (t * t * t)
    } else if t > 7000.0 && t <= 25000.0 {
        0.237040 + 0.24748e3 / t + 1.9018e6 / (t * t) - 2.0064e9 / (t * t * t)
    } else {
        return Err(SpectrumError::Parameter {
            name: "cct_k",
            value: t,
            expected: "4000 to 25000 K for CIE daylight",
        });
    };
    let y = -3.000 * x * x + 2.870 * x - 0.275;
    // CIE 15 rounds M1 and M2 to three decimals; the tabulated D65 follows from that.
    let round = |v: f64| (v * 1000.0).round() / 1000.0;
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    let m1 = round((-1.3515 - 1.7703 * x + 5.9114 * y) / m);
    let m2 = round((0.0300 - 31.4424 * x + 30.0717 * y) / m);
    let s = |i| DAYLIGHT_BASIS.spectrum(i, grid, Outside::Error);
    let (s0, s1, s2) = (s(0)?, s(1)?, s(2)?);
    let values = (0..grid.len()).map(|i| s0.values()[i] + m1 * s1.values()[i] + m2 * s2.values()[i]);
    Spectrum::new(grid, values.map(|v| v.max(0.0)).collect())
}
