//! The samples of an exposure: their scale in volts and numbers, with binning and with one or two conversion gains.

use super::conversion_gain::Combination;
use super::{Binning, BinningMode, ConversionGain, Exposure, LowGain, Sensor, SensorError};
use crate::numeric::require;

impl Sensor {
    /// Volts of a sample per photoelectron in any of its photodiodes, before the analog gain: the conversion
    /// gain of the exposure (for combined gains, the high one), for digital binning divided by the number of
    /// photodiodes, whose volts are averaged.
    #[must_use]
    pub fn volts_per_electron(&self, exposure: &Exposure) -> f64 {
        self.conversion_gain_v_per_e(exposure) / self.readings_per_sample()
    }

    /// Photoelectrons of a sample at saturation, of all its photodiodes: those of the full well, or of the part of the
    /// voltage swing that the analog offset and the black level leave.
    #[must_use]
    pub fn saturation_e(&self, exposure: &Exposure) -> f64 {
        let volts_per_e = self.volts_per_electron(exposure) * exposure.analog_gain;
        let well_e = self.pixel.full_well_e * self.photodiodes_per_sample();
        // Rounding in volts does not enlarge the well.
        ((self.saturation_v(exposure) - exposure.zero_v()) / volts_per_e).min(well_e)
    }

    /// Standard deviation of the read noise of a sample in the dark, in electrons of all its photodiodes. N
    /// readings that are averaged have √N times the noise of one.
    #[must_use]
    pub fn read_noise_e(&self, exposure: &Exposure) -> f64 {
        self.read_noise_v(exposure) / self.conversion_gain_v_per_e(exposure)
            * self.readings_per_sample().sqrt()
    }

    /// Standard deviation of the read noise of one reading in the dark, V before the analog gain.
    pub(super) fn read_noise_v(&self, exposure: &Exposure) -> f64 {
        match exposure.conversion_gain {
            ConversionGain::Low(low) => low.read_noise_v,
            ConversionGain::High | ConversionGain::Combined(_) => self.pixel.read_noise_v,
        }
    }

    /// Volts per electron on the scale of the samples of an exposure.
    pub(super) fn conversion_gain_v_per_e(&self, exposure: &Exposure) -> f64 {
        match exposure.conversion_gain {
            ConversionGain::Low(low) => low.conversion_gain_v_per_e,
            ConversionGain::High | ConversionGain::Combined(_) => self.pixel.conversion_gain_v_per_e,
        }
    }

    /// The high conversion gain over the low one of an exposure; 1 for an exposure with the high gain alone.
    pub(super) fn gain_ratio(&self, exposure: &Exposure) -> f64 {
        let low = exposure.conversion_gain.low();
        low.map_or(1.0, |low| self.pixel.conversion_gain_v_per_e / low.conversion_gain_v_per_e)
    }

    /// Volts of this exposure's scale per volt at the high gain, at which dark signal and DSNU are stated.
    pub(super) fn volts_per_high_volt(&self, exposure: &Exposure) -> f64 {
        if exposure.conversion_gain.is_combined() { 1.0 } else { 1.0 / self.gain_ratio(exposure) }
    }

    /// Bits of the samples of an exposure: those of the converter, of the sum of several readings, or of two
    /// combined gains. 0 without a converter.
    #[must_use]
    pub fn sample_bits(&self, exposure: &Exposure) -> u32 {
        match self.combined_bits(exposure) {
            Some(bits) => bits.min(16),
            None => self.binning.map_or(self.adc.bits, |b| b.sample_bits(self.adc.bits)),
        }
    }

    /// Bits of the numbers of two combined gains before they are limited to 16; `None` for a single gain or
    /// without a converter.
    fn combined_bits(&self, exposure: &Exposure) -> Option<u32> {
        let both = exposure.conversion_gain.is_combined() && self.adc.bits > 0;
        // Rounding must not add a bit to a ratio that is a power of two.
        both.then(|| self.adc.bits + (self.gain_ratio(exposure).log2() - 1e-9).ceil().max(0.0) as u32)
    }

    /// Steps of a sample per step of the converter: the number of readings, halved for each bit that is dropped.
    pub(super) fn steps_per_converter_step(&self, exposure: &Exposure) -> f64 {
        let dropped = match self.combined_bits(exposure) {
            Some(bits) => bits.saturating_sub(16),
            None => self.binning.map_or(0, |b| b.dropped_bits(self.adc.bits)),
        };
        self.readings_per_sample() / f64::from(dropped).exp2()
    }

    /// Checks that the sensor can be read with the conversion gain of an exposure.
    ///
    /// # Errors
    /// When the low gain is not below the high one, or digital binning would average samples of two gains.
    pub(super) fn ensure_gain(&self, exposure: &Exposure) -> Result<(), SensorError> {
        let ratio = self.gain_ratio(exposure);
        let fits = exposure.conversion_gain.low().is_none() || (ratio > 1.0 && ratio <= LowGain::MAX_RATIO);
        require(fits, "the ratio of the conversion gains", ratio, "more than 1 and at most 1024")?;
        match (exposure.conversion_gain, self.binning) {
            (ConversionGain::Combined(_), Some(Binning { mode: BinningMode::Digital, .. })) => {
                Err(SensorError::CombinedBinning)
            }
            _ => Ok(()),
        }
    }

    /// How the samples of the two gains of an exposure are combined; `None` for a single gain.
    pub(super) fn combination(&self, exposure: &Exposure) -> Option<Combination> {
        if !exposure.conversion_gain.is_combined() {
            return None;
        }
        let ratio = self.gain_ratio(exposure);
        let zero_v = exposure.zero_v();
        let full_v = self.saturation_v(&exposure.with_high_gain());
        let swing_v = self.pixel.voltage_swing_v;
        Some(if self.adc.bits == 0 {
            Combination::new(zero_v, full_v, ratio, 1.0)
        } else {
            let full = self.adc.number(full_v, swing_v).min(self.adc.levels() - 1.0);
            let scale = self.steps_per_converter_step(exposure);
            Combination::new(self.adc.number(zero_v, swing_v), full, ratio, scale)
        })
    }
}
