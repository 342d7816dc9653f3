//! Evaluations in words and tables.

use smalti::camera::Evaluation;

use super::columns::{EVALUATE, SENSOR, headings, reliabilities};
use crate::TextTable;
use crate::reliability::meanings;
use crate::words::time_ms;

/// What resolution and noise of one row say together.
const WITHOUT_NOISE: &str = "ΔE, MTF50 and aliasing are measured without noise, noise % on one capture. In little light, noise hides detail that MTF50 still counts.";
/// The same for learned pipelines, whose kernels depend on the level of the signal.
const LEARNED_WITHOUT_NOISE: &str = "ΔE, MTF50 and aliasing are measured on captures without noise, noise % on one capture. The learned kernels of a low signal are nevertheless those for its noise: in little light they reduce saturation and detail, which ΔE and MTF50 include.";

/// From this share of saturated samples of the chart on, the colour differences contain clipping, percent: half of the smallest
/// patch area of one channel.
const NOTABLE_CLIPPING_PERCENT: f64 = 0.5;

/// What resolution and noise of one row say together, for learned pipelines or other processing.
pub(super) fn without_noise(learned: bool) -> &'static str {
    if learned { LEARNED_WITHOUT_NOISE } else { WITHOUT_NOISE }
}

/// The evaluations whose colour differences contain clipping, in words; `None` without any.
pub(super) fn clipped<'a>(results: impl Iterator<Item = (&'a str, &'a Evaluation)>) -> Option<String> {
    let all: Vec<String> = results
        .filter(|(_, e)| e.saturated_percent >= NOTABLE_CLIPPING_PERCENT)
        .map(|(label, e)| format!("{label} at {} cd/m²", e.luminance_cd_m2))
        .collect();
    (!all.is_empty()).then(|| {
        format!(
            "Samples of the chart are clipped, and ΔE contains the errors of clipped patches: {}. A shorter exposure avoids it: --exposure equal, or --exposure equal with a smaller --max-saturated.",
            all.join(", ")
        )
    })
}

/// The scores of labelled evaluations, all evaluations of a camera in a row, and the colorimetry of each sensor. `learned` says whether
/// learned pipelines rendered the pictures.
#[must_use]
pub fn text(
    results: &[(&str, &Evaluation)],
    illuminant: &str,
    learned: bool,
    table: &TextTable<'_>,
) -> String {
    let header: Vec<&str> =
        ["camera", "cd/m²"].into_iter().chain(headings(&EVALUATE)).chain(["exposure ms"]).collect();
    let row = |(label, scores): &(&str, &Evaluation)| {
        let mut cells = vec![(*label).to_owned(), scores.luminance_cd_m2.to_string()];
        cells.extend(EVALUATE.iter().map(|c| c.text(scores)));
        cells.push(time_ms(scores.exposure.macbeth_s * 1e3));
        cells
    };
    let mut out = table(&header, &results.iter().map(row).collect::<Vec<_>>());
    let all: Vec<&Evaluation> = results.iter().map(|(_, scores)| *scores).collect();
    out += &format!("{}\n", without_noise(learned));
    if let Some(text) = clipped(results.iter().copied()) {
        out += &format!("{text}\n");
    }
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
