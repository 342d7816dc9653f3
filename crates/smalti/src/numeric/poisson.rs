//! Poisson deviates, exact at every mean: inversion below 10, Hörmann's PTRS from 10 on ([hormann1993]).
//!
//! The sampler processes a block of lanes at once. Every lane has its own Philox stream, so a rejection in
//! one lane does not affect another, and the grouping of pixels into blocks does not affect the result.
//! Counts are whole numbers in `f64`, which represents integers exactly up to 2⁵³.
//!
//! [hormann1993]: https://doi.org/10.1016/0167-6687(93)90997-4

// Loops over several arrays become vector code only when they are indexed.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use super::elementary::{exp_f64, ln_f32, ln_f64, whole_part_f32};
use super::philox::philox4x32;

/// Lanes of a block.
pub const LANES: usize = 128;

/// Lanes that skip a method together if none of them needs it.
const GROUP: usize = 16;
/// Inversion applies below this mean; PTRS is defined from 10 on.
const PTRS_FROM: f64 = 10.0;
/// Means are clamped to this value: above it a count is no longer exact in `f64`.
const LARGEST_MEAN: f64 = 1e15;

/// Philox counters of the lanes. Word 0 is `first + lane`, words 1 and 2 are common, and word 3 counts
/// attempts from `attempt`. The caller passes words 0 and 1 of the first attempt, because it uses words 2 and
/// 3 itself.
#[derive(Debug, Clone, Copy)]
pub struct LaneCounter {
    /// Key of the generator.
    pub key: [u32; 2],
    /// Word 0 of lane 0.
    pub first: u32,
    /// Word 1.
    pub row: u32,
    /// Word 2.
    pub purpose: u32,
    /// Word 3 of the first attempt.
    pub attempt: u32,
}

impl LaneCounter {
    /// The random words of attempt `n` of a lane.
    #[inline(always)]
    #[must_use]
    pub fn words(&self, lane: u32, n: u32) -> [u32; 4] {
        let counter = [self.first.wrapping_add(lane), self.row, self.purpose, self.attempt.wrapping_add(n)];
        philox4x32(counter, self.key)
    }

    /// The random words of the first attempt of every lane, one array per word.
    #[inline(always)]
    #[must_use]
    pub fn block(&self) -> [[u32; LANES]; 4] {
        let mut words = [[0; LANES]; 4];
        for i in 0..LANES {
            let w = self.words(i as u32, 0);
            (words[0][i], words[1][i], words[2][i], words[3][i]) = (w[0], w[1], w[2], w[3]);
        }
        words
    }
}

/// Replaces each mean by a Poisson deviate. Means that are not positive give 0. `words` belong to attempt 0.
#[inline(always)]
#[allow(clippy::manual_clamp)] // which would keep NaN
pub fn poisson_lanes(counter: &LaneCounter, words: [&[u32; LANES]; 2], means: &mut [f64; LANES]) {
    let (mut any_small, mut any_large) = (false, false);
    for m in means.iter_mut() {
        *m = m.max(0.0).min(LARGEST_MEAN);
        any_small |= *m < PTRS_FROM;
        any_large |= *m >= PTRS_FROM;
    }
    let mut counts = [0.0; LANES];
    if any_large {
        ptrs_lanes(counter, words, means, &mut counts);
    }
    if any_small {
        inversion_lanes(words, means, &mut counts);
    }
    *means = counts;
}

/// Whether a condition holds for any of the means of some lanes. All are tested, because a loop that stops early is no vector code.
#[inline(always)]
fn any(means: &[f64; LANES], lanes: Range<usize>, condition: impl Fn(f64) -> bool) -> bool {
    means[lanes].iter().fold(0u64, |found, mean| found | u64::from(condition(*mean))) != 0
}

