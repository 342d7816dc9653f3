//! The columns of results and the filters of designs as data of the page.

use std::collections::HashMap;

use serde_json::{Value, json};
use smalti::camera::CameraError;
use smalti::design::{ColumnValues, FilterFigures, ResultColumn};
use smalti::metrics::Better;
use smalti::sensor::Filter;
use smalti::spectrum::{Extrapolation, WavelengthGrid};

use super::choice::Choice;
use super::sources::Sources;
use crate::ReportError;
use crate::page::{packed, words};
use crate::study::results::Results;

/// The first and last wavelength of sampled curves. The range grows to that of the cameras.
const CURVE_NM: (f64, f64) = (380.0, 720.0);
/// The largest and smallest step of sampled curves. Between these, it is the smallest step of the cameras.
const CURVE_STEPS_NM: (f64, f64) = (5.0, 1.0);
/// The largest number of bytes of curves in a page.
const MAX_CURVE_BYTES: usize = 700_000;
/// Columns that the page shows elsewhere.
const LEFT_OUT: [&str; 2] = ["trial", "problem"];

pub(super) struct Columns {
    pub(super) colors: Value,
    pub(super) numbers: Vec<Value>,
    pub(super) words: Vec<Value>,
    pub(super) filters: Value,
}

pub(super) fn columns(sources: &Sources<'_>, choice: &Choice) -> Result<Columns, ReportError> {
    let mut shown: Vec<&ResultColumn> = Vec::new();
    for column in sources.all.iter().flat_map(|(results, _)| &results.data.columns) {
        let is_there = shown.iter().any(|s| s.name == column.name && is_alike(s, column));
        if !is_there && !LEFT_OUT.contains(&column.name.as_str()) {
            shown.push(column);
        }
    }
    let (mut numbers, mut texts) = (Vec::new(), Vec::new());
    for column in shown {
        match column.values {
            ColumnValues::Numbers(_) => {
                let values = floats(sources, choice, &column.name);
                let of = |r: &Results| r.measure(&column.name).map(|m| m.better);
                let better = match sources.all.iter().find_map(|(r, _)| of(r)) {
                    Some(Better::Lower) => "lower",
                    Some(Better::Higher) => "higher",
                    _ => "",
                };
                numbers.push(json!({
                    "name": column.name, "label": label(&column.name), "unit": column.unit, "doc": column.doc, "better": better,
                    "values": packed(&values),
                }));
            }
            ColumnValues::Texts(_) => {
                let values = words(strings(sources, choice, &column.name).into_iter());
                texts.push(
                    json!({"name": column.name, "label": label(&column.name), "doc": column.doc, "values": values}),
                );
            }
            ColumnValues::Integers(_) => {}
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

/// The label of a column.
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

/// Whether two columns hold values of the same kind.
fn is_alike(a: &ResultColumn, b: &ResultColumn) -> bool {
    std::mem::discriminant(&a.values) == std::mem::discriminant(&b.values)
}

/// A column of the designs of the page; NaN where a study has no such column.
fn floats(sources: &Sources<'_>, choice: &Choice, name: &str) -> Vec<f64> {
    let value = |results: &Results, row: usize| match &results.data.column(name)?.values {
        ColumnValues::Numbers(values) => values.get(row).copied(),
        _ => None,
    };
    let rows =
        choice.rows.iter().map(|r| sources.all.get(r.study).and_then(|(results, _)| value(results, r.row)));
    rows.map(|v| v.unwrap_or(f64::NAN)).collect()
}

/// A column of texts; empty where a study has no such column.
fn strings<'a>(sources: &Sources<'a>, choice: &Choice, name: &str) -> Vec<&'a str> {
    let value = |results: &'a Results, row: usize| match &results.data.column(name)?.values {
        ColumnValues::Texts(values) => values.get(row).map(|text| &**text),
        _ => None,
    };
    let rows =
        choice.rows.iter().map(|r| sources.all.get(r.study).and_then(|(results, _)| value(results, r.row)));
    rows.map(Option::unwrap_or_default).collect()
}

/// The filters of all designs in their order. `curve` is −1 for a Gaussian, which its centre, width and peak define, −2 for a curve
/// that the page does not contain, and otherwise the number of the sampled curve.
fn filters(sources: &Sources<'_>, choice: &Choice) -> Result<Value, ReportError> {
    let (mut center, mut fwhm, mut peak, mut curve) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let cameras = camera_grids(sources);
    let grid = curve_grid(&cameras)?;
    let (mut places, mut most): (HashMap<String, f64>, Vec<f64>) = Default::default();
    let mut samples: Vec<f64> = Vec::new();
    for row in &choice.rows {
        let Some((results, _)) = sources.all.get(row.study) else { continue };
        let design = results.trial(row.row)?.design;
        for filter in &design.filters.filters {
            let figures = FilterFigures::new(filter).map_err(CameraError::from)?;
            center.push(figures.center_nm);
            fwhm.push(figures.fwhm_nm);
            peak.push(figures.peak);
            if matches!(filter, Filter::Gaussian { .. }) {
                curve.push(-1.0);
                continue;
            }
            let key = serde_json::to_string(filter)?;
            let next = places.len();
            let is_room = (next + 1) * grid.len() <= MAX_CURVE_BYTES;
            let place = *places.entry(key).or_insert(if is_room { next as f64 } else { -2.0 });
            curve.push(place);
            if place == next as f64 {
                // In steps of 1/255 of the largest value, so that a sample takes a byte.
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

/// The wavelength grids of all cameras, the widest first.
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

fn curve_grid(cameras: &[WavelengthGrid]) -> Result<WavelengthGrid, ReportError> {
    let around = |(low, high): (f64, f64), g: &WavelengthGrid| (low.min(g.start_nm()), high.max(g.end_nm()));
    let (low, high) = cameras.iter().fold(CURVE_NM, around);
    let step = cameras.iter().fold(CURVE_STEPS_NM.0, |s, g| s.min(g.step_nm())).max(CURVE_STEPS_NM.1);
    let first = (low / step).floor() * step;
    let count = ((high - first) / step).ceil() as usize + 1;
    Ok(WavelengthGrid::new(first, step, count)?)
}

/// A curve on a grid. A measured curve may cover the wavelengths of its camera only; it is 0 beyond them.
fn sampled(filter: &Filter, grid: WavelengthGrid, cameras: &[WavelengthGrid]) -> Vec<f64> {
    let known = std::iter::once(&grid).chain(cameras).find_map(|own| filter.spectrum(*own).ok());
    let on_grid = known.and_then(|curve| curve.resampled(grid, Extrapolation::Zero).ok());
    on_grid.map_or_else(|| vec![0.0; grid.len()], |curve| curve.values().to_vec())
}
