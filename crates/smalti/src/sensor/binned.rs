//! A sensor with binning: its samples, and the photodiodes that they consist of.

use std::borrow::Cow;

use super::{Binning, Sensor};
use crate::numeric::Rect;

impl Sensor {
    /// Photodiodes along each side of a sample; 1 without binning.
    #[must_use]
    pub fn binning_side(&self) -> usize {
        self.binning.map_or(1, |b| b.side)
    }

    /// Photodiodes of a sample; 1 without binning.
    #[must_use]
    pub fn photodiodes_per_sample(&self) -> f64 {
        self.binning.map_or(1.0, |b| b.photodiodes() as f64)
    }

    /// Photodiodes whose electrons are read together.
    pub(super) fn photodiodes_per_reading(&self) -> f64 {
        self.binning.map_or(1.0, |b| b.photodiodes_per_reading() as f64)
    }

    /// Readings that are averaged to a sample.
    pub(super) fn readings_per_sample(&self) -> f64 {
        self.binning.map_or(1.0, |b| b.readings() as f64)
    }

    /// The same device without binning: each of its pixels is a photodiode. Pitch, size, window and mosaic are
    /// those of the photodiodes; light, noise and fixed pattern of a photodiode are the same in captures of
    /// both sensors.
    #[must_use]
    pub fn unbinned(&self) -> Cow<'_, Self> {
        let Some(Binning { side, .. }) = self.binning else { return Cow::Borrowed(self) };
        let mut pixel = self.pixel;
        pixel.pitch_m /= side as f64;
        let times = |n: usize| n.saturating_mul(side);
        let fine =
            |w: Rect| Rect { row: times(w.row), col: times(w.col), rows: times(w.rows), cols: times(w.cols) };
        Cow::Owned(Self {
            rows: times(self.rows),
            cols: times(self.cols),
            window: self.window.map(fine),
            pixel,
            cfa: self.cfa.with_blocks(side),
            binning: None,
            ..self.clone()
        })
    }
}
