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

    /// The [crosstalk](Sensor::crosstalk) between samples whose photodiodes all have the same light: the kernel itself without binning.
    /// Where the light varies within a sample, its photodiodes beside another sample give that one more or less than this share.
    #[must_use]
    pub fn crosstalk_between_samples(&self) -> Option<[[f64; 3]; 3]> {
        let (kernel, side) = (self.crosstalk?, self.binning_side());
        let share = 1.0 / (side * side) as f64;
        let mut between = [[0.0; 3]; 3];
        for photodiode in 0..side * side {
            let (row, col) = (photodiode / side, photodiode % side);
            for (at, fraction) in kernel.as_flattened().iter().enumerate() {
                // The sample in which the neighbour of a photodiode lies: 1 for that of the photodiode itself.
                let [down, right] = [row + at / 3, col + at % 3].map(|place| place.div_ceil(side));
                between[down][right] += share * fraction;
            }
        }
        Some(between)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::BinningMode;
    use crate::sensor::clear_sensor::clear_sensor;

    /// Half of the photodiodes of a sample of 2 × 2 lie beside a neighbour, a quarter beside a diagonal one.
    #[test]
    fn crosstalk_between_samples_is_that_of_their_outer_photodiodes() {
        let kernel = [[0.01, 0.05, 0.0], [0.03, 0.75, 0.04], [0.02, 0.08, 0.02]];
        let mut sensor = clear_sensor(4, 4, 1);
        sensor.crosstalk = Some(kernel);
        assert_eq!(sensor.crosstalk_between_samples(), Some(kernel));
        sensor.binning = Some(Binning { side: 2, mode: BinningMode::Charge });
        let between = sensor.crosstalk_between_samples().unwrap();
        let up = 0.5 * 0.05 + 0.25 * 0.01;
        assert!((between[0][1] - up).abs() < 1e-15, "{between:?}");
        assert!((between[2][2] - 0.25 * 0.02).abs() < 1e-15, "{between:?}");
        assert!((between.as_flattened().iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }
}
