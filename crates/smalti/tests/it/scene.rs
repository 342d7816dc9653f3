//! Scenes: laws, and the figures of ISETCam that must hold without its files at hand.
#![allow(clippy::unwrap_used)]

use crate::common;

use common::assert_close;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use smalti::scene::{
    Checkerboard, ColorPatches, DeadLeaves, FrequencyOrientation, FrequencySweep, Glints, GlossyBalls,
    Gradients, GreySteps, PatternSampling, PointGrid, ResolutionChart, Scene, SceneError, Setting,
    SiemensStar, SlantedBar, ZonePlate, checkerboard, color_patches, dead_leaves, frequency_orientation,
    frequency_sweep, glossy_balls, gradients, grey_steps, hdr, macbeth, point_grid, resolution_chart,
    siemens_star, slanted_bar, uniform, zone_plate, zone_plate_isetcam,
};
use smalti::spectrum::{Illuminant, Observer, Spectrum, WavelengthGrid};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

fn setting(luminance_cd_m2: f64) -> Setting {
    Setting { luminance_cd_m2, ..Setting::default() }
}

/// Equal photons at every wavelength, the light of some of ISETCam's targets.
fn equal_photons() -> Setting {
    let power = Spectrum::from_fn(GRID, |nm| 560.0 / nm).unwrap();
    Setting { illuminant: Illuminant::Measured { name: "equal photons".into(), power }, ..Setting::default() }
}

fn row(scene: &Scene, band: usize, row: usize) -> Vec<f64> {
    let cols = scene.radiance().cols();
    let plane = scene.radiance().planes().plane(band).unwrap();
    plane[row * cols..(row + 1) * cols].iter().map(|&v| f64::from(v)).collect()
}

fn largest_relative_difference(a: &Scene, b: &Scene) -> f64 {
    let pairs = a.radiance().planes().data().iter().zip(b.radiance().planes().data());
    pairs.fold(0.0, |m: f64, (&a, &b)| m.max(f64::from((a - b).abs()) / f64::from(b.abs()).max(1e-30)))
}

/// Reflectance of the white patch in ISETCam's chart.
const WHITE: [f64; 31] = [
    0.512008, 0.628656, 0.703221, 0.716861, 0.727381, 0.736606, 0.741128, 0.745925, 0.753782, 0.758518,
    0.762446, 0.771529, 0.782334, 0.796497, 0.809060, 0.815148, 0.824976, 0.828992, 0.836109, 0.840637,
    0.845600, 0.853316, 0.862481, 0.864399, 0.870293, 0.870733, 0.874263, 0.869984, 0.865636, 0.864617,
    0.863755,
];
/// Photons of that patch under its D65.
const WHITE_PHOTONS: [f64; 31] = [
    3.473624e15,
    4.833000e15,
    5.656158e15,
    5.476998e15,
    6.880111e15,
    7.951291e15,
    8.234461e15,
    8.256176e15,
    8.599817e15,
    8.292447e15,
    8.548445e15,
    8.698308e15,
    8.742293e15,
    9.323086e15,
    9.354807e15,
    9.567000e15,
    9.475255e15,
    9.336359e15,
    9.527661e15,
    9.022045e15,
    9.366953e15,
    9.566773e15,
    9.619868e15,
    9.304359e15,
    9.563740e15,
    9.291805e15,
    9.495546e15,
    9.839306e15,
    9.454086e15,
    8.533657e15,
    8.883127e15,
];

#[test]
fn white_patch_as_in_isetcam() {
    // A chart of white patches only, at the luminance that the white patch has. ISETCam's D65 differs by up to 6e-4.
    let list = vec![Spectrum::new(GRID, WHITE.to_vec()).unwrap(); 24];
    let scene = macbeth::chart_of(&list, 2, &setting(239.75576593967054)).unwrap();
    let pixel = scene.radiance().pixel(3, 3).unwrap();
    assert_close("photons", pixel.values(), &WHITE_PHOTONS, 7e-4);
    let xyz = Observer::Cie1931.xyz_from_photons(&pixel).unwrap();
    assert_close("XYZ", &xyz, &[229.22001425878824, 239.75576593967054, 234.74745414997324], 7e-4);
}

