//! The capture: light gathered, read out and converted, in bands of rows that any thread may take.

use std::sync::Arc;

use rayon::prelude::*;

use super::collect::{Collector, Rates};
use super::pixel_spectra::{Filtered, PixelSpectra};
use super::readout::Readout;
use super::{ColorArchitecture, Exposure, RawImage, RawSamples, Sensor, SensorError};
use crate::numeric::Planes;
use crate::numeric::poisson::LANES;
use crate::numeric::simd::{Kernel, dispatch};
use crate::optics::OpticalImage;

/// Which noise a capture has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoiseMode {
    /// None: what light alone gives on a perfect device, without dark signal and fixed pattern; saturation and
    /// quantisation as in the real thing. ISETCam's noise-free volts.
    None,
    /// Photon shot noise, and nothing else that [`NoiseMode::None`] has not.
    PhotonOnly,
    /// Everything.
    #[default]
    All,
}

/// What falls on a sensor.
#[derive(Debug, Clone, Copy)]
pub enum Light<'a> {
    /// Irradiance, to be integrated over wavelength and photodetectors.
    Image(&'a OpticalImage),
    /// Photons on the photodetectors, to be integrated over wavelength.
    Pixels(&'a PixelSpectra),
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

/// Rows that one task takes. Fixed: results do not depend on it, but scratch is per band.
const BAND: usize = 16;

impl Sensor {
    /// Mean photoelectrons of every pixel: light alone, after crosstalk, without limit by the well. One plane for
    /// a mosaic, one per channel otherwise, each exposed for `time_s`.
    pub(super) fn electrons(&self, image: &OpticalImage, time_s: f64) -> Result<Planes, SensorError> {
        let (collector, w) = (Collector::new(self, image)?, self.read_window());
        let planes = self.sampling().planes();
        let mut out = Planes::zeros(w.rows, w.cols, planes);
        let time = time_s as f32;
        for plane in 0..planes {
            let bands = out.plane_mut(plane).par_chunks_mut(BAND * w.cols).enumerate();
            bands.for_each(|(b, rows)| {
                dispatch(LightBand {
                    sensor: self,
                    rates: &collector,
                    plane,
                    first_row: b * BAND,
                    out: rows,
                });
                rows.iter_mut().for_each(|e| *e *= time);
            });
        }
        Ok(out)
    }

    /// Volts at the converter without noise: light alone, after full well, analog gain and offset and clipping to
    /// the swing. One plane for a mosaic, one per channel (in the order of the CFA) otherwise; the size is that of
    /// the window. Pixels that lie beyond the optical image see no light.
    ///
    /// # Errors
    /// When sensor or exposure are impossible, or a curve does not cover the wavelengths of the image.
    pub fn expected_volts(&self, image: &OpticalImage, exposure: &Exposure) -> Result<Planes, SensorError> {
        let (volts, rows, cols, planes) = self.read_out::<f32>(image.into(), exposure, NoiseMode::None, 0)?;
        Ok(Planes::new(rows, cols, planes, volts)?)
    }

    /// Takes a picture. The order in the pixel: light and dark current (one Poisson draw, since a sum of Poisson
    /// numbers is one) → full well → volts → gain and offset of the pixel → read noise → row and column noise →
    /// analog offset and gain → clip to the swing → quantisation.
    ///
    /// With a converter, samples are `round(v / swing · 2^bits + black level)` within 0 to 2^bits − 1; without,
    /// volts, of which noise may be below zero. The black level of the result is the sample of no signal, the white
    /// level that of saturation (full well or swing). `seed` names the noise of this capture; the fixed pattern
    /// belongs to the device. The same arguments give the same bits on any machine and number of threads.
    ///
    /// Pixels that lie beyond the optical image see no light; wavelengths beyond it count as dark. An image and the
    /// [`PixelSpectra`] of it give the same but for rounding in the mean number of photoelectrons.
    ///
    /// # Errors
    /// When sensor or exposure are impossible, a curve does not cover the wavelengths of the light, or spectra were
    /// gathered by other pixels ([`SensorError::OtherPixels`]).
    pub fn capture<'a>(
        &self,
        light: impl Into<Light<'a>>,
        exposure: &Exposure,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<RawImage, SensorError> {
        let (levels, light) = (self.raw_levels(exposure)?, light.into());
        let (samples, rows, cols) = if self.adc.bits == 0 {
            let (v, rows, cols, _) = self.read_out::<f32>(light, exposure, noise, seed)?;
            (RawSamples::Analog(v), rows, cols)
        } else {
            let (v, rows, cols, _) = self.read_out::<u16>(light, exposure, noise, seed)?;
            (RawSamples::Digital(v), rows, cols)
        };
        let names = self.cfa.channels().iter().map(|c| c.name.clone()).collect();
        Ok(RawImage::new(rows, cols, samples, self.sampling(), names, levels.black, levels.white)?)
    }

    /// Samples with rows, columns and planes.
    fn read_out<S: Sample>(
        &self,
        light: Light<'_>,
        exposure: &Exposure,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<(Vec<S>, usize, usize, usize), SensorError> {
        self.validate()?;
        exposure.validate()?;
        match light {
            Light::Image(image) => self.read_out_from(&Collector::new(self, image)?, exposure, noise, seed),
            Light::Pixels(pixels) => self.read_out_from(&Filtered::new(self, pixels)?, exposure, noise, seed),
        }
    }

    fn read_out_from<S: Sample>(
        &self,
        rates: &impl Rates,
        exposure: &Exposure,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<(Vec<S>, usize, usize, usize), SensorError> {
        let w = self.read_window();
        let planes = self.sampling().planes();
        let time_s = match self.architecture {
            ColorArchitecture::FieldSequential => exposure.time_s / planes as f64,
            ColorArchitecture::Mosaic | ColorArchitecture::Prism => exposure.time_s,
        };
        let readout = Readout::new(self, exposure, time_s, noise, seed)?;
        let scale = if self.adc.bits == 0 { 1.0 } else { self.adc.levels() / self.pixel.voltage_swing_v };
        let to_sample = ToSample {
            scale: scale as f32,
            black: self.adc.black_level_dn as f32,
            last: (self.adc.levels() - 1.0) as f32,
        };
        let mut out = vec![S::default(); w.rows * w.cols * planes];
        let mut fixed_offset_v = vec![0.0; w.cols.next_multiple_of(LANES)];
        for (plane, samples) in out.chunks_exact_mut(w.rows * w.cols).enumerate() {
            readout.column_offsets(w.col as u32, plane as u32, &mut fixed_offset_v);
            samples.par_chunks_mut(BAND * w.cols).enumerate().for_each(|(b, rows)| {
                let mut light = vec![0.0; rows.len()];
                let first_row = b * BAND;
                dispatch(LightBand { sensor: self, rates, plane, first_row, out: &mut light });
                dispatch(Band {
                    readout: &readout,
                    to_sample: &to_sample,
                    origin: ((w.row + first_row) as u32, w.col as u32, plane as u32),
                    cols: w.cols,
                    fixed_offset_v: &fixed_offset_v,
                    light: &light,
                    out: rows,
                });
            });
        }
        Ok((out, w.rows, w.cols, planes))
    }
}

/// Photoelectrons per second of a band of rows, after crosstalk.
struct LightBand<'a, R> {
    sensor: &'a Sensor,
    rates: &'a R,
    plane: usize,
    first_row: usize,
    out: &'a mut [f32],
}

impl<R: Rates> Kernel for LightBand<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let cols = self.sensor.read_window().cols;
        let (_, width) = self.rates.size();
        let mut lines = Vec::new();
        let Some(kernel) = &self.sensor.crosstalk else {
            for (i, row) in self.out.chunks_exact_mut(cols).enumerate() {
                self.rates.gather_row(self.first_row + i, self.plane, &mut lines, row);
            }
            return;
        };
        let rows = self.out.len() / cols;
        let mut wide = vec![0.0; (rows + 2) * width];
        for (i, row) in wide.chunks_exact_mut(width).enumerate() {
            self.rates.gather_row(self.first_row + i, self.plane, &mut lines, row);
        }
        self.out.fill(0.0);
        for (i, row) in self.out.chunks_exact_mut(cols).enumerate() {
            for (dy, weights) in kernel.iter().enumerate() {
                for (dx, &weight) in weights.iter().enumerate() {
                    // What pixel (r, c) gives to (r + dy − 1, c + dx − 1), seen from there.
                    let at = (i + 2 - dy) * width + 2 - dx;
                    let weight = weight as f32;
                    for (o, l) in row.iter_mut().zip(&wide[at..at + cols]) {
                        *o += weight * l;
                    }
                }
            }
        }
    }
}

/// Scale from volts to samples.
struct ToSample {
    scale: f32,
    black: f32,
    last: f32,
}

/// What a converter gives.
trait Sample: Copy + Default + Send + Sync {
    fn from_volts(volts: f32, to: &ToSample) -> Self;
}

impl Sample for f32 {
    #[inline(always)]
    fn from_volts(volts: f32, _: &ToSample) -> Self {
        volts
    }
}

impl Sample for u16 {
    #[inline(always)]
    fn from_volts(volts: f32, to: &ToSample) -> Self {
        // Not negative here, so that cutting off after adding a half rounds.
        let number = (volts * to.scale + to.black).max(0.0).min(to.last);
        (number + 0.5) as i32 as u16
    }
}

/// Read-out of a band of rows.
struct Band<'a, S> {
    readout: &'a Readout,
    to_sample: &'a ToSample,
    /// Row, column and plane of the first pixel.
    origin: (u32, u32, u32),
    cols: usize,
    /// Per column, to a whole number of blocks.
    fixed_offset_v: &'a [f32],
    light: &'a [f32],
    out: &'a mut [S],
}

impl<S: Sample> Kernel for Band<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (row, col, plane) = self.origin;
        let rows = self.out.chunks_exact_mut(self.cols).zip(self.light.chunks_exact(self.cols));
        for (r, (out, light)) in rows.enumerate() {
            let blocks =
                out.chunks_mut(LANES).zip(light.chunks(LANES)).zip(self.fixed_offset_v.as_chunks().0);
            for (b, ((out, light), fixed)) in blocks.enumerate() {
                let mut lanes = [0.0; LANES];
                lanes[..light.len()].copy_from_slice(light);
                let mut volts = [0.0; LANES];
                let at = (row.wrapping_add(r as u32), col.wrapping_add((b * LANES) as u32), plane);
                self.readout.block(at, &lanes, fixed, &mut volts);
                for (o, &v) in out.iter_mut().zip(&volts) {
                    *o = S::from_volts(v, self.to_sample);
                }
            }
        }
    }
}
