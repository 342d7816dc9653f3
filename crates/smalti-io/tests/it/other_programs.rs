//! What other programs make of our files, and we of theirs. Skipped, with a message, where Python or a package is
//! absent.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use smalti::color::display::Primaries;
use smalti::color::matrix::apply;
use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling};
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};
use smalti_io::dng::{self, ColorMatrix, Compression, DngInfo, DngPicture};
use smalti_io::exr::{self, Layout};
use smalti_io::picture::{self, Depth};
use smalti_io::{Limits, Quantity, ReadOptions, SpectralFile, scene_file};

use crate::python::python;

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn libraw_reads_the_mosaic_unchanged_in_all_four_phases() {
    let dir = tempfile::tempdir().unwrap();
    let (rows, cols) = (32, 48);
    let samples: Vec<u16> =
        (0..rows * cols).map(|i| (64 + i * 2654435761usize / 65536 % 4000) as u16).collect();
    // The white of an sRGB-like camera: raw developers want a matrix.
    let matrix = vec![[3.2405, -1.5371, -0.4985], [-0.9693, 1.8760, 0.0416], [0.0556, -0.2040, 1.0572]];
    let info = DngInfo {
        make: "Smalti".into(),
        model: "Bayer".into(),
        color_matrix: Some(ColorMatrix { camera_from_xyz: matrix, light_source: 21 }),
        as_shot_neutral: Some(vec![0.9505, 1.0, 1.0888]),
        ..DngInfo::default()
    };
    let tile = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
    let mut paths = Vec::new();
    // The channels in the order of DNG and in another.
    for (order, names) in [([0u8, 1, 2], ["R", "G", "B"]), ([1, 0, 2], ["G", "R", "B"])] {
        for (dr, dc) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let shifted = tile.shifted(dr, dc);
            let cells = shifted.cells().iter().map(|c| order[usize::from(*c)]).collect();
            let mosaic = Sampling::Mosaic(Mosaic::new(2, 2, cells).unwrap());
            let names = names.map(str::to_owned).to_vec();
            let samples = RawSamples::Digital(samples.clone());
            let raw = RawImage::new(rows, cols, samples, mosaic, names, 64.0, 4095.0).unwrap();
            let path = dir.path().join(format!("{}{dr}{dc}.dng", order[0]));
            // The matrix is per channel, in the order of the channels.
            let mut info = info.clone();
            if order[0] == 1 {
                info.color_matrix.as_mut().unwrap().camera_from_xyz.swap(0, 1);
                info.as_shot_neutral.as_mut().unwrap().swap(0, 1);
            }
            dng::write(&path, &raw, &info).unwrap();
            paths.push((path, shifted.clone()));
            let path = dir.path().join(format!("{}{dr}{dc}-coded.dng", order[0]));
            dng::write_compressed(&path, &raw, &info, Compression::LosslessJpeg).unwrap();
            paths.push((path, shifted));
        }
    }
    let arguments: Vec<&Path> = paths.iter().map(|(p, _)| p.as_path()).collect();
    let Some(seen) = python("check_dng.py", "rawpy, tifffile, numpy", &arguments) else { return };
    assert_eq!(seen.len(), 16);
    for (seen, (path, mosaic)) in seen.iter().zip(&paths) {
        let name = path.display();
        assert!(numbers(&seen["samples"]).into_iter().eq(samples.iter().map(|v| f64::from(*v))), "{name}");
        assert_eq!(numbers(&seen["visible"]), [rows as f64, cols as f64], "{name}");
        let pattern: Vec<&str> = seen["pattern"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|r| r.as_array().unwrap())
            .map(|v| v.as_str().unwrap())
            .collect();
        let expected: Vec<&str> = mosaic.cells().iter().map(|c| ["R", "G", "B"][usize::from(*c)]).collect();
        assert_eq!(pattern, expected, "{name}");
        assert!(numbers(&seen["black"]).iter().all(|b| *b == 64.0), "{name}: {}", seen["black"]);
        assert_eq!(seen["white"], 4095, "{name}");
        assert_eq!(numbers(&seen["developed"]), [rows as f64, cols as f64, 3.0], "{name}");
        // tifffile reads uncompressed samples without further packages.
        assert_eq!(seen["tifffile_equal"], !name.to_string().contains("coded"), "{name}");
        assert_eq!(seen["photometric"], "CFA", "{name}");
    }
}

