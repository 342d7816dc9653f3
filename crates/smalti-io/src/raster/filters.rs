//! Undoing the filters of HDF5, and the compression and predictors of TIFF.

use flate2::{Decompress, FlushDecompress};
use weezl::BitOrder;

use super::run::Raster;
use super::{Axis, Bad};

/// A step of writing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Filter {
    /// zlib.
    Deflate,
    /// As in TIFF 6.0, section 13.
    Lzw,
    /// TIFF 6.0, section 9.
    PackBits,
    /// All first bytes of the samples, then all second bytes, …
    Shuffle,
    /// Differences between neighbours in a row, taken as whole numbers (TIFF 6.0, section 14).
    Differences,
    /// Differences of the bytes of a row, the first bytes of all its samples first (TIFF Technical Note 3). What comes out is
    /// big-endian.
    FloatDifferences,
}

/// Memory of a thread that undoes filters.
#[derive(Default)]
pub(crate) struct Scratch {
    /// A window of a file.
    pub(super) window: Vec<u8>,
    pub(super) block: Vec<u8>,
    other: Vec<u8>,
    inflater: Option<Decompress>,
}

impl Scratch {
    /// Replaces the content of `self.block` by the result of `unpack`, which are samples of this shape.
    pub(super) fn replaced(
        &mut self,
        shape: &Raster,
        unpack: impl FnOnce(&[u8], &mut Vec<u8>) -> Result<(), String>,
    ) -> Result<(), Bad> {
        self.other.clear();
        unpack(&self.block, &mut self.other).map_err(Bad::Block)?;
        std::mem::swap(&mut self.block, &mut self.other);
        match Some(self.block.len() as u64) == shape.bytes() {
            true => Ok(()),
            false => Err(Bad::Block("a block is of another length".into())),
        }
    }

    /// Undoes the filters of a block of these samples, which is in `self.block`, and leaves the result there.
    pub(super) fn undo(
        &mut self,
        filters: impl DoubleEndedIterator<Item = Filter>,
        shape: &Raster,
    ) -> Result<(), Bad> {
        let need = shape.bytes().and_then(|n| usize::try_from(n).ok()).unwrap_or(usize::MAX);
        let short = |what: &str| Bad::Block(format!("a block does not unpack to {need} bytes: {what}"));
        let size = shape.kind.size();
        let samples = if shape.order[2] == Axis::Band { shape.bands } else { 1 };
        let row = shape.cols.saturating_mul(samples).saturating_mul(size).max(1);
        for filter in filters.rev() {
            let packs = matches!(filter, Filter::Deflate | Filter::Lzw | Filter::PackBits);
            if !packs && self.block.len() != need {
                return Err(short("it is of another length"));
            }
            match filter {
                Filter::Differences => {
                    let rows = self.block.chunks_mut(row);
                    rows.for_each(|r| add_differences(r, samples, size, shape.big_endian));
                    continue;
                }
                Filter::FloatDifferences => {
                    self.block.chunks_mut(row).for_each(|r| restore_floats(r, samples, size));
                    continue;
                }
                _ => self.other.resize(need, 0),
            }
            let (packed, out) = (self.block.as_slice(), self.other.as_mut_slice());
            match filter {
                Filter::Deflate => {
                    let inflater = self.inflater.get_or_insert_with(|| Decompress::new(true));
                    inflater.reset(true);
                    inflater
                        .decompress(packed, out, FlushDecompress::Finish)
                        .map_err(|e| short(&e.to_string()))?;
                    if inflater.total_out() != need as u64 {
                        return Err(short("it ends before"));
                    }
                }
                Filter::Lzw => {
                    let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(BitOrder::Msb, 8);
                    let (mut from, mut to) = (packed, out);
                    while !to.is_empty() {
                        let step = decoder.decode_bytes(from, to);
                        step.status.map_err(|e| short(&e.to_string()))?;
                        if step.consumed_in == 0 && step.consumed_out == 0 {
                            return Err(short("it ends before"));
                        }
                        from = from.get(step.consumed_in..).unwrap_or_default();
                        to = to.get_mut(step.consumed_out..).unwrap_or_default();
                    }
                }
                Filter::PackBits => unpack_bits(packed, out).ok_or_else(|| short("it ends before"))?,
                _ => unshuffle(packed, size, out),
            }
            std::mem::swap(&mut self.block, &mut self.other);
        }
        if self.block.len() == need { Ok(()) } else { Err(short("it is of another length")) }
    }
}

