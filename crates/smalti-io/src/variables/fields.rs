//! Named arrays, texts and structs, and their attributes.

use std::path::Path;

use super::array::{Array, Axes, FORMAT};
use crate::scene_file::cube_file::CubeFile;
use crate::scene_file::facts::Facts;
use crate::scene_file::stated::Bands;
use crate::{IoError, Limits, Quantity, ReadOptions};

/// The file that is read, and how.
#[derive(Clone, Copy)]
pub(crate) struct Reading<'a> {
    pub(crate) path: &'a Path,
    pub(crate) options: &'a ReadOptions,
}

/// What a file or a struct holds, by name.
pub(crate) trait Fields {
    /// The names, in the order of the file.
    fn names(&self) -> Vec<String>;

    /// The value of a name.
    fn get(&self, name: &str) -> Result<Option<Value>, IoError>;
}

/// A named value.
pub(crate) enum Value {
    Numbers(Numbers),
    Text(String),
    Fields(Box<dyn Fields>),
    /// A value of another kind, in words.
    Other(&'static str),
}

/// An array and its attributes.
#[derive(Clone)]
pub(crate) struct Numbers {
    pub(crate) array: Array,
    /// Its axes are those of MATLAB (rows, columns, …, the fastest first), not those of C and Python.
    pub(crate) matlab: bool,
    pub(crate) attributes: Vec<(String, Attribute)>,
}

/// The attributes of an array.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Attribute {
    Text(String),
    Numbers(Vec<f64>),
}

impl Numbers {
    /// Its elements, if it is a list of at most so many as wavelengths can be.
    pub(crate) fn list(&self, name: &str, path: &Path, limits: Limits) -> Result<Vec<f64>, IoError> {
        const MAX_WAVELENGTHS: u64 = 1 << 16;
        let count = self.array.count();
        if count > MAX_WAVELENGTHS {
            return Err(IoError::field(
                path,
                name,
                format!("{count} numbers"),
                format!("at most {MAX_WAVELENGTHS}"),
            ));
        }
        self.array.numbers(path, limits)
    }

    /// Lengths of its axes without those that come to an end at one element, for a message.
    pub(crate) fn shape(&self) -> String {
        let mut dims: Vec<String> = self.array.dims.iter().map(usize::to_string).collect();
        if !self.matlab {
            dims.reverse();
        }
        dims.join(" × ")
    }
}

/// The value at a path, whose names are separated by dots or slashes.
pub(crate) fn at(fields: &dyn Fields, place: &str) -> Result<Option<Value>, IoError> {
    // A name may itself have such a character.
    if let Some(value) = fields.get(place)? {
        return Ok(Some(value));
    }
    let place = place.trim_start_matches('/');
    let Some((first, rest)) = place.split_once(['.', '/']) else { return fields.get(place) };
    match fields.get(first)? {
        Some(Value::Fields(inner)) => at(&*inner, rest),
        _ => Ok(None),
    }
}

/// The numbers at a path.
pub(crate) fn numbers_at(fields: &dyn Fields, place: &str) -> Result<Option<Numbers>, IoError> {
    Ok(match at(fields, place)? {
        Some(Value::Numbers(numbers)) => Some(numbers),
        _ => None,
    })
}

/// The text at a path.
pub(crate) fn text_at(fields: &dyn Fields, place: &str) -> Result<Option<String>, IoError> {
    Ok(match at(fields, place)? {
        Some(Value::Text(text)) => Some(text),
        _ => None,
    })
}

/// An array whose axes and wavelengths are known. If the facts of the file state the grid that was written, it has that grid.
pub(super) fn placed(
    array: &Array,
    axes: Axes,
    (name, quantity): (String, Quantity),
    nm: &[f64],
    facts: Option<&Facts>,
    Reading { path, options }: Reading<'_>,
) -> Result<CubeFile<'static>, IoError> {
    let cube = array.cube(axes, path, options.limits)?;
    Ok(CubeFile::new((path, FORMAT), vec![cube], (name, bands(nm, facts, path)?, quantity), options))
}

/// Wavelengths of bands in their order.
pub(super) fn bands(nm: &[f64], facts: Option<&Facts>, path: &Path) -> Result<Bands, IoError> {
    let bands = Bands::sorted(path, "the wavelengths", nm.iter().copied().enumerate())?;
    Ok(Facts::regrid(facts, bands))
}