/// LibRaw develops a linear DNG to the colours of the picture, in the light of its white.
#[test]
fn libraw_develops_a_picture_to_its_colours() {
    let dir = tempfile::tempdir().unwrap();
    let matrix = Primaries::SRGB.xyz_from_rgb().unwrap();
    let colors = [
        [0.9, 0.9, 0.9],
        [0.5, 0.1, 0.1],
        [0.1, 0.4, 0.1],
        [0.1, 0.15, 0.6],
        [0.5, 0.45, 0.1],
        [0.02, 0.03, 0.02],
    ];
    let (rows, side) = (32, 16);
    let cols = colors.len() * side;
    let xyz: Vec<[f64; 3]> = colors.iter().map(|rgb| apply(&matrix, *rgb)).collect();
    let plane = |c: usize| (0..rows * cols).map(move |i| (c, i % cols / side));
    let values = (0..3).flat_map(plane).map(|(c, patch)| xyz[patch][c] as f32).collect();
    let picture = Image::new(ColorSpace::Xyz, Planes::new(rows, cols, 3, values).unwrap()).unwrap();
    let white = Primaries::SRGB.white_xyz().unwrap();
    let path = dir.path().join("linear.dng");
    let stated = DngPicture { white, gain: 1.0, model: "picture".into(), ..DngPicture::default() };
    dng::write_picture(&path, &picture, &stated).unwrap();
    let Some(seen) = python("check_linear_dng.py", "rawpy", &[&path]) else { return };
    assert_eq!(numbers(&seen[0]["shape"]), [rows as f64, cols as f64, 3.0]);
    let row = numbers(&seen[0]["rows"][rows / 2]);
    let at = |patch: usize| &row[3 * (patch * side + side / 2)..][..3];
    let scale = at(0)[1] / colors[0][1];
    for (patch, color) in colors.iter().enumerate() {
        for (found, expected) in at(patch).iter().zip(color) {
            assert!((found / scale - expected).abs() < 0.003, "{patch}: {:?} {color:?}", at(patch));
        }
    }
    let Ok(output) = Command::new("exiftool").args(["-j", "-n", "-validate"]).arg(&path).output() else {
        return;
    };
    let seen: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(seen[0]["Validate"], "0 0 0", "{}", seen[0]);
}

/// ExifTool, which validates fields against the specification, and the mosaics LibRaw does not know.
#[test]
fn exiftool_finds_nothing_wrong_with_any_mosaic() {
    let Ok(version) = Command::new("exiftool").arg("-ver").output() else {
        eprintln!("skipped: no exiftool");
        return;
    };
    assert!(version.status.success());
    let dir = tempfile::tempdir().unwrap();
    for (name, (rows, cols), cells, letters) in [
        ("bayer", (2, 2), vec![0, 1, 1, 2], &["R", "G", "B"][..]),
        ("rgbw", (2, 2), vec![0, 1, 3, 2], &["R", "G", "B", "W"]),
        ("cmyg", (4, 2), vec![0, 1, 2, 3, 0, 1, 3, 2], &["C", "M", "Y", "G"]),
        ("xtrans", (3, 3), vec![1, 0, 2, 1, 1, 1, 1, 2, 0], &["R", "G", "B"]),
        ("infrared", (2, 2), vec![0, 1, 2, 3], &["R", "G", "B", "IR"]),
    ] {
        let channels = letters.len();
        let mosaic = Sampling::Mosaic(Mosaic::new(rows, cols, cells.clone()).unwrap());
        let samples = RawSamples::Digital((0..24 * 36).map(|i| (i * 37 % 1024) as u16).collect());
        let names = letters.iter().map(|s| (*s).to_owned()).collect();
        let raw = RawImage::new(24, 36, samples, mosaic, names, 64.0, 1023.0).unwrap();
        let info = DngInfo {
            make: "Smalti".into(),
            model: name.into(),
            color_matrix: Some(ColorMatrix {
                camera_from_xyz: (0..channels).map(|c| [0.5, 0.25 * c as f64, -0.125]).collect(),
                light_source: 21,
            }),
            as_shot_neutral: Some(vec![0.5; channels]),
            ..DngInfo::default()
        };
        let path = dir.path().join(format!("{name}.dng"));
        dng::write_compressed(&path, &raw, &info, Compression::LosslessJpeg).unwrap();
        let tags =
            ["-j", "-n", "-validate", "-warning", "-CFARepeatPatternDim", "-CFAPattern2", "-ColorMatrix1"];
        let output = Command::new("exiftool").args(tags).arg(&path).output().unwrap();
        let seen: Value = serde_json::from_slice(&output.stdout).unwrap();
        let seen = &seen[0];
        // Errors, warnings and minor ones.
        assert_eq!(seen["Validate"], "0 0 0", "{seen}");
        assert_eq!(seen["CFARepeatPatternDim"], format!("{rows} {cols}"), "{seen}");
        let code = |c: &u8| match letters[usize::from(*c)] {
            "IR" => "7".into(),
            letter => "RGBCMYW".find(letter).unwrap().to_string(),
        };
        let codes: Vec<String> = cells.iter().map(code).collect();
        assert_eq!(seen["CFAPattern2"], codes.join(" "), "{seen}");
        let matrix = seen["ColorMatrix1"].as_str().unwrap();
        assert_eq!(matrix.split(' ').count(), 3 * channels, "{seen}");
    }
}

