//! Linear demosaicking: for each cell of the tile and each channel, a short list of weighted samples.
//!
//! A plan is computed once per mosaic and applied to images of any size. Bands of rows are processed in parallel, and columns in
//! vectors whose weights repeat with the tile.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::super::IspError;
use super::super::source::Source;
use super::simd::{LANES, LaneTap, Sample, WeightedRow};
use crate::numeric::mirror::about_outermost;
use crate::numeric::simd::dispatch;
use crate::numeric::{ShapeError, bands_of};
use crate::sensor::Mosaic;

/// Rows per task, fixed so that results do not depend on the number of threads.
pub(crate) const BAND_ROWS: usize = 32;
/// Maximum number of weight vectors in memory. Larger tiles are processed pixel by pixel.
const MAX_VECTORS: usize = 1 << 15;

/// A weighted sample, by its offset from the interpolated pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tap {
    pub(crate) row: i32,
    pub(crate) col: i32,
    pub(crate) weight: f32,
}

/// The treatment of samples beyond the border of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Border {
    /// The weights of the available samples are scaled to sum to 1. Without any, the result is the mean of the nearest samples
    /// of the channel.
    Normalize,
    /// The image is mirrored about its outermost pixels, which keeps the phase of a tile of 2 × 2.
    Mirror,
}

/// The weights of a linear demosaicking method for one mosaic.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    mosaic: Mosaic,
    border: Border,
    /// Taps by cell, then channel, in row order of the samples.
    taps: Vec<Vec<Tap>>,
    reach_rows: usize,
    reach_cols: usize,
}

impl Plan {
    /// A plan from `taps(row, col, channel)` for each cell of the tile.
    pub(super) fn new(
        mosaic: &Mosaic,
        border: Border,
        taps: impl Fn(usize, usize, usize) -> Result<Vec<Tap>, IspError> + Sync,
    ) -> Result<Self, IspError> {
        let (cols, channels) = (mosaic.cols(), mosaic.channels());
        let taps = (0..mosaic.cells().len() * channels)
            .into_par_iter()
            .map(|i| {
                let (cell, channel) = (i / channels, i % channels);
                let mut taps = taps(cell / cols, cell % cols, channel)?;
                taps.sort_unstable_by_key(|t| (t.row, t.col));
                Ok(taps)
            })
            .collect::<Result<Vec<_>, IspError>>()?;
        let reach = |f: fn(&Tap) -> i32| taps.iter().flatten().map(|t| f(t).unsigned_abs() as usize).max();
        let (reach_rows, reach_cols) = (reach(|t| t.row).unwrap_or(0), reach(|t| t.col).unwrap_or(0));
        Ok(Self { mosaic: mosaic.clone(), border, taps, reach_rows, reach_cols })
    }

    /// The reach of the taps, in rows or columns, whichever is larger.
    pub(crate) fn reach(&self) -> usize {
        self.reach_rows.max(self.reach_cols)
    }

    /// The taps of a channel at a pixel of the tile.
    pub(crate) fn taps(&self, row: usize, col: usize, channel: usize) -> &[Tap] {
        let cell = (row % self.mosaic.rows()) * self.mosaic.cols() + col % self.mosaic.cols();
        &self.taps[cell * self.mosaic.channels() + channel]
    }

    /// Writes one plane per channel to `out`, one after another.
    pub(super) fn apply<T: Sample>(&self, source: Source<'_>, out: &mut [T]) -> Result<(), IspError> {
        let (rows, cols, count) = (source.rows(), source.cols(), self.mosaic.channels());
        let expected = rows.saturating_mul(cols).saturating_mul(count);
        if out.len() != expected {
            return Err(ShapeError { count, rows, cols, expected, got: out.len() }.into());
        }
        self.every_channel_is_seen(rows, cols)?;
        let layout = Layout::new(self, cols);
        let vectors = layout.as_ref().map(|l| self.vectors(l));
        bands(out, rows, cols).into_par_iter().enumerate().for_each_init(
            Vec::new,
            |buffer, (i, mut band)| {
                let first = i * BAND_ROWS;
                match (&layout, &vectors) {
                    (Some(l), Some(v)) => self.vector_band(source, l, v, first, &mut band, buffer),
                    _ => self.pixel_band(source, first, &mut band),
                }
            },
        );
        Ok(())
    }

