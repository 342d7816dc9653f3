//! Cameras by name or file: described in TOML, checked, resolved.

mod built_in;
mod files;
mod json;
mod mosaics;
#[cfg(test)]
mod tests;

use std::path::Path;

use smalti::camera::{Camera, CameraDescription, CameraError};
use smalti::spectrum::WavelengthGrid;

use self::built_in::CAMERAS;
pub use self::json::from_json;
use self::mosaics::Mosaic;
pub use self::mosaics::filter_letter;
use crate::camera_toml::Override;
use crate::diagnostic::Diagnostic;
use crate::toml_source::{BuiltinFile, TomlSource, beside, is_toml};

pub(crate) use self::files::{read_curve, tell};

/// The built-in cameras.
#[must_use]
pub fn names() -> &'static [BuiltinFile] {
    CAMERAS
}

/// What a camera file may hold, as JSON Schema.
#[cfg(feature = "schema")]
#[must_use]
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(CameraDescription)
}

/// A camera with what is to be told about it.
#[derive(Debug, Clone)]
pub struct LoadedCamera {
    /// The camera.
    pub camera: Camera,
    /// Its description before files were read: curves of files have the names of the files.
    pub stated: CameraDescription,
    /// What was recognised or supplied while reading, in whole sentences without a full stop.
    pub notes: Vec<String>,
}

impl LoadedCamera {
    /// The description as a TOML file, which names the files of its curves.
    ///
    /// # Errors
    /// When a value cannot be written as TOML.
    pub fn stated_toml(&self) -> Result<String, Box<Diagnostic>> {
        toml::to_string(&self.stated)
            .map_err(|e| Box::new(Diagnostic::new(self.stated.name.clone(), e.to_string())))
    }
}

/// A camera by name or file, with overrides applied and the files that it names read; on the given wavelengths, else on its own.
/// `CAMERA@MOSAIC` is a camera with another mosaic, that of the catalogue or of a file; see [`CfaDescription::with_mosaic_of`].
///
/// # Errors
/// When there is none of that name, or a key, a value or a file does not fit; with the line where there is one.
///
/// [`CfaDescription::with_mosaic_of`]: smalti::camera::description::CfaDescription::with_mosaic_of
pub fn load(
    name: &str,
    overrides: &[Override],
    grid: Option<WavelengthGrid>,
) -> Result<Camera, Box<Diagnostic>> {
    Ok(load_with_notes(name, overrides, grid)?.camera)
}

/// As [`load`], with what is to be told about the camera.
///
/// # Errors
/// As [`load`].
pub fn load_with_notes(
    name: &str,
    overrides: &[Override],
    grid: Option<WavelengthGrid>,
) -> Result<LoadedCamera, Box<Diagnostic>> {
    let (camera, mosaic) = mosaics::split(name);
    let source = TomlSource::find("camera", CAMERAS, camera).map_err(|e| mosaics::or_mosaic(camera, e))?;
    let mosaic = mosaic.map(|mosaic| Mosaic::find(name, mosaic)).transpose()?;
    read(&source, overrides, grid, mosaic.as_ref())
}

/// As [`load`], from a text that is not a file's; files that it names are looked for in the source's folder.
pub fn from_source(
    source: &TomlSource,
    overrides: &[Override],
    grid: Option<WavelengthGrid>,
) -> Result<Camera, Box<Diagnostic>> {
    Ok(from_source_with_notes(source, overrides, grid)?.camera)
}

/// As [`from_source`], with what is to be told about the camera.
///
/// # Errors
/// As [`load`].
pub fn from_source_with_notes(
    source: &TomlSource,
    overrides: &[Override],
    grid: Option<WavelengthGrid>,
) -> Result<LoadedCamera, Box<Diagnostic>> {
    read(source, overrides, grid, None)
}

/// Whether a name is that of a built-in camera, alone or with a mosaic of the catalogue: it means the same on every machine.
#[must_use]
pub fn is_built_in(name: &str) -> bool {
    let (camera, mosaic) = mosaics::split(name);
    mosaics::is_camera(camera) && mosaic.is_none_or(mosaics::is_in_catalog)
}

