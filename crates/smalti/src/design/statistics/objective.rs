//! A column of values to minimise or to maximise.

use super::StatisticsError;

/// One value per design, and the direction of improvement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Objective<'a> {
    values: &'a [f64],
    higher: bool,
}

impl<'a> Objective<'a> {
    /// Smaller is better: ΔE, noise.
    #[must_use]
    pub fn lower(values: &'a [f64]) -> Self {
        Self { values, higher: false }
    }

    /// Larger is better: MTF50, signal-to-noise ratio.
    #[must_use]
    pub fn higher(values: &'a [f64]) -> Self {
        Self { values, higher: true }
    }

    /// The value, negated where larger is better, so that smaller is better; `None` for NaN and beyond the last row.
    pub(super) fn cost(&self, row: usize) -> Option<f64> {
        let value = self.values.get(row).copied().filter(|v| !v.is_nan())?;
        Some(if self.higher { -value } else { value })
    }
}

/// The number of rows that all objectives share.
pub(super) fn rows(objectives: &[Objective<'_>]) -> Result<usize, StatisticsError> {
    let expected = objectives.first().ok_or(StatisticsError::NoObjective)?.values.len();
    match objectives.iter().find(|o| o.values.len() != expected) {
        Some(other) => Err(StatisticsError::Lengths { expected, got: other.values.len() }),
        None => Ok(expected),
    }
}
