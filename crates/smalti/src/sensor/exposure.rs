//! Exposure: integration time and analog gain.

use super::{ConversionGain, SensorError};
use crate::numeric::{OutOfRange, require};

/// How a frame is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Integration time, s, 0 or more. Zero gives a bias frame: no light and no dark current, but all other
    /// noise. Field-sequential sensors divide the time among their captures.
    pub time_s: f64,
    /// Gain between pixel and converter, as a factor. (ISETCam divides by its "analog gain".)
    pub analog_gain: f64,
    /// Offset added before the gain, V: `v_out = (v + offset) · gain`.
    pub analog_offset_v: f64,
    /// The conversion gain of the pixels.
    pub conversion_gain: ConversionGain,
}

impl Exposure {
    /// An exposure of unit gain and no offset.
    #[must_use]
    pub fn new(time_s: f64) -> Self {
        Self { time_s, analog_gain: 1.0, analog_offset_v: 0.0, conversion_gain: ConversionGain::High }
    }

    /// The same exposure with the high conversion gain.
    pub(super) fn with_high_gain(&self) -> Self {
        Self { conversion_gain: ConversionGain::High, ..*self }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), SensorError> {
        let (time_s, gain) = (self.time_s, self.analog_gain);
        require((0.0..=1e9).contains(&time_s), "time_s", time_s, "0 (a bias frame) to 1e9 s")?;
        require((1e-6..=1e6).contains(&gain), "analog_gain", gain, "1e-6 to 1e6")?;
        self.conversion_gain.validate()?;
        Ok(self.require_offset((-1e3..=1e3).contains(&self.analog_offset_v))?)
    }

    /// Volts at the converter without signal.
    pub(crate) fn zero_v(&self) -> f64 {
        self.analog_offset_v * self.analog_gain
    }

    /// An error that names the analog offset unless `good`.
    pub(super) fn require_offset(&self, good: bool) -> Result<(), OutOfRange> {
        let expected = "−1e3 to 1e3 V that leave some signal below the voltage swing and the full well (keys exposure.analog_offset_mv, sensor.pixel.voltage_swing_v, \
                        sensor.pixel.full_well_e)";
        require(good, "analog_offset_v", self.analog_offset_v, expected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_out_of_range_is_refused_by_name() {
        let good = Exposure::new(0.01);
        let low = |conversion_gain_v_per_e, read_noise_v| {
            ConversionGain::Low(crate::sensor::LowGain { conversion_gain_v_per_e, read_noise_v })
        };
        for exposure in [good, Exposure::new(0.0), Exposure { conversion_gain: low(1e-5, 0.0), ..good }] {
            assert!(exposure.validate().is_ok(), "{exposure:?}");
        }
        for (exposure, name) in [
            (Exposure::new(-1e-9), "time_s"),
            (Exposure::new(f64::NAN), "time_s"),
            (Exposure { analog_gain: 0.0, ..good }, "analog_gain"),
            (Exposure { analog_offset_v: 1001.0, ..good }, "analog_offset_v"),
            (Exposure { conversion_gain: low(0.0, 0.0), ..good }, "low conversion_gain_v_per_e"),
            (Exposure { conversion_gain: low(1e-5, -1.0), ..good }, "low read_noise_v"),
        ] {
            let error = exposure.validate().unwrap_err().to_string();
            assert!(error.contains(name), "{error}");
        }
    }
}
