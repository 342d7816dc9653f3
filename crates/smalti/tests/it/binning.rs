//! Binning: noise against closed forms, energy, saturation of single photodiodes, and geometry.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use smalti::camera::description::{ArchitectureName, BinnedBlocks, BinningDescription, PatternDescription};
use smalti::camera::{Camera, CameraDescription, CameraError};
use smalti::metrics::photon_transfer::{FlatPair, photon_transfer};
use smalti::sensor::*;
use smalti::spectrum::WavelengthGrid;

use crate::sensor_kit::*;

const CHARGE: BinningMode = BinningMode::Charge;
const DIGITAL: BinningMode = BinningMode::Digital;

/// Samples of `side` × `side` photodiodes of 2.8 µm behind one clear filter.
fn binned(side: usize, mode: BinningMode, samples: usize) -> Sensor {
    let mut s = sensor(samples, samples);
    s.cfa = mono();
    s.pixel.pitch_m *= side as f64;
    s.binning = Some(Binning { side, mode });
    s
}

fn wide(photons: f32) -> smalti::optics::OpticalImage {
    flat(3, 3, 2e-2, photons)
}

/// The irradiance, photons s⁻¹ m⁻² nm⁻¹, that gives a number of electrons in each photodiode of [`binned`] in 10 ms.
fn photons_for(electrons: f64) -> f32 {
    (electrons / (310.0 * 0.5 * 2.8e-6 * 2.8e-6 * 0.01)) as f32
}

const TEN_MS: Exposure =
    Exposure { time_s: 0.01, analog_gain: 1.0, analog_offset_v: 0.0, conversion_gain: ConversionGain::High };

/// Noise of every kind but that of rows and columns, whose few values do not reach one percent.
fn noisy(side: usize, mode: BinningMode, samples: usize) -> Sensor {
    let mut s = binned(side, mode, samples);
    s.pixel.dark_voltage_v_per_s = 0.05;
    s.pixel.read_noise_v = 4e-4;
    s.nonuniformity.prnu_fraction = 0.03;
    s.nonuniformity.dsnu_v = 2e-4;
    s.pixel.voltage_swing_v = 4.0;
    s.adc = Adc { bits: 13, black_level_dn: 64.0 };
    s
}

/// Variance over the samples of several devices, V².
fn drawn_variance(s: &Sensor, electrons: f64, devices: u64) -> f64 {
    let mut all = Vec::new();
    for device in 0..devices {
        let mut s = s.clone();
        s.nonuniformity.device_serial = device;
        all.extend(values(
            &s.capture(&wide(photons_for(electrons)), &TEN_MS, NoiseMode::All, device).unwrap(),
        ));
    }
    let levels = s.raw_levels(&TEN_MS).unwrap();
    let volts_per_dn = (levels.white_v - levels.black_v) / (levels.white - levels.black);
    moments(&all).1 * volts_per_dn * volts_per_dn
}

/// The noise of a sample by the linear model of EMVA 1288, written out: shot noise of light and dark current of all photodiodes, the
/// read noise of each reading, PRNU and DSNU of all photodiodes, quantisation. The 360 000 samples have a standard error of 0.24 %.
#[test]
fn noise_of_binned_samples_is_that_of_theory_to_one_percent() {
    for (side, mode, samples) in [(2, CHARGE, 300), (2, DIGITAL, 300), (3, CHARGE, 300), (3, DIGITAL, 300)] {
        let s = noisy(side, mode, samples);
        let n = (side * side) as f64;
        for electrons in [0.0, 5.0, 400.0, 3000.0] {
            let (gain, dark_e) = (1e-4, 5.0);
            let mean_e = electrons + dark_e;
            let per_photodiode =
                gain * gain * (mean_e * (1.0 + 0.03f64.powi(2)) + (0.03 * mean_e).powi(2)) + 2e-4f64.powi(2);
            let lsb_v = 4.0 / 8192.0;
            let per_reading = 4e-4f64.powi(2) + lsb_v * lsb_v / 12.0;
            let theory = match mode {
                BinningMode::Charge => n * per_photodiode + per_reading,
                // The sum of nine numbers has 17 bits and is rounded to 16: to even numbers, with an error of 1/4.
                BinningMode::Digital if side == 3 => {
                    (per_photodiode + per_reading) / n + (lsb_v / 9.0).powi(2) / 4.0
                }
                BinningMode::Digital => (per_photodiode + per_reading) / n,
            };
            let model = s.noise_variance(n * electrons, &TEN_MS).unwrap().total();
            assert!((model / theory - 1.0).abs() < 1e-3, "{side} {mode:?} {electrons}: {model} for {theory}");
            let drawn = drawn_variance(&s, electrons, 4);
            assert!((drawn / theory - 1.0).abs() < 0.01, "{side} {mode:?} {electrons}: {drawn} for {theory}");
            // What learned pipelines take for the noise of normalised samples.
            let levels = s.raw_levels(&TEN_MS).unwrap();
            let range_v = levels.white_v - levels.black_v;
            let signal = n * electrons * s.volts_per_electron(&TEN_MS) / range_v;
            let of_signal = s.signal_noise(&TEN_MS).unwrap().variance(signal) * range_v * range_v;
            assert!((of_signal / theory - 1.0).abs() < 2e-3, "{side} {mode:?}: {of_signal} for {theory}");
        }
    }
}

