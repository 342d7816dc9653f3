//! Bilinear interpolation of any mosaic, with a fast integer version for Bayer mosaics.

use rayon::prelude::*;

use super::super::IspError;
use super::super::source::Source;
use super::bayer::Bayer;
use super::delaunay;
use super::plan::{BAND_ROWS, Border, Plan, Tap, bands};
use super::simd::{BayerLines, BayerRow};
use crate::numeric::simd::dispatch;
use crate::numeric::{Planes, ShapeError};
use crate::sensor::{Mosaic, RawImage, Sampling};

/// Bilinear demosaicking of one mosaic: a normalised convolution with the weights of linear interpolation between the samples
/// of a channel that enclose a pixel. One instance serves any number of images.
///
/// It reproduces linear gradients away from the border and keeps measured samples. At the border, the weights of the available
/// samples are scaled to sum to 1. If none is available, the result is the mean of the nearest samples of the channel.
///
/// ```
/// use smalti::isp::demosaic::Bilinear;
/// use smalti::sensor::Mosaic;
///
/// let stripes = Mosaic::new(1, 3, vec![0, 1, 2])?;
/// let mut planes = [0; 3 * 6];
/// Bilinear::new(&stripes)?.apply_u16(&[10, 20, 30, 40, 50, 60], 1, 6, &mut planes)?;
/// assert_eq!(planes[..6], [10, 20, 30, 40, 40, 40]); // red, measured at the first and fourth pixel
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Bilinear {
    mosaic: Mosaic,
    bayer: Option<Bayer>,
    pub(super) plan: Plan,
}

impl Bilinear {
    /// Computes the weights for a mosaic.
    ///
    /// # Errors
    /// [`IspError::SparseChannel`] when no samples of a channel within 64 pixels enclose some pixel.
    pub fn new(mosaic: &Mosaic) -> Result<Self, IspError> {
        let (rows, cols) = (mosaic.rows() as i64, mosaic.cols() as i64);
        let plan = Plan::new(mosaic, Border::Normalize, |row, col, channel| {
            let is_sample = |r: i64, c: i64| {
                let (r, c) = ((row as i64 + r).rem_euclid(rows), (col as i64 + c).rem_euclid(cols));
                mosaic.channel_at(r as usize, c as usize) == channel
            };
            let reach = delaunay::MAX_REACH as usize;
            let weights =
                delaunay::weights(is_sample).ok_or(IspError::SparseChannel { channel, row, col, reach })?;
            let tap = |((row, col), weight): ((i64, i64), f64)| Tap {
                row: row as i32,
                col: col as i32,
                weight: weight as f32,
            };
            Ok(weights.into_iter().map(tap).collect())
        })?;
        Ok(Self { mosaic: mosaic.clone(), bayer: Bayer::of(mosaic), plan })
    }

    /// Writes one plane per channel to existing planes, with the values of [`super::Demosaic::apply`].
    ///
    /// # Errors
    /// [`IspError::Mosaic`] when the raw image has another mosaic, [`IspError::Shape`] when `out` does not have the size of the
    /// image and one plane per channel, [`IspError::ChannelNotSeen`] when the image has no sample of a channel.
    pub fn apply_into(&self, raw: &RawImage, out: &mut Planes) -> Result<(), IspError> {
        let (rows, cols) = (raw.rows(), raw.cols());
        if *raw.sampling() != Sampling::Mosaic(self.mosaic.clone()) {
            return Err(IspError::Mosaic);
        }
        if (out.rows(), out.cols()) != (rows, cols) {
            let expected = self.mosaic.channels() * rows * cols;
            let got = out.data().len();
            return Err(ShapeError { count: self.mosaic.channels(), rows, cols, expected, got }.into());
        }
        self.plan.apply(Source::of(raw), out.data_mut())
    }

    /// Writes 16-bit planes of `rows` × `cols` samples to `out`, in the order of the channels. Values are rounded to the nearest
    /// integer (on Bayer mosaics halves up, as in OpenCV). The black level is not subtracted.
    ///
    /// # Errors
    /// When `samples.len()` is not `rows * cols`, `out.len()` is not that times the number of channels, or the image has no
    /// sample of a channel.
    pub fn apply_u16(
        &self,
        samples: &[u16],
        rows: usize,
        cols: usize,
        out: &mut [u16],
    ) -> Result<(), IspError> {
        let expected = rows.saturating_mul(cols);
        let count = self.mosaic.channels();
        for (count, got) in [(1, samples.len()), (count, out.len())] {
            let expected = expected.saturating_mul(count);
            if expected != got || got == 0 {
                return Err(ShapeError { count, rows, cols, expected, got }.into());
            }
        }
        match self.bayer {
            Some(bayer) if rows >= 2 && cols >= 2 => bayer_u16(bayer, samples, rows, cols, out),
            _ => self.plan.apply(Source::digital(samples, rows, cols), out)?,
        }
        Ok(())
    }
}

/// The integer version for Bayer mosaics; the caller has checked the sizes.
fn bayer_u16(bayer: Bayer, samples: &[u16], rows: usize, cols: usize, out: &mut [u16]) {
    bands(out, rows, cols).into_par_iter().enumerate().for_each(|(i, mut band)| {
        let line = |row: usize| &samples[row * cols..(row + 1) * cols];
        let height = band.first().map_or(0, |b| b.len() / cols);
        for k in 0..height {
            let row = i * BAND_ROWS + k;
            // Rows beyond the border are mirrored; they hold the same channels.
            let above = line(if row == 0 { 1 } else { row - 1 });
            let below = line(if row + 1 == rows { rows - 2 } else { row + 1 });
            let [a, b, c] = &mut band[..] else { continue };
            let mut planes = [a, b, c].map(|p| &mut p[k * cols..(k + 1) * cols]);
            let green = bayer.green;
            let own = bayer.chroma_of_row(row);
            let other = 3 - green - own;
            let Ok([g, own, other]) = planes.get_disjoint_mut([green, own, other]) else { continue };
            let lines = BayerLines { above, here: line(row), below, green_first: bayer.is_green(row, 0) };
            dispatch(BayerRow { lines, green: g, own, other });
            for col in [0, cols - 1] {
                (g[col], own[col], other[col]) = border_pixel(&lines, col, row == 0 || row + 1 == rows);
            }
            if row == 0 || row + 1 == rows {
                // In the border rows, the green mean must not count the mirrored row twice.
                for col in 1..cols - 1 {
                    g[col] = border_pixel(&lines, col, true).0;
                }
            }
        }
    });
}

/// Green, the chroma channel of the row and the other chroma channel at a pixel of the border.
fn border_pixel(lines: &BayerLines<'_>, col: usize, outer_row: bool) -> (u16, u16, u16) {
    let sides = [col.checked_sub(1), Some(col + 1).filter(|&c| c < lines.here.len())];
    let mean = |values: &[u32]| {
        let n = values.len() as u32;
        ((values.iter().sum::<u32>() + n / 2) / n.max(1)) as u16
    };
    let of = |line: &[u16]| -> Vec<u32> { sides.iter().flatten().map(|&c| u32::from(line[c])).collect() };
    let (here, above, below) = (lines.here[col], u32::from(lines.above[col]), u32::from(lines.below[col]));
    let beside = of(lines.here);
    if lines.green_first == col.is_multiple_of(2) {
        return (here, mean(&beside), mean(&[above, below]));
    }
    let vertical = if outer_row { vec![above] } else { vec![above, below] };
    let green = mean(&[beside, vertical].concat());
    (green, here, mean(&[of(lines.above), of(lines.below)].concat()))
}
