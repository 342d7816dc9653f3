//! The engine of the studio without a browser: answers are those of the library, and no input makes it panic.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::OnceLock;

use serde_json::{Value, json};
use smalti::camera::{Camera, CameraDescription, ColorimetricObserver, TestScene};
use smalti::color::Image;
use smalti::design::LearningSettings;
use smalti::design::light::LightStatistics;
use smalti::design::live::{
    LiveEffort, LiveLearner, LivePicture, LivePictures, LiveScene, LiveSetup, LiveTraining,
};
use smalti::design::screen::ScreenCondition;
use smalti::design::search::{FilterSpace, FreeCurves};
use smalti::experiment::{Resources, analyse_design, light_statistics};
use smalti::isp::Isp as _;
use smalti::sensor::{Filter, NoiseMode};
use smalti::spectrum::{Illuminant, Observer, WavelengthGrid};
use smalti_io::{cameras, dng, l3, light, studio};
use smalti_wasm::{Answer, Engine, StudioFile};

struct Files {
    camera: CameraDescription,
    scene: LiveScene,
    training: LiveTraining,
    statistics: LightStatistics,
}

fn files() -> &'static Files {
    static FILES: OnceLock<Files> = OnceLock::new();
    FILES.get_or_init(|| {
        let camera = cameras::load("bayer", &[], None).unwrap();
        let learning = LearningSettings { side: 3, levels: 2, size_px: 64, ..LearningSettings::default() };
        let setup = LiveSetup::new(camera.description(), Illuminant::D65, learning);
        let scene = TestScene::built_in("dead-leaves?rows=64&cols=96&seed=3");
        let settings =
            smalti::design::light::LightSettings { side: 3, max_components: 6, ..Default::default() };
        let charts = smalti::scene::catalog::build_natural("macbeth?patch=16", &Default::default()).unwrap();
        Files {
            scene: setup.scene(&scene, 6).unwrap(),
            training: setup.training(6).unwrap(),
            statistics: light_statistics(
                &camera,
                &Illuminant::D65,
                Some(&[charts]),
                &settings,
                Resources::default(),
            )
            .unwrap(),
            camera: camera.description().clone(),
        }
    })
}

fn engine() -> Engine {
    let Files { scene, training, statistics, .. } = files();
    let mut engine = Engine::default();
    let path = Path::new("test");
    engine.load("", StudioFile::Scene, &studio::scene_to_bytes(scene, path).unwrap()).unwrap();
    engine.load("", StudioFile::Training, &studio::training_to_bytes(training, path).unwrap()).unwrap();
    engine.load("", StudioFile::Statistics, &light::to_bytes(statistics, path).unwrap()).unwrap();
    engine
}

fn ask(engine: &mut Engine, request: &Value) -> Answer {
    engine.ask(request.to_string().as_bytes()).unwrap()
}

fn refused(engine: &mut Engine, request: &Value) -> String {
    engine.ask(request.to_string().as_bytes()).unwrap_err().to_string()
}

#[test]
fn pictures_are_those_of_the_library_bit_for_bit() {
    let Files { camera, scene, training, .. } = files();
    let name = scene.name.clone();
    let mut engine = engine();
    let request = |part: &str, reference: bool| json!({part: {"design": camera, "scene": name, "luminance_cd_m2": 5.0, "seed": 3, "reference": reference}});
    let drawn = ask(&mut engine, &request("draw", true));
    let mut learner = LiveLearner::new(training.clone()).unwrap();
    let design = learner.learn(camera, 5.0, 3, LiveEffort::Quick).unwrap();
    let bare = learner.setup().camera().unwrap();
    let mut pictures = LivePictures::new(scene.clone(), &Illuminant::D65, &bare).unwrap();
    let picture = pictures.picture(&design, None, NoiseMode::All, 3).unwrap();
    let both = [pictures.rgba8(&picture).unwrap(), pictures.reference_rgba8(None).unwrap()].concat();
    assert_eq!((drawn.said["height"].as_u64(), drawn.said["width"].as_u64()), (Some(32), Some(48)));
    assert!(drawn.bytes == both);
    assert_eq!(drawn.said["exposure_ms"], json!(100.0));
    let measured = ask(&mut engine, &request("measure", false));
    let mut careful = request("measure", false);
    careful["measure"]["thorough"] = json!(true);
    let careful = ask(&mut engine, &careful);
    let scores = pictures.scores(&picture).unwrap();
    assert_eq!(measured.said["cpsnr_db"].as_f64(), Some(scores.cpsnr_db));
    assert_eq!(measured.said["scielab_mean"].as_f64(), Some(scores.scielab_mean));
    assert_eq!(measured.bytes.len(), 4 * 32 * 48);
    let thorough = learner.learn(camera, 5.0, 3, LiveEffort::Thorough).unwrap();
    let of_thorough = pictures.picture(&thorough, None, NoiseMode::All, 3).unwrap();
    let thorough = pictures.scores(&of_thorough).unwrap().cpsnr_db;
    assert_eq!(careful.said["cpsnr_db"].as_f64(), Some(thorough));
    assert_ne!(thorough, scores.cpsnr_db);
    let targets = learner.targets(&design, 3).unwrap();
    assert_eq!(measured.said["targets"], json!(targets));
    assert!(targets.mtf50_low_contrast_cy_per_px.unwrap() > 0.1);
    // The answer as bytes.
    let bytes = drawn.to_bytes();
    let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
    assert_eq!(serde_json::from_slice::<Value>(&bytes[4..4 + length]).unwrap(), drawn.said);
    assert!(bytes[4 + length..] == drawn.bytes);
}

