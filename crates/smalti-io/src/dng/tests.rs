use std::path::Path;

use proptest::prelude::*;
use smalti::color::matrix::{apply, inverse};
use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;
use smalti::sensor::{Mosaic, RawSamples, Sampling};

use super::*;
use crate::{IoError, Limits};

mod real_files;

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|s| (*s).to_owned()).collect()
}

fn digital(rows: usize, cols: usize, mosaic: Mosaic, channels: &[&str]) -> RawImage {
    let samples = (0..rows * cols).map(|i| (i * 31 % 4096) as u16).collect();
    let sampling = Sampling::Mosaic(mosaic);
    RawImage::new(rows, cols, RawSamples::Digital(samples), sampling, names(channels), 64.0, 4095.0).unwrap()
}

fn bytes_of(raw: &RawImage, info: &DngInfo) -> Vec<u8> {
    if matches!(raw.samples(), RawSamples::Digital(_)) && raw.sampling().planes() <= 4 {
        coded(raw, info, Compression::LosslessJpeg);
    }
    coded(raw, info, Compression::None)
}

fn coded(raw: &RawImage, info: &DngInfo, compression: Compression) -> Vec<u8> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("f.dng");
    write_compressed(&path, raw, info, compression).unwrap();
    let back = read(&path, Limits::default()).unwrap();
    assert_eq!((&back.raw, &back.info), (raw, info));
    std::fs::read(&path).unwrap()
}

fn parse(bytes: &[u8]) -> Result<Dng, IoError> {
    from_bytes(bytes, Path::new("f.dng"))
}

#[test]
fn every_kind_of_mosaic_reads_back_equal() {
    let info = DngInfo {
        make: "Smalti".into(),
        model: "test".into(),
        color_matrix: Some(ColorMatrix {
            camera_from_xyz: vec![[0.5, -0.25, 0.125], [0.0, 1.0, 0.0], [1.5, 0.0, -1.0]],
            light_source: 21,
        }),
        as_shot_neutral: Some(vec![0.5, 1.0, 0.75]),
        baseline_exposure_stops: Some(-1.5),
    };
    let bayer = digital(6, 8, Mosaic::new(2, 2, vec![1, 0, 2, 1]).unwrap(), &["R", "G", "B"]);
    assert_eq!(parse(&bytes_of(&bayer, &info)).unwrap().notes, Vec::<String>::new());

    let reversed = digital(6, 8, Mosaic::new(2, 2, vec![1, 0, 2, 1]).unwrap(), &["B", "G", "R"]);
    bytes_of(&reversed, &info);

    let plain = DngInfo::default();
    // Letters in another order than DNG's, letters twice, names DNG has no code for, a tile wider than the image.
    for (rows, cols, cells, channels) in [
        (2, 2, vec![0, 1, 1, 2], &["B", "W", "R"][..]),
        (2, 2, vec![0, 1, 2, 3], &["G", "R", "G", "infrared “850”"]),
        (1, 9, vec![0, 1, 2, 3, 4, 5, 6, 7, 8], &["R", "G", "B", "C", "M", "Y", "W", "E", "X"]),
        (3, 1, vec![0, 0, 0], &["W"]),
    ] {
        let raw = digital(5, 7, Mosaic::new(rows, cols, cells).unwrap(), channels);
        bytes_of(&raw, &plain);
    }
}

#[test]
fn volts_and_full_sampling_read_back_equal() {
    let volts = |n: usize| RawSamples::Analog((0..n).map(|i| i as f32 * 0.01 - 0.003).collect());
    let mosaic = Sampling::Mosaic(Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap());
    let raw = RawImage::new(4, 6, volts(24), mosaic, names(&["R", "G", "B"]), -0.01, 1.8).unwrap();
    bytes_of(&raw, &DngInfo::default());
    let full = Sampling::Full { channels: 5 };
    let raw =
        RawImage::new(3, 4, volts(60), full.clone(), names(&["a", "b", "c", "d", "e"]), 0.1, 1.8).unwrap();
    bytes_of(&raw, &DngInfo::default());
    let numbers = RawSamples::Digital((0..60).collect());
    let raw = RawImage::new(3, 4, numbers, full, names(&["a", "b", "c", "d", "e"]), 0.5, 1023.0).unwrap();
    bytes_of(&raw, &DngInfo::default());
}

