//! Cameras with another mosaic: `CAMERA@MOSAIC`.

use std::collections::BTreeSet;
use std::path::Path;

use smalti::camera::CameraDescription;
use smalti::camera::description::{CfaDescription, ExchangeError, PatternDescription};
use smalti::sensor::{CfaError, Filter, cfa};

use super::built_in::CAMERAS;
use super::files::{filters_of_table, fit_table, listed};
use crate::camera_toml::Override;
use crate::diagnostic::Diagnostic;
use crate::toml_source::{TomlSource, beside, is_toml};

/// The key of the filters, whose letters follow.
const FILTERS: &str = "sensor.cfa.filters";
/// Keys that a mosaic replaces.
const REPLACED: [&str; 3] = ["sensor.cfa", "sensor.cfa.pattern", "sensor.cfa.mixtures"];

/// The camera and the mosaic in a name. A file may have `@` in its name.
pub(super) fn split(name: &str) -> (&str, Option<&str>) {
    if Path::new(name).is_file() {
        return (name, None);
    }
    let mut places =
        name.match_indices('@').filter(|(at, _)| *at > 0).map(|(at, _)| (&name[..at], &name[at + 1..]));
    let known = places.clone().find(|(camera, _)| is_camera(camera) || Path::new(camera).is_file());
    match known.or_else(|| places.next_back()) {
        Some((camera, mosaic)) => (camera, Some(mosaic)),
        None => (name, None),
    }
}

/// Whether a built-in camera has this name.
pub(super) fn is_camera(name: &str) -> bool {
    CAMERAS.iter().any(|c| c.name == name)
}

/// Whether the catalogue has a mosaic of this name.
pub(super) fn is_in_catalog(name: &str) -> bool {
    cfa::default_filters(name).is_ok()
}

/// The error about a camera that is not there; a mosaic of that name is proposed as the mosaic of a camera.
pub(super) fn or_mosaic(name: &str, error: Box<Diagnostic>) -> Box<Diagnostic> {
    if !is_in_catalog(name) {
        return error;
    }
    let message = "this is a mosaic; expected a camera";
    let help =
        format!("bayer@{name} is the camera bayer with this mosaic; smalti list cameras prints all cameras");
    Box::new(Diagnostic { help: Some(help), ..Diagnostic::new(name, message) })
}

/// A mosaic of the catalogue, or the colour filter array of a camera file.
pub(super) struct Mosaic {
    /// The argument that asks for it, `CAMERA@MOSAIC`.
    argument: String,
    /// Its name in the name of the camera.
    name: String,
    cfa: CfaDescription,
    notes: Vec<String>,
}

impl Mosaic {
    /// The mosaic of that name or file.
    pub(super) fn find(argument: &str, name: &str) -> Result<Self, Box<Diagnostic>> {
        let wrong = |message: String, help: Option<String>| {
            Box::new(Diagnostic { help, ..Diagnostic::new(argument, message) })
        };
        if !(is_toml(Path::new(name)) || Path::new(name).is_file()) {
            return match cfa::default_filters(name) {
                Ok(_) => Ok(Self {
                    argument: argument.into(),
                    name: name.into(),
                    cfa: CfaDescription {
                        pattern: PatternDescription::Name(name.into()),
                        ..CfaDescription::default()
                    },
                    notes: Vec::new(),
                }),
                Err(CfaError::UnknownName { what: "CFA", suggestion, .. }) => {
                    let known = "smalti list cfas prints the mosaics of the catalogue; or give a .toml file";
                    let near = suggestion.map(|near| format!("did you mean '{near}'? "));
                    let camera = is_camera(name)
                        .then(|| format!("'{name}' is a camera; smalti show {name} prints its mosaic. "));
                    let help = format!("{}{known}", camera.or(near).unwrap_or_default());
                    Err(wrong(format!("no such mosaic '{name}'"), Some(help)))
                }
                Err(e) => Err(wrong(e.to_string(), None)),
            };
        }
        let source = TomlSource::find("mosaic", &[], name)?;
        let mut array = source.describe(&[])?.sensor.cfa;
        let mut notes = Vec::new();
        let about = |e: String| Box::new(source.about_key(FILTERS, &e));
        let table = filters_of_table(&mut array, &source.folder, &mut notes).map_err(about)?;
        fit_table(&mut array, table.as_ref(), &mut notes).map_err(about)?;
        // The camera looks for files in its own folder.
        for filter in array.filters.values_mut() {
            if let Filter::File(file) = filter {
                let path = beside(&source.folder, file);
                let path = std::path::absolute(&path).unwrap_or(path);
                *file = path.to_string_lossy().into_owned();
            }
        }
        let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
        Ok(Self { argument: argument.into(), name: stem.unwrap_or_else(|| name.into()), cfa: array, notes })
    }

