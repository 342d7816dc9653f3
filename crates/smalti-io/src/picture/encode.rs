//! Writing PNG and TIFF.

use std::io::{self, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};
use smalti::color::{ColorSpace, Image, ImageError};

use crate::error::At;
use crate::tiff::{Fields, Value, tags, write_header};
use crate::{IoError, icc, write};

/// Bits per sample of a picture that is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Depth {
    /// 8 bits.
    #[default]
    Eight,
    /// 16 bits.
    Sixteen,
}

/// Writes a picture in the format its name asks for: `.png`, `.tif` or `.tiff`.
///
/// # Errors
/// As [`write_png`]; when the name ends otherwise.
pub fn write(path: &Path, image: &Image, depth: Depth) -> Result<(), IoError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "png" => write_png(path, image, depth),
        "tif" | "tiff" => write_tiff(path, image, depth),
        _ => Err(IoError::unknown(path, "a name that ends in .png, .tif or .tiff")),
    }
}

/// Writes an encoded picture ([`ColorSpace::Srgb`] or [`ColorSpace::DisplayP3`]) as PNG that states its colour
/// space: `sRGB`, or `cICP` and a profile. Values are rounded; those outside 0–1 are clipped.
///
/// # Errors
/// When the image is in another space or empty, has a NaN, or the file cannot be written.
pub fn write_png(path: &Path, image: &Image, depth: Depth) -> Result<(), IoError> {
    let samples = quantised(path, image, depth, u16::to_be_bytes)?;
    write::atomic(path, |out| put_png(out, &samples, path, image, depth))
}

/// The bytes that [`write_png`] writes; `path` is only named in errors.
///
/// # Errors
/// As [`write_png`].
pub fn png_bytes(image: &Image, depth: Depth, path: &Path) -> Result<Vec<u8>, IoError> {
    let samples = quantised(path, image, depth, u16::to_be_bytes)?;
    let mut bytes = Vec::new();
    put_png(&mut bytes, &samples, path, image, depth)?;
    Ok(bytes)
}

fn put_png(
    out: impl io::Write,
    samples: &[u8],
    path: &Path,
    image: &Image,
    depth: Depth,
) -> Result<(), IoError> {
    let wrong = |e: png::EncodingError| match e {
        png::EncodingError::IoError(source) => IoError::writing(path)(source),
        other => IoError::writing(path)(io::Error::other(other.to_string())),
    };
    let (cols, rows) = size(path, image)?;
    let mut info = png::Info::with_size(cols, rows);
    info.color_type = ColorType::Rgb;
    info.bit_depth = if depth == Depth::Eight { BitDepth::Eight } else { BitDepth::Sixteen };
    let p3 = image.space() == ColorSpace::DisplayP3;
    if p3 {
        info.icc_profile = icc::profile(image.space()).map(Into::into);
    }
    let mut encoder = Encoder::with_info(out, info).map_err(wrong)?;
    if !p3 {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    }
    let mut writer = encoder.write_header().map_err(wrong)?;
    if p3 {
        // Primaries 12, transfer 13 (sRGB), no matrix, full range: ITU-T H.273.
        writer.write_chunk(png::chunk::ChunkType(*b"cICP"), &[12, 13, 0, 1]).map_err(wrong)?;
    }
    writer.write_image_data(samples).map_err(wrong)?;
    writer.finish().map_err(wrong)
}

/// As [`write_png`], as uncompressed TIFF with an embedded profile.
pub fn write_tiff(path: &Path, image: &Image, depth: Depth) -> Result<(), IoError> {
    let samples = quantised(path, image, depth, u16::to_le_bytes)?;
    let (cols, rows) = size(path, image)?;
    let bits = if depth == Depth::Eight { 8 } else { 16 };
    let mut fields = Fields::from([
        (tags::IMAGE_WIDTH, Value::Long(vec![cols])),
        (tags::IMAGE_LENGTH, Value::Long(vec![rows])),
        (tags::BITS_PER_SAMPLE, Value::Short(vec![bits; 3])),
        (tags::COMPRESSION, Value::Short(vec![1])),
        (tags::PHOTOMETRIC, Value::Short(vec![2])),
        (tags::SAMPLES_PER_PIXEL, Value::Short(vec![3])),
        (tags::PLANAR_CONFIGURATION, Value::Short(vec![1])),
    ]);
    if let Some(profile) = icc::profile(image.space()) {
        fields.insert(tags::ICC_PROFILE, Value::Undefined(profile.to_vec()));
    }
    write::stream(path, |out| {
        write_header(out, fields, rows, samples.len() as u64)?;
        out.write_all(&samples)
    })
}

fn size(path: &Path, image: &Image) -> Result<(u32, u32), IoError> {
    match (u32::try_from(image.cols()), u32::try_from(image.rows())) {
        (Ok(cols), Ok(rows)) if cols > 0 && rows > 0 => Ok((cols, rows)),
        _ => {
            let found = format!("{} × {} pixels", image.rows(), image.cols());
            Err(IoError::field(path, "the picture", found, "between 1 and 2³² rows and columns"))
        }
    }
}

/// Interleaved samples in the bytes of the file.
fn quantised(
    path: &Path,
    image: &Image,
    depth: Depth,
    bytes: fn(u16) -> [u8; 2],
) -> Result<Vec<u8>, IoError> {
    if !matches!(image.space(), ColorSpace::Srgb | ColorSpace::DisplayP3) {
        return Err(ImageError::Space { expected: ColorSpace::Srgb, got: image.space() }).at(path);
    }
    let [r, g, b] = image.channels();
    for (name, plane) in [("R", r), ("G", g), ("B", b)] {
        if let Some(i) = plane.iter().position(|v| v.is_nan()) {
            let place = [i / image.cols(), i % image.cols()];
            return Err(IoError::pixel(path, name, place, f32::NAN, "a number"));
        }
    }
    let pixels = r.iter().zip(g).zip(b).flat_map(|((r, g), b)| [*r, *g, *b]);
    let level = |v: f32, max: f32| (v.clamp(0.0, 1.0) * max).round();
    Ok(match depth {
        Depth::Eight => pixels.map(|v| level(v, 255.0) as u8).collect(),
        Depth::Sixteen => pixels.flat_map(|v| bytes(level(v, 65535.0) as u16)).collect(),
    })
}
