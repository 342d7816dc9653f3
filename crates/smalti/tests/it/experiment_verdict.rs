//! The verdict of a comparison: ties, leads, their worth in light, crossovers, and scenes in their own light.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use smalti::camera::{Camera, CameraDescription, PICTURE_METRICS, ScoreSettings, TestScene};
use smalti::experiment::{
    Compared, ComparisonSettings, Contender, ExposurePolicy, MoreLight, Outcome, Resources, Silent, compare,
    light_gains_to_first, scene_lights,
};
use smalti::scene::{Setting, catalog};
use smalti::spectrum::{Illuminant, WavelengthGrid};

use crate::common::coarse_grid;

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
    Camera::new(description, coarse_grid()).unwrap()
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

/// Scenes of one kind.
fn alike(count: usize) -> Vec<TestScene> {
    let scene = |seed: usize| format!("dead-leaves?rows=96&cols=128&least=2&largest=60&seed={}", 1001 + seed);
    (0..count).map(|seed| TestScene::BuiltIn(scene(seed))).collect()
}

fn compared(cameras: &[Camera], settings: &ComparisonSettings) -> Compared {
    let labels = ["a", "b", "c"];
    let contenders: Vec<Contender<'_>> =
        labels.iter().zip(cameras).map(|(label, c)| Contender::as_described(c, label)).collect();
    compare(&contenders, settings, Resources::default()).unwrap()
}

/// More contenders than are scored at a time, and of several lenses, so that not all share an optical image.
#[test]
fn the_number_of_threads_changes_no_score() {
    let of = |i: u32| camera(|d| d.optics.f_number = [2.8, 4.0, 5.6][i as usize % 3]);
    let cameras: Vec<Camera> = (0..6).map(of).collect();
    let labels: Vec<String> = (0..6).map(|i| i.to_string()).collect();
    let contenders: Vec<Contender<'_>> =
        labels.iter().zip(&cameras).map(|(label, c)| Contender::as_described(c, label)).collect();
    let figures = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = settings(&[2.0, 80.0], 2);
        let compared = pool.install(|| compare(&contenders, &settings, Resources::default())).unwrap();
        let of = |outcome: &Outcome| {
            let scenes = outcome.scenes.iter().map(|(name, scored)| (name.clone(), scored.by_seed.clone()));
            scenes.collect::<Vec<_>>()
        };
        compared.outcomes.iter().flatten().map(of).collect::<Vec<_>>()
    };
    let one = figures(1);
    assert_eq!(one, figures(4));
    // Contender by contender: 0 and 3 are the same camera, 0 and 1 are not.
    assert_eq!(one[..2], one[6..8]);
    assert_ne!(one[..2], one[2..4]);
}

