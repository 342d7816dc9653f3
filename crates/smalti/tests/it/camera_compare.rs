//! Laws of comparisons: the reference has the scale of the picture, equal cameras are equal, light and time are one.
#![allow(missing_docs, clippy::unwrap_used)]

use smalti::camera::description::{ArchitectureName, PatternDescription};
use smalti::camera::{
    Camera, CameraAndIsp, CameraDescription, EvaluationSettings, ExposureTimes, GainInterval, LightGain,
    LightGainSettings, ScoreSettings, Setup, TestScene, compare_on, evaluate, evaluate_with, light_gains,
    score_picture, test_scenes,
};
use smalti::color::Image;
use smalti::isp::{Isp, IspError, WhiteBalance};
use smalti::metrics::esfr::Mtf50Reliability;
use smalti::numeric::Planes;
use smalti::optics::Falloff;
use smalti::scene::{Setting, uniform};
use smalti::sensor::{Channel, Filter, NoiseMode, RawImage};
use smalti::spectrum::{Observer, Spectrum, WavelengthGrid};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

/// A small camera at 100 ms and a tenth of the gain, as the slides' are.
fn camera(change: impl FnOnce(&mut CameraDescription)) -> Camera {
    let mut d = CameraDescription::default();
    (d.sensor.rows, d.sensor.cols) = (48, 64);
    d.exposure.time_ms = Some(100.0);
    d.exposure.analog_gain = 0.125;
    d.sensor.pixel.full_well_e = 70_000.0;
    d.sensor.adc_bits = 14;
    d.isp.white_balance = WhiteBalance::None;
    change(&mut d);
    Camera::new(d, GRID).unwrap()
}

fn pattern(d: &mut CameraDescription, name: &str) {
    d.sensor.cfa.pattern = PatternDescription::Name(name.into());
}

fn mean_of(planes: &Planes) -> Vec<f64> {
    planes.planes().map(|p| p.iter().map(|&v| f64::from(v)).sum::<f64>() / p.len() as f64).collect()
}

/// What the classic pipeline makes of white and what the observer sees of it: the same, in all of X, Y, Z, whatever lens, gain,
/// offset, converter and architecture.
#[test]
fn the_reference_of_white_is_its_picture() {
    type Change = fn(&mut CameraDescription);
    let cases: [(&str, Change); 8] = [
        ("plain", |_| {}),
        ("rgbw", |d| pattern(d, "rgbw")),
        ("black level", |d| d.sensor.black_level_dn = 1000.0),
        ("offset", |d| d.exposure.analog_offset_mv = 30.0),
        ("no converter", |d| d.sensor.adc_bits = 0),
        ("a lens that is yellow", |d| {
            d.optics.transmittance = Filter::Gaussian { center_nm: 600.0, sigma_nm: 70.0, peak: 0.9 };
        }),
        ("prism", |d| d.sensor.architecture = ArchitectureName::Prism),
        ("field sequential", |d| d.sensor.architecture = ArchitectureName::FieldSequential),
    ];
    for (name, change) in cases {
        let camera = camera(|d| {
            d.isp.preserve_white = true;
            d.exposure.analog_gain = 0.5;
            d.sensor.adc_bits = 16;
            d.optics.falloff = Falloff::None;
            change(d);
        });
        let setting = Setting { horizontal_fov_deg: 20.0, luminance_cd_m2: 120.0, ..Setting::default() };
        let scene = uniform(64, 64, &setting).unwrap();
        let image = camera.optics.image(&scene).unwrap();
        let light = scene.illuminant();
        let photo = camera.photograph(image, light, NoiseMode::None, 1).unwrap();
        let reference = camera.reference_as_exposed(&photo.optical_image, &photo.exposure, light).unwrap();
        let (got, expected) = (mean_of(photo.picture.planes()), mean_of(reference.planes()));
        eprintln!("{name}: picture {got:.4?}, reference {expected:.4?}");
        for (g, e) in got.iter().zip(&expected) {
            // Blue behind the yellow lens is at a fiftieth of saturation, where sixteen bits round by up to 4e-4.
            assert!((g / e - 1.0).abs() < 1e-3, "{name}: picture {got:?}, reference {expected:?}");
        }
        assert!(photo.raw.saturated_percent() == 0.0 && expected[1] > 0.05, "{name}: {expected:?}");
    }
}

