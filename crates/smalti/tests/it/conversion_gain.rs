//! Pixels with two conversion gains: noise and levels against closed forms, and both gains combined against each alone.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use smalti::camera::description::{BinningDescription, ConversionGainName, PatternDescription};
use smalti::camera::{Camera, CameraDescription, CameraError, TrainingSettings};
use smalti::scene::{self, Setting};
use smalti::sensor::*;
use smalti::spectrum::{Illuminant, WavelengthGrid};

use crate::sensor_kit::*;

/// A quarter of the high gain of [`pixel`], 100 µV.
const LOW: LowGain = LowGain { conversion_gain_v_per_e: 25e-6, read_noise_v: 5e-4 };

fn exposure(conversion_gain: ConversionGain) -> Exposure {
    Exposure { conversion_gain, ..Exposure::new(0.01) }
}

fn high() -> Exposure {
    exposure(ConversionGain::High)
}

fn low() -> Exposure {
    exposure(ConversionGain::Low(LOW))
}

fn combined() -> Exposure {
    exposure(ConversionGain::Combined(LOW))
}

/// A swing of 1 V holds 10 000 e⁻ at the high gain and 40 000 at the low one; the full well holds 30 000.
fn device(size: usize) -> Sensor {
    let mut s = sensor(size, size);
    s.cfa = mono();
    s.pixel.full_well_e = 30_000.0;
    s.pixel.read_noise_v = 2e-4;
    s.adc = Adc { bits: 12, black_level_dn: 64.0 };
    s
}

fn wide(photons: f32) -> smalti::optics::OpticalImage {
    flat(3, 3, 2e-2, photons)
}

fn photons_for(electrons: f64) -> f32 {
    (electrons / (310.0 * 0.5 * 2.8e-6 * 2.8e-6 * 0.01)) as f32
}

fn drawn(s: &Sensor, image: &smalti::optics::OpticalImage, e: &Exposure, seed: u64) -> Vec<f32> {
    values(&s.capture(image, e, NoiseMode::All, seed).unwrap())
}

/// An image from dark to beyond the full well.
fn ramp(size: usize) -> smalti::optics::OpticalImage {
    let top = f64::from(photons_for(45_000.0));
    let row = |_| (0..size).map(move |c| (top * c as f64 / size as f64) as f32);
    image(size, size, 2.8e-6, (0..31 * size).flat_map(row).collect())
}

#[test]
fn levels_are_those_of_each_gain() {
    let s = device(8);
    let (h, l, c) =
        (s.raw_levels(&high()).unwrap(), s.raw_levels(&low()).unwrap(), s.raw_levels(&combined()).unwrap());
    assert_eq!((h.black, h.white), (64.0, 4095.0));
    // 30 000 e⁻ at 25 µV: 0.75 V.
    assert_eq!((l.black, l.white), (64.0, 64.0 + 3072.0));
    assert_eq!((c.black, c.white), (64.0, 64.0 + 4.0 * 3072.0));
    assert_eq!([high(), low(), combined()].map(|e| s.sample_bits(&e)), [12, 12, 14]);
    assert!((s.saturation_v(&combined()) - 3.0).abs() < 1e-12);
    // Sixteen bits at most: 16 bits and two more are divided by four.
    let mut fine = device(8);
    fine.adc = Adc { bits: 16, black_level_dn: 1024.0 };
    let levels = fine.raw_levels(&combined()).unwrap();
    assert_eq!((fine.sample_bits(&combined()), levels.black, levels.white), (16, 256.0, 256.0 + 49_152.0));
    let bright = drawn(&fine, &wide(photons_for(60_000.0)), &combined(), 1);
    let mean = moments(&bright).0;
    assert!((mean - levels.white).abs() < 100.0, "{mean}");
}

