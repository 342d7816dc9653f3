//! The verdict of a comparison: ties, leads, their worth in light, crossovers, and scenes in their own light.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use smalti::camera::{Camera, CameraDescription, PICTURE_METRICS, ScoreSettings, TestScene};
use smalti::experiment::{
    Compared, ComparisonSettings, Contender, ExposurePolicy, MoreLight, Resources, compare, scene_lights,
};
use smalti::scene::{Setting, catalog};
use smalti::spectrum::{Illuminant, WavelengthGrid};

const LEAVES: [&str; 4] = [
    "dead-leaves?rows=96&cols=128&least=2&largest=60&seed=1001",
    "dead-leaves?rows=96&cols=128&least=4&largest=90&seed=1002",
    "dead-leaves?rows=96&cols=128&least=1&largest=30&seed=1003",
    "macbeth?patch=24",
];

fn camera(change: impl Fn(&mut CameraDescription)) -> Camera {
    let mut description = CameraDescription::default();
    description.exposure.time_ms = Some(30.0);
    change(&mut description);
    Camera::new(description, WavelengthGrid::VISIBLE).unwrap()
}

fn settings(luminances_cd_m2: &[f64], seed_count: u64) -> ComparisonSettings {
    ComparisonSettings {
        luminances_cd_m2: luminances_cd_m2.to_vec(),
        illuminant: Illuminant::D65,
        scenes: LEAVES.map(TestScene::built_in).into(),
        seed: 1,
        seed_count,
        score: ScoreSettings::default(),
        exposure: ExposurePolicy::Own,
    }
}

fn compared(cameras: &[Camera], settings: &ComparisonSettings) -> Compared {
    let labels = ["a", "b", "c"];
    let contenders: Vec<Contender<'_>> =
        labels.iter().zip(cameras).map(|(label, c)| Contender::as_described(c, label)).collect();
    compare(&contenders, settings, Resources::default()).unwrap()
}

#[test]
fn a_camera_ties_with_itself() {
    let cameras = [camera(|_| {}), camera(|_| {})];
    let verdict = compared(&cameras, &settings(&[10.0], 2)).verdict;
    assert_eq!((verdict.scenes, verdict.seeds), (4, 2));
    for metric in &verdict.lights[0].metrics {
        assert_eq!(metric.best, 0);
        assert!(
            metric.leads.iter().all(|l| l.is_tie() == Some(true) && l.by.value == 0.0 && l.light.is_none())
        );
        assert!(metric.is_among_best(1));
    }
    assert!(verdict.crossovers.is_empty());
}

/// A camera that is like another with twice the exposure time leads by one stop of light where noise dominates, and the lead is
/// certain.
#[test]
fn twice_the_time_is_worth_a_stop() {
    let cameras = [camera(|_| {}), camera(|d| d.exposure.time_ms = Some(60.0))];
    let compared = compared(&cameras, &settings(&[2.0], 2));
    let cpsnr = &compared.verdict.lights[0].metrics[0];
    assert_eq!((cpsnr.metric, cpsnr.best), (PICTURE_METRICS[0], 1));
    let lead = &cpsnr.leads[0];
    assert_eq!(lead.is_tie(), Some(false));
    let means = compared.outcomes.iter().map(|o| o[0].means()[0]).collect::<Vec<_>>();
    assert!((lead.by.value - (means[1] - means[0])).abs() < 1e-9);
    let Some(MoreLight::Stops(stops)) = lead.light else { panic!("{:?}", lead.light) };
    // The dark current is that of twice the time.
    assert!((stops.value - 1.0).abs() < 0.05, "{stops:?}");
    assert!(stops.interval.unwrap().contains(stops.value));
}

/// A camera of little read noise wins in the dark, and one whose pixels are equally sensitive in the light.
#[test]
fn the_crossover_lies_between_the_luminances_where_the_lead_changes() {
    let dark = camera(|d| {
        d.sensor.pixel.read_noise_mv = 0.1;
        d.sensor.prnu_percent = 6.0;
    });
    let bright = camera(|d| {
        d.sensor.pixel.read_noise_mv = 6.0;
        d.sensor.prnu_percent = 0.0;
    });
    let verdict = compared(&[dark, bright], &settings(&[100.0, 1.0], 2)).verdict;
    let best: Vec<usize> = verdict.lights.iter().map(|l| l.metrics[0].best).collect();
    assert_eq!(best, [1, 0], "{verdict:?}");
    let crossover = verdict.crossovers.iter().find(|c| c.metric == PICTURE_METRICS[0]).unwrap();
    assert_eq!((crossover.below, crossover.above, crossover.between_cd_m2), (0, 1, [1.0, 100.0]));
    let at = crossover.luminance_cd_m2;
    assert!(1.0 < at.value && at.value < 100.0 && at.interval.unwrap().contains(at.value), "{at:?}");
}

#[test]
fn one_picture_has_no_interval() {
    let cameras = [camera(|_| {}), camera(|d| d.exposure.time_ms = Some(60.0))];
    let mut settings = settings(&[2.0], 1);
    settings.scenes.truncate(1);
    let verdict = compared(&cameras, &settings).verdict;
    let lead = &verdict.lights[0].metrics[0].leads[0];
    assert_eq!((lead.by.interval, lead.is_tie(), lead.light), (None, None, None));
}

/// A scene that keeps its light is scored as under that illuminant.
#[test]
fn a_scene_in_its_own_light_is_scored_in_that_light() {
    let cameras = [camera(|_| {})];
    let setting = Setting { illuminant: Illuminant::A, luminance_cd_m2: 1.0, ..Setting::default() };
    let kept = TestScene::in_own_light("kept", catalog::build_natural(LEAVES[0], &setting).unwrap()).unwrap();
    let of = |scene: TestScene, illuminant: Illuminant| {
        let settings = ComparisonSettings { scenes: vec![scene], illuminant, ..settings(&[20.0], 1) };
        compared(&cameras, &settings).outcomes[0][0].means()
    };
    let (own, under_a) = (of(kept, Illuminant::D65), of(TestScene::built_in(LEAVES[0]), Illuminant::A));
    for (own, under_a) in own.iter().zip(under_a) {
        assert!((own / under_a - 1.0).abs() < 1e-4, "{own} and {under_a}");
    }
}

#[test]
fn scenes_in_one_light_share_it() {
    let scene = |name: &str, illuminant: Illuminant| {
        let setting = Setting { illuminant, ..Setting::default() };
        TestScene::in_own_light(name, catalog::build_natural("macbeth?patch=4", &setting).unwrap()).unwrap()
    };
    let scenes = [
        TestScene::built_in("macbeth"),
        scene("noon", Illuminant::D65),
        scene("lamp", Illuminant::A),
        scene("other lamp", Illuminant::A),
        scene("led", Illuminant::Led),
    ];
    let lights = scene_lights(&Illuminant::D65, &scenes).unwrap();
    let names: Vec<String> = lights.iter().map(|l| l.illuminant.name()).collect();
    // The second is that of scenes on these wavelengths, which cameras on others learn for.
    assert_eq!(names, ["D65", "D65", "lamp", "led"]);
    assert_eq!(lights[0].grid, None);
    assert!(lights[1..].iter().all(|l| l.grid == Some(WavelengthGrid::VISIBLE)));
}
