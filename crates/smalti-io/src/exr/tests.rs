use std::path::Path;

use proptest::prelude::*;
use smalti::numeric::Planes;
use smalti::scene::{Scene, Setting};
use smalti::spectrum::units::photons_per_joule;
use smalti::spectrum::{Illuminant, SpectralCube, WavelengthGrid};

use super::*;
use crate::{IoError, Quantity, ReadOptions, SpectralFile, scene_file};

fn cube(grid: WavelengthGrid, rows: usize, cols: usize) -> SpectralCube {
    let n = rows * cols * grid.len();
    let data = (0..n).map(|i| 1e15 * (1.0 + (i * 7919 % 1000) as f32 / 333.0)).collect();
    SpectralCube::new(grid, Planes::new(rows, cols, grid.len(), data).unwrap()).unwrap()
}

fn scene(grid: WavelengthGrid) -> Scene {
    let light = Illuminant::D65.photons(grid).unwrap();
    Scene::new("a scene, “quoted”", cube(grid, 4, 5), light, 1.2, 9.7).unwrap()
}

fn round_trip(file: &SpectralFile, layout: Layout) -> (SpectralFile, Vec<u8>) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("f.exr");
    write(&path, file, layout).unwrap();
    (
        scene_file::read_spectral(&path, &ReadOptions::default()).unwrap().unwrap(),
        std::fs::read(&path).unwrap(),
    )
}

#[test]
fn a_scene_survives_both_layouts_exactly() {
    for grid in [WavelengthGrid::VISIBLE, WavelengthGrid::new(380.0, 1000.0 / 3.0 / 30.0, 12).unwrap()] {
        for layout in [Layout::Pbrt, Layout::Fichet2021] {
            let scene = scene(grid);
            let file = SpectralFile::of_scene(&scene);
            let (back, bytes) = round_trip(&file, layout);
            assert_eq!(back, file);
            assert_eq!(back.into_scene(&Setting::default()).unwrap(), scene);
            assert_eq!(round_trip(&file, layout).1, bytes, "equal values make equal bytes");
        }
    }
}

#[test]
fn energy_is_photons_over_photons_per_joule() {
    let file = SpectralFile::of_scene(&scene(WavelengthGrid::VISIBLE));
    let energy = file.clone().into_energy().unwrap();
    let ratio = f64::from(file.cube.planes().plane(3).unwrap()[7])
        / f64::from(energy.cube.planes().plane(3).unwrap()[7]);
    assert!((ratio / photons_per_joule(430.0) - 1.0).abs() < 1e-6);
    let (back, _) = round_trip(&energy, Layout::Fichet2021);
    assert_eq!(back.quantity, Quantity::Energy);
    let again = back.into_scene(&Setting::default()).unwrap();
    for (a, b) in again.radiance().planes().data().iter().zip(file.cube.planes().data()) {
        // Two roundings of f32.
        assert!((a / b - 1.0).abs() <= 2.4e-7);
    }
}

#[test]
fn a_reflectance_is_lit_and_scaled() {
    let grid = WavelengthGrid::VISIBLE;
    let half = Planes::new(2, 3, grid.len(), vec![0.5; 6 * grid.len()]).unwrap();
    let file = SpectralFile {
        name: "half".into(),
        cube: SpectralCube::new(grid, half).unwrap(),
        quantity: Quantity::Reflectance,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    };
    assert!(write(Path::new("x.exr"), &file, Layout::Pbrt).is_err());
    let (back, _) = round_trip(&file, Layout::Fichet2021);
    assert_eq!(back, SpectralFile { name: "half".into(), ..file });
    let scene = back.into_scene(&Setting { luminance_cd_m2: 50.0, ..Setting::default() }).unwrap();
    assert!((scene.mean_luminance_cd_m2().unwrap() - 50.0).abs() < 1e-4);
    let white = f64::from(scene.radiance().planes().plane(15).unwrap()[0]) / scene.illuminant().values()[15];
    assert!((white - 0.5).abs() < 1e-6);
}

#[test]
fn a_black_relative_image_cannot_be_scaled() {
    let grid = WavelengthGrid::VISIBLE;
    let file = SpectralFile {
        name: "black".into(),
        cube: SpectralCube::new(grid, Planes::zeros(1, 1, 31)).unwrap(),
        quantity: Quantity::RelativeEnergy,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    };
    let error = file.into_scene(&Setting::default()).unwrap_err().to_string();
    assert_eq!(error, "black: the mean luminance is 0; expected light to scale");
}