/// In the dark, charge binning has one read noise and digital binning n² of them: in electrons of a sample, n times as much.
#[test]
fn digital_binning_has_n_squared_read_noises() {
    for side in [2, 3, 4] {
        let read_e = |mode| {
            let mut s = binned(side, mode, 200);
            s.pixel.read_noise_v = 4e-4;
            let volts = values(&s.capture(&wide(0.0), &TEN_MS, NoiseMode::All, 1).unwrap());
            let drawn = moments(&volts).1.sqrt() / s.volts_per_electron(&TEN_MS);
            assert!(
                (drawn / s.read_noise_e(&TEN_MS) - 1.0).abs() < 0.02,
                "{drawn} for {}",
                s.read_noise_e(&TEN_MS)
            );
            s.read_noise_e(&TEN_MS)
        };
        assert!((read_e(CHARGE) - 4.0).abs() < 1e-9);
        assert!((read_e(DIGITAL) - 4.0 * side as f64).abs() < 1e-9);
    }
}

/// Row and column noise come once per reading: digital binning averages those of the rows and columns of a sample.
#[test]
fn rows_and_columns_are_read_once_per_sample_or_once_per_pixel() {
    for (mode, share) in [(CHARGE, 1.0), (DIGITAL, 0.5)] {
        let mut s = binned(2, mode, 400);
        (s.nonuniformity.row_noise_v, s.nonuniformity.column_noise_v) = (1e-3, 2e-3);
        let model = s.noise_variance(0.0, &TEN_MS).unwrap();
        assert!((model.row / 1e-6 - share).abs() < 1e-12 && (model.column / 4e-6 - share).abs() < 1e-12);
        let volts = values(&s.capture(&wide(0.0), &TEN_MS, NoiseMode::All, 3).unwrap());
        let mean = |of: &dyn Fn(usize) -> usize| -> Vec<f32> {
            (0..400).map(|k| (0..400).map(|i| volts[of(k * 400 + i)]).sum::<f32>() / 400.0).collect()
        };
        let rows = moments(&mean(&|at| at)).1;
        let cols = moments(&mean(&|at| at % 400 * 400 + at / 400)).1;
        // 400 values: a standard error of 7 %.
        assert!(
            (rows / model.row - 1.0).abs() < 0.3 && (cols / model.column - 1.0).abs() < 0.3,
            "{rows} {cols}"
        );
    }
}

fn quad(mode: BinningMode) -> Sensor {
    Sensor { binning: Some(Binning { side: 2, mode }), ..noisy_sensor(24, 36) }
}

