//! Writes a small corpus for every target, from our own writers: `cargo run --bin seeds -- corpus`.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use smalti::color::{ColorSpace, Image};
use smalti::experiment::{RatedPicture, RatedScene};
use smalti::l3::{Axes, Class, Kernels, Levels, Origin, Pair, Pipeline, PipelineParts, Statistics, Textures};
use smalti::numeric::Planes;
use smalti::rating::{Question, Role, Schedule, Shown, Side, Trial};
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling, SignalNoise};
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};
use smalti_io::dataset::{Column, Run};
use smalti_io::envi::Interleave;
use smalti_io::matlab::Version;
use smalti_io::picture::Depth;
use smalti_io::ratings::{self, AnswerFolder, Condition, Display, Planned};
use smalti_io::scene_file::Whole;
use smalti_io::spectral_tiff::{Layout, WriteOptions};
use smalti_io::{Quantity, SpectralFile};
use smalti_io::{dng, envi, exr, l3, matlab, npy, npz, picture, spectral_tiff, spectrum_csv};

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
    let flat = Spectrum::constant(grid, 0.5)?;
    spectrum_csv::write(&dir.join("two.csv"), &[("R", &flat), ("G", &flat)])?;
    fs::write(dir.join("unequal.csv"), "# comment\nnm,v\n400,1\n405,2\n420,3\n")?;

    let dir = folder("exr")?;
    let cube = SpectralCube::new(grid, Planes::new(3, 4, 7, ramp(84))?)?;
    for (quantity, layout) in [
        (Quantity::Photons, exr::Layout::Fichet2021),
        (Quantity::Energy, exr::Layout::Pbrt),
        (Quantity::Reflectance, exr::Layout::Fichet2021),
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

    seeds_of_cubes(&folder)?;
    seeds_of_matlab(&folder("mat")?, &folder("hdf5")?, &cube, &flat)?;

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

    let dir = folder("study")?;
    for study in smalti_io::studies::names() {
        fs::write(dir.join(study.name), study.toml)?;
        let (trials, _) = smalti_io::studies::load(study.name).map_err(|e| e.to_string())?;
        fs::write(dir.join(format!("{}.json", study.name)), serde_json::to_vec(trials.study())?)?;
    }

    seeds_of_ratings(&folder("ratings")?)?;

    let dir = folder("names")?;
    for name in
        ["zone-plate?frequency=0.25&size=64", "D:5600", "blackbody:3000", "random?channels=4&rows=8&cols=8"]
    {
        fs::write(dir.join(name.replace(['?', ':'], "_")), name)?;
    }
    Ok(())
}

/// An experiment with the answer of an observer.
fn seeds_of_ratings(dir: &Path) -> Result<(), Box<dyn Error>> {
    let place = std::env::temp_dir().join(format!("smalti-seeds-{}", std::process::id()));
    let image =
        || Ok::<_, Box<dyn Error>>(Image::new(ColorSpace::Srgb, Planes::new(5, 6, 3, vec![0.5; 90])?)?);
    let picture = || {
        Ok::<_, Box<dyn Error>>(RatedPicture {
            image: image()?,
            gain: 1.0,
            exposure_time_s: 0.1,
            metrics: vec![("cpsnr_db", 30.0)],
        })
    };
    let scene = RatedScene {
        name: "a".into(),
        reference: image()?,
        trap: image()?,
        pictures: vec![picture()?, picture()?],
    };
    let condition = |name: &str| Condition {
        name: name.into(),
        camera: "a".into(),
        processing: "l3".into(),
        luminance_cd_m2: 1.0,
        stops: 0.0,
    };
    let planned = Planned {
        title: "a".into(),
        command: Vec::new(),
        question: Question::Scale,
        schedule: Schedule { ratings: 2, repeats: 1, traps: 1, training: 0, break_every: 2 },
        seed: 1,
        conditions: vec![condition("a"), condition("b")],
    };
    let manifest = ratings::write(&place, &planned, &[scene])?;
    let display = Display { device_pixel_ratio: 1.0, screen_px: [9, 9], px_per_mm: None, gamma: None };
    let (mut observer, mut file) = AnswerFolder::open(&place)?.begin(&manifest, 1, "a", &display)?;
    let trial = Trial { role: Role::Rating, scene: 0, left: Shown::Condition(1), right: Shown::Condition(0) };
    file.show(&mut observer, trial)?;
    file.answer(&mut observer, Side::Left, 900)?;
    let mut seed = fs::read(place.join(ratings::MANIFEST))?;
    seed.push(0);
    seed.extend(fs::read(place.join(ratings::ANSWERS).join("observer-0001.jsonl"))?);
    fs::remove_dir_all(&place)?;
    Ok(fs::write(dir.join("experiment"), seed)?)
}

