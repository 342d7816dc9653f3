//! Metrics against ISETCam's.
#![allow(missing_docs, clippy::unwrap_used)]

use crate::common;

use common::{assert_close, numbers, reference_csv, reference_json};
use smalti::color::DeltaE;
use smalti::metrics::Rect;
use smalti::metrics::color_accuracy::{LabWhite, color_accuracy};
use smalti::metrics::esfr::{
    EsfrOptions, ISETCAM_LUMINANCE_WEIGHTS, find_edge_region, picture_sfr, raw_channel_sfr,
};
use smalti::numeric::Planes;
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling};

const CASES: [&str; 7] = ["nikonD100", "isetRGB", "g3a", "g4a", "g5a", "g6a", "g7a"];

fn planes(names: &[String]) -> Planes {
    let tables: Vec<_> = names.iter().map(|n| reference_csv(n)).collect();
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
    let case = reference_json("metric_mtf_edge.json");
    let image = planes(&["r", "g", "b"].map(|c| format!("metric_mtf_edge_{c}.csv")));
    compare("analytic edge", &image, &case, "mtf_rgbl", 1e-3);
}

#[test]
fn bars_of_all_cases() {
    for id in CASES {
        let case = reference_json(&format!("ip_case_{id}.json"));
        let image = planes(&[1, 2, 3].map(|c| format!("bar_lrgb_{id}_ch{c}.csv")));
        compare(id, &image, &case["mtf"], "mtf", 2e-3);
    }
}

fn xyz(v: &serde_json::Value) -> Vec<[f64; 3]> {
    v.as_array().unwrap().iter().map(|p| numbers(p).try_into().unwrap()).collect()
}

/// Every case scores its measured XYZ against the ideal chart.
#[test]
fn color_accuracy_of_all_cases() {
    let scene = reference_json("scene_macbeth_d65.json");
    let reference = xyz(&scene["ideal_XYZ_maxY100"]);
    for id in CASES {
        let case = reference_json(&format!("ip_case_{id}.json"));
        for scoring in ["sRGB", "custom"] {
            let want = &case["mac_noisefree"][scoring];
            let measured = xyz(&want["xyz"]);
            let got = color_accuracy(&measured, &reference, 3, LabWhite::Reference).unwrap();
            let what = |formula: &str| format!("{id}, {scoring}, {formula}");
            // CIE 1994 is not symmetric, and ISETCam takes the measured colour for the standard; CIE (and we) the
            // reference.
            let pairs = got.measured_lab.iter().zip(&got.reference_lab);
            let swapped: Vec<f64> = pairs.map(|(&m, &r)| DeltaE::Cie1994.between(m, r)).collect();
            for (formula, got) in [
                ("1976", &got.delta_e_76.per_patch),
                ("1994", &swapped),
                ("2000", &got.delta_e_2000.per_patch),
            ] {
                let mean = [want[format!("mean_dE{formula}")].as_f64().unwrap()];
                assert_close(&what(formula), got, &numbers(&want[format!("dE{formula}")]), 1e-4);
                assert_close(&what(formula), &[got.iter().sum::<f64>() / 24.0], &mean, 1e-4);
            }
            let own = color_accuracy(&measured, &reference, 3, LabWhite::Own).unwrap().delta_e_76;
            assert_close(&what("own white"), &own.per_patch, &numbers(&want["dE1976_ownwhite"]), 1e-4);
        }
    }
}

/// The region is found on the picture and on a raw channel; both see one edge of slope 3:7.
#[test]
fn the_bar_is_found_and_its_mosaic_measured() {
    let volts = reference_csv("sensor_bar_volts_noisefree_nikonD100.csv");
    let (rows, cols) = (volts.len(), volts[0].len());
    let data: Vec<f32> = volts.iter().flatten().map(|&v| v as f32).collect();
    // Means of 2 × 2 cells: a small picture without a mosaic.
    let cell = |i: usize| {
        let (y, x) = (2 * (i / (cols / 2)), 2 * (i % (cols / 2)));
        (data[y * cols + x]
            + data[y * cols + x + 1]
            + data[(y + 1) * cols + x]
            + data[(y + 1) * cols + x + 1])
            / 4.0
    };
    let small = Planes::new(rows / 2, cols / 2, 1, (0..(rows / 2) * (cols / 2)).map(cell).collect()).unwrap();
    let found = find_edge_region(&small, 0).unwrap();
    eprintln!("{rows} × {cols}: {found:?}");
    let bayer = Mosaic::new(2, 2, vec![1, 0, 2, 1]).unwrap();
    let names = ["R", "G", "B"].map(String::from).to_vec();
    let raw = RawImage::new(rows, cols, RawSamples::Analog(data), Sampling::Mosaic(bayer), names, 0.0, 1.0);
    let raw = raw.unwrap();
    let rect = Rect { row: 2 * found.row, col: 2 * found.col, rows: 2 * found.rows, cols: 2 * found.cols };
    for channel in 0..3 {
        let sfr = raw_channel_sfr(&raw, channel, rect, &EsfrOptions::default()).unwrap();
        eprintln!("{channel} {:?} {} {}", sfr.mtf50_cy_per_mm(2.8e-6), sfr.edge_angle_deg, sfr.contrast);
        assert!((sfr.edge_angle_deg.abs() - (3f64 / 7.0).atan().to_degrees()).abs() < 0.3);
    }
}
