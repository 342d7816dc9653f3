//! Cholesky factorisation of several matrices at a time, one in each lane of a vector.

/// Matrices per vector.
pub(in crate::design) const LANES: usize = 8;
/// A number of each matrix.
pub(in crate::design) type Lanes = [f64; LANES];
/// Rows and columns of a block, whose sums stay in registers.
const BLOCK: usize = 4;
/// Pivots below this share of their diagonal entry count as zero: the sample adds nothing to the earlier ones.
const SINGULAR: f64 = 1e-13;

/// The columns of a block.
type Block = [[Lanes; BLOCK]; BLOCK];

pub(in crate::design) const ZERO: Lanes = [0.0; LANES];

#[inline(always)]
pub(super) fn plus(mut sum: Lanes, a: Lanes, b: Lanes) -> Lanes {
    for i in 0..LANES {
        sum[i] += a[i] * b[i];
    }
    sum
}

#[inline(always)]
pub(in crate::design) fn plus_scaled(mut sum: Lanes, a: f64, b: Lanes) -> Lanes {
    for i in 0..LANES {
        sum[i] += a * b[i];
    }
    sum
}

#[inline(always)]
fn minus(mut sum: Lanes, a: Lanes, b: Lanes) -> Lanes {
    for i in 0..LANES {
        sum[i] -= a[i] * b[i];
    }
    sum
}

#[inline(always)]
fn product(a: Lanes, b: Lanes) -> Lanes {
    let mut out = ZERO;
    for i in 0..LANES {
        out[i] = a[i] * b[i];
    }
    out
}

/// The symmetric matrix [[G, R], [Rᵀ, Y]] with G of `taps` rows, odd and a square, and three right-hand sides, in blocks of 4 × 4. After
/// [`Augmented::factor`], it is the Cholesky factor of G, the solutions L⁻¹ R below it, and the Schur complement Y − Rᵀ G⁻¹ R.
///
/// `taps` is 1 more than a multiple of four, so that the three right-hand sides complete the last block.
#[derive(Clone)]
pub(in crate::design) struct Augmented {
    taps: usize,
    /// Blocks of the lower triangle, row by row; a block holds its columns.
    blocks: Vec<Block>,
    /// Reciprocal of the diagonal of the factor; 0 for a pivot that counts as zero.
    inverse: Vec<Lanes>,
}

impl Augmented {
    /// Zeros.
    pub(in crate::design) fn new(taps: usize) -> Self {
        let side = taps.div_ceil(BLOCK);
        Self {
            taps,
            blocks: vec![[[ZERO; BLOCK]; BLOCK]; side * (side + 1) / 2],
            inverse: vec![ZERO; side * BLOCK],
        }
    }

    #[inline(always)]
    fn at(row: usize, col: usize) -> usize {
        row * (row + 1) / 2 + col
    }

    /// Entry (row, col) with row ≥ col. Rows from `taps` on are the right-hand sides.
    #[inline(always)]
    pub(super) fn get(&self, row: usize, col: usize) -> Lanes {
        self.blocks[Self::at(row / BLOCK, col / BLOCK)][col % BLOCK][row % BLOCK]
    }

    /// Sets entry (row, col) with row ≥ col.
    #[inline(always)]
    pub(in crate::design) fn set(&mut self, row: usize, col: usize, value: Lanes) {
        self.blocks[Self::at(row / BLOCK, col / BLOCK)][col % BLOCK][row % BLOCK] = value;
    }

    /// Factors in place.
    #[inline(always)]
    pub(in crate::design) fn factor(&mut self) {
        let side = self.taps.div_ceil(BLOCK);
        for row in 0..side {
            for col in 0..=row {
                let (done, rest) = self.blocks.split_at_mut(Self::at(row, col));
                let block = &mut rest[0];
                let mut sums = *block;
                for k in 0..col {
                    let left = &done[Self::at(row, k)];
                    let right = if row == col { left } else { &done[Self::at(col, k)] };
                    subtract_products(&mut sums, left, right);
                }
                if row == col {
                    // The last diagonal block holds one column of G and the Schur complement.
                    let pivots = if row + 1 == side { self.taps - row * BLOCK } else { BLOCK };
                    for c in 0..pivots {
                        let inverse = inverse_root(sums[c][c], block[c][c]);
                        self.inverse[row * BLOCK + c] = inverse;
                        for r in c..BLOCK {
                            sums[c][r] = product(sums[c][r], inverse);
                        }
                        for d in c + 1..BLOCK {
                            for r in d..BLOCK {
                                sums[d][r] = minus(sums[d][r], sums[c][r], sums[c][d]);
                            }
                        }
                    }
                } else {
                    let inverse = &self.inverse[col * BLOCK..(col + 1) * BLOCK];
                    substitute(&mut sums, &done[Self::at(col, col)], inverse);
                }
                *block = sums;
            }
        }
    }