/// Digital binning is the mean of the unbinned capture of the same device, to the bit, with every kind of noise, defects and crosstalk;
/// with 12 bits it is their sum in 14.
#[test]
fn digital_binning_averages_the_capture_of_the_photodiodes() {
    let image = speckle(30, 40, 2.1e-6);
    let exposure = Exposure { analog_gain: 1.5, analog_offset_v: 2e-3, ..TEN_MS };
    for window in [None, Some(Window { row: 3, col: 5, rows: 19, cols: 21 })] {
        let mut s = quad(DIGITAL);
        s.window = window;
        let raw = s.capture(&image, &exposure, NoiseMode::All, 7).unwrap();
        let single = s.unbinned().capture(&image, &exposure, NoiseMode::All, 7).unwrap();
        assert_eq!((single.rows(), single.cols()), (2 * raw.rows(), 2 * raw.cols()));
        let (sums, all) = (values(&raw), values(&single));
        for (i, &sum) in sums.iter().enumerate() {
            let (r, c) = (i / raw.cols() * 2, i % raw.cols() * 2);
            let at = |r: usize, c: usize| all[r * single.cols() + c];
            assert_eq!(sum, at(r, c) + at(r, c + 1) + at(r + 1, c) + at(r + 1, c + 1));
        }
        assert_eq!(raw.black_level(), 4.0 * single.black_level());
        assert_eq!(raw.white_level(), 4.0 * single.white_level());
        assert_eq!(s.sample_bits(&TEN_MS), 14);
    }
}

/// The charge of a sample is the sum of its photodiodes in the unbinned capture of the same device: the same photons, dark electrons,
/// gains, offsets and defects.
#[test]
fn charge_binning_adds_the_electrons_of_the_photodiodes() {
    let image = speckle(30, 40, 2.1e-6);
    for noise in [NoiseMode::None, NoiseMode::PhotonOnly, NoiseMode::All] {
        let mut s = quad(CHARGE);
        s.adc = Adc::default();
        (s.pixel.read_noise_v, s.pixel.voltage_swing_v) = (0.0, 100.0);
        (s.nonuniformity.row_noise_v, s.nonuniformity.column_noise_v) = (0.0, 0.0);
        let sums = values(&s.capture(&image, &TEN_MS, noise, 7).unwrap());
        let all = values(&s.unbinned().capture(&image, &TEN_MS, noise, 7).unwrap());
        for (i, &sum) in sums.iter().enumerate() {
            let at = |dr: usize, dc: usize| all[(i / 36 * 2 + dr) * 72 + i % 36 * 2 + dc];
            let expected = at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1);
            assert!((sum - expected).abs() < 1e-6 * expected.abs().max(0.1), "{sum} for {expected}");
        }
    }
}

/// On a flat field, four photodiodes are one pixel of twice the pitch: four times the dark current and the full well, half the PRNU,
/// twice the DSNU.
#[test]
fn a_flat_field_is_that_of_the_large_pixel_with_four_apertures() {
    let s = noisy(2, CHARGE, 64);
    let mut large = Sensor { binning: None, ..s.clone() };
    large.pixel.full_well_e *= 4.0;
    large.pixel.dark_voltage_v_per_s *= 4.0;
    large.nonuniformity.prnu_fraction /= 2.0;
    large.nonuniformity.dsnu_v *= 2.0;
    let image = wide(photons_for(700.0));
    let volts = |s: &Sensor| s.expected_volts(&image, &TEN_MS).unwrap().data()[40 * 64 + 9];
    assert!((volts(&s) / volts(&large) - 1.0).abs() < 1e-5);
    let variance = |s: &Sensor| s.noise_variance(2800.0, &TEN_MS).unwrap();
    let (a, b) = (variance(&s), variance(&large));
    // The gain of a pixel scales its shot noise: PRNU enters once more, to second order.
    assert!((a.total() / b.total() - 1.0).abs() < 1e-3, "{a:?} {b:?}");
    assert_eq!(s.saturation_v(&TEN_MS), large.saturation_v(&TEN_MS));
    assert_eq!(s.raw_levels(&TEN_MS).unwrap(), large.raw_levels(&TEN_MS).unwrap());
    let rule = AutoExposure::Specular { fraction: 0.95 };
    let time = |s: &Sensor| rule.exposure_time(s, &image, &TEN_MS).unwrap();
    assert!((time(&s) / time(&large) - 1.0).abs() < 1e-9);
}

