//! The scenes, lens and sensors that the reference values of ISETCam are of, built with Smalti.

use super::{numbers, reference_csv, reference_json};
use serde_json::Value;
use smalti::numeric::Planes;
use smalti::optics::{OpticalImage, Optics};
use smalti::scene::Scene;
use smalti::sensor::{Cfa, Channel, Exposure, Mosaic, Pixel, Sensor};
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

pub const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

pub const FOCAL_LENGTH_M: f64 = 0.003862755099228297;

/// Diffraction-limited, f/4, cos⁴.
pub fn lens() -> Optics {
    Optics::new(FOCAL_LENGTH_M, 4.0)
}

/// 2.8 µm, half of it sensitive.
pub fn pixel() -> Pixel {
    Pixel {
        pitch_m: 2.8e-6,
        fill_factor: 0.5,
        conversion_gain_v_per_e: 1e-4,
        voltage_swing_v: 1.0,
        full_well_e: 10_000.0,
        dark_voltage_v_per_s: 1e-3,
        read_noise_v: 1e-3,
    }
}

/// A scene 1.2 m away, of photons by band, row and column.
pub fn scene(rows: usize, cols: usize, fov_deg: f64, photons: impl Fn(usize, usize, usize) -> f64) -> Scene {
    let mut planes = Planes::zeros(rows, cols, GRID.len());
    for band in 0..GRID.len() {
        for (i, v) in planes.plane_mut(band).unwrap().iter_mut().enumerate() {
            *v = photons(band, i / cols, i % cols) as f32;
        }
    }
    let cube = SpectralCube::new(GRID, planes).unwrap();
    Scene::new("reference", cube, Spectrum::constant(GRID, 1.0).unwrap(), 1.2, fov_deg).unwrap()
}

/// The ColorChecker. ISETCam counts patches column by column.
pub fn chart() -> Scene {
    let photons = reference_csv("scene_macbeth_d65_photons.csv");
    scene(128, 192, 10.0, |b, r, c| photons[c / 32 * 4 + r / 32][b])
}

/// The slanted edge. ISETCam compares in single precision, which decides about the lattice points that lie exactly on
/// the line.
pub fn bar() -> Scene {
    let json = reference_json("scene_slantedbar.json");
    let (dark, bright) = (numbers(&json["dark_photons"]), numbers(&json["bright_photons"]));
    scene(
        513,
        513,
        5.0,
        |b, r, c| {
            if r as f32 - 256.0 > 7.0 / 3.0 * (c as f32 - 256.0) { bright[b] } else { dark[b] }
        },
    )
}

pub fn image_of(scene: &Scene) -> OpticalImage {
    lens().image(scene).unwrap()
}

/// ISETCam's aperture for the edge, together with `Aperture::Point`: a Gaussian with σ of ⌈2.8 µm / 0.66 µm⌉/4 = 5/4 samples, cut
/// off at 5 × 5 samples and scaled to sum 1; dark beyond the border.
pub fn blurred_for_the_edge(image: &OpticalImage) -> OpticalImage {
    const RADIUS: usize = 2;
    const SIGMA: f64 = 1.25;
    let cube = image.irradiance();
    let mut planes = cube.planes().clone();
    let bell = |i: usize| (-(i as f64 - RADIUS as f64).powi(2) / (2.0 * SIGMA * SIGMA)).exp() as f32;
    let kernel: Vec<f32> = (0..=2 * RADIUS).map(bell).collect();
    let sum: f32 = kernel.iter().sum();
    let (rows, cols) = (cube.rows(), cube.cols());
    // Along rows, then along columns: the samples of a line lie `step` apart.
    for (step, len, across, lines) in [(1, cols, cols, rows), (cols, rows, 1, cols)] {
        for band in 0..planes.count() {
            let plane = planes.plane_mut(band).unwrap();
            for line in 0..lines {
                let start = line * across;
                let source: Vec<f32> = (0..len).map(|i| plane[start + i * step]).collect();
                let padded = [vec![0.0; RADIUS], source, vec![0.0; RADIUS]].concat();
                for (i, w) in padded.windows(kernel.len()).enumerate() {
                    plane[start + i * step] = w.iter().zip(&kernel).map(|(v, k)| v * k).sum::<f32>() / sum;
                }
            }
        }
    }
    OpticalImage::new(SpectralCube::new(GRID, planes).unwrap(), image.sample_spacing_m()).unwrap()
}

/// The mosaic of a pattern of channel numbers from 1.
pub fn mosaic(pattern: &Value) -> Mosaic {
    let rows = pattern.as_array().unwrap().len();
    let cells: Vec<u8> = numbers(pattern).iter().map(|v| *v as u8 - 1).collect();
    Mosaic::new(rows, cells.len() / rows, cells).unwrap()
}

/// One of the cameras, `ip_case_<id>.json`.
pub struct Case {
    pub json: Value,
    pub cfa: Cfa,
}

impl Case {
    pub fn new(id: &str) -> Self {
        Self::from_json(id, reference_json(&format!("ip_case_{id}.json")))
    }

    /// The cameras with tiles of 4 × 4.
    pub fn tiles_4x4() -> Vec<Self> {
        let cases = reference_json("ip_tiles_4x4.json");
        cases
            .as_array()
            .unwrap()
            .iter()
            .map(|c| Self::from_json(c["id"].as_str().unwrap(), c.clone()))
            .collect()
    }

    fn from_json(id: &str, json: Value) -> Self {
        let n = json["N"].as_u64().unwrap() as usize;
        let table = numbers(&json["filters_31xN"]);
        let filter =
            |k: usize| Spectrum::new(GRID, table.iter().skip(k).step_by(n).copied().collect()).unwrap();
        let channels = (0..n).map(|k| Channel { name: k.to_string(), transmittance: filter(k) }).collect();
        Self { cfa: Cfa::new(id, mosaic(&json["pattern"]), channels).unwrap(), json }
    }

    /// The sensor for a target, `mac` or `bar`.
    pub fn sensor(&self, target: &str) -> Sensor {
        let size = numbers(&self.json[format!("{target}_size")]);
        let quantum_efficiency = Spectrum::constant(GRID, 1.0).unwrap();
        Sensor::new(size[0] as usize, size[1] as usize, pixel(), self.cfa.clone(), quantum_efficiency)
    }

    /// The exposure of a target.
    pub fn exposure(&self, target: &str) -> Exposure {
        Exposure::new(self.number(&format!("/{target}_exp_time_s")))
    }

    pub fn number(&self, pointer: &str) -> f64 {
        self.json.pointer(pointer).unwrap().as_f64().unwrap()
    }
}
