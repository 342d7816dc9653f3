//! Speed of a capture: 24 megapixels from a 2-megapixel optical image of 31 bands, all noise, 12 bits.

#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use smalti::numeric::Planes;
use smalti::optics::OpticalImage;
use smalti::sensor::{Adc, Cfa, Channel, Exposure, Mosaic, NoiseMode, NonUniformity, Pixel, Sensor};
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

const ROWS: usize = 4000;
const COLS: usize = 6000;

fn sensor() -> Sensor {
    let grid = WavelengthGrid::VISIBLE;
    let filter = |name: &str, centre: f64| Channel {
        name: name.into(),
        transmittance: Spectrum::from_fn(grid, |nm| (-((nm - centre) / 40.0).powi(2) / 2.0).exp()).unwrap(),
    };
    let channels = vec![filter("R", 610.0), filter("G", 540.0), filter("B", 460.0)];
    let mosaic = Mosaic::new(2, 2, vec![1, 0, 2, 1]).unwrap();
    let pixel = Pixel {
        pitch_m: 2e-6,
        fill_factor: 0.5,
        conversion_gain_v_per_e: 1e-4,
        voltage_swing_v: 1.0,
        full_well_e: 10_000.0,
        dark_voltage_v_per_s: 1e-3,
        read_noise_v: 1e-3,
    };
    let qe = Spectrum::constant(grid, 0.8).unwrap();
    let mut sensor = Sensor::new(ROWS, COLS, pixel, Cfa::new("Bayer", mosaic, channels).unwrap(), qe);
    sensor.adc = Adc { bits: 12, black_level_dn: 64.0 };
    sensor.nonuniformity = NonUniformity {
        prnu_fraction: 0.01,
        dsnu_v: 1e-3,
        row_noise_v: 1e-4,
        column_noise_v: 1e-4,
        device_serial: 1,
        ..NonUniformity::default()
    };
    sensor
}

/// A smooth picture of two decades, about 1000 photoelectrons in the mean.
fn image() -> OpticalImage {
    let (rows, cols) = (1160, 1740);
    let grid = WavelengthGrid::VISIBLE;
    let plane: Vec<f32> = (0..rows * cols)
        .map(|i| {
            let (x, y) = ((i % cols) as f32 / cols as f32, (i / cols) as f32 / rows as f32);
            10f32.powf(2.0 * x * (0.75 + 0.25 * (40.0 * y).sin())) * 5e14
        })
        .collect();
    let data = plane.repeat(grid.len());
    let cube = SpectralCube::new(grid, Planes::new(rows, cols, grid.len(), data).unwrap()).unwrap();
    OpticalImage::new(cube, COLS as f64 * 2e-6 / cols as f64).unwrap()
}

fn capture(c: &mut Criterion) {
    let (sensor, image) = (sensor(), image());
    let exposure = Exposure::new(0.0015);
    let mut group = c.benchmark_group("capture 24 megapixels");
    group.throughput(Throughput::Elements((ROWS * COLS) as u64)).sample_size(10);
    for mode in [NoiseMode::None, NoiseMode::PhotonOnly, NoiseMode::All] {
        group.bench_function(format!("{mode:?}"), |b| {
            b.iter(|| black_box(sensor.capture(&image, &exposure, mode, 1).unwrap()));
        });
    }
    // What remains beside the pixels: integration over wavelength.
    let mut small = sensor.clone();
    (small.rows, small.cols, small.pixel.pitch_m) = (40, 60, 2e-4);
    small.pixel.fill_factor = 1.0;
    group.bench_function("spectral integration alone", |b| {
        b.iter(|| black_box(small.expected_volts(&image, &exposure).unwrap()));
    });
    group.finish();
}

criterion_group!(benches, capture);
criterion_main!(benches);
