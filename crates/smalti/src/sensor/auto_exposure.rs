//! Rules for the exposure time.

use super::{Exposure, Light, Sensor, SensorError};
use crate::numeric::{OutOfRange, require};
use crate::optics::OpticalImage;
use crate::spectrum::Spectrum;

/// A rule for the exposure time. Saturation is at the full well or the end of the swing, whichever is reached
/// first at the given gain and offset. Light and mean dark signal count; noise does not.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum AutoExposure {
    /// The point of highest illuminance reaches this fraction of saturation in its most sensitive channel, so
    /// that nothing clips. ISETCam's default rule, with 0.95.
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
    /// channel; brighter points may clip.
    LuminancePercentile {
        /// Percentile, 0–100.
        percentile: f64,
        /// Fraction of saturation, above 0, at most 1.
        target: f64,
    },
}

impl AutoExposure {
    /// The exposure time, s, for an optical image on a sensor, at the gain and offset of `exposure` (its time
    /// is ignored).
    ///
    /// # Errors
    /// When sensor, exposure or rule are invalid, or there is no light.
    pub fn exposure_time(
        &self,
        sensor: &Sensor,
        image: &OpticalImage,
        exposure: &Exposure,
    ) -> Result<f64, SensorError> {
        sensor.validate()?;
        match self.metered(sensor, image)? {
            Some(spectrum) => self.time_for_metered(sensor, &spectrum, exposure),
            None => self.time_for_mean(sensor, image, exposure),
        }
    }

    /// The exposure time, s, at which the mean over all pixels is the target of [`AutoExposure::Mean`].
    ///
    /// # Errors
    /// As [`AutoExposure::exposure_time`]; and [`SensorError::NoLight`] where the rule meters a point, which the light on the
    /// pixels does not tell.
    pub fn time_for_mean<'a>(
        &self,
        sensor: &Sensor,
        light: impl Into<Light<'a>>,
        exposure: &Exposure,
    ) -> Result<f64, SensorError> {
        if !matches!(self, Self::Mean { .. }) {
            return Err(SensorError::NoLight);
        }
        // Full exposure of every plane; divided among them below.
        let electrons = sensor.electrons(light.into(), 1.0)?;
        let sum: f64 = electrons.data().iter().map(|&e| f64::from(e)).sum();
        self.time_for_rate(sensor, sum / electrons.data().len() as f64, exposure)
    }

    /// The irradiance, photons s⁻¹ m⁻² nm⁻¹, of the point that the rule meters; `None` for the mean, which
    /// uses all points. It depends only on the image and on the part of it within the sensor's window.
    ///
    /// # Errors
    /// When the percentile is out of range, or the image lies outside the sensor's window.
    pub fn metered(&self, sensor: &Sensor, image: &OpticalImage) -> Result<Option<Spectrum>, SensorError> {
        let percentile = match *self {
            Self::Mean { .. } => return Ok(None),
            Self::Specular { .. } => 100.0,
            Self::LuminancePercentile { percentile, .. } => percentile,
        };
        require((0.0..=100.0).contains(&percentile), "percentile", percentile, "0 to 100")?;
        let at = sample_at_percentile(sensor, image, percentile)?;
        let cube = image.irradiance();
        Ok(Some(Spectrum::new(cube.grid(), cube.planes().planes().map(|p| f64::from(p[at])).collect())?))
    }

    /// The exposure time, s, for a [metered](Self::metered) irradiance in the sensor's most sensitive
    /// channel.
    ///
    /// # Errors
    /// As for [`AutoExposure::exposure_time`].
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
        let target_v = self.target_v(sensor, &exposure)?;
        if electrons_per_s <= 0.0 {
            return Err(SensorError::NoLight);
        }
        let volts_per_s =
            electrons_per_s * sensor.pixel.conversion_gain_v_per_e + sensor.dark_voltage_v_per_s()?;
        Ok(target_v / volts_per_s * sensor.captures())
    }

    /// Target of the metered signal, light plus dark signal, in volts before gain and offset.
    pub(crate) fn target_v(&self, sensor: &Sensor, exposure: &Exposure) -> Result<f64, OutOfRange> {
        let (field, fraction) = match *self {
            Self::Specular { fraction } => ("fraction", fraction),
            Self::Mean { target } | Self::LuminancePercentile { target, .. } => ("target", target),
        };
        require(fraction > 0.0 && fraction <= 1.0, field, fraction, "more than 0 and at most 1")?;
        let saturation_v = sensor.saturation_v(exposure) / exposure.analog_gain - exposure.analog_offset_v;
        exposure.require_offset(saturation_v > 0.0)?;
        Ok(fraction * saturation_v)
    }
}

/// The sample of the image, within the sensor's window, at a percentile of illuminance.
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
