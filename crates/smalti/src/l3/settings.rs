//! How kernels are learned: the solver, the form of kernels, what a class needs.

use serde::{Deserialize, Serialize};

use super::L3Error;
use super::error::within;

/// Largest weight of the variance.
const MAX_ALPHA: f64 = 1e6;

/// How kernels are learned from [`Statistics`](super::Statistics).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct Training {
    /// What kernels minimise.
    pub solver: Solver,
    /// Whether kernels have an offset.
    pub kernel: KernelForm,
    /// Classes that are equivalent under rotations and reflections of the mosaic share their patches. Symmetries are sought in
    /// tiles of up to 4096 cells.
    pub symmetry: bool,
    /// Patches that a class needs to have kernels of its own. `None`: ten for each tap of the patch.
    pub least_patches: Option<u64>,
    /// Share of all patches, 0 to 1, that a combination of clipped channels needs for a place on the axis of
    /// saturation. Patches of rarer ones count to the nearest combination, as in rendering.
    pub saturation_share: f64,
    /// Weight, 0 to 1, with which the learned kernels of the levels next to a class are mixed into its own, besides the number of their
    /// patches. 0: each level for itself.
    pub smoothing: f64,
    /// How much work the pipeline may do for a picture.
    pub quality: Quality,
}

/// How much work a pipeline may do for a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Quality {
    /// One stage: a kernel on the patch around each pixel.
    #[default]
    Fast,
    /// A second stage refines the picture with structure and colour from up to 37 pixels around ([`super::Refinement`]).
    Best,
}

impl Quality {
    /// Both, in order.
    pub const ALL: [Self; 2] = [Self::Fast, Self::Best];

    /// Its name in options and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Best => "best",
        }
    }
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
            quality: Quality::default(),
        }
    }
}

/// The criterion that kernels minimise. C is the covariance of the patches of a class (second moments about zero for linear
/// kernels), c their covariance with an output, and Σ the covariance of the noise ([`super::Axes::noise`]) at the mean signals
/// of the class.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// Squared error over the patches without added noise: C⁻¹ c, or the solution of least norm for a singular C.
    LeastSquares,
    /// Squared error over the patches without added noise plus λ times the squared weights: (C + λ)⁻¹ c. Generalised
    /// cross-validation ([golub1979]) chooses λ for each class and output.
    ///
    /// [golub1979]: https://doi.org/10.1080/00401706.1979.10489751
    Ridge,
    /// Squared error under noise: (C + Σ)⁻¹ c. Statistics of noisy images already include Σ. This default has the least colour
    /// difference of all weights of the noise, in CIEDE2000 and in S-CIELAB.
    #[default]
    Wiener,
    /// bias² + α · variance in an opponent colour space: (C + α Σ)⁻¹ c for each of its coordinates, as in the slides of L³
    /// (l3slides2014 in REFERENCES.bib).
    ///
    /// The space is that of S-CIELAB, a fit to the separability of contrast sensitivity into pattern and colour ([poirson1993],
    /// [zhang1997]), computed from X, Y, Z of the 2° observer. Outputs other than `X`, `Y` and `Z`, and all outputs when one of
    /// these is missing, are solved as by [`Solver::Wiener`].
    ///
    /// [poirson1993]: https://doi.org/10.1364/JOSAA.10.002458
    /// [zhang1997]: crate::color::scielab
    Perceptual(PerceptualWeights),
}

/// The weight α of the variance against bias² in luminance and in the two chrominances, 0 to 10⁶. Values above 1 reduce noise
/// further than least squared error does, at the cost of sharpness in luminance and of saturation in chrominance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Alpha {
    /// α_L.
    pub luminance: f64,
    /// α_C, for red-green and for blue-yellow.
    pub chrominance: f64,
}

/// Weights for flat patches and for all others. The defaults are those of the slides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PerceptualWeights {
    /// For flat patches.
    pub flat: Alpha,
    /// For texture and edges, and for all patches without texture classes.
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
    pub(super) fn validate(&self) -> Result<(), L3Error> {
        within("saturation_share", self.saturation_share, 0.0..=1.0, "0 to 1")?;
        within("smoothing", self.smoothing, 0.0..=1.0, "0 to 1")?;
        if let Solver::Perceptual(PerceptualWeights { flat, texture }) = self.solver {
            for alpha in [flat.luminance, flat.chrominance, texture.luminance, texture.chrominance] {
                within("α", alpha, 0.0..=MAX_ALPHA, "0 to 1000000")?;
            }
        }
        Ok(())
    }
}