/// Whether a name is `CAMERA@MOSAIC`, for a camera that is built in or a file.
#[must_use]
pub fn has_mosaic(name: &str) -> bool {
    let (camera, mosaic) = mosaics::split(name);
    mosaic.is_some() && (mosaics::is_camera(camera) || is_toml(Path::new(camera)))
}

/// The letters of the filters that the own mosaic of a camera needs, from its description alone: no file that it names is read.
///
/// # Errors
/// When there is no such camera, or a key or its mosaic is invalid.
pub fn letters(name: &str, overrides: &[Override]) -> Result<Vec<char>, Box<Diagnostic>> {
    let camera = mosaics::split(name).0;
    let source = TomlSource::find("camera", CAMERAS, camera).map_err(|e| mosaics::or_mosaic(camera, e))?;
    let letters = source.describe(overrides)?.sensor.cfa.letters();
    letters.map_err(|e| Box::new(about(&source, overrides, "sensor.cfa.pattern", &e.to_string())))
}

/// The name of a camera that a file in a folder names: TOML files are relative to that folder.
pub(crate) fn name_beside(folder: &Path, name: &str) -> String {
    let path = |name: &str| match is_toml(Path::new(name)) {
        true => beside(folder, name).to_string_lossy().into_owned(),
        false => name.to_owned(),
    };
    match name.split_once('@') {
        Some((camera, mosaic)) if mosaics::is_camera(camera) || is_toml(Path::new(camera)) => {
            format!("{}@{}", path(camera), path(mosaic))
        }
        _ => path(name),
    }
}

fn read(
    source: &TomlSource,
    overrides: &[Override],
    grid: Option<WavelengthGrid>,
    mosaic: Option<&Mosaic>,
) -> Result<LoadedCamera, Box<Diagnostic>> {
    let mut description = source.describe(overrides)?;
    // A file that gives no name is called by its own.
    let unnamed = description.name == CameraDescription::default().name;
    if let Some(stem) = Path::new(&source.name).file_stem().filter(|_| unnamed) {
        description.name = stem.to_string_lossy().into_owned();
    }
    let wrong = |key: &str, message: &str| {
        let told = about(source, overrides, key, message);
        Box::new(match mosaic {
            // The mosaic does not suit a key of the camera, whose file may be built in.
            Some(mosaic) if is_of_binning(key) && told.place.is_some() => mosaic.conflict(told),
            _ => told,
        })
    };
    let mut notes = Vec::new();
    let table = files::filters_of_table(&mut description.sensor.cfa, &source.folder, &mut notes)
        .map_err(|e| wrong("sensor.cfa.filters", &e))?;
    match mosaic {
        Some(mosaic) => mosaic.put_on(&mut description, overrides, &mut notes)?,
        None => files::fit_table(&mut description.sensor.cfa, table.as_ref(), &mut notes)
            .map_err(|e| wrong("sensor.cfa.filters", &e))?,
    }
    let stated = description.clone();
    files::read_files(&mut description, &source.folder, &mut notes, &wrong)?;
    let made = grid.map_or_else(|| description.grid(), Ok).and_then(|grid| Camera::new(description, grid));
    let camera = made.map_err(|e| match e {
        CameraError::Key { key, message } => wrong(&key, &message),
        other => Box::new(Diagnostic::new(source.name.clone(), other.to_string())),
    })?;
    Ok(LoadedCamera { camera, stated, notes })
}

/// Whether a key is that of binning, which only some mosaics allow.
fn is_of_binning(key: &str) -> bool {
    key == "sensor.binning" || key.starts_with("sensor.binning.")
}

/// Shows an impossible value where it is stated: on the command line, in the file, or without a place if it is a default.
fn about(source: &TomlSource, overrides: &[Override], key: &str, message: &str) -> Diagnostic {
    // An override of the key itself, of the table around it, or of a key within it.
    let within = |inner: &str, outer: &str| {
        inner.strip_prefix(outer).is_some_and(|r| r.is_empty() || r.starts_with('.'))
    };
    match overrides.iter().rev().find(|o| within(key, &o.key) || within(&o.key, key)) {
        Some(o) => o.wrong(format!("`{key}`: {message}")),
        None => source.about_key(key, message),
    }
}