/// Through the camera's own sensitivities one sees the camera's own raw values: blur, fall-off and scale are those of the sensor.
#[test]
fn through_its_own_sensitivities_a_camera_sees_its_raw_values() {
    let camera = camera(|d| {
        pattern(d, "rgbw");
        d.sensor.architecture = ArchitectureName::Prism;
        d.sensor.adc_bits = 0;
        d.optics.transmittance = Filter::Gaussian { center_nm: 560.0, sigma_nm: 90.0, peak: 0.8 };
    });
    let setting = Setting { luminance_cd_m2: 20.0, ..Setting::default() };
    let setup = Setup::of_test_scene(&camera, "dead-leaves?rows=96&cols=128", &setting).unwrap();
    let camera = &setup.camera;
    let lens = camera.optics.transmittance_on(GRID).unwrap();
    let seen = camera.sensor.spectral_responsivity_on(GRID).unwrap();
    let channels: Vec<Channel> = seen
        .iter()
        .zip(camera.sensor.cfa.channels())
        .map(|(s, c)| Channel { name: c.name.clone(), transmittance: s.times(&lens).unwrap() })
        .collect();
    let white = |c: &&Channel| c.transmittance.times(&setup.light).unwrap().integral();
    let brightest = channels.iter().max_by(|a, b| white(a).total_cmp(&white(b))).unwrap();
    let scale = camera.exposure_scale(&setup.exposure, &setup.light, &brightest.transmittance).unwrap();
    let got = camera.seen_by(&setup.image, &channels).unwrap();
    let raw = camera.sensor.capture(&setup.image, &setup.exposure, NoiseMode::None, 1).unwrap().normalized();
    assert_eq!((got.count(), raw.len()), (4, got.data().len()));
    for (g, r) in got.data().iter().zip(&raw) {
        // Sums of 31 single-precision products in two orders of scaling.
        assert!((f64::from(*g) * scale - f64::from(*r)).abs() < 1e-5 * f64::from(*r) + 1e-9, "{g} {r}");
    }
    // Twice the unit of the targets is twice what is seen and half the scale.
    let twice: Vec<Channel> = channels
        .iter()
        .map(|c| Channel { transmittance: c.transmittance.scaled(2.0).unwrap(), name: c.name.clone() })
        .collect();
    let double = camera.seen_by(&setup.image, &twice).unwrap();
    assert!(double.data().iter().zip(got.data()).all(|(d, g)| (d / g - 2.0).abs() < 1e-4));
}

#[test]
fn impossible_targets_are_refused() {
    let camera = camera(|_| {});
    let setup = Setup::of_test_scene(&camera, "uniform?size=16", &Setting::default()).unwrap();
    let flat = |v| Channel { name: "x".into(), transmittance: Spectrum::constant(GRID, v).unwrap() };
    let seen = |targets: &[Channel]| setup.camera.seen_by(&setup.image, targets);
    assert!(seen(&[]).is_err() && seen(&[flat(0.0)]).is_err() && seen(&[flat(1.0), flat(-1.0)]).is_err());
    assert!(seen(&[flat(1.0)]).is_ok());
    let (exposure, light) = (&setup.exposure, &setup.light);
    let scale = |l: &Spectrum, s: f64| {
        setup.camera.exposure_scale(exposure, l, &Spectrum::constant(GRID, s).unwrap())
    };
    assert!(
        scale(&light.scaled(0.0).unwrap(), 1.0).is_err()
            && scale(light, 0.0).is_err()
            && scale(light, 1.0).is_ok()
    );
}