#[test]
fn slanted_bar_as_in_isetcam() {
    let setting = Setting { illuminant: Illuminant::E, ..setting(74.99999588151978) };
    let scene = slanted_bar(&SlantedBar::default(), &setting).unwrap();
    assert_eq!((scene.radiance().rows(), scene.radiance().cols()), (513, 513));
    let at = |row, col, band: usize| scene.radiance().pixel(row, col).unwrap().values()[band];
    let bright = [at(256, 0, 0), at(256, 0, 15), at(256, 0, 30)];
    // Planck's constant, 1.6e-5.
    let expected = [4141065196011520.0, 5693964845842432.0, 7246863958802432.0];
    assert_close("bright", &bright, &expected, 3e-5);
    assert_close("dark", &[at(256, 512, 0)], &[4141065216.0], 3e-5);
    let middle = row(&scene, 15, 256);
    assert_eq!(middle.iter().filter(|&&v| v > 1e12).count(), 256);
    // Seven rows down the edge has moved by three columns; pixels on the edge itself are dark.
    assert_eq!(row(&scene, 15, 263).iter().filter(|&&v| v > 1e12).count(), 259);
}

#[test]
fn zone_plate_as_in_isetcam() {
    let scene = zone_plate_isetcam(&equal_photons()).unwrap();
    let expected = [
        5.6371334e11,
        5.6371338e15,
        7.9687466e12,
        5.6371338e15,
        7.9096109e13,
        5.6371338e15,
        3.3733676e14,
        5.6371338e15,
        9.6287865e14,
        5.6371338e15,
        2.1508412e15,
        5.6371338e15,
        4.0228403e15,
        5.6371338e15,
        5.6371338e15,
        3.4586102e15,
    ];
    assert_close("row 1", &row(&scene, 15, 0)[..16], &expected, 3e-5);
    let expected = [
        5.6371338e15,
        2.9189994e15,
        5.6371338e15,
        3.3316724e15,
        5.6371338e15,
        4.1114270e15,
        5.6371338e15,
        5.2914609e15,
        5.2454409e15,
        5.6371338e15,
        3.5439689e15,
        5.6371338e15,
        1.7668347e15,
        5.6371338e15,
        3.8607149e14,
        5.6371338e15,
    ];
    assert_close("row 128", &row(&scene, 15, 127)[..16], &expected, 3e-5);
}

#[test]
fn frequency_orientation_as_in_isetcam() {
    let target = FrequencyOrientation {
        sampling: PatternSampling::Isetcam,
        block_px: 32,
        frequencies: 8,
        angles: 8,
        contrast: 1.0,
    };
    let scene = frequency_orientation(&target, &equal_photons()).unwrap();
    let row_16: Vec<f64> = row(&scene, 15, 15).into_iter().step_by(32).collect();
    let expected = [
        4.6194317e15,
        2.3861391e15,
        6.0128098e15,
        1.1321322e15,
        7.0792550e15,
        2.9423157e14,
        7.6564106e15,
        7.7306823e11,
    ];
    assert_close("row 16", &row_16, &expected, 3e-5);
    let row_100 = row(&scene, 15, 99);
    let row_100 = [0, 1, 15, 40, 77, 100, 131, 177, 200, 255].map(|i| row_100[i]);
    let expected = [
        5.5832111e15,
        5.9931974e15,
        6.7558032e15,
        4.8656482e15,
        3.3753031e15,
        1.4975571e15,
        6.1816740e14,
        5.5733992e15,
        1.5119353e15,
        5.7610259e15,
    ];
    assert_close("row 100", &row_100, &expected, 3e-5);
}

