//! Scores of designs on kept targets, against those of `evaluate`.
#![allow(clippy::unwrap_used)]

use smalti::camera::description::{BinningDescription, PatternDescription};
use smalti::camera::{
    Camera, CameraDescription, EvaluationSettings, ScoreSettings, Setup, compare_on, evaluate,
};
use smalti::design::{Metric, Scores, StudyScene, Targets};
use smalti::isp::{Demosaic, WhiteBalance};
use smalti::scene::Setting;
use smalti::sensor::{BinningMode, Cfa, Channel, Filter, Mosaic};
use smalti::spectrum::WavelengthGrid;

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

pub(crate) use crate::gaussian_sets::{SETS, Set};

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

const SCENE: &str = "dead-leaves?rows=96&cols=128&seed=3";
const ALIASING: [Metric; 2] = [Metric::Aliasing, Metric::ColorAliasing];

/// Targets for metrics of all kinds.
fn all_targets(camera: &Camera) -> Targets {
    let metrics: Vec<Metric> =
        [&Metric::USUAL[..], &ALIASING, &Metric::OF_SCENES, &Metric::OF_SENSITIVITIES].concat();
    let scenes = [StudyScene { name: SCENE.into(), hash: None, scene: None }];
    Targets::new(camera, &EvaluationSettings::default(), &metrics, &scenes, &|_, make| make()).unwrap()
}

/// Targets for the usual metrics.
pub(crate) fn targets(camera: &Camera) -> Targets {
    Targets::new(camera, &EvaluationSettings::default(), &Metric::USUAL, &[], &|_, make| make()).unwrap()
}

/// Sums over wavelength and photodetector in the other order: rounding, and now and then a photon more or less.
fn tolerance(metric: Metric) -> f64 {
    match metric {
        Metric::Mtf50CyPerMm | Metric::Mtf50CyPerPx => 1e-5,
        Metric::LuminanceNoise => 1e-3,
        _ => 1e-4,
    }
}

fn check(camera: &Camera, cfa: &Cfa, scores: &Scores) {
    let camera = camera.with_cfa(cfa.clone());
    let (e, _) = evaluate(&camera, &EvaluationSettings::default(), &|_, make| make()).unwrap();
    for (metric, expected) in [
        (Metric::DeltaE76, e.delta_e_76.mean),
        (Metric::DeltaE2000, e.delta_e_2000.mean),
        (Metric::Mtf50CyPerMm, e.mtf50_cy_per_mm),
        (Metric::Mtf50CyPerPx, e.mtf50_cy_per_px),
        (Metric::LuminanceNoise, e.luminance_noise_percent.mean),
        (Metric::Aliasing, e.aliasing_percent),
        (Metric::ColorAliasing, e.color_aliasing_percent),
        (Metric::VoraValue, e.sensor.vora_value),
        (Metric::SensitivityMetamerismIndex, e.sensor.sensitivity_metamerism_index),
        (Metric::MetamerMismatch, e.sensor.metamer_mismatch_percent),
    ] {
        if ALIASING.contains(&metric) && scores.zone_plate.is_none()
            || Metric::OF_SENSITIVITIES.contains(&metric) && scores.sensor.is_none()
        {
            continue;
        }
        let got = scores.value(metric, 0).unwrap();
        assert!(
            (got / expected - 1.0).abs() < tolerance(metric),
            "{} of {}: {got}, evaluate {expected}",
            metric.name(),
            cfa.name()
        );
    }
    let edge_time_s = scores.edge.as_ref().unwrap().as_ref().unwrap().time_s;
    for (got, expected) in [(scores.macbeth_time_s, e.exposure.macbeth_s), (edge_time_s, e.exposure.edge_s)] {
        assert!((got / expected - 1.0).abs() < 1e-12, "{got} s, evaluate {expected} s");
    }
    assert_eq!(scores.problems().count(), 0);
}

#[test]
fn kept_targets_score_as_evaluate() {
    let camera = Camera::new(description(), GRID).unwrap();
    let targets = targets(&camera);
    for set in SETS {
        let cfa = cfa(set);
        check(&camera, &cfa, &targets.score(&cfa).unwrap());
    }
}

/// The mosaic of a design is that of the binned samples.
#[test]
fn binned_targets_score_as_evaluate() {
    for mode in [BinningMode::Charge, BinningMode::Digital] {
        let mut d = description();
        d.sensor.cfa.pattern = PatternDescription::Name("quad-bayer".into());
        d.sensor.binning = Some(BinningDescription::Mode(mode));
        let camera = Camera::new(d, GRID).unwrap();
        let cfa = cfa(SETS[0]);
        check(&camera, &cfa, &targets(&camera).score(&cfa).unwrap());
    }
}

/// Zone plate as `evaluate`, a scene as `compare`; what no metric asks for is not looked at.
#[test]
fn pictures_score_as_evaluate_and_compare() {
    let camera = Camera::new(description(), GRID).unwrap();
    let cfa = cfa(SETS[1]);
    let scores = all_targets(&camera).score(&cfa).unwrap();
    check(&camera, &cfa, &scores);

    let setting = Setting { luminance_cd_m2: 75.0, ..Setting::default() };
    let camera_of_set = camera.with_cfa(cfa.clone());
    let setup = Setup::of_test_scene(&camera_of_set, SCENE, &setting).unwrap();
    let isp = camera_of_set.isp(&setup.light, WhiteBalance::None).unwrap();
    let expected = compare_on(&setup, &isp, 1, &ScoreSettings::default()).unwrap().scores;
    for (metric, expected) in [
        (Metric::Cpsnr, expected.cpsnr_db),
        (Metric::PixelDeltaE2000, expected.pixel_delta_e_2000_mean),
        (Metric::Scielab, expected.scielab_mean),
    ] {
        let got = scores.value(metric, 0).unwrap();
        assert!((got / expected - 1.0).abs() < 1e-3, "{}: {got}, compare {expected}", metric.name());
        assert_eq!(scores.value(metric, 1), None, "there is one scene");
    }

    let settings = EvaluationSettings::default();
    let some = Targets::new(&camera, &settings, &[Metric::Aliasing], &[], &|_, make| make()).unwrap();
    let some = some.score(&cfa).unwrap();
    assert_eq!(some.value(Metric::Aliasing, 0), scores.value(Metric::Aliasing, 0));
    for other in Metric::USUAL.into_iter().chain(Metric::OF_SCENES) {
        assert_eq!(some.value(other, 0), None, "{}", other.name());
    }
}

/// Overexposed, black is as white as white: that there is no edge says nothing of colours.
#[test]
fn a_target_that_fails_leaves_the_others() {
    let mut d = description();
    d.exposure.time_ms = Some(1e9);
    let camera = Camera::new(d, GRID).unwrap();
    let scores = targets(&camera).score(&cfa(SETS[0])).unwrap();
    let failed: Vec<&str> = scores.problems().map(|(target, _)| target).collect();
    assert_eq!(failed, ["edge"]);
    assert!(scores.value(Metric::Mtf50CyPerMm, 0).is_none());
    assert!(scores.value(Metric::DeltaE76, 0).is_some_and(f64::is_finite));
}

/// Other processing, a rule of exposure that looks at the whole image, crosstalk, a stated time.
#[test]
fn and_whatever_the_camera() {
    let changes: [fn(&mut CameraDescription); 5] = [
        |d| d.isp.demosaic = Demosaic::Malvar2004,
        |d| {
            d.isp.demosaic = Demosaic::HamiltonAdams1997;
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
        check(&camera, &cfa, &targets(&camera).score(&cfa).unwrap());
    }
}
