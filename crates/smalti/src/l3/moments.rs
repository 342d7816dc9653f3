//! Moments of patch and target: the sufficient statistics of least squares for a class.

/// The sum of z zᵀ over the patches of a class, with z = (1, patch, target). It contains the count, the
/// means, the Gram matrix and the cross-products. Only the upper triangle is stored, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Moments {
    size: usize,
    sums: Vec<f64>,
}

impl Moments {
    /// Empty moments for `taps` samples and `outputs` targets.
    #[must_use]
    pub fn new(taps: usize, outputs: usize) -> Self {
        let size = 1 + taps + outputs;
        Self { size, sums: vec![0.0; size * (size + 1) / 2] }
    }

    /// From the upper triangle of Σ z zᵀ, row by row. `None` when its length is wrong, a value is not finite,
    /// or the count is not a whole number.
    #[must_use]
    pub fn from_sums(taps: usize, outputs: usize, sums: Vec<f64>) -> Option<Self> {
        let size = 1 + taps + outputs;
        let fits = sums.len() == size * (size + 1) / 2 && sums.iter().all(|s| s.is_finite());
        let counted = sums.first().is_some_and(|n| *n >= 0.0 && n.fract() == 0.0);
        (fits && counted).then_some(Self { size, sums })
    }

    /// The upper triangle of Σ z zᵀ, row by row.
    #[must_use]
    pub fn sums(&self) -> &[f64] {
        &self.sums
    }

    /// Length of z.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// Entry (i, j) of Σ z zᵀ, in either order.
    #[must_use]
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.sums[self.place(i.min(j), i.max(j))]
    }

    /// Index of (i, j), with i ≤ j, in the upper triangle.
    fn place(&self, i: usize, j: usize) -> usize {
        i * self.size - i * (i + 1) / 2 + j
    }

    /// Number of patches.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.sums[0] as u64
    }

    /// Adds other moments of the same size; those of another size are ignored.
    pub fn merge(&mut self, other: &Self) {
        if self.size == other.size {
            self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| *a += b);
        }
    }

    /// Adds moments of the same size whose entry `i` belongs to entry `places[i]` of these.
    pub(crate) fn merge_permuted(&mut self, other: &Self, places: &[usize]) {
        if self.size != other.size || places.len() != self.size {
            return;
        }
        let mut values = other.sums.iter();
        for (i, &row) in places.iter().enumerate() {
            for &col in &places[i..] {
                let place = self.place(row.min(col), row.max(col));
                if let (Some(sum), Some(value)) = (self.sums.get_mut(place), values.next()) {
                    *sum += value;
                }
            }
        }
    }

    /// Adds moments of a shorter z, whose entry `places[i]` stands at entry `i` of the z of these.
    pub(crate) fn merge_repeated(&mut self, shorter: &Self, places: &[usize]) {
        let rows = places.iter().enumerate();
        let pairs = rows.flat_map(|(i, &row)| places[i..].iter().map(move |&col| (row, col)));
        self.sums.iter_mut().zip(pairs).for_each(|(sum, (row, col))| *sum += shorter.get(row, col));
    }

    /// Adds one z `times` times; a z of another length is ignored.
    pub(crate) fn add(&mut self, z: &[f64], times: f64) {
        if z.len() != self.size {
            return;
        }
        let mut at = 0;
        for (i, &left) in z.iter().enumerate() {
            let (left, right) = (left * times, &z[i..]);
            self.sums[at..at + right.len()].iter_mut().zip(right).for_each(|(s, r)| *s += left * r);
            at += right.len();
        }
    }

    /// Divides all entries, including the count.
    pub(crate) fn divide(&mut self, by: f64) {
        self.sums.iter_mut().for_each(|s| *s /= by);
    }

    /// Adds the upper triangle of a square matrix Σ z zᵀ with a row stride of `stride`.
    pub(crate) fn add_square(&mut self, square: &[f64], stride: usize) {
        let mut at = 0;
        for (i, row) in square.chunks_exact(stride).take(self.size).enumerate() {
            let count = self.size - i;
            let (Some(sums), Some(row)) = (self.sums.get_mut(at..at + count), row.get(i..self.size)) else {
                return;
            };
            sums.iter_mut().zip(row).for_each(|(s, v)| *s += v);
            at += count;
        }
    }
}
