//! Mosaics of filters that are still to be found, whose names do not matter.

use std::collections::BTreeSet;

use super::group::{Group, Symmetry};
use crate::sensor::Mosaic;

/// The mosaics without those that equal an earlier one after a symmetry and an exchange of filters.
pub(in crate::design) fn distinct(mosaics: Vec<Mosaic>, symmetry: Symmetry) -> Vec<Mosaic> {
    let mut seen = BTreeSet::new();
    let is_new = |m: &Mosaic| seen.insert((m.rows(), m.cols(), smallest_image(m, symmetry)));
    mosaics.into_iter().filter(is_new).collect()
}

/// The smallest image of a tile under the symmetry, with filters numbered in their order of appearance.
fn smallest_image(mosaic: &Mosaic, symmetry: Symmetry) -> Vec<u8> {
    let cells = mosaic.cells();
    let group = Group::new(mosaic.rows(), mosaic.cols(), symmetry);
    let renamed = |element: &[u16]| {
        let mut names: Vec<u8> = Vec::new();
        let name = |&source: &u16| {
            let cell = cells[usize::from(source)];
            let known = names.iter().position(|n| *n == cell);
            known.unwrap_or_else(|| {
                names.push(cell);
                names.len() - 1
            }) as u8
        };
        element.iter().map(name).collect::<Vec<u8>>()
    };
    group.elements().map(renamed).min().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{MosaicFamily, Tile};

    fn of(colors: usize, symmetry: Symmetry) -> Vec<Mosaic> {
        let tile = Tile { rows: 2, cols: 2, symmetry };
        distinct(MosaicFamily::Tile(tile).pick(colors, None, 1).unwrap(), symmetry)
    }

    #[test]
    fn a_tile_of_two_by_two_has_few_layouts() {
        // Stripes along rows, along columns and the checkerboard, and three cells of one filter; rotations make the stripes equal.
        assert_eq!(of(2, Symmetry::ShiftMirrorRotation).len(), 3);
        assert_eq!(of(2, Symmetry::Shift).len(), 4);
        // Bayer, and a pair in a row or a column.
        assert_eq!(of(3, Symmetry::ShiftMirrorRotation).len(), 2);
        assert_eq!(of(4, Symmetry::ShiftMirrorRotation).len(), 1);
    }
}
