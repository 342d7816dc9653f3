//! Spectra per pixel: light that is collected over photodetectors once and then filtered by any colour filter
//! array.
//!
//! A capture integrates an optical image over wavelength, for each channel, and over photodetectors. Both are
//! linear, so their order can be exchanged. The integral over photodetectors is then common to every colour
//! filter array with the same lens and pixel geometry.

use rayon::prelude::*;

use super::collect::{LARGEST_RATE, Rates};
use super::geometry::{EvenTaps, Taps};
use super::{ColorArchitecture, MAX_SAMPLES, Sensor, SensorError};
use crate::numeric::simd::{Kernel, dispatch};
use crate::numeric::{Planes, Rect};
use crate::optics::OpticalImage;
use crate::spectrum::{Spectrum, SpectrumError, WavelengthGrid};

/// Lanes of a pixel vector. Several vectors are summed in parallel to hide the latency of additions.
const LANES: usize = 16;
const GROUP: usize = 4;
const STEP: usize = LANES * GROUP;

/// Photons on the photodetectors of a window, per second and wavelength, before any filter. With binning they are
/// those of the single photodiodes ([`Sensor::unbinned`]).
///
/// They depend on the optical image and on the parts of the sensor that collect light: number and pitch of
/// the pixels, fill factor, aperture, crosstalk (a border of one pixel) and window. Filters, quantum
/// efficiency, noise and converter can vary between captures ([`Sensor::capture`]).
#[derive(Debug, Clone, PartialEq)]
pub struct PixelSpectra {
    grid: WavelengthGrid,
    /// Rows and columns of the whole sensor.
    pixels: [usize; 2],
    window: Rect,
    border: usize,
    /// Columns with border, padded to a whole number of steps; the padding receives no light.
    stride: usize,
    /// Photons s⁻¹ nm⁻¹, ordered row, wavelength, column.
    photons: Vec<f32>,
}

impl PixelSpectra {
    /// Collects the light of an image over the window of a sensor.
    ///
    /// # Errors
    /// When the sensor is invalid, or pixels times wavelengths exceed [`MAX_SAMPLES`].
    pub fn new(sensor: &Sensor, image: &OpticalImage) -> Result<Self, SensorError> {
        sensor.validate()?;
        let sensor = &*sensor.unbinned();
        let mut spectra = Self::dark(sensor, image.irradiance().grid())?;
        let pixels = Photodetectors::of(sensor, image, &spectra);
        let rows = spectra.rows_mut();
        rows.for_each_init(Vec::new, |gathered, (r, out)| pixels.collect(r, gathered, out));
        Ok(spectra)
    }

    /// [`PixelSpectra::new`] of a sensor without binning, on one thread.
    pub(super) fn on_one_thread(sensor: &Sensor, image: &OpticalImage) -> Result<Self, SensorError> {
        let mut spectra = Self::dark(sensor, image.irradiance().grid())?;
        let pixels = Photodetectors::of(sensor, image, &spectra);
        let (len, mut gathered) = (spectra.stride * spectra.grid.len(), Vec::new());
        let rows = spectra.photons.chunks_exact_mut(len).enumerate();
        rows.for_each(|(r, out)| pixels.collect(r, &mut gathered, out));
        Ok(spectra)
    }

    /// No light on any pixel of the window and its border.
    fn dark(sensor: &Sensor, grid: WavelengthGrid) -> Result<Self, SensorError> {
        let (window, border) = (sensor.read_window(), usize::from(sensor.crosstalk.is_some()));
        let (height, width) = (window.rows + 2 * border, window.cols + 2 * border);
        let stride = width.next_multiple_of(STEP);
        let Some(count) = (stride * grid.len()).checked_mul(height).filter(|&n| n <= MAX_SAMPLES) else {
            let (rows, cols) = (window.rows, window.cols);
            return Err(SensorError::TooLarge { rows, cols, planes: grid.len(), limit: MAX_SAMPLES });
        };
        let (pixels, photons) = ([sensor.rows, sensor.cols], vec![0.0; count]);
        Ok(Self { grid, pixels, window, border, stride, photons })
    }

