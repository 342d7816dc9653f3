//! Laws that a sensor obeys, whatever the numbers.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use crate::sensor_kit;

use proptest::prelude::*;
use sensor_kit::*;
use smalti::numeric::{Planes, Rect};
use smalti::sensor::*;
use smalti::spectrum::{SpectralCube, Spectrum, SpectrumError, WavelengthGrid};

#[test]
fn a_flat_field_stays_flat_and_collects_irradiance_times_area_times_time() {
    for (spacing, fill) in [(0.37e-6, 0.5), (2.8e-6, 1.0), (9.1e-6, 0.3)] {
        for aperture in [Aperture::Area, Aperture::Point] {
            let mut s = sensor(20, 30);
            s.pixel.fill_factor = fill;
            s.aperture = aperture;
            let n = (40.0 * 2.8e-6 / spacing) as usize + 2;
            let image = flat(n, n + 3, spacing, 1e14);
            let volts = s.expected_volts(&image, &Exposure::new(0.01)).unwrap();
            for (i, v) in volts.plane(0).unwrap().iter().enumerate() {
                let channel = s.cfa.mosaic().channel_at(i / 30, i % 30);
                let responsivity =
                    s.spectral_responsivity_on(WavelengthGrid::VISIBLE).unwrap()[channel].integral();
                let expected = 1e14 * responsivity * fill * 2.8e-6 * 2.8e-6 * 0.01 * 1e-4;
                // Single precision sums over 31 wavelengths and the photodetector.
                assert!((f64::from(*v) / expected - 1.0).abs() < 3e-6, "{v} for {expected}");
            }
        }
    }
}

/// With full fill factor every photon of the image is collected once, whatever the ratio of pitch to spacing.
#[test]
fn pixels_lose_no_light() {
    for spacing in [0.9e-6, 2.8e-6, 4.3e-6] {
        let mut s = sensor(64, 64);
        s.cfa = mono();
        s.pixel.fill_factor = 1.0;
        s.pixel.full_well_e = 1e6;
        s.pixel.voltage_swing_v = 100.0;
        let image = speckle(24, 20, spacing);
        let volts = s.expected_volts(&image, &Exposure::new(0.01)).unwrap();
        let got: f64 = volts.plane(0).unwrap().iter().map(|&v| f64::from(v)).sum();
        let photons: f64 = image.irradiance().planes().data().iter().map(|&v| f64::from(v)).sum();
        let expected = photons * 10.0 * spacing * spacing * 0.01 * 1e-4;
        assert!((got / expected - 1.0).abs() < 1e-5, "{got} for {expected}");
    }
}

#[test]
fn crosstalk_keeps_a_flat_field_and_moves_light_the_way_it_says() {
    let kernel = [[0.0, 0.02, 0.0], [0.03, 0.9, 0.05], [0.0, 0.0, 0.0]];
    let mut s = sensor(16, 16);
    s.cfa = mono();
    let image = flat(200, 200, 0.5e-6, 1e14);
    let without = s.expected_volts(&image, &Exposure::new(0.01)).unwrap();
    s.crosstalk = Some(kernel);
    let with = s.expected_volts(&image, &Exposure::new(0.01)).unwrap();
    assert!(without.data().iter().zip(with.data()).all(|(a, b)| (a / b - 1.0).abs() < 1e-6));

    // One lit pixel: a sample as large as the pixel, in the middle of an odd sensor.
    (s.rows, s.cols, s.pixel.fill_factor) = (5, 5, 1.0);
    let lit = flat(1, 1, 2.8e-6, 1e14);
    let volts = s.expected_volts(&lit, &Exposure::new(0.01)).unwrap();
    let total: f32 = volts.data().iter().sum();
    for (i, row) in kernel.iter().enumerate() {
        for (j, k) in row.iter().enumerate() {
            let share = volts.plane(0).unwrap()[(1 + i) * 5 + 1 + j] / total;
            assert!((f64::from(share) - k).abs() < 1e-6, "({i}, {j}): {share} for {k}");
        }
    }
}

