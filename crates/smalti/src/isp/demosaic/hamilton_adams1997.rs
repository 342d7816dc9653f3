//! Hamilton and Adams 1997 (US patent 5 629 734, expired): green is interpolated along the smaller gradient, the other
//! channels by their difference from green.

use rayon::prelude::*;

use super::super::IspError;
use super::super::source::Source;
use super::bayer::Bayer;
use super::bilinear::Bilinear;
use super::plan::BAND_ROWS;
use crate::numeric::mirror::about_outermost;
use crate::sensor::Mosaic;

/// Green depends on samples two pixels away, and the differences on green one pixel away.
pub(super) const REACH: usize = 3;

/// Writes one plane per channel of a Bayer mosaic to `out`. At the border, the image is mirrored for green, and differences are
/// averaged over the available pixels.
pub(super) fn apply(mosaic: &Mosaic, source: Source<'_>, out: &mut [f32]) -> Result<(), IspError> {
    let bayer = Bayer::required(mosaic, "hamilton-adams1997")?;
    let (rows, cols) = (source.rows(), source.cols());
    let mut green = vec![0.0f32; rows * cols];
    green.par_chunks_mut(BAND_ROWS * cols).enumerate().for_each(|(band, out)| {
        green_band(&source, bayer, band * BAND_ROWS, out);
    });
    let mut own = vec![0.0f32; rows * cols];
    for (row, out) in own.chunks_mut(cols).enumerate() {
        source.read_row(row, out);
    }
    // Colour differences vary more slowly than the channels, because most edges are edges of luminance.
    let differences: Vec<f32> = own.iter().zip(&green).map(|(v, g)| v - g).collect();
    Bilinear::new(mosaic)?.plan.apply(Source::normalized(&differences, rows, cols), out)?;
    for (channel, plane) in out.chunks_mut(rows * cols).enumerate() {
        if channel == bayer.green {
            plane.copy_from_slice(&green);
            continue;
        }
        plane.par_chunks_mut(cols).enumerate().for_each(|(row, out)| {
            let at = row * cols..(row + 1) * cols;
            for (o, g) in out.iter_mut().zip(&green[at.clone()]) {
                *o += g;
            }
            if bayer.chroma_of_row(row) == channel {
                // Measured samples are copied, which avoids rounding of the differences.
                for (col, (o, &v)) in out.iter_mut().zip(&own[at]).enumerate() {
                    if !bayer.is_green(row, col) {
                        *o = v;
                    }
                }
            }
        });
    }
    Ok(())
}

/// Green at the pixels of a band of rows.
fn green_band(source: &Source<'_>, bayer: Bayer, first: usize, out: &mut [f32]) {
    let (rows, cols) = (source.rows(), source.cols());
    // Two rows and two columns around the band, mirrored.
    let stride = cols + 4;
    let height = out.len() / cols;
    let mut window = vec![0.0f32; (height + 4) * stride];
    for (i, line) in window.chunks_mut(stride).enumerate() {
        source.read_row(about_outermost(first as isize + i as isize - 2, rows), &mut line[2..2 + cols]);
        for k in 0..2 {
            line[k] = line[2 + about_outermost(k as isize - 2, cols)];
            line[2 + cols + k] = line[2 + about_outermost((cols + k) as isize, cols)];
        }
    }
    for (i, out) in out.chunks_mut(cols).enumerate() {
        let line = |k: usize| &window[(i + k) * stride..(i + k + 1) * stride];
        let lines = [line(0), line(1), line(2), line(3), line(4)];
        for (col, o) in out.iter_mut().enumerate() {
            let (c, here) = (col + 2, lines[2][col + 2]);
            *o = if bayer.is_green(first + i, col) {
                here
            } else {
                let across = Gradient::of([0, 1, 3, 4].map(|k| lines[2][col + k]), here);
                let down = Gradient::of([0, 1, 3, 4].map(|k| lines[k][c]), here);
                if across.size < down.size {
                    across.estimate
                } else if down.size < across.size {
                    down.estimate
                } else {
                    0.5 * (across.estimate + down.estimate)
                }
            };
        }
    }
}

/// The gradient along a line through a pixel, and the estimate of green from this line.
struct Gradient {
    size: f32,
    estimate: f32,
}

impl Gradient {
    /// From the samples at −2, −1, 1, 2 and the pixel itself. The outer samples are of its channel, the inner ones green.
    fn of([far, near, next, beyond]: [f32; 4], here: f32) -> Self {
        let curvature = (here - far) + (here - beyond);
        Self { size: (near - next).abs() + curvature.abs(), estimate: 0.5 * (near + next) + 0.25 * curvature }
    }
}
