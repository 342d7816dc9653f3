//! Screening of colour filter arrays in closed form: cost against tile, filters, classes and figures, with the least number of products
//! that each needs.
#![allow(clippy::expect_used)]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use smalti::camera::{Camera, CameraDescription};
use smalti::design::light::{LightClasses, LightSettings, LightStatistics};
use smalti::design::screen::{FigureWeights, Figures, FilterResponses, Screen, ScreenCondition, ScreenTime};
use smalti::experiment::{Resources, light_statistics};
use smalti::scene::{Setting, catalog};
use smalti::sensor::Mosaic;
use smalti::spectrum::{Illuminant, Spectrum, WavelengthGrid};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;
/// Arrays of one call.
const SETS: usize = 64;
/// Multiplications of eight numbers that a core with two units of that width starts per second at 3 GHz.
const PRODUCTS_PER_S: f64 = 6e9;

/// Two classes of contrast, or fifteen with luminance as well.
fn classes(many: bool) -> LightClasses {
    let luminance_cuts = if many { vec![0.15, 0.4, 0.9, 1.8] } else { Vec::new() };
    let contrast_cuts = if many { vec![0.03, 0.15] } else { vec![0.15] };
    LightClasses { luminance_cuts, contrast_cuts, ..LightClasses::default() }
}

fn statistics(camera: &Camera, classes: LightClasses) -> LightStatistics {
    let setting = Setting { grid: GRID, ..Setting::default() };
    let natural = smalti::spectrum::reflectance::natural(GRID).expect("reflectances");
    let reflectances: Vec<Spectrum> = natural.into_iter().map(|(_, s)| s).collect();
    let spec = "dead-leaves?rows=600&cols=600&seed=1&least=2&largest=90";
    let scene = catalog::build(spec, &setting, &reflectances).expect("leaves");
    let deg = camera.field_of_view_deg(300, setting.distance_m).expect("an angle");
    let scene = scene.with_fov(deg).expect("a scene");
    let settings = LightSettings { max_left_out: 0.0, classes, ..LightSettings::default() };
    light_statistics(camera, &Illuminant::D65, Some(&[scene]), &settings, Resources::default())
        .expect("statistics")
}

fn screen(many_classes: bool) -> Screen {
    let mut d = CameraDescription::default();
    (d.sensor.adc_bits, d.sensor.pixel.pitch_um) = (0, 2.2);
    let camera = Camera::new(d, GRID).expect("a camera");
    let condition = |luminance_cd_m2| ScreenCondition { luminance_cd_m2, time: ScreenTime::Fixed(0.1) };
    let conditions = [1.0, 10.0, 80.0].map(condition);
    Screen::new(&camera, &statistics(&camera, classes(many_classes)), &conditions).expect("a screen")
}

/// Filters with some response to all components.
fn sets(screen: &Screen, filters: usize) -> Vec<FilterResponses> {
    let components = screen.response_spectra().len();
    let value = |s: usize, f: usize, k: usize| {
        20.0 * libm::sin((7 * s + 3 * f + 5 * k) as f64) + if k == 0 { 400.0 } else { 0.0 }
    };
    let filter = |s: usize, f: usize| (0..components).map(|k| value(s, f, k)).collect();
    (0..SETS).map(|s| FilterResponses::new((0..filters).map(|f| filter(s, f)).collect())).collect()
}

fn mosaic(rows: usize, cols: usize, filters: usize) -> Mosaic {
    Mosaic::new(rows, cols, (0..rows * cols).map(|c| (c % filters) as u8).collect()).expect("a tile")
}

/// The least number of products of eight numbers for an array: covariances of all pairs of pixels, and factorisations.
fn products(screen: &Screen, positions: usize, filters: usize) -> f64 {
    let (taps, k) = (25.0, screen.response_spectra().len() as f64);
    let (pairs, groups) = (taps * (taps + 1.0) / 2.0, screen.classes().div_ceil(8) as f64);
    let covariances = pairs * k * (k * filters as f64 + positions as f64);
    let factors = (taps * taps * taps / 6.0 + 3.0 * taps * taps / 2.0) * 3.0 * positions as f64;
    groups * (covariances + factors)
}

fn screening(c: &mut Criterion) {
    let screens = [screen(false), screen(true)];
    let mut group = c.benchmark_group("screening");
    group.sample_size(10).throughput(Throughput::Elements(SETS as u64));
    let mut run = |name: &str, screen: &Screen, (rows, cols, filters): (usize, usize, usize), figures| {
        let (mosaic, sets) = (mosaic(rows, cols, filters), sets(screen, filters));
        let limit = PRODUCTS_PER_S / products(screen, rows * cols, filters);
        println!("{name}: at most {limit:.0} arrays per second and core for CPSNR");
        group.bench_function(BenchmarkId::from_parameter(name), |b| {
            b.iter(|| screen.expected_of(black_box(&mosaic), &sets, figures))
        });
    };
    let [few, many] = &screens;
    for (rows, cols) in [(2, 2), (3, 3), (4, 4), (8, 8)] {
        run(&format!("tile {rows} x {cols}, 4 filters, 15 classes"), many, (rows, cols, 4), Figures::Cpsnr);
    }
    for filters in [3, 6, 9] {
        run(&format!("tile 3 x 3, {filters} filters, 15 classes"), many, (3, 3, filters), Figures::Cpsnr);
    }
    run("tile 2 x 2, 4 filters, 2 classes", few, (2, 2, 4), Figures::Cpsnr);
    run("tile 2 x 2, 4 filters, 2 classes, with colour differences", few, (2, 2, 4), Figures::Color);
    run("tile 2 x 2, 4 filters, 2 classes, with S-CIELAB", few, (2, 2, 4), Figures::All);
    group.finish();
    gradients(c, few);
}

/// The figures of one array with their derivatives, as in a step of the search, on one core.
fn gradients(c: &mut Criterion, screen: &Screen) {
    let mut group = c.benchmark_group("screening, derivatives");
    let (mosaic, sets) = (mosaic(2, 2, 4), sets(screen, 4));
    let none = FigureWeights::default();
    for (name, figures, weights) in [
        ("CPSNR", Figures::Cpsnr, FigureWeights { cpsnr_db: 1.0, ..none }),
        ("CPSNR and ΔE2000", Figures::Color, FigureWeights { cpsnr_db: 1.0, delta_e_2000: 1.0, ..none }),
        ("CPSNR and S-CIELAB", Figures::All, FigureWeights { cpsnr_db: 1.0, scielab: 1.0, ..none }),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| screen.differentiable(&mosaic, black_box(&sets[0]), figures).by_response(&[weights; 3]))
        });
    }
    group.finish();
}

criterion_group!(benches, screening);
criterion_main!(benches);
