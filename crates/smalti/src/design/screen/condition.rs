//! Light and exposure that colour filter arrays are screened under.

use super::lanes::Lanes;
use super::responses::{FilterResponses, sum_of_products};
use crate::camera::{Camera, CameraError};
use crate::design::error::DesignError;
use crate::sensor::Exposure;

/// The rule for the exposure time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScreenTime {
    /// The same for every array, s.
    Fixed(f64),
    /// The longest time, s, at which display white does not saturate the brightest channel, at most this.
    UpTo(f64),
}

/// Light and exposure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenCondition {
    /// Mean luminance of the scenes, cd/m².
    pub luminance_cd_m2: f64,
    /// The exposure time.
    pub time: ScreenTime,
}

impl ScreenCondition {
    /// The condition with the time that the camera states, or up to `longest_s` if it states none.
    #[must_use]
    pub fn of_camera(camera: &Camera, luminance_cd_m2: f64, longest_s: f64) -> Self {
        let time = camera.stated_time_s().map_or(ScreenTime::UpTo(longest_s), ScreenTime::Fixed);
        Self { luminance_cd_m2, time }
    }
}

/// A condition on a camera: its noise in electrons.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    luminance: f64,
    time: ScreenTime,
    saturation_e: f64,
    /// Variance in the dark, e².
    pub(super) dark_e2: f64,
    /// Variance per electron, e.
    pub(super) per_e: f64,
    /// Variance per squared electron.
    pub(super) per_e2: f64,
}

impl Level {
    /// Relative variance of a signal that is not known: the statistics are of single precision, and covariances are small differences of
    /// large sums. It matters for sensors without noise only.
    pub(super) const UNKNOWN: f64 = 1e-12;

    /// The condition on a sensor without noise.
    pub(super) fn without_noise(&self) -> Self {
        Self { dark_e2: 0.0, per_e: 0.0, per_e2: Self::UNKNOWN, ..*self }
    }

    pub(super) fn new(camera: &Camera, condition: &ScreenCondition) -> Result<Self, DesignError> {
        let ScreenCondition { luminance_cd_m2: luminance, time } = *condition;
        if !(luminance > 0.0 && luminance.is_finite()) {
            return Err(DesignError::key(
                "luminance_cd_m2",
                format!("{luminance}; expected a number above 0"),
            ));
        }
        camera.ensure_one_gain()?;
        let (ScreenTime::Fixed(time_s) | ScreenTime::UpTo(time_s)) = time;
        let exposure = Exposure { time_s, ..camera.gain_and_offset() };
        let sensor = &camera.sensor;
        let noise = |e: f64| sensor.noise_variance(e, &exposure).map_err(CameraError::from);
        let volts_per_e = sensor.volts_per_electron(&exposure) * exposure.analog_gain;
        let squared = volts_per_e * volts_per_e;
        let dark_e2 = noise(0.0)?.total() / squared;
        // The variance is a polynomial of the signal: its terms from the terms at a signal within the range.
        let probe_e = 0.1 * sensor.saturation_e(&exposure);
        let bright = noise(probe_e)?;
        let gains = sensor.nonuniformity.prnu_fraction;
        let per_e2 = gains * gains / sensor.photodiodes_per_sample() + Self::UNKNOWN;
        let per_e = (bright.photon / squared / probe_e).max(0.0);
        Ok(Self { luminance, time, saturation_e: sensor.saturation_e(&exposure), dark_e2, per_e, per_e2 })
    }

    /// The exposure time for filters, s, and the number of the filter that limits it.
    pub(super) fn limited_time(&self, white: &[f64], responses: &FilterResponses) -> (f64, Option<usize>) {
        let longest = match self.time {
            ScreenTime::Fixed(time_s) => return (time_s, None),
            ScreenTime::UpTo(longest_s) => longest_s,
        };
        let rates = responses.0.iter().map(|f| sum_of_products(f, white) * self.luminance);
        let brightest = rates.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        match brightest {
            Some((channel, rate)) if rate * longest > self.saturation_e => {
                (self.saturation_e / rate, Some(channel))
            }
            _ => (longest, None),
        }
    }

    pub(super) fn time_s(&self, white: &[f64], responses: &FilterResponses) -> f64 {
        self.limited_time(white, responses).0
    }

    /// The variance of samples with a mean, both in electrons divided by `scale`.
    #[inline(always)]
    pub(super) fn noise(&self, mean: Lanes, scale: f64) -> Lanes {
        let (dark, per_e) = (self.dark_e2 / (scale * scale), self.per_e / scale);
        mean.map(|mean| dark + mean * (per_e + self.per_e2 * mean))
    }

    /// Luminance times time: the factor from responses to electrons.
    pub(super) fn scale(&self, time_s: f64) -> f64 {
        self.luminance * time_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The time is the longest at which white saturates no filter: at a shorter time than the longest, the filter that limits it is just
    /// saturated.
    #[test]
    fn the_brightest_filter_limits_the_time() {
        let (luminance, saturation_e, white) = (5.0, 6000.0, [2.0, 0.5]);
        let filters = [[30.0, 10.0], [50.0, -20.0], [10.0, 5.0]];
        let responses = FilterResponses::new(filters.iter().map(|f| f.to_vec()).collect());
        let level =
            |time| Level { luminance, time, saturation_e, dark_e2: 4.0, per_e: 1.0, per_e2: Level::UNKNOWN };
        // White takes 13.3 s to saturate the second filter.
        for longest in [0.02, 5.0, 13.0, 14.0, 100.0] {
            let (time_s, limit) = level(ScreenTime::UpTo(longest)).limited_time(&white, &responses);
            let electrons = filters.map(|[a, b]| (a * white[0] + b * white[1]) * luminance * time_s);
            assert!(
                electrons.iter().all(|e| *e < saturation_e * (1.0 + 1e-12)),
                "{longest} s: {electrons:?}"
            );
            match limit {
                None => assert_eq!(time_s.to_bits(), f64::to_bits(longest)),
                Some(filter) => {
                    assert!(time_s < longest, "{longest} s: {time_s} s");
                    assert!((electrons[filter] / saturation_e - 1.0).abs() < 1e-12, "{longest} s");
                }
            }
            let fixed = level(ScreenTime::Fixed(longest));
            assert_eq!(fixed.limited_time(&white, &responses), (longest, None));
        }
    }
}
