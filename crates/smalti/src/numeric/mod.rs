//! Arithmetic without optics: image planes and rectangles, random numbers, Fourier transforms, least squares.

pub(crate) mod arithmetic;
pub(crate) mod bloomfield_steiger1980;
pub mod bootstrap;
pub(crate) mod crossing;
pub(crate) mod dense;
pub mod elementary;
pub mod fft;
mod first_invalid;
pub(crate) mod halving_filter;
pub mod least_squares;
pub(crate) mod mirror;
pub mod normal;
pub(crate) mod orthonormal;
mod out_of_range;
pub mod philox;
pub(crate) mod plane_filter;
mod planes;
pub mod poisson;
pub(crate) mod products;
mod rect;
pub(crate) mod simd;
pub mod simultaneous;
mod transpose;

pub use arithmetic::arithmetic;
pub(crate) use first_invalid::first_invalid;
pub use out_of_range::OutOfRange;
pub(crate) use out_of_range::{Number, require};
pub(crate) use planes::bands_of;
pub use planes::{Planes, ShapeError};
pub use rect::Rect;