#[test]
fn pixels_beyond_the_image_are_dark() {
    let s = sensor(30, 30);
    let volts = s.expected_volts(&flat(4, 4, 2.8e-6, 1e14), &Exposure::new(0.01)).unwrap();
    assert_eq!(volts.plane(0).unwrap()[0], 0.0);
    assert!(volts.plane(0).unwrap()[15 * 30 + 15] > 0.0);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for architecture in [ColorArchitecture::Mosaic, ColorArchitecture::Prism] {
        let mut s = noisy_sensor(70, 300);
        s.architecture = architecture;
        let image = speckle(50, 170, 4e-6);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| s.capture(&image, &Exposure::new(0.05), NoiseMode::All, 3).unwrap())
        };
        let one = run(1);
        assert!(one == run(2) && one == run(4));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_window_has_the_bits_of_the_whole(
        row in 0usize..30, col in 0usize..150, rows in 1usize..20, cols in 1usize..150,
        spacing_um in 0.5f64..9.0, prism: bool, bits in prop::sample::select(vec![0u32, 8, 12, 16]),
        aperture in prop::sample::select(vec![Aperture::Area, Aperture::Point]),
    ) {
        let mut s = noisy_sensor(50, 300);
        s.aperture = aperture;
        s.adc = Adc { bits, black_level_dn: if bits == 0 { 0.0 } else { 16.0 } };
        s.architecture = if prism { ColorArchitecture::Prism } else { ColorArchitecture::Mosaic };
        let image = speckle(30, 60, spacing_um * 1e-6);
        let exposure = Exposure::new(0.05);
        let whole = s.capture(&image, &exposure, NoiseMode::All, 3).unwrap();
        s.window = Some(Window { row, col, rows, cols });
        let part = s.capture(&image, &exposure, NoiseMode::All, 3).unwrap();
        let (whole_values, part_values) = (values(&whole), values(&part));
        for plane in 0..whole.sampling().planes() {
            for r in 0..rows {
                let at = plane * 50 * 300 + (row + r) * 300 + col;
                let from = (plane * rows + r) * cols;
                prop_assert_eq!(&whole_values[at..at + cols], &part_values[from..from + cols]);
            }
        }
        if let (Sampling::Mosaic(w), Sampling::Mosaic(p)) = (whole.sampling(), part.sampling()) {
            prop_assert_eq!(w.channel_at(row + 3, col + 5), p.channel_at(3, 5));
        }
    }

    #[test]
    fn impossible_numbers_are_errors_and_never_panics(
        which in 0usize..14, value in prop::sample::select(vec![
            f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -0.0, 0.0, 1e-300, 1e300, 0.5, 2.0]),
    ) {
        let mut s = noisy_sensor(3, 5);
        let mut e = Exposure::new(0.01);
        let p = &mut s.pixel;
        let n = &mut s.nonuniformity;
        let fields = [&mut p.pitch_m, &mut p.fill_factor, &mut p.conversion_gain_v_per_e, &mut p.voltage_swing_v,
            &mut p.full_well_e, &mut p.dark_voltage_v_per_s, &mut p.read_noise_v, &mut n.prnu_fraction,
            &mut n.dsnu_v, &mut n.dead_pixel_fraction, &mut s.adc.black_level_dn, &mut e.time_s,
            &mut e.analog_gain, &mut e.analog_offset_v];
        *fields.into_iter().nth(which).unwrap() = value;
        let result = s.capture(&flat(9, 9, 2e-6, 1e14), &e, NoiseMode::All, 0);
        prop_assert!(!(value.is_nan() && result.is_ok()));
        if let Ok(raw) = result {
            prop_assert!(values(&raw).iter().all(|v| v.is_finite()));
        }
    }
}

