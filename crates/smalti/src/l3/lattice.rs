//! The translational symmetry of a mosaic.

use crate::sensor::Mosaic;

/// The sample pairs of equal channels within a patch whose differences measure its contrast.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ContrastPairs {
    /// Shift from the first to the second pixel of a pair, in rows and columns.
    pub shift: [isize; 2],
    /// First and last row of the pairs' first pixels, relative to the centre of the patch.
    pub rows: [isize; 2],
    /// First and last column of the pairs' first pixels, relative to the centre of the patch.
    pub cols: [isize; 2],
}

impl ContrastPairs {
    /// The pairs along a shift in a patch that extends `half` pixels from its centre.
    pub(super) fn new(shift: Shift, half: usize) -> Self {
        // Both pixels lie within the patch; where the shift is longer than the patch, the pair is centred on
        // it.
        let span = |s: isize| {
            let half = half as isize;
            let (from, to) = ((-half).max(-half - s), half.min(half - s));
            if from <= to { [from, to] } else { [-s.div_euclid(2), -s.div_euclid(2)] }
        };
        Self { shift, rows: span(shift[0]), cols: span(shift[1]) }
    }

    /// Number of pairs.
    #[must_use]
    pub fn count(&self) -> usize {
        ((self.rows[1] - self.rows[0] + 1) * (self.cols[1] - self.cols[0] + 1)) as usize
    }

    /// Distance from the centre of the farthest sample read, in rows and columns.
    #[must_use]
    pub fn reach(&self) -> [usize; 2] {
        let far = |span: [isize; 2], s: isize| {
            [span[0], span[1], span[0] + s, span[1] + s]
                .map(isize::unsigned_abs)
                .into_iter()
                .max()
                .unwrap_or(0)
        };
        [far(self.rows, self.shift[0]), far(self.cols, self.shift[1])]
    }
}

/// A shift in rows and columns.
pub(super) type Shift = [isize; 2];

/// Two short, independent translations that map every pixel to one of its own channel, the shorter first.
/// They are the reduced basis of the mosaic's translation lattice, which may be finer than its tile: a 5 × 5
/// tile whose rows are shifted copies of each other repeats along a knight's move.
pub(super) fn basis(mosaic: &Mosaic) -> [Shift; 2] {
    let (rows, cols) = (mosaic.rows() as isize, mosaic.cols() as isize);
    let repeats = |[r, c]: Shift| {
        let (down, right) = (r.rem_euclid(rows) as usize, c.rem_euclid(cols) as usize);
        mosaic.shifted(down, right).cells() == mosaic.cells()
    };
    // One of each pair of opposite shifts suffices. The tile itself is included, so two independent shifts exist.
    let half = (0..=rows).flat_map(|r| (-cols..=cols).map(move |c| [r, c]));
    let mut all: Vec<Shift> = half.filter(|&[r, c]| r > 0 || c > 0).collect();
    // Ordered by squared length; equal lengths in the order right, down, others.
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
    /// Both pixels of a pair lie within the patch where the shift allows it; otherwise one pair is centred on it.
    #[test]
    fn pairs_fill_the_patch_or_surround_its_centre() {
        let shifts = [[0, 2], [2, 0], [1, -1], [1, 2], [2, -1], [0, 8], [7, 0], [12, 5], [3, -9]];
        for (half, shift) in (1..=5).flat_map(|half| shifts.map(|shift| (half, shift))) {
            let pairs = ContrastPairs::new(shift, half);
            let firsts = (pairs.rows[0]..=pairs.rows[1])
                .flat_map(|r| (pairs.cols[0]..=pairs.cols[1]).map(move |c| [r, c]));
            let ends: Vec<Shift> = firsts.flat_map(|[r, c]| [[r, c], [r + shift[0], c + shift[1]]]).collect();
            let farthest = |axis: usize| ends.iter().map(|e| e[axis].unsigned_abs()).max().unwrap();
            assert_eq!(pairs.reach(), [farthest(0), farthest(1)], "{shift:?}, {half}");
            let mut count = 1;
            for (axis, long) in shift.map(isize::unsigned_abs).into_iter().enumerate() {
                let fitting = (2 * half + 1).saturating_sub(long);
                count *= fitting.max(1);
                let most = if fitting > 0 { half } else { long.div_ceil(2) };
                assert!(farthest(axis) == most, "{shift:?}, {half}: {}", farthest(axis));
            }
            assert_eq!((pairs.count(), ends.len()), (count, 2 * count), "{shift:?}, {half}");
        }
    }
}
