//! The moments of the light on patches, gathered and laid out for the kernels.

use std::collections::BTreeSet;

use crate::camera::CameraError;
use crate::l3::{
    Axes, ClassMap, ClassPool, L3Error, Moments, PatchCounts, Turn, needed_pools, representatives, turns,
};
use crate::numeric::Planes;
use crate::sensor::RawImage;

use super::gather::Gatherer;
use crate::design::pixel_light::PixelLight;
use crate::design::screen::lanes::{LANES, Lanes, ZERO};

/// Pools per vector in single precision.
pub(super) const WIDE: usize = 16;
/// A number of each pool.
pub(super) type Wide = [f32; WIDE];

/// The moments of the light on patches of pixels, for every pool of classes that a pipeline needs.
#[derive(Debug)]
pub(in crate::design) struct ClassLight {
    pub(super) taps: usize,
    pub(super) components: usize,
    /// The pools in the order of lanes.
    pub(super) pools: Vec<Pooled>,
    /// Number of vectors of pools.
    pub(super) groups: usize,
    /// Covariances of pixels i ≤ j, by group, pair, and the components of i and j.
    pub(super) covariances: Vec<Wide>,
    /// Means, by half a group, then pixel and component.
    pub(super) means: Vec<Lanes>,
    /// Covariances of a pixel with X, Y, Z of the middle one, by half a group, then pixel and component.
    pub(super) crossed: Vec<[Lanes; 3]>,
    /// Mean responses of the neutral array relative to white, smallest and largest.
    pub(super) range: [f32; 2],
    /// Number of pixels by level and texture.
    pub(super) counts: Vec<f64>,
    pub(super) textures: usize,
    /// The classes of the pixels.
    pub(super) map: ClassMap,
    /// The rotations and reflections of the mosaic.
    pub(super) turns: Vec<Turn>,
}

/// A pool of classes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pooled {
    pub(super) pool: ClassPool,
    /// Number of patches.
    pub(super) count: f64,
    /// Mean X, Y, Z of the middle pixel.
    pub(super) target: [f64; 3],
}

impl ClassLight {
    /// The statistics of light with a target X, Y, Z for each pixel. `axes` are those of the neutral array, and `seen` is its
    /// capture with noise, in which white has the response `white`. `even_patches` is the usual number of uniform patches of a level
    /// that a design adds at each position.
    pub(in crate::design) fn new(
        light: &PixelLight,
        target: &Planes,
        axes: &Axes,
        seen: &RawImage,
        white: f32,
        even_patches: f64,
    ) -> Result<Self, CameraError> {
        let map = ClassMap::new(axes, seen)?;
        let (taps, components) = (axes.taps(), light.spectra().len());
        let (levels, textures) = (axes.level_count(), axes.textures().count());
        let gatherer = Gatherer::new(light, target, axes.side(), &map);
        let mut counts = vec![0.0; levels * textures];
        gatherer.members().for_each(|(class, pixels)| counts[class] = pixels.len() as f64);
        let mut this = Self {
            taps,
            components,
            pools: Vec::new(),
            groups: 0,
            covariances: Vec::new(),
            means: Vec::new(),
            crossed: Vec::new(),
            range: map.range.map(|r| r / white),
            counts,
            textures,
            map,
            turns: turns(axes),
        };
        let pools = this.needed_pools(axes, even_patches)?;
        let of_class: Vec<Moments> = (0..levels * textures).map(|class| gatherer.moments(class)).collect();
        this.groups = pools.len().div_ceil(WIDE);
        let pairs = taps * (taps + 1) / 2;
        let halves = this.groups * (WIDE / LANES) * taps * components;
        (this.means, this.crossed) = (vec![ZERO; halves], vec![[ZERO; 3]; halves]);
        this.covariances = vec![[0.0; WIDE]; this.groups * pairs * components * components];
        for (lane, pool) in pools.into_iter().enumerate() {
            let moments = this.moments(pool, &of_class);
            this.fill(lane, pool, &moments);
        }
        Ok(this)
    }

