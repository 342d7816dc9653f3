//! What a design depends on and what limits it, and its proof.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use smalti::camera::{Camera, CameraDescription, ScoreSettings, TestScene, TrainingSettings};
use smalti::design::Deviation;
use smalti::design::light::{LightClasses, LightSettings, LightStatistics};
use smalti::design::screen::{Screen, ScreenCondition, ScreenTime};
use smalti::experiment::{
    ComparisonSettings, Entrant, ExperimentError, ExposurePolicy, Finding, Progress, ProofResult, Resources,
    analyse_design, light_statistics, prove, score_entrants, tolerances,
};
use smalti::l3::Training;
use smalti::scene::{Scene, Setting, catalog};
use smalti::sensor::{Cfa, Channel, Mosaic};
use smalti::spectrum::{Illuminant, Spectrum};

use crate::common::coarse_grid;

fn camera() -> Camera {
    let mut d = CameraDescription::default();
    (d.sensor.pixel.pitch_um, d.exposure.time_ms) = (2.2, Some(50.0));
    Camera::new(d, coarse_grid()).unwrap()
}

fn statistics(camera: &Camera) -> LightStatistics {
    let setting = Setting { grid: coarse_grid(), ..Setting::default() };
    let reflectances: Vec<Spectrum> =
        smalti::spectrum::reflectance::natural(coarse_grid()).unwrap().into_iter().map(|(_, s)| s).collect();
    let spec = "dead-leaves?rows=240&cols=240&seed=5&least=2&largest=60";
    let scene: Scene = catalog::build(spec, &setting, &reflectances).unwrap();
    let deg = camera.field_of_view_deg(120, setting.distance_m).unwrap();
    let settings = LightSettings {
        side: 3,
        max_components: 6,
        classes: LightClasses { luminance_cuts: vec![0.8], ..LightClasses::default() },
        ..LightSettings::default()
    };
    let scenes = [scene.with_fov(deg).unwrap()];
    light_statistics(camera, &Illuminant::D65, Some(&scenes), &settings, Resources::default()).unwrap()
}

fn conditions() -> [ScreenCondition; 2] {
    [1.0, 80.0].map(|luminance_cd_m2| ScreenCondition { luminance_cd_m2, time: ScreenTime::Fixed(0.05) })
}

fn squared_error(cpsnr_db: f64) -> f64 {
    libm::pow(10.0, -0.1 * cpsnr_db)
}

#[test]
fn sensitivities_are_those_of_arrays_that_deviate() {
    let camera = camera();
    let statistics = statistics(&camera);
    let cfa = camera.sensor.cfa.clone();
    let analysis = analyse_design(&camera, &statistics, &conditions(), 0.95, &cfa).unwrap();
    let screen = Screen::new(&camera, &statistics, &conditions()).unwrap();
    assert_eq!(analysis.expected, screen.expected(&cfa).unwrap());
    assert_eq!(analysis.sensitivities.len(), 4 * (cfa.channels().len() + 1));
    for s in &analysis.sensitivities {
        let channel = |c: &Channel| match &s.filter {
            Some(name) if *name != c.name => c.clone(),
            _ => Channel { transmittance: s.deviation.of(&c.transmittance, 0.95).unwrap(), ..c.clone() },
        };
        let deviating =
            Cfa::new("deviating", cfa.mosaic().clone(), cfa.channels().iter().map(channel).collect())
                .unwrap();
        for (direct, found) in screen.expected(&deviating).unwrap().iter().zip(&s.expected) {
            assert!((direct.cpsnr_db - found.cpsnr_db).abs() < 1e-9, "{s:?}");
            assert!((direct.delta_e_2000 - found.delta_e_2000).abs() < 1e-9, "{s:?}");
        }
        if s.filter.is_none() {
            let whole = s.deviation.of_camera(&camera, 0.95).unwrap();
            assert_eq!(whole.sensor.cfa.channels()[0].transmittance, deviating.channels()[0].transmittance);
        }
    }
}

