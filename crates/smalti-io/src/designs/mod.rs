//! Reading of design files: which colour filter array is wanted.

mod log;
mod shared;

use std::collections::BTreeMap;
use std::path::Path;

pub use log::{SEARCH_LOG, SearchLog, task_hash, task_text};
use serde::Deserialize;
pub use shared::SharedSearch;
use smalti::camera::description::CameraDescription;
use smalti::design::light::LightSettings;
use smalti::design::screen::ScreenCondition;
use smalti::design::search::{
    Annealing, FilterSpace, Front, LayoutRules, Objective, SearchSettings, Tolerance,
};
use smalti::design::{Design, DesignError, MosaicFamily};
use smalti::experiment::DesignTask;
use smalti::names::steers;

use crate::camera_toml::Override;
use crate::cameras::{read_curve, tell};
use crate::diagnostic::Diagnostic;
use crate::toml_source::{BuiltinFile, TomlSource, builtin};
use crate::{cameras, lights};

static DESIGNS: &[BuiltinFile] = &[
    builtin!(
        "designs",
        "pigments-3",
        "Three filters of pigments in 2 × 2, for 1 to 80 cd/m², on the camera of the L³ slides"
    ),
    builtin!("designs", "pigments-4", "Four filters of pigments in 2 × 2, for the same camera and light"),
    builtin!("designs", "pigments-5", "Five filters of pigments in 2 × 3, for the same camera and light"),
    builtin!("designs", "pigments-6", "Six filters of pigments in 2 × 3, for the same camera and light"),
    builtin!("designs", "pigments-4x4", "Four filters of pigments in 4 × 4, whose layouts are annealed"),
    builtin!("designs", "pigments-dark", "Three filters of pigments in 2 × 2, for 1 cd/m² alone"),
    builtin!(
        "designs",
        "pigments-daylight",
        "Three and four filters of pigments in 2 × 2, for 80 cd/m² alone"
    ),
    builtin!(
        "designs",
        "pigments-front",
        "The best compromises between noise in the dark and colour by day, three to six filters in 2 × 3"
    ),
    builtin!(
        "designs",
        "dichroic-4",
        "Four filters with two edges each in 2 × 2, such as interference filters"
    ),
    builtin!(
        "designs",
        "mixtures-16",
        "Sixteen different mixtures of red, green and blue in 4 × 4, in the manner of learned arrays (Henz 2018)"
    ),
    builtin!(
        "designs",
        "free-3",
        "Three free filter curves in 2 × 2: the bound for any filters that can be made"
    ),
    builtin!("designs", "free-4", "Four free filter curves in 2 × 2"),
    builtin!("designs", "free-6", "Six free filter curves in 2 × 3"),
];

/// The built-in design files.
#[must_use]
pub fn names() -> &'static [BuiltinFile] {
    DESIGNS
}

/// JSON Schema of a design file.
#[cfg(feature = "schema")]
#[must_use]
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(DesignFile)
}

/// A design file.
#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct DesignFile {
    /// Name of the design. The default is the file name without its extension.
    name: Option<String>,
    /// Purpose of the design, in one sentence.
    #[serde(default)]
    about: String,
    /// Name or file of the camera. Its colour filter array is replaced.
    camera: String,
    /// Changed keys of the camera, such as `"optics.f_number" = 2.8`.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "BTreeMap<String, serde_json::Value>"))]
    set: BTreeMap<String, toml::Value>,
    /// Illuminants of the scenes: names or CSV files. All count equally.
    #[serde(default = "default_lights")]
    illuminants: Vec<String>,
    /// Mean luminances of the scenes, cd/m². All count equally.
    #[serde(default = "default_luminances")]
    luminances_cd_m2: Vec<f64>,
    /// Longest exposure time, ms, if the camera states none. The time is shorter where white would saturate.
    #[serde(default = "default_longest_ms")]
    longest_ms: f64,
    /// Numbers of filters.
    colors: Vec<usize>,
    /// The filters that can be made.
    filters: FilterSpace,
    /// The mosaics to search.
    mosaics: MosaicFamily,
    /// Number of mosaics to draw for each number of filters. By default all are tried if they are at most 256, and those of larger tiles are
    /// annealed.
    mosaic_count: Option<u64>,
    /// What every mosaic must fulfil.
    #[serde(default)]
    rules: LayoutRules,
    /// How the layouts of large tiles are searched.
    #[serde(default)]
    annealing: Annealing,
    /// Whether the published mosaics compete, each with the best filters of the same kind.
    #[serde(default = "yes")]
    rivals: bool,
    /// What is minimised.
    #[serde(default)]
    objective: Objective,
    /// Aims between which the best compromises are wanted as well.
    front: Option<Front>,
    /// How filters differ from those that were wanted.
    #[serde(default)]
    tolerance: Tolerance,
    /// The extent of the search.
    #[serde(default)]
    search: SearchSettings,
    /// The statistics of the light.
    #[serde(default)]
    light: LightSettings,
}

