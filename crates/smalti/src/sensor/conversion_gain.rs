//! The conversion gain of a reading, for pixels that have a high and a low one.

use super::SensorError;
use crate::numeric::require;

/// Share of the range of the high gain, from the black level to saturation, up to which a combined sample is
/// that of the high gain. Noise does not clip it there.
pub(super) const SWITCH: f64 = 0.95;

/// The low conversion gain of a pixel with two: a switch adds capacitance to the floating diffusion.
///
/// Dark current, full well, PRNU and DSNU are the same electrons at both gains. Offsets of rows and columns
/// and the swing are the same volts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowGain {
    /// Volts per electron, above 0 and below the high gain, that of the [`Pixel`](super::Pixel).
    pub conversion_gain_v_per_e: f64,
    /// Standard deviation of the read noise, V, before the analog gain.
    pub read_noise_v: f64,
}

impl LowGain {
    /// The largest ratio of the high gain to the low one.
    pub const MAX_RATIO: f64 = 1024.0;
}

/// The conversion gain of a capture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ConversionGain {
    /// That of the pixel; of two gains, the high one.
    #[default]
    High,
    /// The low one.
    Low(LowGain),
    /// The electrons are read with both gains. A sample is that of the high gain up to 95 % of its saturation,
    /// otherwise that of the low gain on the scale of the high one: times the ratio of the gains from the
    /// black level. Its numbers have as many more bits than the converter as the ratio needs, and at most 16.
    Combined(LowGain),
}

impl ConversionGain {
    /// The low gain, if it is read.
    #[must_use]
    pub fn low(&self) -> Option<LowGain> {
        match *self {
            Self::High => None,
            Self::Low(low) | Self::Combined(low) => Some(low),
        }
    }

    /// Whether both gains are read.
    #[must_use]
    pub fn is_combined(&self) -> bool {
        matches!(self, Self::Combined(_))
    }

    /// Checks the low gain.
    ///
    /// # Errors
    /// When it or its read noise is out of range.
    pub(super) fn validate(&self) -> Result<(), SensorError> {
        let Some(low) = self.low() else { return Ok(()) };
        let (gain, noise) = (low.conversion_gain_v_per_e, low.read_noise_v);
        require((1e-12..=1.0).contains(&gain), "low conversion_gain_v_per_e", gain, "1e-12 to 1 V")?;
        Ok(require((0.0..=1e3).contains(&noise), "low read_noise_v", noise, "0 to 1e3 V")?)
    }
}

/// How the numbers or volts of the two readings of a capture become one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Combination {
    /// Sample without signal, of both readings, before it is limited by the converter.
    pub(super) zero: f32,
    /// Largest sample of the high gain that is taken.
    pub(super) switch: f32,
    /// The high gain over the low one.
    pub(super) ratio: f32,
    /// Steps of a combined sample per step of the converter: 1, halved for each bit beyond 16.
    pub(super) scale: f32,
}

impl Combination {
    /// The combination of readings whose sample without signal is `zero` and whose high gain saturates at `full`.
    pub(super) fn new(zero: f64, full: f64, ratio: f64, scale: f64) -> Self {
        let switch = zero + SWITCH * (full - zero);
        Self { zero: zero as f32, switch: switch as f32, ratio: ratio as f32, scale: scale as f32 }
    }

    /// The combined sample, not rounded.
    #[inline(always)]
    pub(super) fn combined(&self, high: f32, low: f32) -> f32 {
        let sample = if high <= self.switch { high } else { self.zero + (low - self.zero) * self.ratio };
        sample * self.scale
    }
}
