//! The engine of the studio without a browser: answers are those of the library, and no input makes it panic.
#![allow(clippy::unwrap_used)]

mod designs;
mod pictures;
mod warnings;

use std::path::Path;
use std::sync::OnceLock;

use serde_json::{Value, json};
use smalti::camera::{CameraDescription, TestScene};
use smalti::design::LearningSettings;
use smalti::design::light::LightStatistics;
use smalti::design::live::{LiveScene, LiveSetup, LiveTraining};
use smalti::experiment::{Resources, light_statistics};
use smalti::spectrum::Illuminant;
use smalti_io::{cameras, light, studio};
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
