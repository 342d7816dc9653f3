//! Studies by name or file: described in TOML, checked, resolved.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;
use smalti::camera::CameraDescription;
use smalti::camera::description::ArchitectureName;
use smalti::design::{
    Condition, ConditionValue, DesignError, Designs, FilterFamily, LessonSettings, MosaicFamily, Processing,
    Study,
};
use smalti::names::nearest;
use smalti::spectrum::Illuminant;

use crate::camera_toml::{CameraSource, Override, beside};
use crate::cameras::read_curve;
use crate::diagnostic::Diagnostic;
use crate::{cameras, spectrum_csv, text};

/// A built-in study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StudyInfo {
    /// Its name.
    pub name: &'static str,
    /// What it asks.
    pub summary: &'static str,
    /// Its file.
    pub toml: &'static str,
}

macro_rules! builtin {
    ($name:literal, $summary:literal) => {
        StudyInfo {
            name: $name,
            summary: $summary,
            toml: include_str!(concat!("../studies/", $name, ".toml")),
        }
    };
}

static STUDIES: &[StudyInfo] = &[
    builtin!("table2", "What more colours cost: 1000 sets of Gaussian filters for each of 3 to 7 colours"),
    builtin!(
        "table2-l3",
        "The same with a pipeline learned for each design in place of bilinear demosaicking"
    ),
    builtin!("theory", "Filters by rule: uniform, height-scaled, all-scaled, 3 to 7 colours"),
    builtin!("mosaics", "Where to put the filters: 1000 placements for each of 3 to 7 colours"),
    builtin!("aliasing", "Published mosaics and the aliasing of each"),
];

/// The built-in studies.
#[must_use]
pub fn names() -> &'static [StudyInfo] {
    STUDIES
}

/// Most conditions of a study: a grid of axes grows fast.
const MAX_CONDITIONS: usize = 5_000;

/// A study file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct StudyFile {
    /// What the study is called.
    name: Option<String>,
    /// What it asks, in a sentence.
    #[serde(default)]
    about: String,
    /// The camera whose filters are searched: a name or a file.
    camera: String,
    /// Keys of the camera that differ, such as `"optics.f_number" = 2.8`.
    #[serde(default)]
    set: BTreeMap<String, toml::Value>,
    /// Mean luminance of the targets, cd/m².
    #[serde(default = "default_luminance")]
    luminance_cd_m2: f64,
    /// The light of the targets.
    #[serde(default = "default_light")]
    illuminant: String,
    /// Decides which designs are drawn, and the noise.
    #[serde(default = "default_seed")]
    seed: u64,
    /// Numbers of colours.
    colors: Vec<usize>,
    /// What makes pictures of raw samples: one or several.
    #[serde(default)]
    processing: OneOrMore<Processing>,
    /// Whether aliasing on the zone plate is scored too, for some milliseconds a design.
    #[serde(default)]
    aliasing: bool,
    /// How pipelines of designs are learned where `processing` has `"l3"`.
    #[serde(default)]
    l3: LessonSettings,
    /// How many of each family.
    #[serde(default)]
    sample: Sample,
    /// The filters.
    filters: FilterFamily,
    /// The mosaics.
    mosaics: MosaicFamily,
    /// What designs are seen under.
    conditions: Option<Conditions>,
}

fn default_luminance() -> f64 {
    75.0
}

fn default_light() -> String {
    "D65".into()
}

fn default_seed() -> u64 {
    1
}

#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "expected \"classic\", \"l3\" or a list of them")]
enum OneOrMore<T> {
    One(T),
    More(Vec<T>),
}

impl Default for OneOrMore<Processing> {
    fn default() -> Self {
        Self::One(Processing::Classic)
    }
}

/// How many designs of the families are taken.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Sample {
    /// Sets of filters for each number of colours.
    filters: Count,
    /// Mosaics for each number of colours.
    mosaics: Count,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(untagged, expecting = "expected a whole number or \"all\"")]
