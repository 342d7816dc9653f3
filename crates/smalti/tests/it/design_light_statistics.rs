//! Pipelines of designs from statistics of the light of the training scene, against those from patches.
#![allow(clippy::unwrap_used)]

use smalti::camera::{Camera, CameraDescription, CameraError, EvaluationSettings};
use smalti::design::{LearningSettings, LearningStatistics, Metric, PipelineTrainer, Scores, Targets};
use smalti::l3::{Pipeline, Solver, Textures};
use smalti::sensor::{Cfa, Mosaic};
use smalti::spectrum::WavelengthGrid;

use crate::design_targets::{SETS, cfa};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

/// The camera of "Resolution in Color Filter Array Images", with a change.
fn camera(change: impl FnOnce(&mut CameraDescription)) -> Camera {
    let mut d = CameraDescription::default();
    (d.sensor.adc_bits, d.sensor.pixel.pitch_um, d.sensor.pixel.fill_factor) = (0, 2.8, 0.5);
    change(&mut d);
    Camera::new(d, GRID).unwrap()
}

fn targets(camera: &Camera) -> Targets {
    Targets::new(camera, &EvaluationSettings::default(), &Metric::USUAL, &[], &|_, make| make()).unwrap()
}

fn trainer(camera: &Camera, settings: &LearningSettings) -> Result<PipelineTrainer, CameraError> {
    PipelineTrainer::new(&targets(camera), settings, &|_, make| make())
}

fn light() -> LearningSettings {
    LearningSettings {
        statistics: LearningStatistics::Light,
        size_px: 128,
        side: 5,
        ..LearningSettings::default()
    }
}

fn learned(camera: &Camera, settings: &LearningSettings, cfa: &Cfa) -> Pipeline {
    trainer(camera, settings).unwrap().pipeline(cfa).unwrap().0
}

fn score(trainer: &PipelineTrainer, targets: &Targets, cfa: &Cfa) -> Scores {
    let (pipeline, reach) = trainer.pipeline(cfa).unwrap();
    targets.score_with(cfa, &pipeline.renderer(), reach).unwrap()
}

/// With one channel and one class, both paths learn from the same patches. What remains are the components that leave out 0.1 % of the
/// light, and single precision.
#[test]
fn one_channel_has_the_kernels_of_its_patches() {
    // Half the exposure, so that nothing is clipped.
    let camera = camera(|d| d.exposure.auto_target = Some(0.5));
    let whole = cfa(SETS[0]);
    let mono = Cfa::new("one", Mosaic::new(1, 1, vec![0]).unwrap(), whole.channels()[1..2].to_vec()).unwrap();
    let one = LearningSettings { textures: Textures::None, levels: 1, ..light() };
    let patches = LearningSettings { statistics: LearningStatistics::Patches, ..one.clone() };
    let [a, b] = [patches, one].map(|settings| learned(&camera, &settings, &mono));
    let largest = a.kernels().weights.iter().fold(0.0f32, |m, w| m.max(w.abs()));
    for (x, y) in a.kernels().weights.iter().zip(&b.kernels().weights) {
        assert!((x - y).abs() < 2e-3 * largest, "{x} and {y}, largest {largest}");
    }
    for (x, y) in a.kernels().offsets.iter().zip(&b.kernels().offsets) {
        assert!((x - y).abs() < 1e-4, "{x} and {y}");
    }
    assert_eq!(a.classes()[0].count, b.classes()[0].count);
    assert_eq!((a.black_level(), a.white_level()), (b.black_level(), b.white_level()));
}

/// The scores of arrays of 3 to 7 filters. The paths differ by the classes of saturated colours, and a position learns from all pixels
/// instead of its own; on this small scene by several times more than on the default one, for which `just learned-statistics` states
/// the differences.
#[test]
fn scores_are_those_of_patches() {
    let camera = camera(|_| ());
    let targets = targets(&camera);
    let [patches, light] = [LearningStatistics::Patches, LearningStatistics::Light].map(|statistics| {
        trainer(&camera, &LearningSettings { statistics, size_px: 256, ..light() }).unwrap()
    });
    for set in SETS {
        let cfa = cfa(set);
        let [a, b] = [&patches, &light].map(|trainer| score(trainer, &targets, &cfa));
        for (metric, tolerance) in [
            (Metric::DeltaE76, 0.1),
            (Metric::DeltaE2000, 0.1),
            (Metric::Mtf50CyPerMm, 0.08),
            (Metric::LuminanceNoise, 0.1),
        ] {
            let [a, b] = [&a, &b].map(|s| s.value(metric, 0).unwrap());
            assert!((a / b - 1.0).abs() < tolerance, "{}: {a} and {b}", metric.name());
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let camera = camera(|_| ());
    let cfas = [SETS[0], SETS[4]].map(cfa);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (trainer, targets) = (trainer(&camera, &light()).unwrap(), targets(&camera));
            cfas.each_ref().map(|cfa| (trainer.pipeline(cfa).unwrap(), score(&trainer, &targets, cfa)))
        })
    };
    assert_eq!(with(1), with(3));
}

