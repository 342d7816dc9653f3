//! Filters as they leave a factory: thicker or thinner, and shifted.

use serde::{Deserialize, Serialize};

use crate::design::deviation::Deviation;
use crate::design::error::DesignError;
use crate::numeric::normal::normal_pair;
use crate::numeric::philox::Stream;

/// Purpose of the random numbers.
const PURPOSE: u32 = 0x0044_5354;
/// Thinnest filter, relative to the one that was wanted.
const MIN_THICKNESS: f64 = 0.1;

/// `tolerance` of a design: how filters differ from those that were wanted. With a tolerance, the expected cost over the spread is
/// minimised. Every filter of an array differs on its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Tolerance {
    /// Standard deviation of the thickness, relative to it, 0 to 0.5. Absorbances change in proportion.
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

#[cfg(test)]
mod tests {
    use super::*;

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
