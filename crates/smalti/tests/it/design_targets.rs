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
    let edge = scores.edge.as_ref().unwrap().as_ref().unwrap();
    assert_eq!(edge.mtf50_reliability, e.mtf50_reliability);
    // Automatic exposure keeps the chart below saturation, but for noise.
    assert_eq!((scores.macbeth_saturated_percent, edge.saturated_percent), (0.0, 0.0));
    assert!(e.saturated_percent < 0.1, "{}", e.saturated_percent);
    assert_eq!(scores.problems().count(), 0);
}

/// The share of saturated samples is that of `evaluate`, which captures the chart with noise, here the photon noise of very many
/// electrons, for samples that are bounded without a capture and for those that are not. (Read noise comes after the full well and
/// takes half of the saturated samples below the white level again.)
#[test]
fn saturated_samples_are_those_of_evaluate() {
    let share = |luminance_cd_m2: f64, binning: Option<BinningMode>| {
        let mut d = description();
        (d.sensor.prnu_percent, d.sensor.dsnu_mv) = (0.0, 0.0);
        (d.sensor.pixel.read_noise_mv, d.sensor.pixel.dark_voltage_v_per_s) = (0.0, 0.0);
        d.sensor.pixel.conversion_gain_uv_per_e *= 1e-4;
        d.sensor.pixel.full_well_e *= 1e4;
        d.exposure.time_ms = Some(1e5);
        if binning.is_some() {
            d.sensor.cfa.pattern = PatternDescription::Name("quad-bayer".into());
            d.sensor.binning = binning.map(BinningDescription::Mode);
        }
        let (camera, cfa) = (Camera::new(d, GRID).unwrap(), cfa(SETS[0]));
        let settings = EvaluationSettings { luminance_cd_m2, ..EvaluationSettings::default() };
        // Metrics that need no capture have it too.
        let targets =
            Targets::new(&camera, &settings, &Metric::OF_SENSITIVITIES, &[], &|_, make| make()).unwrap();
        let scores = targets.score(&cfa).unwrap();
        let (e, _) = evaluate(&camera.with_cfa(cfa), &settings, &|_, make| make()).unwrap();
        assert!(
            (scores.macbeth_saturated_percent - e.saturated_percent).abs() < 0.5,
            "{luminance_cd_m2} cd/m², {binning:?}: {}, evaluate {}",
            scores.macbeth_saturated_percent,
            e.saturated_percent
        );
        scores.macbeth_saturated_percent
    };
    for binning in [None, Some(BinningMode::Charge), Some(BinningMode::Digital)] {
        let shares = [100.0, 1000.0, 3000.0].map(|light| share(light, binning));
        assert!(shares[0] == 0.0 && shares[0] < shares[1] && shares[1] < shares[2], "{shares:?}");
    }
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
