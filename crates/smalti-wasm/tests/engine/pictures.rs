//! Pictures and their scores.

use std::path::Path;

use serde_json::{Value, json};
use smalti::camera::{Camera, CameraDescription, ColorimetricObserver};
use smalti::color::Image;
use smalti::design::live::{LiveEffort, LiveLearner, LivePicture, LivePictures, LiveSetup};
use smalti::design::screen::ScreenCondition;
use smalti::experiment::analyse_design;
use smalti::isp::Isp as _;
use smalti::sensor::NoiseMode;
use smalti::spectrum::{Illuminant, Observer, WavelengthGrid};
use smalti_io::{dng, l3, studio};
use smalti_wasm::{Answer, Engine, StudioFile};

use super::{Files, ask, engine, files, refused};

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
