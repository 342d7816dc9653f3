//! The error covariances of sets of filters in one mosaic, eight classes at a time.

use super::color_error::PACKED;
use super::condition::Level;
use super::eye::SampleNoise;
use super::figures::Figures;
use super::lanes::{Augmented, LANES, Lanes, ZERO, plus_scaled};
use super::layout::Layout;
use super::model::Screen;
use super::responses::FilterResponses;
use crate::numeric::simd::{Kernel, dispatch};

/// Filters whose products with a covariance are summed in registers together.
const FILTERS: usize = 4;
/// Sets of filters that share one pass over the covariances, which do not stay in the cache.
pub(super) const SETS: usize = 8;

/// Pairs of pixels i ≤ j of a patch.
pub(super) fn pairs(taps: usize) -> usize {
    taps * (taps + 1) / 2
}

/// The error covariances of one set of filters under one condition, by position and group.
#[derive(Clone)]
pub(super) struct ErrorCovariances {
    /// Of the pixels.
    pub(super) pixels: Vec<[Lanes; 6]>,
    /// What the eye sees of them; empty unless asked for.
    pub(super) seen: Vec<[Lanes; 6]>,
}

impl ErrorCovariances {
    pub(super) fn new(each: usize, figures: Figures) -> Self {
        let seen = if figures == Figures::All { vec![[ZERO; 6]; each] } else { Vec::new() };
        Self { pixels: vec![[ZERO; 6]; each], seen }
    }
}

/// The error covariances of sets of filters: by set and condition.
pub(super) fn errors(
    screen: &Screen,
    layout: &Layout,
    sets: &[FilterResponses],
    figures: Figures,
) -> Vec<Vec<ErrorCovariances>> {
    let mut work = Errors::new(screen, layout, sets, figures);
    dispatch(&mut work);
    work.out
}

/// Responses by component, with filters in groups of [`FILTERS`], padded with zeros.
pub(super) fn padded(responses: &FilterResponses, components: usize) -> Vec<[f64; FILTERS]> {
    let blocks = responses.0.len().div_ceil(FILTERS);
    let mut out = vec![[0.0; FILTERS]; blocks * components];
    for (filter, response) in responses.0.iter().enumerate() {
        for (k, value) in response.iter().enumerate() {
            out[filter / FILTERS * components + k][filter % FILTERS] = *value;
        }
    }
    out
}

struct Errors<'a> {
    screen: &'a Screen,
    layout: &'a Layout,
    sets: &'a [FilterResponses],
    padded: Vec<Vec<[f64; FILTERS]>>,
    /// A C Aᵀ of a group, by set, position and pair of pixels.
    products: Vec<Lanes>,
    /// The best estimates of a position.
    estimates: Vec<[Lanes; 3]>,
    /// By condition; empty unless the eye's error is asked for.
    noise: Vec<SampleNoise>,
    out: Vec<Vec<ErrorCovariances>>,
}

impl<'a> Errors<'a> {
    fn new(screen: &'a Screen, layout: &'a Layout, sets: &'a [FilterResponses], figures: Figures) -> Self {
        let positions = layout.positions();
        let of_level = ErrorCovariances::new(positions * screen.groups, figures);
        let levels = if figures == Figures::All { screen.levels.len() } else { 0 };
        Self {
            screen,
            layout,
            sets,
            padded: sets.iter().map(|s| padded(s, screen.components)).collect(),
            products: vec![ZERO; sets.len() * positions * pairs(screen.light_taps)],
            estimates: vec![[ZERO; 3]; screen.taps],
            noise: (0..levels).map(|_| SampleNoise::new(layout)).collect(),
            out: vec![vec![of_level; screen.levels.len()]; sets.len()],
        }
    }
}