fn default_lights() -> Vec<String> {
    vec!["D65".into()]
}

fn default_luminances() -> Vec<f64> {
    vec![1.0, 10.0, 80.0]
}

fn default_longest_ms() -> f64 {
    33.0
}

fn yes() -> bool {
    true
}

/// A design file with the cameras, illuminants and filters that it refers to.
#[derive(Debug, Clone)]
pub struct LoadedDesign {
    /// The search.
    pub task: DesignTask,
    /// Its purpose.
    pub about: String,
    /// The description of its camera.
    pub camera: CameraDescription,
    /// What was recognised about the files that it refers to; each once.
    pub notes: Vec<String>,
}

/// Reads a design by name or file.
///
/// # Errors
/// When the name is unknown or a key, a value or a file is invalid. The error names the line, if there is one.
pub fn load(name: &str) -> Result<LoadedDesign, Box<Diagnostic>> {
    let source = TomlSource::find("design", DESIGNS, name)?;
    let study = || "this is the file of a study or a camera; smalti sweep takes studies".to_owned();
    let file: DesignFile = source.parse_or_tell(&["optics", "sensor", "sample", "metrics"], study)?;
    let wrong = |key: &str, message: &str| Box::new(source.about_key(key, message));
    // It names the cameras that are found.
    if let Some(c) = file.name.iter().flat_map(|name| name.chars()).find(|&c| steers(c)) {
        let found = format!("it contains the control character U+{:04X}", u32::from(c));
        return Err(wrong("name", &format!("{found}; expected a name in one line")));
    }
    let mut notes = Vec::new();
    let mut filters = file.filters.clone();
    if let Some((library, curves)) = filters.library_mut() {
        for (at, filter) in curves.iter_mut().enumerate() {
            let key = format!("filters.{library}[{at}]");
            let note = read_curve(filter, &source.folder).map_err(|e| wrong(&key, &e))?;
            tell(&mut notes, note);
        }
    }
    let mut rules = file.rules.clone();
    for (letter, filter) in &mut rules.filters {
        let note =
            read_curve(filter, &source.folder).map_err(|e| wrong(&format!("rules.filters.{letter}"), &e))?;
        tell(&mut notes, note);
    }
    if file.luminances_cd_m2.is_empty() {
        return Err(wrong("luminances_cd_m2", "expected at least one luminance"));
    }
    if let Some(bad) = file.luminances_cd_m2.iter().find(|v| !(**v > 0.0 && v.is_finite())) {
        return Err(wrong("luminances_cd_m2", &format!("{bad}; expected numbers above 0")));
    }
    if !(file.longest_ms > 0.0 && file.longest_ms.is_finite()) {
        return Err(wrong("longest_ms", &format!("{}; expected a number above 0", file.longest_ms)));
    }
    if file.colors.is_empty() {
        return Err(wrong("colors", "expected at least one number of filters"));
    }
    let overrides: Vec<Override> =
        file.set.iter().map(|(k, v)| Override { key: k.clone(), value: v.to_string() }).collect();
    let camera_name = cameras::name_beside(&source.folder, &file.camera);
    let loaded = cameras::load_with_notes(&camera_name, &overrides, None)?;
    notes.extend(loaded.notes);
    if file.illuminants.is_empty() {
        return Err(wrong("illuminants", "expected at least one illuminant"));
    }
    let mut illuminants = Vec::new();
    for (at, name) in file.illuminants.iter().enumerate() {
        let (illuminant, note) = lights::load_with_note(name, &source.folder)
            .map_err(|e| wrong(&format!("illuminants[{at}]"), &e.to_string()))?;
        tell(&mut notes, note);
        illuminants.push(illuminant);
    }
    let camera = loaded.camera;
    let condition = |&luminance: &f64| ScreenCondition::of_camera(&camera, luminance, file.longest_ms * 1e-3);
    let stem = Path::new(&source.name).file_stem().map(|s| s.to_string_lossy().into_owned());
    let task = DesignTask {
        name: file.name.clone().or(stem).unwrap_or_else(|| source.name.clone()),
        conditions: file.luminances_cd_m2.iter().map(condition).collect(),
        illuminants,
        colors: file.colors.clone(),
        filters,
        mosaics: file.mosaics.clone(),
        mosaic_count: file.mosaic_count,
        rules,
        annealing: file.annealing,
        rivals: file.rivals,
        objective: file.objective,
        front: file.front.clone(),
        tolerance: file.tolerance,
        search: file.search,
        light: file.light.clone(),
        camera,
    };
    check(&task, &source)?;
    let camera = task.camera.description().clone();
    Ok(LoadedDesign { task, about: file.about, camera, notes })
}

