//! Live pictures of designs: those of a study for the same light, a part as in the whole, and improvements under locks.
#![allow(clippy::unwrap_used)]

use smalti::camera::description::{AutoExposureName, CfaDescription, PatternDescription};
use smalti::camera::{
    COMPARED_NOISE_CAPTURES, Camera, CameraDescription, EvaluationSettings, TestScene, evaluate_with,
    score_picture,
};
use smalti::color::Image;
use smalti::design::live::{
    LiveCrop, LiveEffort, LiveLearner, LivePictures, LiveScene, LiveSetup, LiveTraining,
};
use smalti::design::screen::{Screen, ScreenCondition, ScreenTime};
use smalti::design::search::{FilterSpace, FreeCurves, Improvement, Locks, Objective};
use smalti::design::{
    Condition, LearningSettings, LearningStatistics, Preview, PreviewLight, Study, TrialProcessing, Trials,
};
use smalti::experiment::{Resources, light_statistics};
use smalti::sensor::{Filter, NoiseMode};
use smalti::spectrum::{Illuminant, Observer, WavelengthGrid};

const STUDY: &str = r#"{
    "name": "live", "seed": 5, "colors": [3], "filter_sets": 1, "mosaic_count": null,
    "filters": {"gaussian_grid": {"centers_nm": [430, 10, 660], "sigmas_nm": [20, 5, 55], "min_spacing_nm": 20}},
    "mosaics": {"given": [["bc", "ab"]]},
    "conditions": [], "processing": ["l3"], "metrics": [], "l3": {}
}"#;
const LUMINANCE: f64 = 12.0;

fn learning() -> LearningSettings {
    let statistics = LearningStatistics::Light;
    LearningSettings { side: 3, levels: 2, size_px: 80, statistics, ..LearningSettings::default() }
}

fn light(camera: &CameraDescription) -> (LiveScene, LiveTraining) {
    let setup = LiveSetup::new(camera, Illuminant::D65, learning());
    let scene = TestScene::built_in("dead-leaves?rows=96&cols=144&seed=3");
    (setup.scene(&scene, 6).unwrap(), setup.training(6).unwrap())
}

/// A camera whose exposure leaves room for the training scene.
fn camera() -> CameraDescription {
    let mut camera = CameraDescription::default();
    camera.exposure.time_ms = Some(4.0);
    camera.sensor.quantum_efficiency = Filter::Builtin("silicon".into());
    camera.optics.ir_cut = Some(Filter::Builtin("ir-cut".into()));
    camera
}

fn live(scene: LiveScene, training: LiveTraining) -> (LiveLearner, LivePictures) {
    let learner = LiveLearner::new(training).unwrap();
    let bare = learner.setup().camera().unwrap();
    let pictures = LivePictures::new(scene, &Illuminant::D65, &bare).unwrap();
    (learner, pictures)
}

fn viewed(picture: &Image) -> Vec<u8> {
    let white = Observer::Cie1931.white(&Illuminant::D65.photons(WavelengthGrid::VISIBLE).unwrap()).unwrap();
    picture.shown(Some(white), picture.brightness_gain()).unwrap().rgb8()
}

/// On bare pixels the light of a study and that of the studio are the same numbers, and so are the pictures.
#[test]
fn pictures_are_those_of_a_study_bit_for_bit() {
    let bare = LiveSetup::new(&camera(), Illuminant::D65, learning()).bare;
    assert_eq!(as_in_a_study(bare, LUMINANCE, LearningStatistics::Light), 0.0);
}

/// In light that saturates the training scene, they are those of a study whose pipelines are learned from patches.
#[test]
fn saturated_pictures_are_those_of_patches_bit_for_bit() {
    let mut bright = LiveSetup::new(&camera(), Illuminant::D65, learning()).bare;
    bright.exposure.time_ms = Some(4.0);
    for stops in [0.0, 3.0, 10.0] {
        let share = as_in_a_study(bright.clone(), 1e4 * f64::exp2(stops), LearningStatistics::Patches);
        assert!(share > 10.0, "{stops}: {share} %");
    }
}

