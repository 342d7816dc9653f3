//! The kernels of a design from the statistics of the light, for all pools and positions.

use super::saturated_moments::Saturated;
use super::statistics::{ClassLight, WIDE, Wide};
use crate::design::screen::lanes::{Augmented, LANES, Lanes, ZERO, plus_scaled};
use crate::l3::{ClassPool, Moments, PatchCounts, PoolKernels, PoolSource};
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::SignalNoise;

/// Filters whose products with a covariance are summed in registers together.
const FILTERS: usize = 4;
/// Largest number of spectral components.
pub(in crate::design) const MAX_COMPONENTS: usize = 12;
/// Relative variance of a signal that is not known, because the statistics are in single precision.
const UNKNOWN: f64 = 1e-7;

/// Uniform patches of one position and a pool: surfaces without texture.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::design) struct EvenPatches {
    /// Number of patches.
    pub(in crate::design) count: f64,
    /// Mean sample of each channel.
    pub(in crate::design) mean: Vec<f64>,
    /// Covariance of the channels, row by row.
    pub(in crate::design) covariance: Vec<f64>,
    /// Mean target.
    pub(in crate::design) target: [f64; 3],
    /// Covariance of each channel with the target.
    pub(in crate::design) crossed: Vec<[f64; 3]>,
}

/// A design: everything that its kernels follow from, beside the light.
pub(in crate::design) struct LightSystem<'a> {
    /// Normalised samples per unit of each component, for each channel.
    pub(in crate::design) responses: Vec<Vec<f64>>,
    /// The factor of X, Y, Z.
    pub(in crate::design) scale: f64,
    /// The positions whose kernels are needed.
    pub(in crate::design) positions: Vec<usize>,
    /// The channel of every pixel of a patch, for each of these positions.
    pub(in crate::design) channels: Vec<Vec<usize>>,
    /// The patches of the light count by this factor: each position of a capture has its share of them.
    pub(in crate::design) share: f64,
    pub(in crate::design) noise: SignalNoise,
    /// The uniform patches at one of these positions (by index) and in a pool.
    pub(in crate::design) even: &'a (dyn Fn(usize, ClassPool) -> Option<EvenPatches> + Sync),
    /// The patches that the design saturates.
    pub(in crate::design) saturated: Saturated,
    /// The numbers of patches of a capture.
    pub(in crate::design) counts: PatchCounts,
}

/// The kernels of a design for all pools and positions.
pub(in crate::design) struct DesignKernels<'a> {
    light: &'a ClassLight,
    system: &'a LightSystem<'a>,
    /// By position and lane.
    kernels: Vec<Option<PoolKernels>>,
}

impl ClassLight {
    /// The kernels of a design.
    pub(in crate::design) fn kernels<'a>(&'a self, system: &'a LightSystem<'a>) -> DesignKernels<'a> {
        let mut work = Solve {
            light: self,
            system,
            filters: padded(&system.responses, self.components),
            products: vec![[0.0; WIDE]; system.positions.len() * self.taps * (self.taps + 1) / 2],
            kernels: vec![None; system.positions.len() * self.pools.len()],
        };
        dispatch(&mut work);
        DesignKernels { light: self, system, kernels: work.kernels }
    }
}

impl PoolSource for DesignKernels<'_> {
    fn count(&self, position: usize, pool: ClassPool) -> u64 {
        let Ok(at) = self.system.positions.binary_search(&position) else { return 0 };
        let further = |level, texture| {
            let class = ClassPool { level: Some(level), texture: Some(texture) };
            let even = (self.system.even)(at, class).map_or(0.0, |even| even.count);
            even - self.system.saturated.count(at, level, texture) * self.system.share
        };
        self.system.counts.count(position, pool, &further)
    }

    fn kernels(&self, position: usize, pool: ClassPool) -> Option<PoolKernels> {
        let at = self.system.positions.binary_search(&position).ok()?;
        let lane = self.light.pools.iter().position(|p| p.pool == pool)?;
        self.kernels.get(at * self.light.pools.len() + lane)?.clone()
    }
}

