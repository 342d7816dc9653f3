//! The light that contributes to each channel of each patch of the chart, for one mosaic and any filters.
//!
//! The mean of an interpolated channel over a patch is a weighted sum of the samples in and around it. A sample that does
//! not clip is an integral of the light on its pixel over wavelength. The weighted sum can therefore be taken of the light
//! itself, and the colours of a design need one integral for each patch and channel.

use crate::isp::demosaic::Plan;
use crate::metrics::Rect;
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::{Mosaic, PixelSpectra};

/// The interpolation of a mosaic and the weighted light of every patch.
#[derive(Debug)]
pub(super) struct PatchLight {
    pub(super) interpolation: Plan,
    patches: Vec<Vec<ChannelLight>>,
}

/// The weighted light with which the samples of one channel contribute to the mean of an interpolated channel.
#[derive(Debug)]
struct ChannelLight {
    interpolated: usize,
    sampled: usize,
    /// Photons s⁻¹ nm⁻¹ at each wavelength.
    light: Vec<f64>,
}

impl PatchLight {
    pub(super) fn new(interpolation: Plan, mosaic: &Mosaic, chart: &PixelSpectra, patches: &[Rect]) -> Self {
        let channels: Vec<usize> = (0..mosaic.channels()).collect();
        // When every channel is interpolated from its own samples alone, one sweep over the light serves all channels.
        let apart = channels.iter().all(|&channel| {
            let at = |i: usize, d: i32, n: usize| (i as i64 + i64::from(d)).rem_euclid(n as i64) as usize;
            cells(mosaic).all(|(row, col)| {
                interpolation.taps(row, col, channel).iter().all(|t| {
                    let (r, c) = (at(row, t.row, mosaic.rows()), at(col, t.col, mosaic.cols()));
                    mosaic.channel_at(r, c) == channel
                })
            })
        });
        let sweeps: Vec<&[usize]> = if apart { vec![&channels] } else { channels.chunks(1).collect() };
        let of_patch = |patch: &Rect| {
            let sweep = |channels: &&[usize]| {
                PatchWeights::new(&interpolation, mosaic, *patch, channels).channel_light(chart)
            };
            sweeps.iter().flat_map(sweep).collect()
        };
        let patches = patches.iter().map(of_patch).collect();
        Self { interpolation, patches }
    }

    /// The mean channels of each patch, from the response of each channel per photon at each wavelength.
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
struct PatchWeights<'a> {
    mosaic: &'a Mosaic,
    /// The interpolated channels; several when each depends on its own samples alone.
    channels: &'a [usize],
    around: Rect,
    weights: Vec<f32>,
}

impl<'a> PatchWeights<'a> {
    fn new(interpolation: &Plan, mosaic: &'a Mosaic, patch: Rect, channels: &'a [usize]) -> Self {
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
            // All pixels of the patch at this position of the tile share their weights.
            let places = |first: usize, count: usize, at: usize, period: usize| {
                let start = (at + period - first % period) % period;
                (start..count).step_by(period)
            };
            for &channel in channels {
                for t in interpolation.taps(row, col, channel) {
                    for r in places(patch.row, patch.rows, row, mosaic.rows()) {
                        let line = (r + reach).wrapping_add_signed(t.row as isize) * around.cols;
                        for c in places(patch.col, patch.cols, col, mosaic.cols()) {
                            let at = line + (c + reach).wrapping_add_signed(t.col as isize);
                            if let Some(sum) = weights.get_mut(at) {
                                *sum += share * t.weight;
                            }
                        }
                    }
                }
            }
        }
        Self { mosaic, channels, around, weights }
    }

    fn channel_light(&self, chart: &PixelSpectra) -> Vec<ChannelLight> {
        let wavelengths = chart.grid().len();
        let (around, mosaic) = (self.around, self.mosaic);
        // Per row of the tile, wavelength and column.
        let mut sums = vec![0.0f32; mosaic.rows() * wavelengths * around.cols];
        dispatch(AddWeightedLight { sweep: self, chart, wavelengths, sums: &mut sums });
        let mut light = vec![vec![0.0f64; wavelengths]; mosaic.channels()];
        for (i, line) in sums.chunks_exact(around.cols).enumerate() {
            let (row, wavelength) = (i / wavelengths, i % wavelengths);
            for (col, &sum) in line.iter().enumerate() {
                light[mosaic.channel_at(row, around.col + col)][wavelength] += f64::from(sum);
            }
        }
        let of_channel = |(sampled, light): (usize, Vec<f64>)| {
            let interpolated = if self.channels.len() > 1 { sampled } else { *self.channels.first()? };
            Some(ChannelLight { interpolated, sampled, light })
        };
        light.into_iter().enumerate().filter_map(of_channel).collect()
    }
}

/// Adds the weighted light row by row, compiled for each instruction set.
struct AddWeightedLight<'a> {
    sweep: &'a PatchWeights<'a>,
    chart: &'a PixelSpectra,
    wavelengths: usize,
    sums: &'a mut [f32],
}

impl Kernel for AddWeightedLight<'_> {
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
