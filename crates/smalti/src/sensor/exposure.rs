//! Exposure: integration time and analog gain, given or found.

use super::{ColorArchitecture, Sensor, SensorError};
use crate::optics::OpticalImage;
use crate::spectrum::Spectrum;

/// How a frame is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Integration time, s, 0 or more. Zero is a bias frame: no light, no dark current, all else. Field-sequential
    /// sensors divide it among their captures.
    pub time_s: f64,
    /// Gain between pixel and converter; it multiplies. (ISETCam divides by its "analog gain".)
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
    /// The first field that is impossible.
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

/// A rule that finds the exposure time. Saturation is where the well is full or the swing used up, whichever
/// comes first at the given gain and offset; light and mean dark signal count, noise does not.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum AutoExposure {
    /// The brightest point (by illuminance) of what the sensor sees reaches this fraction of saturation in its
    /// most sensitive channel: nothing clips. ISETCam's default rule, with 0.95.
    Specular {
        /// Fraction of saturation, above 0, at most 1.
        fraction: f64,
    },
    /// The mean over all pixels reaches this fraction of saturation.
    Mean {
        /// Fraction of saturation, above 0, at most 1.
        target: f64,
    },
    /// The point at this percentile of illuminance reaches this fraction of saturation in its most sensitive
    /// channel; brighter ones may clip.
    LuminancePercentile {
        /// Percentile, 0–100.
        percentile: f64,
        /// Fraction of saturation, above 0, at most 1.
        target: f64,
    },
}

impl AutoExposure {
    /// The exposure time, s, for a sensor before an image, at the gain and offset of `exposure` (its time is not
    /// looked at).
    ///
    /// # Errors
    /// When sensor, exposure or rule are impossible, or there is no light.
    pub fn exposure_time(
        &self,
        sensor: &Sensor,
        image: &OpticalImage,
        exposure: &Exposure,
    ) -> Result<f64, SensorError> {
        sensor.validate()?;
        match self.metered(sensor, image)? {
            Some(spectrum) => self.time_for_metered(sensor, &spectrum, exposure),
            None => {
                // Full exposure to every plane, shared below.
                let electrons = sensor.electrons(image, 1.0)?;
                let sum: f64 = electrons.data().iter().map(|&e| f64::from(e)).sum();
                self.time_for_rate(sensor, sum / electrons.data().len() as f64, exposure)
            }
        }
    }

    /// The irradiance, photons s⁻¹ m⁻² nm⁻¹, of the point that the rule looks at; `None` for the mean, which looks at all.
    /// It depends on the part of the image that is read out, and on nothing else of the sensor.
    ///
    /// # Errors
    /// When the percentile is impossible, or the sensor sees nothing of the image.
    pub fn metered(&self, sensor: &Sensor, image: &OpticalImage) -> Result<Option<Spectrum>, SensorError> {
        let percentile = match *self {
            Self::Mean { .. } => return Ok(None),
            Self::Specular { .. } => 100.0,
            Self::LuminancePercentile { percentile, .. } => percentile,
        };
        if !(0.0..=100.0).contains(&percentile) {
            let (field, expected) = ("percentile", "0 to 100");
            return Err(SensorError::AutoExposure { field, value: percentile, expected });
        }
        let at = sample_at_percentile(sensor, image, percentile)?;
        let cube = image.irradiance();
        Ok(Some(Spectrum::new(cube.grid(), cube.planes().planes().map(|p| f64::from(p[at])).collect())?))
    }

    /// The exposure time, s, that a [metered](Self::metered) irradiance asks for in the sensor's most sensitive channel.
    ///
    /// # Errors
    /// As [`AutoExposure::exposure_time`].
    pub fn time_for_metered(
        &self,
        sensor: &Sensor,
        irradiance: &Spectrum,
        exposure: &Exposure,
    ) -> Result<f64, SensorError> {
        let grid = irradiance.grid();
        let area = sensor.pixel.photodetector_area_m2();
        let rates = sensor.spectral_responsivity_on(grid)?.into_iter().map(|channel| {
            let sum: f64 = channel.values().iter().zip(irradiance.values()).map(|(r, e)| r * e).sum();
            sum * grid.step_nm() * area
        });
        self.time_for_rate(sensor, rates.fold(0.0, f64::max), exposure)
    }

    fn time_for_rate(
        &self,
        sensor: &Sensor,
        electrons_per_s: f64,
        exposure: &Exposure,
    ) -> Result<f64, SensorError> {
        let exposure = Exposure { time_s: 1.0, ..*exposure };
        exposure.validate()?;
        let (field, fraction) = match *self {
            Self::Specular { fraction } => ("fraction", fraction),
            Self::Mean { target } | Self::LuminancePercentile { target, .. } => ("target", target),
        };
        if !(fraction > 0.0 && fraction <= 1.0) {
            let expected = "more than 0 and at most 1";
            return Err(SensorError::AutoExposure { field, value: fraction, expected });
        }
        if electrons_per_s <= 0.0 {
            return Err(SensorError::NoLight);
        }
        let volts_per_s =
            electrons_per_s * sensor.pixel.conversion_gain_v_per_e + sensor.dark_voltage_v_per_s()?;
        let captures = match sensor.architecture {
            ColorArchitecture::FieldSequential => sensor.cfa.channels().len() as f64,
            ColorArchitecture::Mosaic | ColorArchitecture::Prism => 1.0,
        };
        let saturation_v = sensor.saturation_v(&exposure) / exposure.analog_gain - exposure.analog_offset_v;
        if saturation_v <= 0.0 {
            return Err(SensorError::AnalogOffset { value: exposure.analog_offset_v });
        }
        Ok(fraction * saturation_v / volts_per_s * captures)
    }
}

/// The sample of the image (within what the sensor sees) that has the given percentile of illuminance.
fn sample_at_percentile(
    sensor: &Sensor,
    image: &OpticalImage,
    percentile: f64,
) -> Result<usize, SensorError> {
    let lux = image.illuminance_lux()?;
    let cols = image.irradiance().cols();
    let [rows_seen, cols_seen] = sensor.footprint(image);
    let mut seen: Vec<(f32, usize)> = rows_seen
        .flat_map(|r| cols_seen.clone().map(move |c| r * cols + c))
        .filter_map(|at| lux.get(at).map(|&v| (v, at)))
        .collect();
    if seen.is_empty() {
        return Err(SensorError::NoLight);
    }
    let rank = (percentile / 100.0 * (seen.len() - 1) as f64).round() as usize;
    let rank = rank.min(seen.len() - 1);
    let (_, &mut (_, at), _) =
        seen.select_nth_unstable_by(rank, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    Ok(at)
}
