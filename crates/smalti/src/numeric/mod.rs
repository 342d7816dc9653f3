//! Arithmetic that knows nothing of light: image planes, random numbers, Fourier transforms, least squares.

pub mod fft;
pub mod philox;
mod planes;

pub use planes::{Planes, ShapeError};
