//! Colour on pictures of a megapixel (encoding: 24 megapixels).
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use smalti::color::difference::delta_e_map;
use smalti::color::jakob_hanika2019::Uplift;
use smalti::color::repaint::Repaint;
use smalti::color::scielab::scielab;
use smalti::color::{ColorSpace, DeltaE, Image};
use smalti::numeric::Planes;
use smalti::spectrum::{Observer, WavelengthGrid};

/// Smooth shading with detail on it; every colour of sRGB comes up.
fn picture(rows: usize, cols: usize, phase: f32) -> Image {
    let n = rows * cols;
    let value = |i: usize| {
        let (c, at) = (i / n, i % n);
        let (y, x) = ((at / cols) as f32 / rows as f32, (at % cols) as f32 / cols as f32);
        let k = 7.0 + 4.0 * c as f32;
        0.5 + 0.45 * (k * x + phase).sin() * (k * y).cos() + 0.05 * (911.0 * x * y).sin()
    };
    let data = (0..3 * n).map(value).collect();
    Image::new(ColorSpace::LinearSrgb, Planes::new(rows, cols, 3, data).unwrap()).unwrap()
}

fn color(c: &mut Criterion) {
    let rgb = picture(1000, 1000, 0.0);
    let white = [0.95047, 1.0, 1.08883];
    let [a, b] = [0.0, 0.05].map(|p| picture(1000, 1000, p).converted(ColorSpace::Xyz).unwrap());
    let mut g = c.benchmark_group("color");
    g.sample_size(10);
    g.throughput(Throughput::Elements(1_000_000));
    g.bench_function("delta_e_2000_map_1mp", |t| {
        t.iter(|| delta_e_map(&a, &b, white, DeltaE::Ciede2000).unwrap());
    });
    g.bench_function("scielab_1mp_60_per_degree", |t| {
        t.iter(|| scielab(&a, &b, white, 60.0, DeltaE::Ciede2000).unwrap());
    });
    g.bench_function("uplift_table", |t| {
        t.iter(|| Uplift::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap());
    });
    let uplift = Uplift::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap();
    g.bench_function("uplift_1mp_31_bands", |t| t.iter(|| uplift.uplift_image(&rgb).unwrap()));
    g.throughput(Throughput::Elements(576 * 768));
    let photograph = picture(576, 768, 0.0);
    let repaint = Repaint::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap();
    g.bench_function("repaint_576_768_31_bands", |t| t.iter(|| repaint.repaint_image(&photograph).unwrap()));
    let large = picture(4000, 6000, 0.0);
    g.throughput(Throughput::Elements(24_000_000));
    g.bench_function("srgb_encode_24mp", |t| t.iter(|| large.converted(ColorSpace::Srgb).unwrap()));
    g.bench_function("xyz_to_srgb_24mp", |t| {
        let xyz = large.converted(ColorSpace::Xyz).unwrap();
        t.iter(|| xyz.converted(ColorSpace::Srgb).unwrap());
    });
    g.finish();
}

criterion_group!(benches, color);
criterion_main!(benches);
