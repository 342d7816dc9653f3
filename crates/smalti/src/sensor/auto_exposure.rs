//! Rules for the exposure time.

use super::{Exposure, Light, Sensor, SensorError};
use crate::numeric::{OutOfRange, Planes, require};
use crate::optics::OpticalImage;
use crate::spectrum::Spectrum;

/// A rule for the exposure time. Saturation is at the full well, the end of the swing or the last number of the
/// converter, whichever is reached first at the given gain and offset. Light and mean dark signal count; noise does not.
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
    /// At most this share of the samples, with their filters, saturates. A binned sample counts as its brightest
    /// photodiode alone would, so that none of its photodiodes saturates either.
    SaturatedShare {
        /// Share of the samples, 0 to below 1.
        share: f64,
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
        let rate = self.rate(sensor, image)?;
        self.time_for_rate(sensor, rate, exposure)
    }

    /// The metered signal of an optical image, photoelectrons per second. It is proportional to the light.
    ///
    /// # Errors
    /// When sensor or rule are invalid, or the image lies outside the sensor's window.
    pub fn rate(&self, sensor: &Sensor, image: &OpticalImage) -> Result<f64, SensorError> {
        sensor.validate()?;
        match self.metered(sensor, image)? {
            Some(spectrum) => Self::rate_of_metered(sensor, &spectrum),
            None => self.rate_of_samples(sensor, image),
        }
    }

    /// The exposure time, s, for light on the pixels, by a rule that meters all samples.
    ///
    /// # Errors
    /// As [`AutoExposure::exposure_time`]; and [`SensorError::NoLight`] for a rule that meters a point, which the light on the pixels
    /// does not contain.
    pub fn time_for_samples<'a>(
        &self,
        sensor: &Sensor,
        light: impl Into<Light<'a>>,
        exposure: &Exposure,
    ) -> Result<f64, SensorError> {
        let rate = self.rate_of_samples(sensor, light)?;
        self.time_for_rate(sensor, rate, exposure)
    }

    /// The metered signal over all samples, photoelectrons per second, each plane with the full exposure time.
    pub(crate) fn rate_of_samples<'a>(
        &self,
        sensor: &Sensor,
        light: impl Into<Light<'a>>,
    ) -> Result<f64, SensorError> {
        let share = match *self {
            Self::Mean { .. } => None,
            Self::SaturatedShare { share } => {
                require((0.0..1.0).contains(&share), "share", share, "0 to less than 1")?;
                Some(share)
            }
            Self::Specular { .. } | Self::LuminancePercentile { .. } => return Err(SensorError::NoLight),
        };
        let planes = sensor.electrons(light.into(), 1.0)?;
        let each = sensor.photodiodes_per_sample();
        let Some(share) = share else {
            let electrons = planes.data();
            return Ok(electrons.iter().map(|&e| f64::from(e)).sum::<f64>() / electrons.len() as f64 * each);
        };
        let mut electrons = match sensor.binning {
            None => planes.into_data(),
            Some(binning) => brightest_of_blocks(&planes, binning.side),
        };
        let count = electrons.len();
        // The brightest samples that may saturate are those above this rank.
        let above = (share * count as f64) as usize;
        let Some(rank) = count.checked_sub(1 + above) else { return Err(SensorError::NoLight) };
        Ok(f64::from(*electrons.select_nth_unstable_by(rank, f32::total_cmp).1) * each)
    }

    /// The irradiance, photons s⁻¹ m⁻² nm⁻¹, of the point that the rule meters; `None` for rules that
    /// meter all samples. It depends only on the image and on the part of it within the sensor's window.
    ///
    /// # Errors
    /// When the percentile is out of range, or the image lies outside the sensor's window.
    pub fn metered(&self, sensor: &Sensor, image: &OpticalImage) -> Result<Option<Spectrum>, SensorError> {
        let percentile = match *self {
            Self::Mean { .. } | Self::SaturatedShare { .. } => return Ok(None),
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
        let rate = Self::rate_of_metered(sensor, irradiance)?;
        self.time_for_rate(sensor, rate, exposure)
    }

    /// The signal of a [metered](Self::metered) irradiance in the sensor's most sensitive channel, photoelectrons per second.
    pub(crate) fn rate_of_metered(sensor: &Sensor, irradiance: &Spectrum) -> Result<f64, SensorError> {
        let grid = irradiance.grid();
        let area = sensor.pixel.photodetector_area_m2();
        let rates = sensor.spectral_responsivity_on(grid)?.into_iter().map(|channel| {
            let sum: f64 = channel.values().iter().zip(irradiance.values()).map(|(r, e)| r * e).sum();
            sum * grid.step_nm() * area
        });
        Ok(rates.fold(0.0, f64::max))
    }

    /// The exposure time, s, for a [rate](Self::rate) of the metered signal, at the gain and offset of `exposure`.
    ///
    /// # Errors
    /// When the exposure or the rule is invalid, or there is no light.
    pub fn time_for_rate(
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
        sensor.ensure_gain(&exposure)?;
        let dark_v_per_s = sensor.dark_voltage_v_per_s()? * sensor.volts_per_high_volt(&exposure);
        let volts_per_s = electrons_per_s * sensor.volts_per_electron(&exposure)
            + dark_v_per_s * sensor.photodiodes_per_reading();
        Ok(target_v / volts_per_s * sensor.captures())
    }

    /// Target of the metered signal, light plus dark signal, in volts before gain and offset.
    pub(crate) fn target_v(&self, sensor: &Sensor, exposure: &Exposure) -> Result<f64, OutOfRange> {
        let (field, fraction) = match *self {
            Self::Specular { fraction } => ("fraction", fraction),
            Self::Mean { target } | Self::LuminancePercentile { target, .. } => ("target", target),
            Self::SaturatedShare { .. } => ("share", 1.0),
        };
        require(fraction > 0.0 && fraction <= 1.0, field, fraction, "more than 0 and at most 1")?;
        let saturation_v = sensor.saturation_v(exposure) / exposure.analog_gain - exposure.analog_offset_v;
        exposure.require_offset(saturation_v > 0.0)?;
        Ok(fraction * saturation_v)
    }
}

