//! What production changes about filters.

use serde::{Deserialize, Serialize};

use crate::camera::{Camera, CameraError};
use crate::sensor::{Cfa, Channel};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Share of the clear transmittance below which a filter is opaque.
const OPAQUE: f64 = 1e-9;

/// A deviation of filters from their design.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Deviation {
    /// Shift of the transmittance towards longer wavelengths, nm. Beyond the ends of the grid, transmittances are those of the ends.
    pub shift_nm: f64,
    /// Thickness of the filter relative to its design: its absorbance changes in proportion (Beer–Lambert law).
    pub thickness: f64,
}

impl Deviation {
    /// No deviation.
    pub const NONE: Self = Self { shift_nm: 0.0, thickness: 1.0 };

    /// A shift alone.
    #[must_use]
    pub fn shift(shift_nm: f64) -> Self {
        Self { shift_nm, ..Self::NONE }
    }

    /// Another thickness alone.
    #[must_use]
    pub fn thickness(thickness: f64) -> Self {
        Self { thickness, ..Self::NONE }
    }

    /// The transmittance of a filter with the deviation. `clear` is the transmittance without any absorbance, at least the largest of the filter.
    ///
    /// # Errors
    /// Never for finite deviations.
    pub fn of(&self, transmittance: &Spectrum, clear: f64) -> Result<Spectrum, CameraError> {
        let clear = clear.max(transmittance.max());
        Ok(Spectrum::new(
            transmittance.grid(),
            self.apply(transmittance.values(), transmittance.grid(), clear),
        )?)
    }

    /// [`Deviation::of`] for the values on a grid.
    #[must_use]
    pub fn apply(&self, transmittance: &[f64], grid: WavelengthGrid, clear: f64) -> Vec<f64> {
        if *self == Self::NONE {
            return transmittance.to_vec();
        }
        let at = |i: usize| {
            let t = self.shifted(transmittance, grid, i);
            if clear > 0.0 { clear * libm::pow((t / clear).clamp(0.0, 1.0), self.thickness) } else { t }
        };
        (0..transmittance.len()).map(at).collect()
    }

    /// The derivative with respect to the transmittance that was wanted, from that with respect to [`Deviation::apply`].
    #[must_use]
    pub fn by_wanted(
        &self,
        transmittance: &[f64],
        by_deviating: &[f64],
        grid: WavelengthGrid,
        clear: f64,
    ) -> Vec<f64> {
        if *self == Self::NONE {
            return by_deviating.to_vec();
        }
        let mut by_wanted = vec![0.0; transmittance.len()];
        for (i, g) in by_deviating.iter().enumerate() {
            let share = self.shifted(transmittance, grid, i) / clear;
            // An opaque filter stays opaque.
            if share <= OPAQUE {
                continue;
            }
            let slope = g * self.thickness * libm::pow(share, self.thickness - 1.0);
            let (low, high, weight) = self.source(i, transmittance.len(), grid);
            by_wanted[low] += slope * (1.0 - weight);
            by_wanted[high] += slope * weight;
        }
        by_wanted
    }

    /// The transmittance that the shift brings to wavelength `i`.
    fn shifted(&self, transmittance: &[f64], grid: WavelengthGrid, i: usize) -> f64 {
        let (low, high, weight) = self.source(i, transmittance.len(), grid);
        transmittance[low] + weight * (transmittance[high] - transmittance[low])
    }

    /// The two wavelengths whose transmittances meet at wavelength `i`, and the weight of the second.
    fn source(&self, i: usize, count: usize, grid: WavelengthGrid) -> (usize, usize, f64) {
        let last = count.saturating_sub(1);
        let place = (i as f64 - self.shift_nm / grid.step_nm()).clamp(0.0, last as f64);
        let low = (place as usize).min(last.saturating_sub(1));
        (low, (low + 1).min(last), place - low as f64)
    }

