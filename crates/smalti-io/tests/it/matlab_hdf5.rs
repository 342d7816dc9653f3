//! Scene files of MATLAB and HDF5: those of SciPy, h5py and Octave are read, ours are read by them. Skipped, with a
//! message, where a program is absent.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use serde_json::Value;
use smalti::numeric::Planes;
use smalti::spectrum::units::photons_per_joule;
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};
use smalti_io::matlab::Version;
use smalti_io::scene_file::Crop;
use smalti_io::{IoError, Quantity, ReadOptions, SpectralFile, hdf5, matlab, scene_file};

use crate::python::python;

const SCRIPT: &str = "check_matlab_hdf5.py";
const PACKAGES: &str = "numpy, scipy, h5py";
const TYPES: [&str; 10] = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"];

fn grid() -> WavelengthGrid {
    WavelengthGrid::new(400.0, 50.0, 7).unwrap()
}

/// The sample that the other programs write.
fn sample(row: usize, col: usize, band: usize) -> f64 {
    ((row + 5 * col + 20 * band) % 120 + 1) as f64
}

fn part_of(file: &SpectralFile, part: Crop) -> SpectralFile {
    let options = ReadOptions { crop: Some(part), ..ReadOptions::default() };
    scene_file::load(&scene_file::Whole::new(file), Path::new("f"), &options).unwrap()
}

fn read(path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    scene_file::read_spectral(path, options).map(Option::unwrap)
}

/// Samples are `scale` times those that were written, within `tolerance` of the largest.
fn check(file: &SpectralFile, scale: f64, tolerance: f64, name: &str) {
    assert_eq!((file.cube.rows(), file.cube.cols()), (5, 4), "{name}");
    for (b, plane) in file.cube.planes().planes().enumerate() {
        for (i, &v) in plane.iter().enumerate() {
            let expected = sample(i / 4, i % 4, b % 7) * scale;
            assert!(
                (f64::from(v) - expected).abs() <= tolerance * 120.0 * scale,
                "{name} {i} {b}: {v} {expected}"
            );
        }
    }
}

fn light() -> Vec<f64> {
    (0..7).map(|i| 1.0 + f64::from(i) / 6.0).collect()
}

fn near(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs())
}

/// A scene of ISETCam: photons, with all that belongs to it.
fn check_scene(file: &SpectralFile, facts: (&str, f64, f64), name: &str) {
    assert_eq!((file.quantity, file.cube.grid()), (Quantity::Photons, grid()), "{name}");
    let found = (file.name.as_str(), file.distance_m, file.horizontal_fov_deg);
    assert_eq!(found, (facts.0, Some(facts.1), Some(facts.2)), "{name}");
    assert!(near(file.illuminant.as_ref().unwrap().values(), &light()), "{name}");
}

