//! From the optical image to photoelectrons per second: integration over wavelength for each channel, at the
//! resolution of the image, and then over the aperture of each pixel.

use std::ops::Range;

use rayon::prelude::*;

use super::geometry::{AxisGeometry, Taps};
use super::{ColorArchitecture, Sensor, SensorError};
use crate::numeric::simd::{Kernel, dispatch};
use crate::optics::OpticalImage;
use crate::spectrum::Spectrum;

/// A source of photoelectron rates before crosstalk.
pub(super) trait Rates: Sync {
    /// Rows and columns of available pixels: the window with its border.
    fn size(&self) -> (usize, usize);

    /// Photoelectrons per second of row `row` (relative to [`Rates::size`]) of a plane of samples. `lines` is
    /// scratch memory. Must be `#[inline(always)]`.
    fn gather_row(&self, row: usize, plane: usize, lines: &mut Vec<f32>, out: &mut [f32]);
}

/// The light on a sensor, integrated over wavelength, for row-by-row collection.
pub(super) struct Collector<'a> {
    pub(super) sensor: &'a Sensor,
    /// Photoelectrons per second of a photodetector that a sample covers completely: row, channel, column.
    rates: Vec<f32>,
    channels: usize,
    width: usize,
    rows: Taps,
    cols: Taps,
    /// Sensor row and column of the first value of `rows`.
    origin: [i64; 2],
}

/// Photoelectrons per second above which `f32` sums could overflow.
pub(super) const LARGEST_RATE: f32 = 1e30;

impl Sensor {
    fn axes(&self, image: &OpticalImage) -> [AxisGeometry; 2] {
        let cube = image.irradiance();
        let spacing = image.sample_spacing_m();
        [(self.rows, cube.rows()), (self.cols, cube.cols())].map(|(pixels, samples)| AxisGeometry {
            pixels,
            pitch_in_samples: self.pixel.pitch_m / spacing,
            side_in_samples: self.pixel.pitch_m * self.pixel.fill_factor.sqrt() / spacing,
            samples,
            aperture: self.aperture,
        })
    }

    /// Rows and columns of the window, with the border of dummy pixels that crosstalk needs.
    fn gathered(&self) -> [Range<i64>; 2] {
        let w = self.read_window();
        let border = i64::from(self.crosstalk.is_some());
        [(w.row, w.rows), (w.col, w.cols)]
            .map(|(first, count)| first as i64 - border..(first + count) as i64 + border)
    }

    /// The samples of the image that contribute to the rows and columns of pixels.
    pub(super) fn taps(&self, image: &OpticalImage) -> (Taps, Taps) {
        let [rows, cols] = self.axes(image);
        let [row_range, col_range] = self.gathered();
        (rows.taps(row_range), cols.taps(col_range))
    }

    /// Whether this sensor, without binning, collects the same light as another, before any filter.
    pub(super) fn collects_as(&self, other: &Self) -> bool {
        let of = |s: &Self| {
            let (pixel, border) = (&s.pixel, s.crosstalk.is_some());
            (s.rows, s.cols, s.read_window(), pixel.pitch_m, pixel.fill_factor, s.aperture, border)
        };
        of(self) == of(other)
    }

    /// Whether pixels are smaller than the samples of an image. Rounding does not decide.
    pub(super) fn is_finer_than(&self, image: &OpticalImage) -> bool {
        self.pixel.pitch_m < 0.999 * image.sample_spacing_m()
    }

    /// Rows and columns of the image within the field of view of the window.
    pub(super) fn footprint(&self, image: &OpticalImage) -> [Range<usize>; 2] {
        let (rows, cols) = self.taps(image);
        [rows.used, cols.used]
    }
}

impl<'a> Collector<'a> {
    /// Integrates the visible part of the image over wavelength.
    pub(super) fn new(sensor: &'a Sensor, image: &OpticalImage) -> Result<Self, SensorError> {
        let mut collector = Self::dark(sensor, image);
        collector.integrate_with(&mut [], image)?;
        Ok(collector)
    }

