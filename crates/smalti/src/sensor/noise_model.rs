//! The variance of a pixel in closed form. Tests compare captures with it, and it provides weights for noisy
//! data without simulation.

use serde::{Deserialize, Serialize};

use super::{Exposure, Sensor, SensorError};

/// Variance at the converter, V², term by term, for a pixel far below saturation, without defects. For digital
/// binning, volts are the mean of the readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseVariance {
    /// Shot noise of the light.
    pub photon: f64,
    /// Shot noise of the dark current.
    pub dark: f64,
    /// Read noise.
    pub read: f64,
    /// Row noise.
    pub row: f64,
    /// Photo-response non-uniformity (PRNU): gain differences that act on light and dark signal.
    pub prnu: f64,
    /// Dark-signal non-uniformity (DSNU): offset differences between pixels.
    pub dsnu: f64,
    /// Column noise.
    pub column: f64,
    /// Quantisation noise, LSB²/12: valid where the other noise exceeds half an LSB.
    pub quantization: f64,
}

impl NoiseVariance {
    /// Variance of one pixel over many captures.
    #[must_use]
    pub fn temporal(&self) -> f64 {
        self.photon + self.dark + self.read + self.row + self.quantization
    }

    /// Variance over the pixels of a flat field, after averaging over many captures.
    #[must_use]
    pub fn spatial(&self) -> f64 {
        self.prnu + self.dsnu + self.column
    }

    /// Variance over the pixels of many devices.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.temporal() + self.spatial()
    }
}

/// The variance of a normalised sample ([`super::RawImage::normalized`]: 0 at the black level, 1 at the white
/// level) as a polynomial of its mean, `constant + per_signal · x + per_signal_squared · x²`, plus the
/// variances that the pixels of a row or a column share.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignalNoise {
    /// Signal-independent variance of each pixel: read noise, dark current, offsets, quantisation.
    pub constant: f64,
    /// Shot noise: variance per unit of signal.
    pub per_signal: f64,
    /// Gain differences: variance per squared signal.
    pub per_signal_squared: f64,
    /// Variance common to all pixels of a row.
    pub row: f64,
    /// Variance common to all pixels of a column.
    pub column: f64,
}

impl SignalNoise {
    /// Variance at a mean signal, including rows and columns. Negative signals count as 0.
    #[must_use]
    pub fn variance(&self, signal: f64) -> f64 {
        let x = signal.max(0.0);
        self.own(x, x * x) + self.row + self.column
    }

    /// Mean variance of a pixel, without rows and columns, over signals with a given mean and mean square.
    #[must_use]
    pub fn own(&self, mean: f64, mean_square: f64) -> f64 {
        self.constant + self.per_signal * mean.max(0.0) + self.per_signal_squared * mean_square
    }
}

impl Sensor {
    /// The noise of normalised samples far below saturation, over the pixels of many devices.
    ///
    /// # Errors
    /// As for [`Sensor::noise_variance`], and when there is no range between black and saturation.
    pub fn signal_noise(&self, exposure: &Exposure) -> Result<SignalNoise, SensorError> {
        let levels = self.raw_levels(exposure)?;
        let range_v = levels.white_v - levels.black_v;
        let full_e = range_v / (self.volts_per_electron() * exposure.analog_gain);
        let (dark, full) = (self.noise_variance(0.0, exposure)?, self.noise_variance(full_e, exposure)?);
        // The gains of several photodiodes average out.
        let gain = self.nonuniformity.prnu_fraction / self.binning_side() as f64;
        let squared = range_v * range_v;
        // PRNU acts on light and dark signal: (e + d)² = e² + 2 e d + d², and `dark` includes d².
        let per_signal_squared = (range_v * gain).powi(2);
        let own = |v: &NoiseVariance| v.total() - v.row - v.column;
        Ok(SignalNoise {
            constant: own(&dark) / squared,
            per_signal: (own(&full) - own(&dark) - per_signal_squared).max(0.0) / squared,
            per_signal_squared: per_signal_squared / squared,
            row: dark.row / squared,
            column: dark.column / squared,
        })
    }

    /// The variance of a pixel with a mean number of `photoelectrons`, with binning those of all photodiodes of
    /// the sample, which share them equally.
    ///
    /// # Errors
    /// When the exposure or the sensor's temperature is out of range.
    pub fn noise_variance(
        &self,
        photoelectrons: f64,
        exposure: &Exposure,
    ) -> Result<NoiseVariance, SensorError> {
        exposure.validate()?;
        let time_s = exposure.time_s / self.captures();
        let (pixel, non) = (&self.pixel, &self.nonuniformity);
        let (photodiodes, readings) = (self.photodiodes_per_sample(), self.readings_per_sample());
        let dark_e = self.dark_voltage_v_per_s()? * time_s / pixel.conversion_gain_v_per_e * photodiodes;
        let out = exposure.analog_gain * exposure.analog_gain;
        let per_e = self.volts_per_electron() * self.volts_per_electron() * out;
        // The gain of a pixel scales its shot noise: E[(1 + p)²] = 1 + σ².
        let shot = per_e * (1.0 + non.prnu_fraction * non.prnu_fraction);
        let mean_e = photoelectrons + dark_e;
        let lsb_v = if self.adc.bits == 0 { 0.0 } else { pixel.voltage_swing_v / self.adc.levels() };
        let squared = |v: f64| v * v * out;
        // A sample is read in `lines` rows and columns. A sum of too many bits is rounded once more: from steps of
        // `lsb_v / readings` to those of `step_v`.
        let (lines, step_v) = (readings.sqrt(), lsb_v / self.steps_per_converter_step());
        let rounding = step_v * step_v - lsb_v * lsb_v / (readings * readings);
        Ok(NoiseVariance {
            photon: photoelectrons * shot,
            dark: dark_e * shot,
            read: squared(pixel.read_noise_v) / readings,
            row: squared(non.row_noise_v) / lines,
            prnu: (mean_e * non.prnu_fraction).powi(2) * per_e / photodiodes,
            dsnu: squared(non.dsnu_v) * self.photodiodes_per_reading() / readings,
            column: squared(non.column_noise_v) / lines,
            quantization: lsb_v * lsb_v / 12.0 / readings + rounding / 12.0,
        })
    }
}