#[test]
fn files_of_scipy_and_h5py_are_read() {
    let dir = tempfile::tempdir().unwrap();
    if python(SCRIPT, PACKAGES, &[Path::new("write"), dir.path()]).is_none() {
        return;
    }
    let default = ReadOptions::default();
    let file = |name: &str| {
        let whole = read(&dir.path().join(name), &default).unwrap_or_else(|e| panic!("{e}"));
        let part = Crop { row: 1, col: 2, rows: 3, cols: 2 };
        let cut = read(&dir.path().join(name), &ReadOptions { crop: Some(part), ..ReadOptions::default() });
        assert_eq!(cut.unwrap(), part_of(&whole, part), "{name}");
        whole
    };
    let error = |name: &str| read(&dir.path().join(name), &default).unwrap_err().to_string();

    for t in TYPES {
        for z in ["", "z"] {
            let name = format!("photons_{t}{z}.mat");
            let photons = file(&name);
            check(&photons, 1.0, 0.0, &name);
            check_scene(&photons, ("scipy", 2.0, 12.5), &name);
        }
        for order in ["", "_big"] {
            let name = format!("generic_{t}{order}.h5");
            let generic = file(&name);
            check(&generic, 1.0, 0.0, &name);
            assert_eq!((generic.quantity, generic.cube.grid()), (Quantity::RelativeEnergy, grid()), "{name}");
        }
    }
    for name in ["v73_photons.mat", "v73_photons_zipped.mat"] {
        check(&file(name), 1.0, 0.0, name);
        check_scene(&file(name), ("h5py", 2.0, 12.5), name);
    }
    for name in ["scene.mat", "v73_scene.mat", "v73_newer.mat"] {
        check(&file(name), 1e15, 1e-7, name);
        check_scene(&file(name), ("ä scene", 3.0, 20.0), name);
    }
    // Sixteen bits.
    check(&file("packed.mat"), 1.0, 1e-5, "packed.mat");
    for name in ["mccoef.mat", "mccoef_without_mean.mat", "v73_mccoef.mat"] {
        check(&file(name), 1.0, 1e-7, name);
        assert_eq!(file(name).quantity, Quantity::Photons);
    }
    let old = file("mccoef.mat");
    assert_eq!((old.name.as_str(), old.distance_m, old.horizontal_fov_deg), ("mccoef", Some(1.5), Some(8.0)));
    let photons: Vec<f64> =
        light().iter().zip(grid().wavelengths_nm()).map(|(e, nm)| e * photons_per_joule(nm)).collect();
    assert!(near(old.illuminant.unwrap().values(), &photons));

    check(&file("icvl.mat"), 1.0, 0.0, "icvl.mat");
    assert_eq!(file("icvl.mat").quantity, Quantity::RelativeEnergy);
    check(&file("arad.mat"), 1.0 / 120.0, 1e-7, "arad.mat");
    let kaust = file("kaust.h5");
    check(&kaust, 1.0 / 120.0, 1e-7, "kaust.h5");
    let expected = (Quantity::Reflectance, WavelengthGrid::new(400.0, 10.0, 34).unwrap());
    assert_eq!((kaust.quantity, kaust.cube.grid()), expected);

    for storage in ["chunked", "one_chunk", "zipped", "deflated", "shuffled", "checked", "lzf", "growing"] {
        for version in ["earliest", "v110"] {
            let name = format!("stored_{storage}_{version}.h5");
            check(&file(&name), 1.0, 0.0, &name);
        }
    }
    let part = file("in_part.h5");
    assert_eq!(part.cube.planes().plane(0).unwrap()[..5], [5.0, 5.0, 5.0, 3.0, 5.0]);
    assert!(part.cube.planes().plane(4).unwrap().iter().all(|&v| v == 3.0));

    assert!(error("level4.mat").contains("version 4 of the MATLAB format"));
    assert!(error("complex.mat").contains("cube (complex numbers)"), "{}", error("complex.mat"));
    assert!(error("two.h5").contains("any of a (5 × 4 × 7), b (5 × 4 × 7); expected one; name it"));
    let named = ReadOptions { variable: Some("a".into()), ..ReadOptions::default() };
    check(&read(&dir.path().join("two.h5"), &named).unwrap(), 1.0, 0.0, "two.h5");
    let absent = ReadOptions { variable: Some("c".into()), ..ReadOptions::default() };
    let absent = read(&dir.path().join("two.h5"), &absent).unwrap_err().to_string();
    assert!(absent.ends_with("c is absent; expected one of a, b, wave"), "{absent}");
}

/// A file in which every number is another.
fn ours(quantity: Quantity) -> SpectralFile {
    let data = (0..5 * 4 * 7).map(|i| (i as f32 + 0.1) * 1e15).collect();
    // A grid whose step is not exact in binary.
    let grid = WavelengthGrid::new(400.1, 10.3, 7).unwrap();
    SpectralFile {
        name: "ours, ä".into(),
        cube: SpectralCube::new(grid, Planes::new(5, 4, 7, data).unwrap()).unwrap(),
        quantity,
        illuminant: Some(Spectrum::from_fn(grid, |nm| nm * 1.1e13).unwrap()),
        distance_m: Some(1.3),
        horizontal_fov_deg: None,
    }
}

#[test]
fn what_is_written_reads_back_equal() {
    let dir = tempfile::tempdir().unwrap();
    let default = ReadOptions::default();
    for quantity in Quantity::ALL {
        for illuminant in [true, false] {
            let mut file = ours(quantity);
            file.illuminant = file.illuminant.filter(|_| illuminant);
            for version in [Version::V5, Version::V73] {
                let path = dir.path().join("a.mat");
                matlab::write(&path, &file, version).unwrap();
                assert_eq!(read(&path, &default).unwrap(), file, "{version:?}");
            }
            let path = dir.path().join("a.h5");
            hdf5::write(&path, &file).unwrap();
            assert_eq!(read(&path, &default).unwrap(), file);
        }
    }
}

