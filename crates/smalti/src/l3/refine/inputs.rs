//! The inputs of the second stage at a pixel.

use super::roots::{ROOTS, roots};
use super::stages::{FINE, MARGIN, SCALES, Stages};

/// Outputs: X, Y, Z.
pub(super) const OUTPUTS: usize = 3;
/// Side of the neighbourhood of Y.
pub(super) const SIDE_Y: usize = 5;
/// Side of the neighbourhoods of X and Z.
pub(super) const SIDE_XZ: usize = 3;
/// Number of inputs that are linear in the picture: Y of 5 × 5 pixels, X of 3 × 3, Z of 3 × 3, and X, Y, Z of every smooth picture.
pub(super) const LINEAR: usize = SIDE_Y * SIDE_Y + 2 * SIDE_XZ * SIDE_XZ + 3 * SCALES;
/// Number of inputs: the linear ones, and the roots of one of the smooth pictures.
pub(super) const COUNT: usize = LINEAR + ROOTS;
/// The smooth picture of the roots: little noise is left in it, and the root of noise is biased.
pub(super) const ROOTS_OF: usize = 2;
/// Neighbourhoods: the plane, and the side.
pub(super) const NEIGHBOURHOODS: [(usize, usize); 3] = [(1, SIDE_Y), (0, SIDE_XZ), (2, SIDE_XZ)];

/// The first input of a smooth picture: X, Y, Z of the finest.
pub(super) const SMOOTH: usize = LINEAR - 3 * SCALES;

/// The input that is the pixel itself in X, Y, Z.
pub(super) const OWN: [usize; OUTPUTS] = [
    SIDE_Y * SIDE_Y + SIDE_XZ * SIDE_XZ / 2,
    SIDE_Y * SIDE_Y / 2,
    SIDE_Y * SIDE_Y + SIDE_XZ * SIDE_XZ + SIDE_XZ * SIDE_XZ / 2,
];

/// The plane of a linear input: 0, 1 and 2 for X, Y and Z.
pub(super) fn plane_of(input: usize) -> usize {
    let mut after = input;
    for (plane, side) in NEIGHBOURHOODS {
        match after.checked_sub(side * side) {
            None => return plane,
            Some(rest) => after = rest,
        }
    }
    after % OUTPUTS
}

/// The lines from which the inputs of a row are read.
pub(super) struct Lines<'a> {
    /// Y of five rows, X of three, Z of three.
    pub(super) neighbours: [&'a [f32]; SIDE_Y + 2 * SIDE_XZ],
    /// X, Y, Z of every smooth picture.
    pub(super) smooth: [&'a [f32]; 3 * SCALES],
}

impl<'a> Lines<'a> {
    #[inline(always)]
    pub(super) fn of(stages: &'a Stages, row: usize) -> Self {
        let mut neighbours = [&[] as &[f32]; SIDE_Y + 2 * SIDE_XZ];
        let mut at = 0;
        for (plane, side) in NEIGHBOURHOODS {
            for down in 0..side {
                let row = (row + down) as isize - (side / 2) as isize;
                neighbours[at] = stages.picture().line(plane, row);
                at += 1;
            }
        }
        let smooth = std::array::from_fn(|i| {
            let row = if i / 3 < FINE { row } else { row / 2 };
            stages.smooth(i / 3).line(i % 3, row as isize)
        });
        Self { neighbours, smooth }
    }

    /// Writes the inputs of a pixel.
    #[inline(always)]
    pub(super) fn read(&self, col: usize, out: &mut [f32; COUNT]) {
        let mut lines = self.neighbours.iter();
        let mut places = out.iter_mut();
        for (_, side) in NEIGHBOURHOODS {
            let from = MARGIN + col - side / 2;
            for line in lines.by_ref().take(side) {
                line[from..from + side].iter().zip(places.by_ref()).for_each(|(v, place)| *place = *v);
            }
        }
        for (i, (line, place)) in self.smooth.iter().zip(places.by_ref()).enumerate() {
            *place = line[MARGIN + if i / 3 < FINE { col } else { col / 2 }];
        }
        let [x, y, z] = self.of_roots().map(|line| line[MARGIN + col]);
        places.zip(roots(x, y, z)).for_each(|(place, root)| *place = root);
    }

    /// X, Y, Z of the smooth picture of the roots.
    pub(super) fn of_roots(&self) -> [&'a [f32]; 3] {
        std::array::from_fn(|plane| self.smooth[3 * ROOTS_OF + plane])
    }
}