/// Without read noise, a combined sample is the number of the high gain below the switch, and four times that of the low gain above it.
#[test]
fn combined_samples_are_high_below_and_low_above() {
    for noise in [NoiseMode::None, NoiseMode::PhotonOnly] {
        let (s, image) = (device(64), ramp(64));
        let of = |e: &Exposure| values(&s.capture(&image, e, noise, 5).unwrap());
        let (h, l, c) = (of(&high()), of(&low()), of(&combined()));
        let switch = 64.0 + 0.95 * (4095.0 - 64.0);
        let mut count = [0, 0];
        for ((h, l), c) in h.iter().zip(&l).zip(&c) {
            let is_low = *h > switch;
            count[usize::from(is_low)] += 1;
            assert_eq!(*c, if is_low { 64.0 + 4.0 * (l - 64.0) } else { *h }, "{h} {l}");
        }
        assert!(count.iter().all(|n| *n > 500), "{count:?}");
    }
    // The samples are those of one scale: the mean is proportional to light.
    let s = device(128);
    for electrons in [3000.0, 9000.0, 9600.0, 12_000.0, 25_000.0] {
        let mean = moments(&drawn(&s, &wide(photons_for(electrons)), &combined(), 2)).0;
        let expected = 64.0 + electrons * 1e-4 * 4096.0;
        assert!((mean / expected - 1.0).abs() < 2e-3, "{mean} for {expected}");
    }
}

/// The variance is that of the gain that is read, on the scale of the high one. 320 000 samples have a standard error of 0.25 %.
#[test]
fn noise_is_that_of_the_gain_to_one_percent() {
    let mut s = device(400);
    s.pixel.dark_voltage_v_per_s = 0.05;
    s.nonuniformity.prnu_fraction = 0.005;
    s.nonuniformity.dsnu_v = 1e-4;
    let lsb_v = 1.0 / 4096.0;
    for (e, gain, read_v, scale, levels) in [
        (high(), 1e-4, 2e-4, 1.0, [0.0, 300.0, 6000.0]),
        (low(), 25e-6, 5e-4, 1.0, [0.0, 300.0, 20_000.0]),
        (combined(), 1e-4, 2e-4, 1.0, [0.0, 300.0, 6000.0]),
        (combined(), 25e-6, 5e-4, 4.0, [11_000.0, 15_000.0, 24_000.0]),
    ] {
        for electrons in levels {
            let (mean_e, p): (f64, f64) = (electrons + 5.0, 0.005);
            let mut theory = gain * gain * (mean_e * (1.0 + p * p) + (p * mean_e).powi(2) + 1.0)
                + read_v * read_v
                + lsb_v * lsb_v / 12.0;
            theory *= scale * scale;
            let model = s.noise_variance(electrons, &e).unwrap().total();
            // Samples of the low gain in combined ones lie on every fourth number: nothing is rounded again.
            let rounding = if scale > 1.0 { lsb_v * lsb_v / 12.0 } else { 0.0 };
            assert!((model / (theory + rounding) - 1.0).abs() < 1e-6, "{electrons}: {model} for {theory}");
            let mut all = Vec::new();
            for device in 0..2 {
                s.nonuniformity.device_serial = device;
                all.extend(drawn(&s, &wide(photons_for(electrons)), &e, device));
            }
            let found = moments(&all).1 * lsb_v * lsb_v;
            assert!((found / theory - 1.0).abs() < 0.01, "{e:?} {electrons}: {found} for {theory}");
            // What learned pipelines take for the noise of normalised samples.
            let levels = s.raw_levels(&e).unwrap();
            let range_v = levels.white_v - levels.black_v;
            let signal = electrons * s.volts_per_electron(&e) / range_v;
            let of_signal = s.signal_noise(&e).unwrap().variance(signal) * range_v * range_v;
            assert!((of_signal / model - 1.0).abs() < 2e-3, "{electrons}: {of_signal} for {model}");
        }
    }
    assert_eq!(s.signal_noise(&low()).unwrap().above, None);
    let noise = s.signal_noise(&combined()).unwrap();
    let above = noise.above.unwrap();
    // The polynomial has the variance itself in the dark and where the gains change.
    let x = above.signal;
    let polynomial = noise.variance(0.0) + noise.per_signal * x + noise.quadratic() * x * x;
    assert!((polynomial / (noise.variance(x) + above.constant) - 1.0).abs() < 1e-12);
}