/// HDF5 states its length. Cut anywhere, it is no file, even where all samples are there and only an attribute or a name is lost.
#[test]
fn a_file_that_is_cut_short_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let file = ours(Quantity::Photons);
    matlab::write(&dir.path().join("whole.mat"), &file, Version::V73).unwrap();
    hdf5::write(&dir.path().join("whole.h5"), &file).unwrap();
    for name in ["whole.mat", "whole.h5"] {
        let whole = std::fs::read(dir.path().join(name)).unwrap();
        let path = dir.path().join(name.replace("whole", "cut"));
        for len in (0..whole.len()).step_by(1 + whole.len() / 400).chain([whole.len() - 1]) {
            std::fs::write(&path, &whole[..len]).unwrap();
            let message = match scene_file::read_spectral(&path, &ReadOptions::default()) {
                Err(error) => error.to_string(),
                Ok(found) => {
                    assert!(found.is_none(), "{name} is read from {len} of {} bytes", whole.len());
                    continue;
                }
            };
            assert!(message.starts_with(path.to_str().unwrap()), "{message}");
        }
        // What follows the end is of no meaning.
        std::fs::write(&path, [whole.as_slice(), &[0; 100]].concat()).unwrap();
        assert_eq!(read(&path, &ReadOptions::default()).unwrap(), file);
    }
}

/// A heap that is overwritten loses the texts of attributes; the file is refused, not read as relative energy.
#[test]
fn an_attribute_that_cannot_be_read_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.h5");
    hdf5::write(&path, &ours(Quantity::Photons)).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let heap = bytes.windows(4).position(|w| w == b"GCOL").unwrap();
    bytes[heap..heap + 4].fill(0);
    std::fs::write(&path, bytes).unwrap();
    let error = read(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("the attribute 'quantity' is unreadable; expected a text"), "{error}");
}

#[test]
fn a_part_is_the_part_of_the_whole() {
    let dir = tempfile::tempdir().unwrap();
    let grid = WavelengthGrid::new(400.0, 50.0, 7).unwrap();
    let (rows, cols) = (40, 33);
    let data: Vec<f32> = (0..7 * rows * cols).map(|i| (i * 7919 % 10_007) as f32).collect();
    let planes = Planes::new(rows, cols, 7, data.clone()).unwrap();
    let file = SpectralFile {
        cube: SpectralCube::new(grid, planes).unwrap(),
        illuminant: Some(Spectrum::constant(grid, 2.0).unwrap()),
        ..ours(Quantity::Photons)
    };
    matlab::write(&dir.path().join("v5.mat"), &file, Version::V5).unwrap();
    matlab::write(&dir.path().join("v73.mat"), &file, Version::V73).unwrap();
    hdf5::write(&dir.path().join("plain.h5"), &file).unwrap();
    let chunks = [[1, 40, 33], [2, 7, 10], [7, 5, 33], [7, 40, 4], [3, 64, 64]];
    for (i, chunk) in chunks.iter().enumerate() {
        let mut builder = hdf5_pure::FileBuilder::new();
        let cube =
            builder.create_dataset("cube").with_f32_data(&data).with_shape(&[7, rows as u64, cols as u64]);
        cube.with_chunks(chunk).with_shuffle().with_deflate(1 + i as u32);
        let nm: Vec<f64> = grid.wavelengths_nm().collect();
        builder.create_dataset("wavelengths").with_f64_data(&nm);
        let mut out = std::fs::File::create(dir.path().join(format!("chunks{i}.h5"))).unwrap();
        builder.finish_to(&mut out).unwrap();
    }
    let mut names: Vec<_> = std::fs::read_dir(dir.path()).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    assert_eq!(names.len(), 3 + chunks.len());
    for path in names {
        let whole = read(&path, &ReadOptions::default()).unwrap();
        assert_eq!(whole.cube.planes().data(), data, "{}", path.display());
        let tiles = scene_file::open(&path, &ReadOptions::default()).unwrap().unwrap();
        for part in [
            Crop { row: 7, col: 5, rows: 11, cols: 3 },
            Crop { row: 39, col: 0, rows: 1, cols: 33 },
            Crop { row: 0, col: 32, rows: 40, cols: 1 },
        ] {
            let cut = part_of(&whole, part);
            assert_eq!(&tiles.read(part).unwrap(), cut.cube.planes(), "{}", path.display());
            let options = ReadOptions { crop: Some(part), ..ReadOptions::default() };
            assert_eq!(read(&path, &options).unwrap(), cut, "{}", path.display());
        }
        let beyond = tiles.read(Crop { row: 30, col: 0, rows: 11, cols: 3 }).unwrap_err();
        assert!(beyond.to_string().contains("the part to read is 11 rows from 30"), "{beyond}");
    }
}

