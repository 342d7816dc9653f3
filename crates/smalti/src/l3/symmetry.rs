//! Rotations and reflections that map a mosaic onto itself, so that patches around one cell are equivalent to
//! those around another.
//!
//! Sensor and scenes have no preferred direction. A class therefore learns from the rotated and reflected
//! patches of all cells that such an operation maps to its own. In a Bayer mosaic the red cell has all eight
//! symmetries of the square, and its kernels are symmetric; the two green cells are each other's transpose.

use super::{Axes, Levels, Textures};

/// Maximum number of cells of a tile (after removing repetitions) for the symmetry search. It tests each of
/// the eight operations with every shift and every cell, so this bounds the comparisons to 8 · 4096², a tenth
/// of a second. Larger tiles have only the identity.
const MAX_CELLS: usize = 4096;
/// Relative tolerance for equal cut points of two positions, which are computed in a different order.
const SAME_CUT: f32 = 1e-5;

/// One of the eight symmetries of the square, acting on (down, right).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Isometry([[isize; 2]; 2]);

impl Isometry {
    pub(super) const IDENTITY: Self = Self([[1, 0], [0, 1]]);
    /// All operations, the identity first.
    pub(super) const ALL: [Self; 8] = [
        Self::IDENTITY,
        Self([[1, 0], [0, -1]]),
        Self([[-1, 0], [0, 1]]),
        Self([[-1, 0], [0, -1]]),
        Self([[0, 1], [1, 0]]),
        Self([[0, 1], [-1, 0]]),
        Self([[0, -1], [1, 0]]),
        Self([[0, -1], [-1, 0]]),
    ];

    fn swaps(self) -> bool {
        self.0[0][0] == 0
    }

    fn apply(self, [down, right]: [isize; 2]) -> [isize; 2] {
        self.0.map(|[a, b]| a * down + b * right)
    }

    /// For each tap of a patch, the tap that it is mapped to.
    pub(super) fn taps(self, side: usize) -> Vec<usize> {
        let half = (side / 2) as isize;
        let moved = |tap: usize| {
            let [down, right] = self.apply([(tap / side) as isize - half, (tap % side) as isize - half]);
            (down + half) as usize * side + (right + half) as usize
        };
        (0..side * side).map(moved).collect()
    }

    /// The image of a texture class: edges rotate with the patch, other textures are unchanged.
    pub(super) fn texture(self, textures: Textures, texture: usize) -> usize {
        // The gradient directions of patches, in the order of the names from the third on.
        const DIRECTIONS: [[isize; 2]; 4] = [[0, 1], [1, 1], [1, 0], [1, -1]];
        let (Textures::Oriented, Some(edge)) = (textures, texture.checked_sub(2)) else { return texture };
        let [down, right] = self.apply(DIRECTIONS[edge % 4]);
        let same = |d: &[isize; 2]| *d == [down, right] || *d == [-down, -right];
        DIRECTIONS.iter().position(same).map_or(texture, |place| 2 + place)
    }
}

/// A cell whose transformed patches are equivalent to those of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Member {
    pub(super) position: usize,
    pub(super) isometry: Isometry,
}

/// Groups of equivalent cells of a tile, each with a representative.
#[derive(Debug)]
pub(super) struct Symmetry {
    /// For each cell: its representative, and the operation that maps the representative's patches to its
    /// own.
    pub(super) represented: Vec<Member>,
    /// The representatives, ascending, each with the cells whose patches it uses. A cell occurs once for
    /// every operation that maps it to the representative.
    pub(super) groups: Vec<(usize, Vec<Member>)>,
}

impl Symmetry {
    /// No symmetry: every cell represents itself.
    pub(super) fn none(axes: &Axes) -> Self {
        let own = |position| Member { position, isometry: Isometry::IDENTITY };
        let represented: Vec<Member> = (0..axes.positions()).map(own).collect();
        let groups = represented.iter().map(|m| (m.position, vec![*m])).collect();
        Self { represented, groups }
    }