    /// The error about a key of the camera that the mosaic does not allow, with what would mend it.
    pub(super) fn conflict(&self, told: Diagnostic) -> Diagnostic {
        let help = "--set sensor.binning=none turns off the binning of this camera".to_owned();
        Diagnostic { help: Some(help), ..Diagnostic::new(&self.argument, told.message) }
    }

    /// Replaces the mosaic of a camera and adds the mosaic to its name.
    pub(super) fn put_on(
        &self,
        camera: &mut CameraDescription,
        overrides: &[Override],
        notes: &mut Vec<String>,
    ) -> Result<(), Box<Diagnostic>> {
        let replaced =
            |o: &&Override| REPLACED.contains(&o.key.as_str()) || o.key.starts_with("sensor.cfa.mixtures.");
        if let Some(o) = overrides.iter().find(replaced) {
            let message =
                format!("the mosaic is given twice, here and as {}; expected one of them", self.argument);
            return Err(Box::new(o.wrong(message)));
        }
        let stated = stated_letters(overrides, &camera.sensor.cfa);
        let exchanged = camera.sensor.cfa.with_mosaic_of(&self.cfa, &stated);
        let exchanged = exchanged.map_err(|e| self.cannot(&camera.name, &e))?;
        camera.sensor.cfa = exchanged.cfa;
        notes.extend(self.notes.iter().cloned());
        let end = format!("@{}", self.name);
        if !camera.name.ends_with(&end) {
            camera.name += &end;
        }
        let name = &camera.name;
        if !exchanged.from_catalog.is_empty() {
            let generic =
                exchanged.from_catalog.iter().map(|(letter, filter)| format!("{letter} ({filter})"));
            let generic = generic.collect::<Vec<_>>().join(", ");
            notes.push(format!(
                "{name}: the camera has no filter for {generic}; that of the catalogue is taken"
            ));
        }
        if !exchanged.unused.is_empty() {
            let unused = listed(&exchanged.unused);
            notes.push(format!(
                "{name}: the stated filter for {unused} is not used, since the mosaic has no such letter"
            ));
        }
        Ok(())
    }

    /// The error about a mosaic that the camera cannot have, with what would mend it.
    fn cannot(&self, camera: &str, error: &ExchangeError) -> Box<Diagnostic> {
        let help = match error {
            ExchangeError::NoFilter { missing, .. } => {
                let set = |(letter, _): &(char, Option<String>)| {
                    format!("--set 'sensor.cfa.filters.{letter}={{ file = \"{letter}.csv\" }}'")
                };
                let set = missing.iter().map(set).collect::<Vec<_>>().join(" ");
                Some(format!(
                    "state them: {set}, or a built-in one as in {{ builtin = \"white\" }} (smalti list filters). Filters of the \
                     catalogue are generic, and {camera} has curves of its own, which they do not fit"
                ))
            }
            _ => None,
        };
        Box::new(Diagnostic { help, ..Diagnostic::new(&self.argument, error.to_string()) })
    }
}

/// The letter whose filter an override states, as in `sensor.cfa.filters.W`; `None` for any other key.
#[must_use]
pub fn filter_letter(o: &Override) -> Option<char> {
    o.key.strip_prefix(FILTERS)?.strip_prefix('.')?.split('.').next()?.chars().next()
}

/// The letters whose filters the command line states.
fn stated_letters(overrides: &[Override], cfa: &CfaDescription) -> BTreeSet<char> {
    let mut letters = BTreeSet::new();
    for o in overrides {
        if o.key == FILTERS {
            letters.extend(cfa.filters.keys().filter_map(|name| name.chars().next()));
        }
        letters.extend(filter_letter(o));
    }
    letters
}