    /// Reference implementation of [`Plan::apply`].
    #[cfg(test)]
    pub(super) fn pixel_by_pixel(&self, source: Source<'_>) -> Vec<f32> {
        let mut out = vec![0.0; source.rows() * source.cols() * self.mosaic.channels()];
        for (i, mut band) in bands(&mut out, source.rows(), source.cols()).into_iter().enumerate() {
            self.pixel_band(source, i * BAND_ROWS, &mut band);
        }
        out
    }

    /// Checks that the image has samples of every channel; one smaller than the tile may not.
    fn every_channel_is_seen(&self, rows: usize, cols: usize) -> Result<(), IspError> {
        let m = &self.mosaic;
        let mut seen = vec![false; m.channels()];
        for r in 0..rows.min(m.rows()) {
            (0..cols.min(m.cols())).for_each(|c| seen[m.channel_at(r, c)] = true);
        }
        match seen.iter().position(|s| !s) {
            Some(channel) => Err(IspError::ChannelNotSeen { channel, rows, cols }),
            None => Ok(()),
        }
    }

    /// The value of a channel at any pixel, including the border.
    fn pixel(&self, source: &Source<'_>, row: usize, col: usize, channel: usize) -> f32 {
        let (mut sum, mut total, mut missing) = (0.0f32, 0.0f32, false);
        for t in self.taps(row, col, channel) {
            let (r, c) = (row as isize + t.row as isize, col as isize + t.col as isize);
            let inside = (0..source.rows() as isize).contains(&r) && (0..source.cols() as isize).contains(&c);
            if inside {
                sum += t.weight * source.at(r as usize, c as usize);
                total += t.weight;
            } else if self.border == Border::Mirror {
                sum += t.weight
                    * source.at(about_outermost(r, source.rows()), about_outermost(c, source.cols()));
            } else {
                missing = true;
            }
        }
        match missing {
            false => sum,
            true if total > 0.0 => sum / total,
            true => self.nearest(source, row, col, channel),
        }
    }

    /// The mean of the nearest samples of a channel, searched in growing squares.
    fn nearest(&self, source: &Source<'_>, row: usize, col: usize, channel: usize) -> f32 {
        for ring in 1..source.rows().max(source.cols()) {
            let rows = row.saturating_sub(ring)..=(row + ring).min(source.rows() - 1);
            let cols = col.saturating_sub(ring)..=(col + ring).min(source.cols() - 1);
            let square = rows.flat_map(|r| cols.clone().map(move |c| (r, c)));
            let of_channel = square.filter(|&(r, c)| self.mosaic.channel_at(r, c) == channel);
            let (n, sum) = of_channel.fold((0u32, 0.0f32), |(n, s), (r, c)| (n + 1, s + source.at(r, c)));
            if n > 0 {
                return sum / n as f32;
            }
        }
        0.0 // unreachable: the image has samples of every channel
    }

