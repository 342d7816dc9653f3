//! Reading of built-in studies and study files.

mod conditions;
mod file;
mod parcel;
mod processing;

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use serde_json::Value;
use smalti::camera::description::ArchitectureName;
use smalti::design::{
    Condition, DesignError, Metric, MetricTarget, Study, StudyScene, TrialProcessing, Trials,
};
use smalti::scene::{Scene, Setting, catalog};
use smalti::spectrum::WavelengthGrid;

pub use self::parcel::scenes_as_bytes;

use self::conditions::conditions;
use self::file::StudyFile;
use self::parcel::hash;
use crate::cameras::{read_curve, tell};
use crate::diagnostic::Diagnostic;
use crate::toml_source::{BuiltinFile, TomlSource, beside, builtin};
use crate::{ReadOptions, scene_file, text};

static STUDIES: &[BuiltinFile] = &[
    builtin!(
        "studies",
        "table2",
        "What more colours cost: 1000 sets of Gaussian filters for each of 3 to 7 colours"
    ),
    builtin!(
        "studies",
        "table2-l3",
        "The same with a pipeline learned for each design in place of bilinear demosaicking"
    ),
    builtin!("studies", "theory", "Filters by rule: uniform, height-scaled, all-scaled, 3 to 7 colours"),
    builtin!("studies", "mosaics", "Where to place the filters: 1000 placements for each of 3 to 7 colours"),
    builtin!("studies", "aliasing", "The aliasing of each published mosaic"),
];

/// The built-in studies.
#[must_use]
pub fn names() -> &'static [BuiltinFile] {
    STUDIES
}

/// JSON Schema of a study file.
#[cfg(feature = "schema")]
#[must_use]
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(StudyFile)
}

/// Reads a study by name or file, with the cameras, illuminants, filters and scenes that it refers to. Returns its trials and its
/// description (`about`). A `.json` file is a resolved study or the manifest of results.
///
/// # Errors
/// When the name is unknown, a key, a value or a file is invalid, or the study has no design. The error names the line, if there is one.
pub fn load(name: &str) -> Result<(Trials, String), Box<Diagnostic>> {
    load_with_notes(name).map(|LoadedStudy { trials, about, .. }| (trials, about))
}

/// A study with what is to be told about it.
#[derive(Debug, Clone)]
pub struct LoadedStudy {
    /// Its trials.
    pub trials: Trials,
    /// Its description.
    pub about: String,
    /// What was recognised about the files that it refers to, such as percent and separators; each once.
    pub notes: Vec<String>,
}

/// As [`load`], with what is to be told about the files of the study.
///
/// # Errors
/// As [`load`].
pub fn load_with_notes(name: &str) -> Result<LoadedStudy, Box<Diagnostic>> {
    if Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        let text = text::read_to_string(Path::new(name));
        let text = text.map_err(|e| Box::new(Diagnostic::new(name, e.to_string())))?;
        let (trials, about) = from_json(name, &text, &[])?;
        return Ok(LoadedStudy { trials, about, notes: Vec::new() });
    }
    from_source_with_notes(&TomlSource::find("study", STUDIES, name)?)
}

/// Reads a resolved study, or the manifest of results, from its JSON text. `scenes` are the scenes from files, as returned by
/// [`scenes_as_bytes`], and `name` is used in error messages.
///
/// # Errors
/// When the text is not a resolved study, `scenes` lacks a scene from a file, or the study has no design.
pub fn from_json(name: &str, text: &str, scenes: &[u8]) -> Result<(Trials, String), Box<Diagnostic>> {
    let wrong = |message: String| Box::new(Diagnostic::new(name, message));
    let value: Value = serde_json::from_str(text).map_err(|e| wrong(e.to_string()))?;
    let study = value.get("study").unwrap_or(&value);
    let about = study.get("about").and_then(Value::as_str).unwrap_or_default().to_owned();
    let mut study = Study::deserialize(study).map_err(|e| wrong(format!("not a resolved study: {e}")))?;
    if !scenes.is_empty() {
        parcel::put_scenes(&mut study, scenes).map_err(wrong)?;
    }
    if let Some(scene) = study.scenes.iter().find(|s| s.hash.is_some() && s.scene.is_none()) {
        let name = &scene.name;
        return Err(wrong(format!("it does not hold the scene {name}; give the TOML file of the study")));
    }
    if study.processing.contains(&TrialProcessing::L3) {
        study.l3.validate().map_err(|e| wrong(e.to_string()))?;
    }
    Ok((Trials::new(study).map_err(|e| wrong(e.to_string()))?, about))
}

/// Reads a study from the text of its TOML file.
///
/// # Errors
/// As [`load`].
pub fn from_source(source: &TomlSource) -> Result<(Trials, String), Box<Diagnostic>> {
    from_source_with_notes(source).map(|LoadedStudy { trials, about, .. }| (trials, about))
}

