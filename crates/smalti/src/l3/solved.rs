//! Pipelines whose kernels are solved elsewhere, class by class: fallbacks for rare classes and symmetric positions are those of
//! [`Training`](super::Training).

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use super::fallback::{Filled, Source, Table};
use super::pools::{Pool, repeats};
use super::solve::Solution;
use super::symmetry::{Isometry, Member, Symmetry};
use super::train::{expanded, least_patches};
use super::{Axes, L3Error, Pipeline, PipelineParts, Textures};

/// Classes of a position to pool by level and texture; `None` pools a whole axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ClassPool {
    pub(crate) level: Option<usize>,
    pub(crate) texture: Option<usize>,
}

impl From<Pool> for ClassPool {
    fn from(pool: Pool) -> Self {
        Self { level: pool.level, texture: pool.texture }
    }
}

/// The kernels of a pool.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PoolKernels {
    /// Ordered output, tap.
    pub(crate) weights: Vec<f64>,
    /// One per output.
    pub(crate) offsets: Vec<f64>,
}

/// Numbers of patches and kernels of pools around [representative](representatives) positions.
pub(crate) trait PoolSource: Sync {
    /// Number of patches, without repetitions by symmetry.
    fn count(&self, position: usize, pool: ClassPool) -> u64;

    /// The kernels; `None` where they are not known.
    fn kernels(&self, position: usize, pool: ClassPool) -> Option<PoolKernels>;
}

/// Numbers of patches that a capture would have in each class, from those of all pixels.
#[derive(Debug, Clone)]
pub(crate) struct PatchCounts {
    textures: Textures,
    /// By level and texture, at each position.
    classes: Vec<f64>,
    groups: Vec<(usize, Vec<Member>)>,
}

impl PatchCounts {
    /// `pixels` are the numbers of pixels by level and texture. A capture shows an equal share of them at each position.
    pub(crate) fn new(axes: &Axes, pixels: &[f64]) -> Self {
        let classes = pixels.iter().map(|n| n / axes.positions() as f64).collect();
        Self { textures: axes.textures(), classes, groups: Symmetry::of(axes).groups }
    }

    /// A representative position and those that are equivalent; none for other positions.
    fn members(&self, position: usize) -> &[Member] {
        let found = self.groups.binary_search_by_key(&position, |(p, _)| *p);
        found.map_or(&[], |at| self.groups[at].1.as_slice())
    }

    /// Number of positions that are equivalent to a representative one.
    pub(crate) fn cells(&self, position: usize) -> usize {
        self.members(position).iter().map(|m| m.position).collect::<BTreeSet<usize>>().len()
    }

    /// Number of patches of a pool around a representative position and those that are equivalent, without repetitions; `further` is the
    /// number of patches of a level and texture that are added at each position, or less than 0.
    pub(crate) fn count(
        &self,
        position: usize,
        pool: ClassPool,
        further: &dyn Fn(usize, usize) -> f64,
    ) -> u64 {
        let members = self.members(position);
        let count = self.textures.count();
        let mut all = 0.0;
        for member in members {
            for (class, patches) in self.classes.iter().enumerate() {
                let (level, texture) = (class / count, class % count);
                let turned = member.isometry.texture(self.textures, texture);
                if pool.level.is_none_or(|l| l == level) && pool.texture.is_none_or(|t| t == turned) {
                    all += (patches + further(level, turned)).max(0.0);
                }
            }
        }
        (all / repeats(position, members, pool.texture, self.textures) as f64) as u64
    }
}

/// A rotation or reflection that maps the mosaic onto itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Turn {
    /// Its number, 0 to 7; 0 is the identity.
    pub(crate) number: usize,
    /// For each tap of a patch, the tap that it is mapped to.
    pub(crate) taps: Vec<usize>,
    /// For each texture class, the class that it is mapped to.
    pub(crate) textures: Vec<usize>,
}

/// The rotations and reflections that map the mosaic onto itself, whatever the shift.
pub(crate) fn turns(axes: &Axes) -> Vec<Turn> {
    let symmetry = Symmetry::of(axes);
    let keeps = |isometry: &Isometry| {
        symmetry.groups.iter().any(|(_, members)| members.iter().any(|m| m.isometry == *isometry))
    };
    let all = Isometry::ALL.into_iter().enumerate().filter(|(_, isometry)| keeps(isometry));
    all.map(|(number, isometry)| Turn {
        number,
        taps: isometry.taps(axes.side()),
        textures: (0..axes.textures().count()).map(|t| isometry.texture(axes.textures(), t)).collect(),
    })
    .collect()
}