/// An edge through a sample: each photodiode is limited by its own full well before the sum.
#[test]
fn a_photodiode_saturates_alone() {
    for (mode, readings) in [(CHARGE, 1.0), (DIGITAL, 4.0)] {
        let mut s = binned(2, mode, 1);
        (s.pixel.fill_factor, s.pixel.voltage_swing_v) = (1.0, 10.0);
        // Photons on the left and the right photodiodes: three times the full well, and a tenth of it.
        let per_electron = 1.0 / (310.0 * 2.8e-6 * 2.8e-6 * 0.01);
        let (left, right) = (30_000.0 * per_electron, 1000.0 * per_electron);
        let data = (0..31).flat_map(|_| [left, right, left, right].map(|v| v as f32)).collect();
        let edge = image(2, 2, 2.8e-6, data);
        let expected = (2.0 * 10_000.0 + 2.0 * 1000.0) * 1e-4 / readings;
        let volts = f64::from(s.expected_volts(&edge, &TEN_MS).unwrap().data()[0]);
        assert!((volts / expected - 1.0).abs() < 1e-6, "{mode:?}: {volts} for {expected}");
        // A pixel of the same size without binning would hold all of them.
        assert!(volts < 0.36 * 62_000.0 * 1e-4 / readings);
        s.adc = Adc { bits: 12, black_level_dn: 100.0 };
        let ideal = s.capture_ideal(&edge, &TEN_MS).unwrap();
        let digital = s.capture(&edge, &TEN_MS, NoiseMode::None, 0).unwrap();
        let difference = ideal.normalized()[0] - digital.normalized()[0];
        // Half a step of the converter, whose range of 10 V has 410 steps below the full well.
        let white_steps = if mode == CHARGE { 1638.0 } else { 410.0 };
        assert!(difference.abs() < 0.51 / white_steps, "{mode:?}: {difference}");
        assert_eq!(digital.saturated_percent(), 0.0);
    }
}

/// With charge binning, the floating diffusion may hold less than the full wells.
#[test]
fn the_floating_diffusion_limits_the_sum() {
    let s = binned(2, CHARGE, 4);
    // 1 V at 100 µV/e⁻: 10 000 e⁻, the full well of one photodiode.
    assert_eq!(s.saturation_v(&TEN_MS), 1.0);
    let volts = s.expected_volts(&wide(photons_for(4000.0)), &TEN_MS).unwrap();
    assert!(volts.data().iter().all(|v| *v == 1.0));
    assert_eq!(binned(2, DIGITAL, 4).saturation_v(&TEN_MS), 1.0);
    let digital = binned(2, DIGITAL, 4).expected_volts(&wide(photons_for(4000.0)), &TEN_MS).unwrap();
    assert!(digital.data().iter().all(|v| (*v - 0.4).abs() < 1e-5));
}

#[test]
fn exposure_rules_keep_photodiodes_below_saturation() {
    let image = speckle(24, 24, 2.8e-6);
    for mode in [CHARGE, DIGITAL] {
        let mut s = binned(2, mode, 12);
        s.pixel.voltage_swing_v = 4.0;
        let none = AutoExposure::SaturatedShare { share: 0.0 }.exposure_time(&s, &image, &TEN_MS).unwrap();
        let most = |time_s: f64| {
            let volts = s.unbinned().expected_volts(&image, &Exposure::new(time_s)).unwrap();
            volts.data().iter().fold(0.0f32, |m, v| m.max(*v))
        };
        assert!(most(0.999 * none) < 0.9995 && most(1.001 * none) == 1.0, "{mode:?}: {}", most(none));
        let time_s = AutoExposure::Mean { target: 0.1 }.exposure_time(&s, &image, &TEN_MS).unwrap();
        let mut unlimited = s.clone();
        (unlimited.pixel.full_well_e, unlimited.pixel.voltage_swing_v) = (1e9, 900.0);
        let volts = unlimited.expected_volts(&image, &Exposure::new(time_s)).unwrap();
        let mean = moments(volts.data()).0;
        assert!((mean / (0.1 * s.saturation_v(&TEN_MS)) - 1.0).abs() < 1e-4, "{mode:?}: {mean}");
    }
}