#[test]
fn mean_luminance_is_what_was_asked() {
    let s = &setting(37.5);
    let scenes = [
        macbeth::chart(8, s),
        slanted_bar(&SlantedBar { size: 64, ..SlantedBar::default() }, s),
        zone_plate(&ZonePlate { size: 64, ..ZonePlate::default() }, s),
        uniform(4, 5, s),
        grey_steps(&GreySteps { rows: 8, steps: 20, step_px: 32, density: 3.0 }, s),
        frequency_sweep(
            &FrequencySweep { rows: 16, cols: 64, lowest: 1.0 / 256.0, highest: 0.5, least_contrast: 0.01 },
            s,
        ),
        frequency_orientation(
            &FrequencyOrientation {
                block_px: 8,
                frequencies: 8,
                angles: 8,
                contrast: 1.0,
                sampling: PatternSampling::Area,
            },
            s,
        ),
        siemens_star(&SiemensStar { size: 64, cycles: 72, contrast_ratio: 1e3 }, s),
        point_grid(&PointGrid { points: 2, spacing_px: 32, diameter_px: 2.0 }, s),
        checkerboard(&Checkerboard { squares: 4, square_px: 4, contrast_ratio: 1e3 }, s),
        resolution_chart(&ResolutionChart { rows: 96, contrast_ratio: 40.0 }, s),
        dead_leaves(
            &DeadLeaves { rows: 40, cols: 60, least_radius_px: 1.5, largest_radius_px: 200.0, seed: 1 },
            &macbeth::reflectances(GRID).unwrap(),
            s,
        ),
        hdr(40, s),
    ];
    for scene in scenes {
        let scene = scene.unwrap();
        // Single precision of the radiance.
        let mean = scene.mean_luminance_cd_m2().unwrap();
        assert!((mean / 37.5 - 1.0).abs() < 1e-6, "{}: {mean}", scene.name());
        let xyz = scene.xyz().unwrap();
        let luminance = scene.luminance_cd_m2().unwrap();
        assert!(xyz.plane(1).unwrap().iter().zip(&luminance).all(|(a, b)| (a - b).abs() <= 1e-6 * b.abs()));
        let brighter = scene.clone().with_mean_luminance(75.0).unwrap();
        assert!((brighter.mean_luminance_cd_m2().unwrap() / 75.0 - 1.0).abs() < 1e-6);
        let white = brighter.illuminant().values()[9] / scene.illuminant().values()[9];
        assert!((white - 2.0).abs() < 1e-6);
    }
}

#[test]
fn relighting_there_and_back_is_the_identity() {
    let d65 = macbeth::chart(4, &setting(100.0)).unwrap();
    let a = d65.clone().relit(&Illuminant::A).unwrap();
    assert!((a.mean_luminance_cd_m2().unwrap() - 100.0).abs() < 1e-4);
    // The same as making the chart under A in the first place; single precision twice.
    let made = macbeth::chart(4, &Setting { illuminant: Illuminant::A, ..setting(100.0) }).unwrap();
    assert!(largest_relative_difference(&a, &made) < 1e-6);
    assert_close("light", a.illuminant().values(), made.illuminant().values(), 1e-6);
    let back = a.relit(&Illuminant::D65).unwrap();
    assert!(largest_relative_difference(&back, &d65) < 1e-6);
}

/// Local light multiplies every wavelength by the ratio of two illuminants, up to one factor that keeps the luminance, and leaves the
/// white of the scene; the other way round it is undone.
#[test]
fn local_light_changes_pixels_and_no_white() {
    let built = macbeth::chart(8, &setting(80.0)).unwrap();
    let local = built.clone().in_local_light(&Illuminant::A, &Illuminant::D65).unwrap();
    assert_eq!(local.illuminant(), built.illuminant());
    assert!((local.mean_luminance_cd_m2().unwrap() / 80.0 - 1.0).abs() < 1e-6);
    let [a, d65] = [Illuminant::A, Illuminant::D65].map(|light| light.photons(GRID).unwrap());
    let factor = |band: usize| {
        let ratio = row(&local, band, 9)[9] / row(&built, band, 9)[9];
        ratio / (a.values()[band] / d65.values()[band])
    };
    let factors: Vec<f64> = (0..GRID.len()).map(factor).collect();
    assert_close("factors", &factors, &vec![factors[0]; GRID.len()], 1e-6);
    let back = local.in_local_light(&Illuminant::D65, &Illuminant::A).unwrap();
    assert!(largest_relative_difference(&back, &built) < 1e-6);

    let dark = Illuminant::Measured { name: "dark".into(), power: Spectrum::constant(GRID, 0.0).unwrap() };
    let refused = built.in_local_light(&Illuminant::A, &dark).unwrap_err();
    assert!(matches!(refused, SceneError::NoLightToDivideBy { .. }), "{refused:?}");
}