enum Count {
    Number(u64),
    All(All),
    #[default]
    #[serde(skip)]
    Unsaid,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case")]
enum All {
    All,
}

impl Count {
    fn number(&self) -> Option<u64> {
        match self {
            Self::Number(n) => Some(*n),
            Self::All(All::All) | Self::Unsaid => None,
        }
    }
}

/// `[conditions.grid]`: every combination of the axes; `[[conditions.list]]`: one by one.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Conditions {
    Grid(BTreeMap<String, Axis>),
    List(Vec<BTreeMap<String, toml::Value>>),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a list of values, or { from, to, steps } with scale = \"linear\" or \"log\""
)]
enum Axis {
    Values(Vec<toml::Value>),
    Range(AxisRange),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisRange {
    from: f64,
    to: f64,
    steps: usize,
    #[serde(default)]
    scale: AxisScale,
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum AxisScale {
    #[default]
    Linear,
    Log,
}

impl Axis {
    fn values(&self) -> Result<Vec<toml::Value>, String> {
        let range = match self {
            Self::Values(values) => return Ok(values.clone()),
            Self::Range(range) => range,
        };
        let AxisRange { from, to, steps, scale } = *range;
        let positive = from > 0.0 && to > 0.0;
        let ends = from.is_finite() && to.is_finite();
        if !(ends && (1..=MAX_CONDITIONS).contains(&steps)) {
            return Err(format!(
                "{from} to {to} in {steps} steps; expected finite ends and 1 to {MAX_CONDITIONS} steps"
            ));
        }
        if matches!(scale, AxisScale::Log) && !positive {
            return Err(format!("{from} to {to} on a logarithmic scale; expected ends above 0"));
        }
        let at = |i: usize| {
            let t = if steps > 1 { i as f64 / (steps - 1) as f64 } else { 0.0 };
            match scale {
                AxisScale::Linear => from + t * (to - from),
                AxisScale::Log => from * libm::pow(to / from, t),
            }
        };
        // Free of the digits that arithmetic leaves: twelve are more than any condition means.
        let rounded = |v: f64| format!("{v:.12e}").parse().unwrap_or(v);
        Ok((0..steps).map(|i| toml::Value::Float(rounded(at(i)))).collect())
    }
}

/// A study by name or file, resolved, with what it is about: cameras, lights and filters that it names are read. A `.json` file
/// is a study that was resolved before, or the manifest of its results.
///
/// # Errors
/// When there is none of that name, or a key, a value or a file does not fit, with the line where there is one; when the study
/// has no design.
pub fn load(name: &str) -> Result<(Designs, String), Box<Diagnostic>> {
    if Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return resolved(name);
    }
    let source = source(name)?;
    from_source(&source)
}

/// A study as JSON: names no file, needs nothing else.
fn resolved(name: &str) -> Result<(Designs, String), Box<Diagnostic>> {
    let wrong = |message: String| Box::new(Diagnostic::new(name, message));
    let text = text::read_to_string(Path::new(name)).map_err(|e| wrong(e.to_string()))?;
    let value: Value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    let study = value.get("study").unwrap_or(&value);
    let about = study.get("about").and_then(Value::as_str).unwrap_or_default().to_owned();
    let study = Study::deserialize(study).map_err(|e| wrong(format!("it is no resolved study: {e}")))?;
    if study.processing.contains(&Processing::L3) {
        study.l3.validate().map_err(|e| wrong(e.to_string()))?;
    }
    Ok((Designs::new(study).map_err(|e| wrong(e.to_string()))?, about))
}

/// A study from the text of its file.
///
/// # Errors
/// As [`load`].
pub fn from_source(source: &CameraSource) -> Result<(Designs, String), Box<Diagnostic>> {
    let file: StudyFile =
        toml::from_str(&source.text).map_err(|e| Box::new(source.at(e.span(), e.message())))?;
    let wrong = |key: &str, message: &str| Box::new(source.about_key(key, message));
    let mut filters = file.filters.clone();
    for (place, filter) in filters.filters_mut() {
        read_curve(filter, &source.folder).map_err(|e| wrong(&format!("filters.{place}"), &e))?;
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
        conditions: conditions(&file, source)?,
        processing: match &file.processing {
            OneOrMore::One(p) => vec![*p],
            OneOrMore::More(list) => list.clone(),
        },
        l3: file.l3.clone(),
        aliasing: file.aliasing,
    };
    let mut seen = std::collections::BTreeSet::new();
    if let Some(twice) = file.colors.iter().find(|c| !seen.insert(**c)) {
        return Err(wrong("colors", &format!("{twice} stands there twice")));
    }
    let mut seen = std::collections::BTreeSet::new();
    if let Some(twice) = study.processing.iter().find(|p| !seen.insert(**p)) {
        return Err(wrong("processing", &format!("{twice:?} stands there twice")));
    }
    if study.processing.contains(&Processing::L3) {
        study.l3.validate().map_err(|e| wrong("l3", &e.to_string()))?;
        let other = |c: &Condition| c.camera.sensor.architecture != ArchitectureName::Mosaic;
        if study.conditions.iter().any(other) {
            let message = "\"l3\" learns for mosaics; expected a camera with architecture = \"mosaic\"";
            return Err(wrong("processing", message));
        }
    }
    let designs = Designs::new(study).map_err(|e| match &e {
        DesignError::Key { key, message } if key.starts_with("given") || key.starts_with("tile") => {
            wrong(&format!("mosaics.{key}"), message)
        }
        DesignError::Key { key, message } => wrong(&format!("filters.{key}"), message),
        DesignError::Filter { .. } => wrong("filters", &e.to_string()),
        DesignError::TooFewSets { .. } | DesignError::TooManySets { .. } => {
            wrong("sample.filters", &e.to_string())
        }
        DesignError::TooFew { .. } | DesignError::TooMany { .. } => wrong("sample.mosaics", &e.to_string()),
        _ => Box::new(Diagnostic::new(source.name.clone(), e.to_string())),
    })?;
    Ok((designs, file.about))
}

fn source(name: &str) -> Result<CameraSource, Box<Diagnostic>> {
    if let Some(s) = STUDIES.iter().find(|s| s.name == name) {
        return Ok(CameraSource { name: name.into(), folder: PathBuf::new(), text: s.toml.into() });
    }
    let path = Path::new(name);
    let is_file = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) || path.is_file();
    if !is_file {
        let known: Vec<&str> = STUDIES.iter().map(|s| s.name).collect();
        let list = format!("built in: {}; or give a .toml file", known.join(", "));
        let help = match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean '{near}'? {list}"),
            None => list,
        };
        return Err(Box::new(Diagnostic { help: Some(help), ..Diagnostic::new(name, "no such study") }));
    }
    let text = text::read_to_string(path).map_err(|e| Box::new(Diagnostic::new("study", e.to_string())))?;
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    Ok(CameraSource { name: name.into(), folder, text })
}

