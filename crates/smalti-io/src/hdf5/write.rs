//! Writing HDF5.

use std::path::Path;

use hdf5_pure::{AttrValue, FileBuilder};

use crate::scene_file::facts::Comment;
use crate::{IoError, SpectralFile, write as whole};

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