#[test]
fn each_impossible_pixel_has_its_own_error() {
    let check = |change: &dyn Fn(&mut Sensor), expected: &str| {
        let mut s = sensor(4, 4);
        change(&mut s);
        let message = s.validate().unwrap_err().to_string();
        assert!(message.starts_with(expected), "{message}");
        assert!(message.contains("expected") || message.contains("must"), "{message}");
    };
    check(&|s| s.pixel.pitch_m = 0.0, "pitch_m is 0");
    check(&|s| s.pixel.fill_factor = 1.2, "fill_factor is 1.2");
    check(&|s| s.pixel.fill_factor = 0.0, "fill_factor is 0");
    check(&|s| s.pixel.conversion_gain_v_per_e = -1.0, "conversion_gain_v_per_e is -1");
    check(&|s| s.pixel.voltage_swing_v = 0.0, "voltage_swing_v is 0");
    check(&|s| s.pixel.full_well_e = f64::NAN, "full_well_e is NaN");
    check(&|s| s.pixel.dark_voltage_v_per_s = -1e-3, "dark_voltage_v_per_s is -0.001");
    check(&|s| s.pixel.read_noise_v = -1.0, "read_noise_v is -1");
    check(&|s| s.nonuniformity.prnu_fraction = f64::NAN, "prnu_fraction is NaN");
    check(&|s| s.adc.bits = 17, "adc bits is 17");
    check(&|s| s.adc = Adc { bits: 8, black_level_dn: 250.0 }, "black_level_dn is 250");
    check(&|s| s.window = Some(Window { row: 2, col: 0, rows: 3, cols: 1 }), "the window of 3 × 1");
}

#[test]
fn a_sensor_larger_than_memory_is_an_error_and_its_window_is_not() {
    let mut s = sensor(1_000_000, 1_000_000);
    let image = flat(9, 9, 2e-6, 1e14);
    let e = Exposure::new(0.01);
    assert!(matches!(s.capture(&image, &e, NoiseMode::All, 0), Err(SensorError::TooLarge { .. })));
    s.rows = usize::MAX;
    assert!(matches!(s.validate(), Err(SensorError::TooLarge { .. })));
    s.rows = 1_000_000;
    s.window = Some(Window { row: 500_000, col: 499_998, rows: 3, cols: 5 });
    assert_eq!(s.capture(&image, &e, NoiseMode::All, 0).unwrap().cols(), 5);
}

#[test]
fn crosstalk_that_makes_light_is_refused() {
    let mut s = sensor(4, 4);
    s.crosstalk = Some([[0.1; 3]; 3]);
    assert!(matches!(s.validate(), Err(SensorError::Crosstalk { .. })));
    s.crosstalk = Some([[0.0, -0.1, 0.0], [0.0, 1.1, 0.0], [0.0; 3]]);
    assert!(matches!(s.validate(), Err(SensorError::Crosstalk { .. })));
}

#[test]
fn light_of_components_that_is_not_finite_is_an_error() {
    let spectra = [Spectrum::from_fn(GRID, |nm| nm - 410.0).unwrap()];
    let light = |value: f32| {
        let planes = Planes::new(2, 3, 1, [vec![1.0; 5], vec![value]].concat()).unwrap();
        PixelSpectra::of_components(&sensor(2, 3), &planes, &spectra)
    };
    // Rounding below 0 is clipped.
    assert_eq!(light(-1.0).unwrap().spectrum(1, 2).unwrap().values()[..3], [10.0, 0.0, 0.0]);
    for bad in [f32::NAN, f32::INFINITY] {
        let error = light(bad).unwrap_err();
        assert!(matches!(error, SensorError::Spectrum(SpectrumError::Value { .. })), "{error}");
    }
}

#[test]
fn wavelengths_that_the_filters_do_not_cover_are_an_error_with_both_ranges() {
    let grid = WavelengthGrid::new(380.0, 10.0, 40).unwrap();
    let cube = SpectralCube::new(grid, Planes::zeros(2, 2, 40)).unwrap();
    let image = smalti::optics::OpticalImage::new(cube, 1e-6).unwrap();
    let e = sensor(4, 4).capture(&image, &Exposure::new(0.01), NoiseMode::None, 0).unwrap_err().to_string();
    assert!(e.contains("quantum efficiency") && e.contains("400–700") && e.contains("380–770"), "{e}");
    // An IR-cut filter of another grid is brought to the filters' own, or refused.
    let mut s = sensor(4, 4);
    s.ir_cut = Some(Spectrum::constant(WavelengthGrid::new(400.0, 5.0, 40).unwrap(), 1.0).unwrap());
    assert!(matches!(
        s.spectral_responsivity_on(WavelengthGrid::VISIBLE),
        Err(SensorError::Spectrum(SpectrumError::Of { .. }))
    ));
    s.ir_cut = Some(Spectrum::constant(WavelengthGrid::new(350.0, 5.0, 90).unwrap(), 0.5).unwrap());
    let halved = s.spectral_responsivity_on(WavelengthGrid::VISIBLE).unwrap()[0].integral();
    s.ir_cut = None;
    assert!(
        (s.spectral_responsivity_on(WavelengthGrid::VISIBLE).unwrap()[0].integral() / halved - 2.0).abs()
            < 1e-12
    );
    let wrong: Result<Spectrum, SpectrumError> = Spectrum::new(WavelengthGrid::VISIBLE, vec![1.5; 31]);
    s.quantum_efficiency = wrong.unwrap();
    assert!(matches!(s.validate(), Err(SensorError::Spectrum(SpectrumError::Value { .. }))));
}

