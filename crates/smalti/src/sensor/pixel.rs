//! The pixel: geometry, well, conversion to volts, dark current, read noise.

use super::SensorError;
use crate::numeric::require;
use crate::spectrum::units::{BOLTZMANN_J_PER_K, ELECTRON_C};

/// One pixel, equal over the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Pixel pitch, m, equal in both directions, 1 nm to 1 cm.
    pub pitch_m: f64,
    /// Area of the photodetector as a fraction of the pixel, above 0 and at most 1. The photodetector is a
    /// square at the centre of the pixel.
    pub fill_factor: f64,
    /// Conversion gain, volts per electron.
    pub conversion_gain_v_per_e: f64,
    /// Volts at which the signal chain saturates, after the analog gain; the range of the converter.
    pub voltage_swing_v: f64,
    /// Full-well capacity, electrons.
    pub full_well_e: f64,
    /// Dark signal, V/s, at the reference temperature. It has its own shot noise.
    pub dark_voltage_v_per_s: f64,
    /// Standard deviation of the read noise, V, before the analog gain.
    pub read_noise_v: f64,
}

impl Pixel {
    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), SensorError> {
        // The bounds are far outside real devices; they prevent overflow of single precision.
        let within = |name: &str, value: f64, low: f64, high: f64, expected| {
            require((low..=high).contains(&value), name, value, expected)
        };
        let fill_factor_ok = self.fill_factor > 0.0 && self.fill_factor <= 1.0;
        within("pitch_m", self.pitch_m, 1e-9, 1e-2, "1e-9 to 1e-2 m")?;
        require(fill_factor_ok, "fill_factor", self.fill_factor, "more than 0 and at most 1")?;
        within("conversion_gain_v_per_e", self.conversion_gain_v_per_e, 1e-12, 1.0, "1e-12 to 1 V")?;
        within("voltage_swing_v", self.voltage_swing_v, 1e-6, 1e3, "1e-6 to 1e3 V")?;
        within("full_well_e", self.full_well_e, 1.0, 1e12, "1 to 1e12 electrons")?;
        within("dark_voltage_v_per_s", self.dark_voltage_v_per_s, 0.0, 1e3, "0 to 1e3 V/s")?;
        Ok(within("read_noise_v", self.read_noise_v, 0.0, 1e3, "0 to 1e3 V")?)
    }

    /// Area of the photodetector, m².
    #[must_use]
    pub fn photodetector_area_m2(&self) -> f64 {
        self.fill_factor * self.pitch_m * self.pitch_m
    }
}

/// Dependence of dark current on temperature. The pixel's dark voltage applies at `reference_k`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DarkCurrentTemperature {
    /// Thermal activation, `exp(−E/k · (1/T − 1/T₀))` ([widenhorn2002]). E is near 1.1 eV (the band gap)
    /// where diffusion dominates, and near 0.55 eV (half of it) where generation in the depletion region
    /// dominates.
    ///
    /// [widenhorn2002]: https://doi.org/10.1117/12.463446
    Activation {
        /// Temperature of the sensor, K.
        temperature_k: f64,
        /// Temperature at which the dark voltage was measured, K.
        reference_k: f64,
        /// Activation energy, eV.
        energy_ev: f64,
    },
    /// `2^((T − T₀)/ΔT)`, the doubling interval of EMVA standard 1288: typically 6–10 K.
    Doubling {
        /// Temperature of the sensor, K.
        temperature_k: f64,
        /// Temperature at which the dark voltage was measured, K.
        reference_k: f64,
        /// Rise in temperature that doubles the dark current, K.
        interval_k: f64,
    },
}

impl DarkCurrentTemperature {
    /// Dark current at the sensor's temperature, relative to that at the reference.
    ///
    /// # Errors
    /// When a temperature is not within 1–1000 K, an energy not within 0–5 eV, or an interval not above 0.1
    /// K.
    pub fn factor(&self) -> Result<f64, SensorError> {
        let check = |field: &str, value: f64, low: f64, high: f64, expected| {
            require((low..=high).contains(&value), field, value, expected).map(|()| value)
        };
        let kelvin = |field, value| check(field, value, 1.0, 1000.0, "1 to 1000 K");
        let factor = match *self {
            Self::Activation { temperature_k, reference_k, energy_ev } => {
                let (t, t0) = (kelvin("temperature_k", temperature_k)?, kelvin("reference_k", reference_k)?);
                let e = check("energy_ev", energy_ev, 0.0, 5.0, "0 to 5 eV")?;
                libm::exp(-e * ELECTRON_C / BOLTZMANN_J_PER_K * (1.0 / t - 1.0 / t0))
            }
            Self::Doubling { temperature_k, reference_k, interval_k } => {
                let (t, t0) = (kelvin("temperature_k", temperature_k)?, kelvin("reference_k", reference_k)?);
                libm::exp2((t - t0) / check("interval_k", interval_k, 0.1, 1000.0, "0.1 to 1000 K")?)
            }
        };
        // A reference near absolute zero would make the dark current unbounded.
        Ok(check("dark current relative to the reference", factor, 0.0, 1e12, "at most 1e12")?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_temperature_laws_do_what_they_say() {
        let doubled =
            DarkCurrentTemperature::Doubling { temperature_k: 308.0, reference_k: 300.0, interval_k: 8.0 };
        assert!((doubled.factor().unwrap() - 2.0).abs() < 1e-12);
        // Activation with half the band gap near room temperature doubles about every 10 K.
        let activated =
            DarkCurrentTemperature::Activation { temperature_k: 310.0, reference_k: 300.0, energy_ev: 0.56 };
        assert!((activated.factor().unwrap() - 2.01).abs() < 0.01);
    }

    #[test]
    fn impossible_temperatures_are_refused() {
        for t in [0.0, -3.0, f64::NAN, f64::INFINITY] {
            let law =
                DarkCurrentTemperature::Doubling { temperature_k: t, reference_k: 300.0, interval_k: 8.0 };
            assert!(matches!(law.factor(), Err(SensorError::Parameter(e)) if e.name == "temperature_k"));
        }
        let cold =
            DarkCurrentTemperature::Activation { temperature_k: 300.0, reference_k: 1.0, energy_ev: 1.1 };
        assert!(cold.factor().is_err());
    }
}
