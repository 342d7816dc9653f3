//! Bilinear interpolation of any mosaic, and its fast integer form for Bayer.

use rayon::prelude::*;

use super::super::IspError;
use super::delaunay;
use super::plan::{BAND_ROWS, Border, Plan, Tap, bands};
use super::simd::{BayerLines, Simd, bayer_row};
use super::{Bayer, is_bayer};
use crate::numeric::ShapeError;
use crate::sensor::Mosaic;

/// Normalised convolution with the weights of linear interpolation between the samples that enclose a pixel.
pub(super) fn plan(mosaic: &Mosaic) -> Result<Plan, IspError> {
    let (rows, cols) = (mosaic.rows() as i64, mosaic.cols() as i64);
    Plan::new(mosaic, Border::Normalize, |row, col, channel| {
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
    })
}

/// Bilinear demosaicking of 16-bit Bayer samples into three planes of 16 bits, one after another, in the order of
/// the channels. Halves round up, as in OpenCV; at the border the mean is over the neighbours that are there.
///
/// This is the fast way to a preview. [`super::Demosaic::Bilinear`] gives the same values without rounding.
///
/// # Errors
/// When the mosaic is not Bayer, the image is smaller than 2 × 2, `samples.len()` is not `rows * cols` or
/// `out.len()` is not three times that.
pub fn bayer_u16(
    samples: &[u16],
    rows: usize,
    cols: usize,
    mosaic: &Mosaic,
    out: &mut [u16],
) -> Result<(), IspError> {
    bayer_u16_with(Simd::best(), samples, rows, cols, mosaic, out)
}

pub(super) fn bayer_u16_with(
    simd: Simd,
    samples: &[u16],
    rows: usize,
    cols: usize,
    mosaic: &Mosaic,
    out: &mut [u16],
) -> Result<(), IspError> {
    let bayer = is_bayer(mosaic, "bilinear in 16 bits")?;
    let expected = rows.checked_mul(cols).unwrap_or(usize::MAX);
    let shape =
        |count: usize, got| ShapeError { count, rows, cols, expected: expected.saturating_mul(count), got };
    if samples.len() != expected {
        return Err(shape(1, samples.len()).into());
    }
    if out.len() != expected.saturating_mul(3) {
        return Err(shape(3, out.len()).into());
    }
    if rows < 2 || cols < 2 {
        return Err(IspError::ChannelNotSeen { channel: mosaic.channel_at(1, 1), rows, cols });
    }
    bands(out, rows, cols).into_par_iter().enumerate().for_each(|(i, mut band)| {
        let line = |row: usize| &samples[row * cols..(row + 1) * cols];
        let height = band.first().map_or(0, |b| b.len() / cols);
        for k in 0..height {
            let row = i * BAND_ROWS + k;
            // Above and below the image lies the row on the other side, which holds the same channels.
            let above = line(if row == 0 { 1 } else { row - 1 });
            let below = line(if row + 1 == rows { rows - 2 } else { row + 1 });
            let [a, b, c] = &mut band[..] else { continue };
            let mut planes = [a, b, c].map(|p| &mut p[k * cols..(k + 1) * cols]);
            let Bayer { green, .. } = bayer;
            let own = bayer.chroma_of_row(row);
            let other = 3 - green - own;
            let Ok([g, own, other]) = planes.get_disjoint_mut([green, own, other]) else { continue };
            let lines = BayerLines { above, here: line(row), below, green_first: bayer.is_green(row, 0) };
            bayer_row(simd, lines, g, own, other);
            for col in [0, cols - 1] {
                (g[col], own[col], other[col]) = border_pixel(&lines, col, row == 0 || row + 1 == rows);
            }
            if row == 0 || row + 1 == rows {
                // Doubling the row that is there would weigh it twice in the green mean of four.
                for col in 1..cols - 1 {
                    g[col] = border_pixel(&lines, col, true).0;
                }
            }
        }
    });
    Ok(())
}

/// Green, the row's own chroma and the other chroma at a pixel whose row or column is outermost.
fn border_pixel(lines: &BayerLines<'_>, col: usize, outer_row: bool) -> (u16, u16, u16) {
    let sides = [col.checked_sub(1), Some(col + 1).filter(|&c| c < lines.here.len())];
    let mean = |values: &[u32]| {
        let n = values.len() as u32;
        ((values.iter().sum::<u32>() + n / 2) / n.max(1)) as u16
    };
    let of = |line: &[u16]| -> Vec<u32> { sides.iter().flatten().map(|&c| u32::from(line[c])).collect() };
    let (here, above, below) = (lines.here[col], u32::from(lines.above[col]), u32::from(lines.below[col]));
    let beside = of(lines.here);
    if lines.green_first == (col % 2 == 0) {
        return (here, mean(&beside), mean(&[above, below]));
    }
    let vertical = if outer_row { vec![above] } else { vec![above, below] };
    let green = mean(&[beside, vertical].concat());
    (green, here, mean(&[of(lines.above), of(lines.below)].concat()))
}
