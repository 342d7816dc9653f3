//! What reading a part of a file takes of memory, and how often the blocks of a file are unpacked when it is read by parts.
#![allow(clippy::unwrap_used, clippy::panic, unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, Text, Vec2, WritableImage, f16,
};
use flate2::write::DeflateEncoder;
use hdf5_pure::FileBuilder;
use smalti::numeric::Planes;
use smalti::spectrum::{SpectralCube, WavelengthGrid};
use smalti_io::envi::Interleave;
use smalti_io::matlab::Version;
use smalti_io::scene_file::{self, Crop, Whole};
use smalti_io::spectral_tiff::{self, Layout as Bands};
use smalti_io::{Limits, Quantity, ReadOptions, SpectralFile, dng, envi, exr, hdf5, matlab, npz};

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

/// An archive as `numpy.savez_compressed` writes it, of one array of `<f4` and its wavelengths.
fn deflated(path: &Path, data: &[f32], (shape, fortran): ([usize; 3], bool), nm: &[f64]) {
    let array = |descr: &str, order: &str, shape: String, bytes: Vec<u8>| {
        let mut text = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({shape}), }}");
        text.push_str(&" ".repeat(117 - text.len()));
        [b"\x93NUMPY\x01\0\x76\0".as_slice(), text.as_bytes(), b"\n", &bytes].concat()
    };
    let [a, b, c] = shape;
    let order = if fortran { "True" } else { "False" };
    let cube =
        array("<f4", order, format!("{a}, {b}, {c}"), data.iter().flat_map(|v| v.to_le_bytes()).collect());
    let list =
        array("<f8", "False", format!("{},", nm.len()), nm.iter().flat_map(|v| v.to_le_bytes()).collect());
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in [("cube.npy", cube), ("wavelengths.npy", list)] {
        let mut encoder = DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&content).unwrap();
        let packed = encoder.finish().unwrap();
        let mut entry = [20u16, 0, 8, 0, 0].map(u16::to_le_bytes).concat();
        entry.extend(crc32fast::hash(&content).to_le_bytes());
        entry.extend([packed.len() as u32, content.len() as u32].map(u32::to_le_bytes).concat());
        entry.extend([name.len() as u16, 0].map(u16::to_le_bytes).concat());
        let at = (out.len() as u32).to_le_bytes();
        directory.extend([b"PK\x01\x02\x14\0", &entry[..], &[0; 10], &at[..], name.as_bytes()].concat());
        out.extend([b"PK\x03\x04", &entry[..], name.as_bytes(), &packed].concat());
    }
    let ends = [directory.len() as u32, out.len() as u32].map(u32::to_le_bytes).concat();
    out.extend([&directory[..], b"PK\x05\x06\0\0\0\0\x02\0\x02\0", &ends, &[0, 0]].concat());
    fs::write(path, out).unwrap();
}

/// Tiles of half precision, whose whole numbers end at 2048, beside channels of a picture.
fn tiled_exr(path: &Path, data: &[f32], nm: &[f64]) {
    let halves = |band: usize| {
        data[band * ROWS * COLS..][..ROWS * COLS].iter().map(|v| f16::from_f32(*v % 1000.0)).collect()
    };
    let mut channels: Vec<AnyChannel<FlatSamples>> = (0..BANDS)
        .map(|band| {
            AnyChannel::new(
                Text::from(format!("S0.{},0nm", nm[band]).as_str()),
                FlatSamples::F16(halves(band)),
            )
        })
        .collect();
    channels.push(AnyChannel::new("R", FlatSamples::F32(vec![1.0; ROWS * COLS])));
    let blocks = Blocks::Tiles(Vec2(96, 64));
    let encoding = Encoding { compression: Compression::ZIP16, blocks, line_order: LineOrder::Increasing };
    let layer =
        Layer::new((COLS, ROWS), LayerAttributes::default(), encoding, AnyChannels::sort(channels.into()));
    Image::from_layer(layer).write().to_file(path).unwrap();
}