/// Glints have the colour of the light, lie on the stated share of the samples, and exceed k times the least brightness with the
/// probability k⁻ᵉ; all other samples stay.
#[test]
fn glints_have_the_colour_of_the_light_and_a_pareto_distribution() {
    let built = uniform(200, 300, &setting(50.0)).unwrap();
    let glints = Glints { share: 0.05, least: 0.5, exponent: 1.5, seed: 3 };
    let scene = built.clone().with_glints(&glints).unwrap();
    let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(single.install(|| built.clone().with_glints(&glints).unwrap()), scene);
    assert_eq!(scene.illuminant(), built.illuminant());
    let added = |band: usize| -> Vec<f64> {
        let planes = [&scene, &built].map(|s| s.radiance().planes().plane(band).unwrap());
        let white = scene.illuminant().values()[band];
        planes[0].iter().zip(planes[1]).map(|(a, b)| f64::from(a - b) / white).collect()
    };
    let first = added(0);
    for band in [7, GRID.len() - 1] {
        for (a, b) in added(band).iter().zip(&first) {
            assert!((a - b).abs() < 1e-5 * (1.0 + b), "{a} {b}");
        }
    }
    let mut drawn: Vec<f64> = first.into_iter().filter(|v| *v != 0.0).collect();
    drawn.sort_by(f64::total_cmp);
    // Of 60 000 samples; the standard deviation of the count is 53.
    let count = drawn.len() as f64;
    assert!((count - 3000.0).abs() < 200.0, "{count}");
    assert!(drawn[0] > 0.499 && *drawn.last().unwrap() < 30.001, "{drawn:?}");
    for k in [1.5f64, 3.0, 10.0] {
        let above = drawn.iter().filter(|v| **v > 0.5 * k).count() as f64 / count;
        let expected = k.powf(-1.5);
        let deviation = (expected * (1.0 - expected) / count).sqrt();
        assert!((above - expected).abs() < 4.0 * deviation, "{above} {expected}");
    }
    // A greatest brightness of 30 is met by one in 465.
    assert!(drawn.iter().filter(|v| **v > 29.99).count() < 20);
    for bad in [
        Glints { share: 1.5, ..glints },
        Glints { least: 0.0, ..glints },
        Glints { exponent: 0.0, ..glints },
        Glints { exponent: f64::NAN, ..glints },
    ] {
        assert!(built.clone().with_glints(&bad).is_err(), "{bad:?}");
    }
}

/// A reflectance takes its share of every wavelength, and leaves the illuminant as it is.
#[test]
fn a_reflectance_multiplies_the_radiance_of_a_scene() {
    let scene = macbeth::chart(2, &Setting::default()).unwrap();
    let factor =
        Spectrum::from_fn(scene.radiance().grid(), |nm| if nm < 450.0 { 0.25 } else { 0.5 }).unwrap();
    let product = scene.clone().multiplied_by(&factor).unwrap();
    assert_eq!(product.illuminant(), scene.illuminant());
    for (band, &share) in factor.values().iter().enumerate() {
        let [before, after] = [&scene, &product].map(|s| s.radiance().planes().plane(band).unwrap());
        // Powers of two, so that nothing is rounded.
        assert!(before.iter().zip(after).all(|(b, a)| f64::from(*a) == f64::from(*b) * share));
    }
    let of = |value: f64, grid| Spectrum::constant(grid, value).unwrap();
    let grid = scene.radiance().grid();
    assert!(scene.clone().multiplied_by(&of(-0.1, grid)).is_err());
    assert!(scene.multiplied_by(&of(0.5, WavelengthGrid::new(400.0, 5.0, 61).unwrap())).is_err());
}

