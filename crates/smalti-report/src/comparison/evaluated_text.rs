//! Evaluations in words and tables.

use smalti::camera::Evaluation;

use super::columns::{EVALUATE, SENSOR, headings, reliabilities};
use super::reliability::meanings;
use crate::TextTable;

/// What resolution and noise of one row say together.
pub(super) const WITHOUT_NOISE: &str = "ΔE, MTF50 and aliasing are measured without noise, noise % on one capture. In little light, noise hides detail that MTF50 still counts.";

/// The scores of labelled evaluations, all evaluations of a camera in a row, and the colorimetry of each sensor.
#[must_use]
pub fn text(results: &[(&str, &Evaluation)], illuminant: &str, table: &TextTable<'_>) -> String {
    let header: Vec<&str> =
        ["camera", "cd/m²"].into_iter().chain(headings(&EVALUATE)).chain(["exposure ms"]).collect();
    let row = |(label, scores): &(&str, &Evaluation)| {
        let mut cells = vec![(*label).to_owned(), scores.luminance_cd_m2.to_string()];
        cells.extend(EVALUATE.iter().map(|c| c.text(scores)));
        cells.push(format!("{:.1}", scores.exposure.macbeth_s * 1e3));
        cells
    };
    let mut out = table(&header, &results.iter().map(row).collect::<Vec<_>>());
    let all: Vec<&Evaluation> = results.iter().map(|(_, scores)| *scores).collect();
    out += &format!("{WITHOUT_NOISE}\n");
    for meaning in meanings(reliabilities(&EVALUATE, &all)) {
        out += &format!("{meaning}\n");
    }
    let mut sensors: Vec<Vec<String>> = Vec::new();
    for (label, scores) in results {
        if sensors.last().is_none_or(|last| last.first().is_none_or(|l| l != label)) {
            let values = SENSOR.iter().map(|c| c.text(&scores.sensor));
            sensors.push(std::iter::once((*label).to_owned()).chain(values).collect());
        }
    }
    let header: Vec<&str> = std::iter::once("camera").chain(headings(&SENSOR)).collect();
    out + &format!("\nColorimetry of the sensor under {illuminant}:\n{}", table(&header, &sensors))
}
