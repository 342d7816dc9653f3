//! The optical image of 1024 × 1024 samples and 31 wavelengths, beside its Fourier transforms alone: one forward
//! and one inverse of the padded plane per wavelength, on the same threads. The last lines compare the two.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use rayon::prelude::*;
use smalti::numeric::Planes;
use smalti::numeric::fft::{Complex32, RealFft2, fast_len};
use smalti::optics::{
    ChromaticFocus, Defocus, Optics, OpticsModel, Wavefront, WavefrontUnit, ZernikeIndex, ZernikeMode,
};
use smalti::scene::Scene;
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

const SIDE: usize = 1024;
const PADDED: usize = SIDE + 2 * (SIDE / 8);

fn scene() -> Scene {
    let grid = WavelengthGrid::VISIBLE;
    let values = (0..SIDE * SIDE * grid.len()).map(|i| (i * 7919 % 1013) as f32 * 1e12);
    let planes = Planes::new(SIDE, SIDE, grid.len(), values.collect()).unwrap();
    let radiance = SpectralCube::new(grid, planes).unwrap();
    // At f/4 and 4 mm this is a sample every 1.1 µm: the whole pass band of the lens is at work.
    Scene::new("noise", radiance, Spectrum::constant(grid, 1e15).unwrap(), 1.2, 17.0).unwrap()
}

/// The transforms that the image needs, with memory set up beforehand.
struct Transforms {
    fft: RealFft2,
    planes: Vec<(usize, Vec<f32>, smalti::numeric::fft::Workspace)>,
}

impl Transforms {
    fn new() -> Self {
        let fft = RealFft2::new(fast_len(PADDED), fast_len(PADDED)).unwrap();
        let threads = rayon::current_num_threads();
        let planes = (0..threads)
            .map(|t| ((31 + t) / threads, vec![1.0; fft.rows() * fft.cols()], fft.workspace()))
            .collect();
        Self { fft, planes }
    }

    fn run(&mut self) {
        let (fft, cols) = (&self.fft, self.fft.cols());
        self.planes.par_iter_mut().for_each(|(count, plane, work)| {
            for _ in 0..*count {
                let input = |r: usize, row: &mut [f32]| row.fill(r as f32);
                let keep = |_: usize, column: &mut [Complex32]| {
                    black_box(column);
                };
                fft.filter(work, input, usize::MAX, keep, (plane, cols), |v| v).unwrap();
            }
        });
    }
}

fn median(repeats: usize, mut run: impl FnMut()) -> Duration {
    let mut times: Vec<Duration> = (0..repeats)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed()
        })
        .collect();
    times.sort();
    times[repeats / 2]
}

fn optical_image(c: &mut Criterion) {
    let scene = scene();
    let mut transforms = Transforms::new();
    let perfect = Optics::new(4e-3, 4.0);
    // Defocus and coma.
    let terms = [4, 8].map(|j| (ZernikeMode::from_index(ZernikeIndex::Noll, j).unwrap(), 0.05));
    let wavefront = Wavefront::new(&terms, WavefrontUnit::Micrometres).unwrap();
    let model = OpticsModel::Zernike { wavefront, defocus: Defocus::None, chromatic: ChromaticFocus::None };
    let aberrated = Optics { model, ..perfect.clone() };

    let mut group = c.benchmark_group("optical image 1024x1024x31");
    group.sample_size(10).measurement_time(Duration::from_secs(5));
    group.bench_function("transforms alone", |b| b.iter(|| transforms.run()));
    group.bench_function("diffraction", |b| b.iter(|| perfect.image(&scene).unwrap()));
    group.bench_function("zernike", |b| b.iter(|| aberrated.image(&scene).unwrap()));
    group.finish();

    let alone = median(7, || transforms.run());
    let image = median(7, || drop(black_box(perfect.image(&scene).unwrap())));
    println!(
        "optical image {image:.0?}, its transforms {alone:.0?}: {:.2} times (goal: at most 2.5)",
        image.as_secs_f64() / alone.as_secs_f64()
    );
}

criterion_group!(benches, optical_image);
criterion_main!(benches);