#[test]
fn a_camera_ties_with_itself() {
    let cameras = [camera(|_| {}), camera(|_| {})];
    let verdict = compared(&cameras, &settings(&[10.0], 2)).verdict;
    assert_eq!((verdict.scenes, verdict.seeds), (4, 2));
    for metric in &verdict.lights[0].metrics {
        assert_eq!(metric.best, 0);
        assert!(metric.leads.iter().all(|l| l.is_tie() && l.by.value == 0.0 && l.light.is_none()));
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
    assert!(!lead.is_tie());
    let means = compared.outcomes.iter().map(|o| o[0].means()[0]).collect::<Vec<_>>();
    assert!((lead.by.value - (means[1] - means[0])).abs() < 1e-9);
    let Some(MoreLight::Stops(stops)) = lead.light else { panic!("{:?}", lead.light) };
    // The dark current is that of twice the time.
    assert!((stops.value - 1.0).abs() < 0.05, "{stops:?}");
    let interval = stops.interval.unwrap();
    assert!(interval.low > 0.0 && interval.low < stops.value, "{stops:?}");
    assert!(interval.high.is_some_and(|high| stops.value < high && high < 1.5), "{stops:?}");
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
    let of = |luminances_cd_m2: &[f64]| {
        let settings = ComparisonSettings { scenes: alike(6), ..settings(luminances_cd_m2, 2) };
        let verdict = compared(&[dark.clone(), bright.clone()], &settings).verdict;
        let found = verdict.crossovers.iter().find(|c| c.metric == PICTURE_METRICS[0]).cloned();
        (verdict, found.unwrap())
    };
    let (verdict, crossover) = of(&[100.0, 1.0]);
    let best: Vec<usize> = verdict.lights.iter().map(|l| l.metrics[0].best).collect();
    assert_eq!(best, [1, 0], "{verdict:?}");
    assert_eq!((crossover.below, crossover.above, crossover.between_cd_m2), (0, 1, [1.0, 100.0]));
    assert!(crossover.is_of_best);
    let at = crossover.interpolated_cd_m2;
    assert!(1.0 < at && at < 100.0, "{at}");
    // A luminance near the crossover, at which the cameras tie, does not hide it.
    let (mut low, mut high) = (1.0f64, 100.0f64);
    for _ in 0..10 {
        let middle = (low * high).sqrt();
        let (verdict, crossover) = of(&[1.0, middle, 100.0]);
        assert_eq!((crossover.below, crossover.above), (0, 1));
        let cpsnr = &verdict.lights[1].metrics[0];
        if cpsnr.leads.iter().all(|l| l.is_tie()) {
            assert_eq!(crossover.between_cd_m2, [1.0, 100.0]);
            return;
        }
        *(if cpsnr.best == 0 { &mut low } else { &mut high }) = middle;
    }
    panic!("no luminance with a tie from {low} to {high} cd/m²");
}

/// A camera whose quality is limited by its pixels, and not by light, does not reach another one with more light.
#[test]
fn light_does_not_replace_equal_pixels() {
    let uneven = camera(|d| d.sensor.prnu_percent = 8.0);
    let settings = ComparisonSettings { scenes: alike(6), ..settings(&[100.0], 2) };
    let compared = compared(&[uneven, camera(|_| {})], &settings);
    let lead = &compared.verdict.lights[0].metrics[0].leads[0];
    assert!(!lead.is_tie());
    assert!(matches!(lead.light, Some(MoreLight::Unreachable { .. })), "{:?}", lead.light);
}

/// The scores of the light gain at equal light are those of the comparison, the means over its seeds.
#[test]
fn the_light_gain_speaks_of_the_pictures_of_the_table() {
    let cameras = [camera(|_| {}), camera(|d| d.exposure.time_ms = Some(60.0))];
    let contenders =
        [("a", &cameras[0]), ("b", &cameras[1])].map(|(label, c)| Contender::as_described(c, label));
    let mut settings = settings(&[2.0], 3);
    settings.scenes.truncate(2);
    let compared = compare(&contenders, &settings, Resources::default()).unwrap();
    let gains = light_gains_to_first(&contenders, &settings, &compared.exposure, &Silent).unwrap();
    let [own, target] = [0, 1].map(|i: usize| compared.outcomes[i][0].means());
    for (i, gain) in gains[0].gains.metrics.iter().take(PICTURE_METRICS.len()).enumerate() {
        assert_eq!(gain.metric, PICTURE_METRICS[i]);
        assert!((gain.own - own[i]).abs() < 1e-9 && (gain.target - target[i]).abs() < 1e-9, "{gain:?}");
    }
    // So do visual SNR and noise, of the captures of the chart.
    let of_chart: [fn(&Outcome) -> f64; 2] =
        [|o| o.targets.visual_snr.median, |o| o.targets.luminance_noise_percent.mean];
    for (gain, of) in gains[0].gains.metrics.iter().skip(PICTURE_METRICS.len()).zip(of_chart) {
        let [own, target] = [0, 1].map(|i: usize| of(&compared.outcomes[i][0]));
        assert!((gain.own / own - 1.0).abs() < 1e-9 && (gain.target / target - 1.0).abs() < 1e-9, "{gain:?}");
    }
}

#[test]
fn one_picture_has_no_interval() {
    let cameras = [camera(|_| {}), camera(|d| d.exposure.time_ms = Some(60.0))];
    let mut settings = settings(&[2.0], 1);
    settings.scenes.truncate(1);
    let verdict = compared(&cameras, &settings).verdict;
    let lead = &verdict.lights[0].metrics[0].leads[0];
    // A lead by a relevant amount, without certainty.
    assert_eq!((lead.by.interval, lead.is_tie(), lead.light), (None, false, None));
}

/// A scene that keeps its light is scored as under that illuminant.
#[test]
fn a_scene_in_its_own_light_is_scored_in_that_light() {
    let cameras = [camera(|_| {})];
    let setting = Setting {
        illuminant: Illuminant::A,
        luminance_cd_m2: 1.0,
        grid: coarse_grid(),
        ..Setting::default()
    };
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
