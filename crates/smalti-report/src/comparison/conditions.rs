//! The conditions of a comparison: exposure times, and what differs between the cameras besides the colour filter array.

use serde_json::{Value, json};
use smalti::experiment::{CameraDifference, EqualExposure, ExposurePolicy, Outcome};

use super::columns::mean;
use crate::TextTable;
use crate::page::{Markup, Table, paragraph};

/// The headings of exposure time and saturated share in tables.
pub(super) const EXPOSURE_HEADINGS: [&str; 2] = ["exposure ms", "saturated %"];

/// The range of the exposure times over the scenes, ms, and the mean share of saturated samples, percent.
pub(super) fn exposure_cells(outcome: &Outcome) -> [String; 2] {
    let times = outcome.scenes.iter().map(|(_, s)| s.scores.exposure_time_s * 1e3);
    let (least, most) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), ms| (a.min(ms), b.max(ms)));
    let text = |ms: f64| if ms < 10.0 { format!("{ms:.2}") } else { format!("{ms:.1}") };
    let (least, most) = (text(least), text(most));
    let times = if least == most { most } else { format!("{least}–{most}") };
    [times, format!("{:.2}", mean(outcome, |s| s.saturated_percent))]
}

/// The conditions under which cameras were scored.
#[derive(Debug, Clone, Copy)]
pub struct Conditions<'a> {
    /// The choice of the exposure times that was applied.
    pub exposure: ExposurePolicy,
    /// What differs between the cameras besides the colour filter array.
    pub differences: &'a [CameraDifference],
    /// The label of each camera.
    pub labels: &'a [String],
}

impl<'a> Conditions<'a> {
    /// The choice of the exposure times as a sentence.
    #[must_use]
    pub fn exposure_line(&self) -> String {
        let words = match self.exposure {
            ExposurePolicy::Own => "the time or the rule of each camera".into(),
            ExposurePolicy::Time(time_s) => format!("{} ms for all pictures", time_s * 1e3),
            ExposurePolicy::Equal(EqualExposure { saturated_share, longest_s })
            | ExposurePolicy::AutoEqual(EqualExposure { saturated_share, longest_s }) => format!(
                "equal for all cameras; for each scene the longest time at which none saturates more than {} % of its samples, at most \
                 {} ms",
                saturated_share * 100.0,
                longest_s * 1e3
            ),
        };
        format!("Exposure: {words}.")
    }

    /// The choice of the exposure times for results.json.
    #[must_use]
    pub fn exposure_as_json(&self) -> Value {
        match self.exposure {
            ExposurePolicy::Own => json!({"policy": "own"}),
            ExposurePolicy::Time(time_s) => json!({"policy": "time", "time_s": time_s}),
            ExposurePolicy::Equal(limits) | ExposurePolicy::AutoEqual(limits) => json!({
                "policy": "equal",
                "max_saturated_share": limits.saturated_share,
                "max_exposure_s": limits.longest_s,
            }),
        }
    }

    /// The differences between the cameras for results.json.
    #[must_use]
    pub fn differences_as_json(&self) -> Value {
        self.differences.iter().map(|d| json!({"key": d.key, "values": d.values})).collect()
    }

    /// Rows of key and values, without exposure rules that were not applied.
    fn rows(&self) -> Vec<Vec<String>> {
        let replaced = self.exposure != ExposurePolicy::Own;
        let is_applied = |d: &&CameraDifference| {
            !(replaced && (d.key == "exposure.time_ms" || d.key.starts_with("exposure.auto")))
        };
        let row = |d: &CameraDifference| std::iter::once(&d.key).chain(&d.values).cloned().collect();
        self.differences.iter().filter(is_applied).map(row).collect()
    }

    /// The exposure times, and a table of what differs between the cameras besides the colour filter array.
    #[must_use]
    pub fn text(&self, table: &TextTable<'_>) -> String {
        let (rows, exposure) = (self.rows(), self.exposure_line());
        if rows.is_empty() {
            return exposure + "\n";
        }
        let header: Vec<&str> =
            std::iter::once("key").chain(self.labels.iter().map(String::as_str)).collect();
        format!(
            "The cameras differ in more than the colour filter array:\n{}\n{exposure}\n",
            table(&header, &rows)
        )
    }

    /// The same for a page.
    pub(super) fn markup(&self) -> Markup {
        let (rows, exposure) = (self.rows(), paragraph("help", self.exposure_line()));
        if rows.is_empty() {
            let same = "The cameras differ in their colour filter arrays only.";
            return if self.labels.len() > 1 { exposure.and(paragraph("help", same)) } else { exposure };
        }
        let table = Table::new("Differences between the cameras besides the colour filter array").text("Key");
        let table = self.labels.iter().fold(table, |table, label| table.text(label.as_str()));
        let table = rows.into_iter().fold(table, |table, row| table.row(row, false));
        exposure.and(Markup::from(table))
    }
}