/// A camera whose channels are nearly those of the observer renders nearly what the reference shows.
#[test]
fn the_reference_is_what_a_prism_camera_renders() {
    let camera = camera(|d| {
        d.sensor.architecture = ArchitectureName::Prism;
        pattern(d, "five-band");
    });
    let setup = Setup::of_test_scene(&camera, "macbeth?patch=32", &Setting::default()).unwrap();
    let Setup { camera, image, light, exposure } = &setup;
    let raw = camera.sensor.capture(image, exposure, NoiseMode::None, 1).unwrap();
    let picture = camera.isp(light, WhiteBalance::None).unwrap().render(&raw).unwrap();
    let reference = camera.reference_as_exposed(image, exposure, light).unwrap();
    let white = Observer::Cie1931.white(light).unwrap();
    let scores = score_picture(&picture, &reference, white, &ScoreSettings::default());
    let scores = scores.unwrap();
    assert!(scores.cpsnr_db > 35.0 && scores.pixel_delta_e_2000_mean < 2.0, "{scores:?}");
    // The relative reference differs from it by one factor where the lens is colourless.
    let relative = camera.reference(image).unwrap();
    let factor = reference.planes().data()[0] / relative.planes().data()[0];
    let pairs = reference.planes().data().iter().zip(relative.planes().data());
    assert!(pairs.clone().all(|(a, b)| (a / (b * factor) - 1.0).abs() < 1e-4));
}

/// Twice the light on a scene is the scene of twice the luminance.
#[test]
fn light_scales_a_setup() {
    let camera = camera(|_| {});
    let at = |cd_m2: f64| {
        let setting = Setting { luminance_cd_m2: cd_m2, ..Setting::default() };
        Setup::of_test_scene(&camera, "macbeth?patch=16", &setting).unwrap()
    };
    let (scaled, made) = (at(1.0).in_light(3.0).unwrap(), at(3.0));
    let pairs = |a: &Setup, b: &Setup| {
        let data = |s: &Setup| s.image.irradiance().planes().data().to_vec();
        data(a).into_iter().zip(data(b)).map(|(x, y)| f64::from(x / y - 1.0).abs()).fold(0.0, f64::max)
    };
    // The transforms of the lens are of single precision.
    assert!(pairs(&scaled, &made) < 1e-4, "{}", pairs(&scaled, &made));
    assert!((scaled.light.max() / made.light.max() - 1.0).abs() < 1e-6);
    assert!(made.in_light(-1.0).is_err() && made.in_light(f64::NAN).is_err());
    // Another camera behind the same lens takes the same image; one of other pixels does not.
    assert!(made.before(&self::camera(|d| pattern(d, "rgbw"))).unwrap().is_some());
    assert!(made.before(&self::camera(|d| d.sensor.pixel.pitch_um = 3.0)).unwrap().is_none());
}

#[test]
fn every_test_scene_is_scored_and_dark_is_worse() {
    let camera = camera(|_| {});
    for spec in test_scenes() {
        let scores = |cd_m2: f64| {
            let setting = Setting { luminance_cd_m2: cd_m2, ..Setting::default() };
            let setup = Setup::of_test_scene(&camera, spec, &setting).unwrap();
            let isp = setup.camera.isp(&setup.light, WhiteBalance::None).unwrap();
            compare_on(&setup, &isp, 1, &ScoreSettings::default()).unwrap()
        };
        let (dim, bright) = (scores(1.0), scores(20.0));
        let (rows, cols) = (bright.picture.rows(), bright.picture.cols());
        assert!(rows <= 288 && cols <= 384 && rows >= 192, "{spec}: {rows} × {cols}");
        assert_eq!((bright.reference.rows(), bright.reference.cols()), (rows, cols));
        let figures = |s: &smalti::camera::SceneScores| {
            (s.scores.cpsnr_db, s.scores.pixel_delta_e_2000_mean, s.scores.scielab_mean)
        };
        eprintln!("{spec}: {:.2?} at 1 cd/m², {:.2?} at 20", figures(&dim), figures(&bright));
        // What the sensor clips of the sunlit room costs some of what the rest gains.
        assert!(dim.scores.cpsnr_db < bright.scores.cpsnr_db, "{spec}");
        assert!(dim.scores.scielab_mean > bright.scores.scielab_mean, "{spec}");
    }
}

