//! The module without a browser: what goes in as text and numbers gives the pictures of the library.
#![allow(clippy::unwrap_used)]

use smalti::camera::{Camera, CameraDescription, Setup};
use smalti::design::{Condition, Preview, PreviewLight, PreviewScene, Study, TrialProcessing, Trials};
use smalti::scene::Setting;
use smalti::sensor::NoiseMode;
use smalti::spectrum::{Illuminant, WavelengthGrid};
use smalti_wasm::StudyPictures;

const STUDY: &str = r#"{
    "name": "module", "seed": 5, "colors": [3], "filter_sets": 4, "mosaic_count": null,
    "filters": {"gaussian_grid": {"centers_nm": [430, 10, 660], "sigmas_nm": [20, 5, 55], "min_spacing_nm": 20}},
    "mosaics": {"given": [["bc", "ab"]]},
    "conditions": [], "processing": ["classic"], "metrics": [], "l3": {}
}"#;

fn study() -> Study {
    let condition = Condition {
        values: Vec::new(),
        luminance_cd_m2: 30.0,
        illuminant: Illuminant::D65,
        camera: CameraDescription::default(),
    };
    Study { conditions: vec![condition], ..serde_json::from_str(STUDY).unwrap() }
}

fn light() -> PreviewLight {
    let camera = Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap();
    let scene = "dead-leaves?rows=64&cols=96&seed=3";
    let setup = Setup::of_test_scene(&camera, scene, &Setting::default()).unwrap();
    PreviewLight { factor: 2.0, scenes: vec![PreviewScene::new(&setup, 6).unwrap()], training: None }
}

fn codes(light: &mut PreviewLight) -> Vec<u8> {
    let bytes = |codes: &[i32]| codes.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<_>>();
    light.planes_mut().flat_map(|p| bytes(&p.codes)).collect()
}

#[test]
fn text_and_numbers_give_the_pictures_of_the_library() {
    let (study, mut light) = (study(), light());
    let trials = Trials::new(study.clone()).unwrap();
    let preview = Preview::new(&study, 0, TrialProcessing::Classic, &light).unwrap();
    let mut studio = StudyPictures::default();
    let index = studio.study(&serde_json::to_vec(&study).unwrap()).unwrap();
    let text = serde_json::to_vec(&light).unwrap();
    studio.setup(index, 0, TrialProcessing::Classic, &text, &codes(&mut light)).unwrap();
    for number in [0, 3] {
        let design = preview.design(&trials.trial(number).unwrap().design).unwrap();
        for noise in [NoiseMode::None, NoiseMode::All] {
            let rgb = preview.picture(&design, 0, noise).unwrap().rgb8();
            let rgba = studio.draw(number, 0, noise).unwrap();
            assert_eq!(rgba.len(), 4 * 32 * 48);
            let expected: Vec<u8> = rgb.chunks(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
            assert!(rgba == expected);
        }
    }
}

#[test]
fn what_is_wrong_is_told() {
    let mut studio = StudyPictures::default();
    assert!(studio.draw(0, 0, NoiseMode::None).unwrap_err().to_string().contains("no setup"));
    assert!(studio.study(b"{}").unwrap_err().to_string().contains("missing field"));
    studio.study(&serde_json::to_vec(&study()).unwrap()).unwrap();
    let mut light = light();
    let (codes, text) = (codes(&mut light), serde_json::to_vec(&light).unwrap());
    let mut refused = |study, condition, text: &[u8], codes: &[u8]| {
        studio.setup(study, condition, TrialProcessing::Classic, text, codes).unwrap_err().to_string()
    };
    assert!(refused(1, 0, &text, &codes).contains("no study 1"));
    assert!(refused(0, 1, &text, &codes).contains("condition"));
    assert!(refused(0, 0, b"[", &codes).contains("cannot be read"));
    for wrong in [&codes[4..], &codes[1..], &[&codes[..], &[0; 4]].concat()] {
        assert!(refused(0, 0, &text, wrong).contains("more or fewer samples"));
    }
    studio.setup(0, 0, TrialProcessing::Classic, &text, &codes).unwrap();
    assert!(studio.draw(99, 0, NoiseMode::None).is_err() && studio.draw(0, 1, NoiseMode::None).is_err());
    assert!(studio.draw(0, 0, NoiseMode::None).is_ok());
}
