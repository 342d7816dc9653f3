//! The built-in cameras against published figures, and cameras with other mosaics.
#![allow(clippy::unwrap_used, clippy::panic)]

use smalti::camera::NOTABLE_UNSHARED_SHARE;
use smalti::sensor::Exposure;
use smalti::spectrum::{Extrapolation, Illuminant};

use super::*;

fn camera(name: &str) -> Camera {
    load(name, &[], None).unwrap()
}

fn within_2_percent(what: &str, got: f64, published: f64) {
    assert!((got / published - 1.0).abs() <= 0.02, "{what}: {got}, published {published}");
}

/// Electrons between the black level and the largest sample.
fn saturation_e(camera: &Camera) -> f64 {
    let levels = camera.sensor.raw_levels(&Exposure::new(0.01)).unwrap();
    (levels.white_v - levels.black_v) / camera.sensor.pixel.conversion_gain_v_per_e
}

/// Read noise, and the temporal dark noise of samples, which includes quantisation; electrons.
fn dark_noise_e(camera: &Camera) -> (f64, f64) {
    let bias = camera.sensor.noise_variance(0.0, &Exposure::new(0.0)).unwrap();
    let gain = camera.sensor.pixel.conversion_gain_v_per_e;
    (bias.read.sqrt() / gain, bias.temporal().sqrt() / gain)
}

/// Dark current at the sensor's temperature, electrons per second.
fn dark_current_e_per_s(camera: &Camera) -> f64 {
    let dark = camera.sensor.noise_variance(0.0, &Exposure::new(1.0)).unwrap().dark;
    let gain = camera.sensor.pixel.conversion_gain_v_per_e;
    // The dark shot noise is Poisson; PRNU changes its variance by less than 2e-4.
    dark / (gain * gain)
}

/// Largest electrons per photon on the pixel in red, green (or clear) and blue, without the infrared cut.
fn peaks(camera: &Camera) -> Vec<f64> {
    let mut sensor = camera.sensor.clone();
    sensor.ir_cut = None;
    let curves = sensor.spectral_responsivity_on(camera.grid()).unwrap();
    curves.iter().map(|c| c.max() * sensor.pixel.fill_factor).collect()
}

#[test]
fn machine_vision_has_the_emva_figures_of_the_imx250() {
    // MATRIX VISION, mvBlueFOX3-2051: SNRmax 40.3 dB, dynamic range 71.2 dB (EMVA 1288). Teledyne DALSA, Genie Nano: 10.7 ke⁻.
    let camera = camera("machine-vision");
    let saturation = saturation_e(&camera);
    within_2_percent("saturation capacity", saturation, 10_700.0);
    within_2_percent("SNRmax, dB", 10.0 * saturation.log10(), 40.3);
    // The absolute sensitivity threshold of EMVA 1288: temporal dark noise plus half an electron.
    let (_, dark) = dark_noise_e(&camera);
    within_2_percent("dynamic range, dB", 20.0 * (saturation / (dark + 0.5)).log10(), 71.2);
    within_2_percent("dynamic range", saturation / (dark + 0.5), 10f64.powf(71.2 / 20.0));
    // Basler, acA4112-30u (IMX304, monochrome): 70 % at 545 nm.
    let nm = WavelengthGrid::new(545.0, 5.0, 2).unwrap();
    let silicon = camera.sensor.quantum_efficiency.resampled(nm, Extrapolation::Zero).unwrap();
    within_2_percent("monochrome", silicon.values()[0] * camera.sensor.pixel.fill_factor, 0.70);
    within_2_percent("peak quantum efficiency", peaks(&camera)[1], 0.65);
    within_2_percent("dark current", dark_current_e_per_s(&camera), 0.97);
}

#[test]
fn cmv12000_has_the_figures_of_its_datasheet() {
    // ams, CMV12000, DS000603, v5-00, figures 7 and 8.
    let camera = camera("cmv12000");
    let (saturation, (_, dark)) = (saturation_e(&camera), dark_noise_e(&camera));
    within_2_percent("full well", saturation, 13_500.0);
    within_2_percent("SNRmax, dB", 10.0 * saturation.log10(), 41.3);
    within_2_percent("temporal noise", dark, 13.0);
    within_2_percent("dynamic range, dB", 20.0 * (saturation / dark).log10(), 60.0);
    within_2_percent("dark current", dark_current_e_per_s(&camera), 70.0);
    // Maxima of the curves: red at 605, green at 530 (mean of both rows), blue at 460 nm.
    for (got, published) in peaks(&camera).into_iter().zip([0.392, 0.408, 0.390]) {
        within_2_percent("peak quantum efficiency", got, published);
    }
}

