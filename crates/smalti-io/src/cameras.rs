//! Cameras by name or file: described in TOML, checked, resolved.

use std::path::Path;

use smalti::camera::{Camera, CameraDescription, CameraError};
use smalti::numeric::Planes;
use smalti::sensor::Filter;
use smalti::spectrum::WavelengthGrid;

use crate::camera_toml::Override;
use crate::diagnostic::Diagnostic;
use crate::toml_source::{BuiltinFile, TomlSource, beside, builtin};
use crate::{Limits, npy, spectrum_csv};

static CAMERAS: &[BuiltinFile] = &[
    builtin!("cameras", "bayer", "The L³ slides' camera, Bayer"),
    builtin!("cameras", "rgbw", "The L³ slides' camera, RGBW 2 × 2"),
    builtin!("cameras", "clarity", "The L³ slides' camera, RCCB as in Aptina Clarity+"),
    builtin!("cameras", "kodak", "The L³ slides' camera, Kodak's panchromatic 4 × 4"),
    builtin!("cameras", "wang", "The L³ slides' camera, Wang et al. 2011, 5 × 5"),
    builtin!("cameras", "rgbx", "The L³ slides' camera, RGB and near infrared"),
    builtin!("cameras", "rgbcmy", "The L³ slides' camera, six colours in 3 × 2"),
    builtin!("cameras", "medical", "The L³ slides' camera, RGB and a narrow band for medical imaging"),
    builtin!("cameras", "table1", "\"Resolution in Color Filter Array Images\", table 1"),
    builtin!("cameras", "phone", "A phone of 2020: 1 µm pixels at f/1.8"),
];

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

/// A camera by name or file, with overrides applied and the files that it names read; on the given wavelengths, else on its own.
///
/// # Errors
/// When there is none of that name, or a key, a value or a file does not fit; with the line where there is one.
pub fn load(
    name: &str,
    overrides: &[Override],
    grid: Option<WavelengthGrid>,
) -> Result<Camera, Box<Diagnostic>> {
    from_source(&TomlSource::find("camera", CAMERAS, name)?, overrides, grid)
}

/// As [`load`], from a text that is not a file's; files that it names are looked for in the source's folder.
pub fn from_source(
    source: &TomlSource,
    overrides: &[Override],
    grid: Option<WavelengthGrid>,
) -> Result<Camera, Box<Diagnostic>> {
    let mut description = source.describe(overrides)?;
    // A file that gives no name is called by its own.
    let unnamed = description.name == CameraDescription::default().name;
    if let Some(stem) = Path::new(&source.name).file_stem().filter(|_| unnamed) {
        description.name = stem.to_string_lossy().into_owned();
    }
    let wrong = |key: &str, message: &str| Box::new(about(source, overrides, key, message));
    read_files(&mut description, &source.folder, &wrong)?;
    let made = grid.map_or_else(|| description.grid(), Ok).and_then(|grid| Camera::new(description, grid));
    made.map_err(|e| match e {
        CameraError::Key { key, message } => wrong(&key, &message),
        other => Box::new(Diagnostic::new(source.name.clone(), other.to_string())),
    })
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

/// Replaces the name of every file by its content, so that the description is complete.
fn read_files(
    d: &mut CameraDescription,
    folder: &Path,
    wrong: &dyn Fn(&str, &str) -> Box<Diagnostic>,
) -> Result<(), Box<Diagnostic>> {
    let lens = [
        ("optics.transmittance".to_owned(), Some(&mut d.optics.transmittance)),
        ("optics.ir_cut".to_owned(), d.optics.ir_cut.as_mut()),
    ];
    let sensor = [("sensor.quantum_efficiency".to_owned(), Some(&mut d.sensor.quantum_efficiency))];
    let filters =
        d.sensor.cfa.filters.iter_mut().map(|(letter, f)| (format!("sensor.cfa.filters.{letter}"), Some(f)));
    for (key, filter) in lens.into_iter().chain(sensor).chain(filters) {
        if let Some(filter) = filter {
            read_curve(filter, folder).map_err(|e| wrong(&key, &e))?;
        }
    }
    if let Some(psf) = &mut d.optics.psf {
        let path = beside(folder, &psf.file);
        let read = || -> Result<(Planes, String), String> {
            let array = npy::read(&path, Limits::default()).map_err(|e| e.to_string())?;
            let (count, rows, cols) = match array.shape[..] {
                [rows, cols] => (1, rows, cols),
                [count, rows, cols] => (count, rows, cols),
                _ => {
                    let (path, got) = (path.display(), array.shape.len());
                    return Err(format!("{path}: expected 2 or 3 dimensions, got {got}"));
                }
            };
            let planes = Planes::new(rows, cols, count, array.to_f32()).map_err(|e| e.to_string())?;
            let bytes: Vec<u8> = planes.data().iter().flat_map(|v| v.to_le_bytes()).collect();
            Ok((planes, blake3::hash(&bytes).to_hex().to_string()))
        };
        let (planes, hash) = read().map_err(|e| wrong("optics.psf.file", &e))?;
        if !psf.hash.is_empty() && psf.hash != hash {
            let message = format!("the file has the hash {hash}, not that of the description");
            return Err(wrong("optics.psf.hash", &message));
        }
        (psf.planes, psf.hash) = (Some(planes), hash);
    }
    Ok(())
}

/// Replaces a named file by the samples in it.
pub(crate) fn read_curve(filter: &mut Filter, folder: &Path) -> Result<(), String> {
    if let Filter::File(name) = filter {
        let path = beside(folder, name);
        let spectrum = spectrum_csv::read_spectrum(&path.to_string_lossy()).map_err(|e| e.to_string())?;
        let grid = spectrum.grid();
        *filter = Filter::Samples {
            start_nm: grid.start_nm(),
            step_nm: grid.step_nm(),
            values: spectrum.values().to_vec(),
        };
    }
    Ok(())
}