/// Inversion by sequential search, for lanes whose mean is below [`PTRS_FROM`].
#[inline(always)]
fn inversion_lanes(words: [&[u32; LANES]; 2], means: &[f64; LANES], counts: &mut [f64; LANES]) {
    // P(K > 120) for a mean of 10 is 1e-84, far below the 2^-53 of the uniform.
    const LARGEST: u32 = 120;
    for base in (0..LANES).step_by(GROUP) {
        if !any(means, base..base + GROUP, |mean| mean < PTRS_FROM) {
            continue;
        }
        let (mut u, mut term, mut cumulated, mut count) =
            ([0.0; GROUP], [0.0; GROUP], [0.0; GROUP], [0.0f64; GROUP]);
        let mut mean = [0.0f64; GROUP];
        for i in 0..GROUP {
            let bits = u64::from(words[0][base + i]) << 32 | u64::from(words[1][base + i]);
            mean[i] = means[base + i];
            u[i] = (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64);
            // Lanes that PTRS handles stop at once.
            u[i] = if mean[i] < PTRS_FROM { u[i] } else { -1.0 };
            term[i] = exp_f64(-mean[i].min(PTRS_FROM));
            cumulated[i] = term[i];
        }
        for k in 1..=LARGEST {
            let inverse = 1.0 / f64::from(k);
            // An integer, because a sum of floating-point numbers would have an order and make the loop scalar.
            let mut searching = 0;
            for i in 0..GROUP {
                let is_beyond = u[i] >= cumulated[i];
                count[i] += if is_beyond { 1.0 } else { 0.0 };
                searching |= u64::from(is_beyond);
                term[i] *= mean[i] * inverse;
                cumulated[i] += term[i];
            }
            if searching == 0 {
                break;
            }
        }
        for i in 0..GROUP {
            counts[base + i] = if mean[i] < PTRS_FROM { count[i] } else { counts[base + i] };
        }
    }
}

/// ln k! for k below 16.
const LN_FACTORIAL: [f64; 16] = [
    0.0,
    0.0,
    std::f64::consts::LN_2,
    1.791_759_469_228_055,
    3.178_053_830_347_945_8,
    4.787_491_742_782_046,
    6.579_251_212_010_101,
    8.525_161_361_065_415,
    10.604_602_902_745_25,
    12.801_827_480_081_469,
    15.104_412_573_075_516,
    17.502_307_845_873_887,
    19.987_214_495_661_885,
    22.552_163_853_123_425,
    25.191_221_182_738_68,
    27.899_271_383_840_89,
];

/// PTRS for lanes whose mean is at least [`PTRS_FROM`]. All lanes make the quick test; the undecided ones are
/// gathered for the full test, and rejected ones are gathered for the next attempt.
#[inline(always)]
fn ptrs_lanes(
    counter: &LaneCounter,
    words: [&[u32; LANES]; 2],
    means: &[f64; LANES],
    counts: &mut [f64; LANES],
) {
    let mut accepted = [1u8; LANES];
    for base in (0..LANES).step_by(GROUP) {
        if !any(means, base..base + GROUP, |mean| mean >= PTRS_FROM) {
            continue;
        }
        for i in base..base + GROUP {
            let t = Candidate::new(means[i].max(PTRS_FROM), words[0][i], words[1][i]);
            counts[i] = t.k;
            accepted[i] = u8::from(t.quick | (means[i] < PTRS_FROM));
        }
    }
    let mut open = Candidates { lane: [0; LANES], mean: [PTRS_FROM; LANES], u: [0; LANES], v: [0; LANES] };
    let mut n = 0;
    for (eight, accepted) in accepted.as_chunks::<8>().0.iter().enumerate() {
        // The lowest bit of each byte whose lane is undecided.
        let mut undecided = !u64::from_le_bytes(*accepted) & 0x0101_0101_0101_0101;
        while undecided != 0 {
            let i = (8 * eight + undecided.trailing_zeros() as usize / 8) % LANES;
            open.lane[n % LANES] = i as u32;
            undecided &= undecided - 1;
            n += 1;
        }
    }
    for j in 0..n.next_multiple_of(8).min(LANES) {
        let i = open.lane[j] as usize % LANES;
        (open.mean[j], open.u[j], open.v[j]) = (means[i], words[0][i], words[1][i]);
    }
    let mut attempt = 0;
    loop {
        // Undecided trials take the full test; rejected ones are packed to the front.
        let failed = open.full_test(n, counts);
        if failed == 0 {
            return;
        }
        n = failed;
        attempt += 1;
        for j in 0..LANES.min(n.next_multiple_of(8)) {
            let w = counter.words(open.lane[j], attempt);
            (open.u[j], open.v[j]) = (w[0], w[1]);
        }
    }
}

