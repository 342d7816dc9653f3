//! Symmetries under which tiles are the same mosaic: shifts, mirror images and rotations.

use serde::{Deserialize, Serialize};

/// The symmetry under which two tiles count as the same mosaic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Symmetry {
    /// Shifts of the origin.
    #[default]
    Shift,
    /// Shifts, and reflections at a row or a column; both together are a rotation by 180°.
    ShiftMirror,
    /// Shifts, reflections and rotations by 90°; for square tiles.
    ShiftMirrorRotation,
}

/// The group of permutations of the cells of a tile by a symmetry. The identity comes first.
pub(super) struct Group {
    cells: usize,
    /// Element by element: for each cell, the cell whose colour it takes.
    sources: Vec<u16>,
}

impl Group {
    /// The group for at most 65536 cells. Rotations by 90° need a square tile.
    pub(super) fn new(rows: usize, cols: usize, symmetry: Symmetry) -> Self {
        let turned = symmetry == Symmetry::ShiftMirrorRotation && rows == cols;
        let options = |on: bool| if on { &[false, true][..] } else { &[false][..] };
        let mirrored = options(symmetry != Symmetry::Shift);
        let mut elements: Vec<Vec<u16>> = Vec::new();
        for (&transposed, &down) in options(turned).iter().flat_map(|t| mirrored.iter().map(move |d| (t, d)))
        {
            for &across in mirrored {
                for shift in 0..rows * cols {
                    let source = |cell: usize| {
                        let (row, col) = (cell / cols, cell % cols);
                        let (row, col) = if transposed { (col, row) } else { (row, col) };
                        let row = if down { rows - 1 - row } else { row };
                        let col = if across { cols - 1 - col } else { col };
                        ((row + shift / cols) % rows * cols + (col + shift % cols) % cols) as u16
                    };
                    elements.push((0..rows * cols).map(source).collect());
                }
            }
        }
        // On small tiles a reflection can equal a shift. The identity is the smallest element.
        elements.sort_unstable();
        elements.dedup();
        Self { cells: rows * cols, sources: elements.concat() }
    }

    pub(super) fn elements(&self) -> impl ExactSizeIterator<Item = &[u16]> {
        self.sources.chunks_exact(self.cells)
    }

    pub(super) fn element(&self, index: usize) -> &[u16] {
        &self.sources[index * self.cells..][..self.cells]
    }

    /// The lexicographically smallest image of a tile.
    pub(super) fn canonical(&self, tile: &[u8]) -> Box<[u8]> {
        let mut best = self.element(0);
        for element in self.elements().skip(1) {
            let image = element.iter().map(|&s| tile[usize::from(s)]);
            if image.lt(best.iter().map(|&s| tile[usize::from(s)])) {
                best = element;
            }
        }
        best.iter().map(|&s| tile[usize::from(s)]).collect()
    }

    /// Whether the first cells of a tile can begin a canonical tile, that is, no image is already smaller.
    pub(super) fn may_be_canonical(&self, first: &[u8]) -> bool {
        self.elements().skip(1).all(|element| {
            for (&source, own) in element.iter().zip(first) {
                match first.get(usize::from(source)) {
                    Some(cell) if cell < own => return false,
                    Some(cell) if cell == own => {}
                    _ => return true,
                }
            }
            true
        })
    }
}

/// Writes the cycle of each cell, numbered in order of appearance, and returns the number of cycles.
pub(super) fn cycles(element: &[u16], of: &mut [u16]) -> usize {
    of.fill(u16::MAX);
    let mut count = 0;
    for start in 0..element.len() {
        if of[start] == u16::MAX {
            let mut cell = start;
            while of[cell] == u16::MAX {
                of[cell] = count;
                cell = usize::from(element[cell]);
            }
            count += 1;
        }
    }
    usize::from(count)
}