/// The positions whose kernels determine those of all positions, ascending.
pub(crate) fn representatives(axes: &Axes) -> Vec<usize> {
    Symmetry::of(axes).groups.iter().map(|(position, _)| *position).collect()
}

/// The pools whose kernels a position of a pipeline needs, from the numbers of patches of all pools.
pub(crate) fn needed_pools(
    axes: &Axes,
    position: usize,
    count: &(dyn Fn(ClassPool) -> u64 + Sync),
) -> Result<BTreeSet<ClassPool>, L3Error> {
    struct Wanted<'a> {
        count: &'a (dyn Fn(ClassPool) -> u64 + Sync),
        pools: &'a Mutex<BTreeSet<ClassPool>>,
    }
    impl Source for Wanted<'_> {
        fn count(&self, pool: Pool) -> u64 {
            (self.count)(pool.into())
        }

        fn solve(&self, pool: Pool, _: bool, _: usize) -> Result<Solution, L3Error> {
            self.pools.lock().unwrap_or_else(PoisonError::into_inner).insert(pool.into());
            Ok(Solution { weights: Vec::new(), offsets: Vec::new() })
        }
    }
    let pools = Mutex::default();
    let source = Wanted { count, pools: &pools };
    Table::new(position, source, axes, 1, least_patches(axes)).filled(0.0)?;
    Ok(pools.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// A pipeline whose kernels come from a [`PoolSource`]. It has no classes of saturated patches.
pub(crate) struct Solved<'a> {
    pub(crate) axes: &'a Axes,
    pub(crate) outputs: Vec<String>,
    pub(crate) channel_names: Vec<String>,
    /// Black and white level of the raw images.
    pub(crate) levels: [f64; 2],
    /// Smallest and largest mean response of the patches, for each position.
    pub(crate) trained: Vec<[f32; 2]>,
    /// Number of patches of a class at a representative position, by position, level and texture.
    pub(crate) count: &'a dyn Fn(usize, usize, usize) -> u64,
    pub(crate) source: &'a dyn PoolSource,
}

impl Solved<'_> {
    /// # Errors
    /// When kernels are missing or not finite.
    pub(crate) fn pipeline(self, provenance: String) -> Result<Pipeline, L3Error> {
        let Self { axes, outputs, channel_names, levels: [black_level, white_level], trained, count, source } =
            self;
        let symmetry = Symmetry::of(axes);
        let table = |position: usize| {
            let own = PositionSource { position, source };
            let filled = Table::new(position, own, axes, 1, least_patches(axes)).filled(0.0)?;
            Ok((position, filled))
        };
        let tables: Vec<(usize, Filled)> =
            symmetry.groups.iter().map(|(position, _)| table(*position)).collect::<Result<_, L3Error>>()?;
        let (mut classes, kernels) = expanded(axes, outputs.len(), &symmetry, &tables, 1)?;
        let textures = axes.textures().count();
        let per_position = textures * axes.level_count();
        for (own, classes) in symmetry.represented.iter().zip(classes.chunks_exact_mut(per_position)) {
            for (place, class) in classes.iter_mut().enumerate() {
                class.count = count(own.position, place / textures, place % textures);
            }
        }
        Pipeline::from_parts(PipelineParts {
            axes: axes.clone(),
            saturations: vec![0],
            outputs,
            channel_names,
            black_level,
            white_level,
            trained,
            classes,
            kernels,
            provenance,
        })
    }
}

struct PositionSource<'a> {
    position: usize,
    source: &'a dyn PoolSource,
}

impl Source for PositionSource<'_> {
    fn count(&self, pool: Pool) -> u64 {
        self.source.count(self.position, pool.into())
    }

    fn solve(&self, pool: Pool, _: bool, class: usize) -> Result<Solution, L3Error> {
        let found = self.source.kernels(self.position, pool.into()).ok_or(L3Error::Singular(class))?;
        let finite = found.weights.iter().chain(&found.offsets).all(|w| w.is_finite());
        if !finite {
            return Err(L3Error::Singular(class));
        }
        Ok(Solution { weights: found.weights, offsets: found.offsets })
    }
}
