//! Statistics of the light of the training scene, from which the pipeline of any design is learned without its patches.
//!
//! A patch of noise-free samples is x = A u: the coefficients u of the light on its pixels in a few spectral components
//! ([`PixelLight`]), and the linear map A of the filters. The moments of x and of the target follow from those of u, which no
//! filter changes. [`ClassLight`] holds the moments of u for each class of patches. The classes are those that a *neutral array*
//! sees, whose mosaic is that of the design and whose filters are all clear: they depend on the translations of the mosaic,
//! between whose samples contrast and orientation are measured, but not on the filters.
//!
//! Every pixel of the scene belongs to the patches of every position of the tile, whereas a capture shows each pixel at one
//! position. Kernels are therefore learned from as many times more patches as the tile has cells. Which classes have kernels of their
//! own is decided by the number of patches that a capture would show.

mod gather;
// Indices that several arrays share read better than zipped iterators, and become vector code.
#[allow(clippy::needless_range_loop)]
mod kernel;
mod saturated;
mod saturated_moments;
mod statistics;
#[cfg(test)]
mod tests;

pub(super) use kernel::{EvenPatches, LightSystem};
pub(super) use saturated::BrightScene;
pub(super) use saturated_moments::Saturated;
pub(super) use statistics::ClassLight;
