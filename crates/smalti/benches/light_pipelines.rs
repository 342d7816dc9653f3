//! Pipelines learned from statistics of light: cost of a design against tile, classes and patch, beside the products of its factorisations.
#![allow(clippy::expect_used)]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use smalti::camera::{Camera, CameraDescription, EvaluationSettings};
use smalti::design::{LearningSettings, LearningStatistics, Metric, PipelineTrainer, Targets};
use smalti::l3::Textures;
use smalti::sensor::{Cfa, Channel, Filter, Mosaic};
use smalti::spectrum::WavelengthGrid;

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;
/// Multiplications of eight numbers that a core with two units of that width starts per second at 3 GHz.
const PRODUCTS_PER_S: f64 = 6e9;

/// Gaussian filters in a tile, one after the other.
fn cfa(rows: usize, cols: usize, filters: usize) -> Cfa {
    let channel = |c: usize| Channel {
        name: c.to_string(),
        transmittance: Filter::Gaussian {
            center_nm: 430.0 + 240.0 * c as f64 / (filters - 1) as f64,
            sigma_nm: 30.0 + (c * 7 % 20) as f64,
            peak: 1.0,
        }
        .spectrum(GRID)
        .expect("a Gaussian"),
    };
    let cells = (0..rows * cols).map(|c| (c % filters) as u8).collect();
    let mosaic = Mosaic::new(rows, cols, cells).expect("a tile");
    Cfa::new("bench", mosaic, (0..filters).map(channel).collect()).expect("a CFA")
}

/// The least time of a design on one core: its factorisations, a matrix for each class and position.
fn least_s(side: usize, classes: usize, positions: usize) -> f64 {
    let taps = (side * side) as f64;
    let factor = taps * taps * taps / 6.0 + 3.0 * taps * taps / 2.0;
    (positions * classes.div_ceil(8)) as f64 * factor / PRODUCTS_PER_S
}

fn pipelines(c: &mut Criterion) {
    let mut d = CameraDescription::default();
    (d.sensor.adc_bits, d.sensor.pixel.pitch_um, d.sensor.pixel.fill_factor) = (0, 2.8, 0.5);
    let camera = Camera::new(d, GRID).expect("a camera");
    let settings = EvaluationSettings::default();
    let targets = Targets::new(&camera, &settings, &Metric::USUAL, &[], &|_, make| make()).expect("targets");
    let light = LearningSettings {
        statistics: LearningStatistics::Light,
        size_px: 192,
        ..LearningSettings::default()
    };
    let mut group = c.benchmark_group("pipeline from light, one core");
    group.sample_size(20);
    let cases = [
        ((2, 2, 4), light.clone()),
        ((2, 3, 6), light.clone()),
        ((3, 3, 7), light.clone()),
        ((4, 4, 4), light.clone()),
        ((2, 2, 4), LearningSettings { side: 5, ..light.clone() }),
        ((2, 2, 4), LearningSettings { levels: 16, ..light.clone() }),
        ((2, 2, 4), LearningSettings { textures: Textures::FlatTexture, ..light }),
    ];
    for ((rows, cols, filters), settings) in cases {
        let trainer = PipelineTrainer::new(&targets, &settings, &|_, make| make()).expect("a trainer");
        let cfa = cfa(rows, cols, filters);
        trainer.prepare(cfa.mosaic()).expect("statistics");
        let classes = settings.levels * settings.textures.count();
        let name = format!(
            "tile {rows} x {cols}, {filters} filters, {classes} classes, patch {0} x {0}",
            settings.side
        );
        let least_ms = least_s(settings.side, classes, rows * cols) * 1e3;
        println!("{name}: at least {least_ms:.2} ms for the factorisations of all positions");
        group.bench_function(BenchmarkId::from_parameter(name), |b| {
            b.iter(|| trainer.pipeline(black_box(&cfa)).expect("a pipeline"))
        });
    }
    group.finish();
}

criterion_group!(benches, pipelines);
criterion_main!(benches);
