//! TIFF 6.0 and BigTIFF: directories of fields, strips and tiles of samples. DNG, spectral TIFF and pictures share them.

mod directory;
mod samples;
pub(crate) mod tags;
mod write;

pub(crate) use directory::{Directory, Images};
pub(crate) use samples::cube;
pub(crate) use write::{Fields, Value, directory, write_header};

#[cfg(test)]
mod tests;
