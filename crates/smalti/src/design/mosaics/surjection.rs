//! Colourings of places in which every colour appears (surjections).

use crate::numeric::philox::Stream;

/// The number of ways to colour `places` places so that each of `colors` colours appears; `None` when it is above
/// 2¹²⁸ − 1.
pub(super) fn count(places: usize, colors: usize) -> Option<u128> {
    // ways[j]: colourings of the places so far in which j given colours all appear.
    let mut ways: Vec<Option<u128>> = (0..=colors).map(|j| Some(u128::from(j == 0))).collect();
    for _ in 0..places {
        for j in (0..=colors).rev() {
            let times =
                |n: usize, ways: Option<u128>| if n == 0 { Some(0) } else { ways?.checked_mul(n as u128) };
            let missing = if j == 0 { Some(0) } else { times(j, ways[j - 1]) };
            ways[j] = times(colors - j, ways[j]).zip(missing).and_then(|(a, b)| a.checked_add(b));
        }
    }
    ways[colors]
}

/// Draws such colourings, all equally likely to the precision of an `f64`.
pub(super) struct Sampler {
    colors: usize,
    /// Row m: for each j, the probability that j given colours all appear on m randomly coloured places.
    covered: Vec<Vec<f64>>,
}

impl Sampler {
    /// A sampler for up to `places` places.
    pub(super) fn new(places: usize, colors: usize) -> Self {
        let mut covered = vec![(0..=colors).map(|j| f64::from(u8::from(j == 0))).collect::<Vec<f64>>()];
        for m in 0..places {
            let next = (0..=colors).map(|j| {
                let [new, old] = Self::next(&covered[m], colors, j);
                new + old
            });
            let next = next.collect();
            covered.push(next);
        }
        Self { colors, covered }
    }

    /// The probability that the next place takes one of the `j` missing colours and the later places the rest, and the
    /// probability that it takes another colour and the later places all `j`. `after` is the row of the later places.
    fn next(after: &[f64], colors: usize, j: usize) -> [f64; 2] {
        let share = j as f64 / colors as f64;
        [if j == 0 { 0.0 } else { share * after[j - 1] }, (1.0 - share) * after[j]]
    }

    /// The fraction of all colourings of `places` places in which every colour appears.
    pub(super) fn probability(&self, places: usize) -> f64 {
        self.covered[places][self.colors]
    }

    /// Writes a colouring to `out`, which has at least as many places as there are colours.
    pub(super) fn draw(&self, stream: &mut Stream, out: &mut [u8]) {
        // The missing colours, then the others.
        let mut palette: [u8; 256] = std::array::from_fn(|i| i as u8);
        let mut missing = self.colors;
        let places = out.len();
        for (i, place) in out.iter_mut().enumerate() {
            let [new, old] = Self::next(&self.covered[places - 1 - i], self.colors, missing);
            if missing > 0 && stream.uniform() * (new + old) < new {
                let at = stream.below(missing as u32) as usize;
                missing -= 1;
                *place = palette[at];
                palette.swap(at, missing);
            } else {
                let others = (self.colors - missing) as u32;
                *place = palette[missing + stream.below(others) as usize];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_stirling_numbers_times_factorials() {
        // k! S(n, k) from the table of Stirling numbers.
        for (n, k, expected) in
            [(3, 2, 6), (4, 4, 24), (9, 5, 120 * 6951), (16, 4, 24 * 171_798_901), (2, 3, 0)]
        {
            assert_eq!(count(n, k), Some(expected), "{n} {k}");
        }
        // S(27, 26) = C(27, 2).
        assert_eq!(count(27, 26), Some(141_555_302_855_438_578_089_984_000_000));
        // 4⁶⁴ = 2¹²⁸ colourings, of which 4 · 3⁶⁴ and a few lack a colour.
        let lacking = 4 * 3u128.pow(64) - 6 * (1 << 64) + 4;
        assert_eq!(count(64, 4), Some(u128::MAX - lacking + 1));
        assert_eq!(count(65, 4), None);
    }

    #[test]
    fn draws_are_uniform() {
        // 36 ways to colour four places with three colours.
        let sampler = Sampler::new(4, 3);
        let mut stream = Stream::new(1, 2, 3);
        let (mut counts, mut out) = (std::collections::BTreeMap::new(), [0; 4]);
        for _ in 0..36_000 {
            sampler.draw(&mut stream, &mut out);
            *counts.entry(out).or_insert(0) += 1;
        }
        assert_eq!(counts.len(), 36);
        let chi: f64 = counts.values().map(|&c: &i32| f64::from(c - 1000).powi(2) / 1000.0).sum();
        // 35 degrees of freedom, standard deviation 8.4.
        assert!((chi - 35.0).abs() < 4.0 * 8.4, "{chi}");
        assert!((sampler.probability(4) - 36.0 / 81.0).abs() < 1e-15);
        // As many places as colours: a random order of the colours.
        let mut all = [0; 26];
        Sampler::new(26, 26).draw(&mut stream, &mut all);
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..26));
    }
}