/// As [`from_source`], with what is to be told about the files of the study.
///
/// # Errors
/// As [`load`].
pub fn from_source_with_notes(source: &TomlSource) -> Result<LoadedStudy, Box<Diagnostic>> {
    let camera = || format!("this is a camera file; a study refers to it by camera = \"{}\"", source.name);
    let file: StudyFile = source.parse_or_tell(&["optics", "sensor", "exposure", "isp"], camera)?;
    let wrong = |key: &str, message: &str| Box::new(source.about_key(key, message));
    let (mut filters, mut notes) = (file.filters.clone(), Vec::new());
    for (place, filter) in filters.filters_mut() {
        let note = read_curve(filter, &source.folder).map_err(|e| wrong(&format!("filters.{place}"), &e))?;
        tell(&mut notes, note);
    }
    let stem = Path::new(&source.name).file_stem().map(|s| s.to_string_lossy().into_owned());
    let study = Study {
        name: file.name.clone().or(stem).unwrap_or_else(|| source.name.clone()),
        seed: file.seed,
        colors: file.colors.clone(),
        filters,
        filter_sets: file.sample.filters.number(),
        mosaics: file.mosaics.clone(),
        mosaic_count: file.sample.mosaics.number(),
        conditions: conditions(&file, source, &mut notes)?,
        processing: file.processing.list(),
        l3: file.l3.clone(),
        metrics: metrics(&file, source)?,
        scenes: scenes(&file, source)?,
    };
    let once = |key, again: Option<String>| match again {
        Some(twice) => Err(wrong(key, &format!("{twice} is listed twice"))),
        None => Ok(()),
    };
    once("colors", twice(&study.colors).map(ToString::to_string))?;
    once("processing", twice(&study.processing).map(|p| p.name().to_owned()))?;
    once("metrics", twice(&study.metrics).map(|m| m.name().to_owned()))?;
    once("scenes", twice(&file.scenes).cloned())?;
    if study.processing.contains(&TrialProcessing::L3) {
        study.l3.validate().map_err(|e| wrong("l3", &e.to_string()))?;
        let other = |c: &Condition| c.camera.sensor.architecture != ArchitectureName::Mosaic;
        if study.conditions.iter().any(other) {
            let message = "\"l3\" requires a mosaic; expected a camera with architecture = \"mosaic\"";
            return Err(wrong("processing", message));
        }
    }
    let trials = Trials::new(study).map_err(|e| match &e {
        DesignError::Key { key, message } if key.starts_with("given") || key.starts_with("tile") => {
            wrong(&format!("mosaics.{key}"), message)
        }
        DesignError::Key { key, message } => wrong(&format!("filters.{key}"), message),
        DesignError::Filter { .. } => wrong("filters", &e.to_string()),
        DesignError::TooFewSets { .. } | DesignError::TooManySets { .. } => {
            wrong("sample.filters", &e.to_string())
        }
        DesignError::TooFew { .. } | DesignError::TooMany { .. } | DesignError::TooManyMosaics { .. } => {
            wrong("sample.mosaics", &e.to_string())
        }
        DesignError::NoDesign { colors, sets, .. } => {
            let key = match (file.sample.filters.number(), file.sample.mosaics.number()) {
                _ if colors.is_empty() => "colors",
                (Some(0), _) => "sample.filters",
                (_, Some(0)) => "sample.mosaics",
                _ if sets.iter().all(|n| *n == 0) => "filters",
                _ => "colors",
            };
            wrong(key, &e.to_string())
        }
        _ => Box::new(Diagnostic::new(source.name.clone(), e.to_string())),
    })?;
    processing::check(&trials, &file, source, &mut notes)?;
    Ok(LoadedStudy { trials, about: file.about, notes })
}

fn twice<T: Ord>(all: &[T]) -> Option<&T> {
    let mut seen = BTreeSet::new();
    all.iter().find(|v| !seen.insert(*v))
}

/// The metrics of the file, or the default ones. Metrics of scenes and scenes require each other.
fn metrics(file: &StudyFile, source: &TomlSource) -> Result<Vec<Metric>, Box<Diagnostic>> {
    let wrong = |key: &str, message: &str| Box::new(source.about_key(key, message));
    let Some(stated) = &file.metrics else {
        let of_scenes = Metric::OF_SCENES.into_iter().filter(|_| !file.scenes.is_empty());
        return Ok(Metric::USUAL.into_iter().chain(of_scenes).collect());
    };
    let of_scenes = stated.iter().find(|m| m.target() == MetricTarget::Scenes);
    match of_scenes {
        _ if stated.is_empty() => Err(wrong("metrics", "expected at least one metric")),
        Some(metric) if file.scenes.is_empty() => {
            let message = format!("{} needs scenes; expected scenes = [\"dead-leaves\", …]", metric.name());
            Err(wrong("metrics", &message))
        }
        None if !file.scenes.is_empty() => {
            let names = Metric::OF_SCENES.map(Metric::name).join(", ");
            Err(wrong("scenes", &format!("no metric uses them; expected one of {names} in `metrics`")))
        }
        _ => Ok(stated.clone()),
    }
}

/// The scenes. Files are read; the parameters of built-in scenes are checked.
fn scenes(file: &StudyFile, source: &TomlSource) -> Result<Vec<StudyScene>, Box<Diagnostic>> {
    let scene = |(i, name): (usize, &String)| {
        let wrong = |message: String| Box::new(source.about_key(&format!("scenes[{i}]"), &message));
        let path = beside(&source.folder, name);
        if scene_file::is_meant(&path.to_string_lossy()) {
            let scene = scene_file::read(&path, &Setting::default(), &ReadOptions::default())
                .map_err(|e| wrong(e.to_string()))?;
            return Ok(StudyScene {
                name: name.clone(),
                hash: Some(hash(&scene)),
                scene: Some(Arc::new(scene)),
            });
        }
        // Building the scene at one wavelength checks its parameters.
        let try_it = || -> Result<Scene, Box<dyn std::error::Error>> {
            let grid = WavelengthGrid::new(550.0, 10.0, 1)?;
            Ok(catalog::build_natural(name, &Setting { grid, ..Setting::default() })?)
        };
        try_it().map_err(|e| wrong(e.to_string()))?;
        Ok(StudyScene { name: name.clone(), hash: None, scene: None })
    };
    file.scenes.iter().enumerate().map(scene).collect()
}