#[test]
fn every_kind_of_light_gives_the_same_samples() {
    let image = speckle(30, 40, 2.1e-6);
    for mode in [CHARGE, DIGITAL] {
        for architecture in
            [ColorArchitecture::Mosaic, ColorArchitecture::Prism, ColorArchitecture::FieldSequential]
        {
            let mut s = quad(mode);
            s.architecture = architecture;
            let rates = ElectronRates::new(&s, &image).unwrap();
            let by_rates = s.capture((&rates, 1.0), &TEN_MS, NoiseMode::All, 3).unwrap();
            let with_pattern = rates.clone().with_pattern_of(&s);
            assert_eq!(s.capture((&with_pattern, 1.0), &TEN_MS, NoiseMode::All, 3).unwrap(), by_rates);
            let pixels = PixelSpectra::new(&s, &image).unwrap();
            assert_eq!((pixels.window().rows, pixels.window().cols), (48, 72));
            let ideal = s.capture_ideal(&image, &TEN_MS).unwrap().normalized();
            let by_pixels = s.capture_ideal(&pixels, &TEN_MS).unwrap().normalized();
            let by_rates = s.capture_ideal((&rates, 1.0), &TEN_MS).unwrap().normalized();
            for other in [by_pixels, by_rates] {
                assert!(ideal.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-5), "{mode:?}");
            }
        }
    }
}

#[test]
fn threads_and_windows_do_not_change_a_bit() {
    let image = speckle(30, 40, 2.1e-6);
    for mode in [CHARGE, DIGITAL] {
        let s = quad(mode);
        let capture = |s: &Sensor| values(&s.capture(&image, &TEN_MS, NoiseMode::All, 3).unwrap());
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let whole = pool(1).install(|| capture(&s));
        assert_eq!(pool(5).install(|| capture(&s)), whole);
        let window = Window { row: 2, col: 7, rows: 17, cols: 20 };
        let part = capture(&Sensor { window: Some(window), ..s.clone() });
        for (r, row) in part.chunks_exact(20).enumerate() {
            let at = (2 + r) * 36 + 7;
            assert_eq!(row, &whole[at..at + 20], "{mode:?} row {r}");
        }
    }
}

/// The photon transfer curve of EMVA 1288 finds the conversion gain, one read noise and the saturation of the sum.
#[test]
fn the_photon_transfer_curve_shows_one_reading_of_the_sum() {
    let mut s = noisy(2, CHARGE, 96);
    s.pixel.dark_voltage_v_per_s = 0.0;
    s.pixel.voltage_swing_v = 3.0;
    s.adc = Adc { bits: 14, black_level_dn: 256.0 };
    let frame = |electrons: f64, seed| {
        values(&s.capture(&wide(photons_for(electrons)), &TEN_MS, NoiseMode::All, seed).unwrap())
    };
    let frames: Vec<(f64, [Vec<f32>; 4])> = (1..=22)
        .map(|i: u32| {
            let (e, seed) = (f64::from(i) * 400.0, 10 * u64::from(i));
            (e, [frame(e, seed), frame(e, seed + 1), frame(0.0, seed + 2), frame(0.0, seed + 3)])
        })
        .collect();
    let pairs: Vec<FlatPair<'_>> = frames
        .iter()
        .map(|(e, [a, b, c, d])| FlatPair { exposure: *e, bright: [a, b], dark: [c, d] })
        .collect();
    let found = photon_transfer(&pairs, None, 1.0).unwrap();
    let gain = found.conversion_gain_v_per_e(3.0 / 16384.0);
    assert!((gain / 1e-4 - 1.0).abs() < 0.01, "{gain}");
    assert!((found.dark_noise_e / 4.0 - 1.0).abs() < 0.02, "{}", found.dark_noise_e);
    // The swing of 3 V holds 29 531 e⁻ above the black level; the four full wells hold 40 000.
    assert!((found.full_well_e.unwrap() / 29_531.0 - 1.0).abs() < 0.01, "{found:?}");
}

fn described(change: impl FnOnce(&mut CameraDescription)) -> Result<Camera, CameraError> {
    let mut d = CameraDescription::default();
    (d.sensor.rows, d.sensor.cols) = (48, 64);
    d.sensor.cfa.pattern = PatternDescription::Name("quad-bayer".into());
    d.sensor.binning = Some(BinningDescription::Mode(CHARGE));
    change(&mut d);
    Camera::new(d, WavelengthGrid::VISIBLE)
}

