//! Metrics against ISETCam's.
#![allow(missing_docs)]

#[allow(unreachable_pub)]
mod common;

use common::{assert_close, numbers, oracle, oracle_csv, oracle_json};
use smalti::metrics::Rect;
use smalti::metrics::esfr::{EsfrOptions, ISETCAM_LUMINANCE_WEIGHTS, picture_sfr};
use smalti::numeric::Planes;

fn planes(names: &[String]) -> Planes {
    let tables: Vec<_> = names.iter().map(|n| oracle_csv(n).unwrap()).collect();
    let (rows, cols) = (tables[0].len(), tables[0][0].len());
    let data = tables.iter().flatten().flatten().map(|&v| v as f32).collect();
    Planes::new(rows, cols, names.len(), data).unwrap()
}

/// Curves of red, green, blue and luminance beside the reference's, MTF50 of each, and the aliasing figure, which
/// ISETCam takes from green.
fn compare(what: &str, image: &Planes, case: &serde_json::Value, curves: &str, tolerance: f64) {
    let pitch_m = case["dx_mm"].as_f64().unwrap() * 1e-3;
    let rect = Rect::whole(image.rows(), image.cols());
    let got = picture_sfr(image, rect, &ISETCAM_LUMINANCE_WEIGHTS, &EsfrOptions::isetcam()).unwrap();
    let all: Vec<_> = got.channels.iter().chain([&got.luminance]).collect();
    assert_close(what, &all[0].frequency_cy_per_mm(pitch_m), &numbers(&case["freq"]), 1e-12);
    let table: Vec<Vec<f64>> = case[curves].as_array().unwrap().iter().map(numbers).collect();
    for (channel, sfr) in all.iter().enumerate() {
        let expected: Vec<f64> = table.iter().map(|row| row[channel]).collect();
        assert_close(&format!("{what}, curve {channel}"), &sfr.sfr, &expected, tolerance);
    }
    let mtf50: Vec<f64> = all.iter().map(|s| s.mtf50_cy_per_mm(pitch_m).unwrap()).collect();
    let expected = match &case["mtf50_exact_rgbl"] {
        serde_json::Value::Null => {
            [numbers(&case["mtf50_rgb_exact"]), numbers(&serde_json::json!([case["mtf50_exact"]]))].concat()
        }
        rgbl => numbers(rgbl),
    };
    for (g, e) in mtf50.iter().zip(&expected) {
        assert!((g / e - 1.0).abs() < 0.002, "{what}: MTF50 {g} cy/mm, expected {e}");
    }
    let (alias, expected) = (got.channels[1].aliasing_percent, case["alias_pct"].as_f64().unwrap());
    assert!((alias / expected - 1.0).abs() < 0.01, "{what}: aliasing {alias} %, expected {expected} %");
}

#[test]
fn analytic_edge() {
    let Some(case) = oracle_json("metric_mtf_edge.json") else { return };
    let image = planes(&["r", "g", "b"].map(|c| format!("metric_mtf_edge_{c}.csv")));
    compare("analytic edge", &image, &case, "mtf_rgbl", 1e-3);
}

#[test]
fn bars_of_all_cases() {
    if oracle().is_none() {
        return;
    }
    for id in ["nikonD100", "isetRGB", "g3a", "g4a", "g5a", "g6a", "g7a"] {
        let case = oracle_json(&format!("ip_case_{id}.json")).unwrap();
        let image = planes(&[1, 2, 3].map(|c| format!("bar_lrgb_{id}_ch{c}.csv")));
        compare(id, &image, &case["mtf"], "mtf", 2e-3);
    }
}