/// The largest value of each block of `side` × `side` values, plane after plane.
fn brightest_of_blocks(planes: &Planes, side: usize) -> Vec<f32> {
    let (rows, cols) = (planes.rows() / side, planes.cols() / side);
    let mut out = vec![f32::NEG_INFINITY; rows * cols * planes.count()];
    for (plane, out) in planes.planes().zip(out.chunks_exact_mut((rows * cols).max(1))) {
        for (r, line) in plane.chunks_exact(planes.cols()).enumerate() {
            let blocks = &mut out[r / side * cols..][..cols];
            for (block, values) in blocks.iter_mut().zip(line.chunks_exact(side)) {
                *block = values.iter().fold(*block, |most, &v| most.max(v));
            }
        }
    }
    out
}

/// The sample of the image, within the sensor's window, at a percentile of illuminance.
fn sample_at_percentile(
    sensor: &Sensor,
    image: &OpticalImage,
    percentile: f64,
) -> Result<usize, SensorError> {
    let lux = image.illuminance_lux()?;
    let cols = image.irradiance().cols();
    let [rows_seen, cols_seen] = sensor.unbinned().footprint(image);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    #[test]
    fn the_brightest_of_a_block_is_that_of_its_photodiodes() {
        let mut random = Stream::new(4, 2, 0);
        for (side, rows, cols) in [(1, 3, 5), (2, 3, 4), (3, 4, 2), (4, 2, 3)] {
            let (high, wide) = (side * rows, side * cols);
            let data: Vec<f32> = (0..2 * high * wide).map(|_| random.uniform() as f32 - 0.5).collect();
            let found = brightest_of_blocks(&Planes::new(high, wide, 2, data.clone()).unwrap(), side);
            assert_eq!(found.len(), 2 * rows * cols);
            for (i, most) in found.iter().enumerate() {
                let (plane, row, col) = (i / (rows * cols), i / cols % rows, i % cols);
                let values = (0..side * side).map(|k| {
                    let (r, c) = (row * side + k / side, col * side + k % side);
                    data[(plane * high + r) * wide + c]
                });
                assert_eq!(*most, values.fold(f32::MIN, f32::max), "side {side}, block {i}");
            }
        }
    }
}