#[test]
fn what_was_not_lit_cannot_be_relit() {
    let power = Spectrum::from_fn(GRID, |nm| if nm < 450.0 { 0.0 } else { 1.0 }).unwrap();
    let amber = Illuminant::Measured { name: "amber".into(), power };
    let scene = macbeth::chart(1, &Setting { illuminant: amber.clone(), ..Setting::default() }).unwrap();
    let error = scene.clone().relit(&Illuminant::D65).unwrap_err();
    assert!(matches!(error, SceneError::NoLightToDivideBy { wavelength_nm: 400.0, .. }), "{error}");
    // The other way round is possible, and so is the light it has.
    let d65 = macbeth::chart(1, &Setting::default()).unwrap().relit(&amber).unwrap();
    assert!(d65.radiance().planes().plane(2).unwrap().iter().all(|&v| v == 0.0));
    assert!(largest_relative_difference(&scene.clone().relit(&amber).unwrap(), &scene) < 1e-6);
}

#[test]
fn a_uniform_scene_is_uniform_and_scales() {
    let one = uniform(3, 7, &setting(1.0)).unwrap();
    for plane in one.radiance().planes().planes() {
        assert!(plane.iter().all(|&v| v == plane[0]));
    }
    let thousand = uniform(3, 7, &setting(1000.0)).unwrap();
    let ratio = thousand.radiance().planes().data()[0] / one.radiance().planes().data()[0];
    assert!((ratio / 1000.0 - 1.0).abs() < 1e-6);
    assert!(one.luminance_cd_m2().unwrap().iter().all(|y| (y - 1.0).abs() < 1e-6));
    // A white field has the radiance of its light.
    let pixel = one.radiance().pixel(1, 1).unwrap();
    assert_close("radiance", pixel.values(), one.illuminant().values(), 1e-7);
}

#[test]
fn distance_field_and_part() {
    let scene = uniform(10, 20, &setting(10.0)).unwrap();
    let scene = scene.with_distance(3.0).unwrap().with_fov(40.0).unwrap();
    assert_eq!((scene.distance_m(), scene.horizontal_fov_deg()), (3.0, 40.0));
    let part = scene.clone().cropped(2, 5, 4, 10).unwrap();
    assert_eq!((part.radiance().rows(), part.radiance().cols()), (4, 10));
    // Half the width of the plane is half the tangent of half the angle.
    let tan = |deg: f64| (deg / 2.0).to_radians().tan();
    assert!((2.0 * tan(part.horizontal_fov_deg()) - tan(40.0)).abs() < 1e-12);
    for (row, col, rows, cols) in [(0, 0, 0, 1), (0, 0, 11, 1), (0, 20, 1, 1), (usize::MAX, 0, 1, 1)] {
        assert!(scene.clone().cropped(row, col, rows, cols).is_err());
    }
    assert!(scene.clone().with_distance(0.0).is_err());
    assert!(scene.clone().with_fov(180.0).is_err());
    assert!(scene.clone().with_mean_luminance(f64::NAN).is_err());
}

#[test]
fn impossible_requests_are_errors() {
    let ok = Setting::default();
    assert!(matches!(uniform(1 << 20, 1 << 20, &ok), Err(SceneError::TooLarge { .. })));
    assert!(matches!(uniform(usize::MAX, usize::MAX, &ok), Err(SceneError::TooLarge { .. })));
    assert!(uniform(0, 4, &ok).is_err());
    assert!(macbeth::chart(0, &ok).is_err() && macbeth::chart(usize::MAX, &ok).is_err());
    assert!(matches!(macbeth::chart_of(&[], 4, &ok), Err(SceneError::Reflectances { got: 0, .. })));
    assert!(uniform(4, 4, &setting(0.0)).is_err());
    assert!(uniform(4, 4, &Setting { distance_m: -1.0, ..Setting::default() }).is_err());
    let infrared = Setting {
        grid: WavelengthGrid::new(900.0, 10.0, 11).unwrap(),
        illuminant: Illuminant::E,
        ..Setting::default()
    };
    assert!(matches!(uniform(4, 4, &infrared), Err(SceneError::Dark { .. })));
}

