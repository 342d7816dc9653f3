//! Writes a small corpus for every target, from our own writers: `cargo run --bin seeds -- corpus`.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use smalti::color::{ColorSpace, Image};
use smalti::l3::{Axes, Class, Kernels, Levels, Origin, Pair, Pipeline, PipelineParts, Statistics, Textures};
use smalti::numeric::Planes;
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling, SignalNoise};
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};
use smalti_io::dataset::{Column, Run};
use smalti_io::exr::Layout;
use smalti_io::{Quantity, SpectralFile};
use smalti_io::picture::Depth;
use smalti_io::{dng, exr, l3, npy, picture, spectrum_csv};

mod plan;

fn main() -> Result<(), Box<dyn Error>> {
    let corpus = PathBuf::from(std::env::args().nth(1).ok_or("usage: seeds FOLDER")?);
    let folder = |target: &str| -> Result<PathBuf, std::io::Error> {
        let dir = corpus.join(target);
        fs::create_dir_all(&dir)?;
        Ok(dir)
    };
    let ramp = |n: usize| (0..n).map(|i| i as f32 / n as f32).collect::<Vec<f32>>();

    let dir = folder("spectrum_csv")?;
    let grid = WavelengthGrid::new(400.0, 50.0, 7)?;
    let flat = Spectrum::constant(grid, 0.5);
    spectrum_csv::write(&dir.join("two.csv"), &[("R", &flat), ("G", &flat)])?;
    fs::write(dir.join("unequal.csv"), "# comment\nnm,v\n400,1\n405,2\n420,3\n")?;

    let dir = folder("exr")?;
    let cube = SpectralCube::new(grid, Planes::new(3, 4, 7, ramp(84))?)?;
    for (quantity, layout) in [
        (Quantity::Photons, Layout::Fichet2021),
        (Quantity::Energy, Layout::Pbrt),
        (Quantity::Reflectance, Layout::Fichet2021),
    ] {
        let file = SpectralFile {
            name: "seed".into(),
            cube: cube.clone(),
            quantity,
            illuminant: Some(flat.clone()),
            distance_m: Some(1.0),
            horizontal_fov_deg: Some(10.0),
        };
        exr::write(&dir.join(format!("{quantity:?}.exr")), &file, layout)?;
    }

    let dir = folder("picture")?;
    for space in [ColorSpace::Srgb, ColorSpace::DisplayP3] {
        let image = Image::new(space, Planes::new(5, 6, 3, ramp(90))?)?;
        for (bits, depth) in [(8, Depth::Eight), (16, Depth::Sixteen)] {
            for extension in ["png", "tif"] {
                picture::write(&dir.join(format!("{space:?}{bits}.{extension}")), &image, depth)?;
            }
        }
    }
    // The smallest JPEG header; the fuzzer finds its way from there.
    fs::write(dir.join("start.jpg"), b"\xff\xd8\xff\xe0\0\x10JFIF\0\x01\x01\0\0\x01\0\x01\0\0\xff\xd9")?;

    seeds_of_dng(&folder("dng")?)?;

    seeds_of_l3(&folder("l3")?)?;

    seeds_of_dataset(&folder("dataset")?)?;

    let dir = folder("npy")?;
    npy::write(&dir.join("f4.npy"), &[2, 3], &ramp(6))?;
    npy::write(&dir.join("u2.npy"), &[4], &[1u16, 2, 3, 4])?;
    npy::write(&dir.join("f8.npy"), &[], &[1f64])?;

    let dir = folder("camera_toml")?;
    for camera in smalti_io::cameras::names() {
        fs::write(dir.join(camera.name), camera.toml)?;
    }
    fs::write(dir.join("override"), "sensor.pixel.pitch_um=1.4\nsensor.cfa.pattern=[\"RG\"]\n")?;

    let dir = folder("names")?;
    for name in
        ["zone-plate?frequency=0.25&size=64", "D:5600", "blackbody:3000", "random?channels=4&rows=8&cols=8"]
    {
        fs::write(dir.join(name.replace(['?', ':'], "_")), name)?;
    }
    Ok(())
}

