//! Time of the metrics that look at whole pictures, of the edge that every evaluation measures, and of the colorimetry of sensors.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use smalti::camera::{Camera, CameraDescription, ColorimetricObserver};
use smalti::metrics::Rect;
use smalti::metrics::aliasing::aliasing;
use smalti::metrics::esfr::{EsfrOptions, find_edge_region, picture_sfr};
use smalti::metrics::psnr::psnr;
use smalti::numeric::Planes;
use smalti::sensor::{Cfa, Channel, Filter, Mosaic};
use smalti::spectrum::{Illuminant, WavelengthGrid};

/// A neutral edge, slope 1:10, a little blurred.
fn edge(rows: usize, cols: usize) -> Planes {
    let value = |i: usize| {
        let (y, x) = ((i / cols % rows) as f64, (i % cols) as f64);
        (0.5 + 0.4 * (x - cols as f64 / 2.0 - (y - rows as f64 / 2.0) / 10.0).tanh()) as f32
    };
    Planes::new(rows, cols, 3, (0..3 * rows * cols).map(value).collect()).unwrap()
}

/// A zone plate up to `top` cycles per pixel at the sides.
fn zone_plate(size: usize, top: f64) -> Planes {
    let middle = size as f64 / 2.0;
    let value = |i: usize| {
        let (y, x) = ((i / size % size) as f64 - middle, (i % size) as f64 - middle);
        (0.5 + 0.4 * (std::f64::consts::PI * top / middle * (x * x + y * y)).cos()) as f32
    };
    Planes::new(size, size, 3, (0..3 * size * size).map(value).collect()).unwrap()
}

/// A camera of evenly spaced Gaussian filters.
fn camera(colors: u8) -> Camera {
    let grid = WavelengthGrid::VISIBLE;
    let channel = |i: u8| {
        let center_nm = 430.0 + 200.0 * f64::from(i) / f64::from(colors - 1);
        let filter = Filter::Gaussian { center_nm, sigma_nm: 30.0, peak: 1.0 };
        Channel { name: i.to_string(), transmittance: filter.spectrum(grid).unwrap() }
    };
    let mosaic = Mosaic::new(1, usize::from(colors), (0..colors).collect()).unwrap();
    let cfa = Cfa::new("even", mosaic, (0..colors).map(channel).collect()).unwrap();
    Camera::new(CameraDescription::default(), grid).unwrap().with_cfa(cfa)
}

fn benches(c: &mut Criterion) {
    let light = Illuminant::D65.photons(WavelengthGrid::VISIBLE).unwrap();
    let observer = ColorimetricObserver::new(&light).unwrap();
    for colors in [3, 4, 6] {
        let camera = camera(colors);
        let name = format!("colorimetry of a sensor of {colors} colours");
        c.bench_function(&name, |b| b.iter(|| observer.colorimetry(&camera)));
    }
    let small = edge(66, 44);
    let options = EsfrOptions::default();
    let weights = [0.2126, 0.7152, 0.0722];
    c.bench_function("esfr of 3 planes and luminance, 66 x 44", |b| {
        b.iter(|| picture_sfr(&small, Rect::whole(66, 44), &weights, &options));
    });
    let large = edge(480, 640);
    c.bench_function("edge region found, 640 x 480", |b| b.iter(|| find_edge_region(&large, 1)));
    let (sharp, soft) = (zone_plate(384, 0.45), zone_plate(384, 0.44));
    c.bench_function("aliasing, 384 x 384 x 3", |b| b.iter(|| aliasing(&soft, &sharp, &weights)));
    c.bench_function("psnr, 384 x 384 x 3", |b| b.iter(|| psnr(&soft, &sharp, Rect::whole(384, 384), 1.0)));
}

criterion_group!(metrics, benches);
criterion_main!(metrics);
