//! The columns of results, and the filters of designs, as a page holds them.

use std::collections::HashMap;

use anyhow::Context;
use serde_json::{Value, json};
use smalti::design::FilterFigures;
use smalti::metrics::Better;
use smalti::sensor::Filter;
use smalti::spectrum::WavelengthGrid;
use smalti_io::dataset::{Column, ColumnKind, ColumnSpec};
use smalti_report::page::{packed, words};

use super::Sources;
use super::choice::Choice;
use crate::study_report::results::Results;

/// Wavelengths of curves that are no formula, at least: first and last. They go on to those of the cameras.
const CURVE_NM: (f64, f64) = (380.0, 720.0);
/// Between two of them, at most and at least: as fine as those of the cameras.
const CURVE_STEPS_NM: (f64, f64) = (5.0, 1.0);
/// Most bytes of curves in a page.
const MOST_CURVE_BYTES: usize = 700_000;
/// What is no column to look at: the number stands beside, problems in the lead.
const LEFT_OUT: [&str; 2] = ["design", "problem"];

pub(super) struct Columns {
    pub(super) colors: Value,
    pub(super) numbers: Vec<Value>,
    pub(super) words: Vec<Value>,
    pub(super) filters: Value,
}

pub(super) fn columns(sources: &Sources<'_>, choice: &Choice) -> anyhow::Result<Columns> {
    let mut specs: Vec<ColumnSpec> = Vec::new();
    for (results, _) in sources.all {
        for spec in &results.dataset.manifest().plan.schema {
            let told = specs.iter().any(|s| s.name == spec.name && s.kind == spec.kind);
            if !told && !LEFT_OUT.contains(&spec.name.as_str()) {
                specs.push(spec.clone());
            }
        }
    }
    let (mut numbers, mut texts) = (Vec::new(), Vec::new());
    for spec in specs {
        match spec.kind {
            ColumnKind::Float => {
                let values = floats(sources, choice, &spec.name)?;
                let of = |r: &Results| r.measure(&spec.name).map(|m| m.better);
                let better = match sources.all.iter().find_map(|(r, _)| of(r)) {
                    Some(Better::Lower) => "lower",
                    Some(Better::Higher) => "higher",
                    _ => "",
                };
                numbers.push(json!({
                    "name": spec.name, "label": label(&spec.name), "unit": spec.unit, "doc": spec.doc, "better": better,
                    "values": packed(&values),
                }));
            }
            ColumnKind::Text => {
                let values = strings(sources, choice, &spec.name)?;
                let column = words(values.iter().map(String::as_str));
                texts.push(
                    json!({"name": spec.name, "label": label(&spec.name), "doc": spec.doc, "values": column}),
                );
            }
            ColumnKind::Int | ColumnKind::Floats => {}
        }
    }
    let colors: Vec<f64> = choice
        .rows
        .iter()
        .map(|r| sources.all.get(r.study).and_then(|(results, _)| results.colors.get(r.row)))
        .map(|c| f64::from(c.copied().unwrap_or_default()))
        .collect();
    let filters = filters(sources, choice)?;
    Ok(Columns { colors: packed(&colors), numbers, words: texts, filters })
}

/// What a reader calls a column.
fn label(name: &str) -> String {
    match name {
        "delta_e_76" => "Colour error ΔE76".into(),
        "delta_e_2000" => "Colour error ΔE2000".into(),
        "mtf50_cy_per_mm" => "Resolution MTF50".into(),
        "mtf50_cy_per_px" => "Resolution MTF50 per pixel".into(),
        "luminance_noise_percent" => "Luminance noise".into(),
        "aliasing_percent" => "Aliasing".into(),
        "color_aliasing_percent" => "Colour aliasing".into(),
        "macbeth_time_s" => "Exposure of the chart".into(),
        "edge_time_s" => "Exposure of the edge".into(),
        "tile" => "Mosaic".into(),
        other => {
            let mut text = other.replace('_', " ");
            if let Some(first) = text.get_mut(..1) {
                first.make_ascii_uppercase();
            }
            text
        }
    }
}

fn floats(sources: &Sources<'_>, choice: &Choice, name: &str) -> anyhow::Result<Vec<f64>> {
    let read = |column| if let Column::Float(values) = column { Some(values) } else { None };
    chosen(sources, choice, name, ColumnKind::Float, f64::NAN, read)
}

fn strings(sources: &Sources<'_>, choice: &Choice, name: &str) -> anyhow::Result<Vec<String>> {
    let read = |column| if let Column::Text(values) = column { Some(values) } else { None };
    chosen(sources, choice, name, ColumnKind::Text, String::new(), read)
}