#[test]
fn without_our_description_the_fields_of_dng_suffice() {
    let raw = digital(4, 4, Mosaic::new(2, 2, vec![2, 1, 0, 2]).unwrap(), &["R", "G", "B"]);
    let mut bytes = bytes_of(&raw, &DngInfo::default());
    let at = bytes.windows(6).position(|w| w == b"smalti").unwrap();
    bytes[at] = b'x';
    let back = parse(&bytes).unwrap().raw;
    assert_eq!(back, raw);
}

#[test]
fn a_matrix_must_have_a_row_per_channel() {
    let raw = digital(2, 2, Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap(), &["R", "G", "B"]);
    let info = DngInfo { as_shot_neutral: Some(vec![1.0]), ..DngInfo::default() };
    let error = write(Path::new("f.dng"), &raw, &info).unwrap_err().to_string();
    assert_eq!(error, "f.dng: as_shot_neutral is 1 long; expected one entry for each of 3 channels");
}

#[test]
fn what_is_not_read_is_said() {
    assert_eq!(parse(b"P6").unwrap_err().to_string(), "f.dng: expected a DNG file");
    let raw = digital(4, 4, Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap(), &["R", "G", "B"]);
    let bytes = bytes_of(&raw, &DngInfo::default());
    let patched = |tag: u16, value: u16| {
        let mut b = bytes.clone();
        let entry = (0..40).map(|i| 10 + 12 * i).find(|&i| b[i..i + 2] == tag.to_le_bytes()).unwrap();
        b[entry + 8..entry + 10].copy_from_slice(&value.to_le_bytes());
        parse(&b).unwrap_err().to_string()
    };
    use crate::tiff::tags;
    assert!(patched(tags::COMPRESSION, 34892).contains("Compression is 34892 (lossy JPEG); expected 1"));
    assert!(patched(tags::COMPRESSION, 52546).contains("row 0, column 0 (counted from 0): JPEG XL"));
    assert!(patched(tags::COMPRESSION, 7).contains("lossless JPEG: it does not begin as a JPEG does"));
    assert!(patched(tags::COMPRESSION, 8).contains("row 0, column 0 (counted from 0): Deflate"));
    assert!(patched(tags::CFA_LAYOUT, 2).contains("CFALayout is 2; expected 1"));
    assert!(patched(tags::BITS_PER_SAMPLE, 24).contains("BitsPerSample"));
    assert!(patched(tags::IMAGE_WIDTH, 60_000).contains("the raw image needs"));
    assert!(patched(tags::CFA_REPEAT_PATTERN_DIM, 3).contains("tile"));
}

/// A big-endian file by hand: fields of type LONG or, where `true`, BYTE; each strip or tile at 1000, 2000 …
fn by_hand(fields: &[(u16, bool, Vec<u32>)], chunks: &[Vec<u8>]) -> Vec<u8> {
    let mut out = b"MM\0*\0\0\0\x08".to_vec();
    out.extend((fields.len() as u16).to_be_bytes());
    let mut more = Vec::new();
    for (tag, bytes, values) in fields {
        let values: Vec<u8> = match bytes {
            true => values.iter().map(|v| *v as u8).collect(),
            false => values.iter().flat_map(|v| v.to_be_bytes()).collect(),
        };
        out.extend(tag.to_be_bytes());
        out.extend((if *bytes { 1u16 } else { 4 }).to_be_bytes());
        out.extend((values.len() as u32 / if *bytes { 1 } else { 4 }).to_be_bytes());
        if values.len() <= 4 {
            out.extend(values.iter().copied().chain([0; 4]).take(4));
        } else {
            out.extend((9000 + more.len() as u32).to_be_bytes());
            more.extend(values);
        }
    }
    for (i, chunk) in chunks.iter().enumerate() {
        out.resize(1000 * (i + 1), 0);
        out.extend(chunk);
    }
    out.resize(9000, 0);
    out.extend(more);
    out
}

const SIZE: (usize, usize) = (5, 6);

fn value(r: usize, c: usize) -> u32 {
    (100 * r + c) as u32
}