fn numbers(v: &Value) -> Vec<f64> {
    match v {
        Value::Array(a) => a.iter().flat_map(numbers).collect(),
        v => vec![v.as_f64().unwrap()],
    }
}

#[test]
fn scipy_and_h5py_read_ours() {
    let dir = tempfile::tempdir().unwrap();
    let file = ours(Quantity::Photons);
    matlab::write(&dir.path().join("ours.mat"), &file, Version::V5).unwrap();
    matlab::write(&dir.path().join("ours73.mat"), &file, Version::V73).unwrap();
    hdf5::write(&dir.path().join("ours.h5"), &file).unwrap();
    let Some(seen) = python(SCRIPT, PACKAGES, &[Path::new("read"), dir.path()]) else { return };
    let planes = file.cube.planes();
    let mut interleaved = Vec::new();
    for i in 0..planes.plane_len() {
        interleaved.extend(planes.planes().map(|p| f64::from(p[i])));
    }
    let wave: Vec<f64> = file.cube.grid().wavelengths_nm().collect();
    for (seen, class, kind) in [(&seen[0], "float32", "scene"), (&seen[1], "single", "struct")] {
        assert_eq!(seen["class"], class);
        assert_eq!(numbers(&seen["photons"]), interleaved, "{class}");
        assert_eq!(numbers(&seen["wave"]), wave);
        assert_eq!(numbers(&seen["light"]), file.illuminant.as_ref().unwrap().values());
        assert_eq!((&seen["distance"], &seen["fov"]), (&1.3.into(), &10.0.into()));
        assert_eq!((&seen["name"], &seen["type"]), (&"ours, ä".into(), &kind.into()));
    }
    let plain: Vec<f64> = planes.data().iter().map(|&v| f64::from(v)).collect();
    assert_eq!((numbers(&seen[2]["cube"]), numbers(&seen[2]["wave"])), (plain, wave));
    assert_eq!((&seen[2]["units"], &seen[2]["quantity"]), (&"nm".into(), &file.quantity.name().into()));
}