#[test]
fn an_area_sampled_edge_has_the_area_of_the_edge() {
    let bar = SlantedBar {
        size: 64,
        slope: SlantedBar::slope_of_angle(5.0),
        contrast_ratio: 4.0,
        sampling: PatternSampling::Area,
    };
    let scene = slanted_bar(&bar, &setting(50.0)).unwrap();
    let bright = scene.radiance().pixel(32, 0).unwrap().values()[10];
    let dark = scene.radiance().pixel(32, 64).unwrap().values()[10];
    assert!((bright / dark - 4.0).abs() < 1e-5);
    // Every row is crossed by the edge, whose place follows from the mean of the row.
    for r in 0..65 {
        let mean = row(&scene, 10, r).iter().sum::<f64>() / 65.0;
        let place = 65.0 * (mean - dark) / (bright - dark);
        let expected = 32.5 + (r as f64 - 32.0) * 5f64.to_radians().tan();
        assert!((place - expected).abs() < 1e-4, "row {r}: {place} {expected}");
    }
}

#[test]
fn patches_lie_row_by_row() {
    let scene = macbeth::chart(5, &setting(100.0)).unwrap();
    let list = macbeth::reflectances(GRID).unwrap();
    for (i, reflectance) in list.iter().enumerate() {
        let (row, col) = (i / macbeth::COLS * 5, i % macbeth::COLS * 5);
        for (row, col) in [(row, col), (row + 4, col + 4)] {
            let got = scene.radiance().pixel(row, col).unwrap();
            let expected = reflectance.times(scene.illuminant()).unwrap();
            assert_close("patch", got.values(), expected.values(), 1e-6);
        }
    }
}

#[test]
fn any_grid_works() {
    let grid = WavelengthGrid::new(380.0, 5.0, 125).unwrap();
    let s = Setting { grid, illuminant: Illuminant::Blackbody { temperature_k: 3000.0 }, ..setting(20.0) };
    let scene = macbeth::chart(2, &s).unwrap();
    assert!((scene.mean_luminance_cd_m2().unwrap() - 20.0).abs() < 1e-4);
    assert_eq!(scene.radiance().grid().end_nm(), 1000.0);
}

/// Power of a square plane by distance from zero frequency, in cycles per image, after a Hann window.
fn radial_power(plane: &[f32], n: usize) -> Vec<f64> {
    let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
    let window = |i: usize| 1.0 - (std::f64::consts::TAU * (i as f64 + 0.5) / n as f64).cos();
    let mut data: Vec<Complex<f64>> = (0..n * n)
        .map(|i| Complex::new((f64::from(plane[i]) - mean) * window(i / n) * window(i % n), 0.0))
        .collect();
    let fft = FftPlanner::new().plan_fft_forward(n);
    for _ in 0..2 {
        fft.process(&mut data);
        data = (0..n * n).map(|i| data[i % n * n + i / n]).collect();
    }
    let signed = |i: usize| if i < n / 2 { i as f64 } else { i as f64 - n as f64 };
    let (mut sum, mut count) = (vec![0.0; n / 2], vec![0.0f64; n / 2]);
    for (i, v) in data.iter().enumerate() {
        let ring = signed(i / n).hypot(signed(i % n)).round() as usize;
        if ring < n / 2 {
            sum[ring] += v.norm_sqr();
            count[ring] += 1.0;
        }
    }
    sum.iter().zip(&count).map(|(s, c)| s / c.max(1.0)).collect()
}

