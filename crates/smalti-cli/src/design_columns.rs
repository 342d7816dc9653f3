//! The columns of a sweep's results: a row for each design.

use smalti::design::{
    ConditionValue, Designs, FilterFamily, FilterFigures, Processing, Scored, Scores, Study,
};
use smalti::metrics::{CATALOG, MetricInfo};
use smalti_io::dataset::{Column, ColumnKind, ColumnSpec};

/// The name that a processing has in results and study files.
pub(crate) fn processing(of: Processing) -> String {
    serde_json::to_value(of).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

/// A key of a condition as the name of a column: `optics.f_number` becomes `optics_f_number`.
pub(crate) fn condition_column(key: &str) -> String {
    key.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

/// Figures of a design that are metrics, by their names.
const METRICS: [&str; 5] =
    ["delta_e_76", "delta_e_2000", "mtf50_cy_per_mm", "mtf50_cy_per_px", "luminance_noise_percent"];
const ALIASING: [&str; 2] = ["aliasing_percent", "color_aliasing_percent"];

/// Whether sets of filters have names that say more than their figures.
fn named(study: &Study) -> bool {
    !matches!(study.filters, FilterFamily::GaussianGrid(_))
}

/// Whether a condition is a number wherever it is stated.
fn all_numbers(study: &Study, condition: usize) -> bool {
    let value = |c: &smalti::design::Condition| {
        matches!(c.values.get(condition), Some((_, ConditionValue::Number(_))))
    };
    study.conditions.iter().all(value)
}

/// The columns of a study.
pub(crate) fn schema(study: &Study) -> Vec<ColumnSpec> {
    use ColumnKind::{Float, Floats, Int, Text};
    let column = |name: &str, kind: ColumnKind, unit: &str, doc: &str| ColumnSpec {
        name: name.into(),
        kind,
        unit: unit.into(),
        doc: doc.into(),
    };
    let mut all = vec![
        column("design", Int, "", "Number of the design in the study, from 0."),
        column("colors", Int, "", "Number of colours."),
        column("processing", Text, "", "What makes the picture of the raw samples."),
    ];
    for (at, (key, _)) in study.conditions.first().map_or(&[][..], |c| &c.values).iter().enumerate() {
        let kind = if all_numbers(study, at) { Float } else { Text };
        all.push(column(
            &condition_column(key),
            kind,
            "",
            &format!("The condition `{key}`, in the unit of its key."),
        ));
    }
    if named(study) {
        all.push(column("filters", Text, "", "What the family calls the set of filters."));
    }
    all.extend([
        column("tile", Text, "", "The mosaic, rows apart by /; a is the filter of the shortest wavelengths."),
        column(
            "center_nm",
            Floats,
            "nm",
            "Middle of each filter: where it is formed by one, else its mean wavelength.",
        ),
        column("fwhm_nm", Floats, "nm", "Width in which each filter passes at least half of its peak."),
        column("peak", Floats, "", "Largest transmittance of each filter."),
    ]);
    for name in METRICS.iter().chain(ALIASING.iter().filter(|_| study.aliasing)) {
        let info = CATALOG.iter().find(|m| m.name == *name);
        let (unit, doc) = info.map_or(("", ""), |MetricInfo { unit, doc, .. }| (*unit, *doc));
        all.push(column(name, Float, unit, doc));
    }
    all.extend([
        column("macbeth_time_s", Float, "s", "Exposure time of the ColorChecker."),
        column("edge_time_s", Float, "s", "Exposure time of the edge."),
        column("problem", Text, "", "Why a design has no scores; empty where it has them."),
    ]);
    all
}

/// The rows of designs, column by column, in the order of the schema.
pub(crate) fn columns(designs: &Designs, rows: &[Scored]) -> Vec<Column> {
    let study = designs.study();
    let text = |f: &dyn Fn(&Scored) -> String| Column::Text(rows.iter().map(f).collect());
    let number = |f: &dyn Fn(&Scored) -> f64| Column::Float(rows.iter().map(f).collect());
    let lists = |f: &dyn Fn(&FilterFigures) -> f64| {
        let of = |r: &Scored| r.design.filters.filters.iter().map(|filter| f(&filter.into())).collect();
        Column::Floats(rows.iter().map(of).collect())
    };
    let mut all = vec![
        Column::Int(rows.iter().map(|r| r.design.number as i64).collect()),
        Column::Int(rows.iter().map(|r| r.design.filters.filters.len() as i64).collect()),
        text(&|r| processing(r.design.processing)),
    ];
    let keys = study.conditions.first().map_or(0, |c| c.values.len());
    for key in 0..keys {
        let value = |r: &Scored| study.conditions.get(r.design.condition).and_then(|c| c.values.get(key));
        all.push(if all_numbers(study, key) {
            number(&|r| match value(r) {
                Some((_, ConditionValue::Number(v))) => *v,
                _ => f64::NAN,
            })
        } else {
            text(&|r| match value(r) {
                Some((_, ConditionValue::Text(t))) => t.clone(),
                Some((_, ConditionValue::Number(v))) => v.to_string(),
                None => String::new(),
            })
        });
    }
    if named(study) {
        all.push(text(&|r| r.design.filters.label.clone()));
    }
    all.extend([
        text(&|r| r.design.tile()),
        lists(&|f| f.center_nm),
        lists(&|f| f.fwhm_nm),
        lists(&|f| f.peak),
    ]);
    let score = |f: &dyn Fn(&Scores) -> f64| number(&|r| r.scores.as_ref().map_or(f64::NAN, f));
    all.extend([
        score(&|s| s.delta_e_76),
        score(&|s| s.delta_e_2000),
        score(&|s| s.mtf50_cy_per_mm),
        score(&|s| s.mtf50_cy_per_px),
        score(&|s| s.luminance_noise_percent),
    ]);
    if study.aliasing {
        all.push(number(&|r| r.aliasing.map_or(f64::NAN, |a| a.aliasing_percent)));
        all.push(number(&|r| r.aliasing.map_or(f64::NAN, |a| a.color_aliasing_percent)));
    }
    all.extend([
        score(&|s| s.macbeth_time_s),
        score(&|s| s.edge_time_s),
        text(&|r| r.scores.as_ref().err().map(ToString::to_string).unwrap_or_default()),
    ]);
    all
}
