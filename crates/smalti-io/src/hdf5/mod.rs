//! HDF5: any cube with its wavelengths, by way of the crate `hdf5-pure`, which needs no C library. That crate reads the
//! structure of a file and writes files; numbers are read here, several chunks at once, straight into planes.

mod octave;
mod tree;

use std::path::Path;
use std::sync::Arc;

use hdf5_pure::{AttrValue, FileBuilder};

use crate::file::guarded;
use crate::raster::{FileSource, Shared};
use crate::scene_file::facts::Comment;
use crate::scene_file::tiles::{Tiles, load};
use crate::{IoError, ReadOptions, SpectralFile, variables, write as whole};

/// How messages call the format.
pub(crate) const FORMAT: &str = "HDF5";

/// A spectral image from an HDF5 file. What is taken for the cube, and for its wavelengths, says `docs/formats-scenes.md`.
///
/// The values are those of the file. What they are is assumed from the name of the dataset, unless `options` says it:
/// reflectance for `img\` and `img` (KAUST), relative energy for all others.
///
/// # Errors
/// When the file cannot be read, is no HDF5, has no cube or several without a name of one in `options`, states no
/// wavelengths or such as are not ascending nm, has a NaN, infinite or negative value (with its band and pixel), or is
/// larger than the limits.
pub fn read(path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    load(&open(path, options)?, path, options)
}

/// As [`read`], samples to be read as they are needed, chunks whole; those under other filters than shuffle and deflate are
/// unpacked at once. Of the options, the part is not looked at.
///
/// # Errors
/// As [`read`], but for the samples.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Box<dyn Tiles>, IoError> {
    from_source(Arc::new(FileSource::open(path)?), path, options)
}

/// As [`read`], from memory; `path` is only named.
///
/// # Errors
/// As [`read`].
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    load(&from_source(Arc::new(bytes.to_vec()), path, options)?, path, options)
}

pub(crate) fn from_source(
    source: Shared<'static>,
    path: &Path,
    options: &ReadOptions,
) -> Result<Box<dyn Tiles>, IoError> {
    guarded(path, FORMAT, || {
        let root = tree::open(source, path, options.limits)?;
        variables::open(&root, path, options)
    })
}

/// Writes the datasets `cube` (bands × rows × columns, single precision) and `wavelengths` (nm), and in the attribute
/// `comment` of the cube what else is known, as JSON.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, file: &SpectralFile) -> Result<(), IoError> {
    let planes = file.cube.planes();
    let mut builder = FileBuilder::new();
    let text = |text: &str| AttrValue::VarLenString(text.to_owned());
    builder
        .create_dataset("cube")
        .with_f32_data(planes.data())
        .with_shape(&[planes.count() as u64, planes.rows() as u64, planes.cols() as u64])
        .set_attr("quantity", text(file.quantity.name()))
        .set_attr("comment", text(&serde_json::to_string(&Comment::of(file)).unwrap_or_default()));
    let nm: Vec<f64> = file.cube.grid().wavelengths_nm().collect();
    builder.create_dataset("wavelengths").with_f64_data(&nm).set_attr("units", text("nm"));
    whole::atomic(path, |out| builder.finish_to(out).map_err(|e| unwritten(path, e)))
}

/// What the encoder says, as an error of writing.
pub(crate) fn unwritten(path: &Path, error: impl std::error::Error + Send + Sync + 'static) -> IoError {
    IoError::Write { path: path.to_owned(), source: std::io::Error::other(error) }
}
