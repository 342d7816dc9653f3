//! Noise against closed forms and against the reference values of ISETCam.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use crate::sensor_kit;

use sensor_kit::reference::*;
use sensor_kit::*;
use smalti::sensor::*;
use smalti::spectrum::Spectrum;

/// The sensor of the reference values.
fn reference_sensor(rows: usize, cols: usize) -> Sensor {
    let filter = |i: usize| Spectrum::new(GRID, NIKON_D100[i].to_vec()).unwrap();
    let mut s = Sensor::new(
        rows,
        cols,
        pixel(),
        bayer([filter(0), filter(1), filter(2)]),
        Spectrum::constant(GRID, 1.0).unwrap(),
    );
    (s.pixel.dark_voltage_v_per_s, s.pixel.read_noise_v) = (1e-3, 1e-3);
    s
}

/// A flat image larger than the sensor.
fn wide(photons: f32) -> smalti::optics::OpticalImage {
    flat(3, 3, 1e-3, photons)
}

#[test]
fn noise_free_volts_and_numbers_are_those_of_isetcam() {
    let mut s = reference_sensor(6, 6);
    let image = flat_spectrum(9, 9, 3.5e-6, &IRRADIANCE);
    let volts = s.expected_volts(&image, &Exposure::new(0.01)).unwrap();
    for (i, v) in volts.data().iter().enumerate() {
        let expected = VOLTS_10_MS[s.cfa.mosaic().channel_at(i / 6, i % 6)];
        // The irradiance is that of the middle of the field, ISETCam's volts are means over the sensor: the tails of
        // the PSF take 1e-4 of the light over the edge of the field.
        assert!((f64::from(*v) / expected - 1.0).abs() < 2e-4, "{v} for {expected}");
    }
    for (time_s, cases) in [(0.01, NUMBERS_10_MS), (0.04, NUMBERS_40_MS)] {
        for (bits, expected) in cases {
            s.adc.bits = bits;
            let raw = s.capture(&image, &Exposure::new(time_s), NoiseMode::None, 0).unwrap();
            for (c, number) in expected.iter().enumerate() {
                assert!(of_channel(&s, &values(&raw), c).iter().all(|v| *v == f32::from(*number)));
            }
        }
    }
}

#[test]
fn automatic_exposure_is_isetcams_less_the_noise_in_it() {
    let s = reference_sensor(146, 146);
    let image = flat_spectrum(9, 9, 1e-3, &IRRADIANCE);
    let time =
        AutoExposure::Specular { fraction: 0.95 }.exposure_time(&s, &image, &Exposure::new(0.0)).unwrap();
    // ISETCam leaves read noise on: it divides by the largest of 128 green pixels of a block of 8×8 tiles, whose
    // mean lies 2.6 standard deviations (1 mV) above the signal.
    let signal_v = 0.95 / time;
    assert!((0.95 / (signal_v + 2.6e-3) / AUTO_EXPOSURE_S - 1.0).abs() < 3e-4, "{time}");
    let e = Exposure { time_s: time, ..Exposure::new(0.0) };
    let peak = s.expected_volts(&image, &e).unwrap().data().iter().fold(0.0f32, |m, v| m.max(*v));
    assert!((f64::from(peak) + 1e-3 * time - 0.95).abs() < 1e-5);
}

#[test]
fn automatic_exposure_reaches_its_targets() {
    let mut s = sensor(40, 60);
    let image = speckle(30, 40, 4.2e-6);
    let base = Exposure { analog_gain: 2.0, analog_offset_v: 0.01, ..Exposure::new(0.0) };
    for architecture in [ColorArchitecture::Mosaic, ColorArchitecture::FieldSequential] {
        s.architecture = architecture;
        let time_s = AutoExposure::Mean { target: 0.18 }.exposure_time(&s, &image, &base).unwrap();
        let volts = s.expected_volts(&image, &Exposure { time_s, ..base }).unwrap();
        let mean = moments(volts.data()).0 - 0.02;
        assert!((mean / (1.0 - 0.02) - 0.18).abs() < 1e-4, "{mean}");
    }
    s.architecture = ColorArchitecture::Mosaic;
    // At the time of the rule a tenth of the samples saturates, and after a little longer more than a tenth.
    let rule = AutoExposure::SaturatedShare { share: 0.1 };
    let longest_s = rule.exposure_time(&s, &image, &base).unwrap();
    let saturated = |time_s: f64| {
        let volts = s.expected_volts(&image, &Exposure { time_s, ..base }).unwrap();
        volts.data().iter().filter(|v| f64::from(**v) >= s.saturation_v(&base) - 1e-6).count() as f64
            / volts.data().len() as f64
    };
    assert!(saturated(0.999 * longest_s) <= 0.1, "{}", saturated(0.999 * longest_s));
    assert!(saturated(1.01 * longest_s) > 0.1, "{}", saturated(1.01 * longest_s));
    let none = AutoExposure::SaturatedShare { share: 0.0 }.exposure_time(&s, &image, &base).unwrap();
    assert!(saturated(0.999 * none) == 0.0 && none < longest_s);
    let dark = rule.exposure_time(&s, &wide(0.0), &base);
    assert_eq!(dark, Err(SensorError::NoLight));
    let wrong = AutoExposure::SaturatedShare { share: 1.0 }.exposure_time(&s, &image, &base);
    assert!(matches!(wrong, Err(SensorError::Parameter(e)) if e.name == "share"));
    let at = |percentile| {
        AutoExposure::LuminancePercentile { percentile, target: 0.95 }
            .exposure_time(&s, &image, &base)
            .unwrap()
    };
    assert!(at(100.0) < at(50.0));
    let specular = AutoExposure::Specular { fraction: 0.95 };
    assert_eq!(at(100.0), specular.exposure_time(&s, &image, &base).unwrap());
    assert_eq!(specular.exposure_time(&s, &wide(0.0), &base), Err(SensorError::NoLight));
    let wrong = AutoExposure::Mean { target: 1.5 }.exposure_time(&s, &image, &base);
    assert!(matches!(wrong, Err(SensorError::Parameter(e)) if e.name == "target"));
}