#[test]
fn dead_leaves_have_the_spectrum_of_photographs() {
    // Over four decades of radius, so that neither limit shows in the middle of the spectrum. For photographs
    // exponents of 1.8 (Ruderman 1994) to 1.9 (van der Schaaf and van Hateren 1996) were measured.
    let n = 256;
    let grid = WavelengthGrid::new(550.0, 10.0, 1).unwrap();
    let greys: Vec<Spectrum> =
        (0..11).map(|i| Spectrum::constant(grid, f64::from(i) / 10.0).unwrap()).collect();
    let mut power = vec![0.0; n / 2];
    for seed in 0..24 {
        let leaves = DeadLeaves { rows: n, cols: n, least_radius_px: 0.5, largest_radius_px: 5000.0, seed };
        let scene = dead_leaves(&leaves, &greys, &Setting { grid, ..Setting::default() }).unwrap();
        let one = radial_power(scene.radiance().planes().plane(0).unwrap(), n);
        power.iter_mut().zip(one).for_each(|(sum, p)| *sum += p);
    }
    // Straight line through log power over log frequency, from 3 to 64 cycles per image (a quarter per pixel).
    let points: Vec<[f64; 2]> = (3..=64).map(|f| [f64::from(f).ln(), power[f as usize].ln()]).collect();
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64;
    let (mx, my) = (mean(0), mean(1));
    let slope = points.iter().map(|p| (p[0] - mx) * (p[1] - my)).sum::<f64>()
        / points.iter().map(|p| (p[0] - mx).powi(2)).sum::<f64>();
    eprintln!("power spectrum falls as f^{slope:.2}");
    assert!((-2.2..=-1.7).contains(&slope), "power falls as f^{slope:.2}");
}

#[test]
fn dead_leaves_are_the_same_for_any_number_of_threads() {
    let list = macbeth::reflectances(GRID).unwrap();
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let leaves =
            DeadLeaves { rows: 100, cols: 70, least_radius_px: 1.5, largest_radius_px: 200.0, seed: 1 };
        pool.install(|| dead_leaves(&leaves, &list, &setting(10.0)).unwrap())
    };
    assert_eq!(draw(1), draw(5));
    let leaves = DeadLeaves { rows: 100, cols: 70, seed: 2, least_radius_px: 1.5, largest_radius_px: 200.0 };
    assert_ne!(draw(1), dead_leaves(&leaves, &list, &setting(10.0)).unwrap());
    assert!(dead_leaves(&leaves, &[], &setting(10.0)).is_err());
    let negative = [Spectrum::constant(GRID, -0.1).unwrap()];
    assert!(dead_leaves(&leaves, &negative, &setting(10.0)).is_err());
}

#[test]
fn the_room_spans_more_than_five_decades() {
    let scene = hdr(96, &setting(100.0)).unwrap();
    let mut luminance = scene.luminance_cd_m2().unwrap();
    luminance.sort_by(f32::total_cmp);
    assert!(luminance[0] > 0.0);
    // Even without the darkest and the brightest half percent, so it is areas that differ, not single pixels.
    let half_percent = luminance.len() / 200;
    let decades = |cut: usize| (luminance[luminance.len() - 1 - cut] / luminance[cut]).log10();
    eprintln!("{:.1} decades, {:.1} without a percent", decades(0), decades(half_percent));
    assert!(decades(0) > 7.0 && decades(half_percent) > 5.0);
}

/// Patches are squares of the sizes asked for, each of one colour; the smallest and the largest both occur.
#[test]
fn color_patches_are_even_and_of_several_sizes() {
    let list = macbeth::reflectances(GRID).unwrap();
    let chart = ColorPatches { rows: 128, cols: 128, least_px: 4, doublings: 3, seed: 2 };
    let luminance = color_patches(&chart, &list, &setting(10.0)).unwrap().luminance_cd_m2().unwrap();
    let at = |row: usize, col: usize| luminance[row * 128 + col];
    let even = |side: usize, down: usize, right: usize| {
        let first = at(down * side, right * side);
        (0..side * side).all(|i| at(down * side + i / side, right * side + i % side) == first)
    };
    let squares = |side: usize| (0..128 / side).flat_map(move |d| (0..128 / side).map(move |r| (d, r)));
    assert!(squares(4).all(|(d, r)| even(4, d, r)));
    for side in [8, 16, 32] {
        let evens = squares(side).filter(|&(d, r)| even(side, d, r)).count();
        assert!(evens > 0 && evens < (128 / side) * (128 / side), "{side}: {evens}");
    }
}

