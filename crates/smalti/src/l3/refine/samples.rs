//! The raw image that a picture was rendered from, as the correction beside highlights reads it.

use super::super::Axes;
use super::fixed::FixedRefinement;
use crate::isp::source::Source;
use crate::sensor::{RawImage, RawSamples};

/// Stands for the response of a sample that is clipped.
pub(super) const CLIPPED: f32 = -1.0;
/// Binary places of the factor from digital numbers to responses, beyond those of responses.
const FACTOR_PLACES: u32 = 16;

/// The responses of the samples that a picture was rendered from: 0 at the black level and below, 1 at the white level.
#[derive(Debug, Clone, Copy)]
pub struct RefinementSamples<'a> {
    raw: &'a RawImage,
    source: Source<'a>,
    tile: [usize; 2],
    clip: f32,
}

impl<'a> RefinementSamples<'a> {
    /// Of a raw image that has the mosaic of the axes.
    pub(in super::super) fn of(raw: &'a RawImage, axes: &Axes) -> Self {
        let tile = [axes.mosaic().rows(), axes.mosaic().cols()];
        Self { raw, source: Source::of(raw), tile, clip: axes.clip() as f32 }
    }

    /// Rows and columns of the raw image.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.raw.rows(), self.raw.cols()]
    }

    /// Rows and columns of the mosaic's tile.
    pub(super) fn tile(&self) -> [usize; 2] {
        self.tile
    }

    /// Writes the responses of a row to `out`, which has its length; [`CLIPPED`] where a sample is.
    #[inline(always)]
    pub(super) fn read_row(&self, row: usize, out: &mut [f32]) {
        self.source.read_row(row, out);
        for v in out {
            let light = if *v > 0.0 { *v } else { 0.0 };
            *v = if light >= self.clip { CLIPPED } else { light };
        }
    }

    /// The response of a sample in integers, with the binary places of pictures. `None` where it is clipped or in volts.
    pub(super) fn whole(&self, row: usize, col: usize) -> Option<i64> {
        let RawSamples::Digital(samples) = self.raw.samples() else { return None };
        let sample = *samples.get(row * self.raw.cols() + col)?;
        let above = (i64::from(sample) - self.raw.black_level().round() as i64).max(0);
        let factor = Self::factor(self.raw.black_level(), self.raw.white_level());
        (self.source.at(row, col) < self.clip).then_some((above * factor) >> FACTOR_PLACES)
    }

    /// The factor from digital numbers above black to responses in integers, of which 16 binary places are dropped.
    #[must_use]
    pub fn factor(black_level: f64, white_level: f64) -> i64 {
        let one = f64::from(FixedRefinement::PLACES + FACTOR_PLACES).exp2();
        (one / (white_level - black_level)).round() as i64
    }
}