    fn pixel_band<T: Sample>(&self, source: Source<'_>, first: usize, band: &mut [&mut [T]]) {
        for (channel, rows) in band.iter_mut().enumerate() {
            for (row, out) in rows.chunks_mut(source.cols()).enumerate() {
                for (col, o) in out.iter_mut().enumerate() {
                    *o = T::from_f32(self.pixel(&source, first + row, col, channel));
                }
            }
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn vector_band<T: Sample>(
        &self,
        source: Source<'_>,
        layout: &Layout,
        vectors: &[RowVectors],
        first: usize,
        band: &mut [&mut [T]],
        buffer: &mut Vec<f32>,
    ) {
        let (rows, cols, channels) = (source.rows(), source.cols(), self.mosaic.channels());
        let (up, side) = (self.reach_rows, self.reach_cols);
        let band_rows = band.first().map_or(0, |b| b.len() / cols);
        // The buffer begins with row `first - up` of the image, even if that row does not exist.
        buffer.resize((band_rows + 2 * up) * layout.stride, 0.0);
        for (i, line) in buffer.chunks_mut(layout.stride).enumerate() {
            if let Some(row) = (first + i).checked_sub(up).filter(|&r| r < rows) {
                source.read_row(row, &mut line[side..side + cols]);
            }
        }
        for i in 0..band_rows {
            let row = first + i;
            let inside = row >= up && row + up < rows;
            for (channel, plane) in band.iter_mut().enumerate() {
                let out = &mut plane[i * cols..(i + 1) * cols];
                let edges = if inside {
                    let v = &vectors[(row % self.mosaic.rows()) * channels + channel];
                    let window = &buffer[i * layout.stride..];
                    dispatch(WeightedRow { taps: &v.taps, spans: &v.spans, window, out });
                    (0..side).chain(cols - side..cols)
                } else {
                    (0..cols).chain(0..0)
                };
                for col in edges {
                    out[col] = T::from_f32(self.pixel(&source, row, col, channel));
                }
            }
        }
    }

    /// The taps for each row of the tile and each channel, grouped by vector of columns.
    fn vectors(&self, layout: &Layout) -> Vec<RowVectors> {
        let offset = |(row, col): (i32, i32)| {
            let down = (self.reach_rows as i64 + i64::from(row)) as usize;
            down * layout.stride + (self.reach_cols as i64 + i64::from(col)) as usize
        };
        let row_vectors = |i: usize| {
            let (row, channel) = (i / self.mosaic.channels(), i % self.mosaic.channels());
            let mut v = RowVectors::default();
            for vector in 0..layout.period {
                let mut at: BTreeMap<(i32, i32), [f32; LANES]> = BTreeMap::new();
                for lane in 0..LANES {
                    for t in self.taps(row, vector * LANES + lane, channel) {
                        at.entry((t.row, t.col)).or_default()[lane] += t.weight;
                    }
                }
                let from = v.taps.len();
                v.taps.extend(at.into_iter().map(|(at, weights)| LaneTap { offset: offset(at), weights }));
                v.spans.push((from, v.taps.len()));
            }
            v
        };
        (0..self.mosaic.rows() * self.mosaic.channels()).map(row_vectors).collect()
    }
}

/// The taps for one row of the tile and one channel. `spans` holds the range of each vector; vectors repeat along the row.
#[derive(Debug, Default)]
struct RowVectors {
    taps: Vec<LaneTap>,
    spans: Vec<(usize, usize)>,
}

/// The layout of rows in the buffer of a band, and the period of the weights in vectors.
#[derive(Debug)]
struct Layout {
    stride: usize,
    period: usize,
}

impl Layout {
    /// `None` when the image is too small or the tile too large for vectors.
    fn new(plan: &Plan, cols: usize) -> Option<Self> {
        let m = &plan.mosaic;
        // The least common multiple of tile width and lanes, in vectors; LANES is a power of two.
        let period = m.cols() >> m.cols().trailing_zeros().min(LANES.trailing_zeros());
        let count = period.saturating_mul(m.rows()).saturating_mul(m.channels());
        let stride = cols.next_multiple_of(LANES) + 2 * plan.reach_cols;
        (count <= MAX_VECTORS && cols > 2 * plan.reach_cols).then_some(Self { stride, period })
    }
}

/// The rows of each band of all planes.
pub(crate) fn bands<T>(data: &mut [T], rows: usize, cols: usize) -> Vec<Vec<&mut [T]>> {
    bands_of(BAND_ROWS, data, rows, cols)
}
