//! Scoring of designs on kept targets: the camera of table 1 of "Resolution in Color Filter Array Images", 3 to 7 colours.
#![allow(clippy::expect_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rayon::prelude::*;
use smalti::camera::{Camera, CameraDescription, CameraError, EvaluationSettings};
use smalti::design::statistics::{Objective, pareto_front};
use smalti::design::{LearningSettings, Metric, PipelineTrainer, Scores, Targets};
use smalti::numeric::philox::Stream;
use smalti::sensor::{Cfa, Channel, Filter, Mosaic};
use smalti::spectrum::WavelengthGrid;

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

fn cfa(colors: usize, i: usize) -> Cfa {
    let channel = |c: usize| Channel {
        name: c.to_string(),
        transmittance: Filter::Gaussian {
            center_nm: 430.0 + 240.0 * c as f64 / (colors - 1) as f64 + (i % 7) as f64,
            sigma_nm: 20.0 + ((i * 5 + c * 7) % 31) as f64,
            peak: 1.0,
        }
        .spectrum(GRID)
        .expect("a Gaussian"),
    };
    let (side, cells): (usize, Vec<u8>) = match colors {
        3 => (2, vec![1, 2, 0, 1]),
        4 => (2, vec![0, 1, 2, 3]),
        n => (3, (0..9).map(|c| (c % n) as u8).collect()),
    };
    let mosaic = Mosaic::new(side, side, cells).expect("a tile");
    Cfa::new("bench", mosaic, (0..colors).map(channel).collect()).expect("a CFA")
}

fn designs(c: &mut Criterion) {
    let mut d = CameraDescription::default();
    (d.sensor.adc_bits, d.sensor.pixel.pitch_um, d.sensor.pixel.fill_factor) = (0, 2.8, 0.5);
    let camera = Camera::new(d, GRID).expect("a camera");
    let settings = EvaluationSettings::default();
    let targets = Targets::new(&camera, &settings, &Metric::USUAL, &[], &|_, make| make()).expect("targets");
    let mut group = c.benchmark_group("designs");
    for colors in 3..=7 {
        let one = cfa(colors, 3);
        group.bench_function(format!("{colors} colours, one"), |b| b.iter(|| targets.score(black_box(&one))));
    }
    let many: Vec<Cfa> = (0..200).map(|i| cfa(3 + i % 5, i)).collect();
    group.throughput(Throughput::Elements(many.len() as u64));
    group.bench_function("3 to 7 colours, all cores", |b| {
        b.iter(|| many.par_iter().map(|cfa| targets.score(cfa)).collect::<Vec<_>>())
    });
    let trainer =
        PipelineTrainer::new(&targets, &LearningSettings::default(), &|_, make| make()).expect("trainer");
    let learned = |cfa: &Cfa| -> Result<Scores, CameraError> {
        let (pipeline, reach) = trainer.pipeline(cfa)?;
        targets.score_with(cfa, &pipeline.renderer(), reach)
    };
    let some = &many[..40];
    group.sample_size(10).throughput(Throughput::Elements(some.len() as u64));
    group.bench_function("learned, 3 to 7 colours, all cores", |b| {
        b.iter(|| some.par_iter().map(learned).collect::<Vec<_>>())
    });
    group.finish();
}

/// The front of scores that lie as those of a study do: better colour goes with worse resolution.
fn front(c: &mut Criterion) {
    let mut group = c.benchmark_group("pareto front");
    for count in [10_000usize, 100_000, 1_000_000] {
        let mut stream = Stream::new(1, 0, 0);
        let rows: Vec<[f64; 3]> = (0..count)
            .map(|_| {
                let [a, b, c] = [(); 3].map(|()| stream.uniform());
                [1.0 + 9.0 * a, 60.0 + 70.0 * a + 5.0 * b, 1.0 + 3.0 * (1.0 - a) + c]
            })
            .collect();
        let column = |i: usize| rows.iter().map(|r| r[i]).collect::<Vec<f64>>();
        let (delta_e, mtf50, noise) = (column(0), column(1), column(2));
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(format!("{count} designs, three objectives"), |b| {
            b.iter(|| {
                let objectives =
                    [Objective::lower(&delta_e), Objective::higher(&mtf50), Objective::lower(&noise)];
                pareto_front(black_box(&objectives)).expect("a front")
            })
        });
    }
    group.finish();
}

criterion_group!(benches, designs, front);
criterion_main!(benches);
