//! Training: from moments to the learned table.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::error::within;
use super::fallback::{Filled, Table};
use super::pools::{Pools, kept_saturations, trained};
use super::solve::Solving;
use super::symmetry::Symmetry;
use super::{Class, Kernels, L3Error, Origin, Pipeline, PipelineParts, Statistics};

/// Patches that a class needs by default, per tap. Kernels of p weights learned from n patches have an error that is larger
/// by p/n on average than that of the best kernels: a tenth.
const PATCHES_PER_TAP: u64 = 10;
/// Largest weight of the variance.
const MOST_ALPHA: f64 = 1e6;

/// How kernels are learned from [`Statistics`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct Training {
    /// What kernels minimise.
    pub solver: Solver,
    /// Whether kernels have an offset.
    pub kernel: KernelForm,
    /// Classes share the patches of those that turns and mirrors of the mosaic make equal to them. Looked for in tiles of up to
    /// 4096 cells.
    pub symmetry: bool,
    /// Patches that a class needs to have kernels of its own. `None`: ten for each tap of the patch.
    pub least_patches: Option<u64>,
    /// Share of all patches, 0 to 1, that a combination of clipped channels needs for a place on the axis of
    /// saturation. Patches of rarer ones count to the nearest combination, as in rendering.
    pub saturation_share: f64,
    /// Weight, 0 to 1, with which the learned kernels of the levels next to a class are mixed into its own, besides the number of their
    /// patches. 0: each level for itself.
    pub smoothing: f64,
}

impl Default for Training {
    fn default() -> Self {
        Self {
            solver: Solver::default(),
            kernel: KernelForm::default(),
            symmetry: true,
            least_patches: None,
            saturation_share: 0.003,
            smoothing: 0.0,
        }
    }
}

/// What kernels minimise. C is the covariance of the patches of a class (second moments about zero for linear kernels), c
/// theirs with an output, Σ the covariance of the noise, from [`super::Axes::noise`] at the class's own mean signals.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// Squared error over the patches as they are, without adding noise: C⁻¹ c, the solution of least norm where C is singular.
    LeastSquares,
    /// Squared error over the patches as they are plus λ times the squared weights: (C + λ)⁻¹ c, with λ for each class and
    /// output by generalised cross-validation ([golub1979]).
    ///
    /// [golub1979]: https://doi.org/10.1080/00401706.1979.10489751
    Ridge,
    /// Squared error under noise: (C + Σ)⁻¹ c. Statistics of noisy images hold Σ already. The default: of all weights it has the
    /// least colour difference, in pixels and as the eye sees them.
    #[default]
    Wiener,
    /// bias² + α · variance in an opponent colour space: (C + α Σ)⁻¹ c for each of its coordinates, as in the slides that L³ was shown
    /// with (l3slides2014 in REFERENCES.bib).
    ///
    /// The space is that of S-CIELAB, fitted to how contrast sensitivity separates into pattern and colour ([poirson1993],
    /// [zhang1997]), computed from X, Y, Z of the 2° observer. When the outputs are not named `X`, `Y` and `Z` (among others
    /// perhaps), those without a place in it are solved as by [`Solver::Wiener`].
    ///
    /// [poirson1993]: https://doi.org/10.1364/JOSAA.10.002458
    /// [zhang1997]: crate::color::scielab
    Perceptual(PerceptualWeights),
}

/// The weight α of the variance against bias² in luminance and in the two chrominances, 0 to 10⁶. Above 1 there is
/// less noise than the least squared error has; for it luminance is blurred, and chrominance loses saturation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Alpha {
    /// α_L.
    pub luminance: f64,
    /// α_C, for red-green and for blue-yellow.
    pub chrominance: f64,
}

/// Weights for flat patches and for all others. By default those of the slides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PerceptualWeights {
    /// For flat patches.
    pub flat: Alpha,
    /// For texture and edges, and where they are not told apart from flat ones.
    pub texture: Alpha,
}

impl Default for PerceptualWeights {
    fn default() -> Self {
        Self {
            flat: Alpha { luminance: 16.0, chrominance: 4.0 },
            texture: Alpha { luminance: 1.0, chrominance: 4.0 },
        }
    }
}