fn seeds_of_dng(dir: &Path) -> Result<(), Box<dyn Error>> {
    let names = ["R", "G", "B"].map(str::to_owned).to_vec();
    let mosaic = Sampling::Mosaic(Mosaic::new(2, 2, vec![0, 1, 1, 2])?);
    let digital = RawSamples::Digital((0..48).collect());
    let raw = RawImage::new(6, 8, digital, mosaic, names.clone(), 2.0, 47.0)?;
    dng::write(&dir.join("bayer.dng"), &raw, &dng::DngInfo::default())?;
    let coding = dng::Compression::LosslessJpeg;
    dng::write_compressed(&dir.join("lossless.dng"), &raw, &dng::DngInfo::default(), coding)?;
    let analog = RawSamples::Analog((0..48).map(|i| i as f32 / 48.0).collect());
    let raw = RawImage::new(4, 4, analog, Sampling::Full { channels: 3 }, names, 0.0, 1.0)?;
    dng::write(&dir.join("full.dng"), &raw, &dng::DngInfo::default())?;
    Ok(())
}

/// Small, so that most of what the fuzzer changes is structure.
fn seeds_of_l3(dir: &Path) -> Result<(), Box<dyn Error>> {
    let mosaic = Mosaic::new(1, 2, vec![0, 1])?;
    let noise = SignalNoise { constant: 1e-6, per_signal: 1e-4, ..SignalNoise::default() };
    let axes =
        Axes::new(mosaic.clone(), 3, Levels::new(vec![0.1, 0.5])?, noise)?.with_textures(Textures::None);
    let names = vec!["a".to_owned(), "b".to_owned()];
    let classes = 2 * 2 * 3;
    let table = Pipeline::from_parts(PipelineParts {
        axes: axes.clone(),
        saturations: vec![0, 1],
        outputs: vec!["Y".into()],
        channel_names: names.clone(),
        black_level: 0.0,
        white_level: 255.0,
        trained: vec![[0.0, 1.0]; 2],
        classes: vec![Class { count: 5, origin: Origin::Learned }; classes],
        kernels: Kernels { weights: vec![0.1; classes * 9], offsets: vec![0.0; classes] },
        provenance: "{}".into(),
    })?;
    l3::write_table(&dir.join("table.l3"), &table)?;
    let mut statistics = Statistics::new(axes, vec!["Y".into()], true)?;
    l3::write_statistics(&dir.join("nothing.l3s"), &statistics)?;
    let samples = RawSamples::Digital((0..48).collect());
    let raw = RawImage::new(6, 8, samples, Sampling::Mosaic(mosaic), names, 0.0, 255.0)?;
    let target = Planes::new(6, 8, 1, (0..48).map(|i| i as f32).collect())?;
    statistics.add(&Pair { raw: &raw, seen: None, target: &target })?;
    l3::write_statistics(&dir.join("some.l3s"), &statistics)?;
    Ok(())
}

/// A manifest and its only part.
fn seeds_of_dataset(dir: &Path) -> Result<(), Box<dyn Error>> {
    let plan = plan::plan();
    let results = std::env::temp_dir().join(format!("smalti-seeds-{}", std::process::id()));
    let run = Run::open(&results, &plan, None)?;
    run.write(
        0,
        &[
            Column::Int(vec![0, 1, 2]),
            Column::Float(vec![1.5, f64::NAN, -0.0]),
            Column::Text(["RG/GB", "", "RG/GB"].map(str::to_owned).to_vec()),
            Column::Floats(vec![vec![450.0, 550.0], vec![], vec![f64::NAN]]),
        ],
    )?;
    run.finish(serde_json::json!({"seconds": 1}))?;
    for name in ["manifest.json", "designs/part-000000.parquet"] {
        let file = results.join(name);
        fs::copy(&file, dir.join(file.file_name().ok_or("a file has a name")?))?;
    }
    fs::remove_dir_all(results)?;
    Ok(())
}