/// The converter ends below the swing by its black level, where captures, exposure rules and predictions saturate alike.
#[test]
fn the_converter_ends_below_the_swing_by_its_black_level() {
    let image = speckle(30, 40, 4.2e-6);
    let exposure = Exposure::new(0.0);
    for black in [0.0, 64.0, 200.0] {
        let mut s = sensor(40, 60);
        s.pixel.full_well_e = 20_000.0;
        s.adc = Adc { bits: 10, black_level_dn: black };
        let electrons = (1023.0 - black) / 1024.0 * 10_000.0;
        assert!((s.saturation_e(&exposure) - electrons).abs() < 1e-6, "{}", s.saturation_e(&exposure));
        let levels = s.raw_levels(&exposure).unwrap();
        assert!((s.saturation_v(&exposure) - levels.white_v).abs() < 1e-9 && levels.white == 1023.0);
        for share in [0.0, 0.1] {
            let rule = AutoExposure::SaturatedShare { share };
            let longest_s = rule.exposure_time(&s, &image, &exposure).unwrap();
            let saturated = |factor: f64| {
                let longer = Exposure::new(factor * longest_s);
                s.capture(&image, &longer, NoiseMode::None, 0).unwrap().saturated_percent() / 100.0
            };
            // Numbers are rounded: half a step of 1024.
            assert!(saturated(0.998) <= share, "black {black}, {share}: {}", saturated(0.998));
            assert!(saturated(1.01) > share, "black {black}, {share}: {}", saturated(1.01));
        }
    }
}

/// Mean and variance with all noise, 8 frames as in the reference: mean within 4 standard errors, variance within
/// 2 % of `(v + dark·t)·gain + read²` (42 632 pixels of R and B: standard error 0.7 %).
#[test]
fn noise_has_the_mean_and_variance_of_the_closed_form() {
    let s = reference_sensor(146, 146);
    let image = flat_spectrum(3, 3, 1e-3, &IRRADIANCE);
    let mut all: [Vec<f32>; 3] = Default::default();
    for seed in 0..8 {
        let raw = s.capture(&image, &Exposure::new(0.01), NoiseMode::All, seed).unwrap();
        (0..3).for_each(|c| all[c].extend(of_channel(&s, &values(&raw), c)));
    }
    for (values, v) in all.iter().zip(VOLTS_10_MS) {
        let expected = (v + 1e-5) * 1e-4 + 1e-6;
        let (mean, variance) = moments(values);
        assert!((mean - v - 1e-5).abs() < 4.0 * (expected / values.len() as f64).sqrt(), "{mean} for {v}");
        assert!((variance / expected - 1.0).abs() < 0.02, "{variance} for {expected}");
        let model = s.noise_variance(v / 1e-4, &Exposure::new(0.01)).unwrap();
        assert!((model.total() / expected - 1.0).abs() < 1e-12);
    }
}

