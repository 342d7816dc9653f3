//! Analog-to-digital conversion.

use super::SensorError;
use crate::numeric::require;

/// The analog-to-digital converter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Adc {
    /// Bits, 1–16; 0 for no converter, in which case samples are volts.
    pub bits: u32,
    /// Digital number of zero volts. A positive value preserves noise below zero. 0 without a converter.
    pub black_level_dn: f64,
}

impl Adc {
    /// Checks every field.
    ///
    /// # Errors
    /// When there are more than 16 bits, or the black level exceeds nine tenths of the range.
    pub fn validate(&self) -> Result<(), SensorError> {
        require(self.bits <= 16, "adc bits", f64::from(self.bits), "0 (no converter) to 16")?;
        let limit = if self.bits == 0 { 0.0 } else { 0.9 * self.levels() };
        let fits = self.black_level_dn == 0.0 || (self.black_level_dn > 0.0 && self.black_level_dn < limit);
        if fits { Ok(()) } else { Err(SensorError::BlackLevel { value: self.black_level_dn, limit }) }
    }

    /// Number of levels, 2^bits.
    #[must_use]
    pub fn levels(&self) -> f64 {
        f64::from(self.bits.min(16)).exp2()
    }

    /// Digital number of a voltage, neither rounded nor clipped: `v / swing · 2^bits + black level`, where
    /// `swing_v` is the range of the converter. Samples are this value, rounded and clipped to 0 to 2^bits −
    /// 1.
    ///
    /// ISETCam does not clip, so its full scale is 2^bits, which is not a code of the converter.
    #[must_use]
    pub fn number(&self, volts: f64, swing_v: f64) -> f64 {
        volts / swing_v * self.levels() + self.black_level_dn
    }

    /// The voltage of a digital number: the inverse of [`Adc::number`].
    pub(crate) fn volts(&self, number: f64, swing_v: f64) -> f64 {
        (number - self.black_level_dn) * swing_v / self.levels()
    }
}