impl Kernel for &mut Errors<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (screen, layout) = (self.screen, self.layout);
        let (positions, count) = (layout.positions(), pairs(screen.light_taps));
        let mut system = System::new(screen);
        for group in 0..screen.groups {
            self.products.fill(ZERO);
            let mut pair = 0;
            for i in 0..screen.light_taps {
                for j in i..screen.light_taps {
                    for (set, padded) in self.padded.iter().enumerate() {
                        let out = &mut self.products[set * positions * count..(set + 1) * positions * count];
                        add_pair(screen, layout, padded, [group, pair, i, j], &mut |p, value| {
                            out[p * count + pair] = value;
                        });
                    }
                    pair += 1;
                }
            }
            for (set, responses) in self.sets.iter().enumerate() {
                for position in 0..positions {
                    let products = &self.products[(set * positions + position) * count..][..count];
                    system.gather(screen, responses, layout.at(position), group, products);
                    for (level, condition) in screen.levels.iter().enumerate() {
                        let time_s = condition.time_s(&screen.white, responses);
                        let scale = condition.scale(time_s);
                        system.factor(&screen.targets[group], condition, scale);
                        let at = position * screen.groups + group;
                        let out = &mut self.out[set][level];
                        out.pixels[at] = system.matrix.complement();
                        if let Some(noise) = self.noise.get_mut(level) {
                            system.matrix.solve(&mut self.estimates);
                            let first = position * screen.taps;
                            for (tap, estimate) in self.estimates.iter().enumerate() {
                                noise.variances[first + tap] = condition.noise(system.means[tap], scale);
                                noise.weights[first + tap] = screen.eye.opponent(estimate);
                            }
                            let variances = &noise.variances[first..first + screen.taps];
                            out.seen[at] = signal_error(&out.pixels[at], &self.estimates, variances);
                        }
                    }
                }
                for (noise, out) in self.noise.iter().zip(&mut self.out[set]) {
                    let noise = screen.eye.noise(layout, noise);
                    for seen in out.seen.iter_mut().skip(group).step_by(screen.groups) {
                        add(seen, &noise);
                    }
                }
            }
        }
    }
}

/// The error covariance without its part from noise, Wᵀ Σ W.
#[inline(always)]
pub(super) fn signal_error(error: &[Lanes; 6], estimates: &[[Lanes; 3]], variances: &[Lanes]) -> [Lanes; 6] {
    let mut out = *error;
    for (w, variance) in estimates.iter().zip(variances) {
        for (out, (c, d)) in out.iter_mut().zip(PACKED) {
            for lane in 0..LANES {
                out[lane] -= w[c][lane] * variance[lane] * w[d][lane];
            }
        }
    }
    out
}

#[inline(always)]
pub(super) fn add(sum: &mut [Lanes; 6], other: &[Lanes; 6]) {
    for (sum, other) in sum.iter_mut().zip(other) {
        for lane in 0..LANES {
            sum[lane] += other[lane];
        }
    }
}

/// The covariance of the signals of a pair of pixels, for each position in the tile.
#[inline(always)]
fn add_pair(
    screen: &Screen,
    layout: &Layout,
    padded: &[[f64; FILTERS]],
    [group, pair, i, j]: [usize; 4],
    set: &mut impl FnMut(usize, Lanes),
) {
    let k = screen.components;
    let covariance = &screen.covariances[(pair * screen.groups + group) * k * k..][..k * k];
    let blocks = layout.filters().div_ceil(FILTERS);
    // The product of the covariance with the filter of j, by component of i.
    let mut right = [[ZERO; FILTERS]; MAX_COMPONENTS];
    for block in 0..blocks {
        let filters = &padded[block * k..(block + 1) * k];
        for (row, right) in covariance.chunks_exact(k).zip(&mut right) {
            // Written out, since compilers turn a loop over the filters into gathers.
            let [mut s0, mut s1, mut s2, mut s3] = [ZERO; FILTERS];
            for (c, f) in row.iter().zip(filters) {
                s0 = plus_scaled(s0, f[0], *c);
                s1 = plus_scaled(s1, f[1], *c);
                s2 = plus_scaled(s2, f[2], *c);
                s3 = plus_scaled(s3, f[3], *c);
            }
            *right = [s0, s1, s2, s3];
        }
        for position in 0..layout.positions() {
            let at = layout.at(position);
            let (a, b) = (usize::from(at[i]), usize::from(at[j]));
            if b / FILTERS != block {
                continue;
            }
            let left = &padded[a / FILTERS * k..][..k];
            let mut sum = ZERO;
            for (right, f) in right.iter().zip(left) {
                sum = plus_scaled(sum, f[a % FILTERS], right[b % FILTERS]);
            }
            set(position, sum);
        }
    }
}

