use std::path::Path;

use proptest::prelude::*;
use smalti::numeric::Planes;
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

use super::*;
use crate::{Limits, Quantity};

fn file(quantity: Quantity, samples: Vec<f32>) -> SpectralFile {
    let grid = WavelengthGrid::new(400.0, 100.0, samples.len() / 6).unwrap();
    SpectralFile {
        name: "small".into(),
        cube: SpectralCube::new(grid, Planes::new(2, 3, grid.len(), samples).unwrap()).unwrap(),
        quantity,
        illuminant: Some(Spectrum::constant(grid, 0.5).unwrap()),
        distance_m: Some(1.0),
        horizontal_fov_deg: Some(2.0),
    }
}

fn bytes_of(file: &SpectralFile) -> Vec<u8> {
    let mut bytes = Vec::new();
    v5::write::write(&mut bytes, &content::of(file)).unwrap();
    bytes
}

fn ramp() -> Vec<f32> {
    (0..24).map(|i| i as f32).collect()
}

fn read(bytes: &[u8]) -> Result<SpectralFile, IoError> {
    from_bytes(bytes, Path::new("a.mat"), &ReadOptions::default())
}

fn error(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

/// Turns the data elements from `at` to `end` round, into the other byte order.
fn turn(bytes: &mut [u8], mut at: usize, end: usize) {
    while at + 8 <= end {
        let word = |b: &[u8]| u32::from_le_bytes(b[..4].try_into().unwrap());
        let first = word(&bytes[at..]);
        if first >> 16 != 0 {
            // A small element: its data are one number here.
            bytes[at..at + 4].reverse();
            bytes[at + 4..at + 8].reverse();
            at += 8;
            continue;
        }
        let len = word(&bytes[at + 4..]) as usize;
        bytes[at..at + 4].reverse();
        bytes[at + 4..at + 8].reverse();
        let (data, size) = (
            at + 8,
            match first {
                14 => 0,
                1 | 2 => 1,
                4 | 17 => 2,
                9 => 8,
                _ => 4,
            },
        );
        match size {
            0 => turn(bytes, data, data + len),
            _ => bytes[data..data + len].chunks_mut(size).for_each(<[u8]>::reverse),
        }
        at = data + len.next_multiple_of(8);
    }
}

#[test]
fn big_endian_files_are_read() {
    let file = file(Quantity::Photons, ramp());
    let mut bytes = bytes_of(&file);
    let end = bytes.len();
    turn(&mut bytes, 128, end);
    bytes[124..128].copy_from_slice(&[1, 0, b'M', b'I']);
    assert_eq!(read(&bytes).unwrap(), file);
}

/// The file with some bytes exchanged for others of the same length.
fn exchanged(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let at = bytes.windows(from.len()).position(|w| w == from).unwrap();
    let mut bytes = bytes.to_vec();
    bytes[at..at + to.len()].copy_from_slice(to);
    bytes
}

#[test]
fn samples_that_are_no_radiance_are_named() {
    let good = bytes_of(&file(Quantity::Reflectance, ramp()));
    let with = |value: f32| exchanged(&good, &13f32.to_le_bytes(), &value.to_le_bytes());
    let place = "channel 600 nm (band 3), row 0, column 1 (counted from 0) is";
    let expected = "expected a finite number, not negative";
    assert_eq!(error(&with(-2.0)), format!("a.mat: {place} -2; {expected}"));
    assert_eq!(error(&with(f32::NAN)), format!("a.mat: {place} NaN; expected a finite number"));
    let clamping = ReadOptions { clamp_negative: true, ..ReadOptions::default() };
    let clamped = |v| from_bytes(&with(v), Path::new("a.mat"), &clamping);
    assert_eq!(clamped(-2.0).unwrap().cube.planes().plane(2).unwrap()[1], 0.0);
    assert!(clamped(f32::NAN).is_err());
    // Minus zero is zero, to the bit.
    assert_eq!(read(&with(-0.0)).unwrap().cube.planes().plane(2).unwrap()[1].to_bits(), 0);
}

#[test]
fn absurd_dimensions_and_wavelengths_are_refused() {
    let good = bytes_of(&file(Quantity::Reflectance, ramp()));
    let dims = |d: [i32; 3]| {
        let from: Vec<u8> = [2i32, 3, 4].iter().flat_map(|d| d.to_le_bytes()).collect();
        error(&exchanged(&good, &from, &d.iter().flat_map(|d| d.to_le_bytes()).collect::<Vec<u8>>()))
    };
    assert!(dims([-2, 3, 4]).contains("a negative dimension"), "{}", dims([-2, 3, 4]));
    assert!(dims([i32::MAX; 3]).contains("96 bytes for an array of"), "{}", dims([i32::MAX; 3]));
    assert!(dims([0, i32::MAX, i32::MAX]).contains("96 bytes for an array of"));
    let wave = |nm: f64| error(&exchanged(&good, &500f64.to_le_bytes(), &nm.to_le_bytes()));
    assert!(wave(0.5).contains("bands is 0.5 to 700, which mixes units; expected wavelengths in nm"));
    assert!(wave(900.0).contains("not ascending"));
    assert!(wave(f64::NAN).contains("not finite"));
}

#[test]
fn what_is_no_mat_file_is_said() {
    assert!(error(b"").contains("expected a MAT-file of level 5 or version 7.3"));
    assert!(error(&[b'x'; 200]).contains("expected a MAT-file"));
    assert!(error(&[0; 200]).contains("version 4 of the MATLAB format"));
    let good = bytes_of(&file(Quantity::Photons, ramp()));
    // Only what is cut between its variables, or in the tag of the second, is whole.
    let whole = (0..good.len()).filter(|&len| read(&good[..len]).is_ok()).count();
    assert_eq!(whole, 8);
}

#[test]
fn a_bomb_is_not_unpacked() {
    // Half a gibibyte of zeros, a variable of which says that it is as large.
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    let zeros = vec![0u8; 1 << 20];
    std::io::Write::write_all(&mut encoder, &[14, 0, 0, 0, 0, 0, 0, 32]).unwrap();
    // The header of an array `cube` of 2²⁹ bytes.
    let good = bytes_of(&file(Quantity::Reflectance, ramp()));
    std::io::Write::write_all(&mut encoder, &good[136..184]).unwrap();
    for _ in 0..512 {
        std::io::Write::write_all(&mut encoder, &zeros).unwrap();
    }
    let stream = encoder.finish().unwrap();
    let mut bytes = good[..128].to_vec();
    bytes.extend_from_slice(&15u32.to_le_bytes());
    bytes.extend_from_slice(&(stream.len() as u32).to_le_bytes());
    bytes.extend_from_slice(&stream);
    let limits = Limits { decoded_bytes: 1 << 24, ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    let error = from_bytes(&bytes, Path::new("a.mat"), &options).unwrap_err();
    assert!(matches!(error, IoError::TooLarge { what: "a variable", .. }), "{error}");
}

#[test]
fn what_level_5_cannot_hold_is_refused() {
    let planes = Planes::zeros(1, 1 << 10, 1 << 10);
    let items: Vec<_> = (0..600).map(|_| ("x", content::Item::Cube(&planes))).collect();
    let bytes = v5::write::largest(&[("scene", content::Item::Struct(items))]);
    assert!(bytes > 600 << 22 && bytes < 601 << 22 && bytes > v5::write::LARGEST);
    assert!(v5::write::largest(&[("x", content::Item::Cube(&planes))]) < v5::write::LARGEST);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn scenes_read_back_equal(bits in prop::collection::vec(0u32..0x7f80_0000, 12)) {
        let file = file(Quantity::Photons, bits.into_iter().map(f32::from_bits).collect());
        prop_assert_eq!(read(&bytes_of(&file)).unwrap(), file);
    }

    #[test]
    fn mutated_files_are_read_or_refused(at in any::<prop::sample::Index>(), v in any::<u8>(), photons in any::<bool>()) {
        let mut bytes = bytes_of(&file([Quantity::Reflectance, Quantity::Photons][usize::from(photons)], ramp()));
        let i = at.index(bytes.len());
        bytes[i] = v;
        let _ = read(&bytes);
    }
}
