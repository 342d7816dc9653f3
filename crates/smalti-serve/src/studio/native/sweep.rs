//! The scores of a design over light, with filters as designed and with filters that deviate.

use serde_json::json;
use smalti::camera::{PICTURE_METRICS, ScoreSettings, TrainingSettings};
use smalti::design::search::FreeCurves;
use smalti::experiment::{
    ComparisonSettings, Estimate, ExposurePolicy, Progress as _, ToleranceRow, tolerances,
};
use smalti::l3::Training;
use smalti_io::test_scenes::TestSet;

use super::capture::{LIGHT, SEED};
use super::design::camera;
use super::error::JobError;
use super::material::{Found, Native};
use super::message::Sweep;
use super::watch::Watch;

/// The set of scenes of a name.
pub(super) fn set(name: &str) -> Result<TestSet, JobError> {
    let known = TestSet::NAMED.iter().find(|(known, ..)| *known == name);
    known.map(|(.., set)| *set).ok_or_else(|| {
        let names: Vec<&str> = TestSet::NAMED.iter().map(|(name, ..)| *name).collect();
        JobError::Wrong(format!("there is no set of scenes {name:?}; expected {}", names.join(", ")))
    })
}

/// Scores the design and its deviations on all scenes of a set, with one noise realisation each.
pub(super) fn sweep(native: &Native, wanted: &Sweep, watch: &Watch) -> Result<Found, JobError> {
    let camera = camera(&wanted.design)?;
    watch.begin("scenes");
    let settings = ComparisonSettings {
        luminances_cd_m2: wanted.luminances_cd_m2.clone(),
        illuminant: LIGHT,
        scenes: set(&wanted.set)?.scenes(&LIGHT)?,
        seed: SEED,
        seed_count: 1,
        score: ScoreSettings::default(),
        exposure: ExposurePolicy::Own,
    };
    let clear = wanted.family.space(FreeCurves::default()).clear();
    let training = Training { quality: wanted.quality, ..Training::default() };
    let learning = (&TrainingSettings::default(), &training);
    let label = camera.description().name.as_str();
    let rows = tolerances((&camera, label), clear, &settings, learning, native.resources(watch))?;
    let said = json!({"metrics": PICTURE_METRICS, "scenes": settings.scenes.len(), "rows": rows});
    Ok(Found { said, files: vec![("csv", csv(&rows).into_bytes())] })
}

/// The rows as a table: means, and changes from the filters as designed, each with its interval.
fn csv(rows: &[ToleranceRow]) -> String {
    let of_metric = |m: &&str| {
        ["", "_low", "_high", "_change", "_change_low", "_change_high"].map(|which| format!("{m}{which}"))
    };
    let head = PICTURE_METRICS.iter().flat_map(of_metric);
    let head = ["shift_nm", "thickness", "luminance_cd_m2"].into_iter().map(String::from).chain(head);
    let line = |cells: Vec<String>| cells.join(",") + "\n";
    let estimated = |estimate: Option<&Estimate>| {
        let interval = estimate.and_then(|e| e.interval);
        [estimate.map(|e| e.value), interval.map(|i| i.low), interval.map(|i| i.high)]
    };
    let row = |row: &ToleranceRow| {
        let figures = (0..PICTURE_METRICS.len()).flat_map(|metric| {
            let change = row.changes.as_ref().map(|changes| &changes[metric]);
            [estimated(Some(&row.means[metric])), estimated(change)].concat()
        });
        let of = [row.deviation.shift_nm, row.deviation.thickness, row.luminance_cd_m2].map(Some);
        let cells = of.into_iter().chain(figures);
        line(cells.map(|v| v.map_or_else(String::new, |v| v.to_string())).collect())
    };
    line(head.collect()) + &rows.iter().map(row).collect::<String>()
}

#[cfg(test)]
mod tests {
    use smalti::design::Deviation;
    use smalti::numeric::bootstrap::Interval;

    use super::*;

    #[test]
    fn a_table_has_a_row_for_each_deviation_and_luminance() {
        let row = |deviation: Deviation, changes| ToleranceRow {
            deviation,
            name: deviation.to_string(),
            luminance_cd_m2: 10.0,
            means: [
                Estimate { value: 30.5, interval: Some(Interval { low: 29.0, high: 31.5 }) },
                Estimate { value: 2.0, interval: None },
                Estimate { value: 3.0, interval: None },
            ],
            changes,
        };
        let change = |value| Estimate { value, interval: None };
        let rows = [
            row(Deviation::NONE, None),
            row(Deviation::shift(-5.0), Some([change(-0.5), change(0.25), change(0.0)])),
        ];
        let csv = csv(&rows);
        let lines: Vec<&str> = csv.lines().collect();
        assert!(lines[0].starts_with(
            "shift_nm,thickness,luminance_cd_m2,cpsnr_db,cpsnr_db_low,cpsnr_db_high,cpsnr_db_change,"
        ));
        assert!(lines[0].ends_with(",scielab_mean_change_high"));
        assert_eq!(lines[1], "0,1,10,30.5,29,31.5,,,,2,,,,,,3,,,,,");
        assert_eq!(lines[2], "-5,1,10,30.5,29,31.5,-0.5,,,2,,,0.25,,,3,,,0,,");
        assert!(lines.iter().all(|line| line.split(',').count() == lines[0].split(',').count()));
        assert!(
            set("natural").is_ok()
                && set("none").unwrap_err().to_string().contains("expected charts, natural, all")
        );
    }
}