fn unshuffle(shuffled: &[u8], size: usize, into: &mut [u8]) {
    fn sized<const N: usize>(shuffled: &[u8], into: &mut [u8]) {
        let count = shuffled.len() / N;
        let mut planes = shuffled.chunks_exact(count.max(1));
        let planes: [&[u8]; N] = std::array::from_fn(|_| planes.next().unwrap_or_default());
        for (i, element) in into.as_chunks_mut::<N>().0.iter_mut().enumerate().take(count) {
            for (byte, plane) in element.iter_mut().zip(planes) {
                *byte = plane.get(i).copied().unwrap_or_default();
            }
        }
    }
    match size {
        2 => sized::<2>(shuffled, into),
        3 => sized::<3>(shuffled, into),
        4 => sized::<4>(shuffled, into),
        8 => sized::<8>(shuffled, into),
        _ => into.copy_from_slice(shuffled),
    }
}

/// PackBits (TIFF 6.0, section 9).
fn unpack_bits(packed: &[u8], out: &mut [u8]) -> Option<()> {
    let (mut from, mut to) = (packed, out);
    while !to.is_empty() {
        let (&head, rest) = from.split_first()?;
        let count;
        match head as i8 {
            -128 => {
                from = rest;
                continue;
            }
            n @ 0.. => {
                count = (n as usize + 1).min(to.len());
                to.get_mut(..count)?.copy_from_slice(rest.get(..count)?);
                from = rest.get(n as usize + 1..).unwrap_or_default();
            }
            n => {
                count = (1 + usize::from(n.unsigned_abs())).min(to.len());
                to.get_mut(..count)?.fill(*rest.first()?);
                from = rest.get(1..)?;
            }
        }
        to = to.get_mut(count..)?;
    }
    Some(())
}

/// Undoes horizontal differencing (TIFF 6.0, section 14) of samples of any size, taken as whole numbers. Each is the difference to the one
/// `samples` before it.
pub(crate) fn add_differences(row: &mut [u8], samples: usize, size: usize, big_endian: bool) {
    macro_rules! of {
        ($t:ty) => {{
            let (load, store): (fn(_) -> $t, fn($t) -> _) = if big_endian {
                (<$t>::from_be_bytes, <$t>::to_be_bytes)
            } else {
                (<$t>::from_le_bytes, <$t>::to_le_bytes)
            };
            let numbers = row.as_chunks_mut().0;
            for i in samples..numbers.len() {
                numbers[i] = store(load(numbers[i]).wrapping_add(load(numbers[i - samples])));
            }
        }};
    }
    match size {
        1 => of!(u8),
        2 => of!(u16),
        4 => of!(u32),
        _ => of!(u64),
    }
}

/// Undoes the predictor of floating point (TIFF Technical Note 3): differences of bytes, the first bytes of all samples first.
pub(crate) fn restore_floats(row: &mut [u8], samples: usize, size: usize) {
    for i in samples..row.len() {
        row[i] = row[i].wrapping_add(row[i - samples]);
    }
    let shuffled = row.to_vec();
    // The first bytes are the most significant: the result is big-endian.
    unshuffle(&shuffled, size, row);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_put_back_in_order() {
        let mut out = [0; 8];
        unshuffle(&[1, 5, 2, 6, 3, 7, 4, 8], 4, &mut out);
        assert_eq!(out, [1, 2, 3, 4, 5, 6, 7, 8]);
        let mut out = [0; 4];
        unshuffle(&[1, 3, 2, 4], 2, &mut out);
        assert_eq!(out, [1, 2, 3, 4]);
        unshuffle(&[1, 3, 2, 4], 1, &mut out);
        assert_eq!(out, [1, 3, 2, 4]);
    }
}
