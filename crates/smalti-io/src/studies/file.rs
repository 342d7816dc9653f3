//! The keys of a study file.

use std::collections::BTreeMap;

use serde::Deserialize;
use smalti::design::{FilterFamily, LearningSettings, Metric, MosaicFamily, TrialProcessing};

/// Maximum number of conditions, since a grid with several axes grows fast.
pub(super) const MAX_CONDITIONS: usize = 5_000;

/// A study file.
#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    /// Name of the study. The default is the file name without its extension.
    pub(super) name: Option<String>,
    /// Purpose of the study, in one sentence.
    #[serde(default)]
    pub(super) about: String,
    /// Name or file of the camera. Each design replaces its colour filter array.
    pub(super) camera: String,
    /// Changed keys of the camera, such as `"optics.f_number" = 2.8`.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "BTreeMap<String, serde_json::Value>"))]
    pub(super) set: BTreeMap<String, toml::Value>,
    /// Mean luminance of the targets, cd/m².
    #[serde(default = "default_luminance")]
    pub(super) luminance_cd_m2: f64,
    /// Illuminant of the targets: a name or a CSV file.
    #[serde(default = "default_light")]
    pub(super) illuminant: String,
    /// Seed of the random designs and of the noise.
    #[serde(default = "default_seed")]
    pub(super) seed: u64,
    /// Numbers of colours.
    pub(super) colors: Vec<usize>,
    /// Processing of the raw samples: one kind or a list.
    #[serde(default)]
    pub(super) processing: OneOrMore<TrialProcessing>,
    /// Metrics of the study. The default is the first five, and with `scenes` also the last three.
    pub(super) metrics: Option<Vec<Metric>>,
    /// Scenes that designs are scored on in addition to the targets: names with parameters, or files. Each takes about ten milliseconds per
    /// design.
    #[serde(default)]
    pub(super) scenes: Vec<String>,
    /// Training settings for the processing `"l3"`.
    #[serde(default)]
    pub(super) l3: LearningSettings,
    /// Numbers of filter sets and mosaics.
    #[serde(default)]
    pub(super) sample: Sample,
    /// The filters.
    pub(super) filters: FilterFamily,
    /// The mosaics.
    pub(super) mosaics: MosaicFamily,
    /// Conditions under which designs are scored.
    pub(super) conditions: Option<Conditions>,
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "expected \"classic\", \"l3\" or a list of them")]
pub(super) enum OneOrMore<T> {
    One(T),
    More(Vec<T>),
}

impl OneOrMore<TrialProcessing> {
    pub(super) fn list(&self) -> Vec<TrialProcessing> {
        match self {
            Self::One(p) => vec![*p],
            Self::More(list) => list.clone(),
        }
    }
}

impl Default for OneOrMore<TrialProcessing> {
    fn default() -> Self {
        Self::One(TrialProcessing::Classic)
    }
}

/// Numbers of filter sets and mosaics that are drawn from the families.
#[derive(Debug, Clone, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub(super) struct Sample {
    /// Number of filter sets for each number of colours. The default is all.
    pub(super) filters: Count,
    /// Number of mosaics for each number of colours. The default is all.
    pub(super) mosaics: Count,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "expected a whole number or \"all\"")]
pub(super) enum Count {
    Number(u64),
    All(All),
    #[default]
    #[serde(skip)]
    Unsaid,
}

#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(super) enum All {
    All,
}

impl Count {
    pub(super) fn number(&self) -> Option<u64> {
        match self {
            Self::Number(n) => Some(*n),
            Self::All(All::All) | Self::Unsaid => None,
        }
    }
}

/// The conditions: `[conditions.grid]` for all combinations of axes, or `[[conditions.list]]` for a list.
#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Conditions {
    /// All combinations of the axes. An axis is a list of values or `{ from, to, steps, scale }`.
    Grid(BTreeMap<String, Axis>),
    /// A list of conditions. All entries have the same keys.
    List(
        #[cfg_attr(feature = "schema", schemars(with = "Vec<BTreeMap<String, serde_json::Value>>"))]
        Vec<BTreeMap<String, toml::Value>>,
    ),
}

#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "expected a list of values, or { from, to, steps } with scale = \"linear\" or \"log\""
)]
pub(super) enum Axis {
    Values(#[cfg_attr(feature = "schema", schemars(with = "Vec<serde_json::Value>"))] Vec<toml::Value>),
    Range(AxisRange),
}

#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct AxisRange {
    from: f64,
    to: f64,
    steps: usize,
    #[serde(default)]
    scale: AxisScale,
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum AxisScale {
    #[default]
    Linear,
    Log,
}

impl Axis {
    pub(super) fn values(&self) -> Result<Vec<toml::Value>, String> {
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
        // 13 significant digits are enough for any condition and hide rounding errors.
        let rounded = |v: f64| format!("{v:.12e}").parse().unwrap_or(v);
        Ok((0..steps).map(|i| toml::Value::Float(rounded(at(i)))).collect())
    }
}