    /// [`Collector::new`] for several sensors. Those that see the same part of the image share one pass of it, which takes longer than the
    /// products.
    pub(super) fn of_all(sensors: &[&'a Sensor], image: &OpticalImage) -> Result<Vec<Self>, SensorError> {
        let mut all: Vec<Self> = sensors.iter().map(|s| Self::dark(s, image)).collect();
        let mut left: Vec<&mut Self> = all.iter_mut().collect();
        while !left.is_empty() {
            let first = left.swap_remove(0);
            let (mut alike, others): (Vec<_>, Vec<_>) = left
                .into_iter()
                .partition(|c| c.rows.used == first.rows.used && c.cols.used == first.cols.used);
            first.integrate_with(&mut alike, image)?;
            left = others;
        }
        Ok(all)
    }

    /// Without light.
    fn dark(sensor: &'a Sensor, image: &OpticalImage) -> Self {
        let origin = sensor.gathered().map(|range| range.start);
        let (rows, cols) = sensor.taps(image);
        let (width, channels) = (cols.used.len(), sensor.cfa.channels().len());
        let rates = vec![0.0f32; rows.used.len() * channels * width];
        Self { sensor, rates, channels, width, rows, cols, origin }
    }

    /// The weight of every wavelength of the image, for each channel.
    fn weights(&self, image: &OpticalImage) -> Result<Vec<Vec<f32>>, SensorError> {
        let grid = image.irradiance().grid();
        let scale = grid.step_nm() * self.sensor.pixel.photodetector_area_m2();
        let weights = |r: &Spectrum| r.values().iter().map(|v| (v * scale) as f32).collect();
        Ok(self.sensor.spectral_responsivity_on(grid)?.iter().map(weights).collect())
    }

    /// Integrates an image over wavelength, also for others that see the same part of it.
    fn integrate_with(&mut self, others: &mut [&mut Self], image: &OpticalImage) -> Result<(), SensorError> {
        let mut weights = self.weights(image)?;
        for other in others.iter() {
            weights.extend(other.weights(image)?);
        }
        let (cube, width) = (image.irradiance(), self.width);
        let (first_row, first_col) = (self.rows.used.start, self.cols.used.start);
        let planes: Vec<&[f32]> = cube.planes().planes().collect();
        let mut lines: Vec<Vec<&mut [f32]>> = Vec::new();
        lines.resize_with(self.rows.used.len(), || Vec::with_capacity(weights.len()));
        for Self { rates, channels, .. } in std::iter::once(self).chain(others.iter_mut().map(|c| &mut **c)) {
            let rows = rates.chunks_exact_mut((*channels * width).max(1));
            lines
                .iter_mut()
                .zip(rows)
                .for_each(|(lines, row)| lines.extend(row.chunks_exact_mut(width.max(1))));
        }
        lines.into_par_iter().enumerate().for_each_init(Vec::new, |light, (row, out)| {
            let first = (first_row + row) * cube.cols() + first_col;
            dispatch(SpectralRow { planes: &planes, weights: &weights, first, width, light, out });
        });
        Ok(())
    }
}

impl Rates for Collector<'_> {
    fn size(&self) -> (usize, usize) {
        let [rows, cols] = self.sensor.gathered();
        ((rows.end - rows.start) as usize, (cols.end - cols.start) as usize)
    }

