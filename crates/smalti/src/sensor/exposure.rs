//! Exposure: integration time and analog gain.

use super::SensorError;

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
}

impl Exposure {
    /// An exposure of unit gain and no offset.
    #[must_use]
    pub fn new(time_s: f64) -> Self {
        Self { time_s, analog_gain: 1.0, analog_offset_v: 0.0 }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), SensorError> {
        if !(0.0..=1e9).contains(&self.time_s) {
            return Err(SensorError::ExposureTime { value: self.time_s });
        }
        if !(1e-6..=1e6).contains(&self.analog_gain) {
            return Err(SensorError::AnalogGain { value: self.analog_gain });
        }
        if !(-1e3..=1e3).contains(&self.analog_offset_v) {
            return Err(SensorError::AnalogOffset { value: self.analog_offset_v });
        }
        Ok(())
    }
}
