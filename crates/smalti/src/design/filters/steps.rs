//! Evenly spaced values in the file of a study.

use serde::Deserialize;

use crate::design::error::DesignError;

/// Evenly spaced values, given as first, step and last; the last need not be a whole number of steps from the first.
pub(super) struct Steps {
    first: f64,
    pub(super) step: f64,
    pub(super) len: u64,
}

/// Reads three numbers; the error explains their meaning.
pub(super) fn first_step_last<'de, D: serde::Deserializer<'de>>(from: D) -> Result<[f64; 3], D::Error> {
    let found = Vec::<f64>::deserialize(from)?;
    let wrong = |v: Vec<f64>| format!("found {} numbers; expected three: [first, step, last] in nm", v.len());
    found.try_into().map_err(|v| serde::de::Error::custom(wrong(v)))
}

impl Steps {
    pub(super) fn new(key: &str, [first, step, last]: [f64; 3]) -> Result<Self, DesignError> {
        let range = 1e-3..=1e5;
        let steps = (last - first) / step;
        if range.contains(&first) && range.contains(&last) && step > 0.0 && (0.0..1e6).contains(&steps) {
            return Ok(Self { first, step, len: (steps + 1e-9).floor() as u64 + 1 });
        }
        let message = format!(
            "[{first}, {step}, {last}] is no range; expected [first, step, last] in nm, above 0, ascending, at most a \
             million values"
        );
        Err(DesignError::key(key, message))
    }

    pub(super) fn at(&self, i: u64) -> f64 {
        // Rounding removes the errors of binary fractions: 430.3 instead of 430.30000000000001.
        ((self.first + i as f64 * self.step) * 1e6).round() / 1e6
    }
}