    /// The rows with the border: wavelength, column.
    fn rows_mut(&mut self) -> impl IndexedParallelIterator<Item = (usize, &mut [f32])> {
        self.photons.par_chunks_exact_mut(self.stride * self.grid.len()).enumerate()
    }

    /// The sum of planes times their spectra, plane₀ · spectrum₀ + plane₁ · spectrum₁ + …, photons s⁻¹ nm⁻¹, clipped at 0. The
    /// planes have the size of the sensor, in photodiodes; only the light in its window is summed. The pixels around the sensor receive the
    /// light of its outermost pixels.
    ///
    /// # Errors
    /// When the sensor is invalid, the sizes of planes and spectra do not match it or each other, pixels times wavelengths exceed [`MAX_SAMPLES`], or the light on a pixel is NaN or infinite.
    pub fn of_components(
        sensor: &Sensor,
        planes: &Planes,
        spectra: &[Spectrum],
    ) -> Result<Self, SensorError> {
        sensor.validate()?;
        let sensor = &*sensor.unbinned();
        let (rows, cols) = (sensor.rows, sensor.cols);
        let (window, gathered) =
            (sensor.read_window(), Rect { row: 0, col: 0, rows: planes.rows(), cols: planes.cols() });
        let grid = spectra.first().map(Spectrum::grid).ok_or(SensorError::NoLight)?;
        let like = planes.count() == spectra.len() && spectra.iter().all(|s| s.grid() == grid);
        if !like || [rows, cols] != [planes.rows(), planes.cols()] {
            return Err(SensorError::OtherPixels { window, gathered });
        }
        let mut light = Self::dark(sensor, grid)?;
        let (border, stride) = (light.border, light.stride);
        light.rows_mut().try_for_each(|(r, out)| {
            let row = (window.row + r).saturating_sub(border).min(rows - 1);
            // The columns of the sensor that are summed, and where the first of them lies in the row.
            let first = window.col.saturating_sub(border);
            let end = (window.col + window.cols + border).min(cols);
            let place = first + border - window.col;
            for (i, out) in out.chunks_exact_mut(stride).enumerate() {
                let inner = &mut out[place..place + end - first];
                for (plane, spectrum) in planes.planes().zip(spectra) {
                    let weight = spectrum.values()[i] as f32;
                    let line = &plane[row * cols + first..row * cols + end];
                    inner.iter_mut().zip(line).for_each(|(o, l)| *o += weight * l);
                }
                if let Some(&bad) = inner.iter().find(|o| !o.is_finite()) {
                    return Err(SpectrumError::Value {
                        quantity: "the light on a pixel",
                        wavelength_nm: grid.wavelength_nm(i),
                        value: bad.into(),
                        expected: "a finite number was expected",
                    });
                }
                inner.iter_mut().for_each(|o| *o = o.max(0.0));
                if place > 0 {
                    out[0] = out[1];
                }
                let width = window.cols + 2 * border;
                if place + end - first < width {
                    out[width - 1] = out[width - 2];
                }
            }
            Ok(())
        })?;
        Ok(light)
    }

    /// The window, in photodiodes.
    #[must_use]
    pub fn window(&self) -> Rect {
        self.window
    }

    /// The wavelength grid.
    #[must_use]
    pub fn grid(&self) -> WavelengthGrid {
        self.grid
    }

    /// Photons s⁻¹ nm⁻¹ of a pixel of the whole sensor; `None` outside the window.
    #[must_use]
    pub fn spectrum(&self, row: usize, col: usize) -> Option<Spectrum> {
        let (r, c) = (row.checked_sub(self.window.row)?, col.checked_sub(self.window.col)?);
        if r >= self.window.rows || c >= self.window.cols {
            return None;
        }
        let values = (0..self.grid.len()).map(|i| self.line(row, i).get(c).map_or(0.0, |&v| f64::from(v)));
        // The light on the pixels is finite, whether it comes from an image or from components.
        Spectrum::new(self.grid, values.collect()).ok()
    }
}