    /// A camera all of whose filters have the deviation.
    ///
    /// # Errors
    /// As [`Deviation::of`].
    pub fn of_camera(&self, camera: &Camera, clear: f64) -> Result<Camera, CameraError> {
        let cfa = &camera.sensor.cfa;
        let channel = |c: &Channel| {
            Ok(Channel { name: c.name.clone(), transmittance: self.of(&c.transmittance, clear)? })
        };
        let channels = cfa.channels().iter().map(channel).collect::<Result<_, CameraError>>()?;
        Ok(camera.with_cfa(Cfa::new(cfa.name(), cfa.mosaic().clone(), channels)?))
    }
}

impl std::fmt::Display for Deviation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let signed = |v: f64, unit: &str| {
            let sign = if v < 0.0 { "−" } else { "+" };
            format!("{sign}{}{unit}", (v.abs() * 1e6).round() / 1e6)
        };
        let percent = 100.0 * (self.thickness - 1.0);
        match (self.shift_nm == 0.0, percent == 0.0) {
            (true, true) => f.write_str("as designed"),
            (false, true) => f.write_str(&signed(self.shift_nm, " nm")),
            (true, false) => write!(f, "thickness {}", signed(percent, " %")),
            (false, false) => {
                write!(f, "{}, thickness {}", signed(self.shift_nm, " nm"), signed(percent, " %"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    fn ramp() -> Spectrum {
        let grid = WavelengthGrid::VISIBLE;
        Spectrum::new(grid, (0..grid.len()).map(|i| 0.9 * i as f64 / 30.0).collect()).unwrap()
    }

    #[test]
    fn a_shift_moves_a_curve_to_longer_wavelengths() {
        let moved = Deviation::shift(5.0).of(&ramp(), 0.95).unwrap();
        // The step is 10 nm and the slope 0.03 per step.
        assert!((moved.values()[10] - (0.9 * 9.5 / 30.0)).abs() < 1e-12);
        assert_eq!(moved.values()[0], 0.0);
        let back = Deviation::shift(-5.0).of(&ramp(), 0.95).unwrap();
        assert!(
            (back.values()[30] - 0.9).abs() < 1e-12 && (back.values()[10] - 0.9 * 10.5 / 30.0).abs() < 1e-12
        );
    }

    #[test]
    fn twice_the_thickness_has_twice_the_absorbance() {
        let thick = Deviation::thickness(2.0).of(&ramp(), 0.95).unwrap();
        for (t, thin) in thick.values().iter().zip(ramp().values()) {
            assert!((t / 0.95 - (thin / 0.95).powi(2)).abs() < 1e-12);
        }
        assert_eq!(Deviation::NONE.of(&ramp(), 0.95).unwrap().values()[30], 0.9);
        // The clear part of a filter stays.
        assert!((Deviation::thickness(2.0).of(&ramp(), 0.9).unwrap().values()[30] - 0.9).abs() < 1e-12);
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let deviation = Deviation { thickness: 0.9, shift_nm: -7.0 };
        let curve: Vec<f64> = (0..31).map(|i| 0.5 + 0.4 * (f64::from(i) * 0.4).sin()).collect();
        let weights: Vec<f64> = (0..31).map(|i| f64::from(i % 5) - 2.0).collect();
        let grid = WavelengthGrid::VISIBLE;
        let value = |t: &[f64]| -> f64 {
            deviation.apply(t, grid, 0.95).iter().zip(&weights).map(|(t, w)| t * w).sum()
        };
        let derivative = deviation.by_wanted(&curve, &weights, grid, 0.95);
        for at in 0..31 {
            let moved = |by: f64| {
                let mut t = curve.clone();
                t[at] += by;
                value(&t)
            };
            let found = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((found - derivative[at]).abs() < 1e-7, "{at}: {found} {}", derivative[at]);
        }
    }

    #[test]
    fn deviations_are_stated_with_their_units() {
        let all =
            [Deviation::NONE, Deviation::shift(-5.0), Deviation::thickness(1.05)].map(|d| d.to_string());
        assert_eq!(all, ["as designed", "−5 nm", "thickness +5 %"]);
        let both = [(0.95, 2.5), (1.1, -0.25)].map(|(thickness, shift_nm)| Deviation { thickness, shift_nm });
        let both = both.map(|d| d.to_string());
        assert_eq!(both, ["+2.5 nm, thickness −5 %", "−0.25 nm, thickness +10 %"]);
    }
}