/// The file of a camera with a design.
///
/// # Errors
/// When a value cannot be written as TOML.
pub fn camera_toml(
    design: &Design,
    fixed: &CameraDescription,
    name: &str,
) -> Result<String, Box<Diagnostic>> {
    own_camera_toml(&CameraDescription { name: name.to_owned(), ..design.camera(fixed) })
}

/// The file of a camera as it is.
///
/// # Errors
/// When a value cannot be written as TOML.
pub fn own_camera_toml(camera: &CameraDescription) -> Result<String, Box<Diagnostic>> {
    toml::to_string(camera).map_err(|e| Box::new(Diagnostic::new(&camera.name, e.to_string())))
}

/// A value as TOML.
///
/// # Errors
/// When it cannot be written as TOML.
pub fn toml_text(value: &impl serde::Serialize) -> Result<String, Box<Diagnostic>> {
    toml::to_string(value).map_err(|e| Box::new(Diagnostic::new("value", e.to_string())))
}

/// Checks what can be checked before any scene is imaged, so that errors have their lines.
fn check(task: &DesignTask, source: &TomlSource) -> Result<(), Box<Diagnostic>> {
    let shown = |table: &str, e: DesignError| match &e {
        DesignError::Key { key, message } => {
            // Families know the keys below their table only.
            let is_whole = table.is_empty() || key.starts_with("rules.") || key == "colors";
            let key = if is_whole { key.clone() } else { format!("{table}.{key}") };
            Box::new(source.about_key(&key, message))
        }
        _ => Box::new(source.about_key(if table.is_empty() { "colors" } else { table }, &e.to_string())),
    };
    task.validate().map_err(|e| shown("", e))?;
    task.light.validate().map_err(|e| shown("light", e))?;
    task.filters.sampled(task.camera.grid()).map_err(|e| shown("filters", e))?;
    let mut has_mosaics = false;
    for &colors in &task.colors {
        let listed = task.listed_mosaics(colors).map_err(|e| shown("mosaics", e))?;
        has_mosaics |= listed.is_none_or(|mosaics| !mosaics.is_empty());
    }
    if !has_mosaics {
        let message = format!("no mosaic has {:?} filters", task.colors);
        return Err(Box::new(source.about_key("mosaics", &message)));
    }
    Ok(())
}
