//! Variables as Octave writes them with `-hdf5`: a group each, of a `type` and a `value`.

use std::fmt::Display;
use std::path::Path;
use std::sync::Arc;

use hdf5_pure::{AttrValue, Group};

use crate::raster::Kind;
use crate::variables::{Array, Fields, Layout, Numbers, Value};
use crate::{IoError, Limits};

/// The attribute of such a group.
pub(super) const MARK: &str = "OCTAVE_NEW_FORMAT";

// Ranges are short here: wavelengths.
const MAX_RANGE_COUNT: u64 = 1 << 16;

/// The group of a variable.
pub(super) struct Variable<'a> {
    pub(super) group: &'a Group,
    pub(super) fields: &'a dyn Fields,
    pub(super) path: &'a Path,
    pub(super) limits: Limits,
    /// The error of a file that cannot be decoded, from its reason.
    pub(super) decode: &'a dyn Fn(&dyn Display) -> IoError,
}

/// The value of the variable whose group this is.
pub(super) fn value(variable: &Variable<'_>) -> Result<Value, IoError> {
    let kind = match variable.fields.get("type")? {
        Some(Value::Text(kind)) => kind,
        _ => return Ok(Value::Other("of an unknown type")),
    };
    if kind.contains("range") {
        return range(variable);
    }
    Ok(match variable.fields.get("value")? {
        Some(Value::Numbers(numbers)) if kind.ends_with("string") => Value::Text(text(&numbers, variable)?),
        Some(Value::Numbers(numbers)) => Value::Numbers(Numbers { matlab: true, ..numbers }),
        Some(value) => value,
        None => Value::Other("empty"),
    })
}

fn text(numbers: &Numbers, variable: &Variable<'_>) -> Result<String, IoError> {
    let bytes = numbers.list("a text", variable.path, variable.limits)?;
    Ok(String::from_utf8_lossy(&bytes.iter().map(|&b| b as u8).collect::<Vec<u8>>()).into_owned())
}

/// First, last and step, and in an attribute how many.
fn range(variable: &Variable<'_>) -> Result<Value, IoError> {
    let wrong = || (variable.decode)(&"a range of Octave without first, last, step and length");
    let dataset = variable.group.dataset("value").map_err(|e| (variable.decode)(&e))?;
    let attributes = dataset.attrs().map_err(|e| (variable.decode)(&e))?;
    let count = attributes.get("OCTAVE_RANGE_NELEM").and_then(AttrValue::as_u64);
    let count = count.filter(|&n| n <= MAX_RANGE_COUNT).ok_or_else(wrong)?;
    if dataset.shape().map_err(|e| (variable.decode)(&e))?.iter().any(|&d| d != 1) {
        return Err(wrong());
    }
    let raw = dataset.read_raw().map_err(|e| (variable.decode)(&e))?;
    let numbers: Vec<f64> = Kind::F64.numbers(false, &raw);
    let [first, _, step] = numbers[..] else { return Err(wrong()) };
    let bytes: Vec<u8> = (0..count).flat_map(|i| (first + step * i as f64).to_le_bytes()).collect();
    let array = Array {
        dims: vec![1, count as usize],
        kind: Kind::F64,
        big_endian: false,
        source: Arc::new(bytes),
        layout: Layout::Run { offset: 0 },
    };
    Ok(Value::Numbers(Numbers { array, matlab: true, attributes: Vec::new() }))
}
