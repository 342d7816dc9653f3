//! MATLAB: scenes of ISETCam, and cubes of data sets, in MAT-files of level 5 and of version 7.3.

mod content;
#[cfg(test)]
mod tests;
mod v5;
#[cfg(feature = "hdf5")]
mod v73;

use std::path::Path;
use std::sync::Arc;

use self::v5::read::{FORMAT, is_level_5};
use crate::file::at_most;
use crate::raster::{FileSource, Shared, bytes_at};
use crate::scene_file::tiles::{Tiles, load};
use crate::variables::{self, Reading};
use crate::{IoError, ReadOptions, SpectralFile, hdf5, write as whole};

/// A version of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Version {
    /// Level 5, which every program reads; variables up to 2 GiB.
    #[default]
    V5,
    /// Version 7.3, of any size: HDF5.
    V73,
}

/// A spectral image from a MAT-file of level 5 (`-v6`, `-v7`) or of version 7.3, which its first bytes identify.
///
/// A scene of ISETCam is photons s⁻¹ m⁻² sr⁻¹ nm⁻¹, whether it is stored as the struct `scene`, as `photons` with `wave`, or
/// as `mcCOEF` with `basis`; its illuminant, distance and field of view are taken where the file has them. For other files the
/// rules are those of [`hdf5::open`].
///
/// A compressed variable of level 5 is one stream and is unpacked at once.
///
/// # Errors
/// As [`hdf5::open`]; files of level 4, which hold no cubes, are refused.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Box<dyn Tiles>, IoError> {
    from_source(Arc::new(FileSource::open(path)?), Reading { path, options })
}

/// As [`open`] and [`load`], from memory; `path` is only named.
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    load(&from_source(Arc::new(bytes.to_vec()), Reading { path, options })?, path, options)
}

fn from_source(source: Shared<'static>, of: Reading<'_>) -> Result<Box<dyn Tiles>, IoError> {
    let path = of.path;
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    let start = bytes_at(&*source, 0, source.len().min(520), "the header", path)?;
    if start.get(512..) == Some(HDF5) || start.starts_with(HDF5) {
        return hdf5::from_source(source, of);
    }
    if let Some(big_endian) = is_level_5(&start) {
        return variables::open(&v5::read::open(source, big_endian, path, of.options.limits)?, of);
    }
    // Files of level 4 begin with a small number, whose bytes include a zero; text does not.
    if start.len() >= 20 && start.iter().take(4).any(|&b| b == 0) {
        let (path, found, expected) =
            (path.to_owned(), "4".into(), "5 or 7.3, which hold arrays of three axes,".into());
        return Err(IoError::Version { path, format: FORMAT, found, expected });
    }
    Err(IoError::unknown(path, "a MAT-file of level 5 or version 7.3"))
}

/// Writes photons as a struct `scene` that ISETCam loads (`sceneFromFile`, `load`), other quantities as `cube` (single
/// precision) and `bands` (nm). Where the distance or the field of view is not known, those of ISETCam are written to the scene
/// (1.2 m, 10°). The variable `comment` has as JSON what else is known, so that a file reads back as it was.
///
/// # Errors
/// [`IoError::TooLarge`] where a variable is larger than level 5 can hold; when the file cannot be written.
pub fn write(path: &Path, file: &SpectralFile, version: Version) -> Result<(), IoError> {
    let variables = content::of(file);
    match version {
        #[cfg(feature = "hdf5")]
        Version::V73 => v73::write(path, &variables),
        #[cfg(not(feature = "hdf5"))]
        Version::V73 => Err(hdf5::refused(path)),
        Version::V5 => {
            let what = "the scene in a MAT-file of level 5 (version 7.3 holds it)";
            at_most(v5::write::LARGEST, path, what, v5::write::largest(&variables))?;
            whole::stream(path, |out| v5::write::write(out, &variables))
        }
    }
}
