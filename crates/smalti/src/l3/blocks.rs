//! Blocks of columns for vector code.
//!
//! Loops over arrays of a block's width become loops over whole registers, and the overhead per block is
//! small. Single vectors process the columns that remain at the end of a row.

/// Lanes of a vector: one AVX-512 register of `f32`.
pub(super) const LANES: usize = 16;
/// Columns of a block, four vectors.
pub(super) const BLOCK: usize = 4 * LANES;

/// An operation on `W` columns from `at`, with `W` a compile-time constant.
pub(super) trait Columns {
    /// Must be `#[inline(always)]`, so that it is compiled for the instruction set of its caller.
    fn columns<const W: usize>(&mut self, at: usize);
}

/// Processes the columns up to `len`, which is a multiple of the number of lanes.
#[inline(always)]
pub(super) fn each(len: usize, work: &mut impl Columns) {
    let mut at = 0;
    while at + BLOCK <= len {
        work.columns::<BLOCK>(at);
        at += BLOCK;
    }
    while at < len {
        work.columns::<LANES>(at);
        at += LANES;
    }
}

/// The values of a line from `at`. Lines are padded so that enough values exist.
#[inline(always)]
pub(super) fn values<T, const W: usize>(line: &[T], at: usize) -> Option<&[T; W]> {
    line.get(at..).and_then(|l| l.first_chunk())
}

/// Like [`values`], but mutable.
#[inline(always)]
pub(super) fn values_mut<T, const W: usize>(line: &mut [T], at: usize) -> Option<&mut [T; W]> {
    line.get_mut(at..).and_then(|l| l.first_chunk_mut())
}

/// Adds the values of a line that begin at the `taps` columns from `at`.
#[inline(always)]
pub(super) fn add_taps<const W: usize>(total: &mut [f32; W], line: &[f32], at: usize, taps: usize) {
    for tap in 0..taps {
        let Some(values) = values::<f32, W>(line, at + tap) else { return };
        for i in 0..W {
            total[i] += values[i];
        }
    }
}

/// Period, in columns, of a tile and the blocks together: the least common multiple of the two widths. The
/// block width is a power of two.
pub(super) fn run_of(tile_cols: usize) -> usize {
    tile_cols << (BLOCK.trailing_zeros() - tile_cols.trailing_zeros().min(BLOCK.trailing_zeros()))
}
