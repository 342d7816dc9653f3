//! Demosaicking of a 4K frame of 16-bit samples, on two threads. `tools/bench_opencv.py` runs it beside OpenCV.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput};
use smalti::isp::demosaic::Bilinear;
use smalti::numeric::Planes;
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling};

const ROWS: usize = 2160;
const COLS: usize = 3840;

fn mosaic(pattern: &[&str], letters: &str) -> Mosaic {
    let cell = |l| letters.find(l).unwrap() as u8;
    Mosaic::new(pattern.len(), pattern[0].len(), pattern.concat().chars().map(cell).collect()).unwrap()
}

fn main() {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    threads.install(|| run(&mut Criterion::default().configure_from_args()));
}

fn run(c: &mut Criterion) {
    // A smooth picture with some texture; no timing depends on the values.
    let samples: Vec<u16> = (0..ROWS * COLS).map(|i| ((i * 2_654_435_761) >> 16) as u16).collect();
    let mut group = c.benchmark_group("demosaic 3840x2160");
    group.throughput(Throughput::Elements((ROWS * COLS) as u64)).sample_size(20);

    let mosaics = [
        ("bayer", mosaic(&["RG", "GB"], "RGB")),
        ("rgbw 4x4", mosaic(&["WBWG", "BWGW", "WGWR", "GWRW"], "RGBW")),
        ("x-trans 6x6", mosaic(&["GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG"], "RGB")),
        ("five band 4x4", mosaic(&["GOGR", "CGBG", "GRGO", "BGCG"], "RGBCO")),
        ("5x5", mosaic(&["RGBWG", "BWGRG", "GRGBW", "GBWGR", "WGRGB"], "RGBW")),
    ];
    // Into planes that exist already: what is measured is the work, not the system's handing out of memory.
    for (name, mosaic) in mosaics {
        let method = Bilinear::new(&mosaic).unwrap();
        let mut planes = vec![0u16; mosaic.channels() * ROWS * COLS];
        group.bench_function(format!("bilinear u16 {name}"), |b| {
            b.iter(|| method.apply_u16(black_box(&samples), ROWS, COLS, &mut planes).unwrap());
        });
        let names = (0..mosaic.channels()).map(|c| c.to_string()).collect();
        let mut planes = Planes::zeros(ROWS, COLS, mosaic.channels());
        let samples = RawSamples::Digital(samples.clone());
        let raw =
            RawImage::new(ROWS, COLS, samples, Sampling::Mosaic(mosaic), names, 256.0, 65535.0).unwrap();
        group.bench_function(format!("bilinear f32 {name}"), |b| {
            b.iter(|| method.apply_into(black_box(&raw), &mut planes).unwrap());
        });
    }
    group.finish();
    c.final_summary();
}
