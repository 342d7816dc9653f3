//! Errors of metrics on targets of an evaluation, with the exposure as their cause where it is one.

use super::exposure_fault::ExposureFault;
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