/// Compares a picture of a bare camera with that of a study, and returns the share of the samples that saturate, percent.
fn as_in_a_study(bare: CameraDescription, luminance_cd_m2: f64, statistics: LearningStatistics) -> f64 {
    let condition =
        Condition { values: Vec::new(), luminance_cd_m2, illuminant: Illuminant::D65, camera: bare.clone() };
    let l3 = LearningSettings { statistics, ..learning() };
    let study = Study { conditions: vec![condition], l3, ..serde_json::from_str(STUDY).unwrap() };
    let (scene, training) = light(&bare);
    let of_study = PreviewLight {
        factor: luminance_cd_m2,
        scenes: vec![scene.scene.clone()],
        training: Some(training.training.clone()),
    };
    let preview = Preview::new(&study, 0, TrialProcessing::L3, &of_study).unwrap();
    let trial = Trials::new(study.clone()).unwrap().trial(0).unwrap();
    let expected =
        preview.picture(&preview.design(&trial.design).unwrap(), 0, NoiseMode::All).unwrap().rgb8();
    let (mut learner, mut pictures) = live(scene, training);
    let filters = "abc".chars().map(String::from).zip(trial.design.filters.filters).collect();
    let pattern = PatternDescription::Letters(vec!["bc".into(), "ab".into()]);
    let mut description = bare;
    description.sensor.cfa = CfaDescription { pattern, filters, ..CfaDescription::default() };
    let design = learner.learn(&description, luminance_cd_m2, study.seed, LiveEffort::Quick).unwrap();
    let found = pictures.picture(&design, None, NoiseMode::All, study.seed).unwrap();
    assert_eq!(viewed(&found.picture).len(), expected.len());
    assert!(viewed(&found.picture) == expected);
    found.saturated_percent
}

/// The picture and the reference from the light on bare pixels have the CPSNR of the simulation with an optical image.
#[test]
fn pictures_and_references_are_those_of_the_simulation() {
    let (scene, training) = light(&camera());
    let (mut learner, mut pictures) = live(scene, training);
    let design = learner.learn(&camera(), LUMINANCE, 1, LiveEffort::Quick).unwrap();
    let found = pictures.picture(&design, None, NoiseMode::None, 1).unwrap();
    let scores = pictures.scores(&found).unwrap();
    // The same without statistics of components.
    let camera = Camera::new(camera(), WavelengthGrid::VISIBLE).unwrap();
    let setup =
        TestScene::built_in("dead-leaves?rows=96&cols=144&seed=3").before(&camera, &Illuminant::D65).unwrap();
    let bright = smalti::optics::OpticalImage::clone(&setup.image).scaled(LUMINANCE).unwrap();
    let photo = setup
        .camera
        .photograph_learned(design.pipeline(), bright.clone(), &setup.light, (NoiseMode::None, 1))
        .unwrap();
    let reference = setup.camera.reference_as_exposed(&bright, &photo.exposure, &setup.light).unwrap();
    let white = Observer::Cie1931.white(&setup.light).unwrap();
    let expected = score_picture(&photo.picture, &reference, white, &Default::default()).unwrap();
    assert!((scores.cpsnr_db - expected.cpsnr_db).abs() < 0.1, "{} {}", scores.cpsnr_db, expected.cpsnr_db);
}

/// The light of the edges and of the chart in components gives the resolution and the noise of `evaluate` with the same pipeline.
#[test]
fn resolution_and_noise_are_those_of_an_evaluation() {
    let (_, training) = light(&camera());
    let mut learner = LiveLearner::new(training).unwrap();
    let design = learner.learn(&camera(), LUMINANCE, 1, LiveEffort::Quick).unwrap();
    let found = learner.targets(&design, 1).unwrap();
    let settings = EvaluationSettings {
        luminance_cd_m2: LUMINANCE,
        illuminant: Illuminant::D65,
        seed: 1,
        noise_captures: COMPARED_NOISE_CAPTURES,
        exposure: None,
    };
    let camera = Camera::new(camera(), WavelengthGrid::VISIBLE).unwrap();
    let isp = |_: &_| Ok(Box::new(design.pipeline().renderer()) as Box<dyn smalti::isp::Isp>);
    let (expected, _) = evaluate_with(&camera, &settings, &|_, make| make(), &isp).unwrap();
    // Six components describe the light to a few thousandths of the brightest pixel.
    assert_eq!(found.no_mtf50, None);
    for (found, expected) in [
        (found.mtf50_cy_per_mm, expected.mtf50_cy_per_mm),
        (found.mtf50_cy_per_px, expected.mtf50_cy_per_px),
        (found.mtf50_low_contrast_cy_per_mm, expected.mtf50_low_contrast_cy_per_mm),
        (found.mtf50_low_contrast_cy_per_px, expected.mtf50_low_contrast_cy_per_px),
        (found.luminance_noise_percent, expected.luminance_noise_percent.mean),
    ] {
        let found = found.unwrap();
        assert!((found / expected - 1.0).abs() < 0.005, "{found} {expected}");
    }
}

