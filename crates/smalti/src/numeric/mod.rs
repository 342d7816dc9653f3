//! Arithmetic that knows nothing of light: image planes, random numbers, Fourier transforms, least squares.

pub mod elementary;
pub mod fft;
pub mod least_squares;
pub mod normal;
pub mod philox;
mod planes;
pub mod poisson;
pub(crate) mod simd;

pub use planes::{Planes, ShapeError};