    #[inline(always)]
    fn gather_row(&self, row: usize, plane: usize, lines: &mut Vec<f32>, out: &mut [f32]) {
        let mosaic = self.sensor.cfa.mosaic();
        // Dummy pixels from −1 continue the mosaic.
        let wrap = |at: i64, period: usize| at.rem_euclid(period as i64) as usize;
        let tile_row = wrap(self.origin[0] + row as i64, mosaic.rows()) * mosaic.cols();
        let tile = match self.sensor.architecture {
            ColorArchitecture::Mosaic => {
                mosaic.cells().get(tile_row..tile_row + mosaic.cols()).unwrap_or(&[])
            }
            ColorArchitecture::Prism | ColorArchitecture::FieldSequential => &[],
        };
        let weights = self.rows.weights_of(row);
        lines.clear();
        if weights.is_empty() || self.width == 0 {
            out.fill(0.0);
            return;
        }
        // The rows of the image that cover this row of pixels, with one line per channel that occurs in it.
        let mut line_of = [0usize; 256];
        for channel in 0..self.channels {
            let wanted = if tile.is_empty() {
                channel == plane
            } else {
                tile.iter().any(|&c| usize::from(c) == channel)
            };
            if !wanted {
                continue;
            }
            let start = lines.len();
            line_of[channel % 256] = start;
            lines.resize(start + self.width, 0.0);
            let line = &mut lines[start..];
            for (t, &w) in weights.iter().enumerate() {
                let at = ((self.rows.first(row) + t) * self.channels + channel) * self.width;
                for (l, r) in line.iter_mut().zip(&self.rates[at..at + self.width]) {
                    *l += w * r;
                }
            }
        }
        let mut cell = if tile.is_empty() { 0 } else { wrap(self.origin[1], tile.len()) };
        for (i, o) in out.iter_mut().enumerate() {
            let channel = tile.get(cell).map_or(plane % 256, |&c| usize::from(c));
            cell = if cell + 1 >= tile.len() { 0 } else { cell + 1 };
            let at = line_of[channel] + self.cols.first(i);
            let mut sum = 0.0;
            for (w, l) in self.cols.weights_of(i).iter().zip(&lines[at..]) {
                sum += w * l;
            }
            *o = sum;
        }
    }
}

/// One row of the image, integrated over wavelength for every channel.
struct SpectralRow<'a> {
    planes: &'a [&'a [f32]],
    /// For each channel, the weight of every plane.
    weights: &'a [Vec<f32>],
    first: usize,
    width: usize,
    /// Scratch memory.
    light: &'a mut Vec<f32>,
    /// A line for each channel.
    out: Vec<&'a mut [f32]>,
}

/// Columns whose light is in the L1 cache while all channels are integrated.
const TILE: usize = 128;
/// Columns whose sums are in registers.
const SUMS: usize = 64;

impl Kernel for SpectralRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { planes, weights, first, width, light, mut out } = self;
        // Planes lie a power of two apart, where they would displace each other from the cache.
        light.resize(planes.len() * TILE, 0.0);
        for from in (0..width).step_by(TILE) {
            let count = TILE.min(width - from);
            for (tile, plane) in light.chunks_exact_mut(TILE).zip(planes) {
                tile[..count].copy_from_slice(&plane[first + from..][..count]);
            }
            for (out, weights) in out.iter_mut().zip(weights) {
                let blocks = out[from..from + count].chunks_mut(SUMS).zip((0..).step_by(SUMS));
                for (out, at) in blocks {
                    let mut sums = [0.0f32; SUMS];
                    for (tile, weight) in light.chunks_exact(TILE).zip(weights) {
                        let Some(light) = tile.get(at..).and_then(<[f32]>::first_chunk::<SUMS>) else {
                            return;
                        };
                        for (sum, light) in sums.iter_mut().zip(light) {
                            *sum += weight * light;
                        }
                    }
                    for (out, sum) in out.iter_mut().zip(sums) {
                        *out = sum.min(LARGEST_RATE);
                    }
                }
            }
        }
    }
}

/// Photoelectrons per second of a band of rows, after crosstalk.
pub(super) struct LightBand<'a, R> {
    pub(super) sensor: &'a Sensor,
    pub(super) rates: &'a R,
    pub(super) plane: usize,
    pub(super) first_row: usize,
    pub(super) out: &'a mut [f32],
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
                    // The contribution of pixel (r, c) to pixel (r + dy − 1, c + dx − 1), indexed by the
                    // receiving pixel.
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
