//! A comparison in words and tables.

use smalti::camera::MetricGain;
use smalti::experiment::{Outcome, PairwiseLightGain};

use super::columns::{heading, headings, reliabilities};
use super::conditions::{EXPOSURE_HEADINGS, exposure_cells};
use super::results::{Comparison, of_contender};
use crate::TextTable;
use crate::reliability::meanings;

/// What resolution and noise of one row say together.
pub(super) const MTF50_AND_NOISE: &str = "MTF50 is measured without noise, visual SNR and noise % on four captures. For learned pipelines, which are not linear, compare the MTF50 of the 4:1 edge. In little light, noise hides detail that MTF50 still counts.";

/// What a light gain and its interval rest on.
pub(super) const GAIN_BASIS: &str = "Below 0, the first camera needs less light. 95 % confidence intervals in brackets: of scores of pictures over the scenes and \
     noise realisations of the first table, of visual SNR and noise over its four captures of the chart. The search ends at ±4 stops. \
     “Also” marks further light at which a score that does not rise steadily with light equals that of the other camera. MTF50 is \
     measured without noise and therefore has no light gain.";

/// A light gain with its interval, `+0.41 stops [+0.38, +0.46]`, and where the scores are equal as well, `, also +0.90`.
pub(super) fn gain_cell(of: &MetricGain, unit: &str) -> String {
    let interval = of.interval.map_or_else(String::new, |i| format!(" {i}"));
    let also: String = of.also_at_stops.iter().map(|stops| format!(", also {stops:+.2}")).collect();
    format!("{}{interval}{also}", of.gain.to_string().replace(" stops", unit)).replace('-', "−")
}

impl Comparison<'_> {
    /// The scores, a row for each luminance and contender, and the meaning of marks at values.
    #[must_use]
    pub fn scores_table(&self, table: &TextTable<'_>) -> String {
        let header: Vec<&str> = ["camera", "pipeline", "cd/m²"]
            .into_iter()
            .chain(headings(self.columns()))
            .chain(EXPOSURE_HEADINGS)
            .collect();
        let mut rows = Vec::new();
        for light in 0..self.light_count() {
            for (contender, o) in self.in_light(light) {
                let values = self.columns().iter().map(|c| c.text(o));
                let cells = of_contender(contender, o.luminance_cd_m2).into_iter().chain(values);
                rows.push(cells.chain(exposure_cells(o)).collect());
            }
        }
        let all: Vec<&Outcome> = self.outcomes.iter().flatten().collect();
        let meanings = meanings(reliabilities(self.columns(), &all));
        let lines = meanings.into_iter().chain(self.target_times());
        lines.fold(table(&header, &rows) + MTF50_AND_NOISE + "\n", |out, line| out + &line + "\n")
    }

    /// The largest difference between fixed point and single precision, as a line. Empty where none was computed.
    #[must_use]
    pub fn fixed_point_line(&self) -> String {
        let all = self.outcomes.iter().flatten().flat_map(|o| &o.scenes);
        let all: Vec<_> = all.filter_map(|(_, s)| s.fixed_point).collect();
        let Some(psnr_db) = all.iter().map(|f| f.psnr_db).reduce(f64::min) else { return String::new() };
        let loss_db = all.iter().map(|f| f.cpsnr_loss_db).fold(0.0, f64::max);
        format!(
            "PSNR of fixed point (16-bit samples and kernels) against single precision: {psnr_db:.1} dB; largest loss of CPSNR: {loss_db:.2} dB\n"
        )
    }

    /// A table for each camera to be equalled at each luminance.
    #[must_use]
    pub fn gains_table(&self, table: &TextTable<'_>) -> String {
        let mut out = String::new();
        for PairwiseLightGain { first, other, gains } in self.gains {
            let header = ["metric", first.as_str(), other.as_str(), "light gain"];
            let row = |g: &MetricGain| {
                vec![
                    heading(g.metric).to_owned(),
                    format!("{:.3}", g.own),
                    format!("{:.3}", g.target),
                    gain_cell(g, " stops"),
                ]
            };
            let rows: Vec<Vec<String>> = gains.metrics.iter().map(row).collect();
            out += &format!(
                "\nAdditional light for {first} to match {other} at {} cd/m²\n{}",
                gains.luminance_cd_m2,
                table(&header, &rows),
            );
        }
        if !out.is_empty() {
            out += &format!("{GAIN_BASIS}\n");
        }
        out
    }
}
