//! Binning: samples that several neighbouring photodiodes behind one filter give together.

use serde::{Deserialize, Serialize};

use super::SensorError;
use crate::numeric::require;

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
/// noise, offsets of row and column, clipping and quantisation. A sample is the mean of these samples in steps
/// fine enough to lose nothing: their exact sum, which has 2 bits more than the converter for 2 × 2 photodiodes
/// and 4 for 3 × 3. A sum of more than 16 bits is divided by the power of two that leaves 16, and rounded.
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

    /// Bits of a sample behind a converter of `bits` bits: those that hold the sum of the readings, at most 16;
    /// 0 without a converter.
    #[must_use]
    pub fn sample_bits(&self, bits: u32) -> u32 {
        self.sum_bits(bits).min(16)
    }

    /// Bits by which the sum of the readings exceeds 16.
    pub(super) fn dropped_bits(&self, bits: u32) -> u32 {
        self.sum_bits(bits).saturating_sub(16)
    }

    /// Bits of the sum of the readings.
    fn sum_bits(&self, bits: u32) -> u32 {
        if bits == 0 { 0 } else { bits + self.readings().next_power_of_two().ilog2() }
    }

    /// Photodiodes of one reading.
    pub(super) fn photodiodes_per_reading(&self) -> usize {
        if self.mode == BinningMode::Charge { self.photodiodes() } else { 1 }
    }

    /// Readings of one sample.
    pub(super) fn readings(&self) -> usize {
        if self.mode == BinningMode::Digital { self.photodiodes() } else { 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_fits_into_its_bits() {
        let digital = |side| Binning { side, mode: BinningMode::Digital };
        for (side, bits, all, dropped) in
            [(2, 10, 12, 0), (2, 14, 16, 0), (2, 15, 16, 1), (3, 12, 16, 0), (3, 14, 16, 2), (8, 16, 16, 6)]
        {
            let binning = digital(side);
            assert_eq!(
                (binning.sample_bits(bits), binning.dropped_bits(bits)),
                (all, dropped),
                "{side}, {bits}"
            );
            let largest = ((side * side) as u64 * ((1 << bits) - 1)) >> dropped;
            assert!(largest < 1 << all, "{largest}");
        }
        assert_eq!(digital(2).sample_bits(0), 0);
        assert_eq!(Binning { side: 2, mode: BinningMode::Charge }.sample_bits(12), 12);
    }

    #[test]
    fn a_block_has_at_least_two_photodiodes_on_a_side() {
        for (side, fits) in [(0, false), (1, false), (2, true), (8, true), (9, false)] {
            assert_eq!(Binning { side, mode: BinningMode::Charge }.validate().is_ok(), fits, "{side}");
        }
    }
}
