//! Demosaicking: every channel at every pixel.

pub mod bilinear;
mod delaunay;
mod plan;
mod simd;

use super::IspError;
use crate::numeric::Planes;
use crate::sensor::{Mosaic, RawImage, Sampling};
use plan::Source;
use simd::Simd;

/// How the channels a pixel has not seen are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Demosaic {
    /// Linear interpolation between the samples of a channel that enclose the pixel, for any mosaic.
    #[default]
    Bilinear,
}

impl Demosaic {
    /// One plane per channel, normalised: 0 at black level, 1 at white level; not clipped. Pixels keep the value
    /// of the channel they have seen. An image that has every channel at every pixel passes through.
    ///
    /// # Errors
    /// [`IspError::UnsupportedCfa`] when the method is not defined for the mosaic; [`IspError::ChannelNotSeen`] when
    /// the image is so small that it misses a channel; [`IspError::SparseChannel`] when samples of a channel are
    /// too far apart.
    pub fn apply(self, raw: &RawImage) -> Result<Planes, IspError> {
        self.apply_with(Simd::best(), raw)
    }

    fn apply_with(self, simd: Simd, raw: &RawImage) -> Result<Planes, IspError> {
        let mosaic = match raw.sampling() {
            Sampling::Full { channels } => {
                return Ok(Planes::new(raw.rows(), raw.cols(), *channels, raw.normalized())?);
            }
            Sampling::Mosaic(m) => m,
        };
        match self {
            Self::Bilinear => bilinear::plan(mosaic)?.apply(Source::of(raw), simd),
        }
    }
}

/// Where the channels of a Bayer mosaic lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Bayer {
    /// The channel that every second pixel has.
    green: usize,
    /// Whether it is at pixel (0, 0).
    green_at_origin: bool,
    /// The other channel of even rows, and of odd rows.
    chroma: [usize; 2],
}

impl Bayer {
    fn is_green(&self, row: usize, col: usize) -> bool {
        (row + col).is_multiple_of(2) == self.green_at_origin
    }

    fn chroma_of_row(&self, row: usize) -> usize {
        self.chroma[row % 2]
    }
}

/// The Bayer layout of a mosaic: any that repeats after 2 × 2 and has three channels, one on a diagonal.
fn is_bayer(mosaic: &Mosaic, method: &'static str) -> Result<Bayer, IspError> {
    let at = |r, c| mosaic.channel_at(r, c);
    let (rows, cols, channels) = (mosaic.rows(), mosaic.cols(), mosaic.channels());
    let repeats = rows.is_multiple_of(2)
        && cols.is_multiple_of(2)
        && (0..rows).all(|r| (0..cols).all(|c| at(r, c) == at(r % 2, c % 2)));
    let quad = [at(0, 0), at(0, 1), at(1, 0), at(1, 1)];
    if repeats && channels == 3 {
        if quad[0] == quad[3] {
            return Ok(Bayer { green: quad[0], green_at_origin: true, chroma: [quad[1], quad[2]] });
        }
        if quad[1] == quad[2] {
            return Ok(Bayer { green: quad[1], green_at_origin: false, chroma: [quad[0], quad[3]] });
        }
    }
    Err(IspError::UnsupportedCfa { rows, cols, channels, method })
}