#[test]
fn automotive_has_the_figures_of_the_split_pixel() {
    // Solhusvik et al. (2019), large photodiode at low conversion gain, as in ISETCam.
    let camera = camera("automotive");
    within_2_percent("full well", saturation_e(&camera), 22_000.0);
    within_2_percent("conversion gain", camera.sensor.pixel.conversion_gain_v_per_e, 49e-6);
    within_2_percent("read noise", dark_noise_e(&camera).0, 3.05);
    within_2_percent("dark current", dark_current_e_per_s(&camera), 25.6);
    // Clear, by the model of silicon.
    within_2_percent("peak quantum efficiency", peaks(&camera)[1], 0.77);
}

#[test]
fn full_frame_has_the_gain_and_noise_of_the_a7r_ii() {
    // Claff (2015): 0.315 DN/e⁻ and 1.413 DN at ISO 100; 14 bits above a black level of 512.
    let camera = camera("full-frame");
    let sensor = &camera.sensor;
    let dn_per_e = sensor.adc.levels() / sensor.pixel.voltage_swing_v * sensor.pixel.conversion_gain_v_per_e;
    within_2_percent("gain, DN/e⁻", dn_per_e, 0.315);
    within_2_percent("read noise, DN", dark_noise_e(&camera).1 * dn_per_e, 1.413);
    within_2_percent("saturation, DN", saturation_e(&camera) * dn_per_e, 16_383.0 - 512.0);
    within_2_percent("dynamic range", saturation_e(&camera) / dark_noise_e(&camera).1, 15_871.0 / 1.413);
    // The camera's curves, without a cut of their own.
    assert!(sensor.ir_cut.is_none());
    // LUCID, IMX571 in colour: 62.7 % at 527.5 nm, times the transmittance of the infrared cut.
    within_2_percent("peak quantum efficiency", peaks(&camera)[1], 0.627 * 0.9894);
    // QHYCCD, IMX455: 0.1231 e⁻/s at 15 °C, 0.2208 e⁻/s at 20 °C.
    let dark = 0.2208 * (0.2208 / 0.1231) * (4.51f64 / 3.76).powi(2);
    within_2_percent("dark current", dark_current_e_per_s(&camera), dark);
}

#[test]
fn phone_quad_has_the_figures_scaled_from_the_imx477() {
    // Hogan: 3400 e⁻/µm² and 3 e⁻ at base gain.
    let camera = camera("phone-quad");
    within_2_percent("full well", saturation_e(&camera), 3400.0 * 1.2 * 1.2);
    within_2_percent("read noise", dark_noise_e(&camera).1, 3.0);
    within_2_percent("dynamic range", saturation_e(&camera) / dark_noise_e(&camera).1, 4896.0 / 3.0);
    // Teledyne FLIR, IMX226 in colour: 72 % at 530 nm.
    within_2_percent("peak quantum efficiency", peaks(&camera)[1], 0.72);
}

/// The binned camera differs from the other in binning alone, and has one read noise for four photodiodes.
#[test]
fn phone_quad_binned_is_phone_quad_with_charge_binning() {
    let (single, binned) = (camera("phone-quad"), camera("phone-quad-binned"));
    let mut description = binned.description().clone();
    assert!(description.sensor.binning.take().is_some());
    description.name = "phone-quad".into();
    assert_eq!(&description, single.description());
    let (a, b) = (&single.sensor, &binned.sensor);
    assert_eq!((a.rows, a.cols), (2 * b.rows, 2 * b.cols));
    let exposure = Exposure::new(0.01);
    assert_eq!(a.read_noise_e(&exposure), b.read_noise_e(&exposure));
    within_2_percent("saturation of the floating diffusion", saturation_e(&binned), 4896.0);
    // 2000 columns are no multiple of 3.
    let error = load("phone-quad-binned@nona", &[], None).unwrap_err().to_string();
    assert!(error.contains("sensor.cols") && error.contains("1998"), "{error}");
    let cols = Override { key: "sensor.cols".into(), value: "1998".into() };
    assert_eq!(load("phone-quad-binned@nona", &[cols], None).unwrap().sensor.binning_side(), 3);
    let error = load("phone-quad-binned@bayer", &[], None).unwrap_err().to_string();
    assert!(error.contains("sensor.binning") && error.contains("quad-bayer"), "{error}");
}