/// Responses by component, with filters in groups of [`FILTERS`], padded with zeros.
fn padded(responses: &[Vec<f64>], components: usize) -> Vec<[f32; FILTERS]> {
    let mut out = vec![[0.0; FILTERS]; responses.len().div_ceil(FILTERS) * components];
    for (filter, response) in responses.iter().enumerate() {
        for (k, value) in response.iter().enumerate() {
            out[filter / FILTERS * components + k][filter % FILTERS] = *value as f32;
        }
    }
    out
}

struct Solve<'a> {
    light: &'a ClassLight,
    system: &'a LightSystem<'a>,
    filters: Vec<[f32; FILTERS]>,
    /// A C Aᵀ of a group, by position and pair.
    products: Vec<Wide>,
    kernels: Vec<Option<PoolKernels>>,
}

/// The signals of eight pools at a position.
struct Signals {
    /// Numbers of patches, over all pixels.
    count: Lanes,
    /// Mean of each sample.
    mean: Vec<Lanes>,
    /// Mean target.
    target: [Lanes; 3],
    /// Covariance of each sample with the target.
    crossed: Vec<[Lanes; 3]>,
}

impl Signals {
    /// Those of all patches of the pools from `first` on. Lanes beyond the last pool repeat the first one.
    #[inline(always)]
    fn new(light: &ClassLight, system: &LightSystem<'_>, channels: &[usize], first: usize) -> Self {
        let (taps, k) = (light.taps, light.components);
        let mut this =
            Self { count: ZERO, mean: vec![ZERO; taps], target: [ZERO; 3], crossed: vec![[ZERO; 3]; taps] };
        for lane in 0..LANES {
            let pooled = &light.pools[if first + lane < light.pools.len() { first + lane } else { first }];
            this.count[lane] = pooled.count;
            for o in 0..3 {
                this.target[o][lane] = pooled.target[o] * system.scale;
            }
        }
        for (i, &channel) in channels.iter().enumerate() {
            for (a, &f) in system.responses[channel].iter().enumerate() {
                let place = (first / LANES * taps + i) * k + a;
                this.mean[i] = plus_scaled(this.mean[i], f, light.means[place]);
                for o in 0..3 {
                    let by = f * system.scale;
                    this.crossed[i][o] = plus_scaled(this.crossed[i][o], by, light.crossed[place][o]);
                }
            }
        }
        this
    }

    /// Leaves patches out of the pool in a lane, and out of the covariances of its samples in lane `wide` of `products`. Moments of all patches less those of a part are those of the rest.
    fn leave_out(&mut self, part: &Moments, lane: usize, wide: usize, products: &mut [Wide]) {
        let (taps, all, n) = (self.mean.len(), self.count[lane], part.get(0, 0));
        // Too few patches are left for kernels.
        if all - n < 1.0 {
            return;
        }
        // The factors of the moments of all and of the part, about their means, and of the product of the difference between these.
        let (kept, lost) = (all / (all - n), n / (all - n));
        let between = kept * lost;
        let mean = |i: usize| part.get(0, 1 + i) / n;
        let means: Vec<f64> = (0..taps + 3).map(mean).collect();
        let apart: Vec<f64> = (0..taps).map(|i| self.mean[i][lane] - means[i]).collect();
        let mut pair = 0;
        for i in 0..taps {
            for j in i..taps {
                let of_part = part.get(1 + i, 1 + j) / n - means[i] * means[j];
                let value = kept * f64::from(products[pair][wide]) - lost * of_part;
                products[pair][wide] = (value - between * apart[i] * apart[j]) as f32;
                pair += 1;
            }
            for o in 0..3 {
                let of_part = part.get(1 + i, 1 + taps + o) / n - means[i] * means[taps + o];
                let shift = self.target[o][lane] - means[taps + o];
                let value = kept * self.crossed[i][o][lane] - lost * of_part;
                self.crossed[i][o][lane] = value - between * apart[i] * shift;
            }
            self.mean[i][lane] = kept * self.mean[i][lane] - lost * means[i];
        }
        for o in 0..3 {
            self.target[o][lane] = kept * self.target[o][lane] - lost * means[taps + o];
        }
        self.count[lane] = all - n;
    }
}

