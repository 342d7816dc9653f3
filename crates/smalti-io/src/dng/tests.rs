use std::path::Path;

use proptest::prelude::*;
use smalti::sensor::{Mosaic, RawSamples, Sampling};

use super::*;
use crate::{IoError, Limits};

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|s| (*s).to_owned()).collect()
}

fn digital(rows: usize, cols: usize, mosaic: Mosaic, channels: &[&str]) -> RawImage {
    let samples = (0..rows * cols).map(|i| (i * 31 % 4096) as u16).collect();
    let sampling = Sampling::Mosaic(mosaic);
    RawImage::new(rows, cols, RawSamples::Digital(samples), sampling, names(channels), 64.0, 4095.0).unwrap()
}

fn bytes_of(raw: &RawImage, info: &DngInfo) -> Vec<u8> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("f.dng");
    write(&path, raw, info).unwrap();
    assert_eq!(read(&path, Limits::default()).unwrap().raw, *raw);
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
    };
    let bayer = digital(6, 8, Mosaic::new(2, 2, vec![1, 0, 2, 1]).unwrap(), &["R", "G", "B"]);
    assert_eq!(parse(&bytes_of(&bayer, &info)).unwrap(), Dng { raw: bayer, info, notes: vec![] });

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
    let raw = digital(4, 4, Mosaic::new(2, 2, vec![0, 1, 2, 0]).unwrap(), &["G", "R", "B"]);
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
    use crate::tiff_tags as tags;
    assert!(patched(tags::COMPRESSION, 7).contains("Compression is 7 (lossless JPEG); expected 1"));
    assert!(patched(tags::CFA_LAYOUT, 2).contains("CFALayout is 2; expected 1"));
    assert!(patched(tags::BITS_PER_SAMPLE, 24).contains("BitsPerSample"));
    assert!(patched(tags::IMAGE_WIDTH, 60_000).contains("the raw image needs"));
    assert!(patched(tags::CFA_REPEAT_PATTERN_DIM, 3).contains("tile"));
}

/// A tiled, big-endian, 12-bit file with borders around the active area, by hand.
#[test]
fn tiles_borders_and_the_other_byte_order_are_read() {
    let (rows, cols, tile) = (5usize, 6usize, (4usize, 4usize));
    let value = |r: usize, c: usize| (100 * r + c) as u32;
    let mut data: Vec<(usize, Vec<u8>)> = Vec::new();
    for (tr, tc) in [(0, 0), (0, 4), (4, 0), (4, 4)] {
        let mut bits = Vec::new();
        for i in 0..tile.0 * tile.1 {
            let v = value(tr + i / tile.1, tc + i % tile.1);
            bits.extend((0..12).rev().map(|b| (v >> b & 1) as u8));
        }
        data.push((0, bits.chunks(8).map(|b| b.iter().fold(0, |a, x| a << 1 | x)).collect()));
    }
    let entries: &[(u16, u16, &[u32])] = &[
        (256, 4, &[cols as u32]),
        (257, 4, &[rows as u32]),
        (258, 4, &[12]),
        (262, 4, &[32803]),
        (322, 4, &[tile.1 as u32]),
        (323, 4, &[tile.0 as u32]),
        (324, 4, &[1000, 1100, 1200, 1300]),
        (33421, 4, &[2, 2]),
        (33422, 1, &[0x0001_0102]),
        (50706, 1, &[0x0104_0000]),
        (50714, 4, &[7]),
        (50829, 4, &[1, 1, 5, 6]),
    ];
    let mut out = b"MM\0*\0\0\0\x08".to_vec();
    out.extend((entries.len() as u16).to_be_bytes());
    let mut more = Vec::new();
    for (tag, kind, values) in entries {
        out.extend(tag.to_be_bytes());
        out.extend(kind.to_be_bytes());
        out.extend((if *kind == 1 { 4 } else { values.len() as u32 }).to_be_bytes());
        if values.len() == 1 {
            out.extend(values[0].to_be_bytes());
        } else {
            out.extend((500 + more.len() as u32).to_be_bytes());
            more.extend(values.iter().flat_map(|v| v.to_be_bytes()));
        }
    }
    out.resize(500, 0);
    out.extend(more);
    for (i, (_, tile)) in data.iter().enumerate() {
        out.resize(1000 + 100 * i, 0);
        out.extend(tile);
    }
    let raw = parse(&out).unwrap().raw;
    assert_eq!((raw.rows(), raw.cols(), raw.black_level(), raw.white_level()), (4, 5, 7.0, 4095.0));
    let RawSamples::Digital(v) = raw.samples() else { panic!("digital") };
    for (i, v) in v.iter().enumerate() {
        assert_eq!(u32::from(*v), value(1 + i / 5, 1 + i % 5));
    }
    assert_eq!(raw.channel_names(), ["R", "G", "B"]);
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
        at in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8), cut in any::<prop::sample::Index>(), whole in any::<bool>(),
    ) {
        let mut bytes = bytes_of(&digital(4, 6, Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap(), &["R", "G", "B"]), &DngInfo::default());
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
