//! Colour: tristimulus values, uniform colour spaces, colour differences, adaptation, display spaces, S-CIELAB.
//!
//! Plain functions take `[f64; 3]`; pictures are [`Image`]s of `f32` planes, worked on in parallel with results
//! that do not depend on the number of threads.

pub mod adaptation;
pub mod cct;
pub mod cie1976;
mod convert;
pub mod difference;
pub mod display;
mod image;
pub mod jakob_hanika2019;
pub mod matrix;
pub mod scielab;

pub use adaptation::Adaptation;
pub use cie1976::{
    lab_from_xyz, luv_from_xyz, upvp_from_xyz, uv_from_xyz, xy_from_xyz, xyz_from_lab, xyz_from_xy,
};
pub use difference::{DeltaE, DifferenceMap};
pub use image::{ColorSpace, Image, ImageError};
