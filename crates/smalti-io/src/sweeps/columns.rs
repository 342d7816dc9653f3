//! Columns of the results of a sweep, with one row per trial.

use smalti::design::{
    ConditionValue, DesignError, EdgeScores, FilterFamily, FilterFigures, Metric, MetricTarget, ScoredTrial,
    Scores, Study, StudyScene, Trials, column_of_key,
};
use smalti::metrics::{CATALOG, MetricInfo};

use crate::dataset::{Column, ColumnKind, ColumnSpec};

/// Column name, metric and index of the scene for each column of metrics, in order. Metrics of scenes have a column for each scene.
fn metrics(study: &Study) -> Vec<(String, Metric, usize)> {
    let mut all = Vec::new();
    for &metric in &study.metrics {
        if metric.target() != MetricTarget::Scenes {
            all.push((metric.name().to_owned(), metric, 0));
            continue;
        }
        let of_scenes = (0..study.scenes.len()).map(|i| (scene_column(study, metric.name(), i), metric, i));
        all.extend(of_scenes);
    }
    all
}

/// The column name for a figure of a scene of the study.
fn scene_column(study: &Study, figure: &str, scene: usize) -> String {
    let name = |scene: &StudyScene| column_of_key(scene.short_name());
    let own = study.scenes.get(scene).map(name).unwrap_or_default();
    // Scenes with the same name are numbered by their position in the study.
    let alike = study.scenes.iter().filter(|s| name(s) == own).count();
    let place = if alike > 1 { format!("_{}", scene + 1) } else { String::new() };
    format!("{figure}_{own}{place}")
}

/// The share of saturated samples of a scene.
const SATURATED: &str = "saturated_percent";

/// Whether a metric of the study is measured on the edge target, which is then exposed.
fn looks_at_edge(study: &Study) -> bool {
    study.metrics.iter().any(|m| m.target() == MetricTarget::Edge)
}

/// Whether the names of filter sets add to the filter columns. A Gaussian grid names its sets by centre and width alone.
fn named(study: &Study) -> bool {
    !matches!(study.filters, FilterFamily::GaussianGrid(_))
}

/// Whether the key of this index has a number in every condition.
fn all_numbers(study: &Study, condition: usize) -> bool {
    let value = |c: &smalti::design::Condition| {
        matches!(c.values.get(condition), Some((_, ConditionValue::Number(_))))
    };
    study.conditions.iter().all(value)
}

/// The columns of the results of a study.
#[must_use]
pub fn schema(study: &Study) -> Vec<ColumnSpec> {
    use ColumnKind::{Float, Floats, Int, Text};
    let column = |name: &str, kind: ColumnKind, unit: &str, doc: &str| ColumnSpec {
        name: name.into(),
        kind,
        unit: unit.into(),
        doc: doc.into(),
    };
    let mut all = vec![
        column("trial", Int, "", "Number of the trial in the study, from 0."),
        column("colors", Int, "", "Number of colours."),
        column("processing", Text, "", "The processing of the raw images: classic or l3."),
    ];
    for (at, (key, _)) in study.conditions.first().map_or(&[][..], |c| &c.values).iter().enumerate() {
        let kind = if all_numbers(study, at) { Float } else { Text };
        all.push(column(
            &column_of_key(key),
            kind,
            "",
            &format!("Value of the condition `{key}`, in the unit of that key."),
        ));
    }
    if named(study) {
        all.push(column("filters", Text, "", "Name of the set of filters in its family."));
    }
    all.extend([
        column("tile", Text, "", "The mosaic, one letter per pixel, rows separated by /; a is the filter of the shortest wavelengths."),
        column(
            "center_nm",
            Floats,
            "nm",
            "Centre of each filter if its shape has one, otherwise its mean wavelength.",
        ),
        column("fwhm_nm", Floats, "nm", "Width over which each filter passes at least half of its peak."),
        column("peak", Floats, "", "Maximum transmittance of each filter."),
    ]);
    for (name, metric, scene) in metrics(study) {
        let info = CATALOG.iter().find(|m| m.name == metric.name());
        let (unit, doc) = info.map_or(("", ""), |MetricInfo { unit, doc, .. }| (*unit, *doc));
        let of = study.scenes.get(scene).filter(|_| metric.target() == MetricTarget::Scenes);
        let of = of.map_or_else(String::new, |s| format!(" Of the scene {}.", s.name));
        all.push(column(&name, Float, unit, &format!("{doc}{of}")));
    }
    for (scene, of) in study.scenes.iter().enumerate() {
        let doc = format!("Percentage of the raw samples at the white level. Of the scene {}.", of.name);
        all.push(column(&scene_column(study, SATURATED, scene), Float, "%", &doc));
    }
    all.push(column("macbeth_time_s", Float, "s", "Exposure time of the ColorChecker."));
    let saturated = |target: &str| {
        format!("Percentage of the raw samples of {target} at the white level, without noise.")
    };
    all.push(column("macbeth_saturated_percent", Float, "%", &saturated("the ColorChecker")));
    if looks_at_edge(study) {
        all.push(column("edge_time_s", Float, "s", "Exposure time of the edge."));
        all.push(column("edge_saturated_percent", Float, "%", &saturated("the edge")));
        all.push(column(
            "mtf50_reliability",
            Text,
            "",
            "Whether MTF50 is a resolution: reliable; beyond-nyquist, where the detail is aliased; plateau, where the response stays near one half or rises again; empty without an MTF50.",
        ));
    }
    all.push(column("problem", Text, "", "Reason for missing scores; empty if the trial has all."));
    all
}

