//! L³: an image pipeline that is local, linear and learned, for any mosaic ([tian2014], [lansel2014]).
//!
//! Every pixel of a raw image is put into a class by the patch around it: the pixel's place in the mosaic's tile, the
//! level of the response, the channels that are clipped, flat or texture ([`Axes`]). Each class has a learned linear
//! transform from the patch to the output, so that demosaicking, denoising, colour and illuminant correction are one
//! step. What is learned from are pairs of a raw image and the picture that should come of it, simulated or real:
//!
//! 1. [`Statistics`] gather moments of patch and target per class, in one pass, in memory that does not grow;
//! 2. [`Training`] solves them for the kernels, with the noise of the sensor added by computation;
//! 3. [`Pipeline`], the learned table, renders raw images ([`crate::isp::Isp`]).
//!
//! [tian2014]: https://doi.org/10.1117/12.2042565
//! [lansel2014]: https://purl.stanford.edu/cp866wz8098

mod axes;
mod blocks;
mod classify;
mod error;
mod fallback;
mod gather;
mod lattice;
mod levels;
mod moments;
mod orientation;
mod pipeline;
mod pools;
mod registration;
mod render;
mod solve;
mod statistics;
mod summary;
mod symmetry;
mod train;
mod window;

pub use axes::{Axes, ClassKey, MAX_SIDE, Textures};
pub use error::L3Error;
pub use lattice::ContrastPairs;
pub use levels::Levels;
pub use moments::Moments;
pub use pipeline::{Class, Kernels, Origin, Pipeline, PipelineParts};
pub use registration::{
    Aligned, GOOD_CORRELATION, GOOD_RESIDUAL_PX, LEAST_CORRELATION, LEAST_SIDE, RESOLVED_SHIFT_PX,
    Registration, RegistrationError,
};
pub use render::{FixedKernels, FixedRenderer, Outside, Rendered, Renderer, peak_ratio_db};
pub use statistics::{Pair, Statistics};
pub use summary::{PositionSummary, Summary};
pub use train::{Alpha, KernelForm, PerceptualWeights, Solver, Training};
