//! L³: an image pipeline that is local, linear and learned, for any mosaic ([tian2014], [lansel2014]).
//!
//! Every pixel of a raw image is classified by the patch around it: its position in the tile of the mosaic, the response
//! level, the clipped channels, and the texture ([`Axes`]). Each class has a learned linear transform from the patch to the
//! output, which combines demosaicking, denoising, colour and illuminant correction. Training uses pairs of a raw image and
//! its target picture, simulated or real:
//!
//! 1. [`Statistics`] accumulate moments of patch and target per class, in one pass and in constant memory;
//! 2. [`Training`] solves them for the kernels, with the noise of the sensor added analytically;
//! 3. [`Pipeline`], the learned table, renders raw images ([`crate::isp::Isp`]). With [`Quality::Best`] a second stage
//!    ([`Refinement`]) refines the picture with what lies beyond the patch.
//!
//! [tian2014]: https://doi.org/10.1117/12.2042565
//! [lansel2014]: https://purl.stanford.edu/cp866wz8098

mod axes;
mod blocks;
mod class_map;
mod classify;
mod error;
mod even_field;
mod fallback;
mod gather;
mod lattice;
mod learner;
mod levels;
mod moments;
mod multiply_adds;
mod orientation;
mod pair;
mod pipeline;
mod pools;
mod refine;
mod registration;
mod render;
mod settings;
mod solve;
mod solved;
mod statistics;
mod summary;
mod symmetry;
mod train;
mod vectors;
mod window;

pub(crate) use class_map::ClassMap;
pub(crate) use pipeline::nearest_saturation;
pub(crate) use pools::saturation_axis;
pub(crate) use solved::{
    ClassPool, PatchCounts, PoolKernels, PoolSource, Solved, Turn, needed_pools, representatives, turns,
};

pub use axes::{Axes, ClassKey, MAX_SIDE, Textures};
pub use error::L3Error;
pub use even_field::EvenField;
pub use lattice::ContrastPairs;
pub use learner::{Learner, SecondStage};
pub use levels::Levels;
pub use moments::Moments;
pub use multiply_adds::MultiplyAdds;
pub use pair::{Pair, Share, Tiles};
pub use pipeline::{Class, Kernels, Origin, Pipeline, PipelineParts};
pub use refine::{
    FixedRefinement, Polynomial, REFINEMENT_CORRECTED_REACH, REFINEMENT_INPUTS, REFINEMENT_LANES,
    REFINEMENT_LINEAR_INPUTS, REFINEMENT_RENDERING_REVISION, REFINEMENT_REVISION, REFINEMENT_RGB_FROM_XYZ,
    Refinement, RefinementAxes, RefinementClass, RefinementPicture, RefinementSamples, RefinementStatistics,
};
pub use registration::{
    Aligned, GOOD_CORRELATION, GOOD_RESIDUAL_PX, MIN_CORRELATION, MIN_SIDE, RESOLVED_SHIFT_PX, Registration,
    RegistrationError,
};
pub use render::{FixedKernels, FixedRenderer, OutsideCounts, Rendered, Renderer, peak_ratio_db};
pub use settings::{Alpha, KernelForm, PerceptualWeights, Quality, Solver, Training};
pub use statistics::{Statistics, ensure_mosaic_of};
pub use summary::{PositionSummary, Summary};
pub use train::REVISION;