/// imagecodecs codes with liblj92, in one component, as PiDNG and cameras do, and with libjxl.
#[test]
fn compressed_raw_files_of_another_program_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let packages = "imagecodecs, tifffile, numpy";
    let Some(seen) = python("make_dng.py", packages, &[dir.path()]) else { return };
    assert_eq!(seen.len(), 6);
    for seen in seen {
        let dng = dng::read(&dir.path().join(seen["file"].as_str().unwrap()), Limits::default()).unwrap();
        let RawSamples::Digital(samples) = dng.raw.samples() else { panic!("digital numbers") };
        assert!(samples.iter().map(|v| f64::from(*v)).eq(numbers(&seen["samples"])), "{}", seen["file"]);
        assert_eq!((dng.raw.black_level(), dng.raw.channel_names().len()), (64.0, 3));
    }
}

fn ramp(rows: usize, cols: usize) -> Image {
    let data = (0..rows * cols * 3).map(|i| (i * 7919 % 65536) as f32 / 65535.0).collect();
    Image::new(ColorSpace::Srgb, Planes::new(rows, cols, 3, data).unwrap()).unwrap()
}

#[test]
fn opencv_and_tifffile_read_our_pictures() {
    let dir = tempfile::tempdir().unwrap();
    let image = ramp(11, 13);
    for (name, depth) in [
        ("p8.png", Depth::Eight),
        ("p16.png", Depth::Sixteen),
        ("t8.tif", Depth::Eight),
        ("t16.tif", Depth::Sixteen),
    ] {
        picture::write(&dir.path().join(name), &image, depth).unwrap();
    }
    let Some(seen) = python("check_pictures.py", "cv2, tifffile, numpy", &[Path::new("read"), dir.path()])
    else {
        return;
    };
    for (seen, max) in seen.iter().zip([255.0, 65535.0, 255.0, 65535.0]) {
        assert_eq!(numbers(&seen["shape"]), [11.0, 13.0, 3.0]);
        for (i, v) in numbers(&seen["samples"]).iter().enumerate() {
            let ours = f64::from(image.planes().plane(i % 3).unwrap()[i / 3]) * max;
            // Rounded to the nearest level; the product is rounded in f32.
            assert!((v - ours).abs() <= 0.5 + 1e-2, "{v} {ours}");
        }
    }
}

#[test]
fn pictures_of_opencv_and_tifffile_are_read() {
    let dir = tempfile::tempdir().unwrap();
    if python("check_pictures.py", "cv2, tifffile, numpy", &[Path::new("write"), dir.path()]).is_none() {
        return;
    }
    let value = |c: usize, y: usize, x: usize| [x * 6, y * 10, (x + y) * 4][c] as f32 / 255.0;
    let read = |name: &str| picture::read(&dir.path().join(name), &ReadOptions::default()).unwrap();
    for (name, bits, tolerance) in [
        ("u8.png", 8, 1e-6),
        ("u16.png", 16, 1e-6),
        ("alpha.png", 8, 1e-6),
        ("lzw.tif", 16, 1e-6),
        ("f32.tif", 32, 1e-6),
        ("big.tif", 16, 1e-6),
        ("tiled.tif", 8, 1e-6),
        ("planar.tif", 8, 1e-6),
        // Quality 98: quantisation and subsampled chroma of a smooth ramp.
        ("u8.jpg", 8, 0.03),
        ("progressive.jpg", 8, 0.03),
    ] {
        let p = read(name);
        assert_eq!((p.bits, p.image.rows(), p.image.cols()), (bits, 24, 40), "{name}");
        let linear = if name == "f32.tif" { ColorSpace::LinearSrgb } else { ColorSpace::Srgb };
        assert_eq!(p.image.space(), linear, "{name}");
        assert_eq!(p.notes.len(), usize::from(name == "alpha.png"), "{name}: {:?}", p.notes);
        for (c, plane) in p.image.planes().planes().enumerate() {
            for (i, v) in plane.iter().enumerate() {
                let expected = value(c, i / 40, i % 40);
                assert!((v - expected).abs() < tolerance, "{name} {c} {i}: {v} {expected}");
            }
        }
    }
    let grey = read("grey.png").image;
    assert_eq!(grey.planes().plane(0).unwrap(), grey.planes().plane(2).unwrap());
    assert!((grey.planes().plane(1).unwrap()[5] - value(0, 0, 5)).abs() < 1e-6);
}