/// Photon transfer: variance grows with the mean at the slope of the gain, from nearly no light to half the well.
#[test]
fn photon_transfer_has_the_slope_of_the_gain() {
    let mut s = sensor(200, 200);
    s.cfa = mono();
    let per_photon = 300.0 * 0.5 * 2.8e-6 * 2.8e-6 * 310.0 / 300.0 * 0.01;
    for electrons in [0.02, 1.0, 8.0, 30.0, 1000.0, 5000.0] {
        let raw = s
            .capture(&wide((electrons / per_photon) as f32), &Exposure::new(0.01), NoiseMode::PhotonOnly, 1)
            .unwrap();
        let (mean, variance) = moments(&values(&raw));
        let n = 200.0f64 * 200.0;
        assert!((mean / 1e-4 - electrons).abs() < 4.0 * (electrons / n).sqrt(), "{mean} for {electrons}");
        // Standard error of a Poisson variance: √((λ + 2λ²)/n).
        let se = ((electrons + 2.0 * electrons * electrons) / n).sqrt();
        assert!((variance / 1e-8 - electrons).abs() < 4.0 * se, "{variance} for {electrons}");
    }
}

/// Every term on: many frames of one device, temporal and spatial variance as predicted.
#[test]
fn every_term_has_the_variance_it_should() {
    const FRAMES: usize = 24;
    let n = 96;
    let mut s = sensor(n, n);
    s.cfa = mono();
    s.pixel.dark_voltage_v_per_s = 0.2;
    s.pixel.read_noise_v = 1.5e-3;
    s.nonuniformity = NonUniformity {
        prnu_fraction: 0.02,
        dsnu_v: 4e-3,
        row_noise_v: 1e-3,
        column_noise_v: 1e-3,
        device_serial: 9,
        ..NonUniformity::default()
    };
    s.adc = Adc { bits: 10, black_level_dn: 32.0 };
    let e = Exposure { analog_gain: 1.7, analog_offset_v: 0.0, ..Exposure::new(0.05) };
    let image = wide(1e13);
    let electrons = f64::from(s.expected_volts(&image, &e).unwrap().data()[0]) / 1.7 / 1e-4;
    let model = s.noise_variance(electrons, &e).unwrap();
    let frames: Vec<Vec<f32>> =
        (0..FRAMES).map(|i| values(&s.capture(&image, &e, NoiseMode::All, i as u64).unwrap())).collect();
    let (mut temporal, mut averages) = (0.0, Vec::new());
    for i in 0..n * n {
        let (mean, variance) = moments(&frames.iter().map(|f| f[i]).collect::<Vec<_>>());
        temporal += variance / (n * n) as f64;
        averages.push(mean as f32);
    }
    let lsb = 1.0 / 1024.0;
    // Row noise is common to a row: 96 rows × 24 frames of it leave 3 % of a term that is a tenth.
    assert!((temporal * lsb * lsb / model.temporal() - 1.0).abs() < 0.02, "{temporal} {model:?}");
    let (mean, variance) = moments(&averages);
    let expected_mean = ((electrons + 0.2 * 0.05 / 1e-4) * 1e-4 * 1.7) * 1024.0 + 32.0;
    assert!((mean / expected_mean - 1.0).abs() < 2e-3, "{mean} for {expected_mean}");
    // Averaging leaves 1/24 of the temporal variance; 9216 pixels give 1.5 %, the 96 columns' share 15 % of a
    // twentieth.
    let spatial = variance * lsb * lsb - temporal * lsb * lsb / FRAMES as f64;
    assert!((spatial / model.spatial() - 1.0).abs() < 0.05, "{spatial} {model:?}");
}

/// The gain of a pixel scales its shot noise: with a PRNU of 30 %, the mean variance is 9 % larger, predicted and drawn.
#[test]
fn prnu_scales_shot_noise() {
    const FRAMES: u64 = 24;
    let n = 96;
    let mut s = sensor(n, n);
    s.cfa = mono();
    s.nonuniformity = NonUniformity { prnu_fraction: 0.3, device_serial: 4, ..NonUniformity::default() };
    let (image, e) = (wide(1e13), Exposure::new(0.01));
    let electrons = f64::from(s.expected_volts(&image, &e).unwrap().data()[0]) / 1e-4;
    let photon_v2 = s.noise_variance(electrons, &e).unwrap().photon;
    let without_v2 = electrons * 1e-8;
    assert!((photon_v2 / without_v2 - 1.09).abs() < 1e-9, "{photon_v2} for {without_v2}");
    let frames: Vec<Vec<f32>> =
        (0..FRAMES).map(|seed| values(&s.capture(&image, &e, NoiseMode::All, seed).unwrap())).collect();
    let of_pixel = |i: usize| moments(&frames.iter().map(|f| f[i]).collect::<Vec<_>>()).1;
    let temporal_v2 = (0..n * n).map(of_pixel).sum::<f64>() / (n * n) as f64;
    // Standard errors: 0.3 % of the variances of 9216 pixels in 24 frames, 0.6 % of the mean of their squared gains.
    assert!((temporal_v2 / photon_v2 - 1.0).abs() < 0.025, "{temporal_v2} for {photon_v2}");
}