fn folder(path: &Path, data: &[f32]) {
    fs::create_dir(path).unwrap();
    for (band, plane) in data.chunks(ROWS * COLS).enumerate() {
        let file = File::create(path.join(format!("s_{}nm.png", 400 + 10 * band))).unwrap();
        let mut encoder = png::Encoder::new(file, COLS as u32, ROWS as u32);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.set_compression(png::Compression::Fast);
        let bytes: Vec<u8> = plane.iter().flat_map(|v| (*v as u16).to_be_bytes()).collect();
        encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
    }
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
    exr::write(&at("i.exr"), &file, exr::Layout::Fichet2021).unwrap();
    tiled_exr(&at("j.exr"), &data, &nm);
    deflated(&at("k.npz"), &data, ([BANDS, ROWS, COLS], false), &nm);
    // Row, column, band; and the same in Fortran's order: band, column, row.
    let by_pixel: Vec<f32> = (0..data.len()).map(|i| data[i % BANDS * ROWS * COLS + i / BANDS]).collect();
    deflated(&at("l.npz"), &by_pixel, ([ROWS, COLS, BANDS], false), &nm);
    let by_column: Vec<f32> = (0..data.len())
        .map(|i| data[i / COLS / ROWS * ROWS * COLS + i % ROWS * COLS + i / ROWS % COLS])
        .collect();
    deflated(&at("m.npz"), &by_column, ([ROWS, COLS, BANDS], true), &nm);
    folder(&at("n"), &data);
    drop((file, data, by_pixel, by_column));

    // A strip of 16 × 24 samples, whose codestream unpacks to 2048 × 2048: 16 MiB.
    let large = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/findings/large_canvas.dng");
    let (refused, bytes) = peak(|| dng::read(&large, Limits::default()).unwrap_err().to_string());
    assert!(
        refused.contains("it has 2048 × 2048 pixels of 1 samples, expected 16 to 16 × 24 of 1"),
        "{refused}"
    );
    assert!(bytes < 1 << 20, "{bytes} bytes");

    let options = ReadOptions::default();
    let part = Crop { row: 500, col: 100, rows: 64, cols: 200 };
    for name in [
        "a.hdr", "b.npz", "c.tif", "d.mat", "e.mat", "f.h5", "g.h5", "h.h5", "i.exr", "j.exr", "k.npz",
        "l.npz", "m.npz", "n",
    ] {
        let path = at(name);
        let (planes, bytes) =
            peak(|| scene_file::open(&path, &options).unwrap().unwrap().read(part).unwrap());
        let value = ((11 * ROWS * COLS + 500 * COLS + 299) / 4096) as f32;
        let value = match name {
            "j.exr" => value % 1000.0,
            // A picture's largest number is 1.
            "n" => value / 65535.0,
            _ => value,
        };
        assert_eq!(planes.plane(11).unwrap()[199], value, "{name}");
        println!("{name}: {} KiB", bytes / 1024);
        // The part itself is 600 KiB; every thread holds some blocks of at most a mebibyte.
        let threads = rayon::current_num_threads().max(1);
        assert!(bytes < (2 + 3 * threads) << 20, "{name}: {bytes} bytes");
    }

    // Formats that are written from memory take what is asked for beforehand, and little beside it.
    let image = scene_file::open(&at("a.hdr"), &options).unwrap().unwrap();
    let whole = 4 * BANDS * ROWS * COLS;
    for (name, copies) in [("o.mat", 4), ("p.h5", 3), ("q.exr", 3)] {
        let (written, bytes) =
            peak(|| scene_file::write(&at(name), &image, &scene_file::WriteOptions::default()));
        written.unwrap();
        println!("{name}: {:.2} times the image", bytes as f64 / whole as f64);
        assert!(bytes <= copies * whole + (8 << 20), "{name}: {bytes} bytes");
    }
    let version = scene_file::WriteOptions { matlab: Some(Version::V73), ..Default::default() };
    let (written, bytes) = peak(|| scene_file::write(&at("r.mat"), &image, &version));
    written.unwrap();
    println!("r.mat: {:.2} times the image", bytes as f64 / whole as f64);
    assert!(bytes <= 4 * whole + (8 << 20), "r.mat: {bytes} bytes");
}