/// Cubes of three bands, so that most of what the fuzzer changes is structure.
fn seeds_of_cubes(folder: &dyn Fn(&str) -> Result<PathBuf, std::io::Error>) -> Result<(), Box<dyn Error>> {
    let grid = WavelengthGrid::new(400.0, 50.0, 3)?;
    let data = (0..36).map(|i| i as f32 / 36.0).collect();
    let file = SpectralFile {
        name: "seed".into(),
        cube: SpectralCube::new(grid, Planes::new(3, 4, 3, data)?)?,
        quantity: Quantity::Reflectance,
        illuminant: Some(Spectrum::constant(grid, 0.5)?),
        distance_m: Some(1.0),
        horizontal_fov_deg: Some(10.0),
    };
    let image = Whole::new(&file);

    let dir = folder("envi")?;
    for interleave in [Interleave::Bsq, Interleave::Bil, Interleave::Bip] {
        let header = dir.join("seed.hdr");
        envi::write(&header, &image, interleave)?;
        let both = [fs::read(&header)?, vec![0], fs::read(dir.join("seed.img"))?].concat();
        fs::write(dir.join(interleave.name()), both)?;
        fs::remove_file(header)?;
        fs::remove_file(dir.join("seed.img"))?;
    }
    let full = "ENVI\nsamples = 2\nlines = 2\nbands = 3\nheader offset = 1\ndata type = 2\ninterleave = bip\nbyte order = 1\n\
        bbl = {1, 1, 0}\ndata ignore value = 7\ndata gain values = {1, 2, 3}\nwavelength units = Micrometers\n\
        wavelength = {0.4,\n 0.5, 0.6}\nreflectance scale factor = 100\n";
    fs::write(dir.join("full"), [full.as_bytes(), &[0; 26]].concat())?;

    let dir = folder("npz")?;
    npz::write(&dir.join("cube.npz"), &image)?;
    npz::write_npy(&dir.join("cube.npy"), &image)?;

    let dir = folder("spectral_tiff")?;
    for (layout, name) in [(Layout::Pages, "pages"), (Layout::Samples, "samples")] {
        for deflate in [false, true] {
            let options = WriteOptions { layout, deflate };
            spectral_tiff::write(&dir.join(format!("{name}{}.tif", u8::from(deflate))), &image, options)?;
        }
    }

    let dir = folder("bands")?;
    for (name, names) in
        [("numbers", ["a_1.png", "a_2.png", "a_3.png"]), ("nm", ["400nm.png", "450nm.png", "9.png"])]
    {
        let mut out = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let mut png = Vec::new();
            let mut encoder = png::Encoder::new(&mut png, 4, 3);
            encoder
                .set_color([png::ColorType::Grayscale, png::ColorType::Rgba, png::ColorType::Grayscale][i]);
            encoder.set_depth([png::BitDepth::Sixteen, png::BitDepth::Eight, png::BitDepth::Eight][i]);
            encoder.write_header()?.write_image_data(&vec![9; [24, 48, 12][i]])?;
            out.push(name.len() as u8);
            out.extend(name.bytes());
            out.extend((png.len() as u16).to_le_bytes());
            out.extend(png);
        }
        fs::write(dir.join(name), out)?;
    }
    Ok(())
}

/// Our own MATLAB and HDF5; those of other programs are in `seeds/`.
fn seeds_of_matlab(
    mat: &Path,
    hdf5: &Path,
    cube: &SpectralCube,
    light: &Spectrum,
) -> Result<(), Box<dyn Error>> {
    for quantity in [Quantity::Photons, Quantity::Reflectance] {
        let file = SpectralFile {
            name: "seed".into(),
            cube: cube.clone(),
            quantity,
            illuminant: Some(light.clone()),
            distance_m: Some(1.0),
            horizontal_fov_deg: Some(10.0),
        };
        matlab::write(&mat.join(format!("{quantity:?}.mat")), &file, Version::V5)?;
        matlab::write(&hdf5.join(format!("{quantity:?}.mat")), &file, Version::V73)?;
        smalti_io::hdf5::write(&hdf5.join(format!("{quantity:?}.h5")), &file)?;
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
    for name in ["manifest.json", "trials/part-000000.parquet"] {
        let file = results.join(name);
        fs::copy(&file, dir.join(file.file_name().ok_or("a file has a name")?))?;
    }
    fs::remove_dir_all(results)?;
    Ok(())
}