    /// The symmetries of the mosaic that preserve every channel and the cut points of every position.
    pub(super) fn of(axes: &Axes) -> Self {
        let (rows, cols) = (axes.mosaic().rows(), axes.mosaic().cols());
        let labels = labels(axes);
        // The smallest period along rows and columns. Operations that swap the two require a square one.
        let small = [
            shortest_period(rows, |r, p| {
                (0..cols).all(|c| labels[r * cols + c] == labels[(r + p) % rows * cols + c])
            }),
            shortest_period(cols, |c, p| {
                (0..rows).all(|r| labels[r * cols + c] == labels[r * cols + (c + p) % cols])
            }),
        ];
        if small[0] * small[1] > MAX_CELLS {
            return Self::none(axes);
        }
        let cells: Vec<[isize; 2]> = places(small).collect();
        let label = |[r, c]: [isize; 2]| {
            labels[r.rem_euclid(small[0] as isize) as usize * cols + c.rem_euclid(small[1] as isize) as usize]
        };
        let moved = |isometry: Isometry, shift: [isize; 2], cell| {
            let [r, c] = isometry.apply(cell);
            [r + shift[0], c + shift[1]]
        };
        let keeps =
            |isometry, shift| cells.iter().all(|&cell| label(moved(isometry, shift, cell)) == label(cell));
        let motions: Vec<(Isometry, [isize; 2])> = Isometry::ALL
            .into_iter()
            .filter(|isometry| !isometry.swaps() || small[0] == small[1])
            .flat_map(|isometry| cells.iter().map(move |&shift| (isometry, shift)))
            .filter(|&(isometry, shift)| keeps(isometry, shift))
            .collect();
        // All cells of the tile that correspond to a cell of the smallest period.
        let copies = |[r, c]: [isize; 2]| {
            let r = r.rem_euclid(small[0] as isize) as usize;
            let c = c.rem_euclid(small[1] as isize) as usize;
            (r..rows)
                .step_by(small[0])
                .flat_map(move |r| (c..cols).step_by(small[1]).map(move |c| r * cols + c))
        };
        let mut represented = vec![None; rows * cols];
        let mut groups = Vec::new();
        for &cell in &cells {
            let stands = cell[0] as usize * cols + cell[1] as usize;
            if represented[stands].is_some() {
                continue;
            }
            let mut members = Vec::new();
            for &(isometry, shift) in &motions {
                for position in copies(moved(isometry, shift, cell)) {
                    represented[position].get_or_insert(Member { position: stands, isometry });
                }
                // The inverse operation maps these to the cell itself.
                let inverse = isometry.inverse();
                let [r, c] = inverse.apply([cell[0] - shift[0], cell[1] - shift[1]]);
                members.extend(copies([r, c]).map(|position| Member { position, isometry }));
            }
            groups.push((stands, members));
        }
        let own = |(position, m): (usize, Option<Member>)| {
            m.unwrap_or(Member { position, isometry: Isometry::IDENTITY })
        };
        Self { represented: represented.into_iter().enumerate().map(own).collect(), groups }
    }
}

impl Isometry {
    /// The transpose: the operations are orthogonal.
    fn inverse(self) -> Self {
        let [[a, b], [c, d]] = self.0;
        Self([[a, c], [b, d]])
    }
}

fn places([rows, cols]: [usize; 2]) -> impl Iterator<Item = [isize; 2]> {
    (0..rows as isize).flat_map(move |r| (0..cols as isize).map(move |c| [r, c]))
}

/// One number per cell, equal for cells with the same channel and cut points.
fn labels(axes: &Axes) -> Vec<usize> {
    let mut kinds: Vec<(usize, &Levels)> = Vec::new();
    let channels = axes.mosaic().cells().iter().map(|&c| usize::from(c));
    channels
        .enumerate()
        .map(|(position, channel)| {
            let levels = axes.levels_at(position);
            let alike = |&(c, l): &(usize, &Levels)| c == channel && same_cuts(l, levels);
            kinds.iter().position(alike).unwrap_or_else(|| {
                kinds.push((channel, levels));
                kinds.len() - 1
            })
        })
        .collect()
}

