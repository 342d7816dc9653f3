//! The second stage of a pipeline of best quality: it refines the picture that the first stage renders.
//!
//! A patch of a raw image is small and noisy. Its class follows the noise, and no kernel can average over more pixels than the patch has.
//! The second stage reads the picture of the first one, which has all colours at every pixel, so that neither classes nor kernels
//! depend on the mosaic:
//!
//! 1. [`stages`] smooths the picture five times, over neighbours 1, 2, 4, 8 and 16 pixels away, without the neighbours whose colours
//!    differ by more than the noise ([dammertz2010]). Edges stay, and flat areas become means over 63 × 63 pixels. The last two pictures have every
//!    second row and column.
//! 2. [`classes`] classifies every pixel by brightness and by the structure tensor of the first of these pictures, relative to the noise.
//! 3. The output is linear in the pixel's neighbourhood in the picture, in the five smooth colours and in roots of products of the channels of
//!    one of them, which correct what is not linear in colour ([`inputs`], [`roots`], [`products`]). The kernels of each class minimise the squared error over the training pictures, in closed form from streamed moments ([`RefinementStatistics`]).
//!    In uniform areas they pass on no pattern with the period of the mosaic's tile ([`tile_pattern`]).
//! 4. [`highlights`] corrects pixels beside light that is many times as bright, and compares their Y with the [`samples`] of the raw image.
//!
//! [dammertz2010]: https://doi.org/10.2312/EGGH/HPG10/067-075

mod axes;
mod classes;
mod fixed;
mod highlights;
mod inputs;
mod layout;
mod pictures;
mod polynomial;
mod products;
mod refinement;
mod roots;
mod samples;
mod stages;
mod statistics;
mod strips;
#[cfg(test)]
mod tests;
mod tile_pattern;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use axes::RefinementAxes;
pub use fixed::FixedRefinement;
pub use pictures::{REFINEMENT_LANES, RefinementPicture};
pub use polynomial::Polynomial;
pub use refinement::{REFINEMENT_INPUTS, REFINEMENT_LINEAR_INPUTS, Refinement, RefinementClass};
pub use roots::REFINEMENT_RGB_FROM_XYZ;
pub use samples::RefinementSamples;
pub use statistics::{REFINEMENT_REVISION, RefinementStatistics};

pub(super) use pictures::multiply_adds;

/// Revision of the pictures that the second stage renders with given kernels. Scores in a cache depend on it as well as on [`REFINEMENT_REVISION`], kernels do not.
pub const REFINEMENT_RENDERING_REVISION: u32 = 7;
/// Distance of the farthest pixel of the picture of the first stage on which an output depends.
pub(super) const REACH: usize = stages::REACH + highlights::REACH;
/// Distance, in rows and columns, of the farthest pixel of the refined picture on which the correction beside highlights depends.
pub const REFINEMENT_CORRECTED_REACH: usize = highlights::REACH;