#[test]
fn a_description_states_single_pixels_and_gives_samples() {
    let camera = described(|_| {}).unwrap();
    let s = &camera.sensor;
    assert_eq!((s.rows, s.cols, s.binning), (24, 32, Some(Binning { side: 2, mode: CHARGE })));
    assert!((s.pixel.pitch_m - 4.4e-6).abs() < 1e-18);
    assert_eq!(camera.description().sensor.sample_pitch_um(), Some(4.4));
    assert_eq!((s.cfa.mosaic().rows(), s.cfa.mosaic().cols(), s.cfa.channels().len()), (2, 2, 3));
    let single = described(|d| d.sensor.binning = None).unwrap();
    let unbinned = s.unbinned();
    assert_eq!((unbinned.rows, unbinned.cols), (48, 64));
    assert_eq!(unbinned.cfa.mosaic(), single.sensor.cfa.mosaic());
    // The photodiodes of both cover the same field of view.
    let deg = |c: &Camera, cols| c.field_of_view_deg(cols, 1.0).unwrap();
    assert!((deg(&camera, 32) - deg(&single, 64)).abs() < 1e-9);
    for (pattern, side) in [("nona", 3), ("rgbw-sony", 0), ("quad-bayer", 2)] {
        let found = described(|d| {
            d.sensor.cfa.pattern = PatternDescription::Name(pattern.into());
            (d.sensor.rows, d.sensor.cols) = (48, 96);
        });
        assert_eq!(found.map_or(0, |c| c.sensor.binning_side()), side, "{pattern}");
    }
}