#[test]
fn causes_add_up_to_the_whole_error() {
    let camera = camera();
    let statistics = statistics(&camera);
    let analysis = analyse_design(&camera, &statistics, &conditions(), 1.0, &camera.sensor.cfa).unwrap();
    assert_eq!(analysis.classes.len(), 4);
    for (limits, expected) in analysis.limits.iter().zip(&analysis.expected) {
        let patches: f64 = limits.iter().map(|c| c.patches).sum();
        assert!((patches - 1.0).abs() < 1e-12);
        let squares: f64 = limits.iter().map(|c| c.patches * c.total().squared_error).sum();
        assert!((squares / squared_error(expected.cpsnr_db) - 1.0).abs() < 1e-9);
        let delta_e: f64 = limits.iter().map(|c| c.patches * c.total().delta_e_2000).sum();
        assert!((delta_e - expected.delta_e_2000).abs() < 1e-9);
        for class in limits {
            let total = class.total().squared_error;
            for part in [class.noise, class.sampling, class.color] {
                assert!(part.squared_error > -1e-9 * total, "{class:?}");
            }
        }
    }
    // Noise matters more in the dark; sampling and colour do not depend on the light.
    let [dark, bright] = [0, 1].map(|light: usize| analysis.limits[light][0]);
    assert!(dark.noise.squared_error > 5.0 * bright.noise.squared_error, "{dark:?} {bright:?}");
    assert!((dark.sampling.squared_error / bright.sampling.squared_error - 1.0).abs() < 1e-6);
    assert!((dark.color.squared_error / bright.color.squared_error - 1.0).abs() < 1e-6);
    assert!(dark.sampling.squared_error > 0.0 && dark.color.squared_error > 0.0);
}

/// A mosaic of one filter samples it everywhere, and its error is the limit of that filter.
#[test]
fn a_single_filter_loses_nothing_by_sampling() {
    let camera = camera();
    let statistics = statistics(&camera);
    let green = camera.sensor.cfa.channels()[1].clone();
    let one = Cfa::new("one", Mosaic::new(1, 1, vec![0]).unwrap(), vec![green]).unwrap();
    let analysis = analyse_design(&camera, &statistics, &conditions(), 1.0, &one).unwrap();
    for class in analysis.limits.iter().flatten() {
        let total = class.total().squared_error;
        assert!(class.sampling.squared_error.abs() < 1e-6 * total, "{class:?}");
        assert!(class.color.squared_error > 0.0);
    }
}

/// A camera against itself and against one of half the light.
#[test]
fn a_proof_tells_an_equal_camera_from_a_worse_one() {
    let camera = camera();
    let mut dim = camera.description().clone();
    dim.exposure.time_ms = Some(12.5);
    let dim = Camera::new(dim, camera.grid()).unwrap();
    let spec = |seed: u32| {
        TestScene::built_in(&format!("dead-leaves?rows=96&cols=96&least=2&largest=40&seed={seed}"))
    };
    let settings = ComparisonSettings {
        luminances_cd_m2: vec![5.0],
        illuminant: Illuminant::D65,
        scenes: (2001..2006).map(spec).collect(),
        seed: 1,
        seed_count: 2,
        score: ScoreSettings::default(),
        exposure: ExposurePolicy::Own,
    };
    let learning = TrainingSettings { side: 3, exposures: vec![1.0, 0.25], ..TrainingSettings::default() };
    let found = Entrant::new("found", camera.clone());
    let rivals = [Entrant::new("same", camera.clone()), Entrant::new("dim", dim)];
    let proof =
        prove(&found, &rivals, &settings, (&learning, &Training::default()), Resources::default()).unwrap();
    let [same, dim] = &proof.rivals[..] else { panic!("{proof:?}") };
    for lead in &same.leads[0] {
        assert_eq!((lead.by.value, lead.finding), (0.0, Finding::NoDifference));
    }
    for lead in &dim.leads[0][..2] {
        let (alone, together) = (lead.by.interval.unwrap(), lead.simultaneous.unwrap());
        assert!(together.low < alone.low && alone.low > 0.0, "{lead:?}");
        assert_eq!(lead.result(), ProofResult::Wins, "{lead:?}");
    }
    assert!(!proof.beats_all());
    assert_eq!(proof.with_result(0, 0, ProofResult::Ties).len(), 1);
    // A deviation of nothing, with the pipeline of the design, has the scores of the design.
    let unchanged = Deviation::NONE.of_camera(&camera, 1.0).unwrap();
    let tuned = Entrant { label: "tuned".into(), camera: unchanged, learned_for: Some(camera) };
    let again =
        prove(&tuned, &rivals[..1], &settings, (&learning, &Training::default()), Resources::default())
            .unwrap();
    assert_eq!(again.found.means, proof.found.means);
}