/// Four tiles of 4 × 4 for a mosaic of `SIZE` with a border of a row and a column.
fn tiled(bits: u32, more: &[(u16, bool, Vec<u32>)], code: impl Fn(&[u32]) -> Vec<u8>) -> Vec<u8> {
    let tile = |(r0, c0): (usize, usize)| -> Vec<u8> {
        let samples: Vec<u32> = (0..16).map(|i| value(r0 + i / 4, c0 + i % 4)).collect();
        code(&samples)
    };
    let tiles: Vec<Vec<u8>> = [(0, 0), (0, 4), (4, 0), (4, 4)].map(tile).to_vec();
    let mut fields = vec![
        (256, false, vec![SIZE.1 as u32]),
        (257, false, vec![SIZE.0 as u32]),
        (258, false, vec![bits]),
        (262, false, vec![32803]),
        (322, false, vec![4]),
        (323, false, vec![4]),
        (324, false, vec![1000, 2000, 3000, 4000]),
        (325, false, tiles.iter().map(|t| t.len() as u32).collect()),
        (33421, false, vec![2, 2]),
        (33422, true, vec![0, 1, 1, 2]),
        (50706, true, vec![1, 4, 0, 0]),
        (50829, false, vec![1, 1, 5, 6]),
    ];
    fields.extend(more.iter().cloned());
    by_hand(&fields, &tiles)
}

fn samples_of(raw: &RawImage) -> &[u16] {
    let RawSamples::Digital(v) = raw.samples() else { panic!("digital") };
    v
}

