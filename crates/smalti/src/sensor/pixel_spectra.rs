//! The light on every pixel, per wavelength: gathered over photodetectors once, then seen through any filters.
//!
//! A capture integrates an optical image over wavelength, for each channel, and then over photodetectors. Both are linear
//! and may change places. What comes first is then the same for every colour filter array before the same lens on pixels
//! of the same geometry.

use rayon::prelude::*;

use super::collect::{LARGEST_RATE, Rates};
use super::{ColorArchitecture, MAX_SAMPLES, Sensor, SensorError};
use crate::numeric::Rect;
use crate::optics::OpticalImage;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Lanes of a vector of pixels, and vectors that are summed side by side: enough to hide the latency of a sum.
const LANES: usize = 16;
const GROUP: usize = 4;
const STEP: usize = LANES * GROUP;

/// Photons on the photodetectors of a part of a sensor, per second and wavelength, before any filter.
///
/// It depends on the optical image and on what of the sensor gathers light: number and pitch of the pixels, fill factor,
/// aperture, crosstalk (a border of one pixel) and window. Filters, quantum efficiency, noise and converter may be
/// anything when it is captured ([`Sensor::capture`]).
#[derive(Debug, Clone, PartialEq)]
pub struct PixelSpectra {
    grid: WavelengthGrid,
    /// Of the whole sensor: rows, columns.
    pixels: [usize; 2],
    window: Rect,
    border: usize,
    /// Columns with border, to a whole number of steps; what is added sees no light.
    stride: usize,
    /// Photons s⁻¹ nm⁻¹; row, wavelength, column.
    photons: Vec<f32>,
}

impl PixelSpectra {
    /// Gathers what the read-out part of a sensor sees of an image.
    ///
    /// # Errors
    /// When the sensor is impossible, or pixels times wavelengths exceed [`MAX_SAMPLES`].
    pub fn new(sensor: &Sensor, image: &OpticalImage) -> Result<Self, SensorError> {
        sensor.validate()?;
        let (window, cube) = (sensor.read_window(), image.irradiance());
        let (grid, border) = (cube.grid(), usize::from(sensor.crosstalk.is_some()));
        let (height, width) = (window.rows + 2 * border, window.cols + 2 * border);
        let stride = width.next_multiple_of(STEP);
        let line = stride * grid.len();
        let Some(count) = line.checked_mul(height).filter(|&n| n <= MAX_SAMPLES) else {
            let (rows, cols) = (window.rows, window.cols);
            return Err(SensorError::TooLarge { rows, cols, planes: grid.len(), limit: MAX_SAMPLES });
        };
        let (rows, cols) = sensor.taps(image);
        let area = sensor.pixel.photodetector_area_m2() as f32;
        let mut photons = vec![0.0; count];
        photons.par_chunks_exact_mut(line.max(1)).enumerate().for_each(|(r, out)| {
            let mut gathered = vec![0.0; cols.used.len()];
            for (plane, out) in cube.planes().planes().zip(out.chunks_exact_mut(stride)) {
                gathered.fill(0.0);
                for (t, &w) in rows.weights_of(r).iter().enumerate() {
                    let at = (rows.used.start + rows.first(r) + t) * cube.cols() + cols.used.start;
                    for (g, l) in gathered.iter_mut().zip(&plane[at..]) {
                        *g += w * l;
                    }
                }
                for (i, o) in out.iter_mut().enumerate().take(width) {
                    let taps = cols.weights_of(i).iter().zip(gathered.get(cols.first(i)..).unwrap_or(&[]));
                    *o = taps.map(|(w, g)| w * g).sum::<f32>() * area;
                }
            }
        });
        Ok(Self { grid, pixels: [sensor.rows, sensor.cols], window, border, stride, photons })
    }

    /// The part of the sensor whose light this is.
    #[must_use]
    pub fn window(&self) -> Rect {
        self.window
    }

    /// The wavelengths.
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
        Spectrum::new(self.grid, values.collect()).ok()
    }
}

impl PixelSpectra {
    /// Photons s⁻¹ nm⁻¹ at one wavelength along a row of the whole sensor, within the window. Nothing for a row or wavelength
    /// that is not there.
    pub(crate) fn line(&self, row: usize, wavelength: usize) -> &[f32] {
        let at = |r: usize| {
            let inside = r < self.window.rows && wavelength < self.grid.len();
            inside.then(|| ((r + self.border) * self.grid.len() + wavelength) * self.stride + self.border)
        };
        let first = row.checked_sub(self.window.row).and_then(at);
        first.and_then(|at| self.photons.get(at..at + self.window.cols)).unwrap_or(&[])
    }
}

/// The light as a sensor's filters let it through.
pub(super) struct Filtered<'a> {
    light: &'a PixelSpectra,
    /// First row to be read, of those of `light`.
    first_row: usize,
    rows: usize,
    cols: usize,
    /// Per row of the tile (or per plane, where every pixel sees every channel): wavelength, then [`Self::period`] vectors of
    /// responsivities, which repeat along the row.
    weights: Vec<Vec<[f32; LANES]>>,
    /// Vectors after which the pattern along a row repeats.
    period: usize,
    /// The row of the tile that `first_row` has; `None` where there is no tile.
    phase: Option<usize>,
}

impl<'a> Filtered<'a> {
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

impl Rates for Filtered<'_> {
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
            // Where the pattern along the row stands, for each vector of the group.
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
