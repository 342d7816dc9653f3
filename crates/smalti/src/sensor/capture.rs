//! The capture: light collection, read-out and conversion, in bands of rows that are independent tasks.

use std::sync::Arc;

use rayon::prelude::*;

use super::collect::{Collector, LightBand, Rates};
use super::electron_rates::ElectronRates;
use super::pixel_spectra::{FilteredLight, PixelSpectra};
use super::read_bands::{Band, ChargeBand, Sample, SampleScale, combine_blocks};
use super::readout::{Drawn, Readout};
use super::temporal_noise::TemporalNoise;
use super::{
    Binning, BinningMode, ConversionGain, Exposure, NoiseMode, RawImage, RawSamples, Sensor, SensorError,
};
use crate::numeric::Planes;
use crate::numeric::poisson::LANES;
use crate::numeric::simd::dispatch;
use crate::optics::OpticalImage;

/// The light on a sensor.
#[derive(Debug, Clone, Copy)]
pub enum Light<'a> {
    /// Spectral irradiance, to be integrated over wavelength and photodetectors.
    Image(&'a OpticalImage),
    /// Photons on the photodetectors, to be integrated over wavelength.
    Pixels(&'a PixelSpectra),
    /// Photoelectrons per second, to be multiplied by a factor.
    Electrons(&'a ElectronRates, f64),
}

impl<'a> From<&'a OpticalImage> for Light<'a> {
    fn from(image: &'a OpticalImage) -> Self {
        Self::Image(image)
    }
}

impl<'a> From<&'a Arc<OpticalImage>> for Light<'a> {
    fn from(image: &'a Arc<OpticalImage>) -> Self {
        Self::Image(image)
    }
}

impl<'a> From<&'a PixelSpectra> for Light<'a> {
    fn from(pixels: &'a PixelSpectra) -> Self {
        Self::Pixels(pixels)
    }
}

impl<'a> From<(&'a ElectronRates, f64)> for Light<'a> {
    fn from((rates, factor): (&'a ElectronRates, f64)) -> Self {
        Self::Electrons(rates, factor)
    }
}

/// Rows per task. Results do not depend on it, but each band has its own scratch memory.
const BAND: usize = 16;

impl Sensor {
    /// Mean photoelectrons of every photodiode from light alone: after crosstalk, without saturation of the
    /// well. One plane for a mosaic, otherwise one per channel, each exposed for `time_s`.
    pub(super) fn electrons(&self, light: Light<'_>, time_s: f64) -> Result<Planes, SensorError> {
        let sensor = &*self.unbinned();
        match light {
            Light::Image(image) => Ok(sensor.electrons_from(&Collector::new(sensor, image)?, time_s)),
            Light::Pixels(pixels) => Ok(sensor.electrons_from(&FilteredLight::new(sensor, pixels)?, time_s)),
            Light::Electrons(rates, factor) => {
                rates.ensure_of(sensor, factor)?;
                let w = sensor.read_window();
                let mut out = Planes::zeros(w.rows, w.cols, sensor.sampling().planes());
                for (plane, values) in out.planes_mut().enumerate() {
                    rates.band(plane, 0, (factor * time_s) as f32, values);
                }
                Ok(out)
            }
        }
    }

    pub(super) fn electrons_from(&self, rates: &impl Rates, time_s: f64) -> Planes {
        let w = self.read_window();
        let planes = self.sampling().planes();
        let mut out = Planes::zeros(w.rows, w.cols, planes);
        let time = time_s as f32;
        for (plane, values) in out.planes_mut().enumerate() {
            let bands = values.par_chunks_mut(BAND * w.cols).enumerate();
            bands.for_each(|(b, rows)| {
                dispatch(LightBand { sensor: self, rates, plane, first_row: b * BAND, out: rows });
                rows.iter_mut().for_each(|e| *e *= time);
            });
        }
        out
    }

