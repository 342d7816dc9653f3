//! The error covariances of sets of filters in one mosaic, eight classes at a time.

use super::condition::Level;
use super::lanes::{Augmented, LANES, Lanes, ZERO, plus_scaled};
use super::model::Screen;
use super::responses::FilterResponses;
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::Mosaic;

/// Filters whose products with a covariance are summed in registers together.
const FILTERS: usize = 4;
/// Sets of filters that share one pass over the covariances, which do not stay in the cache.
pub(super) const SETS: usize = 8;

/// The filter of every pixel of a patch, for each position of its middle pixel in the tile.
pub(super) struct Layout {
    taps: usize,
    filters: usize,
    /// By position and pixel.
    filter: Vec<u8>,
}

impl Layout {
    pub(super) fn new(screen: &Screen, mosaic: &Mosaic) -> Self {
        let (side, half) = (screen.side, screen.side / 2);
        let mut filter = Vec::new();
        for row in 0..mosaic.rows() {
            for col in 0..mosaic.cols() {
                for r in 0..side {
                    for c in 0..side {
                        let down = (row + r + half * (mosaic.rows() - 1)) % mosaic.rows();
                        let right = (col + c + half * (mosaic.cols() - 1)) % mosaic.cols();
                        filter.push(mosaic.channel_at(down, right) as u8);
                    }
                }
            }
        }
        Self { taps: side * side, filters: mosaic.channels(), filter }
    }

    /// Number of positions in the tile.
    pub(super) fn positions(&self) -> usize {
        self.filter.len() / self.taps
    }

    pub(super) fn filters(&self) -> usize {
        self.filters
    }

    /// The filter of each pixel of a patch.
    #[inline(always)]
    pub(super) fn at(&self, position: usize) -> &[u8] {
        &self.filter[position * self.taps..(position + 1) * self.taps]
    }
}

/// Pairs of pixels i ≤ j of a patch.
pub(super) fn pairs(taps: usize) -> usize {
    taps * (taps + 1) / 2
}

/// The error covariances of sets of filters: by set, condition, position and group.
pub(super) fn errors(
    screen: &Screen,
    layout: &Layout,
    sets: &[FilterResponses],
) -> Vec<Vec<Vec<[Lanes; 6]>>> {
    let mut work = Errors::new(screen, layout, sets);
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
    /// A C Aᵀ of a group, by set, position and pair.
    products: Vec<Lanes>,
    out: Vec<Vec<Vec<[Lanes; 6]>>>,
}

impl<'a> Errors<'a> {
    fn new(screen: &'a Screen, layout: &'a Layout, sets: &'a [FilterResponses]) -> Self {
        let positions = layout.positions();
        let of_level = vec![[ZERO; 6]; positions * screen.groups];
        Self {
            screen,
            layout,
            sets,
            padded: sets.iter().map(|s| padded(s, screen.components)).collect(),
            products: vec![ZERO; sets.len() * positions * pairs(screen.taps)],
            out: vec![vec![of_level; screen.levels.len()]; sets.len()],
        }
    }
}

impl Kernel for &mut Errors<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (screen, layout) = (self.screen, self.layout);
        let (positions, count) = (layout.positions(), pairs(screen.taps));
        let mut system = System::new(screen);
        for group in 0..screen.groups {
            self.products.fill(ZERO);
            let mut pair = 0;
            for i in 0..screen.taps {
                for j in i..screen.taps {
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
                    system.gather(screen, responses, layout.at(position), group);
                    let products = &self.products[(set * positions + position) * count..][..count];
                    for (level, condition) in screen.levels.iter().enumerate() {
                        let time_s = condition.time_s(&screen.white, responses);
                        system.factor(products, &screen.targets[group], condition, condition.scale(time_s));
                        self.out[set][level][position * screen.groups + group] = system.matrix.complement();
                    }
                }
            }
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
    let blocks = layout.filters.div_ceil(FILTERS);
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

/// Largest number of spectral components.
pub(super) const MAX_COMPONENTS: usize = 12;

/// The system of a position: its signals, their covariances with the target, and the factored matrix.
pub(super) struct System {
    pub(super) matrix: Augmented,
    /// Covariance of each sample with X, Y, Z of the middle pixel.
    crossed: Vec<[Lanes; 3]>,
    /// Mean electrons per second of each sample, per cd/m², at least 0.
    pub(super) means: Vec<Lanes>,
}

impl System {
    pub(super) fn new(screen: &Screen) -> Self {
        Self {
            matrix: Augmented::new(screen.taps),
            crossed: vec![[ZERO; 3]; screen.taps],
            means: vec![ZERO; screen.taps],
        }
    }

    /// Means and covariances with the target.
    #[inline(always)]
    pub(super) fn gather(
        &mut self,
        screen: &Screen,
        responses: &FilterResponses,
        filter: &[u8],
        group: usize,
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
            self.means[i] = mean.map(|m| if m > 0.0 { m } else { 0.0 });
            self.crossed[i] = crossed;
        }
    }

    /// Factors the matrix of a condition. Signals are in electrons divided by `scale`.
    #[inline(always)]
    pub(super) fn factor(&mut self, products: &[Lanes], targets: &[Lanes; 6], level: &Level, scale: f64) {
        let taps = self.means.len();
        let (dark, per_e) = (level.dark_e2 / (scale * scale), level.per_e / scale);
        let mut pair = 0;
        for i in 0..taps {
            for j in i..taps {
                let mut value = products[pair];
                if i == j {
                    let mean = self.means[i];
                    for lane in 0..LANES {
                        value[lane] += dark + mean[lane] * (per_e + level.per_e2 * mean[lane]);
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
        for ((c, d), value) in super::color_error::PACKED.into_iter().zip(targets) {
            self.matrix.set(taps + c, taps + d, *value);
        }
        self.matrix.factor();
    }
}
