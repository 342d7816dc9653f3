//! TIFF that holds a spectrum: a band for each image of the file, or for each sample of a pixel.

mod read;
mod write;

pub use read::{from_bytes, is_spectral, open};
pub use write::{Layout, WriteOptions, write};
