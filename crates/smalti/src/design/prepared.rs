//! What of scoring a mosaic does not depend on its filters: how its channels are interpolated, and the light that makes up
//! each channel of each patch of the chart.
//!
//! The mean of an interpolated channel over a patch is a weighted sum of the samples in and around it, and a sample that
//! does not clip is an integral of the light on its pixel over wavelength. So the weighted sum may be taken of the light:
//! a design then has its colours after one integral for each patch and channel.

use crate::isp::demosaic::Interpolation;
use crate::metrics::Rect;
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::{Mosaic, PixelSpectra};

/// A mosaic before the chart.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) interpolation: Interpolation,
    patches: Vec<Vec<Part>>,
}

/// What the samples of one channel bring to the mean of an interpolated one.
#[derive(Debug)]
struct Part {
    interpolated: usize,
    sampled: usize,
    /// Photons s⁻¹ nm⁻¹ at each wavelength.
    light: Vec<f64>,
}

impl Prepared {
    pub(super) fn new(
        interpolation: Interpolation,
        mosaic: &Mosaic,
        chart: &PixelSpectra,
        patches: &[Rect],
    ) -> Self {
        let channels: Vec<usize> = (0..mosaic.channels()).collect();
        // Where channels are made of their own samples alone, one sweep over the light serves all of them.
        let apart = channels.iter().all(|&channel| {
            let mut own = true;
            for (row, col) in cells(mosaic) {
                interpolation.each_weight(row, col, channel, |[dr, dc], _| {
                    let at =
                        |i: usize, d: i32, n: usize| (i as i64 + i64::from(d)).rem_euclid(n as i64) as usize;
                    let (r, c) = (at(row, dr, mosaic.rows()), at(col, dc, mosaic.cols()));
                    own &= mosaic.channel_at(r, c) == channel;
                });
            }
            own
        });
        let sweeps: Vec<&[usize]> = if apart { vec![&channels] } else { channels.chunks(1).collect() };
        let of_patch = |patch: &Rect| {
            let sweep =
                |channels: &&[usize]| Weighing::new(&interpolation, mosaic, *patch, channels).parts(chart);
            sweeps.iter().flat_map(sweep).collect()
        };
        let patches = patches.iter().map(of_patch).collect();
        Self { interpolation, patches }
    }

    /// The channels of each patch, from what each channel makes of a photon at each wavelength.
    pub(super) fn channels<'a>(&'a self, response: &'a [Vec<f64>]) -> impl Iterator<Item = Vec<f64>> + 'a {
        self.patches.iter().map(|parts| {
            let mut means = vec![0.0; response.len()];
            for part in parts {
                let response = response.get(part.sampled).map_or(&[][..], Vec::as_slice);
                if let Some(mean) = means.get_mut(part.interpolated) {
                    *mean += part.light.iter().zip(response).map(|(l, r)| l * r).sum::<f64>();
                }
            }
            means
        })
    }
}

fn cells(mosaic: &Mosaic) -> impl Iterator<Item = (usize, usize)> {
    let cols = mosaic.cols();
    (0..mosaic.rows() * cols).map(move |i| (i / cols, i % cols))
}

/// Weights of the samples in and around a patch.
struct Weighing<'a> {
    mosaic: &'a Mosaic,
    /// The interpolated channels; several where each is made of its own samples.
    channels: &'a [usize],
    around: Rect,
    weights: Vec<f32>,
}

impl<'a> Weighing<'a> {
    fn new(interpolation: &Interpolation, mosaic: &'a Mosaic, patch: Rect, channels: &'a [usize]) -> Self {
        let reach = interpolation.reach();
        let around = Rect {
            row: patch.row - reach.min(patch.row),
            col: patch.col - reach.min(patch.col),
            rows: patch.rows + 2 * reach,
            cols: patch.cols + 2 * reach,
        };
        let mut weights = vec![0.0f32; around.len()];
        let share = 1.0 / patch.len() as f32;
        for (row, col) in cells(mosaic) {
            // How often a place of the tile occurs in the patch does not matter to what it is made of.
            let places = |first: usize, count: usize, at: usize, period: usize| {
                let start = (at + period - first % period) % period;
                (start..count).step_by(period)
            };
            for &channel in channels {
                interpolation.each_weight(row, col, channel, |[dr, dc], weight| {
                    for r in places(patch.row, patch.rows, row, mosaic.rows()) {
                        let line = (r + reach).wrapping_add_signed(dr as isize) * around.cols;
                        for c in places(patch.col, patch.cols, col, mosaic.cols()) {
                            let at = line + (c + reach).wrapping_add_signed(dc as isize);
                            if let Some(sum) = weights.get_mut(at) {
                                *sum += share * weight;
                            }
                        }
                    }
                });
            }
        }
        Self { mosaic, channels, around, weights }
    }

    fn parts(&self, chart: &PixelSpectra) -> Vec<Part> {
        let wavelengths = chart.grid().len();
        let (around, mosaic) = (self.around, self.mosaic);
        // Per row of the tile, wavelength and column.
        let mut sums = vec![0.0f32; mosaic.rows() * wavelengths * around.cols];
        dispatch(Weigh { sweep: self, chart, wavelengths, sums: &mut sums });
        let mut light = vec![vec![0.0f64; wavelengths]; mosaic.channels()];
        for (i, line) in sums.chunks_exact(around.cols).enumerate() {
            let (row, wavelength) = (i / wavelengths, i % wavelengths);
            for (col, &sum) in line.iter().enumerate() {
                light[mosaic.channel_at(row, around.col + col)][wavelength] += f64::from(sum);
            }
        }
        let part = |(sampled, light): (usize, Vec<f64>)| {
            let interpolated = if self.channels.len() > 1 { sampled } else { *self.channels.first()? };
            Some(Part { interpolated, sampled, light })
        };
        light.into_iter().enumerate().filter_map(part).collect()
    }
}

/// Adds the weighted light row by row.
struct Weigh<'a> {
    sweep: &'a Weighing<'a>,
    chart: &'a PixelSpectra,
    wavelengths: usize,
    sums: &'a mut [f32],
}

impl Kernel for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let around = self.sweep.around;
        let first_col = self.chart.window().col;
        for (r, weights) in self.sweep.weights.chunks_exact(around.cols).enumerate() {
            let row = around.row + r;
            let of_tile = row % self.sweep.mosaic.rows() * self.wavelengths;
            for i in 0..self.wavelengths {
                let at = (of_tile + i) * around.cols;
                let light = self.chart.line(row, i).get(around.col - first_col..).unwrap_or(&[]);
                for ((s, w), l) in self.sums[at..at + around.cols].iter_mut().zip(weights).zip(light) {
                    *s += w * l;
                }
            }
        }
    }
}
