//! What reading a part of a file takes of memory, and how often the blocks of a file are unpacked when it is read by parts.
#![allow(clippy::unwrap_used, clippy::panic, unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::fs::File;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use hdf5_pure::FileBuilder;
use smalti::numeric::Planes;
use smalti::spectrum::{SpectralCube, WavelengthGrid};
use smalti_io::envi::Interleave;
use smalti_io::matlab::Version;
use smalti_io::scene_file::{self, Crop, Whole};
use smalti_io::spectral_tiff::{self, Layout as Bands};
use smalti_io::{Quantity, ReadOptions, SpectralFile, envi, hdf5, matlab, npz};

/// The system's, which counts.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all is done by the allocator of the system.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = NOW.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(now, Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes that were held at most beyond those before.
fn peak<T>(run: impl FnOnce() -> T) -> (T, usize) {
    let before = NOW.load(Relaxed);
    PEAK.store(before, Relaxed);
    let result = run();
    (result, PEAK.load(Relaxed) - before)
}

const ROWS: usize = 1024;
const COLS: usize = 1024;
const BANDS: usize = 12;

fn chunked(path: &Path, data: &[f32], nm: &[f64], chunk: [u64; 3]) {
    let mut builder = FileBuilder::new();
    let shape = [BANDS as u64, ROWS as u64, COLS as u64];
    builder
        .create_dataset("cube")
        .with_f32_data(data)
        .with_shape(&shape)
        .with_chunks(&chunk)
        .with_shuffle()
        .with_deflate(1);
    builder.create_dataset("wavelengths").with_f64_data(nm);
    builder.finish_to(&mut File::create(path).unwrap()).unwrap();
}

// One test: another that ran beside it would be counted too.
#[test]
fn a_part_takes_the_memory_of_the_part() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let grid = WavelengthGrid::new(400.0, 10.0, BANDS).unwrap();
    let nm: Vec<f64> = grid.wavelengths_nm().collect();
    let data: Vec<f32> = (0..BANDS * ROWS * COLS).map(|i| (i / 4096) as f32).collect();
    let file = SpectralFile {
        name: "large".into(),
        cube: SpectralCube::new(grid, Planes::new(ROWS, COLS, BANDS, data.clone()).unwrap()).unwrap(),
        quantity: Quantity::Photons,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    };
    // 48 MiB each.
    envi::write(&at("a.hdr"), &Whole::new(&file), Interleave::Bip).unwrap();
    npz::write(&at("b.npz"), &Whole::new(&file)).unwrap();
    let tiff = spectral_tiff::WriteOptions { layout: Bands::Samples, deflate: true };
    spectral_tiff::write(&at("c.tif"), &Whole::new(&file), tiff).unwrap();
    matlab::write(&at("d.mat"), &file, Version::V5).unwrap();
    matlab::write(&at("e.mat"), &file, Version::V73).unwrap();
    hdf5::write(&at("f.h5"), &file).unwrap();
    chunked(&at("g.h5"), &data, &nm, [1, 64, 1024]);
    chunked(&at("h.h5"), &data, &nm, [4, 128, 128]);
    drop((file, data));

    let options = ReadOptions::default();
    let part = Crop { row: 500, col: 100, rows: 64, cols: 200 };
    for name in ["a.hdr", "b.npz", "c.tif", "d.mat", "e.mat", "f.h5", "g.h5", "h.h5"] {
        let path = at(name);
        let (planes, bytes) =
            peak(|| scene_file::open(&path, &options).unwrap().unwrap().read(part).unwrap());
        assert_eq!(planes.plane(11)[199], ((11 * ROWS * COLS + 500 * COLS + 299) / 4096) as f32, "{name}");
        println!("{name}: {} KiB", bytes / 1024);
        // The part itself is 600 KiB; every thread holds some blocks of at most a mebibyte.
        let threads = rayon::current_num_threads().max(1);
        assert!(bytes < (2 + 3 * threads) << 20, "{name}: {bytes} bytes");
    }
}
