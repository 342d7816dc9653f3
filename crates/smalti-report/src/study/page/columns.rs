//! The columns of results as data of the page.

use std::collections::BTreeSet;

use serde_json::{Value, json};
use smalti::design::{ColumnValues, ResultColumn, column_of_key};
use smalti::metrics::Better;

use super::choice::Choice;
use super::sources::Sources;
use crate::names;
use crate::page::{packed, words};
use crate::study::results::Results;

/// Columns that the page shows elsewhere.
const LEFT_OUT: [&str; 2] = ["trial", "problem"];

pub(super) struct Columns {
    pub(super) colors: Value,
    pub(super) numbers: Vec<Value>,
    pub(super) words: Vec<Value>,
}

pub(super) fn columns(sources: &Sources<'_>, choice: &Choice) -> Columns {
    let mut shown: Vec<&ResultColumn> = Vec::new();
    for column in sources.all.iter().flat_map(|(results, _)| &results.data.columns) {
        let is_there = shown.iter().any(|s| s.name == column.name && is_alike(s, column));
        if !is_there && !LEFT_OUT.contains(&column.name.as_str()) {
            shown.push(column);
        }
    }
    let (mut numbers, mut texts) = (Vec::new(), Vec::new());
    let keys: BTreeSet<&str> = sources.all.iter().flat_map(|(results, _)| condition_keys(results)).collect();
    for column in shown {
        let (label, unit) = label_and_unit(column, &keys);
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
                    "name": column.name, "label": label, "unit": unit, "doc": column.doc, "better": better,
                    "values": packed(&values),
                }));
            }
            ColumnValues::Texts(_) => {
                let values = words(strings(sources, choice, &column.name).into_iter());
                texts.push(json!({"name": column.name, "label": label, "doc": column.doc, "values": values}));
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
    Columns { colors: packed(&colors), numbers, words: texts }
}

/// The keys of the conditions of a study.
fn condition_keys(results: &Results) -> impl Iterator<Item = &str> {
    let first = results.study().conditions.first();
    first.into_iter().flat_map(|condition| condition.values.iter().map(|(key, _)| key.as_str()))
}

/// The label of a column and its unit. The column of a condition has the name and the unit that its key states.
fn label_and_unit<'a>(column: &'a ResultColumn, keys: &BTreeSet<&str>) -> (String, &'a str) {
    match keys.iter().find(|key| column_of_key(key) == column.name) {
        Some(key) => {
            let (name, unit) = names::said(key, keys.iter().copied());
            (capitalized(name), unit)
        }
        None => (label(&column.name), &column.unit),
    }
}

/// With a capital at the start. The letter of the f-number is a symbol and stays as it is.
fn capitalized(mut text: String) -> String {
    let is_symbol = text.starts_with("f-number");
    if let Some(first) = text.get_mut(..1).filter(|_| !is_symbol) {
        first.make_ascii_uppercase();
    }
    text
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
        "sensitivity_metamerism_index" => "Sensitivity metamerism index".into(),
        "metamer_mismatch_percent" => "Metamer mismatch".into(),
        "mtf50_reliability" => "MTF50 as a resolution".into(),
        "macbeth_time_s" => "Exposure of the chart".into(),
        "macbeth_saturated_percent" => "Saturated samples of the chart".into(),
        "edge_time_s" => "Exposure of the edge".into(),
        "edge_saturated_percent" => "Saturated samples of the edge".into(),
        "tile" => "Mosaic".into(),
        other => capitalized(other.replace('_', " ")),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_have_words_and_units() {
        let column = |name: &str, unit: &str| ResultColumn {
            name: name.into(),
            unit: unit.into(),
            doc: String::new(),
            values: ColumnValues::Numbers(Vec::new()),
        };
        let keys = BTreeSet::from(["luminance_cd_m2", "optics.f_number", "sensor.pixel.pitch_um"]);
        let said = |name: &str, unit: &str| {
            let column = column(name, unit);
            let (label, unit) = label_and_unit(&column, &keys);
            format!("{label}|{unit}")
        };
        assert_eq!(said("luminance_cd_m2", ""), "Luminance|cd/m²");
        assert_eq!(said("optics_f_number", ""), "f-number|");
        assert_eq!(said("sensor_pixel_pitch_um", ""), "Pitch|µm");
        assert_eq!(said("mtf50_cy_per_mm", "cy/mm"), "Resolution MTF50|cy/mm");
    }
}
