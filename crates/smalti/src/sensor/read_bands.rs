//! Read-out of bands of rows: from the light on the photodiodes to samples, pixel by pixel or with binning.

use super::Binning;
use super::conversion_gain::Combination;
use super::readout::Readout;
use crate::numeric::elementary::whole_part_f32;
use crate::numeric::poisson::LANES;
use crate::numeric::simd::Kernel;

/// Scale from volts to samples.
pub(super) struct SampleScale {
    pub(super) scale: f32,
    pub(super) black: f32,
    pub(super) last: f32,
}

/// The output type of a converter.
pub(super) trait Sample: Copy + Default + Send + Sync {
    fn from_volts(volts: f32, to: &SampleScale) -> Self;

    /// This sample of the high conversion gain, or one of the low gain in its place.
    fn with_low(self, low: Self, both: &Combination) -> Self;

    /// The mean of `count` volts, or the sum of numbers without its last `dropped` bits.
    fn combined(samples: impl Iterator<Item = Self>, count: usize, dropped: u32) -> Self;
}

impl Sample for f32 {
    #[inline(always)]
    fn from_volts(volts: f32, _: &SampleScale) -> Self {
        volts
    }

    fn with_low(self, low: Self, both: &Combination) -> Self {
        both.combined(self, low)
    }

    fn combined(samples: impl Iterator<Item = Self>, count: usize, _: u32) -> Self {
        (samples.map(f64::from).sum::<f64>() / count as f64) as f32
    }
}

impl Sample for u16 {
    #[inline(always)]
    fn from_volts(volts: f32, to: &SampleScale) -> Self {
        // The value is not negative here, so that the whole part after adding a half is the nearest number.
        let number = (volts * to.scale + to.black).max(0.0).min(to.last);
        whole_part_f32(number + 0.5) as u16
    }

    fn with_low(self, low: Self, both: &Combination) -> Self {
        both.combined(f32::from(self), f32::from(low)).round().clamp(0.0, f32::from(u16::MAX)) as u16
    }

    fn combined(samples: impl Iterator<Item = Self>, _: usize, dropped: u32) -> Self {
        let (sum, half) = (samples.map(u32::from).sum::<u32>(), (1u32 << dropped) >> 1);
        ((sum + half) >> dropped) as u16
    }
}

/// Combines the samples of blocks of pixels, row by row.
pub(super) fn combine_blocks<S: Sample>(
    samples: &[S],
    binning: Binning,
    bits: u32,
    cols: usize,
    out: &mut [S],
) {
    let (side, dropped) = (binning.side, binning.dropped_bits(bits));
    let width = cols * side;
    for (lines, out) in samples.chunks_exact(width * side).zip(out.chunks_exact_mut(cols)) {
        for (c, out) in out.iter_mut().enumerate() {
            let block = lines.chunks_exact(width).flat_map(|line| &line[c * side..(c + 1) * side]);
            *out = S::combined(block.copied(), binning.photodiodes(), dropped);
        }
    }
}

/// At most a block of values, followed by zeros.
#[inline(always)]
fn padded(values: &[f32]) -> [f32; LANES] {
    // Most blocks are whole, and copied without a call.
    if let Ok(whole) = values.try_into() {
        return whole;
    }
    let mut lanes = [0.0; LANES];
    lanes[..values.len()].copy_from_slice(values);
    lanes
}

/// Read-out of a band of rows whose samples are blocks of `side` × `side` photodiodes on one floating diffusion.
pub(super) struct ChargeBand<'a, S> {
    pub(super) readout: &'a Readout<'a>,
    pub(super) to_sample: &'a SampleScale,
    /// Row, column and plane of the first sample.
    pub(super) origin: (u32, u32, u32),
    pub(super) side: usize,
    /// Samples of a row.
    pub(super) cols: usize,
    /// One value per column of samples, padded to a whole number of blocks.
    pub(super) fixed_offset_v: &'a [f32],
    /// Light on the photodiodes.
    pub(super) light: &'a [f32],
    pub(super) out: &'a mut [S],
}

impl<S: Sample> Kernel for ChargeBand<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (row, col, plane) = self.origin;
        let (side, width) = (self.side, self.cols * self.side);
        let mut charge_v = vec![0.0f32; self.cols.next_multiple_of(LANES)];
        let rows = self.out.chunks_exact_mut(self.cols).zip(self.light.chunks_exact(width * side));
        for (r, (out, light)) in rows.enumerate() {
            let sample_row = row.wrapping_add(r as u32);
            charge_v.fill(0.0);
            for (i, light) in light.chunks_exact(width).enumerate() {
                let photodiode_row = sample_row.wrapping_mul(side as u32).wrapping_add(i as u32);
                for (b, light) in light.chunks(LANES).enumerate() {
                    let mut volts = [0.0; LANES];
                    let first = col.wrapping_mul(side as u32).wrapping_add((b * LANES) as u32);
                    self.readout.charge((photodiode_row, first, plane), &padded(light), &mut volts);
                    for (k, v) in volts[..light.len()].iter().enumerate() {
                        charge_v[(b * LANES + k) / side] += v;
                    }
                }
            }
            let blocks =
                out.chunks_mut(LANES).zip(charge_v.as_chunks().0).zip(self.fixed_offset_v.as_chunks().0);
            for (b, ((out, charge_v), fixed)) in blocks.enumerate() {
                let mut volts = [0.0; LANES];
                let at = (sample_row, col.wrapping_add((b * LANES) as u32), plane);
                self.readout.reading(at, charge_v, fixed, &mut volts);
                for (o, &v) in out.iter_mut().zip(&volts) {
                    *o = S::from_volts(v, self.to_sample);
                }
            }
        }
    }
}

/// Read-out of a band of rows.
pub(super) struct Band<'a, S> {
    pub(super) readout: &'a Readout<'a>,
    pub(super) to_sample: &'a SampleScale,
    /// Row, column and plane of the first pixel.
    pub(super) origin: (u32, u32, u32),
    pub(super) cols: usize,
    /// One value per column, padded to a whole number of blocks.
    pub(super) fixed_offset_v: &'a [f32],
    pub(super) light: &'a [f32],
    pub(super) out: &'a mut [S],
}

impl<S: Sample> Kernel for Band<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (row, col, plane) = self.origin;
        let rows = self.out.chunks_exact_mut(self.cols).zip(self.light.chunks_exact(self.cols));
        for (r, (out, light)) in rows.enumerate() {
            let blocks =
                out.chunks_mut(LANES).zip(light.chunks(LANES)).zip(self.fixed_offset_v.as_chunks().0);
            for (b, ((out, light), fixed)) in blocks.enumerate() {
                let mut volts = [0.0; LANES];
                let at = (row.wrapping_add(r as u32), col.wrapping_add((b * LANES) as u32), plane);
                self.readout.block(at, &padded(light), fixed, &mut volts);
                for (o, &v) in out.iter_mut().zip(&volts) {
                    *o = S::from_volts(v, self.to_sample);
                }
            }
        }
    }
}
