//! The command gives the figures of the library's experiments, to the last bit: it composes nothing of its own.
//! `crates/smalti-py/tests/test_command.py` shows the same of the Python package.

use serde::Serialize;
use serde_json::Value;
use smalti::camera::{Camera, EvaluationSettings, ScoreSettings, TestScene, TrainingSettings};
use smalti::experiment::{
    ComparisonSettings, Contender, ExperimentError, ExposurePolicy, Learned, NamedScene, Processing,
    Resources, Silent, SimulationSettings, TrainingSources, compare, learn, simulate,
};
use smalti::isp::Demosaic;
use smalti::l3::{Textures, Training};
use smalti::sensor::NoiseMode;
use smalti::spectrum::Illuminant;
use smalti_io::rendered::BuiltInTrainingScenes;
use smalti_io::{Override, SceneRequest, cameras, l3, scenes};

use crate::Place;

const SIZE: [&str; 2] = ["sensor.rows=64", "sensor.cols=96"];
const SET: &str = "--set sensor.rows=64 --set sensor.cols=96";
const LEAVES: &str = "dead-leaves?rows=64&cols=96&largest=40";
const MACBETH: &str = "macbeth?patch=12";

fn camera(name: &str) -> Camera {
    let overrides: Vec<Override> = SIZE.map(|o| o.parse().unwrap()).into();
    cameras::load(name, &overrides, None).unwrap()
}

/// A value as it comes out of a file of the command.
fn as_read(value: &impl Serialize) -> Value {
    serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
}

#[test]
fn evaluate_gives_what_the_library_gives() {
    let found = Place::new().document(&format!("evaluate rgbw --luminance 20 --seed 3 --json {SET}"));
    let settings = EvaluationSettings { luminance_cd_m2: 20.0, seed: 3, ..EvaluationSettings::default() };
    let rgbw = camera("rgbw");
    let (scores, _) =
        Contender::as_described(&rgbw, "rgbw").evaluate(&settings, Resources::default()).unwrap();
    let own = as_read(&scores);
    let own = own.as_object().unwrap();
    assert!(own.len() > 10);
    own.iter().for_each(|(key, value)| assert_eq!(&found["cameras"][0][key], value, "{key}"));
}

#[test]
fn compare_gives_what_the_library_gives() {
    let words = format!(
        "compare bayer rgbw --processing bilinear --scene {LEAVES} --scene {MACBETH} --luminance 1,20 -o o --json {SET}"
    );
    let found = Place::new().document(&words);
    let cameras = [camera("bayer"), camera("rgbw")];
    let processing = Processing::Classic(Demosaic::Bilinear);
    let contender = |camera, label| Contender { camera, label, processing, pipelines: None };
    let contenders = [contender(&cameras[0], "bayer"), contender(&cameras[1], "rgbw")];
    let settings = ComparisonSettings {
        luminances_cd_m2: vec![1.0, 20.0],
        illuminant: Illuminant::D65,
        scenes: [LEAVES, MACBETH].map(TestScene::built_in).into(),
        seed_count: 3,
        seed: 1,
        score: ScoreSettings::default(),
        exposure: ExposurePolicy::default(),
    };
    let outcomes = compare(&contenders, &settings, Resources::default()).unwrap().outcomes;
    let mut entries = found["results"].as_array().unwrap().iter();
    for outcome in outcomes.iter().flatten() {
        let entry = entries.next().unwrap();
        assert_eq!(entry["targets"], as_read(&outcome.targets));
        for (i, (name, scores)) in outcome.scenes.iter().enumerate() {
            assert_eq!(entry["scenes"][i]["scene"], name.as_str());
            assert_eq!(entry["scenes"][i]["scores"], as_read(&scores.scores), "{name}");
        }
    }
    assert!(entries.next().is_none());
}

/// One rule for both: pictures are scored with the same share of highlights, and what differs is the size on the sensor alone.
#[test]
fn simulate_gives_what_the_library_gives_and_scores_as_compare_does() {
    let found =
        Place::new().document(&format!("simulate bayer --scene {MACBETH} --luminance 30 -o o --json {SET}"));
    let mut bayer = camera("bayer");
    let request = SceneRequest { luminance_cd_m2: Some(30.0), ..SceneRequest::default() };
    let scene = bayer.fitted(scenes::load(MACBETH, &request).unwrap(), false).unwrap();
    bayer.sensor.window = Some(bayer.window_on(&scene).unwrap());
    let settings = SimulationSettings { noise: NoiseMode::All, seed: 1, score: ScoreSettings::default() };
    let simulation = simulate((&bayer, None), scene, &settings, &Silent, None).unwrap();
    let scores = as_read(&simulation.score.unwrap().scores);
    for key in ["cpsnr_db", "pixel_delta_e_2000_mean", "pixel_delta_e_2000_p95", "scielab_mean"] {
        assert!(scores[key].is_number());
        assert_eq!(found["picture"][key], scores[key], "{key}");
    }
    assert_eq!(found["picture"]["highlight_share"], ScoreSettings::default().highlight_share);
    assert_eq!(found["exposure_time_s"], as_read(&simulation.photograph.exposure.time_s));
}

#[test]
fn train_learns_what_the_library_learns() {
    let place = Place::new();
    place.ok(&format!(
        "train bayer --scene {LEAVES} --scene {MACBETH} --patch 3 --levels 3 --textures none --seed 5 -o a.l3 {SET}"
    ));
    let learned = l3::read_table(&place.path("a.l3")).unwrap();
    let bayer = camera("bayer");
    let settings =
        TrainingSettings { side: 3, levels: 3, textures: Textures::None, seed: 5, ..Default::default() };
    let named = |name: &str| {
        let request = SceneRequest { grid: Some(bayer.grid()), ..SceneRequest::default() };
        let scene = scenes::load(name, &request).unwrap();
        NamedScene::for_camera(&bayer, name.into(), scene, false, false).unwrap()
    };
    let sources = TrainingSources::<ExperimentError> {
        scenes: Some(vec![named(LEAVES), named(MACBETH)]),
        illuminants: Vec::new(),
        stored_scenes: &BuiltInTrainingScenes,
        pairs: Vec::new(),
        saved: Vec::new(),
    };
    let Learned { statistics, pipeline: own, .. } =
        learn(&bayer, &settings, &Training::default(), &sources, &Silent, None).unwrap();
    assert_eq!(learned.kernels(), own.kernels());
    assert_eq!(learned.provenance(), own.provenance());
    // Provenance is structured.
    let provenance = serde_json::from_str::<Value>(learned.provenance()).unwrap();
    assert_eq!(provenance["settings"]["side"], 3);
    assert_eq!(provenance["settings"]["textures"], "none");
    assert_eq!(provenance["scenes"], serde_json::json!([LEAVES, MACBETH]));
    assert_eq!(provenance["camera"]["name"], "bayer");
    assert_eq!(provenance["patches"], statistics.count());
}
