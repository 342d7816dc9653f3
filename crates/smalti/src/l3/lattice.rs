//! Where a mosaic repeats itself.

use crate::sensor::Mosaic;

/// A shift in rows and columns.
pub(super) type Shift = [isize; 2];

/// Two short, independent shifts under which every pixel meets one of its own channel, the shorter first: the reduced
/// basis of the mosaic's translations, which may be finer than its tile (a 5 × 5 tile whose rows are shifted copies of each
/// other repeats along a knight's move).
pub(super) fn basis(mosaic: &Mosaic) -> [Shift; 2] {
    let (rows, cols) = (mosaic.rows() as isize, mosaic.cols() as isize);
    let repeats = |[r, c]: Shift| {
        let (down, right) = (r.rem_euclid(rows) as usize, c.rem_euclid(cols) as usize);
        mosaic.shifted(down, right).cells() == mosaic.cells()
    };
    // Of a shift and its opposite one is enough. The tile itself is among them, so two independent ones are.
    let half = (0..=rows).flat_map(|r| (-cols..=cols).map(move |c| [r, c]));
    let mut all: Vec<Shift> = half.filter(|&[r, c]| r > 0 || c > 0).collect();
    // Squares of lengths; equal ones in the order right, down, others.
    all.sort_by_key(|&[r, c]| (r * r + c * c, r, c));
    let mut found: Vec<Shift> = Vec::new();
    for shift in all {
        let independent = found.first().is_none_or(|f| f[0] * shift[1] != f[1] * shift[0]);
        if independent && repeats(shift) {
            found.push(shift);
        }
        if found.len() == 2 {
            break;
        }
    }
    [found.first().copied().unwrap_or([0, cols]), found.get(1).copied().unwrap_or([rows, 0])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_and_finer_repetitions() {
        let basis_of = |rows, cols, cells: &[u8]| basis(&Mosaic::new(rows, cols, cells.to_vec()).unwrap());
        assert_eq!(basis_of(2, 2, &[0, 1, 1, 2]), [[0, 2], [2, 0]]);
        assert_eq!(basis_of(2, 2, &[0, 1, 1, 0]), [[1, -1], [1, 1]]);
        assert_eq!(basis_of(1, 1, &[0]), [[0, 1], [1, 0]]);
        // A column of stripes.
        assert_eq!(basis_of(1, 3, &[0, 1, 2]), [[1, 0], [0, 3]]);
        // Every row two to the right of the one above.
        let knight: Vec<u8> = (0..25).map(|i| ((i % 5 + 3 * (i / 5)) % 5) as u8).collect();
        assert_eq!(basis_of(5, 5, &knight), [[1, 2], [2, -1]]);
    }
}