    /// The Schur complement after [`Augmented::factor`]: entries (0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2).
    #[inline(always)]
    pub(super) fn complement(&self) -> [Lanes; 6] {
        let n = self.taps;
        [
            self.get(n, n),
            self.get(n + 1, n),
            self.get(n + 1, n + 1),
            self.get(n + 2, n),
            self.get(n + 2, n + 1),
            self.get(n + 2, n + 2),
        ]
    }

    /// G⁻¹ B after [`Augmented::factor`], in place of B: three numbers for each row of G.
    #[inline(always)]
    pub(super) fn solve_for(&self, b: &mut [[Lanes; 3]]) {
        for k in 0..self.taps {
            let mut sums = b[k];
            for (j, known) in b[..k].iter().enumerate() {
                let left = self.get(k, j);
                for c in 0..3 {
                    sums[c] = minus(sums[c], left, known[c]);
                }
            }
            b[k] = sums.map(|s| product(s, self.inverse[k]));
        }
        self.substitute_back(b);
    }

    /// L⁻ᵀ Y in place of Y.
    #[inline(always)]
    fn substitute_back(&self, y: &mut [[Lanes; 3]]) {
        for k in (0..self.taps).rev() {
            let mut sums = y[k];
            for i in k + 1..self.taps {
                let below = self.get(i, k);
                for c in 0..3 {
                    sums[c] = minus(sums[c], below, y[i][c]);
                }
            }
            y[k] = sums.map(|s| product(s, self.inverse[k]));
        }
    }

    /// G⁻¹ R after [`Augmented::factor`]: three numbers for each row of G.
    #[inline(always)]
    pub(in crate::design) fn solve(&self, out: &mut [[Lanes; 3]]) {
        for (k, out) in out.iter_mut().enumerate() {
            *out = [0, 1, 2].map(|c| self.get(self.taps + c, k));
        }
        self.substitute_back(out);
    }
}

/// Subtracts the product of two blocks, left rightᵀ.
///
/// The sixteen sums are written out, since compilers turn loops over them into gathers.
#[inline(always)]
fn subtract_products(sums: &mut Block, left: &Block, right: &Block) {
    let [
        [mut s00, mut s01, mut s02, mut s03],
        [mut s10, mut s11, mut s12, mut s13],
        [mut s20, mut s21, mut s22, mut s23],
        [mut s30, mut s31, mut s32, mut s33],
    ] = *sums;
    for (left, right) in left.iter().zip(right) {
        let [l0, l1, l2, l3] = *left;
        macro_rules! column {
            ($c:literal, $s0:ident, $s1:ident, $s2:ident, $s3:ident) => {
                let r = right[$c];
                $s0 = minus($s0, l0, r);
                $s1 = minus($s1, l1, r);
                $s2 = minus($s2, l2, r);
                $s3 = minus($s3, l3, r);
            };
        }
        column!(0, s00, s01, s02, s03);
        column!(1, s10, s11, s12, s13);
        column!(2, s20, s21, s22, s23);
        column!(3, s30, s31, s32, s33);
    }
    *sums = [[s00, s01, s02, s03], [s10, s11, s12, s13], [s20, s21, s22, s23], [s30, s31, s32, s33]];
}

