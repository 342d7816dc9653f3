//! The conditions of a comparison: exposure times, and what differs between the cameras besides the colour filter array.

use serde_json::{Value, json};
use smalti::camera::Camera;
use smalti::experiment::{
    CameraDifference, EqualExposure, ExposurePolicy, FIELD_OF_VIEW, LimitingCamera, Outcome,
};

use super::columns::mean;
use crate::TextTable;
use crate::page::{Markup, Table, paragraph};
use crate::words::{listed, time_ms};

/// The headings of exposure time and saturated share in tables.
pub(super) const EXPOSURE_HEADINGS: [&str; 2] = ["exposure ms", "saturated %"];

/// Keys that stand beside a verdict before others: those that decide how much light a pixel gets, and its noise.
const FIRST_KEYS: [&str; 6] = [
    "sensor.pixel.pitch_um",
    "optics.f_number",
    "exposure.time_ms",
    "sensor.pixel.read_noise_e",
    "optics.ir_cut",
    "sensor.quantum_efficiency",
];
/// The most keys that stand beside a verdict; a table has all.
const NAMED_KEYS: usize = 4;

const UNEQUAL_VIEW: &str = "Every camera images a scene onto equally many samples, whatever its field of view. A sample of larger pitch collects the light of \
                            more area.";

const BINNED_OR_NOT: &str = " For equal fields of view, compare the same pixels with sensor.binning \"digital\" and \"charge\", which collect the same light.";

/// The range of the exposure times over the scenes, ms, and the mean share of saturated samples, percent.
pub(super) fn exposure_cells(outcome: &Outcome) -> [String; 2] {
    let times = outcome.scenes.iter().map(|(_, s)| s.scores.exposure_time_s * 1e3);
    let (least, most) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), ms| (a.min(ms), b.max(ms)));
    let (least, most) = (time_ms(least), time_ms(most));
    let times = if least == most { most } else { format!("{least}–{most}") };
    [times, format!("{:.2}", mean(outcome, |s| s.saturated_percent))]
}

/// The exposure time of a camera's description, ms; `None` for an automatic one.
fn own_time_ms(camera: &Camera) -> Option<f64> {
    camera.description().exposure.time_ms
}

