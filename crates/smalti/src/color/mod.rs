//! Colour: tristimulus values, uniform colour spaces, colour differences, adaptation, display spaces, S-CIELAB.

mod image;

pub use image::{ColorSpace, Image, ImageError};