/// Channels written by hand, for what our writer never writes.
fn exr_with(channels: &[(&str, [f32; 2])]) -> Vec<u8> {
    use ::exr::prelude::*;
    let list = channels.iter().map(|(n, v)| AnyChannel::new(Text::from(*n), FlatSamples::F32(v.to_vec())));
    let layer = Layer::new(
        (2, 1),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(list.collect()),
    );
    let mut out = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}

fn read_bytes(bytes: &[u8]) -> Result<SpectralFile, IoError> {
    from_bytes(bytes, Path::new("f.exr"), &ReadOptions::default())
}

#[test]
fn unequal_wavelengths_and_units_are_resampled() {
    let bytes = exr_with(&[
        ("S0.0,42um", [4.0, 4.0]),
        ("S0.405,0nm", [1.0, 1.0]),
        ("S0.400nm", [0.0, 0.0]),
        ("R", [9.0; 2]),
    ]);
    let file = read_bytes(&bytes).unwrap();
    assert_eq!(file.quantity, Quantity::RelativeEnergy);
    assert_eq!((file.cube.grid().start_nm(), file.cube.grid().len()), (400.0, 5));
    let got: Vec<f32> = file.cube.planes().planes().map(|p| p[1]).collect();
    for (g, e) in got.iter().zip([0.0, 1.0, 2.0, 3.0, 4.0]) {
        assert!((g - e).abs() < 1e-5, "{got:?}");
    }
}

#[test]
fn bad_values_name_their_band_and_pixel() {
    let bytes = exr_with(&[("S0.400,0nm", [1.0, 1.0]), ("S0.410,0nm", [1.0, -0.25])]);
    let error = read_bytes(&bytes).unwrap_err().to_string();
    assert_eq!(
        error,
        "f.exr: channel S0.410,0nm, row 0, column 1 (counted from 0) is -0.25; expected a finite number, not negative"
    );
    let clamp = ReadOptions { clamp_negative: true, ..ReadOptions::default() };
    assert_eq!(
        from_bytes(&bytes, Path::new("f"), &clamp).unwrap().cube.planes().plane(1).unwrap(),
        [1.0, 0.0]
    );
    let nan = exr_with(&[("S0.400,0nm", [f32::NAN, 1.0]), ("S0.410,0nm", [1.0, 1.0])]);
    assert!(
        from_bytes(&nan, Path::new("f"), &clamp)
            .unwrap_err()
            .to_string()
            .contains("row 0, column 0 (counted from 0) is NaN")
    );
}

/// Three bands of all types beside a channel of a picture, 5 × 7, in blocks.
fn exr_in(blocks: ::exr::prelude::Blocks, compression: ::exr::prelude::Compression) -> Vec<u8> {
    use ::exr::prelude::*;
    let at = |band: usize, i: usize| (100 * band + i) as f32;
    let list = [
        ("B", FlatSamples::F16(vec![f16::from_f32(0.5); 35])),
        ("S0.400,0nm", FlatSamples::F32((0..35).map(|i| at(0, i)).collect())),
        ("S0.500,0nm", FlatSamples::U32((0..35).map(|i| at(1, i) as u32).collect())),
        ("S0.600,0nm", FlatSamples::F16((0..35).map(|i| f16::from_f32(at(2, i))).collect())),
    ];
    let list = list.into_iter().map(|(name, samples)| AnyChannel::new(name, samples));
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let layer = Layer::new((7, 5), LayerAttributes::default(), encoding, AnyChannels::sort(list.collect()));
    let mut out = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}

#[test]
fn every_block_type_and_part_is_read() {
    use ::exr::prelude::{Blocks, Compression, Vec2};
    for compression in [Compression::Uncompressed, Compression::RLE, Compression::ZIP16, Compression::PIZ] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(3, 2)), Blocks::Tiles(Vec2(64, 64))] {
            let bytes = exr_in(blocks, compression);
            let file = read_bytes(&bytes).unwrap();
            for band in 0..3 {
                let expected: Vec<f32> = (0..35).map(|i| (100 * band + i) as f32).collect();
                assert_eq!(file.cube.planes().plane(band).unwrap(), expected, "{blocks:?} {compression:?}");
            }
            let part = crate::scene_file::Crop { row: 1, col: 2, rows: 3, cols: 4 };
            let options = ReadOptions { crop: Some(part), ..ReadOptions::default() };
            let cut = from_bytes(&bytes, Path::new("f.exr"), &options).unwrap();
            let expected =
                scene_file::load(&scene_file::Whole::new(&file), Path::new("f"), &options).unwrap();
            assert_eq!(cut, expected, "{blocks:?} {compression:?}");
        }
    }
}