/// The luminance beyond which a camera saturates a share of the samples is that of its ideal captures.
#[test]
fn cameras_saturate_in_the_light_that_is_stated() {
    let (scene, training) = light(&camera());
    let (mut learner, mut pictures) = live(scene, training);
    let with = |change: &dyn Fn(&mut CameraDescription)| {
        let mut description = camera();
        change(&mut description);
        description
    };
    let mut limit = |description: &CameraDescription, share: f64| {
        let camera = learner.camera(description).unwrap();
        let limit = pictures.saturating_luminance(&camera, share).unwrap();
        let mut saturated = |luminance: f64| {
            let design = learner.learn(description, luminance, 1, LiveEffort::Quick).unwrap();
            pictures.raw(&design, NoiseMode::None, 1).unwrap().saturated_percent() / 100.0
        };
        // An exposure that follows the light saturates as much in any light.
        for factor in [0.5, 0.998] {
            assert!(limit < 0.01 || saturated(factor * limit.min(1e4)) <= share, "{limit}");
        }
        // Samples are rounded to numbers: half a step of 1024.
        assert!(limit == f64::INFINITY || saturated(1.01 * limit.max(1.0)) > share, "{limit}");
        limit
    };
    let stated = limit(&camera(), 0.01);
    assert!(stated > 1.0 && limit(&camera(), 0.3) > 1.1 * stated, "{stated}");
    let longer = limit(&with(&|c| c.exposure.time_ms = Some(8.0)), 0.01);
    assert!((longer / stated - 0.5).abs() < 1e-4, "{longer} {stated}");
    let automatic = |name: AutoExposureName, target: Option<f64>| {
        with(&|c| {
            c.exposure.time_ms = None;
            c.exposure.auto = Some(name);
            c.exposure.auto_target = target;
        })
    };
    assert_eq!(limit(&automatic(AutoExposureName::Specular, None), 0.01), f64::INFINITY);
    assert_eq!(limit(&automatic(AutoExposureName::Mean, Some(0.02)), 0.01), f64::INFINITY);
    assert!(limit(&automatic(AutoExposureName::Mean, Some(0.9)), 0.01) < 0.01);
    // Dark current fills half of the range, or all of it.
    let bright = Camera::new(camera(), WavelengthGrid::VISIBLE).unwrap();
    let range_v = bright.sensor.saturation_v(&bright.gain_and_offset());
    let mut dark = |share_of_range: f64| {
        let description = with(&|c| c.sensor.pixel.dark_voltage_v_per_s = share_of_range * range_v / 4e-3);
        pictures.saturating_luminance(&learner.camera(&description).unwrap(), 0.01).unwrap()
    };
    let (half, all) = (dark(0.5), dark(1.1));
    assert!((half / stated - 0.5).abs() < 1e-3 && all == 0.0, "{half} {stated} {all}");
}

#[test]
fn a_part_is_that_of_the_whole_bit_for_bit() {
    let (scene, training) = light(&camera());
    let (mut learner, mut pictures) = live(scene, training);
    for pattern in [&["GR", "BG"][..], &["GRR", "BGG"], &["RGBGR"], &["R", "G", "B", "G"]] {
        let mut description = camera();
        let name = |letter: char| (letter.to_string(), Filter::Builtin(format!("pigment/{letter}")));
        description.sensor.cfa.pattern =
            PatternDescription::Letters(pattern.iter().map(|l| (*l).into()).collect());
        description.sensor.cfa.filters = "RGB".chars().map(name).collect();
        let design = learner.learn(&description, LUMINANCE, 7, LiveEffort::Quick).unwrap();
        let whole = pictures.picture(&design, None, NoiseMode::All, 7).unwrap();
        let LiveCrop { cols: width, .. } = pictures.whole();
        for crop in [[0, 0, 11, 72], [13, 17, 20, 33], [47, 71, 1, 1], [31, 5, 17, 67]] {
            let [row, col, rows, cols] = crop;
            let crop = LiveCrop { row, col, rows, cols };
            let part = pictures.picture(&design, Some(crop), NoiseMode::All, 7).unwrap();
            for (plane, all) in part.picture.planes().planes().zip(whole.picture.planes().planes()) {
                for (r, line) in plane.chunks_exact(cols).enumerate() {
                    assert_eq!(line, &all[(row + r) * width + col..][..cols], "{pattern:?} {crop:?} {r}");
                }
            }
        }
    }
    let outside = LiveCrop { row: 40, col: 0, rows: 9, cols: 1 };
    let design = learner.learn(&camera(), LUMINANCE, 7, LiveEffort::Quick).unwrap();
    let message = pictures.picture(&design, Some(outside), NoiseMode::All, 7).unwrap_err().to_string();
    assert!(message.contains("crop") && message.contains("48 × 72"), "{message}");
}

