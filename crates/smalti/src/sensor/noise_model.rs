//! The variance that the noise of a pixel should have, in closed form. Tests hold captures against it, and
//! weights for noisy data can be had without simulating.

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

impl Sensor {
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