fn packed(bits: u32) -> impl Fn(&[u32]) -> Vec<u8> {
    move |samples| {
        let bits: Vec<u8> =
            samples.iter().flat_map(|v| (0..bits).rev().map(move |b| (v >> b & 1) as u8)).collect();
        bits.chunks(8).map(|b| b.iter().fold(0, |a, x| a << 1 | x)).collect()
    }
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

#[test]
fn tiles_borders_and_every_coding_are_read() {
    let lossless = |components: usize| {
        move |samples: &[u32]| {
            let samples: Vec<u16> = samples.iter().map(|v| *v as u16).collect();
            // Two rows of the tile as one of the frame, as some cameras do.
            ljpeg::encode(&samples, 8 / components, components, 6, 1).unwrap()
        }
    };
    let big = |samples: &[u32]| samples.iter().flat_map(|v| (*v as u16).to_be_bytes()).collect::<Vec<u8>>();
    let differences = |step: usize| {
        move |samples: &[u32]| {
            let rows = samples.chunks(4).flat_map(|row| {
                let before = |i: usize| if i < step { 0 } else { row[i - step] };
                row.iter().enumerate().map(move |(i, v)| v.wrapping_sub(before(i))).collect::<Vec<u32>>()
            });
            deflated(&big(&rows.collect::<Vec<u32>>()))
        }
    };
    let coding = |n: u32| (259, false, vec![n]);
    let predictor = |n: u32| (317, false, vec![n]);
    for (bits, bytes) in [
        (10, tiled(10, &[], packed(10))),
        (12, tiled(12, &[], packed(12))),
        (14, tiled(14, &[], packed(14))),
        (16, tiled(16, &[], big)),
        (16, tiled(16, &[coding(7)], lossless(1))),
        (12, tiled(12, &[coding(7)], lossless(2))),
        (14, tiled(14, &[coding(7)], lossless(4))),
        (16, tiled(16, &[coding(8)], |s| deflated(&big(s)))),
        (12, tiled(12, &[coding(8)], |s| deflated(&packed(12)(s)))),
        (16, tiled(16, &[coding(8), predictor(2)], differences(1))),
        (16, tiled(16, &[coding(8), predictor(34892)], differences(2))),
        (16, tiled(16, &[coding(8), predictor(34893)], differences(4))),
    ] {
        let dng = parse(&bytes).unwrap();
        let white = f64::from((1 << bits) - 1);
        assert_eq!((dng.raw.rows(), dng.raw.cols(), dng.raw.white_level()), (4, 5, white), "{bits}");
        for (i, v) in samples_of(&dng.raw).iter().enumerate() {
            assert_eq!(u32::from(*v), value(1 + i / 5, 1 + i % 5), "{bits} bits, sample {i}");
        }
        assert_eq!(dng.raw.channel_names(), ["R", "G", "B"]);
        assert_eq!((dng.notes, dng.default_crop), (vec![], None));
    }
}

#[test]
fn interleaved_rows_and_columns_are_put_back() {
    let big = |samples: &[u32]| samples.iter().flat_map(|v| (*v as u16).to_be_bytes()).collect::<Vec<u8>>();
    let factors = |down: u32, across: u32| [(50975, false, vec![down]), (52547, false, vec![across])];
    let dng = parse(&tiled(16, &factors(2, 3), big)).unwrap();
    let (stored_rows, stored_cols) = ([0, 3, 1, 4, 2], [0, 2, 4, 1, 3, 5]);
    for (i, v) in samples_of(&dng.raw).iter().enumerate() {
        assert_eq!(u32::from(*v), value(stored_rows[1 + i / 5], stored_cols[1 + i % 5]), "sample {i}");
    }
    for wrong in [factors(0, 1), factors(1, 7)] {
        let said = parse(&tiled(16, &wrong, big)).unwrap_err().to_string();
        assert!(said.contains("InterleaveFactor") && said.contains("1 to "), "{said}");
    }
}

#[test]
fn black_levels_that_differ_become_the_highest() {
    let black = [
        (50712, false, (0..1024).map(|v| 2 * v).collect::<Vec<u32>>()),
        (50713, false, vec![1, 2]),
        (50714, false, vec![7, 9]),
        (50715, false, vec![0, 0, 0, 1, 0]),
        (50716, false, vec![0, 2, 0, 0]),
        (50717, false, vec![2000]),
        (50719, false, vec![1, 2]),
        (50720, false, vec![4, 2]),
        (51009, false, vec![1, 2]),
    ];
    let dng =
        parse(&tiled(16, &black, |s| s.iter().flat_map(|v| (*v as u16).to_be_bytes()).collect())).unwrap();
    assert_eq!((dng.raw.black_level(), dng.raw.white_level()), (12.0, 2000.0));
    for (i, v) in samples_of(&dng.raw).iter().enumerate() {
        let (r, c) = (i / 5, i % 5);
        let black = [7, 9][c % 2] + u32::from(c == 3) + 2 * u32::from(r == 1);
        assert_eq!(u32::from(*v), 2 * value(1 + r, 1 + c) + 12 - black);
    }
    assert_eq!(dng.default_crop, Some(Crop { row: 2, col: 1, rows: 2, cols: 4 }));
    assert_eq!(dng.notes[0], "black levels from 7 to 12: samples are shifted to have 12");
    assert_eq!(dng.notes[1], "OpcodeList2 is damaged and ignored");
}

#[test]
fn floating_point_in_deflate_is_read() {
    // 1, 1.5, -2 and 0.25 of 16 bits, twice: their high bytes, then their low ones, as differences.
    let row = [0x3cu8, 0x3e, 0xc0, 0x34, 0, 0, 0, 0];
    let coded: Vec<u8> =
        row.iter().scan(0u8, |before, b| Some(b.wrapping_sub(std::mem::replace(before, *b)))).collect();
    let bytes = by_hand(
        &[
            (256, false, vec![4]),
            (257, false, vec![1]),
            (258, false, vec![16]),
            (259, false, vec![8]),
            (262, false, vec![34892]),
            (273, false, vec![1000]),
            (279, false, vec![deflated(&coded).len() as u32]),
            (317, false, vec![3]),
            (339, false, vec![3]),
            (50706, true, vec![1, 4, 0, 0]),
        ],
        &[deflated(&coded)],
    );
    assert_eq!(parse(&bytes).unwrap().raw.samples(), &RawSamples::Analog(vec![1.0, 1.5, -2.0, 0.25]));
}

#[test]
fn a_bomb_is_refused_before_memory_is_taken() {
    let huge = |coding: u32| {
        let fields = [
            (256, false, vec![1 << 16]),
            (257, false, vec![1 << 16]),
            (258, false, vec![16]),
            (259, false, vec![coding]),
            (262, false, vec![34892]),
            (273, false, vec![1000]),
            (279, false, vec![10]),
            (50706, true, vec![1, 4, 0, 0]),
        ];
        parse(&by_hand(&fields, &[vec![0; 10]])).unwrap_err().to_string()
    };
    for coding in [1, 7, 8, 52546] {
        assert!(huge(coding).contains("it is cut short or mislabelled"), "{}", huge(coding));
    }
}

proptest! {
    #[test]
    fn random_mosaics_read_back_equal(
        (rows, cols, cells) in (1usize..5, 1usize..5).prop_flat_map(|(r, c)| (Just(r), Just(c), prop::collection::vec(0u8..6, r * c))),
        (height, width) in (1usize..9, 1usize..9),
        black in -10.0..1000.0f64,
    ) {
        let mut used: Vec<u8> = cells.clone();
        used.sort_unstable();
        used.dedup();
        let cells = cells.iter().map(|c| used.iter().position(|u| u == c).unwrap() as u8).collect();
        let letters = ["R", "G", "B", "W", "IR", "G"];
        let channels: Vec<&str> = used.iter().map(|c| letters[usize::from(*c)]).collect();
        let mosaic = Sampling::Mosaic(Mosaic::new(rows, cols, cells).unwrap());
        let samples = RawSamples::Digital((0..height * width).map(|i| (i * 977) as u16).collect());
        let raw = RawImage::new(height, width, samples, mosaic, names(&channels), black, 65535.0).unwrap();
        bytes_of(&raw, &DngInfo::default());
    }

    #[test]
    fn mutated_files_are_read_or_refused(
        at in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8), cut in any::<prop::sample::Index>(), whole in any::<bool>(), jpeg in any::<bool>(),
    ) {
        let raw = digital(4, 6, Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap(), &["R", "G", "B"]);
        let compression = if jpeg { Compression::LosslessJpeg } else { Compression::None };
        let mut bytes = coded(&raw, &DngInfo::default(), compression);
        for (index, value) in at {
            let i = index.index(bytes.len());
            bytes[i] = value;
        }
        if !whole {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = parse(&bytes);
    }

    #[test]
    fn random_bytes_are_refused(rest in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(parse(&rest).is_err());
        prop_assert!(parse(&[b"II*\0\x08\0\0\0", &rest[..]].concat()).is_err());
    }
}

#[test]
fn a_picture_is_linear_colours_with_room_for_highlights() {
    // A dark pixel below zero by its noise, which becomes black, white, a saturated green, and a lamp.
    let colors = [[-0.01, -0.012, -0.008], [0.95, 1.0, 1.09], [0.1, 0.3, 0.05], [3.0, 2.5, 0.4]];
    let plane = |c: usize| colors.iter().map(move |v| v[c] as f32);
    let planes = Planes::new(2, 2, 3, (0..3).flat_map(plane).collect()).unwrap();
    let picture = Image::new(ColorSpace::Xyz, planes).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("linear.dng");
    let stated = DngPicture {
        white: [0.95, 1.0, 1.09],
        gain: 0.5,
        model: "rgbw".into(),
        orientation: Orientation::from_exif(6),
        default_crop: Some(Crop { row: 0, col: 1, rows: 2, cols: 1 }),
    };
    write_picture(&path, &picture, &stated).unwrap();
    let dng = read(&path, Limits::default()).unwrap();
    assert_eq!(*dng.raw.sampling(), Sampling::Full { channels: 3 });
    assert_eq!((dng.orientation, dng.default_crop), (stated.orientation, stated.default_crop));
    let matrix = dng.info.color_matrix.unwrap().camera_from_xyz;
    let matrix = [matrix[0], matrix[1], matrix[2]];
    let RawSamples::Digital(samples) = dng.raw.samples() else { panic!("digital numbers") };
    // What a developer makes of it: levels, then the baseline exposure, here half of the light, then the matrix.
    let gain = dng.info.baseline_exposure_stops.unwrap().exp2() / 0.5;
    let range = dng.raw.white_level() - dng.raw.black_level();
    let xyz_of = |rgb: [f64; 3]| apply(&inverse(&matrix).unwrap(), rgb);
    for (i, expected) in colors.iter().enumerate() {
        let rgb = [0, 1, 2].map(|c| gain * (f64::from(samples[4 * c + i]) - dng.raw.black_level()) / range);
        for (found, expected) in xyz_of(rgb).iter().zip(expected) {
            assert!((found - f64::max(*expected, 0.0)).abs() < 1e-4, "{i}: {found} {expected}");
        }
    }
    let neutral = dng.info.as_shot_neutral.unwrap();
    let white = xyz_of([neutral[0], neutral[1], neutral[2]]);
    assert!((white[0] / white[1] - 0.95).abs() < 1e-6 && (white[2] / white[1] - 1.09).abs() < 1e-6);
    // A picture for a display is no raw image.
    let shown = picture.converted(ColorSpace::Srgb).unwrap();
    let error = write_picture(&path, &shown, &stated).unwrap_err().to_string();
    assert!(error.contains("linear.dng") && error.contains("a picture in XYZ"), "{error}");
}