/// A column of the designs of the page; `absent` where a study has no such column.
fn chosen<T: Clone>(
    sources: &Sources<'_>,
    choice: &Choice,
    name: &str,
    kind: ColumnKind,
    absent: T,
    values: impl Fn(Column) -> Option<Vec<T>>,
) -> anyhow::Result<Vec<T>> {
    let mut out = Vec::with_capacity(choice.rows.len());
    for (study, (results, _)) in sources.all.iter().enumerate() {
        let here = choice.rows.iter().filter(|r| r.study == study);
        let schema = &results.dataset.manifest().plan.schema;
        if !schema.iter().any(|c| c.name == name && c.kind == kind) {
            out.extend(here.map(|_| absent.clone()));
            continue;
        }
        let mut column: Vec<T> = Vec::new();
        for part in results.dataset.columns(&[name])? {
            let read = part?.columns.into_iter().next().and_then(&values);
            column.extend(
                read.with_context(|| format!("its column {name} holds other things than it states"))?,
            );
        }
        out.extend(here.map(|r| column.get(r.row).cloned().unwrap_or_else(|| absent.clone())));
    }
    Ok(out)
}

/// The filters, one after the other over all designs: as many for each design as it has colours. `curve` is −1 where the filter is
/// the Gaussian of its centre, width and peak, −2 where it is not in the page, else the number of its samples.
fn filters(sources: &Sources<'_>, choice: &Choice) -> anyhow::Result<Value> {
    let (mut center, mut fwhm, mut peak, mut curve) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let cameras = camera_grids(sources);
    let grid = curve_grid(&cameras)?;
    let (mut places, mut most): (HashMap<String, f64>, Vec<f64>) = Default::default();
    let mut samples: Vec<f64> = Vec::new();
    for row in &choice.rows {
        let Some((results, _)) = sources.all.get(row.study) else { continue };
        let design = results.design(row.row)?;
        for filter in &design.filters.filters {
            let figures = FilterFigures::from(filter);
            center.push(figures.center_nm);
            fwhm.push(figures.fwhm_nm);
            peak.push(figures.peak);
            if matches!(filter, Filter::Gaussian { .. }) {
                curve.push(-1.0);
                continue;
            }
            let key = serde_json::to_string(filter)?;
            let next = places.len();
            let is_room = (next + 1) * grid.len() <= MOST_CURVE_BYTES;
            let place = *places.entry(key).or_insert(if is_room { next as f64 } else { -2.0 });
            curve.push(place);
            if place == next as f64 {
                // To 1/255 of its largest value, which stands beside: a byte each.
                let values = sampled(filter, grid, &cameras);
                let largest = values.iter().fold(0.0f64, |m, v| m.max(*v)).max(f64::MIN_POSITIVE);
                samples.extend(values.iter().map(|v| (v / largest * 255.0).round() / 255.0));
                most.push(largest);
            }
        }
    }
    Ok(json!({
        "center": packed(&center),
        "fwhm": packed(&fwhm),
        "peak": packed(&peak),
        "curve": packed(&curve),
        "curves": {
            "first_nm": grid.start_nm(), "step_nm": grid.step_nm(), "count": grid.len(),
            "most": packed(&most), "values": packed(&samples),
        },
    }))
}

/// The wavelengths of all cameras, the widest first.
fn camera_grids(sources: &Sources<'_>) -> Vec<WavelengthGrid> {
    let conditions = sources.all.iter().flat_map(|(results, _)| &results.study().conditions);
    let mut grids: Vec<WavelengthGrid> = Vec::new();
    for grid in conditions.filter_map(|c| c.camera.grid().ok()) {
        if !grids.contains(&grid) {
            grids.push(grid);
        }
    }
    let width = |g: &WavelengthGrid| g.end_nm() - g.start_nm();
    grids.sort_by(|a, b| width(b).total_cmp(&width(a)));
    grids
}

fn curve_grid(cameras: &[WavelengthGrid]) -> anyhow::Result<WavelengthGrid> {
    let around = |(low, high): (f64, f64), g: &WavelengthGrid| (low.min(g.start_nm()), high.max(g.end_nm()));
    let (low, high) = cameras.iter().fold(CURVE_NM, around);
    let step = cameras.iter().fold(CURVE_STEPS_NM.0, |s, g| s.min(g.step_nm())).max(CURVE_STEPS_NM.1);
    let first = (low / step).floor() * step;
    let count = ((high - first) / step).ceil() as usize + 1;
    Ok(WavelengthGrid::new(first, step, count)?)
}

/// A curve on a grid. Measured ones may begin or end where the wavelengths of their camera do; beyond them nothing is known, and
/// nothing drawn.
fn sampled(filter: &Filter, grid: WavelengthGrid, cameras: &[WavelengthGrid]) -> Vec<f64> {
    let known = |own: &WavelengthGrid| Some((*own, filter.spectrum(*own).ok()?));
    let Some((own, curve)) = known(&grid).or_else(|| cameras.iter().find_map(known)) else {
        return vec![0.0; grid.len()];
    };
    let values = curve.values();
    grid.wavelengths_nm()
        .map(|nm| {
            let place = (nm - own.start_nm()) / own.step_nm();
            if place < 0.0 || place > (values.len() - 1) as f64 {
                return 0.0;
            }
            let (low, t) = (place as usize, place.fract());
            let at = |i: usize| values.get(i.min(values.len() - 1)).copied().unwrap_or(0.0);
            at(low) + (at(low + 1) - at(low)) * t
        })
        .collect()
}
