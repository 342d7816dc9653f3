//! Training: from moments to the learned table.

use rayon::prelude::*;

use super::fallback::{Filled, Source, Table};
use super::pools::{Pool, Pools, kept_saturations, trained};
use super::settings::Training;
use super::solve::{ClassSolver, Solution};
use super::symmetry::{Member, Symmetry};
use super::{Axes, Class, Kernels, L3Error, Origin, Pipeline, PipelineParts, Statistics};

/// Raised when learning gives other kernels for equal pairs and settings: statistics that were kept under another revision are not used.
pub const REVISION: u32 = 5;

/// Patches that a class needs by default, per tap. Kernels of p weights learned from n patches have an error that is larger
/// by p/n on average than that of the best kernels: a tenth.
const PATCHES_PER_TAP: u64 = 10;

/// Patches that a class needs by default to have kernels of its own.
pub(super) fn least_patches(axes: &Axes) -> u64 {
    PATCHES_PER_TAP * axes.taps() as u64
}

/// The moments of the patches around one position, and of those that are equivalent by symmetry.
struct Patches<'a> {
    position: usize,
    members: &'a [Member],
    pools: &'a Pools<'a>,
    solver: &'a ClassSolver<'a>,
}

impl Source for Patches<'_> {
    fn count(&self, pool: Pool) -> u64 {
        self.pools.count(self.position, self.members, pool)
    }

    fn solve(&self, pool: Pool, flat: bool, class: usize) -> Result<Solution, L3Error> {
        self.solver.solve(&self.pools.moments(self.position, self.members, pool), flat, class)
    }
}

impl Training {
    /// Solves the kernels of every class. `provenance` is JSON that describes the training; the pipeline keeps it.
    ///
    /// # Errors
    /// When a parameter is out of its range, or the statistics lack patches altogether or at a position of the mosaic.
    pub fn solve(&self, statistics: &Statistics, provenance: String) -> Result<Pipeline, L3Error> {
        self.validate()?;
        let axes = statistics.axes();
        if statistics.count() == 0 {
            return Err(L3Error::Empty(axes.side()));
        }
        let Some([black_level, white_level]) = statistics.raw_levels() else {
            return Err(L3Error::Table("the statistics have no black and white level".into()));
        };
        let saturations = kept_saturations(statistics, self.saturation_share);
        let symmetry = if self.symmetry { Symmetry::of(axes) } else { Symmetry::none(axes) };
        let pools = Pools::new(statistics, &saturations);
        let solver = ClassSolver::new(&self.solver, self.kernel, statistics);
        let least = self.least_patches.unwrap_or(least_patches(axes)).max(1);
        let tables = symmetry.groups.par_iter().map(|(position, members)| {
            let patches = Patches { position: *position, members, pools: &pools, solver: &solver };
            let table = Table::new(*position, patches, axes, saturations.len(), least);
            Ok((*position, table.filled(self.smoothing)?))
        });
        let tables: Vec<(usize, Filled)> = tables.collect::<Result<_, L3Error>>()?;
        let outputs = statistics.outputs().len();
        let (mut classes, kernels) = expanded(axes, outputs, &symmetry, &tables, saturations.len())?;
        pools.count_into(&mut classes, saturations.len());
        let pipeline = Pipeline::from_parts(PipelineParts {
            axes: axes.clone(),
            saturations,
            outputs: statistics.outputs().to_vec(),
            channel_names: statistics.channel_names().to_vec(),
            black_level,
            white_level,
            trained: trained(statistics, &symmetry),
            classes,
            kernels,
            provenance,
        })?;
        Ok(pipeline.with_white(statistics.white()))
    }
}

/// The tables of the representative positions, transformed to all positions, in the order of a pipeline. The counts of the classes
/// are 0.
pub(super) fn expanded(
    axes: &Axes,
    outputs: usize,
    symmetry: &Symmetry,
    tables: &[(usize, Filled)],
    saturations: usize,
) -> Result<(Vec<Class>, Kernels), L3Error> {
    let (taps, textures) = (axes.taps(), axes.textures().count());
    let count = saturations * axes.level_count() * textures;
    let mut classes = vec![Class { count: 0, origin: Origin::PooledLevels }; axes.positions() * count];
    let mut weights = vec![0.0; axes.positions() * count * outputs * taps];
    let mut offsets = vec![0.0; axes.positions() * count * outputs];
    for (position, own) in symmetry.represented.iter().enumerate() {
        let missing = |_| L3Error::Table(format!("position {} has no kernels", own.position));
        let found = tables.binary_search_by_key(&own.position, |t| t.0).map_err(missing)?;
        let to = own.isometry.taps(axes.side());
        for (place, (solution, origin)) in tables[found].1.iter().enumerate() {
            let texture = own.isometry.texture(axes.textures(), place % textures);
            let class = position * count + place - place % textures + texture;
            classes[class].origin = *origin;
            for (output, row) in solution.weights.chunks_exact(taps).enumerate() {
                let row_at = (class * outputs + output) * taps;
                row.iter().zip(&to).for_each(|(&w, &tap)| weights[row_at + tap] = w as f32);
                offsets[class * outputs + output] = solution.offsets[output] as f32;
            }
        }
    }
    Ok((classes, Kernels { weights, offsets }))
}
