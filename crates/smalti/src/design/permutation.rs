//! A random permutation of a range that is too large to shuffle. Each of its values is computed independently.

use crate::numeric::philox::{Stream, philox4x32};

/// Number of rounds, above the 10 recommended for format-preserving encryption, so that small ranges mix as well. A round
/// takes about ten nanoseconds.
const ROUNDS: usize = 16;

/// A keyed permutation of `0..len`. Its values at 0, 1, 2, … are the range in random order, so that the first k values are
/// a uniform sample without replacement. It needs no memory and gives the same order on every machine.
///
/// A Feistel network with Philox ([salmon2011]) as its round function permutes the pairs of numbers below ⌈√len⌉,
/// and a value outside the range is permuted again until it is inside (cycle walking, [black2002]).
///
/// [salmon2011]: https://doi.org/10.1145/2063384.2063405
/// [black2002]: https://eprint.iacr.org/2001/012
#[derive(Debug, Clone)]
pub struct Permutation {
    len: u128,
    /// The halves are numbers below this; at most 2⁶⁴.
    root: u128,
    keys: [[u32; 2]; ROUNDS],
    /// Whether 0 and 1 are exchanged after the rounds.
    exchange: bool,
}

impl Permutation {
    /// The permutation of `0..len` with the key (seed, purpose, item). `purpose` separates the uses of a seed, and `item`
    /// numbers the permutations of one use.
    #[must_use]
    pub fn new(len: u128, seed: u64, purpose: u32, item: u32) -> Self {
        let floor = len.isqrt();
        let root = if floor.checked_mul(floor) == Some(len) { floor } else { floor + 1 };
        let mut stream = Stream::new(seed, purpose, item);
        let keys = std::array::from_fn(|_| [stream.next_u32(), stream.next_u32()]);
        // An even number of rounds on an odd root yields even permutations only; the exchange yields odd ones too.
        let exchange = stream.next_u32() & 1 == 1;
        Self { len, root: root.max(2), keys, exchange }
    }

    /// The value at place `i`; `None` for `i` of `len` or more.
    #[must_use]
    pub fn at(&self, i: u128) -> Option<u128> {
        if i >= self.len {
            return None;
        }
        // The walk ends, because the cycle of `i` returns to `i`, which is inside the range.
        let mut value = self.mixed(i);
        while value >= self.len {
            value = self.mixed(value);
        }
        Some(value)
    }

    /// The Feistel network on `0..root²`.
    fn mixed(&self, value: u128) -> u128 {
        let (mut left, mut right) = (value / self.root, value % self.root);
        for key in &self.keys {
            let words = philox4x32([right as u32, (right >> 32) as u32, 0, 0], *key);
            let random = words.iter().fold(0, |sum, &w| sum << 32 | u128::from(w));
            // The remainder of 128 bits by less than 64 bits is uniform to 2⁻⁶⁴.
            (left, right) = (right, (left + random % self.root) % self.root);
        }
        let mixed = left * self.root + right;
        if self.exchange && mixed < 2 { 1 - mixed } else { mixed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all(len: u128, seed: u64) -> Vec<u128> {
        let p = Permutation::new(len, seed, 1, 2);
        (0..len).map(|i| p.at(i).unwrap()).collect()
    }

    #[test]
    fn every_value_comes_once() {
        for len in (0..200).chain([1000, 1023, 1024, 1025, 4097]) {
            let mut values = all(len, 5);
            values.sort_unstable();
            assert!(values.into_iter().eq(0..len), "{len}");
            assert_eq!(Permutation::new(len, 5, 1, 2).at(len), None);
        }
    }

    /// Computed by a second implementation, in Python.
    #[test]
    fn the_order_is_the_same_for_ever() {
        assert_eq!(all(10, 1), [5, 7, 4, 1, 6, 8, 0, 2, 9, 3]);
        let large = Permutation::new(u128::MAX, 42, 3, 4);
        let expected = [
            13_696_251_436_619_688_750_707_124_601_981_351_634,
            336_304_102_578_874_130_876_284_187_282_837_608_071,
            228_267_555_870_785_026_295_954_272_430_742_300_520,
        ];
        assert_eq!([0, 1, u128::MAX - 1].map(|i| large.at(i).unwrap()), expected);
    }

    #[test]
    fn seed_purpose_and_item_name_the_order() {
        let order = |seed, purpose, item| {
            let p = Permutation::new(1000, seed, purpose, item);
            (0..20).map(|i| p.at(i)).collect::<Vec<_>>()
        };
        let others = [order(2, 1, 1), order(1, 2, 1), order(1, 1, 2), order(1 << 40 | 1, 1, 1)];
        assert!(others.iter().all(|o| *o != order(1, 1, 1)));
    }

    /// Over many keys each of the 120 orders of five, and each ordered pair of the first two of 30, is equally likely.
    #[test]
    fn orders_are_equally_likely() {
        let trials = 60_000;
        let chi_square = |cells: usize, cell: &dyn Fn(u64) -> usize| {
            let mut counts = vec![0.0; cells];
            (0..trials).for_each(|seed| counts[cell(seed)] += 1.0);
            let expected = trials as f64 / cells as f64;
            counts.iter().map(|c| (c - expected).powi(2) / expected).sum::<f64>()
        };
        let rank = |seed| {
            let order = all(5, seed);
            (0..5).fold(0, |r, i| r * (5 - i) + order[i..].iter().filter(|&&x| x < order[i]).count())
        };
        let pair = |seed| {
            let p = Permutation::new(30, seed, 9, 0);
            let (a, b) = (p.at(0).unwrap() as usize, p.at(1).unwrap() as usize);
            a * 29 + b - usize::from(b > a)
        };
        // Mean and variance of chi-square are the degrees of freedom and twice them; four standard deviations.
        for (cells, got) in [(120, chi_square(120, &rank)), (870, chi_square(870, &pair))] {
            let freedom = (cells - 1) as f64;
            assert!((got - freedom).abs() < 4.0 * (2.0 * freedom).sqrt(), "{cells}: {got}");
        }
    }

    proptest! {
        #[test]
        fn values_of_any_range_are_inside_and_differ(len in 2u128.., seed: u64, i: u128, j: u128) {
            let p = Permutation::new(len, seed, 0, 0);
            let (i, j) = (i % len, j % len);
            let (a, b) = (p.at(i).unwrap(), p.at(j).unwrap());
            prop_assert!(a < len && b < len && (a == b) == (i == j));
        }
    }
}
