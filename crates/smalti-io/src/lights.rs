//! Lights by name or file.

use std::path::Path;

use smalti::spectrum::Illuminant;

use crate::toml_source::beside;
use crate::{IoError, spectrum_csv};

/// A light by name as [`Illuminant::from_name`] takes it, or from a CSV file in a folder; `file.csv#column` picks a column. With it
/// comes what is to be told about the file, such as its separators, if anything.
///
/// # Errors
/// When there is none of that name, or the file holds no spectrum or states percent above 100.
pub fn load_with_note(name: &str, folder: &Path) -> Result<(Illuminant, Option<String>), IoError> {
    let file = name.split('#').next().unwrap_or(name);
    if !Path::new(file).extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
        return Ok((Illuminant::from_name(name).map_err(IoError::Light)?, None));
    }
    let (power, note) = spectrum_csv::read_relative(&beside(folder, name).to_string_lossy())?;
    Ok((Illuminant::Measured { name: name.to_owned(), power }, note))
}