#[test]
fn a_zero_exposure_is_a_bias_frame() {
    let mut s = sensor(60, 60);
    s.pixel.read_noise_v = 2e-3;
    let raw = s.capture(&flat(9, 9, 1e-4, 1e15), &Exposure::new(0.0), NoiseMode::All, 1).unwrap();
    let (mean, variance) = moments(&values(&raw));
    assert!(mean.abs() < 4.0 * 2e-3 / 60.0);
    assert!((variance / 4e-6 - 1.0).abs() < 0.1);
}

#[test]
fn the_three_architectures_share_light_as_they_should() {
    let mut s = sensor(8, 8);
    let image = flat(80, 80, 0.5e-6, 1e14);
    let e = Exposure::new(0.012);
    let mosaic = s.expected_volts(&image, &e).unwrap();
    s.architecture = ColorArchitecture::Prism;
    let prism = s.expected_volts(&image, &e).unwrap();
    s.architecture = ColorArchitecture::FieldSequential;
    let sequential = s.expected_volts(&image, &e).unwrap();
    assert_eq!((mosaic.count(), prism.count(), sequential.count()), (1, 3, 3));
    for (i, v) in mosaic.plane(0).unwrap().iter().enumerate() {
        assert_eq!(*v, prism.plane(s.cfa.mosaic().channel_at(i / 8, i % 8)).unwrap()[i]);
    }
    let third = prism.data().iter().zip(sequential.data()).all(|(p, q)| (p / q / 3.0 - 1.0).abs() < 1e-6);
    assert!(third);

    // Sequential captures come from one sensor, a prism's from three.
    s.nonuniformity.dsnu_v = 1e-3;
    let pattern = |s: &Sensor| {
        let raw = s.capture(&image, &Exposure::new(0.0), NoiseMode::All, 1).unwrap();
        values(&raw).chunks(64).map(<[f32]>::to_vec).collect::<Vec<_>>()
    };
    let p = pattern(&s);
    assert_eq!(p[0], p[1]);
    s.architecture = ColorArchitecture::Prism;
    let p = pattern(&s);
    assert_ne!(p[0], p[1]);
}

/// Captures from photoelectron rates times a factor are those of the image with its light multiplied, up to rounding of the means:
/// samples differ by at most one digital number, crosstalk, noise and architectures included.
#[test]
fn rates_times_a_factor_are_the_image_in_more_light() {
    let mut s = sensor(24, 32);
    s.adc.bits = 12;
    s.crosstalk = Some([[0.0, 0.02, 0.0], [0.03, 0.9, 0.05], [0.0, 0.0, 0.0]]);
    let image = speckle(40, 50, 2.1e-6);
    let exposure = Exposure::new(0.01);
    for architecture in [ColorArchitecture::Mosaic, ColorArchitecture::Prism] {
        s.architecture = architecture;
        let rates = ElectronRates::new(&s, &image).unwrap();
        for factor in [0.0, 0.3, 1.0, 7.5] {
            let direct =
                s.capture(&image.scaled(factor).unwrap(), &exposure, NoiseMode::All, 3).unwrap().normalized();
            let from_rates = s.capture((&rates, factor), &exposure, NoiseMode::All, 3).unwrap().normalized();
            let step = 1.0 / f64::from(1u32 << 12) + 1e-6;
            // A mean that rounds to the other side of a threshold changes a Poisson deviate by one.
            let differ = direct.iter().zip(&from_rates).filter(|(a, b)| a != b).count();
            assert!(differ * 1000 <= direct.len() * 5, "{differ} of {} at {factor}", direct.len());
            let largest =
                direct.iter().zip(&from_rates).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
            assert!(largest <= 4.0 * step, "{largest} at {factor}");
        }
        assert!(matches!(
            s.capture((&rates, -1.0), &exposure, NoiseMode::All, 3),
            Err(SensorError::Parameter(_))
        ));
    }
    let other = sensor(24, 30);
    let rates = ElectronRates::new(&other, &image).unwrap();
    assert!(matches!(
        s.capture((&rates, 1.0), &exposure, NoiseMode::All, 3),
        Err(SensorError::OtherPixels { .. })
    ));
}

