//! The extent of a search.

use serde::{Deserialize, Serialize};

use crate::design::error::DesignError;

/// Limits of [`SearchSettings`].
const MAX_STARTS: usize = 100_000;
const MAX_STEPS: usize = 100_000;

/// `search` of a design: the extent of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SearchSettings {
    /// Random starts for each mosaic, 1 to 100 000. The better half of them is searched to the end.
    pub starts: usize,
    /// Greatest number of steps of a start, 1 to 100 000.
    pub steps: usize,
    /// Seed of the starts.
    pub seed: u64,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self { starts: 12, steps: 200, seed: 1 }
    }
}

impl SearchSettings {
    /// Checks that there is something to do.
    ///
    /// # Errors
    /// [`DesignError::Key`] without a start or a step.
    pub fn validate(&self) -> Result<(), DesignError> {
        let range = |key: &str, value: usize, most: usize| {
            if (1..=most).contains(&value) {
                return Ok(());
            }
            Err(DesignError::key(format!("search.{key}"), format!("{value}; expected 1 to {most}")))
        };
        range("starts", self.starts, MAX_STARTS)?;
        range("steps", self.steps, MAX_STEPS)
    }
}
