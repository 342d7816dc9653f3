//! HDF5: any cube with its wavelengths, by way of the crate `hdf5-pure`, which needs no C library. That crate reads the
//! structure of a file and writes files; numbers are read here, several chunks at once, straight into planes.
//!
//! Without the feature `hdf5`, every file in this format is refused.

#[cfg(not(feature = "hdf5"))]
mod absent;
#[cfg(feature = "hdf5")]
mod octave;
#[cfg(feature = "hdf5")]
mod tree;
#[cfg(feature = "hdf5")]
mod write;

use std::path::Path;
use std::sync::Arc;

#[cfg(not(feature = "hdf5"))]
pub use absent::write;
#[cfg(not(feature = "hdf5"))]
pub(crate) use absent::{from_source, refused};
#[cfg(feature = "hdf5")]
pub(crate) use tree::from_source;
#[cfg(feature = "hdf5")]
pub(crate) use write::unwritten;
#[cfg(feature = "hdf5")]
pub use write::write;

use crate::raster::FileSource;
use crate::scene_file::tiles::{Tiles, load};
use crate::variables::Reading;
use crate::{IoError, ReadOptions, SpectralFile};

/// A spectral image from an HDF5 file. `docs/formats-scenes.md` describes which dataset is taken for the cube and for its wavelengths.
///
/// The values are those of the file. Their quantity is assumed from the name of the dataset, unless `options` states it:
/// reflectance for `img\` and `img` (KAUST), relative energy for all others.
///
/// Chunks are read whole; those with other filters than shuffle and deflate are unpacked at once.
///
/// # Errors
/// When the file cannot be read, is no HDF5, has no cube or several without a name of one in `options`, or states no
/// wavelengths or such as are not ascending nm.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Box<dyn Tiles>, IoError> {
    from_source(Arc::new(FileSource::open(path)?), Reading { path, options })
}

/// As [`open`] and [`load`], from memory; `path` is only named.
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    load(&from_source(Arc::new(bytes.to_vec()), Reading { path, options })?, path, options)
}
