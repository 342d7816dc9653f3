//! Rendering of a 4K frame of 16-bit samples with a learned table, classification included, on two threads.
//! `tools/bench_opencv.py` runs it beside OpenCV.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput};
use smalti::l3::{
    Axes, Class, Kernels, Levels, Origin, Pipeline, PipelineParts, REFINEMENT_INPUTS, Refinement,
    RefinementAxes, RefinementClass,
};
use smalti::numeric::Planes;
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling, SignalNoise};

const ROWS: usize = 2160;
const COLS: usize = 3840;
const BLACK: f64 = 256.0;
const WHITE: f64 = 65535.0;

fn main() {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    threads.install(|| run(&mut Criterion::default().configure_from_args()));
}

/// A picture from dark to clipped, with edges and noise; `tools/bench_opencv.py` makes the same.
fn sample(row: usize, col: usize) -> u16 {
    let i = row * COLS + col;
    let noise = (i.wrapping_mul(2_654_435_761) >> 16) & 1023;
    let edges = 1 + (row / 64 + col / 96) % 2;
    let light = row * (col + 400) * 40_000 / (ROWS * (COLS + 400));
    (256 + light * edges + noise).min(65_535) as u16
}

/// 4 positions × 15 levels × 2 textures × 2 combinations of clipped channels: 240 classes of 3 kernels, all distinct, and as large;
/// or, as in learned tables, of unlike magnitudes and some of them shared.
fn pipeline(mosaic: Mosaic, side: usize, learned: bool) -> Pipeline {
    let noise = SignalNoise { constant: 1e-6, per_signal: 1e-5, ..SignalNoise::default() };
    let levels = Levels::logarithmic(15, 0.002, 0.8).unwrap();
    let axes = Axes::new(mosaic, side, levels, noise).unwrap();
    let saturations = vec![0, 2];
    let count = axes.positions() * saturations.len() * axes.level_count() * axes.textures().count();
    assert_eq!(count, 240);
    let weight = |i: usize| ((i * 7919) % 1009) as f32 / 1009.0 / axes.taps() as f32;
    let of_class = |class: usize, i: usize| match (learned, class % 16) {
        (false, _) => weight(i),
        (true, 15) => 1.0 / axes.taps() as f32,
        (true, octave) => weight(i) / (1 << (octave % 9)) as f32,
    };
    let values = |each: usize, factor: f32| {
        (0..count * each).map(|i| factor * of_class(i / each, i)).collect::<Vec<f32>>()
    };
    let parts = PipelineParts {
        saturations,
        outputs: ["X", "Y", "Z"].map(String::from).to_vec(),
        channel_names: ["R", "G", "B"].map(String::from).to_vec(),
        black_level: BLACK,
        white_level: WHITE,
        trained: vec![[0.0, 1.0]; axes.positions()],
        classes: vec![Class { count: 1, origin: Origin::Learned }; count],
        kernels: Kernels { weights: values(3 * axes.taps(), 1.0), offsets: values(3, 0.01) },
        provenance: String::new(),
        axes,
    };
    Pipeline::from_parts(parts).unwrap()
}

/// A second stage of as many classes as cameras have, with distinct kernels.
fn refinement() -> Refinement {
    let axes = RefinementAxes::new(Levels::logarithmic(12, 0.002, 0.8).unwrap(), [1e-6, 1e-5, 0.0]).unwrap();
    let weight = |i: usize| ((i * 7919) % 1009) as f32 / 1009.0 / REFINEMENT_INPUTS as f32;
    let weights = (0..axes.count() * 3 * REFINEMENT_INPUTS).map(weight).collect();
    let offsets = (0..axes.count() * 3).map(weight).collect();
    let classes = vec![RefinementClass { count: 1, is_learned: true }; axes.count()];
    Refinement::new(axes, classes, weights, offsets).unwrap()
}

fn run(c: &mut Criterion) {
    let mut group = c.benchmark_group("l3 3840x2160");
    group.throughput(Throughput::Elements((ROWS * COLS) as u64)).sample_size(20);
    let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
    let samples = (0..ROWS * COLS).map(|i| sample(i / COLS, i % COLS)).collect();
    let names = ["R", "G", "B"].map(String::from).to_vec();
    let sampling = Sampling::Mosaic(mosaic.clone());
    let raw = RawImage::new(ROWS, COLS, RawSamples::Digital(samples), sampling, names, BLACK, WHITE).unwrap();
    // Into planes that exist already: what is measured is the work, not the system's handing out of memory.
    let mut planes = Planes::zeros(ROWS, COLS, 3);
    for (side, learned) in [(3, false), (5, false), (7, false), (5, true)] {
        let pipeline = pipeline(mosaic.clone(), side, learned);
        let what = if learned { ", unlike classes" } else { "" };
        let renderer = pipeline.renderer();
        group.bench_function(format!("l3 f32{what} {side}x{side}"), |b| {
            b.iter(|| renderer.render_into(black_box(&raw), &mut planes).unwrap());
        });
        let renderer = pipeline.fixed_renderer(BLACK, WHITE).unwrap();
        group.bench_function(format!("l3 fixed{what} {side}x{side}"), |b| {
            b.iter(|| renderer.render_into(black_box(&raw), &mut planes).unwrap());
        });
    }
    let best = pipeline(mosaic.clone(), 5, true).with_refinement(Some(refinement())).unwrap();
    let renderer = best.renderer();
    group.bench_function("l3 f32 best quality 5x5", |b| {
        b.iter(|| renderer.render_into(black_box(&raw), &mut planes).unwrap());
    });
    group.finish();
    c.final_summary();
}
