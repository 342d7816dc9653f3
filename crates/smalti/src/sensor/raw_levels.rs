//! Black and white levels of raw samples.

use super::{ConversionGain, Exposure, Light, NoiseMode, RawImage, RawSamples, Sensor, SensorError};
use crate::numeric::require;

/// Black and white level of a capture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawLevels {
    /// Sample without signal: digital number, or V without a converter.
    pub black: f64,
    /// Sample at saturation (full well, swing, or the converter's largest number), in the same unit.
    pub white: f64,
    /// Volts at the converter for the black level.
    pub black_v: f64,
    /// Volts at the converter for the white level.
    pub white_v: f64,
}

impl Sensor {
    /// Black and white level of captures with an exposure.
    ///
    /// # Errors
    /// When the analog offset leaves no range between them, or a full pixel gives no signal.
    pub fn raw_levels(&self, exposure: &Exposure) -> Result<RawLevels, SensorError> {
        self.ensure_gain(exposure)?;
        let levels = self.unchecked_levels(exposure);
        let has_range = |levels: RawLevels| levels.white > levels.black;
        if !has_range(levels) {
            let without_offset = Exposure { analog_offset_v: 0.0, ..*exposure };
            require(
                has_range(self.unchecked_levels(&without_offset)),
                "full_well_e",
                self.pixel.full_well_e,
                "as many electrons as give at least one digital number (keys sensor.pixel.full_well_e, sensor.pixel.conversion_gain_uv_per_e, sensor.adc_bits)",
            )?;
            exposure.require_offset(false)?;
        }
        Ok(levels)
    }

    fn unchecked_levels(&self, exposure: &Exposure) -> RawLevels {
        let zero_v = exposure.zero_v();
        let saturation_v = self.saturation_v(exposure);
        if self.adc.bits == 0 {
            RawLevels { black: zero_v, white: saturation_v, black_v: zero_v, white_v: saturation_v }
        } else {
            let (swing, last) = (self.pixel.voltage_swing_v, self.adc.levels() - 1.0);
            let black = self.adc.number(zero_v, swing).clamp(0.0, last);
            // For combined gains, up to the last number of the low gain on the scale of the high one.
            let highest = match exposure.conversion_gain {
                ConversionGain::High | ConversionGain::Low(_) => last,
                ConversionGain::Combined(_) => black + (last - black) * self.gain_ratio(exposure),
            };
            let white = self.adc.number(saturation_v, swing).round().min(highest);
            // Digital binning adds numbers; their volts remain those of one reading.
            let scale = self.steps_per_converter_step(exposure);
            RawLevels {
                black: black * scale,
                white: white * scale,
                black_v: self.adc.volts(black, swing),
                white_v: self.adc.volts(white, swing),
            }
        }
    }

    /// A noise-free capture by an ideal converter with the same levels: volts at the [`RawLevels`] of this
    /// sensor. Its [`RawImage::normalized`] is that of a digital capture before rounding.
    ///
    /// # Errors
    /// As for [`Sensor::capture`].
    pub fn capture_ideal<'a>(
        &self,
        light: impl Into<Light<'a>>,
        exposure: &Exposure,
    ) -> Result<RawImage, SensorError> {
        let levels = self.raw_levels(exposure)?;
        let mut analog = Self { adc: super::Adc::default(), ..self.clone() };
        if self.readings_per_sample() > 1.0 {
            // Each reading is limited before the mean is taken.
            analog.pixel.voltage_swing_v = levels.white_v.min(analog.pixel.voltage_swing_v);
        }
        let raw = analog.capture(light, exposure, NoiseMode::None, 0)?;
        let (rows, cols, names) = (raw.rows(), raw.cols(), raw.channel_names().to_vec());
        let (black, white) = (levels.black_v, levels.white_v);
        let samples = match raw.samples() {
            RawSamples::Analog(v) => v.iter().map(|&v| v.min(white as f32)).collect(),
            RawSamples::Digital(v) => v.iter().map(|&v| f32::from(v)).collect(),
        };
        let sampling = raw.sampling().clone();
        Ok(RawImage::new(rows, cols, RawSamples::Analog(samples), sampling, names, black, white)?)
    }
}
