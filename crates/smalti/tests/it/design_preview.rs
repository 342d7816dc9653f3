//! The light of a scene as few components, and pictures of designs from it, against captures of the scene itself.
#![allow(clippy::unwrap_used)]

use smalti::camera::description::{
    ArchitectureName, AutoExposureName, BinningDescription, PatternDescription,
};
use smalti::camera::{Camera, CameraDescription, EvaluationSettings, Setup};
use smalti::color::Image;
use smalti::design::{
    Condition, PipelineTrainer, PixelLight, Preview, PreviewLight, PreviewScene, PreviewTraining, Study,
    Targets, TrialProcessing, Trials,
};
use smalti::isp::{Isp, WhiteBalance};
use smalti::scene::Setting;
use smalti::sensor::{BinningMode, Cfa, NoiseMode, PixelSpectra};
use smalti::spectrum::{Illuminant, Observer, WavelengthGrid};

use crate::design_targets::{SETS, cfa};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;
const LEAVES: &str = "dead-leaves?rows=96&cols=128&seed=3";
const LUMINANCE_CD_M2: f64 = 30.0;
const SEED: u64 = 5;

fn setup(change: impl FnOnce(&mut CameraDescription), spec: &str) -> Setup {
    let mut description = CameraDescription::default();
    change(&mut description);
    let camera = Camera::new(description, GRID).unwrap();
    let setting = Setting { luminance_cd_m2: LUMINANCE_CD_M2, ..Setting::default() };
    Setup::of_test_scene(&camera, spec, &setting).unwrap()
}

fn light(setup: &Setup, max_components: usize) -> PixelLight {
    let sensor = &setup.camera.sensor;
    PixelLight::new(sensor, &PixelSpectra::new(sensor, &setup.image).unwrap(), max_components).unwrap()
}

/// Root mean square of what a capture of the components differs by from one of the image, of saturation.
fn error(setup: &Setup, max_components: usize, cfa: &Cfa) -> f64 {
    let camera = setup.camera.with_cfa(cfa.clone());
    let setup = setup.before(&camera).unwrap().unwrap();
    let sensor = &setup.camera.sensor;
    let pixels = light(&setup, max_components).pixels(sensor, 1.0).unwrap();
    let raw = sensor.capture_ideal(&setup.image, &setup.exposure).unwrap().normalized();
    let found = sensor.capture_ideal(&pixels, &setup.exposure).unwrap().normalized();
    let squares: f64 = raw.iter().zip(&found).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (squares / found.len() as f64).sqrt()
}

#[test]
fn few_components_hold_what_filters_see() {
    let change = |d: &mut CameraDescription| {
        d.exposure.analog_gain = 1.5;
        d.exposure.analog_offset_mv = 8.0;
    };
    let leaves = setup(change, LEAVES);
    let rings = setup(change, "zone-plate?size=128&frequency=0.25");
    for set in SETS {
        let cfa = cfa(set);
        // Single precision of the planes.
        assert!(error(&leaves, GRID.len(), &cfa) < 2e-6, "{}", error(&leaves, GRID.len(), &cfa));
        assert!(error(&leaves, 8, &cfa) < 6e-3, "{}", error(&leaves, 8, &cfa));
        assert!(error(&rings, 3, &cfa) < 2e-4, "{}", error(&rings, 3, &cfa));
    }
}

#[test]
fn components_are_orthonormal_and_ordered() {
    let setup = setup(|_| {}, LEAVES);
    let light = light(&setup, 6);
    for (i, a) in light.spectra().iter().enumerate() {
        for (j, b) in light.spectra().iter().enumerate() {
            let product: f64 = a.values().iter().zip(b.values()).map(|(a, b)| a * b).sum();
            assert!((product - f64::from(u8::from(i == j))).abs() < 1e-9);
        }
    }
    let squares: Vec<f64> =
        light.planes().planes().map(|p| p.iter().map(|v| f64::from(*v).powi(2)).sum()).collect();
    assert!(squares.is_sorted_by(|a, b| a > b), "{squares:?}");
    let mean = squares.iter().sum::<f64>() / light.planes().plane_len() as f64;
    assert!(light.brightest() >= mean.sqrt());
    // Half a step at most, of a thousand.
    let quantized = light.quantized(1000.0);
    let again = quantized.light(GRID).unwrap();
    for (a, b) in light.planes().data().iter().zip(again.planes().data()) {
        assert!(f64::from((a - b).abs()) <= 0.5001 * quantized.planes.step);
    }
}

