//! Lights by name or file.

use std::path::Path;

use smalti::spectrum::Illuminant;

use crate::toml_source::beside;
use crate::{IoError, spectrum_csv};

/// A light by name as [`Illuminant::from_name`] takes it, or from a CSV file in a folder; `file.csv#column` picks a column.
///
/// # Errors
/// When there is none of that name, or the file holds no spectrum.
pub fn load(name: &str, folder: &Path) -> Result<Illuminant, IoError> {
    let file = name.split('#').next().unwrap_or(name);
    if !Path::new(file).extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
        return Illuminant::from_name(name).map_err(IoError::Light);
    }
    let power = spectrum_csv::read_spectrum(&beside(folder, name).to_string_lossy())?;
    Ok(Illuminant::Measured { name: name.to_owned(), power })
}