/// The covariance of a pair of pixels times the response of a filter: C f, or Cᵀ f.
#[inline(always)]
pub(super) fn times(
    covariance: &[Lanes],
    response: &[f64],
    transposed: bool,
    out: &mut [Lanes; MAX_COMPONENTS],
) {
    let k = response.len();
    out[..k].fill(ZERO);
    for (a, row) in covariance.chunks_exact(k).enumerate() {
        for (b, c) in row.iter().enumerate() {
            if transposed {
                out[b] = plus_scaled(out[b], response[a], *c);
            } else {
                out[a] = plus_scaled(out[a], response[b], *c);
            }
        }
    }
}

/// Largest number of spectral components.
pub(super) const MAX_COMPONENTS: usize = 12;

/// The system of a position: its signals, their covariances with each other and with the target, and the factored matrix.
pub(super) struct System {
    pub(super) matrix: Augmented,
    /// Covariance of each sample with X, Y, Z of the middle pixel.
    crossed: Vec<[Lanes; 3]>,
    /// Mean electrons per second of each sample, per cd/m², at least 0.
    pub(super) means: Vec<Lanes>,
    /// Covariances of the samples, by pair.
    products: Vec<Lanes>,
    /// Mean of each pixel and its covariance with X, Y, Z, before crosstalk.
    pixels: Vec<[Lanes; 4]>,
    /// The same after crosstalk.
    samples: Vec<[Lanes; 4]>,
}

impl System {
    pub(super) fn new(screen: &Screen) -> Self {
        Self {
            matrix: Augmented::new(screen.taps),
            crossed: vec![[ZERO; 3]; screen.taps],
            means: vec![ZERO; screen.taps],
            products: vec![ZERO; pairs(screen.taps)],
            pixels: vec![[ZERO; 4]; screen.light_taps],
            samples: vec![[ZERO; 4]; screen.taps],
        }
    }

    /// Means and covariances. `filter` are the filters of the pixels, and `products` the covariances of the signals behind them, by pair.
    #[inline(always)]
    pub(super) fn gather(
        &mut self,
        screen: &Screen,
        responses: &FilterResponses,
        filter: &[u8],
        group: usize,
        products: &[Lanes],
    ) {
        let k = screen.components;
        for (i, &filter) in filter.iter().enumerate() {
            let response = &responses.0[usize::from(filter)][..k];
            let first = (i * screen.groups + group) * k;
            let (mut mean, mut crossed) = (ZERO, [ZERO; 3]);
            for (a, &f) in response.iter().enumerate() {
                mean = plus_scaled(mean, f, screen.means[first + a]);
                for c in 0..3 {
                    crossed[c] = plus_scaled(crossed[c], f, screen.crossed[first + a][c]);
                }
            }
            let [x, y, z] = crossed;
            self.pixels[i] = [mean, x, y, z];
        }
        let samples = match &screen.crosstalk {
            Some(crosstalk) => {
                crosstalk.samples(&self.pixels, &mut self.samples);
                crosstalk.sample_pairs(products, &mut self.products);
                &self.samples
            }
            None => {
                self.products.copy_from_slice(products);
                &self.pixels
            }
        };
        for (i, [mean, x, y, z]) in samples.iter().enumerate() {
            self.means[i] = mean.map(|m| if m > 0.0 { m } else { 0.0 });
            self.crossed[i] = [*x, *y, *z];
        }
    }

