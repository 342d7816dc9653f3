//! OpenEXR: spectral images (two layouts) and RGB pictures.
//!
//! A spectral file seldom states everything that a scene needs. [`open`] returns the stated properties unchanged;
//! [`SpectralFile::into_scene`](crate::SpectralFile::into_scene) adds the rest.

mod blocks;
mod layout;
mod read;
mod rgb;
mod write;

pub use layout::Layout;
pub use read::{from_bytes, is_spectral, open};
pub(crate) use rgb::rgb_from_bytes;
pub use write::write;

#[cfg(test)]
mod tests;
