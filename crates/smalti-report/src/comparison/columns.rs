//! Columns of the tables, with the metric of each: one list for the tables and for `smalti list metrics`.

use smalti::camera::{Evaluation, SceneScores, SensorColorimetry};
use smalti::experiment::{Outcome, ScoredScene};
use smalti::metrics::esfr::Mtf50Reliability;
use smalti::metrics::{Better, CATALOG};

use crate::reliability::mark;

/// The heading of the MTF50 of the edge of low contrast, in every table.
const LOW_CONTRAST: &str = "MTF50 4:1 cy/px";

/// A column of scores of a kind.
pub struct Column<T: 'static> {
    heading: &'static str,
    /// The name of its metric in results and in the list of metrics.
    pub(super) metric: &'static str,
    /// Digits behind the point.
    pub(super) digits: usize,
    pub(super) of: fn(&T) -> f64,
    /// Whether the value can be trusted, where that varies.
    reliability: Option<fn(&T) -> Mtf50Reliability>,
}

impl<T> Column<T> {
    pub(super) fn is_higher_better(&self) -> bool {
        CATALOG.iter().any(|m| m.name == self.metric && m.better == Better::Higher)
    }

    /// Whether the value of one that is scored can be trusted.
    pub(super) fn reliability(&self, of: &T) -> Mtf50Reliability {
        self.reliability.map_or(Mtf50Reliability::Reliable, |reliability| reliability(of))
    }

    /// The value as text, with a mark where it cannot be trusted.
    pub(super) fn text(&self, of: &T) -> String {
        let value = (self.of)(of);
        let mark = mark(self.reliability(of));
        if value.is_finite() { format!("{value:.*}{mark}", self.digits) } else { format!("–{mark}") }
    }
}

/// The reliabilities of all values in the columns.
pub(super) fn reliabilities<'a, T>(
    columns: &'a [Column<T>],
    of: &'a [&'a T],
) -> impl Iterator<Item = Mtf50Reliability> + 'a {
    columns.iter().flat_map(move |c| of.iter().map(move |of| c.reliability(of)))
}

const fn column<T>(
    heading: &'static str,
    metric: &'static str,
    digits: usize,
    of: fn(&T) -> f64,
) -> Column<T> {
    Column { heading, metric, digits, of, reliability: None }
}

const fn mtf50<T>(
    heading: &'static str,
    metric: &'static str,
    digits: usize,
    of: fn(&T) -> f64,
    reliability: fn(&T) -> Mtf50Reliability,
) -> Column<T> {
    Column { heading, metric, digits, of, reliability: Some(reliability) }
}

/// The mean of a property of single pictures over the scenes.
pub(super) fn mean(outcome: &Outcome, of: impl Fn(&SceneScores) -> f64) -> f64 {
    outcome.scenes.iter().map(|(_, s)| of(&s.scores)).sum::<f64>() / outcome.scenes.len().max(1) as f64
}

/// The scores of a comparison of cameras of equal pixel pitch.
pub const COMPARE: [Column<Outcome>; 7] = compare(mtf50(
    "MTF50 cy/mm",
    "mtf50_cy_per_mm",
    1,
    |o| o.targets.mtf50_cy_per_mm,
    |o| o.targets.mtf50_reliability,
));

/// The scores of a comparison of cameras of different pixel pitches. They capture the scene with equally many pixels, so that
/// resolutions per pixel can be compared and those per millimetre cannot.
pub const COMPARE_PER_PIXEL: [Column<Outcome>; 7] = compare(mtf50(
    "MTF50 cy/px",
    "mtf50_cy_per_px",
    3,
    |o| o.targets.mtf50_cy_per_px,
    |o| o.targets.mtf50_reliability,
));

const fn compare(of_edge: Column<Outcome>) -> [Column<Outcome>; 7] {
    [
        column("CPSNR dB", "cpsnr_db", 2, |o| o.means()[0]),
        column("ΔE2000", "pixel_delta_e_2000_mean", 2, |o| o.means()[1]),
        column("S-CIELAB", "scielab_mean", 2, |o| o.means()[2]),
        of_edge,
        mtf50(
            LOW_CONTRAST,
            "mtf50_low_contrast_cy_per_px",
            3,
            |o| o.targets.mtf50_low_contrast_cy_per_px,
            |o| o.targets.mtf50_low_contrast_reliability,
        ),
        column("visual SNR", "visual_snr", 3, |o| o.targets.visual_snr.median),
        column("noise %", "luminance_noise_percent", 1, |o| o.targets.luminance_noise_percent.mean),
    ]
}

/// Those that single scenes have as well.
pub(super) const SCENES: [Column<ScoredScene>; 3] = [
    column("CPSNR dB", "cpsnr_db", 2, |s| s.means()[0]),
    column("ΔE2000", "pixel_delta_e_2000_mean", 2, |s| s.means()[1]),
    column("S-CIELAB", "scielab_mean", 2, |s| s.means()[2]),
];

