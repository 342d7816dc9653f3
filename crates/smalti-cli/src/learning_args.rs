//! How pipelines are learned, as typed.

use clap::{Args, ValueEnum};
use smalti::camera::{LevelRule, TrainingSettings};
use smalti::l3::{Alpha, KernelForm, PerceptualWeights, Solver, Textures, Training};

/// How pipelines are learned.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Learning")]
pub(crate) struct LearningOptions {
    /// Side of the patch around a pixel that its colour is computed from
    #[arg(long, value_name = "PX", default_value = "5", value_parser = ["3", "5", "7", "9", "11"])]
    pub(crate) patch: String,
    /// Number of response levels, dark to bright, 1 to 256
    #[arg(long, value_name = "N", default_value_t = TrainingSettings::default().levels, value_parser = levels, allow_negative_numbers = true)]
    pub(crate) levels: usize,
    /// How levels are spaced
    #[arg(long, value_enum, default_value_t = LevelCuts::Logarithmic)]
    pub(crate) level_rule: LevelCuts,
    /// What is told apart by the structure within a patch
    #[arg(long, value_enum, default_value_t = Structure::Oriented)]
    pub(crate) textures: Structure,
    /// How kernels are found from the statistics
    #[arg(long, value_enum, default_value_t = SolverName::Wiener)]
    pub(crate) solver: SolverName,
    /// Weight of noise against blur in flat patches: luminance,chrominance (means --solver perceptual) [default: 16,4]
    #[arg(long, value_name = "L,C", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) alpha_flat: Option<Alpha>,
    /// Weight of noise against blur in textured patches: luminance,chrominance (means --solver perceptual) [default: 1,4]
    #[arg(long, value_name = "L,C", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) alpha_texture: Option<Alpha>,
    /// Kernels without an offset: the picture scales with the light
    #[arg(long)]
    pub(crate) linear: bool,
    /// Do not share data between positions that symmetry of the mosaic makes equal
    #[arg(long)]
    pub(crate) no_symmetry: bool,
    /// Mix kernels with those of the neighbouring levels, 0 (not) to 1
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share, allow_negative_numbers = true)]
    pub(crate) smoothing: f64,
    /// Learn to undo the blur of the lens
    #[arg(long)]
    pub(crate) sharp: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LevelCuts {
    /// In equal ratios
    Logarithmic,
    /// In equal steps of the noise
    NoiseSteps,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Structure {
    /// Nothing: one class for each level
    None,
    /// Flat and texture
    FlatTexture,
    /// Flat, texture and four directions of edges
    Oriented,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SolverName {
    /// Least mean square error under the sensor's noise, which is computed from the camera
    Wiener,
    /// Noise weighted against blur in luminance and chrominance
    Perceptual,
    /// Small weights are preferred, as strongly as generalised cross-validation finds
    Ridge,
    /// Least square error without noise: for bright scenes
    LeastSquares,
}

/// A number of levels.
fn levels(text: &str) -> Result<usize, String> {
    let number: Option<usize> = text.trim().parse().ok();
    number.filter(|n| (1..=256).contains(n)).ok_or_else(|| "expected a whole number, 1 to 256".into())
}

/// A number from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.trim().parse().ok();
    number.filter(|v| (0.0..=1.0).contains(v)).ok_or_else(|| "expected a number from 0 to 1".into())
}

/// Two numbers, `16,4`.
fn pair(text: &str) -> Result<Alpha, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|p| p.trim().parse().ok()).collect();
    let numbers = numbers.unwrap_or_default();
    match numbers[..] {
        [luminance, chrominance] if numbers.iter().all(|a| (0.0..=1e6).contains(a)) => {
            Ok(Alpha { luminance, chrominance })
        }
        _ => Err("expected two numbers of 0 to 1e6, luminance,chrominance, such as 16,4".into()),
    }
}

impl LearningOptions {
    /// What classes and pairs are made by.
    pub(crate) fn settings(&self, seed: u64) -> TrainingSettings {
        TrainingSettings {
            side: self.patch.parse().unwrap_or(5),
            levels: self.levels,
            level_rule: match self.level_rule {
                LevelCuts::Logarithmic => LevelRule::Logarithmic,
                LevelCuts::NoiseSteps => LevelRule::NoiseSteps,
            },
            textures: match self.textures {
                Structure::None => Textures::None,
                Structure::FlatTexture => Textures::FlatTexture,
                Structure::Oriented => Textures::Oriented,
            },
            sharp: self.sharp,
            seed,
            ..TrainingSettings::default()
        }
    }

    /// What kernels are solved by.
    pub(crate) fn training(&self) -> Training {
        let default = PerceptualWeights::default();
        let weights = PerceptualWeights {
            flat: self.alpha_flat.unwrap_or(default.flat),
            texture: self.alpha_texture.unwrap_or(default.texture),
        };
        Training {
            solver: match self.solver {
                // Weights that were typed are meant.
                _ if self.alpha_flat.is_some() || self.alpha_texture.is_some() => Solver::Perceptual(weights),
                SolverName::Perceptual => Solver::Perceptual(weights),
                SolverName::Wiener => Solver::Wiener,
                SolverName::Ridge => Solver::Ridge,
                SolverName::LeastSquares => Solver::LeastSquares,
            },
            kernel: if self.linear { KernelForm::Linear } else { KernelForm::Affine },
            symmetry: !self.no_symmetry,
            smoothing: self.smoothing,
            ..Training::default()
        }
    }
}