/// The low gain alone is a pixel of that gain.
#[test]
fn the_low_gain_is_a_pixel_with_more_capacitance() {
    let mut s = noisy_sensor(20, 30);
    s.pixel.full_well_e = 30_000.0;
    let mut other = s.clone();
    other.pixel.conversion_gain_v_per_e = LOW.conversion_gain_v_per_e;
    other.pixel.read_noise_v = LOW.read_noise_v;
    other.pixel.dark_voltage_v_per_s /= 4.0;
    other.nonuniformity.dsnu_v /= 4.0;
    other.nonuniformity.hot_pixel_dark_voltage_v_per_s /= 4.0;
    let image = speckle(30, 40, 4.2e-6);
    let capture = |s: &Sensor, e: &Exposure| values(&s.capture(&image, e, NoiseMode::All, 3).unwrap());
    assert_eq!(capture(&s, &low()), capture(&other, &high()));
    assert_eq!(s.noise_variance(100.0, &low()).unwrap(), other.noise_variance(100.0, &high()).unwrap());
    let time =
        |s: &Sensor, e: &Exposure| AutoExposure::Mean { target: 0.2 }.exposure_time(s, &image, e).unwrap();
    assert!((time(&s, &low()) / time(&other, &high()) - 1.0).abs() < 1e-9);
}

#[test]
fn threads_windows_and_binning_keep_their_laws() {
    let image = speckle(30, 40, 4.2e-6);
    let mut s = noisy_sensor(20, 30);
    s.pixel.full_well_e = 30_000.0;
    let bright = Exposure { time_s: 0.2, ..combined() };
    let capture = |s: &Sensor, noise| values(&s.capture(&image, &bright, noise, 3).unwrap());
    for binning in [None, Some(Binning { side: 2, mode: BinningMode::Charge })] {
        s.binning = binning;
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let whole = pool(1).install(|| capture(&s, NoiseMode::All));
        assert_eq!(pool(5).install(|| capture(&s, NoiseMode::All)), whole);
        let window = Window { row: 2, col: 7, rows: 11, cols: 20 };
        let part = capture(&Sensor { window: Some(window), ..s.clone() }, NoiseMode::All);
        assert!(part.chunks_exact(20).enumerate().all(|(r, row)| row == &whole[(2 + r) * 30 + 7..][..20]));
        // An ideal capture differs from the numbers by their rounding.
        let ideal = s.capture_ideal(&image, &bright).unwrap().normalized();
        let raw = s.capture(&image, &bright, NoiseMode::None, 0).unwrap();
        let levels = s.raw_levels(&bright).unwrap();
        let step = 2.01 / (levels.white - levels.black) as f32;
        assert!(ideal.iter().zip(raw.normalized()).all(|(a, b)| (a - b).abs() <= step));
    }
    s.binning = Some(Binning { side: 2, mode: BinningMode::Digital });
    assert_eq!(s.capture(&image, &bright, NoiseMode::All, 3).unwrap_err(), SensorError::CombinedBinning);
    assert!(s.capture(&image, &low(), NoiseMode::All, 3).is_ok());
    let inverted = ConversionGain::Low(LowGain { conversion_gain_v_per_e: 2e-4, ..LOW });
    assert!(matches!(s.raw_levels(&exposure(inverted)), Err(SensorError::Parameter(_))));
}

fn described(change: impl FnOnce(&mut CameraDescription)) -> Result<Camera, CameraError> {
    let mut d = CameraDescription::default();
    (d.sensor.rows, d.sensor.cols) = (32, 32);
    d.sensor.pixel.full_well_e = 40_000.0;
    d.sensor.pixel.low_conversion_gain_uv_per_e = Some(50.0);
    d.sensor.pixel.low_gain_read_noise_e = Some(8.0);
    change(&mut d);
    Camera::new(d, WavelengthGrid::VISIBLE)
}

fn key(change: impl FnOnce(&mut CameraDescription)) -> (String, String) {
    match described(change) {
        Err(CameraError::Key { key, message }) => (key, message),
        other => panic!("expected an error about a key, got {other:?}"),
    }
}

