//! RGB pictures: PNG, TIFF, JPEG and OpenEXR in, PNG and TIFF out.

mod decoded;
mod encode;
pub(crate) mod grey;
mod jpeg;
mod png;
mod tiff;

use std::path::Path;

pub use decoded::Picture;
pub use encode::{Depth, png_bytes, write, write_png, write_tiff};

use crate::exr::rgb_from_bytes;
use crate::{IoError, ReadOptions, file};

/// A picture of any of the formats, which its first bytes identify. Grey becomes three equal planes; alpha is
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
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png::decode(bytes, path, options),
        [0xff, 0xd8, 0xff, ..] => jpeg::decode(bytes, path, options),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => tiff::decode(bytes, path, options),
        [0x76, 0x2f, 0x31, 0x01, ..] => rgb_from_bytes(bytes, path, options),
        _ => Err(IoError::unknown(path, "a PNG, TIFF, JPEG or OpenEXR file (by its first bytes)")),
    }
}

/// As [`from_bytes`], for a JPEG file.
pub(crate) fn from_jpeg(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    jpeg::decode(bytes, path, options)
}

#[cfg(test)]
mod tests;
