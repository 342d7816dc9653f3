//! What stands for HDF5 in a build without it.

use std::path::Path;

use crate::raster::Shared;
use crate::scene_file::tiles::Tiles;
use crate::variables::Reading;
use crate::{IoError, SpectralFile};

pub(crate) fn from_source(_: Shared<'static>, of: Reading<'_>) -> Result<Box<dyn Tiles>, IoError> {
    Err(refused(of.path))
}

/// # Errors
/// Always.
pub fn write(path: &Path, _: &SpectralFile) -> Result<(), IoError> {
    Err(refused(path))
}

pub(crate) fn refused(path: &Path) -> IoError {
    IoError::LeftOut { path: path.to_owned(), format: "HDF5 and MAT-files of version 7.3", feature: "hdf5" }
}