/// Statistics are shared by mosaics with the same translations and symmetries; which of them came first must not matter.
#[test]
fn the_order_of_designs_changes_no_bit() {
    let camera = camera(|_| ());
    let cfas = [SETS[2], SETS[3], SETS[4]].map(cfa);
    let alone = cfas.each_ref().map(|cfa| learned(&camera, &light(), cfa));
    let shared = trainer(&camera, &light()).unwrap();
    for (cfa, alone) in cfas.iter().zip(&alone).rev() {
        shared.prepare(cfa.mosaic()).unwrap();
        assert_eq!(shared.pipeline(cfa).unwrap().0, *alone);
    }
}

/// Kernels of symmetric positions are each other's reflections, as those of patches.
#[test]
fn symmetric_positions_have_symmetric_kernels() {
    let pipeline = learned(&camera(|_| ()), &light(), &cfa(SETS[0]));
    let (side, mosaic) = (pipeline.axes().side(), pipeline.axes().mosaic().clone());
    // The doubled channel lies on a diagonal, so that the other two have all symmetries of the square.
    let single = (0..4).find(|&p| mosaic.cells().iter().filter(|c| **c == mosaic.cells()[p]).count() == 1);
    let class = pipeline.index(single.unwrap(), 0, 2, 0);
    let weights = pipeline.weights(class, 1).unwrap();
    assert!(weights.iter().any(|w| w.abs() > 1e-3));
    for (tap, w) in weights.iter().enumerate() {
        let mirrored = weights[tap / side * side + side - 1 - tap % side];
        assert!((w - mirrored).abs() < 1e-5, "{w} and {mirrored}");
    }
}

#[test]
fn what_the_statistics_cannot_serve_is_refused() {
    let message = |camera: &Camera, settings: &LearningSettings| -> String {
        trainer(camera, settings).and_then(|t| t.pipeline(&cfa(SETS[0]))).unwrap_err().to_string()
    };
    let plain = camera(|_| ());
    let ridge = LearningSettings { solver: Solver::Ridge, ..light() };
    assert!(message(&plain, &ridge).contains("wiener"), "{}", message(&plain, &ridge));
    let fine = LearningSettings { levels: 65, ..light() };
    assert!(message(&plain, &fine).contains("64 levels"), "{}", message(&plain, &fine));
    let crosstalk = camera(|d| d.sensor.crosstalk_percent = 2.0);
    assert!(message(&crosstalk, &light()).contains("crosstalk"), "{}", message(&crosstalk, &light()));
    let bright = camera(|d| d.exposure.time_ms = Some(1000.0));
    let found = message(&bright, &light());
    assert!(found.contains("saturates the channel") && found.contains("patches"), "{found}");
    // Filters that pass nothing are the same error as for patches.
    let whole = cfa(SETS[0]);
    let dark = whole.channels().iter().map(|c| {
        let transmittance = c.transmittance.scaled(0.0).unwrap();
        smalti::sensor::Channel { transmittance, ..c.clone() }
    });
    let dark = Cfa::new("dark", whole.mosaic().clone(), dark.collect()).unwrap();
    assert!(trainer(&plain, &light()).unwrap().pipeline(&dark).is_err());
}

/// Settings of earlier studies stay as they are, and the paths have different ones.
#[test]
fn settings_tell_the_paths_apart() {
    let text = |settings: &LearningSettings| serde_json::to_string(settings).unwrap();
    let plain = text(&LearningSettings::default());
    assert!(!plain.contains("statistics") && !plain.contains("scene"), "{plain}");
    assert!(text(&light()).contains(r#""statistics":"light""#));
    assert_eq!(serde_json::from_str::<LearningSettings>(&text(&light())).unwrap(), light());
    assert!(serde_json::from_str::<LearningSettings>(r#"{"statistics":"moments"}"#).is_err());
    assert!(LearningSettings { scene: 1001, ..light() }.validate().is_err());
}

/// Scenes of other numbers have other leaves, and pipelines of their own.
#[test]
fn training_scenes_differ() {
    let (camera, cfa) = (camera(|_| ()), cfa(SETS[0]));
    let other = LearningSettings { scene: 1, ..light() };
    assert_ne!(learned(&camera, &light(), &cfa), learned(&camera, &other, &cfa));
}

/// The classes of a position divide its patches, each count rounded down, as a single class has them all.
#[test]
fn classes_divide_the_patches() {
    // Half the exposure, so that nothing is clipped.
    let (camera, cfa) = (camera(|d| d.exposure.auto_target = Some(0.5)), cfa(SETS[0]));
    let trained = |levels, textures| {
        let settings = LearningSettings { levels, textures, size_px: 64, ..light() };
        learned(&camera, &settings, &cfa)
    };
    let (one, divided) = (trained(1, Textures::None), trained(3, Textures::FlatTexture));
    assert_eq!((one.classes().len(), divided.classes().len()), (4, 4 * 3 * 2));
    for (whole, parts) in one.classes().iter().zip(divided.classes().chunks_exact(6)) {
        let sum: u64 = parts.iter().map(|class| class.count).sum();
        assert!(whole.count.abs_diff(sum) <= 6, "{} and {sum}: {parts:?}", whole.count);
        assert!(parts.iter().filter(|class| class.count > 0).count() > 3, "{parts:?}");
    }
}