impl PixelSpectra {
    /// Photons s⁻¹ nm⁻¹ at one wavelength along a row of the whole sensor, within the window. Empty for a row
    /// or wavelength outside.
    pub(crate) fn line(&self, row: usize, wavelength: usize) -> &[f32] {
        let at = |r: usize| {
            let inside = r < self.window.rows && wavelength < self.grid.len();
            inside.then(|| ((r + self.border) * self.grid.len() + wavelength) * self.stride + self.border)
        };
        let first = row.checked_sub(self.window.row).and_then(at);
        first.and_then(|at| self.photons.get(at..at + self.window.cols)).unwrap_or(&[])
    }
}

/// The photodetectors of a window before an image.
struct Photodetectors<'a> {
    /// The image at each wavelength, and its columns.
    planes: Vec<&'a [f32]>,
    image_cols: usize,
    rows: Taps,
    cols: Taps,
    even: EvenTaps,
    /// Of a photodetector, m².
    area: f32,
    /// Columns with border, without and with padding.
    width: usize,
    stride: usize,
}

impl<'a> Photodetectors<'a> {
    fn of(sensor: &Sensor, image: &'a OpticalImage, spectra: &PixelSpectra) -> Self {
        let (cube, (rows, cols)) = (image.irradiance(), sensor.taps(image));
        Self {
            planes: cube.planes().planes().collect(),
            image_cols: cube.cols(),
            even: cols.even(),
            rows,
            cols,
            area: sensor.pixel.photodetector_area_m2() as f32,
            width: spectra.window.cols + 2 * spectra.border,
            stride: spectra.stride,
        }
    }

    /// Collects the light of a row at all wavelengths. `gathered` is scratch memory.
    fn collect(&self, row: usize, gathered: &mut Vec<f32>, out: &mut [f32]) {
        dispatch(PixelRow { pixels: self, row, gathered, out });
    }
}

/// A row of pixels, at all wavelengths.
struct PixelRow<'a> {
    pixels: &'a Photodetectors<'a>,
    row: usize,
    gathered: &'a mut Vec<f32>,
    out: &'a mut [f32],
}

impl Kernel for PixelRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pixels, row, gathered, out } = self;
        let Photodetectors { planes, image_cols, rows, cols, even, area, width, stride } = pixels;
        let (first, used) =
            ((rows.used.start + rows.first(row)) * image_cols + cols.used.start, cols.used.len());
        let together = if (1..=4).contains(&even.step) { even.pixels.clone() } else { 0..0 };
        for (plane, out) in planes.iter().zip(out.chunks_exact_mut(*stride)) {
            gathered.clear();
            // Steps of the last pixels extend beyond the last sample.
            gathered.resize(used + even.step, 0.0);
            for (t, &w) in rows.weights_of(row).iter().enumerate() {
                let at = first + t * image_cols;
                for (g, l) in gathered.iter_mut().zip(&plane[at..at + used]) {
                    *g += w * l;
                }
            }
            let evenly = &mut out[together.clone()];
            match even.step {
                1 => along_row::<1>(even, gathered, *area, evenly),
                2 => along_row::<2>(even, gathered, *area, evenly),
                3 => along_row::<3>(even, gathered, *area, evenly),
                4 => along_row::<4>(even, gathered, *area, evenly),
                _ => {}
            }
            for i in (0..together.start).chain(together.end..*width) {
                let taps = cols.weights_of(i).iter().zip(gathered.get(cols.first(i)..).unwrap_or(&[]));
                out[i] = taps.map(|(w, g)| w * g).sum::<f32>() * area;
            }
        }
    }
}

/// The light of the pixels of an even run, `STEP` samples apart.
#[inline(always)]
fn along_row<const STEP: usize>(even: &EvenTaps, gathered: &[f32], area: f32, out: &mut [f32]) {
    out.fill(0.0);
    for (t, weights) in even.weights.iter().enumerate() {
        let samples = gathered[even.first + t..].as_chunks::<STEP>().0;
        for ((o, w), sample) in out.iter_mut().zip(weights).zip(samples) {
            *o += w * sample[0];
        }
    }
    out.iter_mut().for_each(|o| *o *= area);
}