/// Runs a program of Octave in a folder; what it prints. None, with a message, where Octave is absent.
fn octave(program: &str, folder: &Path) -> Option<String> {
    let run = Command::new("octave-cli")
        .args(["--quiet", "--norc", "--eval", program])
        .current_dir(folder)
        .output();
    let Ok(output) = run else {
        eprintln!("skipped: no octave-cli");
        return None;
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

#[test]
fn files_of_octave_are_read_and_ours_by_it() {
    let dir = tempfile::tempdir().unwrap();
    let program = "
        [r, c, b] = ndgrid(0:4, 0:3, 0:6);
        photons = mod(r + 5*c + 20*b, 120) + 1;
        wave = 400:50:700; fov = 12.5; dist = 2; name = 'octave'; comment = 'none';
        illuminant.name = 'D65'; illuminant.type = 'illuminant';
        illuminant.data.photons = linspace(1, 2, 7)'; illuminant.spectrum.wave = wave;
        all = {'photons', 'wave', 'fov', 'dist', 'name', 'comment', 'illuminant'};
        save('-6', 'six.mat', all{:}); save('-7', 'seven.mat', all{:}); save('-hdf5', 'own.h5', all{:});
        scene.name = 'octave'; scene.distance = 2; scene.wAngular = 12.5; scene.spectrum.wave = wave';
        scene.data.photons = single(photons); scene.illuminant = illuminant;
        save('-7', 'scene.mat', 'scene'); save('-hdf5', 'scene.h5', 'scene');";
    if octave(program, dir.path()).is_none() {
        return;
    }
    for name in ["six.mat", "seven.mat", "own.h5", "scene.mat", "scene.h5"] {
        let file = read(&dir.path().join(name), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        check(&file, 1.0, 0.0, name);
        check_scene(&file, ("octave", 2.0, 12.5), name);
    }

    let file = ours(Quantity::Photons);
    for (name, version) in [("ours.mat", Version::V5), ("ours73.mat", Version::V73)] {
        matlab::write(&dir.path().join(name), &file, version).unwrap();
    }
    let program = "
        s = load('ours.mat').scene;
        printf('%s %s %s %d %d %d\\n', s.type, class(s.data.photons), class(s.illuminant.data.photons), size(s.data.photons));
        printf('%.17g %.17g %.17g\\n', s.data.photons(2, 3, 4), s.distance, s.wAngular);
        printf('%.17g ', s.spectrum.wave, s.illuminant.data.photons);
        t = load('ours73.mat');
        printf('\\n%d %d %d %.17g', size(t.scene.data.photons), t.scene.data.photons(2, 3, 4));";
    let seen = octave(program, dir.path()).unwrap();
    let mut lines = seen.lines();
    assert_eq!(lines.next(), Some("scene single double 5 4 7"));
    let value = file.cube.planes().plane(3).unwrap()[4 + 2];
    assert_eq!(lines.next().unwrap(), format!("{value:.0} 1.3 10"), "{seen}");
    let columns: Vec<f64> = lines.next().unwrap().split_whitespace().map(|v| v.parse().unwrap()).collect();
    let light = file.illuminant.as_ref().unwrap();
    let expected: Vec<f64> =
        file.cube.grid().wavelengths_nm().chain(light.values().iter().copied()).collect();
    assert_eq!(columns, expected);
    assert_eq!(lines.next().unwrap(), format!("5 4 7 {value:.0}"), "{seen}");
}

#[test]
fn what_the_fuzzer_found_is_refused() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/findings");
    let error = |name: &str| read(&folder.join(name), &ReadOptions::default()).unwrap_err();
    // Four gibibytes would be taken for it.
    let chunk = error("chunk_of_4_gib.h5");
    assert!(matches!(chunk, IoError::Truncated { what: "a chunk", .. }), "{chunk}");
    for name in [
        "elements_of_many_bytes.h5",
        "empty_wavelengths_of_many_bands.h5",
        "integers_of_many_bytes.h5",
        "sum_beyond_64_bits.h5",
    ] {
        let error = error(name);
        assert!(matches!(error, IoError::Decode { .. } | IoError::Field { .. }), "{error}");
    }
}

/// `cargo test --release -p smalti-io --test it -- --ignored --nocapture numpy`. The yardstick is NumPy's own time for the same
/// numbers, or that of SciPy or h5py where they are faster.
#[test]
#[ignore = "a measurement, of a release build on an idle machine"]
fn cubes_are_read_within_twice_the_time_of_numpy() {
    let dir = tempfile::tempdir().unwrap();
    let Some(seen) = python(SCRIPT, PACKAGES, &[Path::new("time"), dir.path()]) else { return };
    let mut slow = Vec::new();
    for seen in seen {
        let name = seen["name"].as_str().unwrap();
        let [numpy, theirs] = ["numpy", "theirs"].map(|key| seen[key].as_f64().unwrap());
        let mut best = f64::INFINITY;
        for _ in 0..9 {
            let start = Instant::now();
            let file = read(&dir.path().join(name), &ReadOptions::default()).unwrap();
            best = best.min(start.elapsed().as_secs_f64());
            assert_eq!(file.cube.planes().data().len(), 512 * 512 * 31);
        }
        let ratio = best / numpy.min(theirs);
        let [best, numpy, theirs] = [best, numpy, theirs].map(|s| s * 1e3);
        println!("{name:24} ours {best:6.1} ms, NumPy {numpy:6.1} ms, theirs {theirs:6.1} ms, {ratio:.2}");
        if ratio > 2.0 {
            slow.push(name.to_owned());
        }
    }
    assert!(slow.is_empty(), "more than twice the time of the yardstick: {slow:?}");
}
