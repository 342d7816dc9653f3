use proptest::prelude::*;

use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;

use super::*;
use crate::Limits;
use crate::tiff::{Fields, Value, tags, write_header};

fn ramp(space: ColorSpace, rows: usize, cols: usize) -> Image {
    let n = rows * cols * 3;
    let data = (0..n).map(|i| ((i * 7919 % 65536) as f32) / 65535.0).collect();
    Image::new(space, Planes::new(rows, cols, 3, data).unwrap()).unwrap()
}

fn largest_difference(a: &Image, b: &Image) -> f32 {
    a.planes().data().iter().zip(b.planes().data()).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max)
}

#[test]
fn what_is_written_reads_back_with_its_space() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["a.png", "a.tif"] {
        for space in [ColorSpace::Srgb, ColorSpace::DisplayP3] {
            for (depth, max) in [(Depth::Eight, 255.0), (Depth::Sixteen, 65535.0)] {
                let path = dir.path().join(name);
                let image = ramp(space, 5, 7);
                write(&path, &image, depth).unwrap();
                let back = read(&path, &ReadOptions::default()).unwrap();
                assert_eq!(back.image.space(), space, "{name}");
                assert!(back.notes.is_empty(), "{:?}", back.notes);
                // Rounding to the nearest level, and f32.
                assert!(largest_difference(&image, &back.image) < 0.5001 / max, "{name} {depth:?}");
            }
        }
    }
}

#[test]
fn only_encoded_pictures_are_written() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.png");
    assert!(write(&path, &ramp(ColorSpace::LinearSrgb, 2, 2), Depth::Eight).is_err());
    assert!(write(&dir.path().join("a.gif"), &ramp(ColorSpace::Srgb, 2, 2), Depth::Eight).is_err());
    let nan =
        Image::new(ColorSpace::Srgb, Planes::new(1, 2, 3, vec![0.0, f32::NAN, 0.0, 0.0, 0.0, 0.0]).unwrap());
    let error = write(&path, &nan.unwrap(), Depth::Eight).unwrap_err().to_string();
    assert!(error.contains("channel R, row 0, column 1"), "{error}");
    assert!(std::fs::read_dir(dir.path()).unwrap().next().is_none());
}

#[test]
fn a_png_gamma_is_undone() {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(::png::ColorType::Grayscale);
    encoder.set_source_gamma(::png::ScaledFloat::new(0.5));
    encoder.write_header().unwrap().write_image_data(&[128]).unwrap();
    let p = from_bytes(&bytes, Path::new("f.png"), &ReadOptions::default()).unwrap();
    assert_eq!(p.image.space(), ColorSpace::LinearSrgb);
    assert!((p.image.planes().plane(2).unwrap()[0] - (128.0f32 / 255.0).powi(2)).abs() < 1e-6);
}

#[test]
fn grey_tiff_is_read_whichever_number_is_white_and_alpha_is_ignored() {
    let read = |photometric: u16, samples: u16, data: &[u8]| {
        let fields = Fields::from([
            (tags::IMAGE_WIDTH, Value::Long(vec![2])),
            (tags::IMAGE_LENGTH, Value::Long(vec![1])),
            (tags::BITS_PER_SAMPLE, Value::Short(vec![8; usize::from(samples)])),
            (tags::PHOTOMETRIC, Value::Short(vec![photometric])),
            (tags::SAMPLES_PER_PIXEL, Value::Short(vec![samples])),
        ]);
        let mut bytes = Vec::new();
        write_header(&mut bytes, fields, 1, data.len() as u64).unwrap();
        bytes.extend(data);
        let picture = from_bytes(&bytes, Path::new("f.tif"), &ReadOptions::default());
        picture.map(|p| (p.image.planes().plane(2).unwrap().to_vec(), p.notes)).map_err(|e| e.to_string())
    };
    assert_eq!(read(1, 1, &[0, 51]), Ok((vec![0.0, 0.2], Vec::new())));
    assert_eq!(read(0, 1, &[255, 204]), Ok((vec![0.0, 0.2], Vec::new())));
    let note = vec!["the alpha channel is ignored".to_owned()];
    assert_eq!(read(1, 2, &[0, 9, 51, 9]), Ok((vec![0.0, 0.2], note)));
    let palette = read(3, 1, &[0, 51]).unwrap_err();
    assert_eq!(palette, "f.tif: PhotometricInterpretation is 3; expected 0 or 1 (grey) or 2 (RGB)");
}

/// A PNG that declares that many rows and columns in a few bytes.
fn bomb(side: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    ::png::Encoder::new(&mut bytes, side, side).write_header().unwrap();
    bytes
}

#[test]
fn a_bomb_is_refused_before_memory_is_taken() {
    let error = from_bytes(&bomb(60_000), Path::new("f.png"), &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, IoError::Truncated { .. }), "{error}");
    let small = Limits { decoded_bytes: 1 << 10, ..Limits::default() };
    let options = ReadOptions { limits: small, ..ReadOptions::default() };
    assert!(matches!(from_bytes(&bomb(60_000), Path::new("f.png"), &options), Err(IoError::TooLarge { .. })));
    assert!(from_bytes(&bomb(i32::MAX as u32), Path::new("f.png"), &ReadOptions::default()).is_err());
}

fn samples() -> Vec<Vec<u8>> {
    let dir = tempfile::tempdir().unwrap();
    ["a.png", "b.tif"]
        .iter()
        .map(|name| {
            let path = dir.path().join(name);
            write(&path, &ramp(ColorSpace::DisplayP3, 9, 6), Depth::Sixteen).unwrap();
            std::fs::read(path).unwrap()
        })
        .collect()
}

proptest! {
    #[test]
    fn mutated_files_are_read_or_refused(which in 0usize..2, at in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), cut in any::<prop::sample::Index>(), whole in any::<bool>()) {
        let mut bytes = samples().swap_remove(which);
        for (index, value) in at {
            let i = index.index(bytes.len());
            bytes[i] = value;
        }
        if !whole {
            let n = cut.index(bytes.len());
            bytes.truncate(n);
        }
        let _ = from_bytes(&bytes, Path::new("f"), &ReadOptions::default());
    }

    #[test]
    fn random_bytes_are_refused(magic in prop::sample::select(vec![&b"\x89PNG\r\n\x1a\n"[..], b"II*\0\x08\0\0\0", b"MM\0*\0\0\0\x08", b"\xff\xd8\xff\xe0", b"\x76\x2f\x31\x01\x02\0\0\0", b""]), rest in prop::collection::vec(any::<u8>(), 0..300)) {
        let bytes = [magic, &rest].concat();
        prop_assert!(from_bytes(&bytes, Path::new("f"), &ReadOptions::default()).is_err());
    }
}
