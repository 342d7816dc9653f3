//! Exposures with which a target of an evaluation cannot be measured.

use std::fmt;

use super::{Camera, CameraError};
use crate::metrics::MetricError;
use crate::optics::OpticalImage;
use crate::sensor::{AutoExposure, Exposure};

/// The share of saturated samples from which on saturation explains why a target cannot be measured, percent: a slanted edge has
/// samples on both sides.
const MOSTLY_SATURATED_PERCENT: f64 = 50.0;
/// Fewer electrons than this in the brightest sample do not show a target.
const LEAST_ELECTRONS: f64 = 10.0;
/// The share of samples that may saturate at the longest time that is proposed.
const SHARE: f64 = 0.005;

/// What is wrong with the exposure of a target.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ExposureFault {
    /// Most samples saturate.
    Saturated {
        /// Saturated samples, percent.
        percent: f64,
        /// The longest time at which at most half a percent of the samples saturates, s.
        longest_s: f64,
    },
    /// There is too little light.
    Dark {
        /// Mean number of electrons in the brightest sample.
        brightest_e: f64,
    },
}

/// A number with three significant digits, without an exponent.
fn significant(value: f64) -> String {
    if value <= 0.0 {
        return "0".into();
    }
    let digits = (2 - value.log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A time with its unit.
fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{} s", significant(s)),
        s if s >= 1e-3 => format!("{} ms", significant(s * 1e3)),
        s => format!("{} µs", significant(s * 1e6)),
    }
}

/// The message of [`CameraError::Exposure`].
pub(super) struct Told<'a>(pub(super) &'a str, pub(super) f64, pub(super) &'a ExposureFault);

impl fmt::Display for Told<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(target, time_s, fault) = self;
        let time_s = time(*time_s);
        match fault {
            ExposureFault::Saturated { percent, longest_s } => write!(
                f,
                "{} % of the samples of {target} saturate in {time_s}, so that it cannot be measured; expected an exposure time of at most {}",
                significant(*percent),
                time(*longest_s)
            ),
            ExposureFault::Dark { brightest_e } => write!(
                f,
                "{target} is too dark to be measured: its brightest sample collects {} electrons in {time_s}; expected more light or a longer exposure",
                significant(*brightest_e)
            ),
        }
    }
}

impl Camera {
    /// The error of a metric on a target, or the fault of the exposure where it explains the error.
    pub(super) fn explained(
        &self,
        error: CameraError,
        target: &'static str,
        image: &OpticalImage,
        exposure: &Exposure,
    ) -> CameraError {
        let CameraError::Metric(metric) = error else { return error };
        // Whatever is wrong with the capture itself has been reported when it was made.
        match self.exposure_fault(image, exposure) {
            Ok(Some(fault)) => of_metric(target, exposure.time_s, fault, metric),
            Ok(None) | Err(_) => CameraError::Metric(metric),
        }
    }

    fn exposure_fault(
        &self,
        image: &OpticalImage,
        exposure: &Exposure,
    ) -> Result<Option<ExposureFault>, CameraError> {
        let percent = self.sensor.capture_ideal(image, exposure)?.saturated_percent();
        if percent >= MOSTLY_SATURATED_PERCENT {
            let rule = AutoExposure::SaturatedShare { share: SHARE };
            let longest_s = rule.exposure_time(&self.sensor, image, exposure)?;
            return Ok(Some(ExposureFault::Saturated { percent, longest_s }));
        }
        let brightest_per_s = AutoExposure::SaturatedShare { share: 0.0 }.rate(&self.sensor, image)?;
        let brightest_e = brightest_per_s * exposure.time_s / self.sensor.captures();
        Ok((brightest_e < LEAST_ELECTRONS).then_some(ExposureFault::Dark { brightest_e }))
    }
}

fn of_metric(target: &'static str, time_s: f64, fault: ExposureFault, metric: MetricError) -> CameraError {
    CameraError::Exposure { target, time_s, fault, metric: Box::new(metric) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_numbers_have_three_digits() {
        for (value, text) in
            [(0.0, "0"), (0.012_34, "0.0123"), (99.96, "100"), (1234.5, "1234"), (2.5, "2.5")]
        {
            assert_eq!(significant(value), text);
        }
        for (seconds, text) in [(33.0, "33 s"), (0.0331, "33.1 ms"), (2.5e-6, "2.5 µs")] {
            assert_eq!(time(seconds), text);
        }
    }
}
