//! Options of the exposure times of a comparison.

use clap::Args;
use smalti::experiment::{EqualExposure, ExposurePolicy};

use crate::numbers::positive;

/// Options of the exposure times.
#[derive(Debug, Clone, Args)]
pub(crate) struct ExposureOptions {
    /// Exposure times: own (the time or the rule of each camera), equal (for each scene the longest time at which no camera
    /// saturates more than --max-saturated of its samples, at most --max-exposure), a time in seconds, or auto-equal (own if it
    /// is the same time for all cameras, otherwise equal)
    #[arg(long, default_value = "auto-equal", value_name = "own|equal|auto-equal|SECONDS", value_parser = exposure)]
    exposure: ExposurePolicy,
    /// Equal exposure: the largest share of saturated samples, percent
    #[arg(long, default_value_t = 100.0 * EqualExposure::default().saturated_share, value_name = "PERCENT")]
    max_saturated: f64,
    /// Equal exposure: the longest time, s
    #[arg(long, default_value_t = EqualExposure::default().longest_s, value_name = "SECONDS")]
    max_exposure: f64,
}

/// Parses a policy, with default limits of equal times.
fn exposure(text: &str) -> Result<ExposurePolicy, String> {
    let named = ExposurePolicy::named(EqualExposure::default());
    match named.into_iter().find(|(name, _)| *name == text) {
        Some((_, policy)) => Ok(policy),
        None => positive(text)
            .map(ExposurePolicy::Time)
            .map_err(|_| "expected own, equal, auto-equal or a time in seconds".into()),
    }
}

impl ExposureOptions {
    /// The choice of the exposure times.
    pub(crate) fn policy(&self) -> ExposurePolicy {
        let (saturated_share, longest_s) = (self.max_saturated / 100.0, self.max_exposure);
        self.exposure.with_limits(EqualExposure { saturated_share, longest_s })
    }
}