/// The form of kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KernelForm {
    /// Weights and an offset. Estimates of small weight fall back to the mean of the class.
    #[default]
    Affine,
    /// Weights alone: the output scales with the light. Estimates of small weight fall back to black.
    Linear,
}

impl Training {
    /// Learns the kernels of every class. `provenance` says how, as JSON, and is kept in the pipeline.
    ///
    /// # Errors
    /// When a parameter is out of its range, nothing has been seen, or nothing of a position of the mosaic.
    pub fn solve(&self, statistics: &Statistics, provenance: String) -> Result<Pipeline, L3Error> {
        self.validate()?;
        let axes = statistics.axes();
        if statistics.count() == 0 {
            return Err(L3Error::Empty { side: axes.side() });
        }
        let Some([black_level, white_level]) = statistics.raw_levels() else {
            return Err(L3Error::Table { reason: "the statistics have no black and white level".into() });
        };
        let saturations = kept_saturations(statistics, self.saturation_share);
        let symmetry = if self.symmetry { Symmetry::of(axes) } else { Symmetry::none(axes) };
        let pools = Pools::new(statistics, &saturations);
        let solving = Solving::new(&self.solver, self.kernel, statistics);
        let least = self.least_patches.unwrap_or(PATCHES_PER_TAP * axes.taps() as u64).max(1);
        let tables = symmetry.groups.par_iter().map(|(position, members)| {
            let group = (*position, members.as_slice());
            let table = Table::new(group, &pools, &solving, axes, saturations.len(), least);
            Ok((*position, table.filled(self.smoothing)?))
        });
        let tables: Vec<(usize, Filled)> = tables.collect::<Result<_, L3Error>>()?;
        let (classes, kernels) = expanded(statistics, &pools, &symmetry, &tables, saturations.len());
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

    fn validate(&self) -> Result<(), L3Error> {
        within("saturation_share", self.saturation_share, 0.0..=1.0, "0 to 1")?;
        within("smoothing", self.smoothing, 0.0..=1.0, "0 to 1")?;
        if let Solver::Perceptual(PerceptualWeights { flat, texture }) = self.solver {
            for alpha in [flat.luminance, flat.chrominance, texture.luminance, texture.chrominance] {
                within("α", alpha, 0.0..=MOST_ALPHA, "0 to 1000000")?;
            }
        }
        Ok(())
    }
}

/// The tables of the positions that stand for others, turned for all positions, in the order of a pipeline.
fn expanded(
    statistics: &Statistics,
    pools: &Pools<'_>,
    symmetry: &Symmetry,
    tables: &[(usize, Filled)],
    saturations: usize,
) -> (Vec<Class>, Kernels) {
    let axes = statistics.axes();
    let (taps, outputs) = (axes.taps(), statistics.outputs().len());
    let (levels, textures) = (axes.level_count(), axes.textures().count());
    let count = saturations * levels * textures;
    let mut classes = vec![Class { count: 0, origin: Origin::PooledLevels }; axes.positions() * count];
    let mut weights = vec![0.0; axes.positions() * count * outputs * taps];
    let mut offsets = vec![0.0; axes.positions() * count * outputs];
    for (position, own) in symmetry.represented.iter().enumerate() {
        let Ok(found) = tables.binary_search_by_key(&own.position, |t| t.0) else { continue };
        let to = own.turn.taps(axes.side());
        for (place, (solution, origin)) in tables[found].1.iter().enumerate() {
            let texture = own.turn.texture(axes.textures(), place % textures);
            let class = position * count + place - place % textures + texture;
            classes[class].origin = *origin;
            for (output, row) in solution.weights.chunks_exact(taps).enumerate() {
                let row_at = (class * outputs + output) * taps;
                row.iter().zip(&to).for_each(|(&w, &tap)| weights[row_at + tap] = w as f32);
                offsets[class * outputs + output] = solution.offsets[output] as f32;
            }
        }
        for seen in &pools.seen[position] {
            let class = (seen.saturation * levels + seen.level) * textures + seen.texture;
            classes[position * count + class].count += seen.moments.count();
        }
    }
    (classes, Kernels { weights, offsets })
}