    /// Noise-free volts at the converter, from light alone: after full well, analog gain and offset, and
    /// clipping to the swing. One plane for a mosaic, otherwise one per channel in the order of the CFA; the
    /// size is that of the window. Pixels outside the optical image receive no light.
    ///
    /// # Errors
    /// When the sensor or the exposure is invalid, or a curve does not cover the wavelengths of the image.
    pub fn expected_volts<'a>(
        &self,
        light: impl Into<Light<'a>>,
        exposure: &Exposure,
    ) -> Result<Planes, SensorError> {
        let volts = self.read_out::<f32>((light.into(), None), exposure, NoiseMode::None, 0)?;
        let w = self.read_window();
        Ok(Planes::new(w.rows, w.cols, self.sampling().planes(), volts)?)
    }

    /// Captures a raw image. The signal chain is: light and dark current (one Poisson deviate, since a sum of
    /// Poisson variables is one) → full well → volts → gain (PRNU) and offset (DSNU) of the pixel → read
    /// noise → row and column noise → analog offset and gain → clipping to the swing → quantisation.
    ///
    /// With [binning](super::Binning), light, dark current, full well, PRNU and DSNU are those of each
    /// photodiode. Charge is summed before read noise, row and column noise, and the rest of the chain;
    /// digital samples are averaged at its end.
    ///
    /// With a converter, samples are `round(v / swing · 2^bits + black level)`, clipped to 0 to 2^bits − 1;
    /// digital binning has more bits ([`Sensor::sample_bits`]). Without one they are volts, which noise can make negative. The black level of the result is the sample
    /// without signal, the white level that at saturation (full well or swing). `seed` determines the
    /// temporal noise of this capture; fixed-pattern noise belongs to the device. Equal arguments give the
    /// same bits on any machine and for any number of threads.
    ///
    /// Pixels outside the optical image receive no light; wavelengths outside its grid count as dark. An
    /// image, its [`PixelSpectra`] and its [`ElectronRates`] give equal results up to rounding of the mean number of photoelectrons.
    ///
    /// # Errors
    /// When the sensor or the exposure is invalid, a curve does not cover the wavelengths of the light, or
    /// the spectra belong to other pixels ([`SensorError::OtherPixels`]).
    pub fn capture<'a>(
        &self,
        light: impl Into<Light<'a>>,
        exposure: &Exposure,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<RawImage, SensorError> {
        self.capture_with(light, exposure, (noise, seed), None)
    }

    /// [`Sensor::capture`] with random numbers that were drawn for the seed, if they are given. They change no bit.
    pub(crate) fn capture_with<'a>(
        &self,
        light: impl Into<Light<'a>>,
        exposure: &Exposure,
        (noise, seed): (NoiseMode, u64),
        drawn: Option<&TemporalNoise>,
    ) -> Result<RawImage, SensorError> {
        let light = (light.into(), drawn);
        let levels = self.raw_levels(exposure)?;
        let samples = if self.adc.bits == 0 {
            RawSamples::Analog(self.read_out(light, exposure, noise, seed)?)
        } else {
            RawSamples::Digital(self.read_out(light, exposure, noise, seed)?)
        };
        let (w, names) = (self.read_window(), self.cfa.channels().iter().map(|c| c.name.clone()).collect());
        Ok(RawImage::new(w.rows, w.cols, samples, self.sampling(), names, levels.black, levels.white)?)
    }

    /// The samples of the window, ordered plane, row, column.
    fn read_out<S: Sample>(
        &self,
        (light, drawn): (Light<'_>, Option<&TemporalNoise>),
        exposure: &Exposure,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<Vec<S>, SensorError> {
        self.validate()?;
        exposure.validate()?;
        self.ensure_gain(exposure)?;
        // Light falls on the photodiodes; binning combines them when they are read.
        let photodiodes = &*self.unbinned();
        let drawn = Drawn { pattern: None, noise: drawn };
        match light {
            Light::Image(image) => {
                let rates = Collector::new(photodiodes, image)?;
                self.read_out_from((photodiodes.light_bands(&rates), drawn), exposure, noise, seed)
            }
            Light::Pixels(pixels) => {
                let rates = FilteredLight::new(photodiodes, pixels)?;
                self.read_out_from((photodiodes.light_bands(&rates), drawn), exposure, noise, seed)
            }
            Light::Electrons(rates, factor) => {
                rates.ensure_of(photodiodes, factor)?;
                let band =
                    |plane, first_row, out: &mut [f32]| rates.band(plane, first_row, factor as f32, out);
                self.read_out_from((band, Drawn { pattern: rates.pattern(), ..drawn }), exposure, noise, seed)
            }
        }
    }

    /// Fills a band of rows of a plane with photoelectrons per second, after crosstalk.
    fn light_bands<'a>(&'a self, rates: &'a impl Rates) -> impl Fn(usize, usize, &mut [f32]) + Sync + 'a {
        move |plane, first_row, out| dispatch(LightBand { sensor: self, rates, plane, first_row, out })
    }

    fn read_out_from<S: Sample>(
        &self,
        (light_band, drawn): (impl Fn(usize, usize, &mut [f32]) + Sync, Drawn<'_>),
        exposure: &Exposure,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<Vec<S>, SensorError> {
        let w = self.read_window();
        let planes = self.sampling().planes();
        let high = Readout::new(self, drawn, exposure, exposure.time_s / self.captures(), (noise, seed))?;
        let share = 1.0 / self.gain_ratio(exposure);
        let (readout, second) = match exposure.conversion_gain {
            ConversionGain::High => (high, None),
            ConversionGain::Low(low) => (high.at_low_gain(low, share, false), None),
            ConversionGain::Combined(low) => {
                let second = high.at_low_gain(low, share, true);
                (high, self.combination(exposure).map(|both| (second, both)))
            }
        };
        let scale = if self.adc.bits == 0 { 1.0 } else { self.adc.levels() / self.pixel.voltage_swing_v };
        let to_sample = SampleScale {
            scale: scale as f32,
            black: self.adc.black_level_dn as f32,
            last: (self.adc.levels() - 1.0) as f32,
        };
        let mut out = vec![S::default(); w.rows * w.cols * planes];
        // Rows and columns of pixels with a reading of their own, for each sample.
        let lines = match self.binning {
            Some(Binning { side, mode: BinningMode::Digital }) => side,
            Some(Binning { mode: BinningMode::Charge, .. }) | None => 1,
        };
        let (first_col, read_cols) = (w.col * lines, w.cols * lines);
        let mut fixed_offset_v = vec![0.0; read_cols.next_multiple_of(LANES)];
        for (plane, samples) in out.chunks_exact_mut(w.rows * w.cols).enumerate() {
            readout.column_offsets(first_col as u32, plane as u32, &mut fixed_offset_v);
            samples.par_chunks_mut(BAND * w.cols).enumerate().for_each(|(b, rows)| {
                let side = self.binning_side();
                let mut light = vec![0.0; rows.len() * side * side];
                let first_row = b * BAND;
                light_band(plane, first_row * side, &mut light);
                let origin = (((w.row + first_row) * lines) as u32, first_col as u32, plane as u32);
                let read_pixels = |readout: &Readout<'_>, out: &mut [S]| {
                    dispatch(Band {
                        readout,
                        to_sample: &to_sample,
                        origin,
                        cols: read_cols,
                        fixed_offset_v: &fixed_offset_v,
                        light: &light,
                        out,
                    });
                };
                let read = |readout: &Readout<'_>, rows: &mut [S]| match self.binning {
                    None => read_pixels(readout, rows),
                    Some(binning @ Binning { mode: BinningMode::Digital, .. }) => {
                        let mut samples = vec![S::default(); light.len()];
                        read_pixels(readout, &mut samples);
                        combine_blocks(&samples, binning, self.adc.bits, w.cols, rows);
                    }
                    Some(Binning { side, mode: BinningMode::Charge }) => dispatch(ChargeBand {
                        readout,
                        to_sample: &to_sample,
                        origin,
                        side,
                        cols: w.cols,
                        fixed_offset_v: &fixed_offset_v,
                        light: &light,
                        out: rows,
                    }),
                };
                read(&readout, rows);
                if let Some((second, both)) = &second {
                    let mut bright = vec![S::default(); rows.len()];
                    read(second, &mut bright);
                    rows.iter_mut().zip(bright).for_each(|(high, low)| *high = high.with_low(low, both));
                }
            });
        }
        Ok(out)
    }
}
