//! The light of the studio in components against the simulation with an optical image: how far the scores of the page are from those of the command.
#![allow(clippy::unwrap_used)]

use smalti::camera::{CameraDescription, PictureScores, TestScene, score_picture};
use smalti::design::live::{LiveDesign, LiveEffort, LiveLearner, LivePictures, LiveScene, LiveSetup};
use smalti::design::{LearningSettings, PixelLight, PreviewScene};
use smalti::isp::Isp;
use smalti::optics::OpticalImage;
use smalti::sensor::{NoiseMode, PixelSpectra};
use smalti::spectrum::{Illuminant, Observer};
use smalti_io::test_scenes::test_scene;
use smalti_io::{cameras, studio};

/// The scores of the picture that the camera of a design takes through its lens, with the pipeline of the design.
fn simulated(design: &LiveDesign, scene: &TestScene, noise: NoiseMode) -> PictureScores {
    let setup = scene.before(design.camera(), &Illuminant::D65).unwrap();
    let bright = OpticalImage::clone(&setup.image).scaled(design.luminance_cd_m2()).unwrap();
    // Pictures are scored in the light of the scene: without the balance from it to the D65 of the display, which differs by a few thousandths
    // and alone changes ΔE2000 by a tenth in the dark.
    let exposure = setup.camera.exposure(&bright).unwrap();
    let raw = setup.camera.sensor.capture(&bright, &exposure, noise, 1).unwrap();
    let picture = design.pipeline().render(&raw).unwrap();
    let reference = setup.camera.reference_as_exposed(&bright, &exposure, &setup.light).unwrap();
    let white = Observer::Cie1931.white(&setup.light).unwrap();
    score_picture(&picture, &reference, white, &Default::default()).unwrap()
}

/// The scores of the picture from the light in some components, in steps of the brightest pixel.
fn live(
    design: &LiveDesign,
    setup: &LiveSetup,
    scene: &TestScene,
    noise: NoiseMode,
    (components, steps): (usize, f64),
) -> PictureScores {
    let bare = setup.camera().unwrap();
    let before = scene.before(&bare, &Illuminant::D65).unwrap();
    let sensor = &before.camera.sensor;
    let spectra = PixelSpectra::new(sensor, &before.image).unwrap();
    let light = PixelLight::new(sensor, &spectra, components).unwrap().quantized(steps);
    let scene = LiveScene { name: "scene".into(), scene: PreviewScene { light, metered: None } };
    let mut pictures = LivePictures::new(scene, &Illuminant::D65, &bare).unwrap();
    let picture = pictures.picture(design, None, noise, 1).unwrap();
    pictures.scores(&picture).unwrap()
}

fn design(camera: &CameraDescription, learning: LearningSettings, luminance: f64) -> (LiveDesign, LiveSetup) {
    let setup = LiveSetup::new(camera, Illuminant::D65, learning);
    let mut learner = LiveLearner::new(studio::training_light(&setup).unwrap()).unwrap();
    (learner.learn(camera, luminance, 1, LiveEffort::Thorough).unwrap(), setup)
}

/// The largest differences of CPSNR, ΔE2000 and S-CIELAB between the simulation and the light in components.
fn apart(learning: &LearningSettings, light: (usize, f64), noise: NoiseMode) -> [f64; 3] {
    let mut camera = cameras::load("bayer", &[], None).unwrap().description().clone();
    let mut most = [0.0f64; 3];
    for (time_ms, luminance) in [(4.0, 12.0), (100.0, 10.0)] {
        camera.exposure.time_ms = Some(time_ms);
        let (design, setup) = design(&camera, learning.clone(), luminance);
        for scene in ["dead-leaves?rows=192&cols=288&seed=3", "macbeth?patch=48"] {
            let scene = TestScene::built_in(scene);
            let expected = simulated(&design, &scene, noise).figures();
            let found = live(&design, &setup, &scene, noise, light).figures();
            let differences = expected.iter().zip(found).map(|(a, b)| (a - b).abs());
            most.iter_mut().zip(differences).for_each(|(most, d)| *most = most.max(d));
        }
    }
    most
}

/// All wavelengths in fine steps give the scores of the simulation, but for rounding in single precision.
#[test]
fn light_at_all_wavelengths_gives_the_scores_of_the_simulation() {
    let learning = LearningSettings { side: 3, levels: 2, size_px: 80, ..LearningSettings::default() };
    let most = apart(&learning, (31, 1e7), NoiseMode::None);
    assert!(most.iter().all(|d| *d < 1e-3), "{most:?}");
}

/// The components and steps of the studio change CPSNR and ΔE2000 by less than the smallest relevant differences, and S-CIELAB, which averages
/// over neighbours and so keeps errors of colour but not the noise, by at most three of them. `docs/how-to/studio.md` states these bounds.
#[test]
fn the_light_of_the_studio_gives_nearly_the_scores_of_the_simulation() {
    for noise in [NoiseMode::None, NoiseMode::All] {
        let [cpsnr, delta_e, scielab] = apart(&studio::learning(), (8, 1000.0), noise);
        assert!(cpsnr < 0.1 && delta_e < 0.05 && scielab < 0.15, "{cpsnr} {delta_e} {scielab}");
    }
}

/// CPSNR, ΔE2000 and S-CIELAB of Paint brushes with the camera bayer at 1000 cd/m², where 4.4 % of the samples saturate, and at 10 cd/m², with a pipeline
/// that is learned from all training scenes: `smalti compare bayer --luminance 10,1000 --exposure own --scene photo-brushes --seeds 1`.
const LEARNED_FROM_ALL: [(f64, [f64; 3]); 2] = [(10.0, [32.36, 3.66, 4.03]), (1000.0, [32.03, 2.13, 2.56])];

/// Thorough learning comes near the pipeline that is learned from all training scenes, also where the picture clips; quick learning does not there.
#[test]
fn thorough_learning_comes_near_that_from_all_scenes() {
    let camera = cameras::load("bayer", &[], None).unwrap().description().clone();
    let setup = LiveSetup::new(&camera, Illuminant::D65, studio::learning());
    let mut learner = LiveLearner::new(studio::training_light(&setup).unwrap()).unwrap();
    let scene = test_scene("photo-brushes", &Illuminant::D65).unwrap();
    let mut missed = |(luminance, all): (f64, [f64; 3]), effort| {
        let design = learner.learn(&camera, luminance, 1, effort).unwrap();
        let found = live(&design, &setup, &scene, NoiseMode::All, (8, 1000.0)).figures();
        std::array::from_fn::<f64, 3, _>(|i| (found[i] - all[i]).abs())
    };
    let [dim, bright] = LEARNED_FROM_ALL.map(|at| missed(at, LiveEffort::Thorough));
    assert!(dim[0] < 1.0 && dim[1] < 0.4 && dim[2] < 1.0, "{dim:?}");
    assert!(bright[0] < 2.0 && bright[1] < 0.6 && bright[2] < 1.3, "{bright:?}");
    let quick = missed(LEARNED_FROM_ALL[1], LiveEffort::Quick);
    assert!(quick.iter().zip(bright).all(|(quick, bright)| *quick > 2.0 * bright), "{quick:?} {bright:?}");
}