/// Any processing is evaluated as the camera's own is.
#[test]
fn evaluating_with_the_classic_pipeline_is_evaluating() {
    let camera = camera(|d| d.sensor.pixel.read_noise_mv = 5.0);
    let settings = EvaluationSettings { luminance_cd_m2: 10.0, ..EvaluationSettings::default() };
    let (own, pictures) = evaluate(&camera, &settings, &|_, make| make()).unwrap();
    let isp = |light: &Spectrum| {
        let isp = camera.isp(light, WhiteBalance::None)?;
        Ok(Box::new(isp) as Box<dyn Isp>)
    };
    let (with, same) = evaluate_with(&camera, &settings, &|_, make| make(), &isp).unwrap();
    assert_eq!(own, with);
    assert_eq!(pictures.macbeth, same.macbeth);
    let snr = &own.visual_snr.per_patch;
    assert!(snr.len() == 6 && snr.iter().all(|v| v.is_finite() && *v > 0.0), "{snr:?}");
    assert!(snr[5] < snr[0], "noise is seen in the dark: {snr:?}");
    let dim = EvaluationSettings { luminance_cd_m2: 1.0, ..settings };
    let (dim, _) = evaluate(&camera, &dim, &|_, make| make()).unwrap();
    assert!(
        dim.visual_snr.median < 0.6 * own.visual_snr.median,
        "{} {}",
        dim.visual_snr.median,
        own.visual_snr.median
    );
}

/// Renders a slanted edge where the raw image has saturated wholly, as rounding may, and otherwise what another processing does.
struct EdgeFromNothing<I>(I);

impl<I: Isp> Isp for EdgeFromNothing<I> {
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        let mut picture = self.0.render(raw)?;
        if raw.saturated_percent() > 99.5 {
            let (rows, cols) = (picture.rows(), picture.cols());
            let is_right = |i: usize| {
                (i % cols) as f64 > 0.5 * cols as f64 + 0.2 * ((i / cols) as f64 - 0.5 * rows as f64)
            };
            let edge = |i: usize| if is_right(i) { 1.0 } else { 0.3 };
            let values = (0..3).flat_map(|_| (0..rows * cols).map(edge)).collect();
            picture = Image::new(picture.space(), Planes::new(rows, cols, 3, values)?)?;
        }
        Ok(picture)
    }
}

/// A target that saturates wholly shows no edge, whatever processing makes of it.
#[test]
fn a_wholly_saturated_edge_is_no_edge() {
    let camera = camera(|_| {});
    let isp = |light: &Spectrum| {
        let isp = camera.isp(light, WhiteBalance::None)?;
        Ok(Box::new(EdgeFromNothing(isp)) as Box<dyn Isp>)
    };
    let low_contrast = |edge_s: f64| {
        let exposure = Some(ExposureTimes { macbeth_s: 0.1, edge_s, zone_plate_s: 0.1 });
        let settings =
            EvaluationSettings { luminance_cd_m2: 80.0, exposure, ..EvaluationSettings::default() };
        let (found, _) = evaluate_with(&camera, &settings, &|_, make| make(), &isp).unwrap();
        (found.mtf50_low_contrast_cy_per_px, found.mtf50_low_contrast_reliability)
    };
    let (shown, reliability) = low_contrast(0.1);
    assert!(shown > 0.1 && reliability == Mtf50Reliability::Reliable, "{shown} {reliability:?}");
    let (saturated, reliability) = low_contrast(30.0);
    assert!(saturated.is_nan() && reliability == Mtf50Reliability::NoEdge, "{saturated} {reliability:?}");
}

