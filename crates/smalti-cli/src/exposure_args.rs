//! Options of the exposure times of a comparison.

use clap::Args;
use smalti::experiment::{EqualExposure, ExposurePolicy};

use crate::numbers::positive;

/// `--exposure` without the limits of equal times.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Exposure {
    Own,
    Equal,
    AutoEqual,
    Time(f64),
}

/// Options of the exposure times.
#[derive(Debug, Clone, Args)]
pub(crate) struct ExposureOptions {
    /// Exposure times: own (the time or the rule of each camera), equal (for each scene the longest time at which no camera
    /// saturates more than --max-saturated of its samples, at most --max-exposure), a time in seconds, or auto-equal (own if it
    /// is the same time for all cameras, otherwise equal)
    #[arg(long, default_value = "auto-equal", value_name = "own|equal|auto-equal|SECONDS", value_parser = exposure)]
    exposure: Exposure,
    /// Equal exposure: the largest share of saturated samples, percent
    #[arg(long, default_value_t = 100.0 * EqualExposure::default().saturated_share, value_name = "PERCENT")]
    max_saturated: f64,
    /// Equal exposure: the longest time, s
    #[arg(long, default_value_t = EqualExposure::default().longest_s, value_name = "SECONDS")]
    max_exposure: f64,
}

fn exposure(text: &str) -> Result<Exposure, String> {
    match text {
        "own" => Ok(Exposure::Own),
        "equal" => Ok(Exposure::Equal),
        "auto-equal" => Ok(Exposure::AutoEqual),
        time => positive(time)
            .map(Exposure::Time)
            .map_err(|_| "expected own, equal, auto-equal or a time in seconds".into()),
    }
}

impl ExposureOptions {
    /// The choice of the exposure times.
    pub(crate) fn policy(&self) -> ExposurePolicy {
        let limits =
            EqualExposure { saturated_share: self.max_saturated / 100.0, longest_s: self.max_exposure };
        match self.exposure {
            Exposure::Own => ExposurePolicy::Own,
            Exposure::Time(time_s) => ExposurePolicy::Time(time_s),
            Exposure::Equal => ExposurePolicy::Equal(limits),
            Exposure::AutoEqual => ExposurePolicy::AutoEqual(limits),
        }
    }
}
