//! Filters as they leave a factory: thicker or thinner, and shifted.

use serde::{Deserialize, Serialize};

use crate::design::error::DesignError;
use crate::numeric::normal::normal_pair;
use crate::numeric::philox::Stream;
use crate::spectrum::WavelengthGrid;

/// Purpose of the random numbers.
const PURPOSE: u32 = 0x0044_5354;
/// Thinnest filter, relative to the one that was wanted.
const MIN_THICKNESS: f64 = 0.1;
/// Transmittance below which a filter is opaque, so that its derivative stays finite.
const OPAQUE: f64 = 1e-9;

/// `tolerance` of a design: how filters differ from those that were wanted. With a tolerance, the expected cost over the spread is
/// minimised. Every filter of an array differs on its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Tolerance {
    /// Standard deviation of the thickness, relative to it, 0 to 0.5. A filter of relative thickness d transmits Tᵈ.
    pub thickness: f64,
    /// Standard deviation of a shift along the wavelengths, nm, 0 to 50.
    pub shift_nm: f64,
    /// Number of arrays that the mean is taken over, 2 to 1000. Every second one has the opposite deviations of the one before it.
    pub draws: usize,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { thickness: 0.0, shift_nm: 0.0, draws: 8 }
    }
}

/// The deviation of one filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Thickness relative to the one that was wanted, above 0.
    pub thickness: f64,
    /// Shift toward longer wavelengths, nm.
    pub shift_nm: f64,
}

impl Deviation {
    /// No deviation.
    pub const NONE: Self = Self { thickness: 1.0, shift_nm: 0.0 };
}

impl Tolerance {
    /// Checks every field.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the first field that is out of its range.
    pub fn validate(&self) -> Result<(), DesignError> {
        let range = |key: &str, fits: bool, found: f64, expected: &str| {
            let key = format!("tolerance.{key}");
            if fits { Ok(()) } else { Err(DesignError::key(key, format!("{found}; expected {expected}"))) }
        };
        range("thickness", (0.0..=0.5).contains(&self.thickness), self.thickness, "0 to 0.5")?;
        range("shift_nm", (0.0..=50.0).contains(&self.shift_nm), self.shift_nm, "0 to 50 nm")?;
        range("draws", (2..=1000).contains(&self.draws), self.draws as f64, "2 to 1000")
    }

    /// The deviations of the filters of each array that is drawn; a single array without deviation when nothing deviates.
    #[must_use]
    pub fn draws(&self, filters: usize, seed: u64) -> Vec<Vec<Deviation>> {
        if self.thickness <= 0.0 && self.shift_nm <= 0.0 {
            return vec![vec![Deviation::NONE; filters]];
        }
        let array = |draw: usize| {
            let mut random = Stream::new(seed, PURPOSE, (draw / 2) as u32);
            let sign = if draw.is_multiple_of(2) { 1.0 } else { -1.0 };
            let filter = |_| {
                let (a, b) = normal_pair(random.next_u32(), random.next_u32());
                let thickness = 1.0 + sign * self.thickness * f64::from(a);
                let shift_nm = sign * self.shift_nm * f64::from(b);
                Deviation { thickness: thickness.max(MIN_THICKNESS), shift_nm }
            };
            (0..filters).map(filter).collect()
        };
        (0..self.draws).map(array).collect()
    }
}

impl Deviation {
    /// The transmittance of the filter that deviates. Beyond the ends of the grid, it is that of the ends.
    #[must_use]
    pub fn apply(&self, transmittance: &[f64], grid: WavelengthGrid) -> Vec<f64> {
        if *self == Self::NONE {
            return transmittance.to_vec();
        }
        let at = |i: usize| {
            let (low, high, share) = self.source(i, transmittance.len(), grid);
            transmittance[low] * (1.0 - share) + transmittance[high] * share
        };
        (0..transmittance.len()).map(|i| libm::pow(at(i).max(OPAQUE), self.thickness)).collect()
    }

    /// The derivative with respect to the transmittance that was wanted, from that with respect to [`Deviation::apply`].
    #[must_use]
    pub fn by_wanted(&self, transmittance: &[f64], by_deviating: &[f64], grid: WavelengthGrid) -> Vec<f64> {
        if *self == Self::NONE {
            return by_deviating.to_vec();
        }
        let mut by_wanted = vec![0.0; transmittance.len()];
        for (i, g) in by_deviating.iter().enumerate() {
            let (low, high, share) = self.source(i, transmittance.len(), grid);
            let shifted = transmittance[low] * (1.0 - share) + transmittance[high] * share;
            if shifted <= OPAQUE {
                continue;
            }
            let slope = g * self.thickness * libm::pow(shifted, self.thickness - 1.0);
            by_wanted[low] += slope * (1.0 - share);
            by_wanted[high] += slope * share;
        }
        by_wanted
    }

    /// The two wavelengths whose transmittances meet at wavelength `i`, and the share of the second.
    fn source(&self, i: usize, count: usize, grid: WavelengthGrid) -> (usize, usize, f64) {
        let last = count.saturating_sub(1);
        let place = (i as f64 - self.shift_nm / grid.step_nm()).clamp(0.0, last as f64);
        let low = (place as usize).min(last);
        (low, (low + 1).min(last), place - low as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

    fn curve() -> Vec<f64> {
        (0..31).map(|i| 0.5 + 0.4 * (f64::from(i) * 0.4).sin()).collect()
    }

    #[test]
    fn a_shift_moves_and_a_thickness_is_a_power() {
        let moved = Deviation { thickness: 1.0, shift_nm: 20.0 }.apply(&curve(), GRID);
        assert!((moved[10] - curve()[8]).abs() < 1e-12 && (moved[0] - curve()[0]).abs() < 1e-12);
        let thick = Deviation { thickness: 2.0, shift_nm: 0.0 }.apply(&curve(), GRID);
        assert!((thick[10] - curve()[10].powi(2)).abs() < 1e-12);
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let deviation = Deviation { thickness: 0.9, shift_nm: -7.0 };
        let weights: Vec<f64> = (0..31).map(|i| f64::from(i % 5) - 2.0).collect();
        let value =
            |t: &[f64]| -> f64 { deviation.apply(t, GRID).iter().zip(&weights).map(|(t, w)| t * w).sum() };
        let derivative = deviation.by_wanted(&curve(), &weights, GRID);
        for at in 0..31 {
            let moved = |by: f64| {
                let mut t = curve();
                t[at] += by;
                value(&t)
            };
            let found = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((found - derivative[at]).abs() < 1e-7, "{at}: {found} {}", derivative[at]);
        }
    }

    #[test]
    fn draws_have_no_mean_and_the_stated_spread() {
        let tolerance = Tolerance { thickness: 0.05, shift_nm: 3.0, draws: 1000 };
        let draws = tolerance.draws(4, 1);
        let all: Vec<Deviation> = draws.into_iter().flatten().collect();
        let mean = |of: &dyn Fn(&Deviation) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        assert!((mean(&|d| d.thickness) - 1.0).abs() < 1e-12 && mean(&|d| d.shift_nm).abs() < 1e-12);
        let spread = mean(&|d| d.shift_nm * d.shift_nm).sqrt();
        assert!((spread - 3.0).abs() < 0.2, "{spread}");
        assert_eq!(Tolerance::default().draws(3, 1), [vec![Deviation::NONE; 3]]);
    }
}
