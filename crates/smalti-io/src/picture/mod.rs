//! RGB pictures: PNG, TIFF, JPEG and OpenEXR in, PNG and TIFF out.

mod encode;
pub(crate) mod grey;
mod jpeg;
mod png;
mod tiff;

use std::path::Path;

use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;

pub use encode::{Depth, write, write_png, write_tiff};

use crate::ReadOptions;
use crate::error::At;
use crate::exr::rgb_from_bytes;
use crate::file::{Negative, sample};
use crate::{IoError, file};

/// A picture and what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// The picture; integers are scaled so that the largest is 1.
    ///
    /// | in the file | space |
    /// |---|---|
    /// | integers (PNG, TIFF, JPEG) | [`ColorSpace::Srgb`] |
    /// | PNG with `cICP` or profile of Display P3 as written here | [`ColorSpace::DisplayP3`] |
    /// | PNG with `gAMA` other than 1/2.2 and no `sRGB` | [`ColorSpace::LinearSrgb`], the gamma undone |
    /// | floating point (TIFF, OpenEXR) | [`ColorSpace::LinearSrgb`] |
    pub image: Image,
    /// Bits per sample in the file.
    pub bits: u8,
    /// What was left aside: alpha channels, profiles of other spaces.
    pub notes: Vec<String>,
}

/// A picture of any of the formats, told apart by its first bytes. Grey becomes three equal planes; alpha is
/// ignored (colours are taken as they are stored, not multiplied); profiles are ignored, with a note, unless they
/// are those written here.
///
/// # Errors
/// When the file cannot be read, is none of the formats or malformed, has a NaN or infinite value, or is larger
/// than the limits. Negative values, the colours outside the gamut of sRGB, are kept unless
/// [`ReadOptions::clamp_negative`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    from_bytes(&file::read(path, options.limits.file_bytes)?, path, options)
}

/// As [`read`], from memory; `path` is only named.
///
/// # Errors
/// As [`read`].
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png::decode(bytes, path, options),
        [0xff, 0xd8, 0xff, ..] => jpeg::decode(bytes, path, options),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => tiff::decode(bytes, path, options),
        [0x76, 0x2f, 0x31, 0x01, ..] => rgb_from_bytes(bytes, path, options),
        _ => Err(IoError::UnknownFormat {
            path: path.to_owned(),
            expected: "a PNG, TIFF, JPEG or OpenEXR file (by its first bytes)",
        }),
    }
}

/// Three planes from interleaved samples of 1 (grey), 2 (grey, alpha), 3 or 4 (alpha) channels.
fn from_interleaved(
    path: &Path,
    (rows, cols, channels): (usize, usize, usize),
    samples: &[f32],
    space: ColorSpace,
) -> Result<Image, IoError> {
    let pixels = rows * cols;
    if channels == 0 || samples.len() != pixels.saturating_mul(channels) {
        let what = "the picture";
        let (need, have) = (pixels.saturating_mul(channels) as u64, samples.len() as u64);
        return Err(IoError::Truncated { path: path.to_owned(), what, need, have });
    }
    let mut data = Vec::with_capacity(3 * pixels);
    for c in 0..3 {
        let c = if channels < 3 { 0 } else { c };
        data.extend(samples.iter().skip(c).step_by(channels));
    }
    let planes = Planes::new(rows, cols, 3, data).at(path)?;
    Image::new(space, planes).at(path)
}

/// Refuses NaN and infinite values of floating-point pictures.
fn check_float(
    path: &Path,
    (cols, channels): (usize, usize),
    samples: &mut [f32],
    clamp_negative: bool,
) -> Result<(), IoError> {
    let negative = if clamp_negative { Negative::Clamp } else { Negative::Keep };
    for (i, v) in samples.iter_mut().enumerate() {
        let pixel = i / channels.max(1);
        *v = sample(*v, negative).map_err(|expected| IoError::Pixel {
            path: path.to_owned(),
            channel: (i % channels.max(1)).to_string(),
            row: pixel / cols.max(1),
            col: pixel % cols.max(1),
            value: f64::from(*v),
            expected,
        })?;
    }
    Ok(())
}

fn alpha_note(notes: &mut Vec<String>, channels: usize) {
    if channels == 2 || channels == 4 {
        notes.push("the alpha channel is ignored".to_owned());
    }
}

const PROFILE_NOTE: &str = "the embedded colour profile is ignored: the picture is taken as sRGB";

#[cfg(test)]
mod tests;