/// Two layers of lines as they are, 2 × 3, with bands in single precision; the first begins at row −4. What the bands of a layer are is
/// told by `first_nm`.
fn two_layers(first_nm: [u32; 2]) -> Vec<u8> {
    use ::exr::prelude::*;
    let layer = |(number, nm): (usize, u32)| {
        let samples =
            |band: usize| FlatSamples::F32((0..6).map(|i| (100 * number + 10 * band + i) as f32).collect());
        let names = ["Z".to_owned(), format!("S0.{nm},0nm"), format!("S0.{},0nm", nm + 10)];
        let list = names.iter().enumerate().map(|(band, name)| AnyChannel::new(name.as_str(), samples(band)));
        let attributes = LayerAttributes {
            layer_position: Vec2(3, -4 * i32::from(number == 0)),
            ..LayerAttributes::named(format!("layer {number}").as_str())
        };
        let encoding = Encoding {
            compression: Compression::Uncompressed,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        Layer::new((3, 2), attributes, encoding, AnyChannels::sort(list.collect()))
    };
    let layers: Vec<_> = first_nm.into_iter().enumerate().map(layer).collect();
    let window = IntegerBounds::new((0, -4), (9usize, 9usize));
    let mut out = std::io::Cursor::new(Vec::new());
    Image::from_layers(ImageAttributes::new(window), layers).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}

#[test]
fn plain_lines_are_read_where_they_lie() {
    let bytes = two_layers([400, 600]);
    let file = read_bytes(&bytes).unwrap();
    // Channels are sorted by name: Z, which is no band, comes last.
    let expected = |band: usize| (0..6).map(|i| (10 * (band + 1) + i) as f32).collect::<Vec<f32>>();
    assert_eq!(file.cube.planes().plane(0).unwrap(), expected(0));
    assert_eq!(file.cube.planes().plane(1).unwrap(), expected(1));
    // Behind the headers are two tables of two blocks each; the first block follows.
    let tables = (8..bytes.len() - 8)
        .find(|at| u64::from_le_bytes(bytes[*at..at + 8].try_into().unwrap()) == *at as u64 + 32)
        .unwrap();
    let of_other_layer = bytes[tables + 16..tables + 24].to_vec();
    let mut wrong = bytes.clone();
    wrong[tables..tables + 8].copy_from_slice(&of_other_layer);
    let error = read_bytes(&wrong).unwrap_err().to_string();
    assert!(
        error.contains("f.exr: not a valid OpenEXR file: the header of block 0 is that of another block"),
        "{error}"
    );
    let mut cut = bytes.clone();
    cut.truncate(bytes.len() - 1);
    assert!(read_bytes(&cut).is_ok(), "the other layer is not looked at");
    cut.truncate(tables + 32 + 40);
    assert!(read_bytes(&cut).unwrap_err().to_string().contains("a block needs"));
}

#[test]
fn a_table_of_blocks_that_lies_is_found_out() {
    let good = exr_in(::exr::prelude::Blocks::ScanLines, ::exr::prelude::Compression::ZIP1);
    // The table of five blocks ends where the first block begins.
    let first = (8..good.len() - 8)
        .find(|at| u64::from_le_bytes(good[*at..at + 8].try_into().unwrap()) == *at as u64 + 40)
        .unwrap();
    let change = |block: usize, to: u64| {
        let mut bytes = good.clone();
        bytes[first + 8 * block..][..8].copy_from_slice(&to.to_le_bytes());
        read_bytes(&bytes).unwrap_err().to_string()
    };
    let second = u64::from_le_bytes(good[first + 8..first + 16].try_into().unwrap());
    assert!(
        change(0, second).contains("the header of block 0 is that of another block"),
        "{}",
        change(0, second)
    );
    assert!(
        change(2, u64::MAX).contains("a block needs 18446744073709551615 bytes"),
        "{}",
        change(2, u64::MAX)
    );
    assert!(
        read_bytes(&good[..first + 39])
            .unwrap_err()
            .to_string()
            .contains("the table of blocks needs 40 bytes")
    );
}

#[test]
fn what_is_missing_is_said() {
    let rgb = exr_with(&[("R", [1.0; 2]), ("G", [1.0; 2]), ("B", [1.0; 2])]);
    assert!(read_bytes(&rgb).unwrap_err().to_string().contains("the spectrum is absent"));
    let two = exr_with(&[("Radiance.C01", [1.0; 2]), ("Radiance.C02", [2.0; 2])]);
    assert!(read_bytes(&two).unwrap_err().to_string().contains("not stated for 2 bands"));
    let grid = WavelengthGrid::new(500.0, 100.0, 2).unwrap();
    let options = ReadOptions { grid: Some(grid), ..ReadOptions::default() };
    assert_eq!(from_bytes(&two, Path::new("f"), &options).unwrap().cube.grid(), grid);
    assert!(read_bytes(b"not exr").unwrap_err().to_string().starts_with("f.exr: not a valid OpenEXR file"));
    let picture = crate::picture::from_bytes(&rgb, Path::new("f"), &options).unwrap();
    assert_eq!(picture.image.planes().data(), [1.0; 6]);
    assert!(crate::picture::from_bytes(&two, Path::new("f"), &options).is_err());
}

/// A file as ISET3d's fork of pbrt writes it: colour and 31 numbered bands from 400 to 700 nm in one layer, of which nothing states
/// wavelengths or units, and attributes of the renderer beside them.
#[test]
fn a_rendering_of_pbrt_is_read() {
    use ::exr::prelude::*;
    let (rows, cols) = (18, 20);
    let value = |band: usize, i: usize| 0.01 * (1.0 + band as f32) * (1.0 + (i * 37 % 101) as f32);
    let plane = |band| FlatSamples::F32((0..rows * cols).map(|i| value(band, i)).collect());
    let numbered = (1..=31).map(|n| (format!("Radiance.C{n:02}"), plane(n)));
    let color = ["R", "G", "B"].map(|name| (name.to_owned(), plane(0)));
    let channels =
        numbered.chain(color).map(|(name, samples)| AnyChannel::new(Text::from(name.as_str()), samples));
    let mut attributes = LayerAttributes::default();
    attributes.other.insert(Text::from("renderTimeSeconds"), AttributeValue::F32(0.13));
    attributes.other.insert(Text::from("samplesPerPixel"), AttributeValue::I32(32));
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::default() };
    let layer = Layer::new((cols, rows), attributes, encoding, AnyChannels::sort(channels.collect()));
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    let bytes = bytes.into_inner();

    let file = read_bytes(&bytes).unwrap();
    assert_eq!((file.cube.rows(), file.cube.cols(), file.cube.grid()), (rows, cols, WavelengthGrid::VISIBLE));
    assert_eq!((file.quantity, file.name.as_str()), (Quantity::RelativeEnergy, "f"));
    for (band, plane) in file.cube.planes().planes().enumerate() {
        assert!(plane.iter().enumerate().all(|(i, &v)| v == value(band + 1, i)), "band {band}");
    }
    let scene = file.into_scene(&Setting::default()).unwrap();
    assert!((scene.mean_luminance_cd_m2().unwrap() - 100.0).abs() < 1e-3);
    let picture = crate::picture::from_bytes(&bytes, Path::new("f"), &ReadOptions::default()).unwrap();
    assert_eq!(picture.image.planes().plane(2).unwrap()[7], value(0, 7));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn mutated_files_are_read_or_refused(
        at in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(), whole in any::<bool>(), header in any::<bool>(), spectral in any::<bool>(),
    ) {
        let mut bytes = if spectral {
            round_trip(&SpectralFile::of_scene(&scene(WavelengthGrid::new(400.0, 100.0, 3).unwrap())), Layout::Fichet2021).1
        } else {
            exr_with(&[("R", [1.0; 2]), ("G", [1.0; 2]), ("B", [1.0; 2])])
        };
        for (index, value) in at {
            let i = index.index(if header { bytes.len().min(400) } else { bytes.len() });
            bytes[i] = value;
        }
        if !whole {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = read_bytes(&bytes);
        let _ = crate::picture::from_bytes(&bytes, Path::new("f"), &ReadOptions::default());
    }

    #[test]
    fn random_bytes_are_refused(rest in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(read_bytes(&rest).is_err());
        prop_assert!(read_bytes(&[b"\x76\x2f\x31\x01\x02\0\0\0", &rest[..]].concat()).is_err());
    }
}