/// The light gains of one scene with two seeds. Each interval has the gain in it.
fn gains(a: &Camera, b: &Camera) -> Vec<(&'static str, LightGain)> {
    let isp = |camera: &Camera, light: &Spectrum| camera.isp(light, WhiteBalance::None);
    let (isp_a, isp_b) = (
        |light: &Spectrum| isp(a, light).map(|i| Box::new(i) as Box<dyn Isp>),
        |light: &Spectrum| isp(b, light).map(|i| Box::new(i) as Box<dyn Isp>),
    );
    let settings = LightGainSettings {
        scenes: vec![TestScene::BuiltIn("dead-leaves?rows=192&cols=256&least=2&largest=60&seed=1001".into())],
        seed_count: 2,
        ..LightGainSettings::default()
    };
    let (a, b) = (CameraAndIsp { camera: a, isp: &isp_a }, CameraAndIsp { camera: b, isp: &isp_b });
    let found = light_gains(a, b, &settings).unwrap().metrics;
    for m in &found {
        let GainInterval { low, high } = m.interval.unwrap();
        let [low, gain, high] = [low, m.gain, high].map(|end| match end {
            LightGain::Stops(stops) => stops,
            LightGain::MoreThan(_) => f64::INFINITY,
            LightGain::LessThan(_) => f64::NEG_INFINITY,
        });
        assert!(low <= gain + 1e-6 && gain <= high + 1e-6, "{m:?}");
    }
    found.iter().map(|m| (m.metric, m.gain)).collect()
}

#[test]
fn a_camera_gains_nothing_on_itself() {
    let c = camera(|_| {});
    for (metric, gain) in gains(&c, &c) {
        assert_eq!(gain, LightGain::Stops(0.0), "{metric}");
    }
}

/// Half the time takes twice the light: to the bit, since without dark current only their product counts.
#[test]
fn half_the_time_costs_one_stop() {
    let [whole, half] = [100.0, 50.0].map(|ms| {
        camera(|d| {
            d.exposure.time_ms = Some(ms);
            d.sensor.pixel.dark_voltage_v_per_s = 0.0;
        })
    });
    for (metric, gain) in gains(&half, &whole) {
        assert_eq!(gain, LightGain::Stops(1.0), "{metric}");
    }
    for (metric, gain) in gains(&whole, &half) {
        assert_eq!(gain, LightGain::Stops(-1.0), "{metric}");
    }
}

/// The scale of an exposure is neither an advantage nor a fault: half the gain without a converter changes nothing but the
/// rounding, and noise by it.
#[test]
fn gain_is_no_light() {
    let [full, less] = [0.125, 0.0625].map(|gain| {
        camera(|d| {
            d.exposure.analog_gain = gain;
            d.sensor.adc_bits = 0;
        })
    });
    for (metric, gain) in gains(&less, &full) {
        let LightGain::Stops(stops) = gain else { panic!("{metric}: {gain}") };
        assert!(stops.abs() < 0.02, "{metric}: {gain}");
    }
}

/// A filter that takes half of the light takes it for good: with photon noise alone that is one stop, in other noise.
#[test]
fn half_the_light_through_the_lens_costs_one_stop() {
    let [clear, grey] = [1.0, 0.5].map(|transmittance| {
        camera(|d| {
            d.optics.transmittance = Filter::Flat(transmittance);
            d.sensor.pixel.dark_voltage_v_per_s = 0.0;
        })
    });
    for (metric, gain) in gains(&grey, &clear) {
        let LightGain::Stops(stops) = gain else { panic!("{metric}: {gain}") };
        assert!((stops - 1.0).abs() < 0.02, "{metric}: {gain}");
    }
}