/// The conditions: of a grid in the order of its keys by name, of which the last changes fastest; or of the list.
fn conditions(file: &StudyFile, source: &CameraSource) -> Result<Vec<Condition>, Box<Diagnostic>> {
    let wrong = |key: &str, message: &str| Box::new(source.about_key(key, message));
    let mut points: Vec<Vec<(String, toml::Value)>> = vec![Vec::new()];
    match &file.conditions {
        None => {}
        Some(Conditions::Grid(axes)) => {
            for (key, axis) in axes {
                let values = axis.values().map_err(|e| wrong("conditions.grid", &format!("`{key}`: {e}")))?;
                if points.len().saturating_mul(values.len()) > MAX_CONDITIONS {
                    return Err(wrong("conditions.grid", &format!("more than {MAX_CONDITIONS} conditions")));
                }
                let with = |point: &Vec<(String, toml::Value)>| {
                    let point = point.clone();
                    let key = key.clone();
                    values.clone().into_iter().map(move |v| {
                        let mut longer = point.clone();
                        longer.push((key.clone(), v));
                        longer
                    })
                };
                points = points.iter().flat_map(with).collect();
            }
        }
        Some(Conditions::List(list)) => {
            points = list.iter().map(|point| point.clone().into_iter().collect()).collect();
            let keys = |p: &Vec<(String, toml::Value)>| p.iter().map(|(k, _)| k.clone()).collect::<Vec<_>>();
            if let Some(other) = points.iter().position(|p| keys(p) != keys(&points[0])) {
                let message = format!("entry {} names other keys than the first", other + 1);
                return Err(wrong("conditions.list", &message));
            }
        }
    }
    points.into_iter().map(|point| condition(file, source, point)).collect()
}

/// A TOML value as `--set` takes it.
fn as_override(key: &str, value: &toml::Value) -> Override {
    Override { key: key.into(), value: value.to_string() }
}

fn condition(
    file: &StudyFile,
    source: &CameraSource,
    point: Vec<(String, toml::Value)>,
) -> Result<Condition, Box<Diagnostic>> {
    let wrong = |key: &str, message: &str| Box::new(source.about_key(key, message));
    let (mut luminance_cd_m2, mut light) = (file.luminance_cd_m2, file.illuminant.clone());
    let mut overrides: Vec<Override> = file.set.iter().map(|(k, v)| as_override(k, v)).collect();
    let mut values = Vec::new();
    for (key, value) in point {
        let number = value.as_float().or_else(|| value.as_integer().map(|i| i as f64));
        match (key.as_str(), number, value.as_str()) {
            ("luminance_cd_m2", Some(v), _) => luminance_cd_m2 = v,
            ("illuminant", _, Some(name)) => light = name.to_owned(),
            ("luminance_cd_m2", None, _) => {
                return Err(wrong("conditions", "`luminance_cd_m2`: expected a number"));
            }
            ("illuminant", _, None) => return Err(wrong("conditions", "`illuminant`: expected a name")),
            _ => overrides.push(as_override(&key, &value)),
        }
        let text = || ConditionValue::Text(value.as_str().map_or_else(|| value.to_string(), str::to_owned));
        values.push((key, number.map_or_else(text, ConditionValue::Number)));
    }
    if !(luminance_cd_m2 > 0.0 && luminance_cd_m2.is_finite()) {
        return Err(wrong("luminance_cd_m2", &format!("{luminance_cd_m2}; expected a number above 0")));
    }
    let is_file = Path::new(&file.camera).extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let camera = if is_file {
        beside(&source.folder, &file.camera).to_string_lossy().into_owned()
    } else {
        file.camera.clone()
    };
    let camera = cameras::load(&camera, &overrides, None)?;
    Ok(Condition {
        values,
        luminance_cd_m2,
        illuminant: illuminant(&light, &source.folder).map_err(|e| wrong("illuminant", &e))?,
        camera: CameraDescription::clone(camera.description()),
    })
}

fn illuminant(name: &str, folder: &Path) -> Result<Illuminant, String> {
    let file = name.split('#').next().unwrap_or(name);
    if Path::new(file).extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
        let path = beside(folder, name);
        let power = spectrum_csv::read_spectrum(&path.to_string_lossy()).map_err(|e| e.to_string())?;
        return Ok(Illuminant::Measured { name: name.to_owned(), power });
    }
    Illuminant::from_name(name).map_err(|e| e.to_string())
}