#[test]
fn a_description_selects_the_gain() {
    let gain = |name| {
        let camera = described(|d| d.exposure.conversion_gain = name).unwrap();
        camera.gain_and_offset().conversion_gain
    };
    let low = LowGain { conversion_gain_v_per_e: 50.0 * 1e-6, read_noise_v: 8.0 * 50.0 * 1e-3 * 1e-3 };
    assert_eq!(gain(None), ConversionGain::High);
    assert_eq!(gain(Some(ConversionGainName::High)), ConversionGain::High);
    assert_eq!(gain(Some(ConversionGainName::Low)), ConversionGain::Low(low));
    assert_eq!(gain(Some(ConversionGainName::Combined)), ConversionGain::Combined(low));
    // A camera of one gain is not changed by keys of the other, and asks for it by name.
    let one = |d: &mut CameraDescription| {
        (d.sensor.pixel.low_conversion_gain_uv_per_e, d.sensor.pixel.low_gain_read_noise_e) = (None, None);
    };
    let (at, message) = key(|d| {
        one(d);
        d.exposure.conversion_gain = Some(ConversionGainName::Auto);
    });
    assert!(
        at == "exposure.conversion_gain" && message.contains("low_conversion_gain_uv_per_e"),
        "{message}"
    );
    let (at, _) = key(|d| d.sensor.pixel.low_conversion_gain_uv_per_e = None);
    assert_eq!(at, "sensor.pixel.low_gain_read_noise_e");
    let (at, message) = key(|d| d.sensor.pixel.low_conversion_gain_uv_per_e = Some(200.0));
    assert!(at == "sensor.pixel.low_conversion_gain_uv_per_e" && message.contains("less than"), "{message}");
    let (at, message) = key(|d| {
        d.exposure.conversion_gain = Some(ConversionGainName::Combined);
        d.sensor.cfa.pattern = PatternDescription::Name("quad-bayer".into());
        d.sensor.binning = Some(BinningDescription::Mode(BinningMode::Digital));
    });
    assert!(at == "exposure.conversion_gain" && message.contains("charge binning"), "{message}");
}

/// `auto` takes the high gain while it does not saturate, and the low gain in more light.
#[test]
fn the_high_gain_is_chosen_while_the_light_fits_it() {
    let camera = |name| {
        described(|d| {
            d.exposure.conversion_gain = Some(name);
            d.exposure.time_ms = Some(20.0);
        })
        .unwrap()
    };
    let auto = camera(ConversionGainName::Auto);
    let mut chosen = Vec::new();
    for luminance_cd_m2 in [5.0, 50.0, 500.0, 5000.0] {
        let setting = Setting { luminance_cd_m2, ..Setting::default() };
        let scene = scene::uniform(32, 32, &setting).unwrap();
        let image = auto.optics.image(&scene).unwrap();
        let exposure = auto.exposure(&image).unwrap();
        assert_eq!(auto.exposure_or(Some(0.02), &image).unwrap(), exposure);
        let at_high = camera(ConversionGainName::High);
        let raw =
            at_high.sensor.capture(&image, &at_high.exposure(&image).unwrap(), NoiseMode::None, 0).unwrap();
        let fits = raw.saturated_percent() <= 0.5;
        assert_eq!(exposure.conversion_gain == ConversionGain::High, fits, "{luminance_cd_m2} cd/m²");
        let pixels = PixelSpectra::new(&auto.sensor, &image).unwrap();
        assert_eq!(auto.exposure_gathered(&pixels).unwrap(), exposure);
        chosen.push(fits);
    }
    assert!(chosen[0] && !chosen[3], "{chosen:?}");
    // A pipeline is learned for one gain.
    let light = Illuminant::D65.photons(auto.grid()).unwrap();
    let settings = TrainingSettings::default();
    match auto.training_axes(&settings, &light) {
        Err(CameraError::Key { key, message }) => {
            assert!(key == "exposure.conversion_gain" && message.contains("combined"), "{message}");
        }
        other => panic!("expected an error about the gain, got {other:?}"),
    }
    let axes = camera(ConversionGainName::Combined).training_axes(&settings, &light).unwrap();
    assert!(axes.noise().above.is_some());
}

