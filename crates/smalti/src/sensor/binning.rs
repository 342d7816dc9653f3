//! Binning: samples that several neighbouring photodiodes behind one filter give together.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::{Sensor, SensorError};
use crate::numeric::{Rect, require};

/// Where the signals of binned photodiodes are combined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum BinningMode {
    /// The electrons of the photodiodes are added on their common floating diffusion, and read once.
    Charge,
    /// Every photodiode is read and converted by itself. The samples are averaged after the converter.
    Digital,
}

impl BinningMode {
    /// Its name in descriptions.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Charge => "charge",
            Self::Digital => "digital",
        }
    }
}

/// Binning of square blocks of photodiodes, from the top left of the sensor.
///
/// Shot noise, dark current, full well, PRNU, DSNU and defects belong to each photodiode in both modes. With
/// [`BinningMode::Charge`] there is one read noise per sample, and the voltage swing limits the sum: the
/// floating diffusion holds `voltage_swing_v / conversion_gain_v_per_e` electrons at unit gain. Offsets of
/// rows and columns (row and column noise) come after the sum, once per sample.
///
/// With [`BinningMode::Digital`] every photodiode is a pixel of its own up to the converter, with its own read
/// noise, offsets of row and column, clipping and quantisation. A sample is the mean of these samples, times a
/// power of two ([`Binning::extra_bits`]) so that rounding it loses nothing that matters: 2 bits more than the
/// converter for 2 × 2 photodiodes, where it is the exact sum, and 4 for 3 × 3, at most 16 bits in all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binning {
    /// Photodiodes along each side of a block, 2 to [`Binning::MAX_SIDE`].
    pub side: usize,
    /// Where their signals are combined.
    pub mode: BinningMode,
}

impl Binning {
    /// Largest number of photodiodes along the side of a block.
    pub const MAX_SIDE: usize = 8;

    /// Checks the side.
    ///
    /// # Errors
    /// When it is not 2 to [`Binning::MAX_SIDE`].
    pub fn validate(&self) -> Result<(), SensorError> {
        let fits = (2..=Self::MAX_SIDE).contains(&self.side);
        Ok(require(fits, "binning side", self.side as f64, "2 to 8 photodiodes")?)
    }

    /// Photodiodes of a block, the square of its side.
    #[must_use]
    pub fn photodiodes(&self) -> usize {
        self.side * self.side
    }

    /// Bits that digital binning adds to a converter of `bits` bits: the least number that holds the sum, at
    /// most 16 bits in all. None are added to charge binning or without a converter.
    #[must_use]
    pub fn extra_bits(&self, bits: u32) -> u32 {
        match self.mode {
            BinningMode::Digital if bits > 0 => {
                self.photodiodes().next_power_of_two().ilog2().min(16u32.saturating_sub(bits))
            }
            BinningMode::Digital | BinningMode::Charge => 0,
        }
    }

    /// Photodiodes of one reading.
    fn photodiodes_per_reading(&self) -> usize {
        if self.mode == BinningMode::Charge { self.photodiodes() } else { 1 }
    }

    /// Readings of one sample.
    fn readings(&self) -> usize {
        if self.mode == BinningMode::Digital { self.photodiodes() } else { 1 }
    }
}

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

    /// Volts of a sample per photoelectron in any of its photodiodes, before the analog gain: the conversion
    /// gain, for digital binning divided by the number of photodiodes, whose volts are averaged.
    #[must_use]
    pub fn volts_per_electron(&self) -> f64 {
        self.pixel.conversion_gain_v_per_e / self.readings_per_sample()
    }

    /// Standard deviation of the read noise of a sample, in electrons of all its photodiodes. N readings that
    /// are averaged have √N times the noise of one.
    #[must_use]
    pub fn read_noise_e(&self) -> f64 {
        self.pixel.read_noise_v / self.pixel.conversion_gain_v_per_e * self.readings_per_sample().sqrt()
    }

    /// Bits of the samples: those of the converter, and those that digital binning adds. 0 without a
    /// converter.
    #[must_use]
    pub fn sample_bits(&self) -> u32 {
        self.adc.bits + self.extra_bits()
    }

    pub(super) fn extra_bits(&self) -> u32 {
        self.binning.map_or(0, |b| b.extra_bits(self.adc.bits))
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

    #[test]
    fn the_sum_fits_into_the_added_bits() {
        let digital = |side| Binning { side, mode: BinningMode::Digital };
        for (side, bits, extra) in [(2, 10, 2), (2, 14, 2), (2, 15, 1), (3, 12, 4), (3, 14, 2), (8, 10, 6)] {
            assert_eq!(digital(side).extra_bits(bits), extra, "{side}, {bits}");
        }
        assert_eq!(digital(2).extra_bits(0), 0);
        assert_eq!(Binning { side: 2, mode: BinningMode::Charge }.extra_bits(12), 0);
    }

    #[test]
    fn a_block_has_at_least_two_photodiodes_on_a_side() {
        for (side, fits) in [(0, false), (1, false), (2, true), (8, true), (9, false)] {
            assert_eq!(Binning { side, mode: BinningMode::Charge }.validate().is_ok(), fits, "{side}");
        }
    }
}