/// A time without the digits that binary fractions add: 33, not 33.00000000000001.
fn milliseconds(time_ms: f64) -> String {
    format!("{time_ms:.3}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The exposure by the settings of the cameras in words, from the time of each one that has a fixed time, ms.
fn own_exposure(times_ms: &[Option<f64>]) -> String {
    let fixed: Vec<f64> = times_ms.iter().flatten().copied().collect();
    let (least, most) =
        fixed.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
    let each = if times_ms.len() == 1 { "the camera" } else { "each camera" };
    if fixed.is_empty() {
        return format!("automatic, by the rule of {each}; the tables state the times");
    }
    let [least, most] = [least, most].map(milliseconds);
    let range = if least == most { format!("{most} ms") } else { format!("{least} to {most} ms") };
    if fixed.len() < times_ms.len() {
        format!(
            "as set in each camera, fixed ({range}) for some and automatic for others; the tables state the times"
        )
    } else if least == most {
        format!("{range}, as set in {each}")
    } else {
        format!("as set in each camera, {range}; the tables state the times")
    }
}

/// The conditions under which cameras were scored.
#[derive(Debug, Clone, Copy)]
pub struct Conditions<'a> {
    /// The choice of the exposure times that was applied.
    pub exposure: ExposurePolicy,
    /// The cameras.
    pub cameras: &'a [Camera],
    /// What differs between the cameras besides the colour filter array.
    pub differences: &'a [CameraDifference],
    /// The camera that makes equal exposure times much shorter than the others need.
    pub limiting: Option<&'a LimitingCamera>,
    /// The label of each camera.
    pub labels: &'a [String],
}

impl<'a> Conditions<'a> {
    /// What limits a verdict, as sentences that stand beside it: differences besides the colour filter array, and a camera that makes
    /// equal exposure times short.
    pub(super) fn reservations(&self) -> Vec<String> {
        let mut keys: Vec<String> =
            self.rows().into_iter().filter_map(|row| row.into_iter().next()).collect();
        // The sort is stable, so that all others keep their order.
        keys.sort_by_key(|key| FIRST_KEYS.iter().position(|first| first == key).unwrap_or(FIRST_KEYS.len()));
        let differ = (!keys.is_empty()).then(|| {
            let named = match keys.len() {
                n if n > NAMED_KEYS => {
                    let rest = n - NAMED_KEYS;
                    let word = if rest == 1 { "key" } else { "keys" };
                    format!("{} and {rest} further {word}", keys[..NAMED_KEYS].join(", "))
                }
                _ => listed(&keys),
            };
            format!("The cameras also differ in {named}; the verdict is about the whole cameras.")
        });
        differ.into_iter().chain(self.limited()).collect()
    }

    /// Which camera makes equal exposure times short, as a sentence.
    fn limited(&self) -> Option<String> {
        let LimitingCamera { label, factor } = self.limiting?;
        let factor = if *factor < 10.0 { format!("{factor:.1}") } else { format!("{factor:.0}") };
        Some(format!(
            "{label} saturates first and limits the exposure times, which could be {factor} times as long without it: compare without it, or with \
             --exposure own."
        ))
    }

    /// The choice of the exposure times as a sentence.
    #[must_use]
    pub fn exposure_line(&self) -> String {
        let words = match self.exposure {
            ExposurePolicy::Own => own_exposure(&self.cameras.iter().map(own_time_ms).collect::<Vec<_>>()),
            ExposurePolicy::Time(time_s) => format!("{} ms for all pictures", milliseconds(time_s * 1e3)),
            ExposurePolicy::Equal(EqualExposure { saturated_share, longest_s })
            | ExposurePolicy::AutoEqual(EqualExposure { saturated_share, longest_s }) => format!(
                "equal for all cameras; for each scene the longest time at which at most {} % of the samples of any camera \
                 saturate, and at most {} ms. Noise saturates further samples: the tables state the share of all",
                saturated_share * 100.0,
                milliseconds(longest_s * 1e3)
            ),
        };
        let limiting = self.limited().map_or_else(String::new, |words| format!(" {words}"));
        format!("Exposure time: {words}.{limiting}")
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
                "limited_by": self.limiting.map(|l| json!({"camera": l.label, "factor": l.factor})),
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
        let view = self.unequal_view().map_or_else(String::new, |words| words + "\n");
        format!(
            "The cameras differ in more than the colour filter array:\n{}{view}\n{exposure}\n",
            table(&header, &rows)
        )
    }

    /// What unequal fields of view mean for the scores, where they are unequal.
    fn unequal_view(&self) -> Option<String> {
        let binned = self.cameras.iter().filter(|c| c.sensor.binning.is_some()).count();
        let some = if (1..self.cameras.len()).contains(&binned) { BINNED_OR_NOT } else { "" };
        self.differences.iter().any(|d| d.key == FIELD_OF_VIEW).then(|| format!("{UNEQUAL_VIEW}{some}"))
    }

    /// The same for a page.
    pub(super) fn markup(&self) -> Markup {
        let (rows, exposure) = (self.rows(), paragraph("help", self.exposure_line()));
        if rows.is_empty() {
            let same = match self.cameras {
                [first, rest @ ..] if rest.iter().all(|c| c.is_same_as(first)) => {
                    "The cameras are identical."
                }
                _ => "The cameras differ in their colour filter arrays only.",
            };
            return if self.labels.len() > 1 { exposure.and(paragraph("help", same)) } else { exposure };
        }
        let table = Table::new("Differences between the cameras besides the colour filter array").text("Key");
        let table = self.labels.iter().fold(table, |table, label| table.text(label.as_str()));
        let table = rows.into_iter().fold(table, |table, row| table.row(row, false));
        let view = self.unequal_view().map(|words| paragraph("help", words));
        exposure.and(Markup::from(table)).and(view.into_iter().collect::<Markup>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exposure_of_the_cameras_is_said() {
        assert_eq!(own_exposure(&[Some(100.0)]), "100 ms, as set in the camera");
        assert_eq!(own_exposure(&[Some(100.0); 2]), "100 ms, as set in each camera");
        let differ = own_exposure(&[Some(100.0), Some(12.5)]);
        assert_eq!(differ, "as set in each camera, 12.5 to 100 ms; the tables state the times");
        assert!(own_exposure(&[None, None]).starts_with("automatic, by the rule of each camera"));
        assert!(
            own_exposure(&[None, Some(0.25)]).contains("fixed (0.25 ms) for some and automatic for others")
        );
        assert_eq!(milliseconds(0.033 * 1e3), "33");
    }

    #[test]
    fn the_camera_that_limits_equal_times_is_named() {
        let limiting = LimitingCamera { label: "tiny".into(), factor: 412.0 };
        let conditions = Conditions {
            exposure: ExposurePolicy::Equal(EqualExposure::default()),
            cameras: &[],
            differences: &[],
            limiting: Some(&limiting),
            labels: &[],
        };
        let line = conditions.exposure_line();
        assert!(line.contains("tiny saturates first") && line.contains("412 times as long"), "{line}");
        assert_eq!(conditions.exposure_as_json()["limited_by"]["camera"], "tiny");
        assert!(!Conditions { limiting: None, ..conditions }.exposure_line().contains("times as long"));
    }
}
