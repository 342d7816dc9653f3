//! A score for each patch of a chart, with a summary.

use serde::Serialize;

use crate::metrics::MetricError;

/// A score for each patch and the mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PatchScores {
    /// Mean over the patches.
    pub mean: f64,
    /// One per patch, row by row from dark skin, or from white to black for the grey series.
    pub per_patch: Vec<f64>,
}

/// The error of scores without patches.
const NO_PATCH: MetricError = MetricError::TooFew { what: "patches", minimum: 1, got: 0 };

impl PatchScores {
    /// # Errors
    /// [`MetricError::TooFew`] without patches.
    pub(super) fn new(per_patch: Vec<f64>) -> Result<Self, MetricError> {
        if per_patch.is_empty() {
            return Err(NO_PATCH);
        }
        Ok(Self { mean: per_patch.iter().sum::<f64>() / per_patch.len() as f64, per_patch })
    }
}

/// A score for each grey patch and the median.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GreyScores {
    /// Median over the patches.
    pub median: f64,
    /// From white to black.
    pub per_patch: Vec<f64>,
}

impl GreyScores {
    /// # Errors
    /// [`MetricError::TooFew`] without patches.
    pub(super) fn new(per_patch: Vec<f64>) -> Result<Self, MetricError> {
        let mut sorted = per_patch.clone();
        sorted.sort_by(f64::total_cmp);
        let count = sorted.len();
        let middle = sorted.get(count.saturating_sub(1) / 2).zip(sorted.get(count / 2));
        let (&low, &high) = middle.ok_or(NO_PATCH)?;
        Ok(Self { median: f64::midpoint(low, high), per_patch })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_need_patches() {
        assert_eq!(PatchScores::new(vec![]), Err(NO_PATCH));
        assert_eq!(GreyScores::new(vec![]), Err(NO_PATCH));
        assert_eq!(PatchScores::new(vec![1.0, 2.0, 6.0]).unwrap().mean, 3.0);
        assert_eq!(GreyScores::new(vec![6.0, 1.0, 2.0]).unwrap().median, 2.0);
        assert_eq!(GreyScores::new(vec![6.0, 1.0, 2.0, 3.0]).unwrap().median, 2.5);
    }
}
