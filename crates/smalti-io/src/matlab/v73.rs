//! Writing MAT-files of version 7.3: HDF5 with a block for MATLAB before it and attributes that name its classes.

use std::path::Path;

use hdf5_pure::mat::{MatBuilder, MatError, Options, StructWriter};

use super::content::{Item, column_major};
use crate::hdf5::unwritten;
use crate::{IoError, write as whole};

/// Writes a file.
pub(super) fn write(path: &Path, variables: &[(&str, Item)]) -> Result<(), IoError> {
    let mut builder = MatBuilder::new(Options::default());
    for (name, item) in variables {
        variable(&mut builder, name, item).map_err(|e| unwritten(path, e))?;
    }
    whole::atomic(path, |out| builder.finish_to(out).map_err(|e| unwritten(path, e)))
}

fn variable(builder: &mut MatBuilder, name: &str, item: &Item) -> Result<(), MatError> {
    match item {
        Item::Cube(planes) => {
            let data: Vec<f32> = planes.planes().flat_map(|p| column_major(p, planes.rows())).collect();
            builder.write_f32(name, &[planes.rows(), planes.cols(), planes.count()], &data)?;
        }
        Item::Column(values) => {
            builder.write_f64(name, &[values.len(), 1], values)?;
        }
        Item::Text(text) => {
            builder.write_char(name, text)?;
        }
        Item::Struct(fields) => {
            builder.struct_(name, |writer: &mut StructWriter| {
                fields.iter().try_for_each(|(name, item)| variable(writer.builder(), name, item))
            })?;
        }
    }
    Ok(())
}