#[test]
fn estimates_state_themselves() {
    for name in ["phone-quad", "phone-quad-binned", "automotive", "machine-vision", "full-frame"] {
        let file = names().iter().find(|c| c.name == name).unwrap();
        let mut comment = file.toml.lines().take_while(|l| l.starts_with('#'));
        assert!(comment.any(|l| l.contains("stimates")), "{name}");
        assert!(!file.toml.contains("no public figures"), "{name}: each estimate has a source");
    }
}

/// The figures of versions without an infrared cut are those of `--set optics.ir_cut=none`.
#[test]
fn cameras_of_the_slides_without_their_infrared_cut_are_those_before() {
    let cut = "ir_cut = { builtin = \"ir-cut\" }\n";
    for name in ["bayer", "rgbw", "clarity", "kodak", "wang", "rgbcmy", "medical"] {
        let file = names().iter().find(|c| c.name == name).unwrap();
        assert_eq!(file.toml.matches(cut).count(), 1, "{name}");
        let before = TomlSource { name: name.into(), folder: "".into(), text: file.toml.replace(cut, "") };
        let before = from_source(&before, &[], None).unwrap();
        let none = load(name, &["optics.ir_cut=none".parse().unwrap()], None).unwrap();
        assert_eq!(none.description(), before.description(), "{name}");
        assert!(none.optics == before.optics && none.optics.ir_cut.is_none(), "{name}");
        assert!(camera(name).optics.ir_cut.is_some(), "{name}");
    }
    assert!(camera("rgbx").optics.ir_cut.is_none());
}

#[test]
fn no_built_in_camera_has_a_clear_channel_that_sees_more() {
    for name in names().iter().map(|c| c.name) {
        let camera = camera(name);
        for light in [Illuminant::D65, Illuminant::A, Illuminant::Led] {
            let unshared = camera.unshared_light(&light.photons(WavelengthGrid::VISIBLE).unwrap()).unwrap();
            assert!(unshared.iter().all(|u| u.share < NOTABLE_UNSHARED_SHARE), "{name}: {unshared:?}");
        }
    }
    let uncut = load("rgbw", &["optics.ir_cut=none".parse().unwrap()], None).unwrap();
    let light = Illuminant::D65.photons(uncut.grid()).unwrap();
    let [w] = &uncut.unshared_light(&light).unwrap()[..] else { panic!("one clear channel") };
    assert!(w.share > NOTABLE_UNSHARED_SHARE && w.seen_nm[1] == 680.0, "{w:?}");
}

#[test]
fn a_name_with_a_mosaic_is_a_camera_and_a_mosaic() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("me@home.toml");
    std::fs::write(&file, "[sensor.pixel]\npitch_um = 1.5\n").unwrap();
    let name = file.to_str().unwrap();
    assert_eq!(camera(name).description().name, "me@home");
    let both = camera(&format!("{name}@xtrans"));
    assert_eq!((both.description().name.as_str(), both.sensor.cfa.name()), ("me@home@xtrans", "xtrans"));
    assert!(is_built_in("bayer@xtrans") && !is_built_in(name) && !is_built_in("bayer@no-such"));
    assert!(has_mosaic("bayer@anything") && has_mosaic("mine.toml@xtrans") && !has_mosaic(name));
    // The name stays when the mosaic is put on once more.
    let toml = load_with_notes("bayer@xtrans", &[], None).unwrap().stated_toml().unwrap();
    std::fs::write(&file, toml).unwrap();
    assert_eq!(camera(&format!("{name}@xtrans")).description(), camera("bayer@xtrans").description());
}
