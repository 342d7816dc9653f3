//! Scores of designs on kept targets, against those of `evaluate`.
#![allow(clippy::unwrap_used)]

use smalti::camera::description::{DemosaicName, PatternDescription};
use smalti::camera::{Camera, CameraDescription, EvaluationSettings, evaluate};
use smalti::design::{Scores, Targets};
use smalti::sensor::{Cfa, Channel, Filter, Mosaic};
use smalti::spectrum::WavelengthGrid;

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

/// Gaussian filters, centres and deviations in nm, and the tile that goes with them.
pub(crate) type Set = (&'static [(f64, f64)], &'static [&'static str]);

/// Sets of which ISETCam's figures are known.
pub(crate) const SETS: [Set; 5] = [
    (&[(629.9, 37.5), (579.5, 29.1), (451.8, 34.5)], &["BA", "CB"]),
    (&[(453.4, 51.8), (533.6, 22.7), (556.9, 43.6), (651.6, 50.0)], &["AB", "CD"]),
    (&[(436.3, 38.5), (459.4, 20.1), (541.4, 52.7), (577.5, 49.1), (650.9, 31.2)], &["ABC", "DEB", "CAD"]),
    (
        &[(435.2, 22.1), (466.2, 40.3), (516.7, 37.3), (550.8, 44.0), (605.9, 48.9), (659.6, 19.4)],
        &["ABC", "DEF", "BCD"],
    ),
    (
        &[
            (435.3, 46.8),
            (460.2, 30.1),
            (492.0, 53.4),
            (526.7, 29.2),
            (609.4, 41.1),
            (634.8, 46.4),
            (656.4, 28.7),
        ],
        &["ABC", "DEF", "GCE"],
    ),
];

pub(crate) fn cfa((filters, tile): Set) -> Cfa {
    let channel = |(i, &(center_nm, sigma_nm)): (usize, &(f64, f64))| Channel {
        name: char::from(b'A' + i as u8).to_string(),
        transmittance: Filter::Gaussian { center_nm, sigma_nm, peak: 1.0 }.spectrum(GRID).unwrap(),
    };
    let channels = filters.iter().enumerate().map(channel).collect();
    let cells = tile.iter().flat_map(|line| line.bytes().map(|b| b - b'A')).collect();
    Cfa::new("set", Mosaic::new(tile.len(), tile[0].len(), cells).unwrap(), channels).unwrap()
}

fn description() -> CameraDescription {
    let mut d = CameraDescription::default();
    d.sensor.adc_bits = 12;
    d.sensor.prnu_percent = 0.5;
    d.sensor.dsnu_mv = 1.0;
    d
}

fn check(camera: &Camera, cfa: &Cfa, scores: &Scores) {
    let camera = camera.with_cfa(cfa.clone());
    let (e, _) = evaluate(&camera, &EvaluationSettings::default(), &|_, make| make()).unwrap();
    // Sums over wavelength and photodetector in the other order: rounding, and now and then a photon more or less.
    for (what, got, expected, tolerance) in [
        ("ΔE76", scores.delta_e_76, e.delta_e_76.mean, 1e-4),
        ("ΔE00", scores.delta_e_2000, e.delta_e_2000.mean, 1e-4),
        ("MTF50", scores.mtf50_cy_per_mm, e.mtf50_cy_per_mm, 1e-5),
        ("MTF50 per pixel", scores.mtf50_cy_per_px, e.mtf50_cy_per_px, 1e-5),
        ("noise", scores.luminance_noise_percent, e.luminance_noise_percent.mean, 1e-3),
        ("time of the chart", scores.macbeth_time_s, e.exposure.macbeth_s, 1e-12),
        ("time of the edge", scores.edge_time_s, e.exposure.edge_s, 1e-12),
    ] {
        assert!(
            (got / expected - 1.0).abs() < tolerance,
            "{what} of {}: {got}, evaluate {expected}",
            cfa.name()
        );
    }
}

#[test]
fn kept_targets_score_as_evaluate() {
    let camera = Camera::new(description(), GRID).unwrap();
    let targets = Targets::new(&camera, &EvaluationSettings::default(), &|_, make| make()).unwrap();
    for set in SETS {
        let cfa = cfa(set);
        check(&camera, &cfa, &targets.score(&cfa).unwrap());
    }
}

/// Other processing, a rule of exposure that looks at the whole image, crosstalk, a stated time.
#[test]
fn and_whatever_the_camera() {
    let changes: [fn(&mut CameraDescription); 5] = [
        |d| d.isp.demosaic = DemosaicName::Malvar2004,
        |d| {
            d.isp.demosaic = DemosaicName::Adaptive;
            d.exposure.auto = Some(smalti::camera::description::AutoExposureName::Mean);
        },
        |d| d.sensor.crosstalk_percent = 6.0,
        |d| d.exposure.time_ms = Some(30.0),
        // No light is below the converter's range.
        |d| d.exposure.analog_offset_mv = -20.0,
    ];
    let cfa = cfa(SETS[0]);
    for change in changes {
        let mut d = description();
        change(&mut d);
        d.sensor.cfa.pattern = PatternDescription::Name("grbg".into());
        let camera = Camera::new(d, GRID).unwrap();
        let targets = Targets::new(&camera, &EvaluationSettings::default(), &|_, make| make()).unwrap();
        check(&camera, &cfa, &targets.score(&cfa).unwrap());
    }
}
