//! Philox4x32-10, a counter-based random number generator ([salmon2011]). The same counter and key give the
//! same numbers on any thread and in any order.
//!
//! [salmon2011]: https://doi.org/10.1145/2063384.2063405

const MULTIPLIER: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

/// The key of a seed: its lower word, then its upper one.
#[must_use]
pub fn key(seed: u64) -> [u32; 2] {
    [seed as u32, (seed >> 32) as u32]
}

/// Four random words for a counter value and a key.
#[must_use]
#[inline]
pub fn philox4x32(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let ([mut a, mut b, mut c, mut d], [mut k0, mut k1]) = (counter, key);
    for _ in 0..10 {
        let p0 = u64::from(MULTIPLIER[0]) * u64::from(a);
        let p1 = u64::from(MULTIPLIER[1]) * u64::from(c);
        (a, b, c, d) = ((p1 >> 32) as u32 ^ b ^ k0, p1 as u32, (p0 >> 32) as u32 ^ d ^ k1, p0 as u32);
        k0 = k0.wrapping_add(WEYL[0]);
        k1 = k1.wrapping_add(WEYL[1]);
    }
    [a, b, c, d]
}

/// A sequence of random numbers, identified by (seed, purpose, item): equal identifiers give equal sequences.
#[derive(Debug, Clone)]
pub struct Stream {
    key: [u32; 2],
    name: [u32; 2],
    block: u64,
    words: [u32; 4],
    used: usize,
}

impl Stream {
    /// Starts the sequence. `purpose` separates the uses of one seed; `item` counts within a use.
    #[must_use]
    pub fn new(seed: u64, purpose: u32, item: u32) -> Self {
        Self { key: key(seed), name: [purpose, item], block: 0, words: [0; 4], used: 4 }
    }

    /// The next 32 random bits.
    pub fn next_u32(&mut self) -> u32 {
        if self.used == 4 {
            let counter = [self.block as u32, (self.block >> 32) as u32, self.name[0], self.name[1]];
            self.words = philox4x32(counter, self.key);
            self.block += 1;
            self.used = 0;
        }
        self.used += 1;
        self.words[self.used - 1]
    }

    /// A uniform number in [0, 1) with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        let bits = u64::from(self.next_u32()) << 32 | u64::from(self.next_u32());
        (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// An unbiased uniform integer in `0..n`; 0 when `n` is 0.
    pub fn below(&mut self, n: u32) -> u32 {
        // Lemire (2019): multiply, and reject the few values that would bias the result.
        let threshold = n.wrapping_neg().checked_rem(n).unwrap_or(0);
        loop {
            let product = u64::from(self.next_u32()) * u64::from(n);
            if product as u32 >= threshold {
                return (product >> 32) as u32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known-answer test vectors of Random123 (`kat_vectors`) for philox4x32 with 10 rounds.
    #[test]
    fn known_answers() {
        let kat = [
            ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([u32::MAX; 4], [u32::MAX; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, expected) in kat {
            assert_eq!(philox4x32(counter, key), expected);
        }
    }

    #[test]
    fn names_separate_streams() {
        let first = |seed, purpose, item| Stream::new(seed, purpose, item).next_u32();
        let all = [first(1, 0, 0), first(2, 0, 0), first(1, 1, 0), first(1, 0, 1)];
        assert!((0..4).all(|i| (0..i).all(|j| all[i] != all[j])));
        assert_eq!(first(1, 0, 0), first(1, 0, 0));
    }

    #[test]
    fn below_covers_its_range_evenly() {
        let mut s = Stream::new(7, 0, 0);
        let mut counts = [0u32; 5];
        (0..50_000).for_each(|_| counts[s.below(5) as usize] += 1);
        assert!(counts.iter().all(|&c| (9_500..10_500).contains(&c)), "{counts:?}");
        assert_eq!(s.below(0), 0);
    }
}