/// The values of the columns of [`schema`] for these trials, one row per trial.
///
/// # Errors
/// When a filter cannot be sampled.
pub fn columns(trials: &Trials, rows: &[ScoredTrial]) -> Result<Vec<Column>, DesignError> {
    let study = trials.study();
    let text = |f: &dyn Fn(&ScoredTrial) -> String| Column::Text(rows.iter().map(f).collect());
    let number = |f: &dyn Fn(&ScoredTrial) -> f64| Column::Float(rows.iter().map(f).collect());
    let figures =
        rows.iter().map(|r| r.trial.design.filters.figures()).collect::<Result<Vec<_>, DesignError>>()?;
    let lists = |f: &dyn Fn(&FilterFigures) -> f64| {
        Column::Floats(figures.iter().map(|row| row.iter().map(f).collect()).collect())
    };
    let mut all = vec![
        Column::Int(rows.iter().map(|r| r.trial.number as i64).collect()),
        Column::Int(rows.iter().map(|r| r.trial.design.filters.filters.len() as i64).collect()),
        text(&|r| r.trial.processing.name().to_owned()),
    ];
    let keys = study.conditions.first().map_or(0, |c| c.values.len());
    for key in 0..keys {
        let value = |r: &ScoredTrial| study.conditions.get(r.trial.condition).and_then(|c| c.values.get(key));
        all.push(if all_numbers(study, key) {
            number(&|r| match value(r) {
                Some((_, ConditionValue::Number(v))) => *v,
                _ => f64::NAN,
            })
        } else {
            text(&|r| value(r).map_or_else(String::new, |(_, v)| v.to_string()))
        });
    }
    if named(study) {
        all.push(text(&|r| r.trial.design.filters.label.clone()));
    }
    all.extend([
        text(&|r| r.trial.design.tile()),
        lists(&|f| f.center_nm),
        lists(&|f| f.fwhm_nm),
        lists(&|f| f.peak),
    ]);
    for (_, metric, scene) in metrics(study) {
        all.push(number(&|r| r.value(metric, scene).unwrap_or(f64::NAN)));
    }
    for scene in 0..study.scenes.len() {
        let saturated = |s: &Scores| Some(s.scenes.get(scene)?.as_ref().ok()?.saturated_percent);
        all.push(number(&|r| r.scores.as_ref().ok().and_then(saturated).unwrap_or(f64::NAN)));
    }
    all.push(number(&|r| r.scores.as_ref().map_or(f64::NAN, |s| s.macbeth_time_s)));
    all.push(number(&|r| r.scores.as_ref().map_or(f64::NAN, |s| s.macbeth_saturated_percent)));
    if looks_at_edge(study) {
        fn edge(r: &ScoredTrial) -> Option<&EdgeScores> {
            r.scores.as_ref().ok()?.edge.as_ref()?.as_ref().ok()
        }
        all.push(number(&|r| edge(r).map_or(f64::NAN, |e| e.time_s)));
        all.push(number(&|r| edge(r).map_or(f64::NAN, |e| e.saturated_percent)));
        all.push(text(&|r| edge(r).map_or_else(String::new, |e| e.mtf50_reliability.name().into())));
    }
    all.push(text(&ScoredTrial::problem));
    Ok(all)
}