/// Neighbours differ by no more than the lattice's steepest slope; white paper stays white in every light.
#[test]
fn gradients_are_smooth() {
    let list = macbeth::reflectances(GRID).unwrap();
    let pattern =
        Gradients { rows: 96, cols: 96, cell_px: 32, contrast_ratio: 10.0, neutral: false, seed: 1 };
    let luminance = gradients(&pattern, &list, &setting(10.0)).unwrap().luminance_cd_m2().unwrap();
    // The reflectances span 30:1, the light 10:1, over 32 pixels.
    let steepest = (0..96 * 95).map(|i| (luminance[i + 96] / luminance[i]).ln().abs()).fold(0.0, f32::max);
    assert!(steepest < (31.0f32).ln() / 3.0 && steepest > 0.01, "{steepest}");
    let paper = gradients(&Gradients { neutral: true, ..pattern }, &list, &setting(10.0)).unwrap();
    let light = paper.illuminant().values();
    let planes: Vec<&[f32]> = paper.radiance().planes().planes().collect();
    let ratio = |band: usize, i: usize| f64::from(planes[band][i]) / light[band];
    assert!((0..96 * 96).all(|i| (ratio(3, i) / ratio(20, i) - 1.0).abs() < 1e-5));
}

/// Highlights and lamps are many times as bright as paper in full light, and of the light's own colour.
#[test]
fn glossy_balls_have_white_highlights_and_deep_shade() {
    let list = macbeth::reflectances(GRID).unwrap();
    let pattern = GlossyBalls { rows: 160, cols: 160, shade: 1000.0, seed: 1 };
    let scene = glossy_balls(&pattern, &list, &setting(10.0)).unwrap();
    let luminance = scene.luminance_cd_m2().unwrap();
    let (brightest, most) = luminance.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    let least = luminance.iter().copied().fold(f32::INFINITY, f32::min);
    assert!(most / least > 1e4, "{most} {least}");
    let light = scene.illuminant().values();
    let planes: Vec<&[f32]> = scene.radiance().planes().planes().collect();
    let ratio = |band: usize| f64::from(planes[band][brightest]) / light[band];
    assert!(ratio(20) > 5.0 && (ratio(3) / ratio(20) - 1.0).abs() < 0.05);
    let again = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(again.install(|| glossy_balls(&pattern, &list, &setting(10.0)).unwrap()), scene);
    for bad in [0.5, f64::NAN] {
        assert!(glossy_balls(&GlossyBalls { shade: bad, ..pattern }, &list, &setting(10.0)).is_err());
    }
}

#[test]
fn a_zone_plate_keeps_its_symmetry_and_contrast() {
    let scene = zone_plate(&ZonePlate { size: 128, frequency: 0.5, contrast: 0.8 }, &setting(100.0)).unwrap();
    let (plane, n) = (scene.radiance().planes().plane(15).unwrap(), 128);
    for (r, c) in [(0, 5), (17, 63), (40, 90)] {
        let v = plane[r * n + c];
        for mirrored in [plane[r * n + n - 1 - c], plane[(n - 1 - r) * n + c], plane[c * n + r]] {
            assert!((v / mirrored - 1.0).abs() < 1e-6);
        }
    }
    let white = scene.illuminant().values()[15] as f32;
    let (least, most) =
        plane.iter().fold((f32::MAX, 0.0f32), |(a, b), &v| (a.min(v / white), b.max(v / white)));
    assert!(least > 0.1 && most <= 0.9 && most > 0.89, "{least} {most}");
}
