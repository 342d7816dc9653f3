//! The conditions of a comparison: exposure times, and what differs between the cameras besides the colour filter array.

use serde_json::{Value, json};
use smalti::experiment::{EqualExposure, ExposurePolicy, Outcome};

use super::results::{Comparison, mean};
use crate::TextTable;
use crate::page::{Markup, Table, paragraph};

/// The headings of exposure time and saturated share in tables.
pub(super) const EXPOSURE_HEADINGS: [&str; 2] = ["exposure ms", "saturated %"];

/// The range of the exposure times over the scenes, ms, and the mean share of saturated samples, percent.
pub(super) fn exposure_cells(outcome: &Outcome) -> [String; 2] {
    let times = outcome.scenes.iter().map(|(_, s)| s.exposure_time_s * 1e3);
    let (least, most) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), ms| (a.min(ms), b.max(ms)));
    let text = |ms: f64| if ms < 10.0 { format!("{ms:.2}") } else { format!("{ms:.1}") };
    let (least, most) = (text(least), text(most));
    let times = if least == most { most } else { format!("{least}–{most}") };
    [times, format!("{:.2}", mean(outcome, |s| s.saturated_percent))]
}

/// A policy in words.
fn in_words(policy: ExposurePolicy) -> String {
    match policy {
        ExposurePolicy::Own => "the time or the rule of each camera".into(),
        ExposurePolicy::Time(time_s) => format!("{} ms for all pictures", time_s * 1e3),
        ExposurePolicy::Equal(EqualExposure { saturated_share, longest_s })
        | ExposurePolicy::AutoEqual(EqualExposure { saturated_share, longest_s }) => format!(
            "equal for all cameras; for each scene the longest time at which none saturates more than {} % of its samples, at most {} ms",
            saturated_share * 100.0,
            longest_s * 1e3
        ),
    }
}

/// A policy for results.json.
pub(super) fn exposure_as_json(policy: ExposurePolicy) -> Value {
    match policy {
        ExposurePolicy::Own => json!({"policy": "own"}),
        ExposurePolicy::Time(time_s) => json!({"policy": "time", "time_s": time_s}),
        ExposurePolicy::Equal(limits) | ExposurePolicy::AutoEqual(limits) => json!({
            "policy": "equal",
            "max_saturated_share": limits.saturated_share,
            "max_exposure_s": limits.longest_s,
        }),
    }
}

impl Comparison<'_> {
    /// The differences without the keys of exposure rules that were not applied.
    fn relevant_differences(&self) -> impl Iterator<Item = (&str, &[String])> {
        let replaced = self.exposure != ExposurePolicy::Own;
        let is_relevant =
            move |key: &str| !(replaced && (key == "exposure.time_ms" || key.starts_with("exposure.auto")));
        self.differences
            .iter()
            .map(|d| (d.key.as_str(), &d.values[..]))
            .filter(move |(key, _)| is_relevant(key))
    }

    /// What differs between the cameras besides the colour filter array, as a table; empty when nothing does.
    #[must_use]
    pub fn differences_table(&self, table: &TextTable<'_>) -> String {
        let header: Vec<&str> =
            std::iter::once("key").chain(self.labels.iter().map(String::as_str)).collect();
        let row = |(key, values): (&str, &[String])| {
            std::iter::once(key.to_owned()).chain(values.iter().cloned()).collect()
        };
        let rows: Vec<Vec<String>> = self.relevant_differences().map(row).collect();
        if rows.is_empty() {
            return String::new();
        }
        format!("The cameras differ in more than the colour filter array:\n{}\n", table(&header, &rows))
    }

    /// The exposure times as a line.
    #[must_use]
    pub fn exposure_line(&self) -> String {
        format!("Exposure: {}.\n", in_words(self.exposure))
    }

    /// Exposure times and differences for the page.
    pub(super) fn conditions(&self) -> Markup {
        let exposure = paragraph("help", format!("Exposure: {}.", in_words(self.exposure)));
        let table = Table::new("Differences between the cameras besides the colour filter array").text("Key");
        let table = self.labels.iter().fold(table, |table, label| table.text(label.as_str()));
        let row = |table: Table, (key, values): (&str, &[String])| {
            table.row(std::iter::once(key.to_owned()).chain(values.iter().cloned()), false)
        };
        if self.relevant_differences().next().is_none() {
            let same = "The cameras differ in their colour filter arrays only.";
            return if self.cameras.len() > 1 { exposure.and(paragraph("help", same)) } else { exposure };
        }
        exposure.and(Markup::from(self.relevant_differences().fold(table, row)))
    }
}
