//! Statistics of the light of the training scene, from which the pipeline of any design is learned without its patches.
//!
//! A patch of noise-free samples is x = A u: the coefficients u of the light on its pixels in a few spectral components
//! ([`PixelLight`]), and the linear map A of the filters. The moments of x and of the target follow from those of u, which no
//! filter changes. [`ClassLight`] holds the moments of u for each class of patches. The classes are those that a *neutral array*
//! sees, whose mosaic is that of the design and whose filters are all clear: they depend on the translations of the mosaic,
//! between whose samples contrast and orientation are measured, but not on the filters.
//!
//! Every pixel of the scene belongs to the patches of every position of the tile, whereas a capture shows each pixel at one
//! position. Kernels are therefore learned from as many times more patches as the tile has cells.

mod gather;
mod kernel;

use crate::camera::CameraError;
use crate::l3::{Axes, ClassMap, ClassPool, Moments, Turn, needed_pools, turns};
use crate::numeric::Planes;
use crate::sensor::RawImage;

use super::pixel_light::PixelLight;
use gather::Gatherer;
use kernel::Wide;
pub(super) use kernel::{EvenPatches, LightSystem};

/// The moments of the light on patches of pixels, for every pool of classes that a pipeline needs.
#[derive(Debug)]
pub(super) struct ClassLight {
    taps: usize,
    components: usize,
    /// The pools in the order of lanes.
    pools: Vec<Pooled>,
    /// Number of vectors of pools.
    groups: usize,
    /// Covariances of pixels i ≤ j, by group, pair, and the components of i and j.
    covariances: Vec<Wide>,
    /// By lane, then pixel and component.
    means: Vec<Vec<f64>>,
    /// Covariances of a pixel with X, Y, Z of the middle one, by lane, then pixel and component.
    crossed: Vec<Vec<[f64; 3]>>,
    /// Mean responses of the neutral array, smallest and largest.
    range: [f32; 2],
    /// Number of patches by class.
    counts: Vec<f64>,
    textures: usize,
}

/// A pool of classes.
#[derive(Debug, Clone, Copy)]
struct Pooled {
    pool: ClassPool,
    /// Number of patches.
    count: f64,
    /// Mean X, Y, Z of the middle pixel.
    target: [f64; 3],
}

impl ClassLight {
    /// The statistics of light with a target X, Y, Z for each pixel. `axes` are those of the neutral array, and `seen` is its
    /// capture with noise.
    pub(super) fn new(
        light: &PixelLight,
        target: &Planes,
        axes: &Axes,
        seen: &RawImage,
    ) -> Result<Self, CameraError> {
        let map = ClassMap::new(axes, seen)?;
        let (taps, components) = (axes.taps(), light.spectra().len());
        let (levels, textures) = (axes.level_count(), axes.textures().count());
        let turns = turns(axes);
        let gatherer = Gatherer::new(light, target, axes.side(), &map);
        // The classes of all rotations and reflections count equally.
        let mut counts = vec![0.0; levels * textures];
        for (class, pixels) in gatherer.members() {
            let (level, texture) = (class / textures, class % textures);
            for turn in &turns {
                counts[level * textures + turn.textures[texture]] += pixels.len() as f64 / turns.len() as f64;
            }
        }
        let mut this = Self {
            taps,
            components,
            pools: Vec::new(),
            groups: 0,
            covariances: Vec::new(),
            means: Vec::new(),
            crossed: Vec::new(),
            range: map.range,
            counts,
            textures,
        };
        let pools = needed_pools(axes, &|pool| this.count(pool) as u64)?;
        this.groups = pools.len().div_ceil(kernel::WIDE);
        let pairs = taps * (taps + 1) / 2;
        this.covariances = vec![[0.0; kernel::WIDE]; this.groups * pairs * components * components];
        for (lane, pool) in pools.into_iter().enumerate() {
            let moments = this.moments(&gatherer, pool, &turns);
            this.fill(lane, pool, &moments);
        }
        Ok(this)
    }

    /// Number of patches of a pool, over all positions.
    pub(super) fn count(&self, pool: ClassPool) -> f64 {
        let fits = |wanted: Option<usize>, got| wanted.is_none_or(|w| w == got);
        let of = |(class, count): (usize, &f64)| {
            let (level, texture) = (class / self.textures, class % self.textures);
            (fits(pool.level, level) && fits(pool.texture, texture)).then_some(*count)
        };
        self.counts.iter().enumerate().filter_map(of).sum()
    }

    /// The smallest and largest mean response of the neutral array.
    pub(super) fn range(&self) -> [f32; 2] {
        self.range
    }

    /// The moments of a pool, averaged over the rotations and reflections of the mosaic.
    fn moments(&self, gatherer: &Gatherer<'_>, pool: ClassPool, turns: &[Turn]) -> Moments {
        let k = self.components;
        let mut sum = Moments::new(self.taps * k, 3);
        for turn in turns {
            let fits = |class: usize| {
                pool.level.is_none_or(|level| level == class / self.textures)
                    && pool.texture.is_none_or(|t| turn.textures[class % self.textures] == t)
            };
            let moments = gatherer.moments(&fits);
            let mut places: Vec<usize> = (0..sum.size()).collect();
            for (tap, to) in turn.taps.iter().enumerate() {
                (0..k).for_each(|c| places[1 + tap * k + c] = 1 + to * k + c);
            }
            sum.merge_permuted(&moments, &places);
        }
        sum.divide(turns.len() as f64);
        sum
    }

    /// Puts a pool into its lane.
    fn fill(&mut self, lane: usize, pool: ClassPool, m: &Moments) {
        let (taps, k) = (self.taps, self.components);
        let width = taps * k;
        let count = m.get(0, 0);
        let share = 1.0 / count.max(1.0);
        let mean: Vec<f64> = (0..width + 3).map(|i| m.get(0, 1 + i) * share).collect();
        let covariance = |i: usize, j: usize| m.get(1 + i, 1 + j) * share - mean[i] * mean[j];
        let pairs = taps * (taps + 1) / 2;
        let (group, at) = (lane / kernel::WIDE, lane % kernel::WIDE);
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
        let crossed = (0..width).map(|i| [0, 1, 2].map(|o| covariance(i, width + o))).collect();
        self.crossed.push(crossed);
        self.pools.push(Pooled { pool, count, target: [0, 1, 2].map(|o| mean[width + o]) });
        self.means.push(mean[..width].to_vec());
    }
}
