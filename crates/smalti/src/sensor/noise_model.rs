//! The variance of a pixel in closed form. Tests compare captures with it, and it provides weights for noisy
//! data without simulation.

use serde::{Deserialize, Serialize};

use super::conversion_gain::SWITCH;
use super::{ConversionGain, Exposure, LowGain, Sensor, SensorError};

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
    /// What a second reading with a low conversion gain adds to bright samples; `None` for a single gain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above: Option<NoiseAbove>,
}

/// The additional noise of bright samples, which have the low of two combined conversion gains.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseAbove {
    /// The signal above which samples have the low gain, above 0 and at most 1.
    pub signal: f64,
    /// Variance of each pixel beyond that of darker samples: read noise, offsets and quantisation of the low
    /// gain. Offsets of rows and columns are counted with each pixel.
    pub constant: f64,
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
        let own = self.constant + self.per_signal * mean.max(0.0) + self.per_signal_squared * mean_square;
        match self.above {
            Some(above) if mean > above.signal => own + above.constant,
            _ => own,
        }
    }

    /// The part of the variance near saturation that does not depend on the signal, including rows and columns.
    #[must_use]
    pub fn additive_at_saturation(&self) -> f64 {
        self.variance(0.0) + self.above.map_or(0.0, |above| above.constant)
    }

    /// The factor of x² in a polynomial of the signal x for the variance: that of the gain differences, and for
    /// combined conversion gains a term that has the value of the additional noise where the gains change.
    #[must_use]
    pub fn quadratic(&self) -> f64 {
        let above = self.above.map_or(0.0, |above| above.constant / (above.signal * above.signal));
        self.per_signal_squared + above
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
        let full_e = range_v / (self.volts_per_electron(exposure) * exposure.analog_gain);
        // Of combined gains, the high one, as if it did not saturate: shot noise and PRNU are those of both.
        let first = match exposure.conversion_gain {
            ConversionGain::Combined(_) => exposure.with_high_gain(),
            ConversionGain::High | ConversionGain::Low(_) => *exposure,
        };
        let (dark, full) = (self.noise_variance(0.0, &first)?, self.noise_variance(full_e, &first)?);
        let in_dark = self.noise_variance(0.0, exposure)?;
        // The gains of several photodiodes average out.
        let gain = self.nonuniformity.prnu_fraction / self.binning_side() as f64;
        let squared = range_v * range_v;
        // PRNU acts on light and dark signal: (e + d)² = e² + 2 e d + d², and `dark` includes d².
        let per_signal_squared = (range_v * gain).powi(2);
        let own = |v: &NoiseVariance| v.total() - v.row - v.column;
        Ok(SignalNoise {
            constant: own(&in_dark) / squared,
            per_signal: (own(&full) - own(&dark) - per_signal_squared).max(0.0) / squared,
            per_signal_squared: per_signal_squared / squared,
            row: in_dark.row / squared,
            column: in_dark.column / squared,
            above: match exposure.conversion_gain {
                ConversionGain::High | ConversionGain::Low(_) => None,
                ConversionGain::Combined(low) => {
                    let bright = self.noise_of_low_gain(0.0, low, exposure)?;
                    let constant = (bright.total() - in_dark.total()).max(0.0) / squared;
                    let signal = SWITCH * self.high_range_v(exposure)? / range_v;
                    Some(NoiseAbove { signal, constant })
                }
            },
        })
    }

    /// The range of the high gain of an exposure between the black level and saturation, V.
    fn high_range_v(&self, exposure: &Exposure) -> Result<f64, SensorError> {
        let levels = self.raw_levels(&exposure.with_high_gain())?;
        Ok(levels.white_v - levels.black_v)
    }

    /// The variance of the low gain on the scale of the high one, of combined samples.
    fn noise_of_low_gain(
        &self,
        photoelectrons: f64,
        low: LowGain,
        combined: &Exposure,
    ) -> Result<NoiseVariance, SensorError> {
        let exposure = Exposure { conversion_gain: ConversionGain::Low(low), ..*combined };
        let (v, ratio) = (self.noise_variance(photoelectrons, &exposure)?, self.gain_ratio(combined));
        let scaled = |variance: f64| variance * ratio * ratio;
        // Samples of the low gain are rounded to the steps of the high one.
        let step_v = self.lsb_v() / self.steps_per_converter_step(combined);
        Ok(NoiseVariance {
            photon: scaled(v.photon),
            dark: scaled(v.dark),
            read: scaled(v.read),
            row: scaled(v.row),
            prnu: scaled(v.prnu),
            dsnu: scaled(v.dsnu),
            column: scaled(v.column),
            quantization: scaled(v.quantization) + step_v * step_v / 12.0,
        })
    }

    /// Volts of a step of the converter; 0 without one.
    fn lsb_v(&self) -> f64 {
        if self.adc.bits == 0 { 0.0 } else { self.pixel.voltage_swing_v / self.adc.levels() }
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
        self.ensure_gain(exposure)?;
        let time_s = exposure.time_s / self.captures();
        let (pixel, non) = (&self.pixel, &self.nonuniformity);
        let (photodiodes, readings) = (self.photodiodes_per_sample(), self.readings_per_sample());
        let dark_e = self.dark_voltage_v_per_s()? * time_s / pixel.conversion_gain_v_per_e * photodiodes;
        let volts_per_e = self.volts_per_electron(exposure);
        if let ConversionGain::Combined(low) = exposure.conversion_gain {
            let mean_v = (photoelectrons + dark_e) * volts_per_e * exposure.analog_gain;
            if mean_v > SWITCH * self.high_range_v(exposure)? {
                return self.noise_of_low_gain(photoelectrons, low, exposure);
            }
        }
        let out = exposure.analog_gain * exposure.analog_gain;
        let per_e = volts_per_e * volts_per_e * out;
        // The gain of a pixel scales its shot noise: E[(1 + p)²] = 1 + σ².
        let shot = per_e * (1.0 + non.prnu_fraction * non.prnu_fraction);
        let mean_e = photoelectrons + dark_e;
        let lsb_v = self.lsb_v();
        let dsnu_v = non.dsnu_v * self.volts_per_high_volt(exposure);
        let squared = |v: f64| v * v * out;
        // A sample is read in `lines` rows and columns. A sum of too many bits is rounded once more: from steps of
        // `lsb_v / readings` to those of `step_v`.
        let (lines, step_v) = (readings.sqrt(), lsb_v / self.steps_per_converter_step(exposure));
        let rounding = step_v * step_v - lsb_v * lsb_v / (readings * readings);
        Ok(NoiseVariance {
            photon: photoelectrons * shot,
            dark: dark_e * shot,
            read: squared(self.read_noise_v(exposure)) / readings,
            row: squared(non.row_noise_v) / lines,
            prnu: (mean_e * non.prnu_fraction).powi(2) * per_e / photodiodes,
            dsnu: squared(dsnu_v) * self.photodiodes_per_reading() / readings,
            column: squared(non.column_noise_v) / lines,
            quantization: lsb_v * lsb_v / 12.0 / readings + rounding / 12.0,
        })
    }
}