/// A sweep over deviations has the scores that a proof has for each of them, and is stopped like any other work.
#[test]
fn tolerances_are_those_of_cameras_that_deviate() {
    let camera = camera();
    let scene = |seed: u32| {
        TestScene::built_in(&format!("dead-leaves?rows=96&cols=96&least=2&largest=40&seed={seed}"))
    };
    let settings = ComparisonSettings {
        luminances_cd_m2: vec![5.0, 50.0],
        illuminant: Illuminant::D65,
        scenes: (2001..2006).map(scene).collect(),
        seed: 1,
        seed_count: 1,
        score: ScoreSettings::default(),
        exposure: ExposurePolicy::Own,
    };
    let learning = TrainingSettings { side: 3, exposures: vec![1.0, 0.25], ..TrainingSettings::default() };
    let learning = (&learning, &Training::default());
    let rows = tolerances((&camera, "swept"), 0.95, &settings, learning, Resources::default()).unwrap();
    assert_eq!(rows.len(), 5 * 2);
    let entrants: Vec<Entrant> = rows
        .iter()
        .step_by(2)
        .map(|row| Entrant {
            label: row.name.clone(),
            camera: row.deviation.of_camera(&camera, 0.95).unwrap(),
            learned_for: Some(camera.clone()),
        })
        .collect();
    let scored = score_entrants(&entrants, &settings, learning, Resources::default()).unwrap();
    for (number, row) in rows.iter().enumerate() {
        let light = &scored[number / 2].lights[number % 2];
        assert_eq!(row.luminance_cd_m2, settings.luminances_cd_m2[number % 2]);
        for (metric, values) in light.metrics.iter().enumerate() {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            assert_eq!(row.means[metric].value, mean, "{row:?}");
            // The scenes differ by more than a deviation changes, so that the interval of a mean is wider than that of a paired difference.
            let of_mean = row.means[metric].interval.unwrap();
            assert!(of_mean.low < mean && mean < of_mean.high, "{row:?}");
            let Some(changes) = &row.changes else { continue };
            let change = &changes[metric];
            assert!((change.value - (mean - rows[number % 2].means[metric].value)).abs() < 1e-9, "{row:?}");
            let interval = change.interval.unwrap();
            assert!(interval.low <= change.value && change.value <= interval.high, "{row:?}");
            assert!(interval.high - interval.low < of_mean.high - of_mean.low, "{row:?}");
        }
        assert_eq!(row.changes.is_none(), row.name == "as designed");
    }
    // A shift of the filters costs colour.
    assert!(rows.iter().any(|row| row.changes.as_ref().is_some_and(|c| c[1].interval.unwrap().low > 0.0)));
    struct Stopped;
    impl Progress for Stopped {
        fn is_stopped(&self) -> bool {
            true
        }
    }
    let stopped = Resources { progress: &Stopped, ..Resources::default() };
    let error = tolerances((&camera, "swept"), 0.95, &settings, learning, stopped).unwrap_err();
    assert!(matches!(error, ExperimentError::Stopped), "{error}");
}