/// On a fine grid the components are found from some of the pixels.
#[test]
fn a_fine_grid_loses_no_more() {
    let grid = WavelengthGrid::new(400.0, 1.0, 301).unwrap();
    let camera = Camera::new(CameraDescription::default(), grid).unwrap();
    let setting = Setting { grid, ..Setting::default() };
    let fine = Setup::of_test_scene(&camera, LEAVES, &setting).unwrap();
    let own = fine.camera.sensor.cfa.clone();
    let coarse = setup(|_| {}, LEAVES);
    let (fine, coarse) = (error(&fine, 8, &own), error(&coarse, 8, &coarse.camera.sensor.cfa));
    assert!(fine < 1.5 * coarse, "{fine}, {coarse}");
}

fn study(camera: CameraDescription, processing: TrialProcessing) -> Study {
    let text = r#"{
        "name": "preview", "seed": 5, "colors": [3], "filter_sets": 4, "mosaic_count": null,
        "filters": {"gaussian_grid": {"centers_nm": [430, 10, 660], "sigmas_nm": [20, 5, 55], "min_spacing_nm": 20}},
        "mosaics": {"given": [["bc", "ab"]]},
        "conditions": [], "processing": [], "metrics": [],
        "l3": {"side": 5, "levels": 3, "size_px": 64}
    }"#;
    let condition = Condition {
        values: Vec::new(),
        luminance_cd_m2: LUMINANCE_CD_M2,
        illuminant: Illuminant::D65,
        camera,
    };
    let study: Study = serde_json::from_str(text).unwrap();
    assert_eq!(study.seed, SEED);
    Study { conditions: vec![condition], processing: vec![processing], ..study }
}

/// A study of one condition, its light with all components, and the scene that it is of.
fn previewed(
    change: impl Fn(&mut CameraDescription),
    processing: TrialProcessing,
) -> (Trials, PreviewLight, Setup, Option<PipelineTrainer>) {
    let mut description = CameraDescription::default();
    change(&mut description);
    let study = study(description, processing);
    let setup = setup(&change, LEAVES);
    let trainer = (processing == TrialProcessing::L3).then(|| {
        let camera = Camera::new(study.conditions[0].camera.clone(), GRID).unwrap();
        let settings = EvaluationSettings {
            luminance_cd_m2: LUMINANCE_CD_M2,
            illuminant: Illuminant::D65,
            seed: SEED,
            ..EvaluationSettings::default()
        };
        let targets = Targets::new(&camera, &settings, &[], &[], &|_, make| make()).unwrap();
        PipelineTrainer::new(&targets, &study.l3, &|_, make| make()).unwrap()
    });
    let light = PreviewLight {
        factor: 1.0,
        scenes: vec![PreviewScene::new(&setup, 12).unwrap()],
        training: trainer.as_ref().map(|l| PreviewTraining::new(l, 12).unwrap()),
    };
    (Trials::new(study).unwrap(), light, setup, trainer)
}

/// Root mean square of the difference of two pictures in sRGB.
fn difference(a: &Image, b: &Image) -> f64 {
    let (a, b) = (a.planes().data(), b.planes().data());
    assert_eq!(a.len(), b.len());
    let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (squares / a.len() as f64).sqrt()
}

fn direct(setup: &Setup, trials: &Trials, number: u64, trainer: Option<&PipelineTrainer>) -> Image {
    let design = trials.trial(number).unwrap().design;
    let camera = setup.camera.with_cfa(design.cfa(GRID).unwrap());
    let Setup { camera, image, light, exposure } = setup.before(&camera).unwrap().unwrap();
    let raw = camera.sensor.capture_ideal(&image, &exposure).unwrap();
    let picture = match trainer {
        Some(trainer) => trainer.pipeline(&camera.sensor.cfa).unwrap().0.render(&raw).unwrap(),
        None => camera.isp(&light, WhiteBalance::None).unwrap().render(&raw).unwrap(),
    };
    let white = Observer::Cie1931.white(&light).unwrap();
    picture.shown(Some(white), picture.brightness_gain()).unwrap()
}