#[test]
fn an_impossible_binning_names_its_key_and_what_would_mend_it() {
    let wrong = |change: fn(&mut CameraDescription)| match described(change) {
        Err(CameraError::Key { key, message }) => (key, message),
        other => panic!("expected an error about a key, got {other:?}"),
    };
    let blocks = |side| Some(BinningDescription::Blocks(BinnedBlocks { side, mode: CHARGE }));
    let (key, message) = wrong(|d| d.sensor.cfa.pattern = PatternDescription::Name("bayer".into()));
    assert!(key == "sensor.binning" && message.contains("quad-bayer"), "{message}");
    let (key, message) = wrong(|d| d.sensor.rows = 47);
    assert!(key == "sensor.rows" && message.contains("46"), "{message}");
    let (key, message) = wrong(|d| d.sensor.architecture = ArchitectureName::Prism);
    assert!(key == "sensor.binning" && message.contains("side = 2"), "{message}");
    for (side, at, mend) in [(3, "sensor.binning", "side of 2"), (1, "sensor.binning.side", "2 to 8")] {
        match described(|d| (d.sensor.binning, d.sensor.rows, d.sensor.cols) = (blocks(side), 48, 96)) {
            Err(CameraError::Key { key, message }) => {
                assert!(key == at && message.contains(mend), "{message}")
            }
            other => panic!("expected an error about a key, got {other:?}"),
        }
    }
    // A single filter has blocks of any side, and a prism has no mosaic.
    let mono = described(|d| {
        d.sensor.cfa.pattern = PatternDescription::Letters(vec!["G".into()]);
        d.sensor.cfa.filters.insert("G".into(), Filter::Flat(1.0));
        d.sensor.binning = blocks(4);
    });
    assert_eq!(mono.unwrap().sensor.rows, 12);
    assert!(
        described(|d| (d.sensor.architecture, d.sensor.binning) = (ArchitectureName::Prism, blocks(2)))
            .is_ok()
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any tile, any side: the photodiodes of a sample have its channel, and binning reverses the division into blocks.
    #[test]
    fn blocks_of_any_tile_are_binned(
        (rows, cols) in (1usize..6, 1usize..6),
        cells in prop::collection::vec(0u8..3, 25),
        side in 2usize..6,
        (first_row, first_col) in (0usize..9, 0usize..9),
    ) {
        let mut cells: Vec<u8> = cells[..rows * cols].to_vec();
        // Every channel below the largest occurs.
        let mut used: Vec<u8> = cells.clone();
        used.sort_unstable();
        used.dedup();
        cells.iter_mut().for_each(|c| *c = used.iter().position(|u| u == c).unwrap() as u8);
        let samples = Mosaic::new(rows, cols, cells.clone()).unwrap();
        let channel = |c: usize| Channel {
            name: c.to_string(),
            transmittance: smalti::spectrum::Spectrum::constant(GRID, 1.0).unwrap(),
        };
        let cfa = Cfa::new("any", samples.clone(), (0..used.len()).map(channel).collect()).unwrap();
        let mut s = sensor(20, 20);
        s.cfa = cfa;
        s.binning = Some(Binning { side, mode: CHARGE });
        s.window = Some(Window { row: first_row, col: first_col, rows: 11, cols: 7 });
        let fine = s.unbinned();
        let (Sampling::Mosaic(binned), Sampling::Mosaic(photodiodes)) = (s.sampling(), fine.sampling()) else {
            panic!("both have a mosaic")
        };
        for r in 0..11 * side {
            for c in 0..7 * side {
                prop_assert_eq!(photodiodes.channel_at(r, c), binned.channel_at(r / side, c / side));
            }
        }
        let again = fine.cfa.mosaic().binned(side).unwrap();
        for r in 0..12 {
            for c in 0..12 {
                prop_assert_eq!(again.channel_at(r, c), samples.channel_at(r, c));
            }
        }
        prop_assert!(fine.cfa.mosaic().block_side(64).is_some_and(|found| found >= side || found.is_multiple_of(side)));
        // A tile of several channels has no blocks that are larger than its own.
        prop_assert_eq!(samples.binned(rows.max(cols) * 2).is_some(), used.len() == 1);
        prop_assert!(s.validate().is_ok());
    }
}

/// Each reading ends at the last number of the converter, which lies below the swing by the black level, before the mean is taken.
#[test]
fn readings_are_limited_before_their_mean() {
    let mut s = binned(2, DIGITAL, 1);
    (s.pixel.fill_factor, s.pixel.full_well_e) = (1.0, 1e6);
    s.adc = Adc { bits: 12, black_level_dn: 1024.0 };
    let per_electron = 1.0 / (310.0 * 2.8e-6 * 2.8e-6 * 0.01);
    // The swing of 1 V has 10 000 e⁻, and the numbers above black have three quarters of it.
    let (left, right) = (30_000.0 * per_electron, 1500.0 * per_electron);
    let data = (0..31).flat_map(|_| [left, right, left, right].map(|v| v as f32)).collect();
    let edge = image(2, 2, 2.8e-6, data);
    let ideal = s.capture_ideal(&edge, &TEN_MS).unwrap().normalized()[0];
    let white_e = (4095.0 - 1024.0) / 4096.0 * 10_000.0;
    let expected = (2.0 + 2.0 * 1500.0 / white_e) / 4.0;
    assert!((f64::from(ideal) - expected).abs() < 1e-5, "{ideal} for {expected}");
    let digital = s.capture(&edge, &TEN_MS, NoiseMode::None, 0).unwrap().normalized()[0];
    // Half a step of the converter.
    assert!((ideal - digital).abs() < 0.51 / 3071.0, "{ideal} {digital}");
}

/// Gain and offset act on the charge of a sample as on that of a large pixel, and noise before them is amplified.
#[test]
fn gain_and_offset_act_on_the_sum() {
    let s = binned(2, CHARGE, 6);
    let mut large = Sensor { binning: None, ..s.clone() };
    large.pixel.full_well_e *= 4.0;
    let image = wide(photons_for(400.0));
    for (analog_gain, analog_offset_v) in [(1.0, 0.0), (2.5, 0.0), (0.4, 0.05), (4.0, -0.01), (9.0, 0.0)] {
        let exposure = Exposure { analog_gain, analog_offset_v, ..TEN_MS };
        let volts = |s: &Sensor| f64::from(s.expected_volts(&image, &exposure).unwrap().data()[7]);
        let expected = ((0.16 + analog_offset_v) * analog_gain).min(1.0);
        for found in [volts(&s), volts(&large)] {
            assert!((found / expected - 1.0).abs() < 1e-5, "gain {analog_gain}: {found} for {expected}");
        }
    }
    let mut noisy = binned(2, CHARGE, 100);
    noisy.pixel.read_noise_v = 1e-3;
    let exposure = Exposure { analog_gain: 3.0, analog_offset_v: 0.1, ..TEN_MS };
    let volts = values(&noisy.capture(&wide(0.0), &exposure, NoiseMode::All, 3).unwrap());
    let (mean, variance) = moments(&volts);
    // 10 000 samples: a standard error of 1.4 % of the variance.
    assert!((mean - 0.3).abs() < 2e-4 && (variance / 9e-6 - 1.0).abs() < 0.06, "{mean} {variance}");
}
