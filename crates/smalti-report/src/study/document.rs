//! The report as one JSON document.

use serde_json::{Map, Value, json};
use smalti::design::statistics::{Estimate, Summary};
use smalti::design::{ColumnValues, FilterFigures};

use super::results::Results;
use super::sections::{CONFIDENCE, Group, Section};
use crate::ReportError;

/// The largest number of trials of a front in the document.
const FRONT: usize = 1000;

/// Columns that say under which conditions a trial was scored, and how far its resolution can be trusted.
const CONDITIONS: [&str; 5] = [
    "macbeth_time_s",
    "macbeth_saturated_percent",
    "edge_time_s",
    "edge_saturated_percent",
    "mtf50_reliability",
];

/// All that the tables contain and more. `figures` are the files, relative to the folder.
pub(super) fn document(
    all: &[(&Results, Vec<Section<'_>>)],
    figures: &[String],
    notes: &[String],
) -> Result<Value, ReportError> {
    let studies =
        all.iter().map(|(r, sections)| study(r, sections)).collect::<Result<Vec<_>, ReportError>>()?;
    Ok(json!({
        "smalti_version": env!("CARGO_PKG_VERSION"),
        "confidence": CONFIDENCE,
        "studies": studies,
        "figures": figures,
        "notes": notes,
    }))
}

fn study(results: &Results, sections: &[Section<'_>]) -> Result<Value, ReportError> {
    let data = &results.data;
    Ok(json!({
        "name": results.study().name,
        "about": results.about(),
        "folder": data.origin,
        "plan_blake3": data.plan_blake3,
        "scored_by": data.smalti_version,
        "trials": data.trials.len(),
        "trials_missing": data.trials.len() - data.numbers.len() as u64,
        "parts_missing": data.parts_missing,
        "problems": results.problems,
        "sections": sections.iter().map(section).collect::<Result<Vec<_>, ReportError>>()?,
    }))
}

fn section(section: &Section<'_>) -> Result<Value, ReportError> {
    let (mut condition, mut out) = (Map::new(), Map::new());
    if let Some((seen_under, way)) = section.results.setup(section.setup) {
        for (key, value) in &seen_under.values {
            condition.insert(key.clone(), serde_json::to_value(value)?);
        }
        out.insert("condition".into(), condition.into());
        out.insert("camera".into(), seen_under.camera.name.clone().into());
        out.insert("description".into(), serde_json::to_value(&seen_under.camera)?);
        out.insert("luminance_cd_m2".into(), seen_under.luminance_cd_m2.into());
        out.insert("illuminant".into(), seen_under.illuminant.name().into());
        out.insert("processing".into(), way.name().into());
    }
    let group = |g: &Group| -> Result<Value, ReportError> {
        let best = g.best.iter().map(|&r| trial(section, r)).collect::<Result<Vec<_>, ReportError>>()?;
        let (trials, left_out) = g.counts();
        let mut out = Map::new();
        out.insert("colors".into(), g.colors.into());
        out.insert("trials".into(), trials.into());
        out.insert("left_out".into(), left_out.into());
        for (measure, found) in section.results.measures.iter().zip(&g.summaries) {
            out.insert(measure.name.clone(), summary(found));
        }
        out.insert("best".into(), best.into());
        out.insert("worst".into(), g.worst.map(|r| trial(section, r)).transpose()?.into());
        Ok(out.into())
    };
    let groups = section.groups.iter().map(group).collect::<Result<Vec<_>, ReportError>>()?;
    out.insert("best_by".into(), section.choice.words().into());
    out.insert("colors".into(), groups.into());
    let mut filters = Vec::new();
    for (label, colors) in &section.labels {
        for (colors, rows) in colors {
            let rows = rows.iter().map(|&r| trial(section, r)).collect::<Result<Vec<_>, ReportError>>()?;
            filters.push(json!({"filters": label, "colors": colors, "trials": rows}));
        }
    }
    out.insert("filters".into(), filters.into());
    let front = section.some_of_front(FRONT);
    let trials = front.iter().map(|&r| trial(section, r)).collect::<Result<Vec<_>, ReportError>>()?;
    out.insert("pareto_front".into(), json!({"count": section.front.len(), "trials": trials}));
    Ok(out.into())
}

fn trial(section: &Section<'_>, row: usize) -> Result<Value, ReportError> {
    let trial = section.results.trial(row)?;
    let figures = trial.design.filters.figures()?;
    let list = |f: fn(&FilterFigures) -> f64| figures.iter().map(f).collect::<Vec<_>>();
    let mut out = Map::new();
    out.insert("trial".into(), trial.number.into());
    out.insert("colors".into(), figures.len().into());
    for measure in &section.results.measures {
        out.insert(measure.name.clone(), measure.at(row).into());
    }
    for column in CONDITIONS {
        match section.results.data.column(column).map(|c| &c.values) {
            Some(ColumnValues::Numbers(values)) => out.insert(column.into(), values.get(row).copied().into()),
            Some(ColumnValues::Texts(values)) => {
                out.insert(column.into(), values.get(row).map(|t| &**t).into())
            }
            _ => None,
        };
    }
    out.insert("filters".into(), trial.design.filters.label.clone().into());
    out.insert("tile".into(), trial.design.tile().into());
    out.insert("mosaic".into(), section.results.mosaic(&trial.design).into());
    out.insert("center_nm".into(), list(|f| f.center_nm).into());
    out.insert("fwhm_nm".into(), list(|f| f.fwhm_nm).into());
    out.insert("peak".into(), list(|f| f.peak).into());
    // As a camera file states it, for the camera of the section.
    if let Some((condition, _)) = section.results.setup(section.setup) {
        let array = trial.design.camera(&condition.camera).sensor.cfa;
        out.insert("cfa".into(), serde_json::to_value(array)?);
    }
    Ok(out.into())
}

/// A summary with its intervals. A bound that is infinite, since there are too few trials, is null.
fn summary(s: &Summary) -> Value {
    let estimate = |e: &Estimate| json!({"value": e.value, "low": e.low, "high": e.high});
    json!({
        "mean": estimate(&s.mean),
        "standard_deviation": estimate(&s.standard_deviation),
        "median": estimate(&s.median),
        "p05": estimate(&s.p05),
        "p95": estimate(&s.p95),
    })
}
