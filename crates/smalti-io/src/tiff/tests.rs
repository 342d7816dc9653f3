use std::path::Path;

use super::tags::{BITS_PER_SAMPLE, BLACK_LEVEL, COLOR_MATRIX_1, IMAGE_WIDTH, MAKE, STRIP_OFFSETS};
use super::*;

/// Tags of the images of a file, or errors.
fn images(bytes: &[u8], sub_images: bool) -> Vec<Result<Directory, String>> {
    let images = Images::new(&bytes, Path::new("f.tif"), sub_images).unwrap();
    images.map(|i| i.map_err(|e| e.to_string())).collect()
}

#[test]
fn fields_read_back() {
    let fields = Fields::from([
        (IMAGE_WIDTH, Value::Long(vec![7])),
        (MAKE, Value::Ascii("Smalti".into())),
        (BITS_PER_SAMPLE, Value::Short(vec![8, 8, 8])),
        (BLACK_LEVEL, Value::Rational(vec![[1, 4]])),
        (COLOR_MATRIX_1, Value::SignedRational(vec![[-1, 2], [3, 1]])),
    ]);
    let mut out = Vec::new();
    write_header(&mut out, fields, 5, 3).unwrap();
    out.extend([1, 2, 3]);
    let images = images(&out, true);
    let [Ok(i)] = images.as_slice() else { panic!("{images:?}") };
    assert_eq!(i.size(IMAGE_WIDTH), Some(7));
    assert_eq!(i.text(MAKE).unwrap(), "Smalti");
    assert_eq!(i.numbers(BITS_PER_SAMPLE).unwrap(), [8.0; 3]);
    assert_eq!(i.number(BLACK_LEVEL), Some(0.25));
    assert_eq!(i.numbers(COLOR_MATRIX_1).unwrap(), [-0.5, 3.0]);
    assert_eq!(i.integers(COLOR_MATRIX_1), None);
    let at = i.size(STRIP_OFFSETS).unwrap();
    assert_eq!(&out[at..], [1, 2, 3]);
}

#[test]
fn a_chain_that_repeats_itself_ends() {
    let mut bytes = b"II*\0\x08\0\0\0\0\0".to_vec();
    bytes.extend(8u32.to_le_bytes());
    assert_eq!(images(&bytes, false).len(), 1);
}

#[test]
fn sub_images_come_before_the_next_image_and_both_widths_are_read() {
    for wide in [false, true] {
        let head =
            if wide { b"II\x2b\0\x08\0\0\0\x10\0\0\0\0\0\0\0".to_vec() } else { b"II*\0\x08\0\0\0".to_vec() };
        let image = |width: u32, at: usize, last: bool, more: &[(u16, Value)]| {
            let mut fields = Fields::from([(IMAGE_WIDTH, Value::Long(vec![width]))]);
            fields.extend(more.iter().cloned());
            directory(&fields, at as u64, (wide, 8), last)
        };
        let len = image(1, 0, false, &[(tags::SUB_IFDS, Value::Places(vec![0]))]).len();
        let next = head.len() + len;
        let sub = next + image(2, 0, true, &[]).len();
        let first = image(1, head.len(), false, &[(tags::SUB_IFDS, Value::Places(vec![sub as u64]))]);
        let bytes = [head, first, image(2, next, true, &[]), image(3, sub, true, &[])].concat();
        let widths = |sub_images: bool| -> Vec<usize> {
            images(&bytes, sub_images)
                .iter()
                .map(|i| i.as_ref().unwrap().size(IMAGE_WIDTH).unwrap())
                .collect()
        };
        assert_eq!((widths(true), widths(false)), (vec![1, 3, 2], vec![1, 2]));
    }
}

#[test]
fn what_is_cut_short_is_named() {
    let fields = Fields::from([(BITS_PER_SAMPLE, Value::Short(vec![8, 8, 8]))]);
    let bytes = [b"II*\0\x08\0\0\0".to_vec(), directory(&fields, 8, (false, 2), true)].concat();
    let error = |end: usize| images(&bytes[..end], false).pop().unwrap().unwrap_err();
    assert_eq!(
        error(bytes.len() - 1),
        "f.tif: not a valid TIFF file: tag 258 of image 1 reaches beyond the end of the file"
    );
    assert_eq!(error(12), "f.tif: not a valid TIFF file: the directory of image 1 is cut short");
}