#[test]
fn the_pattern_belongs_to_the_device() {
    let mut s = sensor(64, 64);
    s.nonuniformity =
        NonUniformity { dsnu_v: 5e-3, column_noise_v: 1e-3, device_serial: 1, ..NonUniformity::default() };
    let bias =
        |s: &Sensor, seed| values(&s.capture(&wide(0.0), &Exposure::new(0.0), NoiseMode::All, seed).unwrap());
    assert_eq!(bias(&s, 1), bias(&s, 2));
    let first = bias(&s, 1);
    s.nonuniformity.device_serial = 2;
    let second = bias(&s, 1);
    let product: f64 = first.iter().zip(&second).map(|(a, b)| f64::from(a * b)).sum();
    assert!((product / 4096.0).abs() < 4.0 * 26e-6 / 64.0, "patterns of two devices are correlated");
    // Read noise is drawn anew.
    s.pixel.read_noise_v = 1e-3;
    assert_ne!(bias(&s, 1), bias(&s, 2));
    assert_eq!(bias(&s, 1), bias(&s, 1));
}

#[test]
fn defects_come_in_their_proportion() {
    let mut s = sensor(200, 200);
    s.cfa = mono();
    s.nonuniformity =
        NonUniformity { dead_pixel_fraction: 0.02, hot_pixel_fraction: 0.03, ..NonUniformity::default() };
    s.dark_temperature =
        Some(DarkCurrentTemperature::Doubling { temperature_k: 308.0, reference_k: 300.0, interval_k: 8.0 });
    s.nonuniformity.hot_pixel_dark_voltage_v_per_s = 20.0;
    let volts = values(&s.capture(&wide(1e13), &Exposure::new(0.01), NoiseMode::All, 1).unwrap());
    let light = f64::from(s.expected_volts(&wide(1e13), &Exposure::new(0.01)).unwrap().data()[0]);
    let count =
        |low: f64, high: f64| volts.iter().filter(|v| (low..=high).contains(&f64::from(**v))).count() as f64;
    // Four standard errors of the binomial. Hot: 20 V/s, doubled by temperature, for 10 ms.
    assert!((count(0.0, 0.0) - 800.0).abs() < 4.0 * 28.0);
    assert!((count(light + 0.36, light + 0.44) - 1200.0).abs() < 4.0 * 34.0);
    assert_eq!(count(0.0, 1.0), 40_000.0);
}

#[test]
fn crosstalk_leaves_poisson_noise_uncorrelated() {
    let mut s = sensor(300, 300);
    s.cfa = mono();
    s.crosstalk = Some([[0.02, 0.05, 0.02], [0.05, 0.72, 0.05], [0.02, 0.05, 0.02]]);
    let raw = s.capture(&wide(3e12), &Exposure::new(0.01), NoiseMode::PhotonOnly, 1).unwrap();
    let v = values(&raw);
    let (mean, variance) = moments(&v);
    assert!((variance / (mean * 1e-4) - 1.0).abs() < 4.0 * (2.0f64 / 9e4).sqrt());
    let covariance: f64 =
        v.windows(2).map(|w| (f64::from(w[0]) - mean) * (f64::from(w[1]) - mean)).sum::<f64>() / 9e4;
    assert!((covariance / variance).abs() < 4.0 / 300.0);
}

#[test]
fn noise_below_zero_survives_a_black_level_and_light_saturates_at_white() {
    let mut s = sensor(100, 100);
    s.pixel.read_noise_v = 2e-3;
    s.adc = Adc { bits: 12, black_level_dn: 64.0 };
    let dark = s.capture(&wide(0.0), &Exposure::new(0.01), NoiseMode::All, 1).unwrap();
    let (mean, variance) = moments(&values(&dark));
    let read_dn = 2e-3 * 4096.0;
    assert!((mean - 64.0).abs() < 4.0 * read_dn / 100.0);
    assert!((variance / (read_dn * read_dn + 1.0 / 12.0) - 1.0).abs() < 0.06);
    assert_eq!((dark.black_level(), dark.white_level()), (64.0, 4095.0));
    let bright = s.capture(&wide(1e18), &Exposure::new(0.01), NoiseMode::All, 1).unwrap();
    assert!(values(&bright).iter().all(|v| *v == 4095.0));
    assert!(bright.normalized().iter().all(|v| *v == 1.0));

    // A gain that leaves the converter unused: saturation is where the well is full.
    s.pixel.read_noise_v = 0.0;
    let e = Exposure { analog_gain: 0.25, analog_offset_v: 0.04, ..Exposure::new(0.01) };
    let bright = s.capture(&wide(1e18), &e, NoiseMode::All, 1).unwrap();
    assert!((bright.black_level() - 104.96).abs() < 1e-9);
    assert_eq!(bright.white_level(), 1129.0);
    assert!(values(&bright).iter().all(|v| *v == 1129.0));
}