    /// Factors the matrix of a condition. Signals are in electrons divided by `scale`.
    #[inline(always)]
    pub(super) fn factor(&mut self, targets: &[Lanes; 6], level: &Level, scale: f64) {
        let taps = self.means.len();
        let mut pair = 0;
        for i in 0..taps {
            for j in i..taps {
                let mut value = self.products[pair];
                if i == j {
                    let noise = level.noise(self.means[i], scale);
                    for lane in 0..LANES {
                        value[lane] += noise[lane];
                    }
                }
                self.matrix.set(j, i, value);
                pair += 1;
            }
        }
        for (i, crossed) in self.crossed.iter().enumerate() {
            for (c, value) in crossed.iter().enumerate() {
                self.matrix.set(taps + c, i, *value);
            }
        }
        for ((c, d), value) in PACKED.into_iter().zip(targets) {
            self.matrix.set(taps + c, taps + d, *value);
        }
        self.matrix.factor();
    }
}

#[cfg(test)]
mod tests {
    use super::super::eye::Eye;
    use super::*;
    use crate::numeric::philox::Stream;

    const TAPS: usize = 9;
    const K: usize = 3;

    /// A screen with the given means and covariances with X, Y, Z of groups of classes, by pixel, group and component.
    fn screen(groups: usize, means: Vec<Lanes>, crossed: Vec<[Lanes; 3]>) -> Screen {
        Screen {
            taps: TAPS,
            light_taps: TAPS,
            crosstalk: None,
            components: K,
            side: 3,
            groups,
            covariances: Vec::new(),
            crossed,
            means,
            targets: vec![[ZERO; 6]; groups],
            shares: vec![ZERO; groups],
            detailed: vec![ZERO; groups],
            detailed_share: 0.0,
            per_white_squared: vec![ZERO; groups],
            eye: Eye::new(3, [1.0; 3]).unwrap(),
            colors: Vec::new(),
            levels: Vec::new(),
            electrons: Vec::new(),
            white: Vec::new(),
        }
    }

    /// A group among others has the system that it has alone.
    #[test]
    fn groups_of_classes_are_independent() {
        const GROUPS: usize = 3;
        let mut random = Stream::new(5, 6, 7);
        let mut lanes = || -> Lanes { std::array::from_fn(|_| random.uniform() - 0.2) };
        let means: Vec<Lanes> = (0..TAPS * GROUPS * K).map(|_| lanes()).collect();
        let crossed: Vec<[Lanes; 3]> = (0..TAPS * GROUPS * K).map(|_| [lanes(), lanes(), lanes()]).collect();
        let products: Vec<Lanes> = (0..pairs(TAPS)).map(|_| lanes()).collect();
        let responses = FilterResponses::new(vec![vec![1.0, -0.5, 0.25], vec![0.3, 2.0, -1.5]]);
        let filter: [u8; TAPS] = [0, 1, 0, 1, 1, 0, 0, 0, 1];
        let all = screen(GROUPS, means.clone(), crossed.clone());
        for group in 0..GROUPS {
            let of_group = |at: &usize| at / K % GROUPS == group;
            let places = || (0..TAPS * GROUPS * K).filter(of_group);
            let alone =
                screen(1, places().map(|at| means[at]).collect(), places().map(|at| crossed[at]).collect());
            let (mut found, mut expected) = (System::new(&all), System::new(&alone));
            found.gather(&all, &responses, &filter, group, &products);
            expected.gather(&alone, &responses, &filter, 0, &products);
            assert_eq!((found.means, found.crossed), (expected.means, expected.crossed), "group {group}");
            assert_eq!(found.products, products);
        }
    }
}
