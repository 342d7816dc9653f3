//! Reading JPEG (ITU-T T.81), baseline and progressive.

use std::io::Cursor;
use std::path::Path;

use smalti::color::ColorSpace;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace as Coded;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::decoded::{PROFILE_NOTE, Picture, from_interleaved};
use crate::file::guarded;
use crate::tiff::{Images, tags};
use crate::{IoError, Orientation, ReadOptions};

pub(super) fn decode(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    let wrong = |message: String| IoError::decode(path, "JPEG", message);
    guarded(path, "JPEG", || {
        let settings = DecoderOptions::default()
            .jpeg_set_out_colorspace(Coded::RGB)
            .set_strict_mode(true)
            .set_max_width(usize::from(u16::MAX))
            .set_max_height(usize::from(u16::MAX));
        let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), settings);
        decoder.decode_headers().map_err(|e| wrong(e.to_string()))?;
        let info = decoder.info().ok_or_else(|| wrong("no header".into()))?;
        let (rows, cols) = (usize::from(info.height), usize::from(info.width));
        let pixels = rows as u64 * cols as u64;
        options.limits.check(path, "the picture", pixels.saturating_mul(3), bytes.len() as u64)?;
        options.limits.check_memory(path, "the picture", pixels.saturating_mul(3 + 12 + 12))?;
        let buffer = decoder.decode().map_err(|e| wrong(e.to_string()))?;
        let mut notes = Vec::new();
        if decoder.icc_profile().is_some() {
            notes.push(PROFILE_NOTE.to_owned());
        }
        let samples: Vec<f32> = buffer.iter().map(|&b| f32::from(b) / 255.0).collect();
        let image = from_interleaved(path, (rows, cols, 3), &samples, ColorSpace::Srgb)?;
        Ok(Picture { image, bits: 8, orientation: orientation(decoder.exif(), path), notes })
    })
}

/// That of Exif, which is a TIFF file in a segment of its own; as stored where there is none or it is damaged.
fn orientation(exif: Option<&Vec<u8>>, path: &Path) -> Orientation {
    let images = exif.and_then(|exif| Images::new(exif, path, false).ok());
    let first = images.and_then(|mut images| images.next()?.ok());
    let code = first.and_then(|d| d.integer(tags::ORIENTATION));
    code.map_or_else(Orientation::default, Orientation::from_exif)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_orientation_is_that_of_exif() {
        let exif = |code: u8| {
            [b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".as_slice(), &[code, 0, 0, 0, 0, 0, 0, 0]]
                .concat()
        };
        let of = |exif: Option<&Vec<u8>>| orientation(exif, Path::new("f.jpg")).exif();
        assert_eq!([of(Some(&exif(6))), of(Some(&exif(3))), of(Some(&exif(0))), of(None)], [6, 3, 1, 1]);
        for end in 0..exif(6).len() - 4 {
            assert_eq!(of(Some(&exif(6)[..end].to_vec())), 1);
        }
    }
}
