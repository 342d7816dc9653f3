//! Pipelines whose kernels are solved elsewhere, class by class: fallbacks for rare classes and symmetric positions are those of
//! [`Training`](super::Training).

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use super::fallback::{Filled, Source, Table};
use super::pools::Pool;
use super::solve::Solution;
use super::symmetry::{Isometry, Symmetry};
use super::train::{expanded, least_patches};
use super::{Axes, L3Error, Pipeline, PipelineParts};

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

/// Numbers of patches and kernels of pools.
pub(crate) trait PoolSource: Sync {
    /// Number of patches.
    fn count(&self, pool: ClassPool) -> u64;

    /// The kernels around a [representative](representatives) position; `None` where they are not known.
    fn kernels(&self, position: usize, pool: ClassPool) -> Option<PoolKernels>;
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

/// The pools whose kernels a pipeline needs, from the numbers of patches of all pools.
pub(crate) fn needed_pools(
    axes: &Axes,
    count: &(dyn Fn(ClassPool) -> u64 + Sync),
) -> Result<Vec<ClassPool>, L3Error> {
    struct Wanted<'a> {
        count: &'a (dyn Fn(ClassPool) -> u64 + Sync),
        outputs: usize,
        taps: usize,
        pools: &'a Mutex<BTreeSet<ClassPool>>,
    }
    impl Source for Wanted<'_> {
        fn count(&self, pool: Pool) -> u64 {
            (self.count)(pool.into())
        }

        fn solve(&self, pool: Pool, _: bool, _: usize) -> Result<Solution, L3Error> {
            self.pools.lock().unwrap_or_else(PoisonError::into_inner).insert(pool.into());
            Ok(Solution { weights: vec![0.0; self.outputs * self.taps], offsets: vec![0.0; self.outputs] })
        }
    }
    let pools = Mutex::default();
    let source = Wanted { count, outputs: 1, taps: axes.taps(), pools: &pools };
    Table::new(0, source, axes, 1, least_patches(axes)).filled(0.0)?;
    let pools = pools.lock().unwrap_or_else(PoisonError::into_inner).iter().copied().collect();
    Ok(pools)
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
    pub(crate) source: &'a dyn PoolSource,
}

impl Solved<'_> {
    /// # Errors
    /// When kernels are missing or not finite.
    pub(crate) fn pipeline(self, provenance: String) -> Result<Pipeline, L3Error> {
        let Self { axes, outputs, channel_names, levels: [black_level, white_level], trained, source } = self;
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
        for (i, class) in classes.iter_mut().enumerate() {
            let place = i % per_position;
            let own = ClassPool { level: Some(place / textures), texture: Some(place % textures) };
            class.count = source.count(own);
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
        self.source.count(pool.into())
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
