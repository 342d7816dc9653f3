//! The inputs of the second stage at a pixel.

use super::stages::{MARGIN, SCALES, Stages};

/// Side of the neighbourhood of Y.
const SIDE_Y: usize = 5;
/// Side of the neighbourhoods of X and Z.
const SIDE_XZ: usize = 3;
/// Number of inputs: Y of 5 × 5 pixels, X of 3 × 3, Z of 3 × 3, and X, Y, Z of every smooth picture.
pub(super) const COUNT: usize = SIDE_Y * SIDE_Y + 2 * SIDE_XZ * SIDE_XZ + 3 * SCALES;
/// Neighbourhoods: the plane, and the side.
const NEIGHBOURHOODS: [(usize, usize); 3] = [(1, SIDE_Y), (0, SIDE_XZ), (2, SIDE_XZ)];

/// The input that is the pixel itself in X, Y, Z.
pub(super) const OWN: [usize; 3] = [
    SIDE_Y * SIDE_Y + SIDE_XZ * SIDE_XZ / 2,
    SIDE_Y * SIDE_Y / 2,
    SIDE_Y * SIDE_Y + SIDE_XZ * SIDE_XZ + SIDE_XZ * SIDE_XZ / 2,
];

/// The lines from which the inputs of a row are read.
pub(super) struct Lines<'a> {
    /// Y of five rows, X of three, Z of three.
    neighbours: [&'a [f32]; SIDE_Y + 2 * SIDE_XZ],
    /// X, Y, Z of every smooth picture.
    smooth: [&'a [f32]; 3 * SCALES],
}

impl<'a> Lines<'a> {
    #[inline(always)]
    pub(super) fn of(stages: &'a Stages, row: usize) -> Self {
        let mut neighbours = [&[] as &[f32]; SIDE_Y + 2 * SIDE_XZ];
        let mut at = 0;
        for (plane, side) in NEIGHBOURHOODS {
            for down in 0..side {
                let row = (row + down) as isize - (side / 2) as isize;
                neighbours[at] = stages.0[0].line(plane, row);
                at += 1;
            }
        }
        let smooth = std::array::from_fn(|i| stages.0[1 + i / 3].line(i % 3, row as isize));
        Self { neighbours, smooth }
    }

    /// Writes the inputs of a pixel; `out` has room for a vector more.
    #[inline(always)]
    pub(super) fn read(&self, col: usize, out: &mut [f32]) {
        let (mut at, mut line) = (0, 0);
        for (_, side) in NEIGHBOURHOODS {
            for _ in 0..side {
                let from = MARGIN + col - side / 2;
                // Rows are copied in whole registers; what is too much is overwritten by the next.
                let found = self.neighbours[line].get(from..).and_then(<[f32]>::first_chunk::<8>);
                let place = out.get_mut(at..).and_then(<[f32]>::first_chunk_mut::<8>);
                if let (Some(found), Some(place)) = (found, place) {
                    *place = *found;
                }
                at += side;
                line += 1;
            }
        }
        if let Some(out) = out.get_mut(at..).and_then(<[f32]>::first_chunk_mut::<{ 3 * SCALES }>) {
            for (out, line) in out.iter_mut().zip(self.smooth) {
                *out = line[MARGIN + col];
            }
        }
    }
}
