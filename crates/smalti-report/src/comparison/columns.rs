//! Columns of the tables, with the metric of each: one list for the tables and for `smalti list metrics`.

/// A column: its heading, and the name of its metric in results and in the list of metrics.
pub type Column = (&'static str, &'static str);

/// The scores of a comparison.
pub const COMPARE: [Column; 6] = [
    ("CPSNR dB", "cpsnr_db"),
    ("ΔE2000", "pixel_delta_e_2000_mean"),
    ("S-CIELAB", "scielab_mean"),
    ("MTF50 cy/mm", "mtf50_cy_per_mm"),
    ("visual SNR", "visual_snr"),
    ("noise %", "luminance_noise_percent"),
];

/// The scores of an evaluation.
pub const EVALUATE: [Column; 8] = [
    ("ΔE76", "delta_e_76"),
    ("ΔE2000", "delta_e_2000"),
    ("MTF50 cy/mm", "mtf50_cy_per_mm"),
    ("MTF50 cy/px", "mtf50_cy_per_px"),
    ("noise %", "luminance_noise_percent"),
    ("aliasing %", "aliasing_percent"),
    ("clipped %", "saturated_percent"),
    ("range dB", "dynamic_range_db"),
];

/// The headings of columns.
pub fn headings(columns: &[Column]) -> impl Iterator<Item = &'static str> {
    columns.iter().map(|(heading, _)| *heading)
}

/// The columns in which a metric is shown, in words; `None` for a metric without a column.
#[must_use]
pub fn where_shown(metric: &str) -> Option<String> {
    let tables = [("smalti compare", &COMPARE[..]), ("smalti evaluate", &EVALUATE[..])];
    let shown = tables.iter().flat_map(|(command, columns)| {
        let here = columns.iter().filter(|(_, name)| *name == metric);
        here.map(move |(heading, _)| format!("'{heading}' in {command}"))
    });
    let shown: Vec<String> = shown.collect();
    (!shown.is_empty()).then(|| format!("column {}", shown.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use smalti::metrics::CATALOG;

    #[test]
    fn every_column_is_a_metric_of_the_list() {
        for (heading, name) in COMPARE.iter().chain(&EVALUATE) {
            let found = CATALOG.iter().find(|m| m.name == *name);
            assert!(found.is_some_and(|m| !m.unit.is_empty() && !m.source.is_empty()), "{heading}: {name}");
        }
    }
}