#[test]
fn a_preview_is_the_picture_of_every_kind_of_camera() {
    type Change = fn(&mut CameraDescription);
    let changes: [Change; 8] = [
        |_| {},
        |d| (d.sensor.adc_bits, d.sensor.crosstalk_percent) = (8, 12.0),
        |d| d.sensor.architecture = ArchitectureName::Prism,
        |d| d.sensor.architecture = ArchitectureName::FieldSequential,
        |d| d.exposure.auto = Some(AutoExposureName::Mean),
        |d| d.exposure.auto = Some(AutoExposureName::Luminance),
        |d| d.exposure.time_ms = Some(30.0),
        |d| {
            d.sensor.cfa.pattern = PatternDescription::Name("quad-bayer".into());
            d.sensor.binning = Some(BinningDescription::Mode(BinningMode::Charge));
        },
    ];
    for (i, change) in changes.into_iter().enumerate() {
        let (trials, light, setup, _) = previewed(change, TrialProcessing::Classic);
        let preview = Preview::new(trials.study(), 0, TrialProcessing::Classic, &light).unwrap();
        for number in [0, 3] {
            let design = preview.design(&trials.trial(number).unwrap().design).unwrap();
            let picture = preview.picture(&design, 0, NoiseMode::None).unwrap();
            let found = difference(&picture, &direct(&setup, &trials, number, None));
            // Of a converter with 8 bits, samples that lie between two numbers go to either.
            let limit = if setup.camera.sensor.adc.bits == 8 { 0.03 } else { 0.01 };
            assert!(found < limit, "camera {i}, design {number}: {found}");
            let noisy = preview.picture(&design, 0, NoiseMode::All).unwrap();
            assert!(difference(&noisy, &picture) > 1e-3 && noisy != picture);
        }
    }
}

#[test]
fn a_learned_pipeline_is_that_of_the_study() {
    let (trials, light, setup, trainer) = previewed(|_| {}, TrialProcessing::L3);
    let preview = Preview::new(trials.study(), 0, TrialProcessing::L3, &light).unwrap();
    let design = preview.design(&trials.trial(2).unwrap().design).unwrap();
    let picture = preview.picture(&design, 0, NoiseMode::None).unwrap();
    let found = difference(&picture, &direct(&setup, &trials, 2, trainer.as_ref()));
    assert!(found < 0.02, "{found}");
    // It is not the camera's own processing.
    assert!(difference(&picture, &direct(&setup, &trials, 2, None)) > 0.03);
}

/// Twice the light at half the time.
#[test]
fn the_factor_scales_the_light() {
    let bright = |factor: f64, time_ms: f64| {
        let change = move |d: &mut CameraDescription| d.exposure.time_ms = Some(time_ms);
        let (trials, light, ..) = previewed(change, TrialProcessing::Classic);
        let light = PreviewLight { factor, ..light };
        let preview = Preview::new(trials.study(), 0, TrialProcessing::Classic, &light).unwrap();
        let design = preview.design(&trials.trial(0).unwrap().design).unwrap();
        preview.picture(&design, 0, NoiseMode::None).unwrap()
    };
    let (once, twice) = (bright(1.0, 20.0), bright(2.0, 10.0));
    assert!(difference(&once, &twice) < 1e-6 && difference(&once, &bright(2.0, 20.0)) < 0.3);
    assert!(difference(&once, &bright(0.1, 20.0)) > 0.0);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (trials, light, ..) = previewed(|d| d.sensor.crosstalk_percent = 5.0, TrialProcessing::L3);
            let preview = Preview::new(trials.study(), 0, TrialProcessing::L3, &light).unwrap();
            let design = preview.design(&trials.trial(1).unwrap().design).unwrap();
            (preview.picture(&design, 0, NoiseMode::All).unwrap(), light)
        })
    };
    let (one, three) = (with(1), with(3));
    assert!(one == three);
}

#[test]
fn what_does_not_fit_is_refused() {
    let (trials, light, ..) = previewed(|_| {}, TrialProcessing::Classic);
    let refused = |light: &PreviewLight, condition, processing| {
        Preview::new(trials.study(), condition, processing, light).unwrap_err().to_string()
    };
    assert!(refused(&light, 1, TrialProcessing::Classic).contains("condition"));
    assert!(refused(&light, 0, TrialProcessing::L3).contains("training"));
    let mut short = light.clone();
    short.planes_mut().for_each(|p| p.rows += 1);
    assert!(
        refused(&short, 0, TrialProcessing::Classic).contains("values"),
        "{}",
        refused(&short, 0, TrialProcessing::Classic)
    );
    let preview = Preview::new(trials.study(), 0, TrialProcessing::Classic, &light).unwrap();
    let design = preview.design(&trials.trial(0).unwrap().design).unwrap();
    assert!(preview.picture(&design, 1, NoiseMode::None).is_err());
}
