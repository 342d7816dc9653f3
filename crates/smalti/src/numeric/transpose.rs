//! Transposition of spectra, in tiles one cache line wide.

use super::fft::Complex32;
use super::simd::{Kernel, dispatch};

/// Side of a tile, in values: 8 complex numbers fill a cache line of 64 bytes.
pub(super) const TILE: usize = 8;

/// Writes the first `count` columns of `from` (rows `stride` apart) as rows of `len` values.
pub(super) fn transpose(from: &[Complex32], stride: usize, to: &mut [Complex32], len: usize, count: usize) {
    if count == TILE {
        return dispatch(TransposeTile { from, stride, to, len });
    }
    for (i, line) in from.chunks(stride).take(len).enumerate() {
        for (t, &v) in line.iter().take(count).enumerate() {
            to[t * len + i] = v;
        }
    }
}

/// [`transpose`] of as many columns as a tile is wide.
struct TransposeTile<'a> {
    from: &'a [Complex32],
    stride: usize,
    to: &'a mut [Complex32],
    len: usize,
}

impl Kernel for TransposeTile<'_> {
    type Output = ();

    /// By squares of whole cache lines, so that lines are read and written at once.
    #[inline(always)]
    fn run(self) {
        let Self { from, stride, to, len } = self;
        let row = |i: usize| from.get(i * stride..).and_then(|line| line.first_chunk::<TILE>());
        let squares = len / TILE * TILE;
        for first in (0..squares).step_by(TILE) {
            let mut square = [&[Complex32::ZERO; TILE]; TILE];
            for (i, line) in square.iter_mut().enumerate() {
                let Some(found) = row(first + i) else { return };
                *line = found;
            }
            for (t, line) in to.chunks_exact_mut(len).enumerate().take(TILE) {
                for (to, row) in line[first..first + TILE].iter_mut().zip(square) {
                    *to = row[t];
                }
            }
        }
        for i in squares..len {
            let Some(line) = row(i) else { return };
            line.iter().enumerate().for_each(|(t, v)| to[t * len + i] = *v);
        }
    }
}