/// One trial of PTRS.
struct Candidate {
    /// The proposed count.
    k: f64,
    /// Whether the squeeze (quick test) accepts it.
    quick: bool,
    /// Inputs of the full test.
    us: f64,
    v: f64,
    a: f64,
    b: f64,
    inverse_alpha: f64,
}

impl Candidate {
    /// Hörmann 1993, algorithm PTRS, steps 0 and 1. `mean` is at least 10.
    #[inline(always)]
    fn new(mean: f64, word_u: u32, word_v: u32) -> Self {
        const UNIT: f64 = 1.0 / 4_294_967_296.0;
        // The end points are excluded: u in (−½, ½), v in (0, 1).
        let u = (f64::from(word_u) + 0.5) * UNIT - 0.5;
        let v = (f64::from(word_v) + 0.5) * UNIT;
        let b = 0.931 + 2.53 * mean.sqrt();
        let a = -0.059 + 0.02483 * b;
        let us = 0.5 - u.abs();
        let k = ((2.0 * a / us + b) * u + mean + 0.43).floor();
        let quick = (us >= 0.07) & (v <= 0.9277 - 3.6224 / (b - 2.0));
        Self { k, quick, us, v, a, b, inverse_alpha: 1.1239 + 1.1328 / (b - 3.4) }
    }
}

/// Candidates of the lanes that the quick test left undecided.
struct Candidates {
    lane: [u32; LANES],
    mean: [f64; LANES],
    u: [u32; LANES],
    v: [u32; LANES],
}

