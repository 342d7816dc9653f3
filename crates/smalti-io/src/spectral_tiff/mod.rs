//! TIFF that holds a spectrum: a band for each image of the file, or for each sample of a pixel.

mod directory;
mod page;
mod read;
mod write;

pub use read::{from_bytes, is_spectral, open, read};
pub use write::{Layout, WriteOptions, write};