#[test]
fn the_openexr_library_reads_our_spectra() {
    let dir = tempfile::tempdir().unwrap();
    let grid = WavelengthGrid::new(400.0, 50.0, 7).unwrap();
    let data: Vec<f32> = (0..7 * 6).map(|i| i as f32 * 0.1).collect();
    let file = SpectralFile {
        name: "ours".into(),
        cube: SpectralCube::new(grid, Planes::new(2, 3, 7, data.clone()).unwrap()).unwrap(),
        quantity: Quantity::Energy,
        illuminant: Some(Spectrum::constant(grid, 2.0).unwrap()),
        distance_m: Some(1.5),
        horizontal_fov_deg: Some(20.0),
    };
    exr::write(&dir.path().join("fichet.exr"), &file, Layout::Fichet2021).unwrap();
    exr::write(&dir.path().join("pbrt.exr"), &file, Layout::Pbrt).unwrap();
    let Some(seen) = python("check_exr.py", "OpenEXR, numpy", &[Path::new("read"), dir.path()]) else {
        return;
    };
    assert_eq!((seen[0]["units"].as_str(), seen[0]["version"].as_str()), (Some("W.m^-2.sr^-1"), Some("1.0")));
    for (seen, name) in seen.iter().zip(["S0.", "Radiance.C"]) {
        let channels: BTreeMap<String, Vec<f32>> = serde_json::from_value(seen["channels"].clone()).unwrap();
        assert_eq!(channels.len(), 7);
        for (i, (key, values)) in channels.iter().enumerate() {
            assert!(key.starts_with(name), "{key}");
            assert_eq!(values[..], data[6 * i..6 * i + 6]);
        }
        assert_eq!(seen["comments"]["distance_m"], 1.5);
    }
}

#[test]
fn spectra_of_the_openexr_library_are_read() {
    let dir = tempfile::tempdir().unwrap();
    if python("check_exr.py", "OpenEXR, numpy", &[Path::new("write"), dir.path()]).is_none() {
        return;
    }
    let read = |name: &str| {
        scene_file::read_spectral(&dir.path().join(name), &ReadOptions::default()).unwrap().unwrap()
    };
    let emissive = read("emissive.exr");
    assert_eq!((emissive.quantity, emissive.cube.rows(), emissive.cube.cols()), (Quantity::Energy, 3, 5));
    assert_eq!(emissive.cube.grid(), WavelengthGrid::new(400.0, 20.0, 16).unwrap());
    for (nm, plane) in emissive.cube.grid().wavelengths_nm().zip(emissive.cube.planes().planes()) {
        assert!(plane.iter().all(|v| f64::from(*v) == nm));
    }
    let reflective = read("reflective.exr");
    assert_eq!(reflective.quantity, Quantity::Reflectance);
    let grid = reflective.cube.grid();
    assert!(
        (grid.start_nm() - 400.0).abs() < 1e-9 && (grid.step_nm() - 50.0).abs() < 1e-9 && grid.len() == 7
    );
    // Half floats have 11 bits.
    assert!((reflective.cube.planes().plane(3).unwrap()[0] - 0.55).abs() < 3e-4);
    let rgb = picture::read(&dir.path().join("rgb.exr"), &ReadOptions::default()).unwrap().image;
    for (plane, v) in rgb.planes().planes().zip([0.25f32, 0.5, 2.0]) {
        // PXR24 keeps 16 bits of the significand.
        assert!(plane.iter().all(|x| (x / v - 1.0).abs() < 1e-4));
    }
}