#[inline(always)]
fn add_scaled(mut sum: Wide, a: f32, b: Wide) -> Wide {
    for i in 0..WIDE {
        sum[i] += a * b[i];
    }
    sum
}

impl Kernel for &mut Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut matrix = Augmented::new(self.light.taps);
        let mut out = vec![[ZERO; 3]; self.light.taps];
        for group in 0..self.light.groups {
            self.multiply(group);
            for half in 0..WIDE / LANES {
                let first = group * WIDE + half * LANES;
                if first < self.light.pools.len() {
                    for position in 0..self.system.positions.len() {
                        self.solve(position, first, half, &mut matrix, &mut out);
                    }
                }
            }
        }
    }
}

impl Solve<'_> {
    /// A C Aᵀ of a group.
    #[inline(always)]
    fn multiply(&mut self, group: usize) {
        let (taps, k) = (self.light.taps, self.light.components);
        let pairs = taps * (taps + 1) / 2;
        let blocks = self.filters.len() / k;
        let mut pair = 0;
        let covariances = &self.light.covariances[group * pairs * k * k..][..pairs * k * k];
        for i in 0..taps {
            for j in i..taps {
                let covariance = &covariances[pair * k * k..][..k * k];
                for block in 0..blocks {
                    let filters = &self.filters[block * k..(block + 1) * k];
                    // The product of the covariance with the filter of j, by component of i.
                    let mut right = [[[0.0f32; WIDE]; FILTERS]; MAX_COMPONENTS];
                    let count = self.system.responses.len() - block * FILTERS;
                    for (row, right) in covariance.chunks_exact(k).zip(&mut right) {
                        // Written out, since compilers turn a loop over the filters into gathers.
                        let [mut s0, mut s1, mut s2, mut s3] = [[0.0f32; WIDE]; FILTERS];
                        macro_rules! add {
                            ($($sum:ident $filter:literal),*) => {
                                for (c, f) in row.iter().zip(filters) {
                                    $($sum = add_scaled($sum, f[$filter], *c);)*
                                }
                            };
                        }
                        match count {
                            1 => add!(s0 0),
                            2 => add!(s0 0, s1 1),
                            3 => add!(s0 0, s1 1, s2 2),
                            _ => add!(s0 0, s1 1, s2 2, s3 3),
                        }
                        *right = [s0, s1, s2, s3];
                    }
                    for (position, channels) in self.system.channels.iter().enumerate() {
                        let (a, b) = (channels[i], channels[j]);
                        if b / FILTERS != block {
                            continue;
                        }
                        let left = &self.filters[a / FILTERS * k..][..k];
                        let mut sum = [0.0f32; WIDE];
                        for (right, f) in right.iter().zip(left) {
                            sum = add_scaled(sum, f[a % FILTERS], right[b % FILTERS]);
                        }
                        self.products[position * pairs + pair] = sum;
                    }
                }
                pair += 1;
            }
        }
    }

    /// The kernels of eight pools at a position.
    #[inline(always)]
    fn solve(
        &mut self,
        position: usize,
        first: usize,
        half: usize,
        matrix: &mut Augmented,
        out: &mut [[Lanes; 3]],
    ) {
        let Solve { light, system, products, kernels, .. } = self;
        let taps = light.taps;
        let channels = &system.channels[position];
        let pairs = taps * (taps + 1) / 2;
        let products = &mut products[position * pairs..(position + 1) * pairs];
        let count = (light.pools.len() - first).min(LANES);
        let mut signals = Signals::new(light, system, channels, first);
        for lane in 0..count {
            let pooled = &light.pools[first + lane];
            if let Some(saturated) = system.saturated.of(position, pooled.pool) {
                signals.leave_out(&saturated, lane, half * LANES + lane, products);
            }
        }
        // Lanes beyond the last pool repeat the first one.
        let lane_of = |lane: usize| first + if lane < count { lane } else { 0 };
        let filters = system.responses.len();
        let (mut share, mut target, mut shift) = (ZERO, [ZERO; 3], [ZERO; 3]);
        let (mut even_mean, mut even) = (vec![ZERO; filters], vec![ZERO; filters * filters]);
        let mut even_crossed = vec![[ZERO; 3]; filters];
        for lane in 0..LANES {
            let own = signals.count[lane] * system.share;
            let mine = [0, 1, 2].map(|o| signals.target[o][lane]);
            share[lane] = 1.0;
            for o in 0..3 {
                target[o][lane] = mine[o];
            }
            if let Some(uniform) = (system.even)(position, light.pools[lane_of(lane)].pool) {
                let w = own / (own + uniform.count);
                share[lane] = w;
                for c in 0..filters {
                    even_mean[c][lane] = uniform.mean[c];
                    for d in 0..filters {
                        even[c * filters + d][lane] = (1.0 - w) * uniform.covariance[c * filters + d];
                    }
                    for o in 0..3 {
                        even_crossed[c][o][lane] = (1.0 - w) * uniform.crossed[c][o];
                    }
                }
                for o in 0..3 {
                    target[o][lane] = w * mine[o] + (1.0 - w) * uniform.target[o];
                    shift[o][lane] = mine[o] - uniform.target[o];
                }
            }
        }
        // Of the patches of the light and the uniform ones, between their means.
        let mut between = ZERO;
        for lane in 0..LANES {
            between[lane] = share[lane] * (1.0 - share[lane]);
        }
        let (mut mean, mut apart) = (vec![ZERO; taps], vec![ZERO; taps]);
        for (i, &channel) in channels.iter().enumerate() {
            let (own, crossed) = (signals.mean[i], signals.crossed[i]);
            for lane in 0..LANES {
                let w = share[lane];
                mean[i][lane] = w * own[lane] + (1.0 - w) * even_mean[channel][lane];
                apart[i][lane] = if w < 1.0 { own[lane] - even_mean[channel][lane] } else { 0.0 };
            }
            for o in 0..3 {
                let mut value = even_crossed[channel][o];
                for lane in 0..LANES {
                    value[lane] +=
                        share[lane] * crossed[o][lane] + between[lane] * apart[i][lane] * shift[o][lane];
                }
                matrix.set(taps + o, i, value);
            }
        }
        let noise = &system.noise;
        let side = (taps as f64).sqrt() as usize;
        let mut pair = 0;
        for i in 0..taps {
            let even = &even[channels[i] * filters..][..filters];
            let mut scaled = ZERO;
            for lane in 0..LANES {
                scaled[lane] = between[lane] * apart[i][lane];
            }
            for j in i..taps {
                let product = &products[pair][half * LANES..][..LANES];
                let mut value = even[channels[j]];
                for lane in 0..LANES {
                    value[lane] += share[lane] * f64::from(product[lane]) + scaled[lane] * apart[j][lane];
                }
                if i == j {
                    for lane in 0..LANES {
                        let m = mean[i][lane];
                        let square = value[lane] + m * m;
                        value[lane] += noise.own(m, square) + UNKNOWN * square;
                    }
                }
                if noise.row != 0.0 && i / side == j / side {
                    value = value.map(|v| v + noise.row);
                }
                if noise.column != 0.0 && i % side == j % side {
                    value = value.map(|v| v + noise.column);
                }
                matrix.set(j, i, value);
                pair += 1;
            }
        }
        for c in 0..3 {
            for d in 0..=c {
                matrix.set(taps + c, taps + d, ZERO);
            }
        }
        matrix.factor();
        matrix.solve(out);
        for lane in 0..count {
            let mut weights = vec![0.0; 3 * taps];
            let mut offsets = vec![0.0; 3];
            for o in 0..3 {
                let mut sum = target[o][lane];
                for i in 0..taps {
                    let w = out[i][o][lane];
                    weights[o * taps + i] = w;
                    sum -= w * mean[i][lane];
                }
                offsets[o] = sum;
            }
            kernels[position * light.pools.len() + first + lane] = Some(PoolKernels { weights, offsets });
        }
    }
}