/// The width is no multiple of the pixels that are drawn at once. A prism with fewer channels has the same window.
#[test]
fn a_fixed_pattern_that_was_drawn_before_changes_no_bit() {
    let mut windowed = noisy_sensor(64, 230);
    windowed.window = Some(Rect { row: 3, col: 7, rows: 40, cols: 101 });
    let mut prism = noisy_sensor(40, 101);
    prism.architecture = ColorArchitecture::Prism;
    let mut of_one_channel = prism.clone();
    of_one_channel.cfa = mono();
    let (image, exposure) = (speckle(60, 170, 2.1e-6), Exposure::new(0.05));
    for sensor in [&windowed, &prism, &of_one_channel] {
        let rates = ElectronRates::new(sensor, &image).unwrap();
        let expected = sensor.capture((&rates, 1.0), &exposure, NoiseMode::All, 3).unwrap();
        for drawn_for in [sensor, &windowed, &prism, &of_one_channel] {
            let rates = rates.clone().with_pattern_of(drawn_for);
            assert!(sensor.capture((&rates, 1.0), &exposure, NoiseMode::All, 3).unwrap() == expected);
        }
        assert_ne!(rates.clone().with_pattern_of(sensor), rates);
    }
}

/// Sensors of one image, with unlike mosaics, windows, binning and sizes, some of them equal, have the bits that each has alone, for any
/// number of threads. The width is no multiple of the columns that are summed at once.
#[test]
fn rates_of_many_sensors_are_those_of_each() {
    let image = speckle(90, 330, 2.1e-6);
    let mut mono_sensor = sensor(64, 230);
    mono_sensor.cfa = mono();
    let mut windowed = sensor(64, 230);
    windowed.window = Some(Rect { row: 3, col: 7, rows: 40, cols: 101 });
    let mut binned = sensor(32, 115);
    binned.pixel.pitch_m *= 2.0;
    binned.binning = Some(Binning { side: 2, mode: BinningMode::Charge });
    let mut prism = noisy_sensor(64, 230);
    prism.architecture = ColorArchitecture::Prism;
    let mut leaking = sensor(64, 230);
    leaking.crosstalk = Some([[0.0, 0.02, 0.0], [0.03, 0.9, 0.05], [0.0, 0.0, 0.0]]);
    let all = [
        [&sensor(64, 230), &mono_sensor],
        [&windowed, &prism],
        [&binned, &sensor(20, 30)],
        [&prism.clone(), &sensor(64, 230)],
        [&leaking, &noisy_sensor(64, 230)],
    ];
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    for threads in [1, 3] {
        let together = pool(threads).install(|| ElectronRates::of_all(&all, &image)).unwrap();
        for (sensors, rates) in all.iter().zip(&together) {
            for (sensor, rates) in sensors.iter().zip(rates) {
                assert_eq!(*rates, ElectronRates::new(sensor, &image).unwrap());
            }
        }
    }
    assert_eq!(ElectronRates::of_all::<2>(&[], &image).unwrap(), Vec::<[ElectronRates; 2]>::new());
    // The volts of these rates are those of the image, whether it has more samples than pixels or fewer, and those of a window are a part
    // of those of the whole sensor, whether or not the image covers it.
    let exposure = Exposure::new(0.01);
    for spacing_m in [0.7e-6, 1.4e-6, 2.1e-6, 3.9e-6] {
        let image = speckle(90, 330, spacing_m);
        for &sensor in all.as_flattened() {
            let rates = ElectronRates::new(sensor, &image).unwrap();
            let volts = sensor.expected_volts((&rates, 1.0), &exposure).unwrap();
            let direct = sensor.expected_volts(&image, &exposure).unwrap();
            let largest = direct.data().iter().fold(0.0f32, |largest, v| largest.max(*v));
            let differ = |(a, b): (&f32, &f32)| (a - b).abs() > 4e-6 * largest;
            assert!(largest > 0.0 && !volts.data().iter().zip(direct.data()).any(differ), "{spacing_m}");
            let (w, mut part) = (sensor.read_window(), sensor.clone());
            if sensor.binning.is_none() {
                part.window = Some(Rect { row: w.row + 5, col: w.col + 9, rows: 13, cols: 20 });
                let rates = ElectronRates::new(&part, &image).unwrap();
                let cut = part.expected_volts((&rates, 1.0), &exposure).unwrap();
                for (plane, whole) in cut.planes().zip(volts.planes()) {
                    for (row, line) in plane.chunks(20).enumerate() {
                        let at = (row + 5) * w.cols + 9;
                        assert_eq!(line, &whole[at..at + 20], "{spacing_m}");
                    }
                }
            }
        }
    }
}