#[test]
fn a_difference_is_that_of_the_pictures_of_two_designs() {
    let Files { camera, scene, training, .. } = files();
    let mut other = camera.clone();
    other.sensor.pixel.read_noise_mv *= 8.0;
    let request = |design: &CameraDescription| json!({"design": design, "scene": scene.name, "luminance_cd_m2": 5.0, "seed": 3});
    let asked = |first, second| json!({"difference": {"picture": request(first), "other": request(second)}});
    let mut engine = engine();
    let found = ask(&mut engine, &asked(camera, &other));
    let mut learner = LiveLearner::new(training.clone()).unwrap();
    let bare = learner.setup().camera().unwrap();
    let mut pictures = LivePictures::new(scene.clone(), &Illuminant::D65, &bare).unwrap();
    let mut picture = |of: &CameraDescription| {
        let design = learner.learn(of, 5.0, 3, LiveEffort::Quick).unwrap();
        pictures.picture(&design, None, NoiseMode::All, 3).unwrap()
    };
    let (one, two) = (picture(camera), picture(&other));
    let expected = pictures.difference(&one, &two).unwrap();
    assert!(found.bytes == expected.data().iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
    assert!(expected.data().iter().sum::<f32>() > 0.0);
    // Of a picture from itself, also once the other one is kept.
    let none = ask(&mut engine, &asked(&other, &other));
    assert!(none.bytes.iter().all(|byte| *byte == 0));
    // It is asked for again without the first picture, which another request has replaced.
    assert!(ask(&mut engine, &asked(camera, &other)).bytes == found.bytes);
}

#[test]
fn scores_are_those_of_the_command() {
    let Files { camera, statistics, .. } = files();
    let luminances = [1.0, 10.0];
    let request = json!({"scores": {"design": camera, "luminances_cd_m2": luminances, "derivatives": true}});
    let said = ask(&mut engine(), &request).said;
    let resolved = Camera::new(camera.clone(), WavelengthGrid::VISIBLE).unwrap();
    let conditions = luminances.map(|l| ScreenCondition::of_camera(&resolved, l, 0.033));
    let analysis = analyse_design(&resolved, statistics, &conditions, 1.0, &resolved.sensor.cfa).unwrap();
    let near = |found: &Value, expected: f64| {
        let found = found.as_f64().unwrap();
        assert!((found - expected).abs() < 1e-6 * expected.abs().max(1.0), "{found} {expected}");
    };
    for (at, expected) in analysis.expected.iter().enumerate() {
        let found = &said["expected"][at];
        near(&found["luminance_cd_m2"], luminances[at]);
        near(&found["cpsnr_db"], expected.cpsnr_db);
        near(&found["delta_e_2000"], expected.delta_e_2000);
        near(&found["scielab"], expected.scielab);
        near(&found["detail_db"], expected.detail_db);
    }
    let observer =
        ColorimetricObserver::new(&Illuminant::D65.photons(WavelengthGrid::VISIBLE).unwrap()).unwrap();
    let figures = resolved.array_figures(&observer).unwrap();
    near(&said["array"]["vora_value"], figures.colorimetry.vora_value);
    near(&said["array"]["photon_efficiency"], figures.photon_efficiency);
    near(&said["array"]["condition_number"], figures.condition_number.unwrap());
    // The derivative is that of a small change of the filter.
    let green = |by: f64| {
        let mut changed = camera.clone();
        let channel = resolved.sensor.cfa.channels().iter().find(|c| c.name == "G").unwrap();
        let mut values = channel.transmittance.values().to_vec();
        values[14] += by;
        changed.sensor.cfa.filters =
            ["R", "B"].map(|l| (l.into(), smalti::sensor::Filter::Builtin(format!("pigment/{l}")))).into();
        let grid = WavelengthGrid::VISIBLE;
        let samples =
            smalti::sensor::Filter::Samples { start_nm: grid.start_nm(), step_nm: grid.step_nm(), values };
        changed.sensor.cfa.filters.insert("G".into(), samples);
        let request = json!({"scores": {"design": changed, "luminances_cd_m2": [1.0], "derivatives": true}});
        ask(&mut engine(), &request).said
    };
    let (less, at, more) = (green(-1e-4), green(0.0), green(1e-4));
    let value = |said: &Value| said["expected"][0]["cpsnr_db"].as_f64().unwrap();
    let expected = (value(&more) - value(&less)) / 2e-4;
    let found = at["derivatives"]["cpsnr_db"]["G"][14].as_f64().unwrap();
    assert!((found - expected).abs() < 1e-4 * expected.abs(), "{found} {expected}");
}

#[test]
fn filters_that_the_family_does_not_have_are_named() {
    let mut engine = engine();
    let mut camera = files().camera.clone();
    let band = smalti::sensor::Filter::Box { low_nm: 500.0, high_nm: 540.0, peak: 1.0 };
    let pigment =
        |letter: &str| (letter.to_owned(), smalti::sensor::Filter::Builtin(format!("pigment/{letter}")));
    camera.sensor.cfa.filters = ["R", "B"].map(pigment).into();
    camera.sensor.cfa.filters.insert("G".into(), band);
    let mut warnings = |family: Value| {
        let request = json!({"scores": {"design": camera, "luminances_cd_m2": [], "family": family}});
        let said = ask(&mut engine, &request).said;
        let named = said["warnings"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|w| w["message"].as_str().unwrap().contains("cannot be made"));
        named.map(|w| w["filter"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(warnings(Value::Null), [""; 0]);
    assert!(warnings(json!("pigments")).contains(&"G".to_owned()));
    assert!(!warnings(json!("dichroic")).is_empty());
    assert_eq!(warnings(json!("pigments")), warnings(json!("pigments")));
}

/// What the page found in a family is of the family, also where its curves are steep; a higher peak is told as such.
#[test]
fn filters_that_the_page_found_can_be_made() {
    let mut engine = engine();
    let warned = |engine: &mut Engine, design: &Value, family: &str| -> Vec<String> {
        let request = json!({"scores": {"design": design, "luminances_cd_m2": [], "family": family}});
        let said = ask(engine, &request).said;
        let all =
            said["warnings"].as_array().unwrap().iter().map(|w| w["message"].as_str().unwrap().to_owned());
        all.filter(|m| m.contains("cannot be made") || m.starts_with("the peak of")).collect()
    };
    for family in ["free", "pigments", "dichroic"] {
        let begin = json!({"improve": {"design": files().camera, "locks": {"mosaic": true}, "luminances_cd_m2": [2.0], "family": family}});
        let mut step = ask(&mut engine, &begin).said;
        for _ in 0..60 {
            step = ask(&mut engine, &json!({"step": {}})).said;
        }
        assert_eq!(warned(&mut engine, &step["design"], family), [""; 0], "{family}");
    }
    let mut design = json!(files().camera);
    // Searches beside the page have fewer knots.
    let coarse = FilterSpace::Free(FreeCurves::default()).sampled(WavelengthGrid::VISIBLE).unwrap();
    let steep = |sign: f64| {
        let parameters: Vec<f64> =
            (0..coarse.parameters()).map(|i| sign * if i % 3 == 0 { 9.0 } else { -7.0 }).collect();
        json!(Filter::sampled(&coarse.spectrum(&parameters).unwrap()))
    };
    design["sensor"]["cfa"] =
        json!({"pattern": ["RG", "GR"], "filters": {"R": steep(1.0), "G": steep(-1.0)}});
    assert_eq!(warned(&mut engine, &design, "free"), [""; 0]);
    let gaussian = |center_nm: f64, peak: f64| json!({"gaussian": {"center_nm": center_nm, "sigma_nm": 40.0, "peak": peak}});
    design["sensor"]["cfa"] = json!({
        "pattern": ["RG", "GB"],
        "filters": {"R": gaussian(610.0, 0.9), "G": gaussian(540.0, 1.0), "B": gaussian(460.0, 0.95)},
    });
    assert_eq!(
        warned(&mut engine, &design, "free"),
        ["the peak of the filter G is 100 % transmittance; smooth curves reach 95 %"]
    );
}

/// Each step of an improvement among pigments is one that a factory can make: with two pigments in a filter at most, as those of `smalti design`. The engine states
/// them, and their layers make the curve.
#[test]
fn improvements_state_the_pigments_of_filters_that_can_be_made() {
    let mut engine = engine();
    let mut design = json!(files().camera);
    let gaussian = |nm: f64| json!({"gaussian": {"center_nm": nm, "sigma_nm": 38.0, "peak": 0.9}});
    design["sensor"]["cfa"] = json!({
        "pattern": ["RG", "GB"],
        "filters": {"R": gaussian(605.0), "G": gaussian(540.0), "B": gaussian(455.0)},
    });
    let curves = |engine: &mut Engine, design: &Value| {
        ask(engine, &json!({"curves": {"design": design}})).said["channels"].as_array().unwrap().clone()
    };
    let pigment = |name: &str| {
        let spectrum = Filter::Builtin(name.into()).spectrum(WavelengthGrid::VISIBLE).unwrap();
        let most = spectrum.max();
        spectrum.values().iter().map(|t| (t / most).max((-7.0f64).exp())).collect::<Vec<f64>>()
    };
    assert!(curves(&mut engine, &design).iter().all(|channel| channel["pigments"].is_null()));
    let begin = json!({"improve": {"design": design, "locks": {"mosaic": true}, "luminances_cd_m2": [2.0], "family": "pigments"}});
    let mut step = ask(&mut engine, &begin).said;
    let mut costs = Vec::new();
    while !step["is_done"].as_bool().unwrap() {
        for channel in curves(&mut engine, &step["design"]) {
            let layers = channel["pigments"].as_array().unwrap();
            assert!((1..=2).contains(&layers.len()), "{channel}");
            let mut made = vec![0.95; 31];
            for layer in layers {
                let thickness = layer["thickness"].as_f64().unwrap();
                let of_pigment = pigment(layer["name"].as_str().unwrap());
                made.iter_mut().zip(of_pigment).for_each(|(m, t)| *m *= t.powf(thickness));
            }
            for (made, stated) in made.iter().zip(channel["transmittance"].as_array().unwrap()) {
                assert!((made - stated.as_f64().unwrap()).abs() < 0.005, "{channel}");
            }
        }
        costs.push(step["cost"].as_f64().unwrap());
        step = ask(&mut engine, &json!({"step": {}})).said;
    }
    assert!(costs.len() > 3 && costs.is_sorted_by(|a, b| a >= b), "{costs:?}");
}

/// Arrays that cannot tell all colours apart, whatever the noise of their colour matrix.
#[test]
fn arrays_that_confuse_colours_are_named() {
    let mut engine = engine();
    let mut warned = |pattern: Value, blue: Value| -> Vec<String> {
        let mut design = json!(files().camera);
        let pigment = |letter: &str| json!({"builtin": format!("pigment/{letter}")});
        let filters = json!({"R": pigment("R"), "G": pigment("G"), "B": blue, "W": {"flat": 0.95}});
        design["sensor"]["cfa"] = json!({"pattern": pattern, "filters": filters});
        let said = ask(&mut engine, &json!({"scores": {"design": design, "luminances_cd_m2": []}})).said;
        let all =
            said["warnings"].as_array().unwrap().iter().map(|w| w["message"].as_str().unwrap().to_owned());
        all.filter(|m| m.starts_with("the array")).collect()
    };
    let [green, blue] = ["G", "B"].map(|letter| json!({"builtin": format!("pigment/{letter}")}));
    assert_eq!(warned(json!(["RG", "GB"]), blue.clone()), [""; 0]);
    assert_eq!(warned(json!(["RW", "WB"]), blue.clone()), [""; 0]);
    for (pattern, blue, word) in [
        (json!(["RG", "GB"]), green, "only two of its channels"),
        (json!(["RG", "GR"]), blue.clone(), "only two of its channels"),
        (json!(["WW", "WW"]), blue, "sees no colour"),
    ] {
        let found = warned(pattern, blue);
        assert!(
            found.len() == 1 && found[0].contains(word) && found[0].contains("colour needs three"),
            "{found:?}"
        );
    }
}

/// In light that saturates a design, the page goes on: the picture is the clipped capture, and a warning states the share of its samples that saturate.
#[test]
fn pictures_and_scores_go_on_where_the_light_saturates() {
    let mut engine = engine();
    let Files { camera, scene, .. } = files();
    let design = json!(camera);
    let mut shares = Vec::new();
    for luminance in [5.0, 3000.0, 10_000.0, 1e6] {
        let request = json!({"design": design, "scene": scene.name, "luminance_cd_m2": luminance, "seed": 3});
        let Answer { said, bytes } = ask(&mut engine, &json!({"draw": request}));
        assert_eq!(bytes.len(), 4 * 32 * 48);
        let measured = ask(&mut engine, &json!({"measure": request})).said;
        assert!(measured["cpsnr_db"].as_f64().unwrap().is_finite(), "{measured}");
        let share = said["saturated_percent"].as_f64().unwrap();
        let stated = format!(
            "{share:.1} % of the samples saturate: the picture and its scores show clipping, in highlights or in darker, saturated colours"
        );
        let is_stated = said["warnings"].as_array().unwrap().iter().any(|w| w["message"] == stated.as_str());
        assert_eq!(is_stated, share > 1.0, "{said}");
        let mut thorough = request.clone();
        thorough["thorough"] = json!(true);
        let thorough = ask(&mut engine, &json!({"measure": thorough})).said;
        assert!(thorough["cpsnr_db"].as_f64().unwrap().is_finite(), "{thorough}");
        shares.push(share);
    }
    assert!(shares[0] < 1.0 && shares[2] > 30.0 && shares[3] > 99.0 && shares.is_sorted(), "{shares:?}");
    // The figures over luminance reach the end of its range.
    let request = json!({"scores": {"design": design, "luminances_cd_m2": [0.1, 10.0, 1000.0]}});
    let expected = ask(&mut engine, &request).said["expected"].clone();
    assert!(
        expected.as_array().unwrap().iter().all(|e| e["cpsnr_db"].as_f64().unwrap().is_finite()),
        "{expected}"
    );
}

/// Where a design clips is what the library says of the share that the catalogue states.
#[test]
fn the_luminance_beyond_which_a_design_clips_is_that_of_the_library() {
    let Files { camera, scene, training, .. } = files();
    let mut engine = engine();
    let share =
        ask(&mut engine, &json!({"catalogue": {}})).said["saturated_percent"].as_f64().unwrap() / 100.0;
    let learner = LiveLearner::new(training.clone()).unwrap();
    let bare = learner.setup().camera().unwrap();
    let mut pictures = LivePictures::new(scene.clone(), &Illuminant::D65, &bare).unwrap();
    let request = |design: &CameraDescription| json!({"clipping": {"design": design, "scene": scene.name}});
    let expected = pictures.saturating_luminance(&learner.camera(camera).unwrap(), share).unwrap();
    assert_eq!(ask(&mut engine, &request(camera)).said, json!({"luminance_cd_m2": expected}));
    let mut automatic = camera.clone();
    automatic.exposure.time_ms = None;
    assert_eq!(ask(&mut engine, &request(&automatic)).said, json!({"luminance_cd_m2": null}));
    let mut other = camera.clone();
    other.sensor.pixel.pitch_um = 1.0;
    assert!(refused(&mut engine, &request(&other)).contains("pitch_um"));
}

#[test]
fn camera_files_read_back() {
    let mut engine = engine();
    let design = json!(files().camera);
    let toml = ask(&mut engine, &json!({"camera_toml": {"design": design}})).said["toml"].clone();
    assert_eq!(ask(&mut engine, &json!({"parse": {"text": toml}})).said["design"], design);
    let curves = ask(&mut engine, &json!({"curves": {"design": design}})).said;
    assert_eq!(curves["mosaic"].as_array().unwrap().len(), 2);
    assert_eq!(curves["channels"].as_array().unwrap().len(), 3);
    assert_eq!(curves["wavelengths_nm"].as_array().unwrap().len(), 31);
    let catalogue = ask(&mut engine, &json!({"catalogue": {}})).said;
    assert!(catalogue["cfas"].as_array().unwrap().iter().any(|c| c["name"] == "rgbw"));
}

#[test]
fn improvements_go_on_and_keep_locks() {
    let mut engine = engine();
    assert!(refused(&mut engine, &json!({"step": {}})).contains("improvement"));
    let design = json!(files().camera);
    let begin = |locks: Value| json!({"improve": {"design": design, "locks": locks, "luminances_cd_m2": [2.0, 20.0]}});
    let mut step = ask(&mut engine, &begin(json!({"filters": ["G"], "mosaic": true}))).said;
    for _ in 0..8 {
        let next = ask(&mut engine, &json!({"step": {}})).said;
        assert!(next["cost"].as_f64().unwrap() <= step["cost"].as_f64().unwrap());
        step = next;
    }
    assert_eq!(step["design"]["sensor"]["cfa"]["pattern"].as_array().unwrap().len(), 2);
    assert_eq!(step["step"], json!(8));
    // The design of a step is one that the engine draws.
    let request =
        json!({"learn": {"design": step["design"], "scene": files().scene.name, "luminance_cd_m2": 5.0}});
    ask(&mut engine, &request);
    assert!(refused(&mut engine, &begin(json!({"filters": ["W"]}))).contains("no filter \"W\""));
    assert!(refused(&mut engine, &begin(json!({"cells": [[0, 2]]}))).contains("2 × 2"));
}

/// A palette may have a filter that no cell has: it stays, whether it is locked or not.
#[test]
fn improvements_keep_filters_without_cells() {
    let mut engine = engine();
    let mut design = json!(files().camera);
    let clear = json!({"flat": 0.9});
    let pigment = |letter: &str| json!({"builtin": format!("pigment/{letter}")});
    design["sensor"]["cfa"] = json!({
        "pattern": ["RG", "GB"],
        "filters": {"R": pigment("R"), "G": pigment("G"), "B": pigment("B"), "C": clear},
    });
    for locked in [json!(["G"]), json!(["G", "C"])] {
        let begin = json!({"improve": {"design": design, "locks": {"filters": locked, "mosaic": true}, "luminances_cd_m2": [2.0]}});
        ask(&mut engine, &begin);
        let filters =
            ask(&mut engine, &json!({"step": {}})).said["design"]["sensor"]["cfa"]["filters"].clone();
        assert_eq!(filters["C"], clear);
        assert_eq!(filters["G"], pigment("G"));
        assert!(filters["R"]["samples"].is_object() && filters["B"]["samples"].is_object(), "{filters}");
        assert_eq!(filters.as_object().unwrap().len(), 4);
    }
}

/// The table and the raw image that the page saves make the picture that it shows, of built-in scenes and of photographs.
#[test]
fn the_table_and_the_raw_image_make_the_picture() {
    let Files { camera, scene, training, .. } = files();
    let path = Path::new("test");
    let mut engine = engine();
    let half = |color: [u8; 4]| color.repeat(24);
    engine
        .photograph("mine", [40, 48], &[half([250; 4]), half([180, 90, 60, 255])].concat().repeat(40))
        .unwrap();
    let light = ask(&mut engine, &json!({"light": {"design": camera, "of": {"scene": "mine"}}})).bytes;
    engine.load("", StudioFile::Scene, &light).unwrap();
    let mut learner = LiveLearner::new(training.clone()).unwrap();
    let design = learner.learn(camera, 5.0, 3, LiveEffort::Thorough).unwrap();
    let bare = learner.setup().camera().unwrap();
    let table = json!({"table": {"design": camera, "luminance_cd_m2": 5.0, "seed": 3}});
    let table = ask(&mut engine, &table).bytes;
    let pipeline = l3::table_from_bytes(&table, path).unwrap();
    assert_eq!(pipeline, learner.table(&design).unwrap());
    let provenance: Value = serde_json::from_str(pipeline.provenance()).unwrap();
    assert_eq!(provenance["learned_in"], "the studio, from patches at several exposures");
    assert_eq!(
        (&provenance["learning"]["side"], &provenance["learning"]["size_px"]),
        (&json!(3), &json!(64))
    );
    assert_eq!(
        (provenance["learning"].get("statistics"), &provenance["learning"]["levels"]),
        (None, &json!(8))
    );
    assert_eq!(provenance["scenes"][0], "training scene 0 of studies, 64 × 64 pixels");
    assert_eq!((&provenance["camera"], &provenance["luminance_cd_m2"]), (&json!(camera), &json!(5.0)));
    let white = Illuminant::D65.photons(WavelengthGrid::VISIBLE).unwrap();
    assert_eq!(pipeline.white(), Some(Observer::Cie1931.white(&white).unwrap()));
    for scene in [scene.clone(), studio::scene_from_bytes(&light, path).unwrap()] {
        let request = json!({"design": camera, "scene": scene.name, "luminance_cd_m2": 5.0, "seed": 3});
        let mut thorough = request.clone();
        thorough["thorough"] = json!(true);
        let Answer { said, bytes: shown } = ask(&mut engine, &json!({"draw": thorough}));
        let raw = ask(&mut engine, &json!({"raw": request})).bytes;
        let read = dng::from_bytes(&raw, path).unwrap();
        let mut pictures = LivePictures::new(scene, &Illuminant::D65, &bare).unwrap();
        assert!(read.raw == pictures.raw(&design, NoiseMode::All, 3).unwrap());
        assert_eq!(read.info.model, camera.name);
        let expected = pictures.picture(&design, None, NoiseMode::All, 3).unwrap();
        let rendered = pipeline.render(&read.raw).unwrap();
        let bits = |image: &Image| image.planes().data().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert!(bits(&rendered) == bits(&expected.picture));
        // `smalti render` with the gain that the page states.
        let balanced = rendered.balanced(pipeline.white()).unwrap();
        assert!(balanced.shown(None, said["gain"].as_f64().unwrap()).unwrap().rgba8() == shown);
        assert!(pictures.rgba8(&LivePicture { picture: rendered, ..expected }).unwrap() == shown);
        // Without noise it is another capture.
        let mut ideal = request.clone();
        ideal["noise"] = json!(false);
        assert!(ask(&mut engine, &json!({"raw": ideal})).bytes != raw);
    }
    let cropped = json!({"raw": {"design": camera, "scene": "mine", "luminance_cd_m2": 5.0, "crop": null}});
    assert!(refused(&mut engine, &cropped).contains("crop"));
}

/// What lies beyond the wavelengths of the page is judged by the curves that are stated there.
#[test]
fn infrared_is_judged_where_curves_are_stated() {
    let mut engine = engine();
    let mut warnings = |change: &dyn Fn(&mut Value)| {
        let mut design = json!(files().camera);
        let pigment = |letter: &str| json!({"builtin": format!("pigment/{letter}")});
        design["sensor"]["cfa"] = json!({
            "pattern": ["RG", "GB"],
            "filters": {"R": pigment("R"), "G": pigment("G"), "B": pigment("B")},
        });
        design["sensor"]["quantum_efficiency"] = json!({"builtin": "silicon"});
        change(&mut design);
        let said = ask(&mut engine, &json!({"scores": {"design": design, "luminances_cd_m2": []}})).said;
        let all = said["warnings"].as_array().unwrap().iter();
        all.filter(|w| w["key"] == "optics.ir_cut")
            .map(|w| w["message"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    let without = |design: &mut Value| drop(design["optics"].as_object_mut().unwrap().remove("ir_cut"));
    let table = |values: Vec<f64>| json!({"samples": {"start_nm": 400.0, "step_nm": 10.0, "values": values}});
    // A table that is dark at 700 nm does not say what it is beyond.
    let fading: Vec<f64> = (0..31).map(|i| if i < 25 { 0.5 } else { 0.0 }).collect();
    assert_eq!(warnings(&|design| design["optics"]["ir_cut"] = json!({"builtin": "ir-cut"})), [""; 0]);
    let seen = warnings(&without);
    assert!(seen.iter().any(|m| m.starts_with("the channel R responds at ")), "{seen:?}");
    assert!(!seen.iter().any(|m| m.contains("cannot be judged")), "{seen:?}");
    let unknown = warnings(&|design| {
        without(design);
        design["sensor"]["cfa"]["filters"]["R"] = table(fading.clone());
    });
    assert!(
        unknown
            .iter()
            .any(|m| m.starts_with("whether light beyond 700 nm reaches the filters R cannot be judged")),
        "{unknown:?}"
    );
    assert!(!unknown.iter().any(|m| m.starts_with("the channel R responds")), "{unknown:?}");
    // The infrared cut is stated there.
    let cut = warnings(&|design| {
        design["optics"]["ir_cut"] = json!({"builtin": "ir-cut"});
        design["sensor"]["cfa"]["filters"]["R"] = table(fading.clone());
    });
    assert_eq!(cut, [""; 0]);
}

/// A design has in another mosaic the filters of the camera that was opened, and those that were changed by hand in place of those of their kind.
#[test]
fn mosaics_keep_the_filters_of_the_camera_and_those_changed_by_hand() {
    let mut engine = engine();
    let request = |base: &Value, given: &Value, changed: &Value, array: &Value, mosaic: &str| json!({"mosaic": {"base": base, "given": given, "changed": changed, "array": array, "mosaic": mosaic}});
    let builtin = |name: &str| json!({"builtin": name});
    let base = json!({"pattern": "bayer"});
    let full = |filters: Value| json!({"pattern": ["GR", "BG"], "filters": filters});
    let plain = full(json!({"R": builtin("red"), "G": builtin("green"), "B": builtin("blue")}));
    let own = ask(&mut engine, &request(&base, &base, &json!([]), &plain, "bayer")).said;
    assert_eq!((&own["is_own"], &own["array"]), (&json!(true), &own["in_full"]));
    let mine = json!({"gaussian": {"center_nm": 611.0, "sigma_nm": 30.0, "peak": 0.9}});
    let by_hand = full(json!({"R": mine, "G": builtin("green"), "B": builtin("blue")}));
    let rgbw = ask(&mut engine, &request(&base, &base, &json!([]), &by_hand, "rgbw")).said;
    assert_eq!(rgbw["given"], json!({"pattern": "rgbw"}));
    assert_eq!(rgbw["is_own"], json!(false));
    assert_eq!((&rgbw["in_full"]["filters"]["R"], &rgbw["array"]["filters"]["R"]), (&builtin("red"), &mine));
    assert_eq!(
        (&rgbw["in_full"]["pattern"], &rgbw["array"]["filters"]["W"]),
        (&rgbw["array"]["pattern"], &builtin("white"))
    );
    // The change is remembered where the mosaic has no such filter, and ends where it is taken back.
    let mono =
        ask(&mut engine, &request(&base, &rgbw["given"], &rgbw["changed"], &rgbw["array"], "mono")).said;
    assert_eq!(
        (&mono["array"]["filters"], &mono["changed"][0]["filter"]),
        (&json!({"W": builtin("white")}), &mine)
    );
    let again =
        ask(&mut engine, &request(&base, &mono["given"], &mono["changed"], &mono["array"], "bayer")).said;
    assert_eq!(again["array"]["filters"], by_hand["filters"]);
    let back = ask(&mut engine, &request(&base, &again["given"], &again["changed"], &plain, "rgbw")).said;
    assert_eq!((&back["array"], &back["changed"]), (&back["in_full"], &json!([])));
    // A camera with curves of its own has none for some letters.
    let measured = json!({"pattern": "bayer", "filters": {"R": mine}});
    let missing = ask(&mut engine, &request(&measured, &measured, &json!([]), &by_hand, "rgbw")).said;
    assert_eq!(missing, json!({"missing": ["W"]}));
    // A filter that was added serves its letter, in one mosaic after another.
    let mut added = by_hand.clone();
    added["filters"]["W"] = mine.clone();
    let mut last = ask(&mut engine, &request(&measured, &measured, &json!([]), &added, "rgbw")).said;
    for mosaic in ["mono", "rgbw"] {
        assert_eq!(last["array"]["filters"]["W"], mine, "{last}");
        let next = request(&measured, &last["given"], &last["changed"], &last["array"], mosaic);
        last = ask(&mut engine, &next).said;
    }
    assert_eq!((&last["array"]["filters"]["W"], &last["array"]["filters"]["R"]), (&mine, &mine));
    assert!(refused(&mut engine, &request(&base, &base, &json!([]), &plain, "bayr")).contains("bayer"));
}

#[test]
fn what_is_wrong_is_told() {
    let mut engine = engine();
    let Files { camera, scene, .. } = files();
    let with = |path: &[&str], value: Value| {
        let mut design = json!(camera);
        let mut at = &mut design;
        for key in path {
            at = &mut at[*key];
        }
        *at = value;
        json!({"draw": {"design": design, "scene": scene.name, "luminance_cd_m2": 5.0}})
    };
    let key = refused(&mut engine, &with(&["sensor", "pixel", "pich_um"], json!(2.2)));
    assert!(key.contains("pich_um") && key.contains("pitch_um"), "{key}");
    let key = refused(&mut engine, &with(&["optics", "f_number"], json!("wide")));
    assert!(key.contains("f_number") || key.contains("wide"), "{key}");
    assert!(refused(&mut engine, &with(&["sensor", "pixel", "pitch_um"], json!(1.0))).contains("pitch_um"));
    assert!(
        refused(&mut engine, &with(&["sensor", "cfa", "pattern"], json!(["RG", "B"]))).contains("pattern")
    );
    assert!(refused(&mut engine, &with(&["sensor", "adc_bits"], json!(99))).contains("adc_bits"));
    assert!(refused(&mut engine, &json!({"paint": {}})).contains("unknown variant"));
    assert!(refused(&mut engine, &json!({"curves": {"design": [1, null]}})).len() > 10);
    assert!(
        refused(&mut engine, &json!({"parse": {"text": "[sensor]\nrowz = 4"}})).contains("camera.toml:2")
    );
    let huge = "x".repeat(5 << 20);
    assert!(refused(&mut engine, &json!({"parse": {"text": huge}})).contains("at most"));
    // A request that is cut anywhere.
    let whole = with(&["name"], json!("a")).to_string();
    for end in (0..whole.len()).step_by(7) {
        assert!(engine.ask(&whole.as_bytes()[..end]).is_err(), "{end}");
    }
    // Deep nesting.
    let deep = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(engine.ask(format!("{{\"curves\":{{\"design\":{deep}}}}}").as_bytes()).is_err());
    assert!(engine.ask(whole.as_bytes()).is_ok());
    // Files that were not loaded, or are damaged.
    assert!(
        refused(&mut Engine::default(), &with(&["name"], json!("a")))
            .contains("expected before this request")
    );
    let bytes = studio::training_to_bytes(&files().training, Path::new("test")).unwrap();
    for at in (0..bytes.len()).step_by(bytes.len() / 23) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        assert!(engine.load("", StudioFile::Training, &damaged).is_err(), "byte {at}");
        assert!(engine.load("", StudioFile::Training, &bytes[..at]).is_err(), "{at} bytes");
    }
    assert!(
        engine.load("", StudioFile::Scene, &bytes).unwrap_err().to_string().contains("smalti-studio-scene")
    );
}

/// Beside white, which fills the display, a colour of a photograph is shown as it is.
#[test]
fn photographs_become_scenes() {
    let mut engine = engine();
    let (white, color) = ([255u8; 4], [180u8, 90, 60, 255]);
    let line = [white.repeat(24), color.repeat(24)].concat();
    let rgba = line.repeat(40);
    engine.photograph("mine", [40, 48], &rgba).unwrap();
    let design = json!(files().camera);
    let light = ask(&mut engine, &json!({"light": {"design": design, "of": {"scene": "mine"}}}));
    engine.load("", StudioFile::Scene, &light.bytes).unwrap();
    let request =
        json!({"draw": {"design": design, "scene": "mine", "luminance_cd_m2": 5.0, "reference": true}});
    let drawn = ask(&mut engine, &request);
    assert_eq!((drawn.said["height"].as_u64(), drawn.said["width"].as_u64()), (Some(40), Some(48)));
    let reference: &[[u8; 4]] = drawn.bytes[4 * 40 * 48..].as_chunks().0;
    for (col, expected) in [(10, white), (40, color)] {
        let found = reference[20 * 48 + col];
        assert!(found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 4), "{found:?} {expected:?}");
    }
    let mut refused = |size, rgba: &[u8]| engine.photograph("mine", size, rgba).unwrap_err().to_string();
    assert!(refused([40, 47], &rgba).contains("40 × 47"));
    assert!(refused([8, 240], &rgba).contains("32"));
    assert!(refused([usize::MAX, 2], &rgba).contains("at most"));
    assert!(refused([40, 48], &vec![0; 4 * 40 * 48]).contains("black"));
}

/// The light behind another lens is that which the server gathers for a camera with it; designs of both lenses are drawn in turn.
#[test]
fn another_lens_has_light_of_its_own() {
    let mut engine = engine();
    let design = json!(files().camera);
    let mut other = files().camera.clone();
    other.optics.f_number = 2.0;
    other.sensor.pixel.pitch_um = 1.4;
    let setup = LiveSetup::new(&other, Illuminant::D65, studio::learning());
    let light =
        |engine: &mut Engine, of: Value| ask(engine, &json!({"light": {"design": other, "of": of}})).bytes;
    let path = Path::new("test");
    let training = light(&mut engine, json!("training"));
    assert!(training == studio::training_to_bytes(&studio::training_light(&setup).unwrap(), path).unwrap());
    let scene = light(&mut engine, json!({"scene": "colorchecker"}));
    let expected = studio::scene_light(&setup, "colorchecker", None).unwrap();
    assert!(scene == studio::scene_to_bytes(&expected, path).unwrap());
    let draw = |engine: &mut Engine, design: &Value, lens: &str, scene: &str| {
        let request =
            json!({"draw": {"design": design, "lens": lens, "scene": scene, "luminance_cd_m2": 5.0}});
        engine.ask(request.to_string().as_bytes()).map_err(|e| e.to_string())
    };
    let name = files().scene.name.clone();
    let first = draw(&mut engine, &design, "", &name).unwrap();
    let missing = draw(&mut engine, &json!(other), "f/2", "colorchecker").unwrap_err();
    assert!(missing.contains("the light of this lens"), "{missing}");
    engine.load("f/2", StudioFile::Training, &training).unwrap();
    engine.load("f/2", StudioFile::Scene, &scene).unwrap();
    draw(&mut engine, &json!(other), "f/2", "colorchecker").unwrap();
    assert!(draw(&mut engine, &json!(other), "", &name).unwrap_err().contains("pitch_um"));
    assert_eq!(draw(&mut engine, &design, "", &name).unwrap(), first);
    // The figures of the array alone need no light.
    let array =
        ask(&mut engine, &json!({"scores": {"design": other, "lens": "f/2", "luminances_cd_m2": []}})).said;
    assert!(array["array"]["vora_value"].as_f64().unwrap() > 0.5 && array["expected"] == json!([]));
    ask(&mut engine, &json!({"forget": {"lens": "f/2"}}));
    assert!(draw(&mut engine, &json!(other), "f/2", "colorchecker").is_err());
    let wrong =
        |engine: &mut Engine, of: Value| refused(engine, &json!({"light": {"design": other, "of": of}}));
    assert!(wrong(&mut engine, json!({"scene": "none"})).contains("no scene 'none'"));
    assert!(wrong(&mut engine, json!({"scene": "brushes"})).contains("source"));
    assert!(wrong(&mut engine, json!("statistics")).contains("training-clutter-1"));
    engine.source("brushes", b"no photograph".to_vec());
    assert!(wrong(&mut engine, json!({"scene": "brushes"})).contains("photo-brushes"));
    let mut impossible = other.clone();
    impossible.optics.f_number = -2.0;
    assert!(
        refused(&mut engine, &json!({"light": {"design": impossible, "of": "training"}}))
            .contains("f_number")
    );
}