/// The light after the filters of a sensor.
pub(super) struct FilteredLight<'a> {
    light: &'a PixelSpectra,
    /// Index in `light` of the first row to read.
    first_row: usize,
    rows: usize,
    cols: usize,
    /// Per row of the tile (or per plane, where every pixel has every channel): for each wavelength,
    /// [`Self::period`] vectors of responsivities, which repeat along the row.
    weights: Vec<Vec<[f32; LANES]>>,
    /// Number of vectors after which the pattern along a row repeats.
    period: usize,
    /// The row of the tile at `first_row`; `None` without a mosaic.
    phase: Option<usize>,
}

impl<'a> FilteredLight<'a> {
    pub(super) fn new(sensor: &Sensor, light: &'a PixelSpectra) -> Result<Self, SensorError> {
        let (window, border) = (sensor.read_window(), light.border);
        let inside =
            window.row.checked_sub(light.window.row).filter(|r| r + window.rows <= light.window.rows);
        let (Some(first_row), true, true) = (
            inside,
            [sensor.rows, sensor.cols] == light.pixels && border == usize::from(sensor.crosstalk.is_some()),
            (window.col, window.cols) == (light.window.col, light.window.cols),
        ) else {
            return Err(SensorError::OtherPixels { window, gathered: light.window });
        };
        let step_nm = light.grid.step_nm();
        let responsivity = sensor.spectral_responsivity_on(light.grid)?;
        let responsivity: Vec<Vec<f32>> =
            responsivity.iter().map(|r| r.values().iter().map(|v| (v * step_nm) as f32).collect()).collect();
        let mosaic = sensor.cfa.mosaic();
        // Dummy pixels continue the mosaic before the first row and column.
        let before = |at: usize, period: usize| (at + border * (period - 1)) % period;
        let (lines, period, phase) = match sensor.architecture {
            ColorArchitecture::Mosaic => {
                (mosaic.rows(), mosaic.cols(), Some(before(window.row, mosaic.rows())))
            }
            ColorArchitecture::Prism | ColorArchitecture::FieldSequential => (responsivity.len(), 1, None),
        };
        let weights = (0..lines).map(|line| {
            let channel = |at: usize| match sensor.architecture {
                ColorArchitecture::Mosaic => mosaic.channel_at(line, before(window.col, mosaic.cols()) + at),
                ColorArchitecture::Prism | ColorArchitecture::FieldSequential => line,
            };
            let channels: Vec<usize> = (0..period * LANES).map(channel).collect();
            let of = |i: usize, lanes: &[usize]| -> [f32; LANES] {
                std::array::from_fn(|l| lanes.get(l).and_then(|&c| responsivity.get(c)).map_or(0.0, |r| r[i]))
            };
            (0..light.grid.len()).flat_map(|i| channels.chunks(LANES).map(move |c| of(i, c))).collect()
        });
        Ok(Self {
            light,
            first_row,
            rows: window.rows + 2 * border,
            cols: window.cols + 2 * border,
            weights: weights.collect(),
            period,
            phase,
        })
    }
}

impl Rates for FilteredLight<'_> {
    fn size(&self) -> (usize, usize) {
        (self.rows, self.cols)
    }

    #[inline(always)]
    fn gather_row(&self, row: usize, plane: usize, _: &mut Vec<f32>, out: &mut [f32]) {
        let (count, stride) = (self.light.grid.len(), self.light.stride);
        let weights = &self.weights[self.phase.map_or(plane, |phase| (phase + row) % self.weights.len())];
        let at = (self.first_row + row) * count * stride;
        let photons = &self.light.photons[at..at + count * stride];
        for (g, out) in out.chunks_mut(STEP).enumerate() {
            let mut sums = [[0.0f32; LANES]; GROUP];
            // Position in the pattern along the row, for each vector of the group.
            let places: [usize; GROUP] = std::array::from_fn(|k| (g * GROUP + k) % self.period);
            for i in 0..count {
                let from = i * stride + g * STEP;
                let (light, _) = photons[from..from + STEP].as_chunks::<LANES>();
                for k in 0..GROUP {
                    let w = &weights[i * self.period + places[k]];
                    for l in 0..LANES {
                        sums[k][l] += w[l] * light[k][l];
                    }
                }
            }
            for (o, s) in out.iter_mut().zip(sums.as_flattened()) {
                *o = s.min(LARGEST_RATE);
            }
        }
    }
}
