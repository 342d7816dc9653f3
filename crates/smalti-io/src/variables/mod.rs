//! Files that hold named arrays, texts and structs of them.

mod array;
mod coefficients;
mod datasets;
mod fields;
mod isetcam;
mod wavelengths;

#[cfg(feature = "hdf5")]
pub(crate) use array::Chunks;
pub(crate) use array::{Array, Axes, Layout};

pub(crate) use fields::{Attribute, Fields, Numbers, Reading, Value};
use fields::{at, bands, numbers_at, placed, text_at};

use crate::IoError;
use crate::scene_file::tiles::Tiles;

/// A spectral image among the variables of a file: a scene of ISETCam, the cube of a known data set, or the only cube
/// there is. Its samples are read as they are needed.
pub(crate) fn open(fields: &dyn Fields, of: Reading<'_>) -> Result<Box<dyn Tiles>, IoError> {
    if let Some(place) = &of.options.variable {
        if let Some(Value::Fields(scene)) = at(fields, place)? {
            return isetcam::scene_struct(&*scene, of, None);
        }
    } else if let Some(file) = isetcam::find(fields, of)? {
        return Ok(file);
    }
    datasets::open(fields, of)
}
