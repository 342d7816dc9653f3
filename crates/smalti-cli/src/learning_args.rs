//! Options of learning.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use smalti::camera::{LevelRule, TrainingSettings};
use smalti::experiment::Resources;
use smalti::l3::{Alpha, KernelForm, PerceptualWeights, Quality, Solver, Textures, Training};
use smalti_io::cache::Cache;
use smalti_io::memory;
use smalti_io::rendered::TrainingSet;

use crate::args::{Choice, choice, word_of};
use crate::numbers::share;
use crate::progress::Progress;

/// Options of learning.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Learning")]
pub(crate) struct LearningOptions {
    /// Built-in scenes to learn from
    #[arg(long, default_value = word_of(&TrainingSet::NAMED, &TrainingSet::default()), value_parser = choice(&TrainingSet::NAMED))]
    pub(crate) training_set: TrainingSet,
    /// Side of the patch from which the colour of its central pixel is computed
    #[arg(long, value_name = "PX", default_value_t = TrainingSettings::default().side, value_parser = sides())]
    pub(crate) patch: usize,
    /// Number of response levels from dark to bright, 1 to 256
    #[arg(long, value_name = "N", default_value_t = TrainingSettings::default().levels, value_parser = levels, allow_negative_numbers = true)]
    pub(crate) levels: usize,
    /// Spacing of the response levels
    #[arg(long, default_value = word_of(&LEVEL_RULES, &TrainingSettings::default().level_rule), value_parser = choice(&LEVEL_RULES))]
    pub(crate) level_rule: LevelRule,
    /// Texture classes of patches
    #[arg(long, default_value = word_of(&TEXTURES, &TrainingSettings::default().textures), value_parser = choice(&TEXTURES))]
    pub(crate) textures: Textures,
    /// Solver of the kernels
    #[arg(long, value_enum, default_value_t = SolverName::Wiener)]
    pub(crate) solver: SolverName,
    /// Weight of noise relative to blur in flat patches: luminance,chrominance (implies --solver perceptual) [default: 16,4]
    #[arg(long, value_name = "L,C", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) alpha_flat: Option<Alpha>,
    /// Weight of noise relative to blur in textured patches: luminance,chrominance (implies --solver perceptual) [default: 1,4]
    #[arg(long, value_name = "L,C", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) alpha_texture: Option<Alpha>,
    /// Learn kernels without an offset, so that the picture scales with the light
    #[arg(long)]
    pub(crate) linear: bool,
    /// Do not share data between positions that are equivalent by a symmetry of the mosaic
    #[arg(long)]
    pub(crate) no_symmetry: bool,
    /// Share of the neighbouring levels in each kernel, from 0 (none) to 1
    #[arg(long, value_name = "SHARE", default_value_t = Training::default().smoothing, value_parser = share, allow_negative_numbers = true)]
    pub(crate) smoothing: f64,
    /// What a learned pipeline may spend on a picture
    #[arg(long, default_value = word_of(&QUALITIES, &Training::default().quality), value_parser = choice(&QUALITIES))]
    pub(crate) quality: Quality,
    /// Also learn to correct the blur of the lens
    #[arg(long)]
    pub(crate) sharp: bool,
}

const LEVEL_RULES: [Choice<LevelRule>; 2] = [
    ("logarithmic", "Equal ratios", LevelRule::Logarithmic),
    ("noise-steps", "Equal multiples of the noise", LevelRule::NoiseSteps),
];

pub(crate) const QUALITIES: [Choice<Quality>; 2] = [
    ("fast", "One stage: a kernel on the patch around each pixel", Quality::Fast),
    ("best", "A second stage refines the picture with its surroundings of up to 37 pixels", Quality::Best),
];

const TEXTURES: [Choice<Textures>; 3] = [
    ("none", "One class for each level", Textures::None),
    ("flat-texture", "Flat and texture", Textures::FlatTexture),
    ("oriented", "Flat, texture and edges of four directions", Textures::Oriented),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SolverName {
    /// Least mean square error under the noise of the sensor, which is computed from the camera
    Wiener,
    /// Noise weighted against blur in luminance and chrominance
    Perceptual,
    /// Ridge regression with the strength that generalised cross-validation selects
    Ridge,
    /// Least squares without noise, for bright scenes
    LeastSquares,
}

/// Parses the side of a patch.
fn sides() -> impl TypedValueParser<Value = usize> {
    PossibleValuesParser::new(["3", "5", "7", "9", "11"]).try_map(|side| side.parse::<usize>())
}

/// Parses a number of levels.
fn levels(text: &str) -> Result<usize, String> {
    let number: Option<usize> = text.trim().parse().ok();
    number.filter(|n| (1..=256).contains(n)).ok_or_else(|| "expected a whole number from 1 to 256".into())
}

/// Parses two numbers such as `16,4`.
fn pair(text: &str) -> Result<Alpha, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|p| p.trim().parse().ok()).collect();
    let numbers = numbers.unwrap_or_default();
    match numbers[..] {
        [luminance, chrominance] if numbers.iter().all(|a| (0.0..=1e6).contains(a)) => {
            Ok(Alpha { luminance, chrominance })
        }
        _ => Err("expected two numbers from 0 to 1e6, luminance,chrominance, such as 16,4".into()),
    }
}

impl LearningOptions {
    /// What an experiment with these options draws on.
    pub(crate) fn resources<'a>(&self, store: &'a Cache, progress: &'a Progress) -> Resources<'a> {
        Resources {
            store,
            training_scenes: self.training_set.stored(),
            progress,
            memory_bytes: memory::available_bytes(),
        }
    }

    /// The settings of classes and training pairs.
    pub(crate) fn settings(&self, seed: u64) -> TrainingSettings {
        TrainingSettings {
            side: self.patch,
            levels: self.levels,
            level_rule: self.level_rule,
            textures: self.textures,
            sharp: self.sharp,
            seed,
            ..TrainingSettings::default()
        }
    }

    /// The settings of the solver.
    pub(crate) fn training(&self) -> Training {
        let default = PerceptualWeights::default();
        let weights = PerceptualWeights {
            flat: self.alpha_flat.unwrap_or(default.flat),
            texture: self.alpha_texture.unwrap_or(default.texture),
        };
        Training {
            solver: match self.solver {
                // Either weight implies the perceptual solver.
                _ if self.alpha_flat.is_some() || self.alpha_texture.is_some() => Solver::Perceptual(weights),
                SolverName::Perceptual => Solver::Perceptual(weights),
                SolverName::Wiener => Solver::Wiener,
                SolverName::Ridge => Solver::Ridge,
                SolverName::LeastSquares => Solver::LeastSquares,
            },
            kernel: if self.linear { KernelForm::Linear } else { KernelForm::Affine },
            symmetry: !self.no_symmetry,
            smoothing: self.smoothing,
            quality: self.quality,
            ..Training::default()
        }
    }
}
