//! From volts to digital numbers.

use super::SensorError;

/// The analog-to-digital converter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Adc {
    /// Bits, 1–16; 0 for none, the samples being volts.
    pub bits: u32,
    /// Digital number of zero volts, so that noise below zero survives. 0 without a converter.
    pub black_level_dn: f64,
}

impl Adc {
    /// Checks every field.
    ///
    /// # Errors
    /// When there are more than 16 bits, or the black level takes more than nine tenths of the range.
    pub fn validate(&self) -> Result<(), SensorError> {
        if self.bits > 16 {
            return Err(SensorError::AdcBits { bits: self.bits });
        }
        let limit = if self.bits == 0 { 0.0 } else { 0.9 * self.levels() };
        let fits = self.black_level_dn == 0.0 || (self.black_level_dn > 0.0 && self.black_level_dn < limit);
        if fits { Ok(()) } else { Err(SensorError::BlackLevel { value: self.black_level_dn, limit }) }
    }

    /// 2^bits.
    #[must_use]
    pub fn levels(&self) -> f64 {
        f64::from(self.bits.min(16)).exp2()
    }

    /// Digital number (not rounded, not clipped) of a voltage, where `swing_v` spans the converter:
    /// `v / swing · 2^bits + black level`. Samples are this, rounded, within 0 to 2^bits − 1.
    ///
    /// ISETCam does not clip, so its full scale is 2^bits, a number the converter does not have.
    #[must_use]
    pub fn number(&self, volts: f64, swing_v: f64) -> f64 {
        volts / swing_v * self.levels() + self.black_level_dn
    }
}
