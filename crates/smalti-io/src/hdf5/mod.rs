//! HDF5: any cube with its wavelengths, by way of the crate `hdf5-pure`, which needs no C library. That crate reads the
//! structure of a file and writes files; numbers are read here, several chunks at once, straight into planes.

mod octave;
mod tree;

use std::path::Path;
use std::sync::Arc;

use hdf5_pure::{AttrValue, FileBuilder};

pub(crate) use tree::FORMAT;

use crate::file::guarded;
use crate::raster::{FileSource, Shared};
use crate::scene_file::facts::Comment;
use crate::scene_file::tiles::{Tiles, load};
use crate::variables::{self, Reading};
use crate::{IoError, ReadOptions, SpectralFile, write as whole};

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

pub(crate) fn from_source(source: Shared<'static>, of: Reading<'_>) -> Result<Box<dyn Tiles>, IoError> {
    guarded(of.path, FORMAT, || variables::open(&tree::open(source, of.path, of.options.limits)?, of))
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

/// The message of the encoder, as an error of writing.
pub(crate) fn unwritten(path: &Path, error: impl std::error::Error + Send + Sync + 'static) -> IoError {
    IoError::writing(path)(std::io::Error::other(error))
}
