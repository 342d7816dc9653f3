//! The variance that the noise of a pixel should have, in closed form. Tests hold captures against it, and
//! weights for noisy data can be had without simulating.

use serde::{Deserialize, Serialize};

use super::{ColorArchitecture, Exposure, Sensor, SensorError};

/// Variance at the converter, V², term by term, for a pixel far from saturation. Defects are not counted.
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
    /// Differences in gain between pixels, acting on light and dark signal.
    pub prnu: f64,
    /// Differences in offset between pixels.
    pub dsnu: f64,
    /// Differences between columns.
    pub column: f64,
    /// Rounding by the converter, LSB²/12: right where the other noise is above half an LSB.
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

/// The variance of a normalised sample ([`super::RawImage::normalized`]: 0 at black level, 1 at white level) as a polynomial
/// of its mean: `constant + per_signal · x + per_signal_squared · x²`, and what the pixels of a row or a column share.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignalNoise {
    /// Of every pixel by itself, whatever the signal: read noise, dark current, offsets, quantisation.
    pub constant: f64,
    /// Shot noise: variance per signal.
    pub per_signal: f64,
    /// Differences in gain: variance per signal².
    pub per_signal_squared: f64,
    /// Shared by all pixels of a row.
    pub row: f64,
    /// Shared by all pixels of a column.
    pub column: f64,
}

impl SignalNoise {
    /// Variance at a mean signal, rows and columns included. Signals below 0 count as 0.
    #[must_use]
    pub fn variance(&self, signal: f64) -> f64 {
        let x = signal.max(0.0);
        self.own(x, x * x) + self.row + self.column
    }

    /// Mean variance of a pixel by itself over signals of a mean and a mean square.
    #[must_use]
    pub fn own(&self, mean: f64, mean_square: f64) -> f64 {
        self.constant + self.per_signal * mean.max(0.0) + self.per_signal_squared * mean_square
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl Sensor {
    /// The noise of normalised samples far from saturation, over the pixels of many devices.
    ///
    /// # Errors
    /// As [`Sensor::noise_variance`], and when nothing lies between black and saturation.
    pub fn signal_noise(&self, exposure: &Exposure) -> Result<SignalNoise, SensorError> {
        let levels = self.raw_levels(exposure)?;
        let range_v = levels.white_v - levels.black_v;
        let full_e = range_v / (self.pixel.conversion_gain_v_per_e * exposure.analog_gain);
        let (dark, full) = (self.noise_variance(0.0, exposure)?, self.noise_variance(full_e, exposure)?);
        let (squared, gain) = (range_v * range_v, self.nonuniformity.prnu_fraction);
        // PRNU acts on light and dark signal: (e + d)² = e² + 2 e d + d², and d² is in `dark` already.
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

    /// The variance of a pixel that collects `photoelectrons` on average.
    ///
    /// # Errors
    /// When the exposure or the sensor's temperature is impossible.
    pub fn noise_variance(
        &self,
        photoelectrons: f64,
        exposure: &Exposure,
    ) -> Result<NoiseVariance, SensorError> {
        exposure.validate()?;
        let time_s = match self.architecture {
            ColorArchitecture::FieldSequential => exposure.time_s / self.cfa.channels().len() as f64,
            ColorArchitecture::Mosaic | ColorArchitecture::Prism => exposure.time_s,
        };
        let (pixel, non) = (&self.pixel, &self.nonuniformity);
        let dark_e = self.dark_voltage_v_per_s()? * time_s / pixel.conversion_gain_v_per_e;
        let out = exposure.analog_gain * exposure.analog_gain;
        let per_e = pixel.conversion_gain_v_per_e * pixel.conversion_gain_v_per_e * out;
        // The gain of a pixel scales its shot noise: E[(1 + p)²] = 1 + σ².
        let shot = per_e * (1.0 + non.prnu_fraction * non.prnu_fraction);
        let mean_e = photoelectrons + dark_e;
        let lsb_v = if self.adc.bits == 0 { 0.0 } else { pixel.voltage_swing_v / self.adc.levels() };
        let squared = |v: f64| v * v * out;
        Ok(NoiseVariance {
            photon: photoelectrons * shot,
            dark: dark_e * shot,
            read: squared(pixel.read_noise_v),
            row: squared(non.row_noise_v),
            prnu: (mean_e * non.prnu_fraction).powi(2) * per_e,
            dsnu: squared(non.dsnu_v),
            column: squared(non.column_noise_v),
            quantization: lsb_v * lsb_v / 12.0,
        })
    }
}
