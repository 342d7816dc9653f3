//! Demosaicking of a 4K frame of 16-bit samples, on two threads. `tools/bench_opencv.py` runs it beside OpenCV.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput};
use smalti::isp::Demosaic;
use smalti::isp::demosaic::bilinear::bayer_u16;
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

    let bayer = mosaic(&["RG", "GB"], "RGB");
    let mut out = vec![0u16; 3 * ROWS * COLS];
    group.bench_function("bilinear u16 bayer", |b| {
        b.iter(|| bayer_u16(black_box(&samples), ROWS, COLS, &bayer, &mut out).unwrap());
    });
    let mosaics = [
        ("bayer", bayer),
        ("rgbw 4x4", mosaic(&["WBWG", "BWGW", "WGWR", "GWRW"], "RGBW")),
        ("x-trans 6x6", mosaic(&["GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG"], "RGB")),
        ("five band 4x4", mosaic(&["GOGR", "CGBG", "GRGO", "BGCG"], "RGBCO")),
        ("5x5", mosaic(&["RGBWG", "BWGRG", "GRGBW", "GBWGR", "WGRGB"], "RGBW")),
    ];
    for (name, mosaic) in mosaics {
        let names = (0..mosaic.channels()).map(|c| c.to_string()).collect();
        let samples = RawSamples::Digital(samples.clone());
        let raw =
            RawImage::new(ROWS, COLS, samples, Sampling::Mosaic(mosaic), names, 256.0, 65535.0).unwrap();
        group.bench_function(format!("bilinear f32 {name}"), |b| {
            b.iter(|| Demosaic::Bilinear.apply(black_box(&raw)).unwrap());
        });
    }
    group.finish();
    c.final_summary();
}