fn same_cuts(a: &Levels, b: &Levels) -> bool {
    a.cuts().iter().zip(b.cuts()).all(|(a, b)| (a - b).abs() <= SAME_CUT * a.abs().max(b.abs()))
}

/// The smallest divisor of `len` that is a period of the lines.
fn shortest_period(len: usize, equal: impl Fn(usize, usize) -> bool) -> usize {
    let mut divisors = (1..=len).filter(|p| len.is_multiple_of(*p));
    divisors.find(|&p| (0..len).all(|line| equal(line, p))).unwrap_or(len)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::{Mosaic, SignalNoise};

    fn axes(rows: usize, cols: usize, cells: &[u8]) -> Axes {
        let mosaic = Mosaic::new(rows, cols, cells.to_vec()).unwrap();
        Axes::new(mosaic, 5, Levels::new(vec![0.1]).unwrap(), SignalNoise::default()).unwrap()
    }

    /// The number of representatives, and the number of members of the first group.
    fn shape(rows: usize, cols: usize, cells: &[u8]) -> (usize, usize) {
        let s = Symmetry::of(&axes(rows, cols, cells));
        (s.groups.len(), s.groups[0].1.len())
    }

    #[test]
    fn known_mosaics() {
        let bayer = Symmetry::of(&axes(2, 2, &[0, 1, 1, 2]));
        let sizes: Vec<(usize, usize)> = bayer.groups.iter().map(|(p, m)| (*p, m.len())).collect();
        // Red and blue each have eight symmetries; green has four of its own and four that map it to the
        // other green.
        assert_eq!(sizes, [(0, 8), (1, 8), (3, 8)]);
        let sisters = |m: &&Member| m.position == 2;
        assert_eq!(bayer.groups[1].1.iter().filter(sisters).count(), 4);
        assert_eq!(bayer.represented[2].position, 1);
        // RGBW: all four cells differ. A transposition would swap the right and lower neighbours.
        assert_eq!(shape(2, 2, &[0, 1, 2, 3]), (4, 4));
        // One channel in any tile: eight symmetries of every cell.
        assert_eq!(shape(4, 6, &[0; 24]), (1, 8 * 24));
        // A checkerboard in a tile of two periods, stripes, and a knight's move (four rotations, no
        // reflections).
        assert_eq!(shape(4, 2, &[0, 1, 1, 0, 0, 1, 1, 0]), (2, 8 * 4));
        assert_eq!(shape(1, 3, &[0, 1, 2]), (3, 2));
        let knight: Vec<u8> = (0..25).map(|i| ((i % 5 + 3 * (i / 5)) % 5 == 0).into()).collect();
        assert_eq!(shape(5, 5, &knight), (2, 4 * 5));
        // X-Trans: two kinds of green; no operation maps the reds or the blues onto each other.
        let xtrans: Vec<u8> =
            "GBGGRGRGRBGBGBGGRGGRGGBGBGBRGRGRGGBG".bytes().map(|b| (b == b'G').into()).collect();
        assert!(Symmetry::of(&axes(6, 6, &xtrans)).groups.len() < 6);
    }

    /// The channels of a member's transformed patch are those of the representative's patch.
    #[test]
    fn channels_stay_with_their_taps() {
        let tiles: [(usize, usize, &[u8]); 4] = [
            (2, 2, &[0, 1, 1, 2]),
            (1, 3, &[0, 1, 2]),
            (4, 4, &[3, 2, 3, 1, 2, 3, 1, 3, 3, 1, 3, 0, 1, 3, 0, 3]),
            (3, 3, &[0, 1, 2, 1, 2, 0, 2, 0, 1]),
        ];
        for (rows, cols, cells) in tiles {
            let axes = axes(rows, cols, cells);
            let s = Symmetry::of(&axes);
            let check = |from: usize, to: usize, isometry: Isometry| {
                for (tap, moved) in isometry.taps(5).into_iter().enumerate() {
                    assert_eq!(axes.channel_of(from, tap), axes.channel_of(to, moved));
                }
            };
            for (stands, members) in &s.groups {
                members.iter().for_each(|m| check(m.position, *stands, m.isometry));
            }
            s.represented.iter().enumerate().for_each(|(p, m)| check(m.position, p, m.isometry));
        }
    }

    #[test]
    fn positions_with_other_levels_stay_apart() {
        let levels = |c: [f32; 4]| c.map(|c| Levels::new(vec![c]).unwrap()).to_vec();
        let bayer = axes(2, 2, &[0, 1, 1, 2]);
        let same = bayer.clone().with_levels(levels([0.1, 0.2, 0.200_000_1, 0.3])).unwrap();
        assert_eq!(Symmetry::of(&same).groups.len(), 3);
        let apart = bayer.with_levels(levels([0.1, 0.2, 0.25, 0.3])).unwrap();
        let s = Symmetry::of(&apart);
        assert_eq!(s.groups.len(), 4);
        // Reflections of rows and columns remain.
        assert!(s.groups.iter().all(|(_, members)| members.len() == 4));
    }

    #[test]
    fn edges_turn_with_the_patch() {
        let transpose = Isometry([[0, 1], [1, 0]]);
        let (oriented, mirror) = (Textures::Oriented, Isometry([[1, 0], [0, -1]]));
        let through = |isometry: Isometry| [0, 1, 2, 3, 4, 5].map(|t| isometry.texture(oriented, t));
        assert_eq!(through(transpose), [0, 1, 4, 3, 2, 5]);
        assert_eq!(through(mirror), [0, 1, 2, 5, 4, 3]);
        assert_eq!(transpose.texture(Textures::FlatTexture, 1), 1);
        for isometry in Isometry::ALL {
            assert_eq!(
                isometry.inverse().taps(5).iter().map(|&t| isometry.taps(5)[t]).collect::<Vec<_>>(),
                (0..25).collect::<Vec<_>>()
            );
        }
    }

    #[test]
    fn large_tiles_are_left_alone_and_done_soon() {
        let mut cells = vec![0; 64 * 64];
        cells[5] = 1;
        let s = Symmetry::of(&axes(64, 64, &cells));
        assert!(s.groups.len() < 64 * 64 / 4);
        let mut cells = vec![0; 256 * 256];
        cells[5] = 1;
        assert_eq!(Symmetry::of(&axes(256, 256, &cells)).groups.len(), 256 * 256);
    }
    /// A tile that is stated as several of its periods has the symmetries of one, and as many more members.
    #[test]
    fn repeating_a_tile_changes_no_symmetry() {
        let tiles: [(usize, usize, &[u8]); 4] = [
            (2, 2, &[0, 1, 1, 2]),
            (1, 3, &[0, 1, 2]),
            (3, 3, &[0, 1, 2, 1, 2, 0, 2, 0, 1]),
            (2, 2, &[0, 1, 2, 3]),
        ];
        for (rows, cols, cells) in tiles {
            let once = Symmetry::of(&axes(rows, cols, cells));
            for (down, across) in [(1, 2), (2, 1), (2, 3)] {
                let wide = across * cols;
                let repeated: Vec<u8> =
                    (0..down * rows * wide).map(|i| cells[i / wide % rows * cols + i % cols]).collect();
                let found = Symmetry::of(&axes(down * rows, wide, &repeated));
                let within = |p: usize| p / wide % rows * cols + p % cols;
                assert_eq!(found.groups.len(), once.groups.len(), "{cells:?}, {down} × {across}");
                for ((stands, members), (alone, few)) in found.groups.iter().zip(&once.groups) {
                    assert_eq!((within(*stands), members.len()), (*alone, down * across * few.len()));
                }
                for (position, member) in found.represented.iter().enumerate() {
                    assert_eq!(within(member.position), once.represented[within(position)].position);
                }
            }
        }
    }
}