impl Candidates {
    /// Tests the first `n` trials, writes their counts, packs the rejected ones to the front and returns their number.
    #[inline(always)]
    fn full_test(&mut self, n: usize, counts: &mut [f64; LANES]) -> usize {
        let (mut k, mut hat, mut ln_factorial) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut place = [0u32; LANES];
        let (mut possible, mut accepted) = ([0u8; LANES], [0u8; LANES]);
        let padded = n.next_multiple_of(8).min(LANES);
        for j in 0..padded {
            let t = Candidate::new(self.mean[j].max(PTRS_FROM), self.u[j], self.v[j]);
            k[j] = t.k;
            #[allow(clippy::manual_clamp)] // which would keep NaN
            let table = t.k.max(0.0).min(15.0);
            place[j] = whole_part_f32(table as f32);
            hat[j] = t.v * t.inverse_alpha / (t.a / (t.us * t.us) + t.b);
            possible[j] = u8::from((t.k >= 0.0) & !((t.us < 0.013) & (t.v > t.us)));
            accepted[j] = u8::from(t.quick);
        }
        for j in 0..padded {
            ln_factorial[j] = LN_FACTORIAL[place[j] as usize % LN_FACTORIAL.len()];
        }
        // Single precision decides all but close cases.
        let mut close = [0u8; LANES];
        for j in 0..padded {
            let mean = self.mean[j].max(PTRS_FROM);
            let (single, kk) = (k[j] as f32, k[j].max(1.0) as f32);
            let small = k[j] < 16.0;
            let inv = 1.0 / kk;
            let series = inv * (1.0 / 12.0 - inv * inv * (1.0 / 360.0));
            let ratio = if small { mean as f32 } else { mean as f32 * inv };
            let rest = if small { -(ln_factorial[j] + mean) as f32 } else { (k[j] - mean) as f32 - series };
            let root = if small { 1.0 } else { (std::f32::consts::TAU * kk).sqrt() };
            let excess = single * ln_f32(ratio) + rest - ln_f32(hat[j] as f32 * root);
            // At least twice the rounding errors of the excess while the count is below ten times the mean. Beyond that the excess is far below
            // 0, and its sign is certain.
            let doubt = 1e-3 + 1e-6 * (single + mean as f32);
            accepted[j] |= possible[j] & u8::from(excess > doubt);
            close[j] = possible[j] & (1 - u8::from(excess.abs() > doubt));
        }
        for base in (0..padded).step_by(8) {
            let lanes = base..base + 8;
            if close[lanes.clone()].iter().fold(0, |any, is_close| any | is_close) == 0 {
                continue;
            }
            for j in lanes {
                let mean = self.mean[j].max(PTRS_FROM);
                // Log-probability of k: k ln(λ/k) + k − λ − Stirling's series, which avoids the cancellation of
                // large terms. The series is inexact below 16, where a table of factorials replaces it.
                let small = k[j] < 16.0;
                let kk = k[j].max(1.0);
                let inv = 1.0 / kk;
                let inv2 = inv * inv;
                let series =
                    inv * (1.0 / 12.0 - inv2 * (1.0 / 360.0 - inv2 * (1.0 / 1260.0 - inv2 * (1.0 / 1680.0))));
                let ratio = if small { mean } else { mean * inv };
                let rest = if small { -ln_factorial[j] } else { kk - series };
                let root = if small { 1.0 } else { (std::f64::consts::TAU * kk).sqrt() };
                let ln_probability = k[j] * ln_f64(ratio) + (rest - mean);
                accepted[j] |= close[j] & u8::from(ln_f64(hat[j] * root) <= ln_probability);
            }
        }
        let mut failed = 0;
        for j in 0..n {
            // A count that is rejected is replaced in a later attempt.
            let lane = self.lane[j];
            counts[lane as usize % LANES] = k[j];
            self.lane[failed] = lane;
            self.mean[failed] = self.mean[j];
            failed += usize::from(accepted[j] == 0);
        }
        failed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    fn draws(mean: f64, blocks: u32) -> Vec<f64> {
        let mut out = Vec::new();
        for row in 0..blocks {
            let counter = LaneCounter { key: [7, 9], first: 0, row, purpose: 3, attempt: 0 };
            let mut means = [mean; LANES];
            let words = counter.block();
            poisson_lanes(&counter, [&words[0], &words[1]], &mut means);
            out.extend(means);
        }
        out
    }

    fn ln_pmf(mean: f64, k: f64) -> f64 {
        k * mean.ln() - mean - libm::lgamma(k + 1.0)
    }

    /// The mean, the variance and the chi-square of the histogram lie within four standard errors of the
    /// exact law.
    #[test]
    fn draws_follow_the_exact_law() {
        const BLOCKS: u32 = 1500;
        let n = f64::from(BLOCKS) * LANES as f64;
        for mean in [1e-3, 0.1, 1.0, 5.0, 9.99, 10.0, 10.5, 15.0, 30.0, 100.0, 1e3, 1e4, 1e6] {
            let mut all = draws(mean, BLOCKS);
            assert!(all.iter().all(|k| k.fract() == 0.0 && *k >= 0.0));
            let m = all.iter().sum::<f64>() / n;
            let v = all.iter().map(|k| (k - m) * (k - m)).sum::<f64>() / (n - 1.0);
            assert!((m - mean).abs() < 4.0 * (mean / n).sqrt(), "mean {m} for {mean}");
            // Var(s²) ≈ (μ4 − σ⁴)/n with μ4 = λ + 3λ².
            let se = ((mean + 2.0 * mean * mean) / n).sqrt();
            assert!((v - mean).abs() < 4.0 * se, "variance {v} for {mean}");

            // Cells of at least 20 expected counts and at most 60 cells.
            all.sort_by(f64::total_cmp);
            let least = 20.0f64.max(n / 60.0);
            let first = (mean - 8.0 * mean.sqrt()).floor().max(0.0);
            let last = (mean + 8.0 * mean.sqrt() + 12.0).ceil();
            let (mut expected, mut chi2, mut cells, mut seen, mut rest) = (0.0, 0.0, 0, 0usize, n);
            let mut k = first;
            while k <= last {
                expected += n * ln_pmf(mean, k).exp();
                if expected >= least && rest - expected >= least {
                    let upto = all.partition_point(|x| *x <= k);
                    let got = (upto - seen) as f64;
                    chi2 += (got - expected) * (got - expected) / expected;
                    (seen, rest, expected, cells) = (upto, rest - expected, 0.0, cells + 1);
                }
                k += 1.0;
            }
            let got = (all.len() - seen) as f64;
            if cells > 0 {
                chi2 += (got - rest) * (got - rest) / rest;
            }
            let freedom = f64::from(cells);
            assert!(
                chi2 < freedom + 4.0 * (2.0 * freedom).sqrt() + 6.0,
                "chi² {chi2} of {freedom} for {mean}"
            );
        }
    }

    #[test]
    fn a_lane_does_not_depend_on_its_block() {
        let block = |first: u32, mean: f64| {
            let counter = LaneCounter { key: [1, 2], first, row: 5, purpose: 3, attempt: 0 };
            // The neighbours have means of all sizes; the lane under test has `mean`.
            let mut means: [f64; LANES] =
                std::array::from_fn(|i| if (i as u32 + first).is_multiple_of(3) { mean } else { i as f64 });
            let words = counter.block();
            poisson_lanes(&counter, [&words[0], &words[1]], &mut means);
            means
        };
        for mean in [0.5, 9.9, 12.0, 250.0, 1e5] {
            let (a, b) = (block(0, mean), block(30, mean));
            assert!((30..LANES).filter(|i| i % 3 == 0).all(|i| a[i] == b[i - 30]));
        }
    }

    #[test]
    fn impossible_means_give_nothing_and_vast_ones_a_number() {
        for (mean, low, high) in
            [(0.0, 0.0, 0.0), (-5.0, 0.0, 0.0), (f64::NAN, 0.0, 0.0), (f64::INFINITY, 0.99e15, 1.01e15)]
        {
            assert!(draws(mean, 1).iter().all(|k| (low..=high).contains(k)), "{mean}");
        }
    }

    /// Every trial is decided as by the exact law, though most are in single precision.
    #[test]
    fn trials_are_decided_exactly() {
        let mut random = Stream::new(5, 6, 7);
        let (mut accepted, mut rejected) = (0, 0);
        for i in 0..100_000 {
            let mean = 10.0 * 1.000_3f64.powi(i);
            // Every eighth trial is one of the tails.
            let u = if i % 8 == 0 { random.next_u32() >> (8 + i / 8 % 24) } else { random.next_u32() };
            let v = if i % 16 == 0 { random.next_u32() >> (i / 16 % 32) } else { random.next_u32() };
            let one = Candidate::new(mean, u, v);
            let hat = one.v * one.inverse_alpha / (one.a / (one.us * one.us) + one.b);
            let excess = ln_pmf(mean, one.k) - hat.ln();
            // Nearer than the rounding errors of the logarithm of the law.
            if one.k < 0.0 || excess.abs() < 1e-13 * mean {
                continue;
            }
            let is_possible = !(one.us < 0.013 && one.v > one.us);
            let expected = one.quick || is_possible && excess > 0.0;
            let mut trial =
                Candidates { lane: [0; LANES], mean: [mean; LANES], u: [u; LANES], v: [v; LANES] };
            assert_eq!(trial.full_test(1, &mut [0.0; LANES]) == 0, expected, "{mean} {u} {v}: {excess}");
            *(if expected { &mut accepted } else { &mut rejected }) += 1;
        }
        assert!(accepted > 50_000 && rejected > 5000, "{accepted} {rejected}");
    }

    /// Where the full test begins to reject, the hat times v is the exact probability of the count.
    #[test]
    fn the_full_test_rejects_from_the_exact_bound_on() {
        let accepts = |mean: f64, u: u32, v: u32| {
            let mut trial =
                Candidates { lane: [0; LANES], mean: [mean; LANES], u: [u; LANES], v: [v; LANES] };
            trial.full_test(1, &mut [0.0; LANES]) == 0
        };
        let (mut small, mut large) = (0, 0);
        for mean in [10.0, 14.0, 16.5, 20.0, 300.0] {
            for u in (1..64).map(|i| i << 26) {
                let one = Candidate::new(mean, u, 0);
                // The hat reaches below 0, where there are no counts.
                if one.k < 0.0 {
                    assert!(!accepts(mean, u, 0), "{mean} {u}");
                    continue;
                }
                let hat = one.inverse_alpha / (one.a / (one.us * one.us) + one.b);
                let exact = ln_pmf(mean, one.k).exp() / hat;
                let (mut accepted, mut rejected) = (0u32, u32::MAX);
                assert!(accepts(mean, u, accepted) && !accepts(mean, u, rejected), "{mean} {u}");
                while rejected - accepted > 1 {
                    let middle = accepted + (rejected - accepted) / 2;
                    *(if accepts(mean, u, middle) { &mut accepted } else { &mut rejected }) = middle;
                }
                // v is that of a half more than the word.
                let found = (f64::from(accepted) + 1.0) / 4_294_967_296.0;
                assert!((found - exact).abs() < 0.6 / 4_294_967_296.0, "{mean} {u}: {found} for {exact}");
                *(if one.k < 16.0 { &mut small } else { &mut large }) += 1;
            }
        }
        assert!(small > 0 && large > 0, "{small} {large}");
    }
}