    /// The pools that pipelines need. Classes of flat patches may have kernels of their own thanks to the uniform patches of a design, or
    /// not, and a design leaves the patches out that it saturates; all pools are included that may be needed.
    fn needed_pools(&self, axes: &Axes, even_patches: f64) -> Result<BTreeSet<ClassPool>, L3Error> {
        let counts = self.patch_counts(axes);
        let mut pools = BTreeSet::new();
        for position in representatives(axes) {
            for even in [0.0, even_patches] {
                let further = |_, texture| if texture == 0 { even } else { 0.0 };
                pools.extend(needed_pools(axes, position, &|pool| counts.count(position, pool, &further))?);
            }
        }
        let levels = (0..axes.level_count()).map(Some).chain([None]);
        pools.extend(levels.map(|level| ClassPool { level, texture: None }));
        Ok(pools)
    }

    /// The numbers of patches of a capture.
    pub(in crate::design) fn patch_counts(&self, axes: &Axes) -> PatchCounts {
        PatchCounts::new(axes, &self.counts)
    }

    /// Number of pixels by level and texture.
    pub(in crate::design) fn pixels(&self) -> &[f64] {
        &self.counts
    }

    /// The smallest and largest mean response of the neutral array relative to white.
    pub(in crate::design) fn range(&self) -> [f32; 2] {
        self.range
    }

    /// The moments of a pool, averaged over the rotations and reflections of the mosaic; `of_class` has those of each class.
    fn moments(&self, pool: ClassPool, of_class: &[Moments]) -> Moments {
        let k = self.components;
        let mut sum = Moments::new(self.taps * k, 3);
        for turn in &self.turns {
            let mut places: Vec<usize> = (0..sum.size()).collect();
            for (tap, to) in turn.taps.iter().enumerate() {
                (0..k).for_each(|c| places[1 + tap * k + c] = 1 + to * k + c);
            }
            for (class, moments) in of_class.iter().enumerate() {
                let texture = turn.textures[class % self.textures];
                let fits = pool.level.is_none_or(|level| level == class / self.textures)
                    && pool.texture.is_none_or(|t| texture == t);
                if fits && moments.get(0, 0) > 0.0 {
                    sum.merge_permuted(moments, &places);
                }
            }
        }
        sum.divide(self.turns.len() as f64);
        sum
    }

    /// Puts a pool into its lane.
    pub(super) fn fill(&mut self, lane: usize, pool: ClassPool, m: &Moments) {
        let (taps, k) = (self.taps, self.components);
        let width = taps * k;
        let count = m.get(0, 0);
        let share = 1.0 / count.max(1.0);
        let mean: Vec<f64> = (0..width + 3).map(|i| m.get(0, 1 + i) * share).collect();
        let covariance = |i: usize, j: usize| m.get(1 + i, 1 + j) * share - mean[i] * mean[j];
        let pairs = taps * (taps + 1) / 2;
        let (group, at) = (lane / WIDE, lane % WIDE);
        let mut place = group * pairs * k * k;
        for i in 0..taps {
            for j in i..taps {
                for a in 0..k {
                    for b in 0..k {
                        self.covariances[place][at] = covariance(i * k + a, j * k + b) as f32;
                        place += 1;
                    }
                }
            }
        }
        // The unused lanes of half a group repeat its first pool, so that they can be solved as well.
        let (half, lane) = (lane / LANES, lane % LANES);
        for (i, &mean) in mean.iter().enumerate().take(width) {
            let place = half * width + i;
            let lanes = if lane == 0 { 0..LANES } else { lane..lane + 1 };
            for lane in lanes {
                self.means[place][lane] = mean;
                for o in 0..3 {
                    self.crossed[place][o][lane] = covariance(i, width + o);
                }
            }
        }
        self.pools.push(Pooled { pool, count, target: [0, 1, 2].map(|o| mean[width + o]) });
    }
}
