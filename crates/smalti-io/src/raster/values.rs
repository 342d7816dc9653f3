//! From stored numbers to values.

use crate::file::{Negative, sample};

/// A sample that is not what it should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BadSample {
    /// The band, in the order of the file.
    pub(crate) band: usize,
    pub(crate) row: usize,
    pub(crate) col: usize,
    pub(crate) value: f32,
    pub(crate) expected: &'static str,
}

/// From stored numbers to values: `number * gain + offset`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Values<'a> {
    /// Gain and offset of every band of the file; where it is shorter, 1 and 0.
    pub(crate) gains: &'a [(f64, f64)],
    /// The number that marks missing measurements.
    pub(crate) ignore: Option<f32>,
    pub(crate) negative: Negative,
}

pub(super) const MEASURED: &str =
    "a measured value, not the one that says there is none (cut it out, or let it be taken as 0)";

impl Values<'_> {
    /// Scales and checks a part of a band, whose rows of `cols` samples begin at a row and column of the file.
    pub(crate) fn check(
        &self,
        band: usize,
        values: &mut [f32],
        (first_row, first_col, cols): (usize, usize, usize),
    ) -> Result<(), BadSample> {
        let bad = |i: usize, value: f32, expected| {
            let (row, col) = (first_row + i / cols.max(1), first_col + i % cols.max(1));
            BadSample { band, row, col, value, expected }
        };
        if let Some(ignore) = self.ignore.filter(|v| *v != 0.0) {
            let missing = |v: f32| v == ignore || (v.is_nan() && ignore.is_nan());
            for (i, v) in values.iter_mut().enumerate() {
                if missing(*v) {
                    if self.negative != Negative::Clamp {
                        return Err(bad(i, *v, MEASURED));
                    }
                    *v = 0.0;
                }
            }
        }
        if let Some((gain, offset)) = self.gains.get(band).filter(|g| **g != (1.0, 0.0)) {
            values.iter_mut().for_each(|v| *v = (f64::from(*v) * gain + offset) as f32);
        }
        // Almost always all are well, and this loop has no branch. Minus zero becomes zero.
        let mut well = true;
        for v in values.iter_mut() {
            well &= (*v >= 0.0) & (*v <= f32::MAX);
            *v += 0.0;
        }
        if well {
            return Ok(());
        }
        for (i, v) in values.iter_mut().enumerate() {
            *v = sample(*v, self.negative).map_err(|expected| bad(i, *v, expected))?;
        }
        Ok(())
    }
}
