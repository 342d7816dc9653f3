//! The stages of a simulation as `.npy` files, and a `stages.json` that describes them.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::npy::{self, Element};
use crate::{IoError, text, write};

/// The file beside the arrays.
pub const INDEX: &str = "stages.json";

/// What one array is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// The file, beside the index.
    pub file: String,
    /// Length of every axis.
    pub shape: Vec<usize>,
    /// What every axis counts, as in `["wavelength", "row", "column"]`.
    pub axes: Vec<String>,
    /// Type of the elements, in NumPy's words.
    pub dtype: String,
    /// Unit of the elements, as in `photons s^-1 m^-2 nm^-1`.
    pub unit: String,
    /// Further numbers one needs to use the array, with the unit in the key, as in `sample_spacing_m`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, Vec<f64>>,
}

/// Writes `name.npy` into a folder (made where it is absent) and enters it into the folder's `stages.json`, whose
/// other entries stay. Axes and shape are equally long.
///
/// # Errors
/// When the name is not a plain file name, axes or elements do not match the shape, an existing index is
/// malformed, or a file cannot be written.
pub fn write_stage<T: Element>(
    dir: &Path,
    name: &str,
    axes: &[(&str, usize)],
    data: &[T],
    unit: &str,
    numbers: &[(&str, &[f64])],
) -> Result<(), IoError> {
    let plain = !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    if !plain {
        let expected = "a name of letters, digits, - and _";
        return Err(IoError::field(dir, "the stage", format!("'{name}'"), expected));
    }
    write::create_folder(dir)?;
    let index_path = dir.join(INDEX);
    let mut index = if index_path.exists() { read_index(dir)? } else { BTreeMap::new() };

    let file = format!("{name}.npy");
    let shape: Vec<usize> = axes.iter().map(|(_, n)| *n).collect();
    npy::write(&dir.join(&file), &shape, data)?;
    let stage = Stage {
        file,
        shape,
        axes: axes.iter().map(|(axis, _)| (*axis).to_owned()).collect(),
        dtype: T::DESCR.to_owned(),
        unit: unit.to_owned(),
        numbers: numbers.iter().map(|(k, v)| ((*k).to_owned(), v.to_vec())).collect(),
    };
    index.insert(name.to_owned(), stage);
    let json = serde_json::to_string_pretty(&index).map_err(|e| IoError::writing(&index_path)(e.into()))?;
    write::bytes(&index_path, (json + "\n").as_bytes())
}

/// The index of a folder of stages, by name.
///
/// # Errors
/// When `stages.json` cannot be read or is malformed.
pub fn read_index(dir: &Path) -> Result<BTreeMap<String, Stage>, IoError> {
    let path = dir.join(INDEX);
    let text = text::read_to_string(&path)?;
    serde_json::from_str(&text).map_err(|e| IoError::decode(&path, "stages.json", e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;

    #[test]
    fn stages_gather_in_one_index() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("stages");
        write_stage(&out, "volts", &[("row", 2), ("column", 3)], &[0.5f32; 6], "V", &[]).unwrap();
        let spacing: &[(&str, &[f64])] = &[("sample_spacing_m", &[1e-6])];
        let axes = [("wavelength", 1), ("row", 1), ("column", 2)];
        write_stage(&out, "irradiance", &axes, &[1f64, 2.0], "photons s^-1 m^-2 nm^-1", spacing).unwrap();
        let index = read_index(&out).unwrap();
        assert_eq!(index.len(), 2);
        assert_eq!(index["irradiance"].numbers["sample_spacing_m"], [1e-6]);
        assert_eq!((index["volts"].unit.as_str(), index["volts"].shape.as_slice()), ("V", &[2, 3][..]));
        assert_eq!(npy::read(&out.join("volts.npy"), Limits::default()).unwrap().shape, [2, 3]);
        assert!(write_stage(&out, "../x", &[("row", 1)], &[0u16], "", &[]).is_err());
    }

    #[test]
    fn a_malformed_index_is_not_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join(INDEX), "{").unwrap();
        let error = write_stage(dir.path(), "a", &[("row", 1)], &[0u16], "DN", &[]).unwrap_err();
        assert!(error.to_string().contains("stages.json"));
        assert!(!dir.path().join("a.npy").exists());
    }
}
