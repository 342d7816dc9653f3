//! Arithmetic without optics: image planes and rectangles, random numbers, Fourier transforms, least squares.

pub(crate) mod dense;
pub mod elementary;
pub mod fft;
pub mod least_squares;
pub(crate) mod mirror;
pub mod normal;
pub mod philox;
mod planes;
pub mod poisson;
mod rect;
pub(crate) mod simd;

pub use planes::{Planes, ShapeError};
pub use rect::Rect;
