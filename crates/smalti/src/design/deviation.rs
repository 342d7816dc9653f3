//! What production changes about filters.

use serde::{Deserialize, Serialize};

use crate::camera::{Camera, CameraError};
use crate::sensor::{Cfa, Channel};
use crate::spectrum::Spectrum;

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

    /// The transmittance of a filter with the deviation. `clear` is the transmittance without any absorbance; without it, that is the
    /// largest transmittance of the filter.
    ///
    /// # Errors
    /// Never for finite deviations.
    pub fn of(&self, transmittance: &Spectrum, clear: Option<f64>) -> Result<Spectrum, CameraError> {
        let grid = transmittance.grid();
        let clear = clear.unwrap_or(transmittance.max()).max(transmittance.max());
        let values = transmittance.values();
        let last = values.len().saturating_sub(1);
        let at = |i: usize| {
            let place = (i as f64 - self.shift_nm / grid.step_nm()).clamp(0.0, last as f64);
            let before = (place as usize).min(last.saturating_sub(1));
            let after = (before + 1).min(last);
            let t = values[before] + (place - before as f64) * (values[after] - values[before]);
            if clear > 0.0 { clear * libm::pow((t / clear).clamp(0.0, 1.0), self.thickness) } else { t }
        };
        Ok(Spectrum::new(grid, (0..values.len()).map(at).collect())?)
    }

    /// A camera all of whose filters have the deviation.
    ///
    /// # Errors
    /// As [`Deviation::of`].
    pub fn of_camera(&self, camera: &Camera, clear: Option<f64>) -> Result<Camera, CameraError> {
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
    use crate::spectrum::WavelengthGrid;

    fn ramp() -> Spectrum {
        let grid = WavelengthGrid::VISIBLE;
        Spectrum::new(grid, (0..grid.len()).map(|i| 0.9 * i as f64 / 30.0).collect()).unwrap()
    }

    #[test]
    fn a_shift_moves_a_curve_to_longer_wavelengths() {
        let moved = Deviation::shift(5.0).of(&ramp(), None).unwrap();
        // The step is 10 nm and the slope 0.03 per step.
        assert!((moved.values()[10] - (0.9 * 9.5 / 30.0)).abs() < 1e-12);
        assert_eq!(moved.values()[0], 0.0);
        let back = Deviation::shift(-5.0).of(&ramp(), None).unwrap();
        assert!(
            (back.values()[30] - 0.9).abs() < 1e-12 && (back.values()[10] - 0.9 * 10.5 / 30.0).abs() < 1e-12
        );
    }

    #[test]
    fn twice_the_thickness_has_twice_the_absorbance() {
        let thick = Deviation::thickness(2.0).of(&ramp(), Some(0.95)).unwrap();
        for (t, thin) in thick.values().iter().zip(ramp().values()) {
            assert!((t / 0.95 - (thin / 0.95).powi(2)).abs() < 1e-12);
        }
        assert_eq!(Deviation::NONE.of(&ramp(), Some(0.95)).unwrap().values()[30], 0.9);
        // Relative to its own largest transmittance, that stays.
        assert!((Deviation::thickness(2.0).of(&ramp(), None).unwrap().values()[30] - 0.9).abs() < 1e-12);
    }

    #[test]
    fn deviations_are_stated_with_their_units() {
        let all =
            [Deviation::NONE, Deviation::shift(-5.0), Deviation::thickness(1.05)].map(|d| d.to_string());
        assert_eq!(all, ["as designed", "−5 nm", "thickness +5 %"]);
    }
}