#[test]
fn keys_that_are_not_live_are_named() {
    let (_, training) = light(&camera());
    let mut learner = LiveLearner::new(training).unwrap();
    let mut refused = |change: &dyn Fn(&mut CameraDescription)| {
        let mut description = camera();
        change(&mut description);
        learner.learn(&description, LUMINANCE, 1, LiveEffort::Quick).unwrap_err().to_string()
    };
    assert!(refused(&|d| d.sensor.pixel.pitch_um = 1.1).contains("sensor.pixel.pitch_um"));
    assert!(refused(&|d| d.sensor.pixel.fill_factor = 0.9).contains("sensor.pixel.fill_factor"));
    assert!(refused(&|d| d.optics.f_number = 2.0).contains("optics.f_number"));
    assert!(refused(&|d| d.optics.defocus_dioptres = 2.0).contains("optics"));
    assert!(refused(&|d| d.wavelengths_nm = Some([400.0, 5.0, 700.0])).contains("wavelengths_nm"));
    assert!(refused(&|d| d.sensor.crosstalk_percent = 5.0).contains("crosstalk"));
    let mut free = |change: &dyn Fn(&mut CameraDescription)| {
        let mut description = camera();
        change(&mut description);
        learner.learn(&description, LUMINANCE, 1, LiveEffort::Quick).unwrap();
    };
    free(&|d| d.sensor.quantum_efficiency = Filter::Flat(0.4));
    free(&|d| d.optics.ir_cut = None);
    free(&|d| d.sensor.pixel.read_noise_mv = 3.0);
    free(&|d| d.exposure.time_ms = None);
    assert!(
        learner.learn(&camera(), f64::NAN, 1, LiveEffort::Quick).is_err()
            && learner.learn(&camera(), 0.0, 1, LiveEffort::Quick).is_err()
    );
}

#[test]
fn an_improvement_lowers_the_cost_and_keeps_what_is_locked() {
    let grid = WavelengthGrid::VISIBLE;
    let camera = Camera::new(camera(), grid).unwrap();
    let scene =
        smalti::scene::catalog::build_natural("macbeth?patch=8", &smalti::scene::Setting::default()).unwrap();
    let settings = smalti::design::light::LightSettings { side: 3, max_components: 4, ..Default::default() };
    let statistics =
        light_statistics(&camera, &Illuminant::D65, Some(&[scene]), &settings, Resources::default()).unwrap();
    let condition = ScreenCondition { luminance_cd_m2: 10.0, time: ScreenTime::Fixed(0.02) };
    let screen = Screen::new(&camera, &statistics, &[condition]).unwrap();
    let space = FilterSpace::Free(FreeCurves { knots: 12, ..FreeCurves::default() }).sampled(grid).unwrap();
    let cfa = &camera.sensor.cfa;
    let mut cells = vec![false; 4];
    cells[0] = true;
    let locks = Locks { filters: vec![true, false, false], cells };
    let begin = |locks| {
        Improvement::new(vec![screen.clone()], space.clone(), &Objective::default(), cfa, locks).unwrap()
    };
    let mut improvement = begin(locks);
    let mut cost = improvement.cost();
    for _ in 0..60 {
        improvement.step();
        assert!(improvement.cost() <= cost);
        cost = improvement.cost();
        assert_eq!(improvement.mosaic().cells()[0], cfa.mosaic().cells()[0]);
    }
    assert!(cost < improvement.own_cost(), "{cost} {}", improvement.own_cost());
    let found = improvement.transmittances().unwrap();
    assert_eq!(found[0], cfa.channels()[0].transmittance);
    assert!(found[1] != cfa.channels()[1].transmittance);
    assert_eq!(improvement.steps(), 60);
    // With everything locked there is nothing to do.
    let mut locked = begin(Locks { filters: vec![true; 3], cells: vec![true; 4] });
    locked.step();
    assert!(locked.is_done() && (locked.cost() - locked.own_cost()).abs() < 1e-9);
    // Of a mosaic that stays, the filters become better at once, until that no longer helps.
    let mut filters = begin(Locks { filters: Vec::new(), cells: vec![true; 4] });
    let first = filters.cost();
    filters.step();
    assert!(filters.cost() < first, "{first}");
    while !filters.is_done() && filters.steps() < 1000 {
        filters.step();
    }
    assert!(filters.is_done() && filters.mosaic() == cfa.mosaic(), "{}", filters.cost());
}

/// Behind a lens that shows no edge, resolution alone is missing, and the reason is told.
#[test]
fn without_an_edge_the_other_figures_remain() {
    let mut blurred = camera();
    blurred.optics.f_number = 1000.0;
    blurred.sensor.pixel.pitch_um = 0.01;
    let (_, training) = light(&blurred);
    let mut learner = LiveLearner::new(training).unwrap();
    let design = learner.learn(&blurred, 1e5, 1, LiveEffort::Quick).unwrap();
    let found = learner.targets(&design, 1).unwrap();
    assert_eq!((found.mtf50_cy_per_px, found.mtf50_low_contrast_cy_per_mm), (None, None));
    let reason = found.no_mtf50.unwrap();
    assert!(reason.contains("edge") && !reason.contains('-'), "{reason}");
}
