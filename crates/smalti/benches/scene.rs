//! Time to build scenes of 31 wavelengths.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use smalti::scene::{
    DeadLeaves, Setting, SlantedBar, ZonePlate, dead_leaves, hdr, macbeth, slanted_bar, zone_plate,
};
use smalti::spectrum::Illuminant;

fn scenes(c: &mut Criterion) {
    let setting = Setting::default();
    let list = macbeth::reflectances(setting.grid).unwrap();
    let mut group = c.benchmark_group("scene");
    group.sample_size(10);
    let leaves =
        DeadLeaves { rows: 1024, cols: 1024, least_radius_px: 1.5, largest_radius_px: 200.0, seed: 1 };
    group.bench_function("dead leaves 1024x1024", |b| {
        b.iter(|| dead_leaves(&leaves, &list, &setting).unwrap());
    });
    group.bench_function("macbeth 128x192", |b| b.iter(|| macbeth::chart(32, &setting).unwrap()));
    let chart = macbeth::chart(32, &setting).unwrap();
    group.bench_function("macbeth relit", |b| {
        b.iter(|| chart.clone().relit(&Illuminant::A).unwrap());
    });
    let bar = SlantedBar::default();
    group.bench_function("slanted bar 513x513", |b| b.iter(|| slanted_bar(&bar, &setting).unwrap()));
    let plate = ZonePlate { size: 1024, ..ZonePlate::default() };
    group.bench_function("zone plate 1024x1024", |b| b.iter(|| zone_plate(&plate, &setting).unwrap()));
    group.bench_function("hdr 384x576", |b| b.iter(|| hdr(384, &setting).unwrap()));
    group.finish();
}

criterion_group!(benches, scenes);
criterion_main!(benches);
