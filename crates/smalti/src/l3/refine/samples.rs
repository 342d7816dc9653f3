//! The raw image that a picture was rendered from, as the correction beside highlights reads it.

use super::super::error::ensure_same_size;
use super::super::{Axes, L3Error};
use crate::isp::source::Source;
use crate::sensor::{RawImage, RawSamples};

/// Stands for the response of a sample that is clipped.
pub(super) const CLIPPED: f32 = -1.0;
/// Binary places of pictures and responses in integers.
pub(super) const PLACES: u32 = 20;
/// Binary places of the black level in integers, and of the factor to responses beyond their own.
const BLACK_PLACES: u32 = 8;
const FACTOR_PLACES: u32 = 16;

/// The responses of the samples that a picture was rendered from: 0 at the black level and below, 1 at the white level.
#[derive(Debug, Clone, Copy)]
pub struct RefinementSamples<'a> {
    raw: &'a RawImage,
    source: Source<'a>,
    tile: [usize; 2],
    clip: f32,
    scale: [i64; 2],
}

impl<'a> RefinementSamples<'a> {
    /// Of a raw image that has the mosaic of the axes.
    pub(in super::super) fn of(raw: &'a RawImage, axes: &Axes) -> Self {
        Self {
            raw,
            source: Source::of(raw),
            tile: [axes.mosaic().rows(), axes.mosaic().cols()],
            clip: axes.clip() as f32,
            scale: Self::scale(raw.black_level(), raw.white_level()),
        }
    }

    /// Rows and columns of the raw image.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.raw.rows(), self.raw.cols()]
    }

    /// Checks that a picture has as many rows and columns.
    pub(super) fn ensure_size(&self, got: [usize; 2]) -> Result<(), L3Error> {
        ensure_same_size("the picture to refine", self.size(), got)
    }

    /// The samples, if the tile has its cells again within `reach` rows or columns of them: otherwise a sample has no others to be compared with.
    pub(super) fn repeated_within(self, reach: usize) -> Option<Self> {
        self.tile.into_iter().any(|side| side <= reach).then_some(self)
    }

    /// Rows and columns of the mosaic's tile.
    pub(super) fn tile(&self) -> [usize; 2] {
        self.tile
    }

    /// Whether the samples are digital numbers.
    pub(super) fn is_digital(&self) -> bool {
        matches!(self.raw.samples(), RawSamples::Digital(_))
    }

    /// Writes the responses of a row to `out`, which has its length; [`CLIPPED`] where a sample is clipped or not a number.
    #[inline(always)]
    pub(super) fn read_row(&self, row: usize, out: &mut [f32]) {
        self.source.read_row(row, out);
        for v in out {
            let light = if *v > 0.0 { *v } else { 0.0 };
            *v = if *v < self.clip { light } else { CLIPPED };
        }
    }

    /// The response of a sample in integers, with [`PLACES`] binary places. `None` where it is clipped or in volts.
    pub(super) fn whole(&self, row: usize, col: usize) -> Option<i64> {
        let RawSamples::Digital(samples) = self.raw.samples() else { return None };
        let sample = i64::from(*samples.get(row * self.raw.cols() + col)?);
        let [black, factor] = self.scale;
        let response = || ((sample << BLACK_PLACES) - black).max(0).saturating_mul(factor);
        (self.source.at(row, col) < self.clip).then(|| response() >> (BLACK_PLACES + FACTOR_PLACES))
    }

    /// The black level b with 8 binary places, and the factor f of responses in integers: they are (256 · sample − b) · f / 2²⁴, rounded down, with 20 binary
    /// places.
    #[must_use]
    pub fn scale(black_level: f64, white_level: f64) -> [i64; 2] {
        let one = |places: u32| f64::from(places).exp2();
        // A conversion to an integer saturates.
        let black = (black_level * one(BLACK_PLACES)).round() as i64;
        [black, (one(PLACES + FACTOR_PLACES) / (white_level - black_level)).round() as i64]
    }
}