/// The scores of an evaluation.
pub const EVALUATE: [Column<Evaluation>; 9] = [
    column("ΔE76", "delta_e_76", 2, |e| e.delta_e_76.mean),
    column("ΔE2000", "delta_e_2000", 2, |e| e.delta_e_2000.mean),
    mtf50("MTF50 cy/mm", "mtf50_cy_per_mm", 1, |e| e.mtf50_cy_per_mm, |e| e.mtf50_reliability),
    mtf50("MTF50 cy/px", "mtf50_cy_per_px", 3, |e| e.mtf50_cy_per_px, |e| e.mtf50_reliability),
    mtf50(
        LOW_CONTRAST,
        "mtf50_low_contrast_cy_per_px",
        3,
        |e| e.mtf50_low_contrast_cy_per_px,
        |e| e.mtf50_low_contrast_reliability,
    ),
    column("noise %", "luminance_noise_percent", 2, |e| e.luminance_noise_percent.mean),
    column("aliasing %", "aliasing_percent", 1, |e| e.aliasing_percent),
    column("saturated %", "saturated_percent", 1, |e| e.saturated_percent),
    column("range dB", "dynamic_range_db", 1, |e| e.dynamic_range_db),
];

/// The colorimetry of a sensor.
pub const SENSOR: [Column<SensorColorimetry>; 3] = [
    column("Vora value", "vora_value", 3, |s| s.vora_value),
    column("SMI", "sensitivity_metamerism_index", 1, |s| s.sensitivity_metamerism_index),
    column("metamer mismatch %", "metamer_mismatch_percent", 1, |s| s.metamer_mismatch_percent),
];

/// The headings of columns.
pub fn headings<T>(columns: &[Column<T>]) -> impl Iterator<Item = &'static str> {
    columns.iter().map(|c| c.heading)
}

/// The heading of a metric in the table of a comparison; the name of the metric if it has no column there.
pub(super) fn heading(metric: &'static str) -> &'static str {
    COMPARE.iter().find(|c| c.metric == metric).map_or(metric, |c| c.heading)
}

/// The heading of a metric by its name, in any table of a comparison; the name where it has no column there.
pub(crate) fn heading_of(metric: &str) -> &str {
    let mut columns = COMPARE.iter().chain(&COMPARE_PER_PIXEL);
    columns.find(|c| c.metric == metric).map_or(metric, |c| c.heading)
}

/// The columns in which a metric is shown, in words; `None` for a metric without a column.
#[must_use]
pub fn where_shown(metric: &str) -> Option<String> {
    let compare = COMPARE.map(|c| (c.metric, c.heading, "smalti compare"));
    let per_pixel = COMPARE_PER_PIXEL
        .map(|c| (c.metric, c.heading, "smalti compare of cameras of different pixel pitches"))
        .into_iter()
        .filter(|(name, ..)| compare.iter().all(|(known, ..)| known != name))
        .collect::<Vec<_>>();
    let evaluate = EVALUATE.map(|c| (c.metric, c.heading, "smalti evaluate"));
    let sensor = SENSOR.map(|c| (c.metric, c.heading, "smalti evaluate"));
    let saturated = ("saturated_percent", "saturated %", "smalti compare");
    let here = compare
        .iter()
        .chain([&saturated])
        .chain(&per_pixel)
        .chain(&evaluate)
        .chain(&sensor)
        .filter(|(name, ..)| *name == metric);
    let shown: Vec<String> = here.map(|(_, heading, command)| format!("'{heading}' in {command}")).collect();
    (!shown.is_empty()).then(|| format!("column {}", shown.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_metric_names_each_of_its_columns_once() {
        let shown = |metric| where_shown(metric).unwrap_or_default();
        let pitches = "'MTF50 cy/px' in smalti compare of cameras of different pixel pitches, 'MTF50 cy/px' in smalti evaluate";
        assert_eq!(shown("mtf50_cy_per_px"), format!("column {pitches}"));
        assert_eq!(shown("mtf50_low_contrast_cy_per_px").matches("smalti compare").count(), 1);
        assert_eq!(where_shown("unknown"), None);
    }

    #[test]
    fn every_column_is_a_metric_of_the_list() {
        let columns = COMPARE.map(|c| (c.heading, c.metric)).into_iter();
        let sensor = SENSOR.map(|c| (c.heading, c.metric));
        for (heading, name) in columns.chain(EVALUATE.map(|c| (c.heading, c.metric))).chain(sensor) {
            let found = CATALOG.iter().find(|m| m.name == name);
            assert!(found.is_some_and(|m| !m.unit.is_empty() && !m.source.is_empty()), "{heading}: {name}");
        }
    }
}
