//! Pipelines of designs' own: laws, and against classic processing.
#![allow(clippy::unwrap_used)]

use smalti::camera::{Camera, CameraDescription, CameraError, ScoreSettings, Setup, compare_on};
use smalti::design::{LearningSettings, Metric, PipelineTrainer, Scores, Targets};
use smalti::isp::WhiteBalance;
use smalti::l3::Textures;
use smalti::scene::Setting;
use smalti::sensor::{Cfa, Channel, Mosaic};
use smalti::spectrum::{Spectrum, WavelengthGrid};

use crate::design_targets::{SETS, cfa, targets};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;
/// A scene that nothing is learned from: other leaves, other radii.
const UNSEEN: &str = "dead-leaves?rows=256&cols=320&least=2&largest=150&seed=1001";

/// The camera of "Resolution in Color Filter Array Images".
fn camera() -> Camera {
    let mut d = CameraDescription::default();
    (d.sensor.adc_bits, d.sensor.pixel.pitch_um, d.sensor.pixel.fill_factor) = (0, 2.8, 0.5);
    Camera::new(d, GRID).unwrap()
}

fn trainer(camera: &Camera, settings: &LearningSettings) -> Result<PipelineTrainer, CameraError> {
    PipelineTrainer::new(&targets(camera), settings, &|_, make| make())
}

/// ΔE, MTF50 in cycles/mm and luminance noise in percent.
fn figures(scores: &Scores) -> [f64; 3] {
    [Metric::DeltaE76, Metric::Mtf50CyPerMm, Metric::LuminanceNoise].map(|m| scores.value(m, 0).unwrap())
}

/// So small that laws are tested fast.
fn small() -> LearningSettings {
    LearningSettings {
        side: 5,
        levels: 2,
        textures: Textures::FlatTexture,
        size_px: 96,
        ..LearningSettings::default()
    }
}

fn score(trainer: &PipelineTrainer, targets: &Targets, cfa: &Cfa) -> Result<Scores, CameraError> {
    let (pipeline, reach) = trainer.pipeline(cfa)?;
    targets.score_with(cfa, &pipeline.renderer(), reach)
}

/// Colour, resolution and noise of every set get better, and the picture of a scene that was not learned from.
#[test]
fn learned_processing_beats_classic_at_every_number_of_colours() {
    let camera = camera();
    let (targets, trainer) = (targets(&camera), trainer(&camera, &LearningSettings::default()).unwrap());
    let setup = Setup::of_test_scene(&camera, UNSEEN, &Setting::default()).unwrap();
    for set in SETS {
        let cfa = cfa(set);
        let n = cfa.channels().len();
        let camera = camera.with_cfa(cfa.clone());
        let (pipeline, reach) = trainer.pipeline(&cfa).unwrap();
        let learned = targets.score_with(&cfa, &pipeline.renderer(), reach).unwrap();
        let classic = targets.score(&cfa).unwrap();
        let both = format!("{n} colours: {learned:?}, classic {classic:?}");
        let ([delta_e, mtf50, noise], by_classic) = (figures(&learned), figures(&classic));
        assert!(delta_e < 0.97 * by_classic[0], "{both}");
        assert!(mtf50 > 1.3 * by_classic[1], "{both}");
        assert!(noise < 0.6 * by_classic[2], "{both}");

        let setup = setup.before(&camera).unwrap().unwrap();
        let isp = camera.isp(&setup.light, WhiteBalance::None).unwrap();
        let on = |isp| compare_on(&setup, isp, 1, &ScoreSettings::default()).unwrap().scores;
        let (learned, classic) = (on(&pipeline), on(&isp));
        let both = format!(
            "{n} colours: {} dB, ΔE {}; classic {} dB, {}",
            learned.cpsnr_db,
            learned.pixel_delta_e_2000_mean,
            classic.cpsnr_db,
            classic.pixel_delta_e_2000_mean
        );
        assert!(learned.cpsnr_db > 1.5 + classic.cpsnr_db, "{both}");
        assert!(learned.pixel_delta_e_2000_mean < 0.9 * classic.pixel_delta_e_2000_mean, "{both}");
    }
}

#[test]
fn threads_change_no_bit() {
    let camera = camera();
    let cfa = cfa(SETS[4]);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let trainer = trainer(&camera, &small()).unwrap();
            (trainer.pipeline(&cfa).unwrap(), score(&trainer, &targets(&camera), &cfa).unwrap())
        })
    };
    assert_eq!(with(1), with(3));
}

/// The rows that `reach` names are enough: a band gives the rows that the whole target gives.
#[test]
fn pictures_depend_on_the_rows_within_reach() {
    let camera = camera();
    let (targets, cfa) = (targets(&camera), cfa(SETS[2]));
    for textures in [Textures::FlatTexture, Textures::Oriented] {
        let trainer = trainer(&camera, &LearningSettings { textures, ..small() }).unwrap();
        let (pipeline, reach) = trainer.pipeline(&cfa).unwrap();
        let far = targets.score_with(&cfa, &pipeline.renderer(), reach + 60).unwrap();
        assert_eq!(targets.score_with(&cfa, &pipeline.renderer(), reach).unwrap(), far);
    }
}

/// A channel that sees nothing is a pixel less, not an end.
#[test]
fn blind_channels() {
    let camera = camera();
    let (targets, trainer) = (targets(&camera), trainer(&camera, &small()).unwrap());
    let whole = cfa(SETS[1]);
    let blind = |which: &dyn Fn(usize) -> bool| {
        let channel = |(i, c): (usize, &Channel)| Channel {
            transmittance: if which(i) {
                Spectrum::constant(GRID, 0.0).unwrap()
            } else {
                c.transmittance.clone()
            },
            ..c.clone()
        };
        let channels = whole.channels().iter().enumerate().map(channel).collect();
        Cfa::new("blind", whole.mosaic().clone(), channels).unwrap()
    };
    let delta_e = |cfa: &Cfa| figures(&score(&trainer, &targets, cfa).unwrap())[0];
    let all = delta_e(&whole);
    let without = delta_e(&blind(&|i| i == 3));
    assert!(without.is_finite() && without > all);
    assert!(score(&trainer, &targets, &blind(&|_| true)).is_err());
    // One channel: grey pictures.
    let mono = Cfa::new("one", Mosaic::new(1, 1, vec![0]).unwrap(), whole.channels()[1..2].to_vec()).unwrap();
    assert!(delta_e(&mono) > all);
    // More channels than classes can tell apart.
    let many = (0..33).map(|i| Channel { name: i.to_string(), ..whole.channels()[1].clone() }).collect();
    let many = Cfa::new("many", Mosaic::new(1, 33, (0..33).collect()).unwrap(), many).unwrap();
    assert!(trainer.pipeline(&many).is_err());
}

#[test]
fn impossible_settings_are_refused() {
    let camera = camera();
    for size_px in [0, 15, 4097, usize::MAX] {
        assert!(trainer(&camera, &LearningSettings { size_px, ..small() }).is_err());
    }
    let cfa = cfa(SETS[0]);
    for settings in [
        LearningSettings { side: 4, ..small() },
        LearningSettings { side: 13, ..small() },
        LearningSettings { levels: 0, ..small() },
        LearningSettings { levels: 257, ..small() },
    ] {
        assert!(trainer(&camera, &settings).and_then(|l| l.pipeline(&cfa)).is_err());
    }
}