/// An offset moves black and saturation alike: the full well is as far above black at any offset, and a pixel beyond it reads as white.
#[test]
fn an_offset_moves_the_levels_and_not_their_distance() {
    for bits in [0, 12] {
        let mut s = device(8);
        s.adc = Adc { bits, black_level_dn: if bits == 0 { 0.0 } else { 64.0 } };
        for (offset, gain) in [(0.0, 1.0), (0.01, 1.0), (0.02, 0.5), (-0.002, 0.25)] {
            for (base, well_v) in [(low(), 30_000.0 * 25e-6), (combined(), 30_000.0 * 1e-4)] {
                let e = Exposure { analog_gain: gain, analog_offset_v: offset, ..base };
                let above = s.saturation_v(&e) - offset * gain;
                assert!((above - well_v * gain).abs() < 1e-9, "{e:?}: {above}");
                let levels = s.raw_levels(&e).unwrap();
                let full = values(&s.capture(&wide(photons_for(60_000.0)), &e, NoiseMode::None, 0).unwrap());
                // Numbers of the low gain are rounded before they are multiplied by the ratio of 4.
                let rounding = if bits == 0 { 1e-5 } else { 4.0 };
                assert!(
                    full.iter().all(|v| (f64::from(*v) - levels.white).abs() <= rounding),
                    "{e:?}: {} for {}",
                    full[0],
                    levels.white
                );
            }
        }
    }
}

/// The noise of normalised samples is that of volts, term by term: a polynomial of second order on both sides of the switch.
#[test]
fn noise_of_normalised_samples_is_that_of_volts() {
    for binning in [None, Some(BinningMode::Charge), Some(BinningMode::Digital)] {
        let mut s = device(20);
        s.pixel.dark_voltage_v_per_s = 0.05;
        (s.nonuniformity.prnu_fraction, s.nonuniformity.dsnu_v) = (0.01, 3e-4);
        (s.nonuniformity.row_noise_v, s.nonuniformity.column_noise_v) = (1e-4, 2e-4);
        s.binning = binning.map(|mode| Binning { side: 2, mode });
        // Binned samples are not combined.
        let gains = [high(), low(), combined()].into_iter().take(if binning.is_none() { 3 } else { 2 });
        for e in gains {
            let e = Exposure { analog_gain: 1.25, analog_offset_v: 0.02, ..e };
            let levels = s.raw_levels(&e).unwrap();
            let range_v = levels.white_v - levels.black_v;
            let noise = s.signal_noise(&e).unwrap();
            for signal in [0.0, 0.01, 0.1, 0.5, 0.9] {
                let electrons = signal * range_v / (s.volts_per_electron(&e) * e.analog_gain);
                let expected = s.noise_variance(electrons, &e).unwrap().total();
                let found = noise.variance(signal) * range_v * range_v;
                // Rounding.
                assert!(
                    (found / expected - 1.0).abs() < 1e-9,
                    "{binning:?} {e:?} {signal}: {found} for {expected}"
                );
            }
        }
    }
}

/// An offset of 0.1 V leaves the high gain 0.9 V, 9000 electrons: it is read up to 8550 of them.
#[test]
fn an_offset_moves_the_switch_of_the_noise() {
    let mut s = device(20);
    s.adc.black_level_dn = 0.0;
    let offset = |e: Exposure| Exposure { analog_offset_v: 0.1, ..e };
    let read = |electrons, e| s.noise_variance(electrons, &offset(e)).unwrap().read;
    for electrons in [0.0, 5000.0, 8400.0] {
        assert_eq!(read(electrons, combined()), read(electrons, high()));
    }
    for electrons in [8700.0, 9500.0, 20_000.0] {
        // On the scale of the high gain, which is four times the low one.
        assert!((read(electrons, combined()) / (16.0 * read(electrons, low())) - 1.0).abs() < 1e-12);
    }
}

/// Independent offsets of four photodiodes: of their sum four times the variance, of their mean a quarter.
#[test]
fn offsets_of_binned_photodiodes_add_or_average() {
    let mut s = device(20);
    s.nonuniformity.dsnu_v = 3e-4;
    for e in [high(), low()] {
        let single = s.noise_variance(0.0, &e).unwrap().dsnu;
        for (mode, share) in [(BinningMode::Charge, 4.0), (BinningMode::Digital, 0.25)] {
            let binned = Sensor { binning: Some(Binning { side: 2, mode }), ..s.clone() };
            let found = binned.noise_variance(0.0, &e).unwrap().dsnu;
            assert!((found / single - share).abs() < 1e-12, "{mode:?}: {found} for {single}");
        }
    }
}
