//! Sensors and images that the tests of the sensor share. Not every test uses everything.
#![allow(dead_code, missing_docs, unreachable_pub, clippy::unwrap_used)]

pub mod reference;

use smalti::numeric::{Planes, philox::Stream};
use smalti::optics::OpticalImage;
use smalti::sensor::{Adc, Cfa, Channel, Mosaic, NonUniformity, Pixel, RawImage, RawSamples, Sensor};
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

pub const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

/// The pixel of the reference values.
pub fn pixel() -> Pixel {
    Pixel {
        pitch_m: 2.8e-6,
        fill_factor: 0.5,
        conversion_gain_v_per_e: 1e-4,
        voltage_swing_v: 1.0,
        full_well_e: 10_000.0,
        dark_voltage_v_per_s: 0.0,
        read_noise_v: 0.0,
    }
}

/// A Bayer mosaic G R / B G over filters R, G, B.
pub fn bayer(filters: [Spectrum; 3]) -> Cfa {
    let names = ["R", "G", "B"].map(String::from);
    let channels =
        names.into_iter().zip(filters).map(|(name, transmittance)| Channel { name, transmittance });
    Cfa::new("Bayer", Mosaic::new(2, 2, vec![1, 0, 2, 1]).unwrap(), channels.collect()).unwrap()
}

pub fn mono() -> Cfa {
    let channel = Channel { name: "W".into(), transmittance: Spectrum::constant(GRID, 1.0).unwrap() };
    Cfa::new("mono", Mosaic::new(1, 1, vec![0]).unwrap(), vec![channel]).unwrap()
}

/// Gaussian filters, no noise.
pub fn sensor(rows: usize, cols: usize) -> Sensor {
    let gaussian =
        |centre: f64| Spectrum::from_fn(GRID, |nm| (-((nm - centre) / 40.0).powi(2) / 2.0).exp()).unwrap();
    let cfa = bayer([gaussian(610.0), gaussian(540.0), gaussian(460.0)]);
    Sensor::new(rows, cols, pixel(), cfa, Spectrum::constant(GRID, 1.0).unwrap())
}

/// Every kind of noise, crosstalk and defects.
pub fn noisy_sensor(rows: usize, cols: usize) -> Sensor {
    let mut s = sensor(rows, cols);
    s.pixel.dark_voltage_v_per_s = 1e-2;
    s.pixel.read_noise_v = 1e-3;
    s.crosstalk = Some([[0.0, 0.02, 0.0], [0.03, 0.9, 0.05], [0.0, 0.0, 0.0]]);
    s.nonuniformity = NonUniformity {
        prnu_fraction: 0.02,
        dsnu_v: 1e-3,
        row_noise_v: 1e-3,
        column_noise_v: 1e-3,
        dead_pixel_fraction: 0.01,
        hot_pixel_fraction: 0.01,
        device_serial: 42,
        ..NonUniformity::default()
    };
    s.adc = Adc { bits: 12, black_level_dn: 64.0 };
    s
}

pub fn image(rows: usize, cols: usize, spacing_m: f64, data: Vec<f32>) -> OpticalImage {
    let cube = SpectralCube::new(GRID, Planes::new(rows, cols, 31, data).unwrap()).unwrap();
    OpticalImage::new(cube, spacing_m).unwrap()
}

/// The same irradiance everywhere.
pub fn flat(rows: usize, cols: usize, spacing_m: f64, photons: f32) -> OpticalImage {
    image(rows, cols, spacing_m, vec![photons; rows * cols * 31])
}

/// A flat image of a spectrum.
pub fn flat_spectrum(rows: usize, cols: usize, spacing_m: f64, photons: &[f64]) -> OpticalImage {
    image(rows, cols, spacing_m, photons.iter().flat_map(|&v| vec![v as f32; rows * cols]).collect())
}

/// Random irradiance from nothing to a few hundred electrons.
pub fn speckle(rows: usize, cols: usize, spacing_m: f64) -> OpticalImage {
    let mut stream = Stream::new(5, 0, 0);
    let data = (0..rows * cols * 31).map(|_| (stream.uniform().powi(4) * 1e14) as f32).collect();
    image(rows, cols, spacing_m, data)
}

pub fn values(raw: &RawImage) -> Vec<f32> {
    match raw.samples() {
        RawSamples::Digital(v) => v.iter().map(|&x| f32::from(x)).collect(),
        RawSamples::Analog(v) => v.clone(),
    }
}

/// Mean and variance.
pub fn moments(values: &[f32]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
    (mean, values.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / (n - 1.0))
}

/// The values that a channel of the mosaic has seen, of a whole capture.
pub fn of_channel(s: &Sensor, values: &[f32], channel: usize) -> Vec<f32> {
    let of = |i: usize| s.cfa.mosaic().channel_at(i / s.cols, i % s.cols);
    values.iter().enumerate().filter(|(i, _)| of(*i) == channel).map(|(_, v)| *v).collect()
}
