//! Training of learned pipelines on two threads: patches gathered per second, and solving of about 240 classes.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput};
use smalti::l3::{Axes, KernelForm, Levels, Pair, PerceptualWeights, Solver, Statistics, Training};
use smalti::numeric::Planes;
use smalti::numeric::philox::Stream;
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling, SignalNoise};

const ROWS: usize = 1080;
const COLS: usize = 1920;
const LEVELS: usize = 20;

/// A picture that grows brighter to the right and clips there, flat and textured in turns, of changing colour; noisy
/// samples and X, Y, Z without noise.
fn pictures(mosaic: &Mosaic, noise: &SignalNoise) -> (RawImage, RawImage, Planes) {
    let mut random = Stream::new(1, 2, 3);
    let color = |r: usize, channel: usize| [1.0, 0.5 + 0.5 * ((r / 40) % 5) as f64 / 4.0, 0.7][channel];
    let light = |r: usize, c: usize| {
        let flat = 2e-3 * (900.0_f64).powf(c as f64 / COLS as f64);
        let texture =
            if (r / 90).is_multiple_of(2) { 0.0 } else { 0.4 * ((r * 7 + c * 5) as f64 * 0.35).sin() };
        flat * (1.0 + texture)
    };
    let mut clean = Vec::with_capacity(ROWS * COLS);
    let mut noisy = Vec::with_capacity(ROWS * COLS);
    let mut target = vec![0.0; 3 * ROWS * COLS];
    for r in 0..ROWS {
        for c in 0..COLS {
            let x = light(r, c) * color(r, mosaic.channel_at(r, c));
            let spread = (random.uniform() + random.uniform() + random.uniform() - 1.5) * 2.0;
            let clipped = |x: f64| (64.0 + x * 3936.0).clamp(0.0, 4000.0).round() as u16;
            clean.push(clipped(x));
            noisy.push(clipped(x + spread * noise.variance(x).sqrt()));
            for k in 0..3 {
                target[(k * ROWS + r) * COLS + c] = (light(r, c) * color(r, k)) as f32;
            }
        }
    }
    let raw = |samples| {
        let names = ["R", "G", "B"].map(String::from).to_vec();
        let sampling = Sampling::Mosaic(mosaic.clone());
        RawImage::new(ROWS, COLS, RawSamples::Digital(samples), sampling, names, 64.0, 4000.0).unwrap()
    };
    (raw(clean), raw(noisy), Planes::new(ROWS, COLS, 3, target).unwrap())
}

fn main() {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    threads.install(|| run(&mut Criterion::default().configure_from_args()));
}

fn run(c: &mut Criterion) {
    let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
    let noise = SignalNoise { constant: 1e-6, per_signal: 1e-4, ..SignalNoise::default() };
    let (clean, noisy, target) = pictures(&mosaic, &noise);
    let axes = |side| {
        let levels = Levels::logarithmic(LEVELS, 0.003, 0.8).unwrap();
        Axes::new(mosaic.clone(), side, levels, noise).unwrap()
    };
    let outputs = || ["X", "Y", "Z"].map(String::from).to_vec();
    let gather = |side| {
        let mut s = Statistics::new(axes(side), outputs(), false).unwrap();
        s.add(&Pair { raw: &clean, seen: Some(&noisy), target: &target }).unwrap();
        s
    };
    let mut group = c.benchmark_group("l3 training 1920x1080");
    group.throughput(Throughput::Elements((ROWS * COLS) as u64)).sample_size(20);
    for side in [3, 5, 9, 11] {
        let classes = gather(side).classes().len();
        group.bench_function(format!("gather {side}x{side}, 3 outputs, {classes} classes"), |b| {
            b.iter(|| black_box(gather(side)));
        });
    }
    group.finish();

    let mut group = c.benchmark_group("l3 training");
    group.sample_size(20);
    let solvers = [
        ("perceptual", Solver::Perceptual(PerceptualWeights::default())),
        ("wiener", Solver::Wiener),
        ("ridge", Solver::Ridge),
        ("least squares", Solver::LeastSquares),
    ];
    for (name, solver) in solvers {
        for side in [5, 9] {
            let statistics = gather(side);
            let training = Training { solver, kernel: KernelForm::Affine, ..Training::default() };
            let classes = statistics.classes().len();
            group.bench_function(format!("solve {side}x{side}, 3 outputs, {classes} classes, {name}"), |b| {
                b.iter(|| training.solve(black_box(&statistics), String::new()).unwrap());
            });
        }
    }
    group.finish();
    c.final_summary();
}