/// Divides a block by the factor of a diagonal block.
#[inline(always)]
fn substitute(sums: &mut Block, diagonal: &Block, inverse: &[Lanes]) {
    macro_rules! column {
        ($c:literal after $($k:literal)*) => {
            let [s0, s1, s2, s3] = sums[$c];
            $(
                let (d, known) = (diagonal[$k][$c], sums[$k]);
                let (s0, s1) = (minus(s0, known[0], d), minus(s1, known[1], d));
                let (s2, s3) = (minus(s2, known[2], d), minus(s3, known[3], d));
            )*
            let by = inverse[$c];
            sums[$c] = [product(s0, by), product(s1, by), product(s2, by), product(s3, by)];
        };
    }
    column!(0 after);
    column!(1 after 0);
    column!(2 after 0 1);
    column!(3 after 0 1 2);
}

/// 1/√pivot, or 0 for a pivot that is zero beside the diagonal entry that it began as.
#[inline(always)]
fn inverse_root(pivot: Lanes, diagonal: Lanes) -> Lanes {
    let mut out = ZERO;
    for i in 0..LANES {
        let root = 1.0 / pivot[i].sqrt();
        out[i] = if pivot[i] > SINGULAR * diagonal[i] { root } else { 0.0 };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::dense::{cholesky, dot, substitute};
    use crate::numeric::philox::Stream;

    /// A positive semidefinite matrix of a rank.
    fn gram(size: usize, rank: usize, seed: u32) -> Vec<f64> {
        let mut random = Stream::new(u64::from(seed), 6, 7);
        let a: Vec<f64> = (0..size * rank).map(|_| random.uniform() - 0.5).collect();
        let row = |i: usize| &a[i * rank..(i + 1) * rank];
        (0..size * size).map(|at| dot(row(at / size), row(at % size))).collect()
    }

    #[test]
    fn every_lane_is_solved_like_a_matrix_alone() {
        for taps in [9, 25, 49] {
            let n = taps + 3;
            let all: Vec<Vec<f64>> = (0..LANES as u32).map(|seed| gram(n, n + 4, seed)).collect();
            let mut augmented = Augmented::new(taps);
            for row in 0..n {
                for col in 0..=row {
                    augmented.set(row, col, std::array::from_fn(|lane| all[lane][row * n + col]));
                }
            }
            augmented.factor();
            let mut solved = vec![[ZERO; 3]; taps];
            augmented.solve(&mut solved);
            // The same right-hand sides from outside the matrix.
            let mut again: Vec<[Lanes; 3]> = (0..taps)
                .map(|r| [0, 1, 2].map(|c| std::array::from_fn(|lane| all[lane][r * n + taps + c])))
                .collect();
            augmented.solve_for(&mut again);
            for (a, b) in again.as_flattened().as_flattened().iter().zip(solved.as_flattened().as_flattened())
            {
                assert!((a - b).abs() < 1e-9 * b.abs().max(1.0));
            }
            for (lane, a) in all.iter().enumerate() {
                let mut g: Vec<f64> = (0..taps).flat_map(|r| a[r * n..r * n + taps].to_vec()).collect();
                assert!(cholesky(&mut g, taps, 0.0));
                let mut expected = Vec::new();
                for c in 0..3 {
                    let mut x: Vec<f64> = (0..taps).map(|r| a[r * n + taps + c]).collect();
                    substitute(&g, taps, &mut x);
                    for (r, x) in x.iter().enumerate() {
                        assert!((solved[r][c][lane] - x).abs() < 1e-9 * x.abs().max(1.0));
                    }
                    expected.push(x);
                }
                let complement = augmented.complement();
                for (at, (i, j)) in [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)].into_iter().enumerate() {
                    let r: f64 = (0..taps).map(|k| a[k * n + taps + i] * expected[j][k]).sum();
                    let left = a[(taps + i) * n + taps + j] - r;
                    assert!((complement[at][lane] - left).abs() < 1e-10, "{taps}: {i} {j}");
                }
            }
        }
    }

    #[test]
    fn samples_that_repeat_others_add_nothing() {
        let (taps, n) = (9, 12);
        // Of rank 5, so that four samples repeat others, and the targets are sums of samples.
        let a = gram(n, 5, 3);
        let mut augmented = Augmented::new(taps);
        for row in 0..n {
            for col in 0..=row {
                augmented.set(row, col, [a[row * n + col]; LANES]);
            }
        }
        augmented.factor();
        assert!(augmented.complement().iter().flatten().all(|v| v.abs() < 1e-12));
    }
}