/// Rates with the random numbers of a fixed pattern give the captures without them: of windows and prisms, with defects, for any
/// number of threads, and on another device as well, whose pattern is its own.
#[test]
fn a_pattern_that_was_drawn_before_changes_no_bit() {
    let image = speckle(90, 330, 2.1e-6);
    let mut device = noisy_sensor(64, 230);
    let non = &mut device.nonuniformity;
    (non.prnu_fraction, non.dsnu_v, non.column_noise_v) = (0.02, 0.001, 0.001);
    (non.dead_pixel_fraction, non.hot_pixel_fraction, non.device_serial) = (0.01, 0.02, 7 << 33);
    let mut windowed = device.clone();
    windowed.window = Some(Rect { row: 3, col: 7, rows: 40, cols: 201 });
    let mut prism = device.clone();
    prism.architecture = ColorArchitecture::Prism;
    let mut even = device.clone();
    (even.nonuniformity.dead_pixel_fraction, even.nonuniformity.hot_pixel_fraction) = (0.0, 0.0);
    let exposure = Exposure::new(0.01);
    for sensor in [&device, &windowed, &prism, &even] {
        let mut other = sensor.clone();
        other.nonuniformity.device_serial += 1;
        let rates = ElectronRates::new(sensor, &image).unwrap();
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let drawn = pool.install(|| rates.clone().with_pattern_of(sensor));
            assert_ne!(drawn, rates);
            for by in [sensor, &other] {
                let capture = |rates| by.capture((rates, 2.0), &exposure, NoiseMode::All, 3).unwrap();
                assert!(capture(&rates) == capture(&drawn));
            }
        }
        assert_ne!(
            sensor.capture((&rates, 2.0), &exposure, NoiseMode::All, 3).unwrap(),
            other.capture((&rates, 2.0), &exposure, NoiseMode::All, 3).unwrap()
        );
    }
    let alike = sensor(64, 230);
    let rates = ElectronRates::new(&alike, &image).unwrap();
    assert_eq!(rates.clone().with_pattern_of(&alike), rates);
}

/// What leaves no range between black and white is named: the offset, or a full well that is too small at any offset.
#[test]
fn levels_without_a_range_name_their_cause() {
    let named = |full_well_e: f64, analog_offset_v: f64, bits: u32| {
        let mut s = sensor(4, 4);
        s.pixel.full_well_e = full_well_e;
        s.adc = Adc { bits, black_level_dn: 0.0 };
        let exposure = Exposure { analog_offset_v, ..Exposure::new(0.01) };
        match s.raw_levels(&exposure) {
            Err(SensorError::Parameter(error)) => Some(error.name),
            Err(error) => panic!("{error}"),
            Ok(_) => None,
        }
    };
    for bits in [0, 12] {
        assert_eq!(named(10_000.0, 0.0, bits), None);
        for offset_v in [1.0, 2.0, 900.0] {
            assert_eq!(named(10_000.0, offset_v, bits).as_deref(), Some("analog_offset_v"), "{offset_v} V");
        }
    }
    // An electron gives 0.4 steps of the converter.
    for offset_v in [0.0, 2.0] {
        assert_eq!(named(1.0, offset_v, 12).as_deref(), Some("full_well_e"), "{offset_v} V");
    }
}
