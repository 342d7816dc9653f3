//! Options of the exposure times of a comparison.

use clap::Args;
use smalti::experiment::{EqualExposure, ExposurePolicy};

use crate::numbers::{number, positive};

/// Options of the exposure times.
#[derive(Debug, Clone, Args)]
pub(crate) struct ExposureOptions {
    /// Exposure times: own (the time or the rule of each camera), equal (for each scene or target the longest time at which no camera
    /// saturates more than --max-saturated of its samples before noise, at most --max-exposure), a time in seconds or with its unit (0.03,
    /// 30ms), or auto-equal (own if it is the same time for all cameras, otherwise equal)
    #[arg(long, default_value = "auto-equal", value_name = "own|equal|auto-equal|TIME", value_parser = exposure, allow_hyphen_values = true)]
    exposure: Exposure,
    /// Equal exposure: the largest share of saturated samples before noise, percent, 0 to less than 100 [default: 0.5]
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    max_saturated: Option<f64>,
    /// Equal exposure: the longest time, in seconds or with its unit [default: 33ms]
    #[arg(long, value_name = "TIME", value_parser = seconds, allow_hyphen_values = true)]
    max_exposure: Option<f64>,
}

/// A policy as typed.
#[derive(Debug, Clone, Copy)]
struct Exposure {
    policy: ExposurePolicy,
    /// Whether it is a time without a unit.
    is_bare: bool,
}

/// Parses a policy, with default limits of equal times.
fn exposure(text: &str) -> Result<Exposure, String> {
    let named = ExposurePolicy::named(EqualExposure::default());
    match named.into_iter().find(|(name, _)| *name == text) {
        Some((_, policy)) => Ok(Exposure { policy, is_bare: false }),
        None => seconds(text)
            .map(|time_s| Exposure { policy: ExposurePolicy::Time(time_s), is_bare: positive(text).is_ok() })
            .map_err(|_| {
                "expected own, equal, auto-equal or a time above 0, such as 0.03 (seconds) or 30ms".into()
            }),
    }
}

/// Parses a time in seconds, or with the unit s, ms or us.
fn seconds(text: &str) -> Result<f64, String> {
    let units = [("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6), ("s", 1.0)];
    let with_unit = units.iter().find_map(|(unit, factor)| Some((text.trim().strip_suffix(unit)?, factor)));
    let (number, factor) = with_unit.unwrap_or((text, &1.0));
    let time = positive(number).map(|value| value * factor);
    time.map_err(|_| "expected a time above 0, such as 0.03 (seconds) or 30ms".into())
}

/// Parses a share of saturated samples.
fn percent(text: &str) -> Result<f64, String> {
    let found = number(text).ok();
    found.filter(|v| (0.0..100.0).contains(v)).ok_or_else(|| "expected percent, 0 to less than 100".into())
}

/// Times without a unit from which on milliseconds may be meant, s.
const LONG_S: f64 = 1.0;

impl ExposureOptions {
    /// A note about limits that have no effect, or about a long time without a unit, which may be meant in milliseconds.
    pub(crate) fn note(&self) -> Option<String> {
        let has_limits = self.max_saturated.is_some() || self.max_exposure.is_some();
        match self.exposure {
            Exposure { policy: ExposurePolicy::Own | ExposurePolicy::Time(_), .. } if has_limits => {
                Some("--max-saturated and --max-exposure have no effect: they limit equal exposure times (--exposure equal)".into())
            }
            Exposure { policy: ExposurePolicy::Time(time_s), is_bare: true } if time_s >= LONG_S => {
                Some(format!(
                    "--exposure {time_s} is a time of {time_s} s; {time_s}ms would be milliseconds, and {time_s}s is the same without this note"
                ))
            }
            _ => None,
        }
    }

    /// The choice of the exposure times.
    pub(crate) fn policy(&self) -> ExposurePolicy {
        let default = EqualExposure::default();
        self.exposure.policy.with_limits(EqualExposure {
            saturated_share: self.max_saturated.map_or(default.saturated_share, |percent| percent / 100.0),
            longest_s: self.max_exposure.unwrap_or(default.longest_s),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_seconds_unless_they_state_a_unit() {
        for (text, expected) in
            [("0.03", 0.03), ("30ms", 0.03), (" 30 ms", 0.03), ("33000us", 0.033), ("2s", 2.0)]
        {
            assert!((seconds(text).unwrap() / expected - 1.0).abs() < 1e-12, "{text}");
        }
        let bare = |text: &str| exposure(text).unwrap().is_bare;
        assert!(bare("33") && bare("0.03") && !bare("33s") && !bare("33ms") && !bare("equal"));
        assert!(exposure("-1").unwrap_err().contains("a time above 0"));
        assert_eq!(percent("0.5"), Ok(0.5));
        for wrong in ["100", "150", "-1", "nan", "x"] {
            assert!(percent(wrong).is_err(), "{wrong}");
        }
        for wrong in ["", "ms", "0ms", "-1", "1m", "nan", "infs"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
