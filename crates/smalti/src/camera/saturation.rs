//! The light in which a camera saturates.

use super::resolve::ExposureTime;
use super::{Camera, CameraError};
use crate::sensor::{AutoExposure, PixelSpectra};
use crate::spectrum::Spectrum;

impl Camera {
    /// The multiple of the light on the pixels beyond which more than a share of the samples (0 to below 1) saturates at the exposure of the camera. Light and mean
    /// dark signal count; noise does not. It is 0 where the samples saturate in any light. It is infinite where they never do, as with an exposure that
    /// follows the light, and where so few samples receive light that the others alone decide, whatever their dark signal is.
    ///
    /// `metered` is the irradiance at the point that the exposure rule meters ([`Camera::metered`]), in the same light; a stated time and a rule that meters all
    /// samples need none.
    ///
    /// # Errors
    /// When the share or the rule is invalid, or the rule finds no light.
    pub(crate) fn saturating_factor(
        &self,
        pixels: &PixelSpectra,
        metered: Option<&Spectrum>,
        share: f64,
    ) -> Result<f64, CameraError> {
        let (sensor, exposure) = (&self.sensor, self.gain_and_offset());
        let bound = AutoExposure::SaturatedShare { share };
        let bound_rate = bound.rate_of_samples(sensor, pixels)?;
        if bound_rate <= 0.0 {
            return Ok(f64::INFINITY);
        }
        let own_rate = match (&self.exposure_time, metered) {
            (ExposureTime::Fixed(_), _) => 0.0,
            (ExposureTime::Auto(_), Some(point)) => AutoExposure::rate_of_metered(sensor, point)?,
            (ExposureTime::Auto(rule), None) => rule.rate_of_samples(sensor, pixels)?,
        };
        // The inverse of an exposure time is a linear function of the light, plus that of the dark signal. So is the difference between the inverses of the
        // camera's time and of the longest time without saturation, which falls below 0 where samples saturate.
        let room = |factor: f64| {
            let time_s = match &self.exposure_time {
                ExposureTime::Fixed(time_s) => *time_s,
                ExposureTime::Auto(rule) => rule.time_for_rate(sensor, factor * own_rate, &exposure)?,
            };
            let longest_s = bound.time_for_rate(sensor, factor * bound_rate, &exposure)?;
            Ok::<_, CameraError>(1.0 / time_s - 1.0 / longest_s)
        };
        let (once, twice) = (room(1.0)?, room(2.0)?);
        let slope = twice - once;
        Ok(if slope < 0.0 { (1.0 - once / slope).max(0.0) } else { f64::INFINITY })
    }
}
