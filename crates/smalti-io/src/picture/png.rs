//! Reading PNG (W3C PNG, third edition).

use std::io::Cursor;
use std::path::Path;

use png::{BitDepth, ColorType, Decoder, Info, Limits, Transformations};
use smalti::color::ColorSpace;

use super::{PROFILE_NOTE, Picture, alpha_note, from_interleaved};
use crate::ReadOptions;
use crate::file::guarded;
use crate::{IoError, icc};

pub(super) fn decode(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    let Unpacked { info, size: (rows, cols), channels, samples } = unpack(bytes, path, options)?;
    let (mut samples, bits) = samples.to_f32();
    let mut notes = Vec::new();
    alpha_note(&mut notes, channels);
    let (space, gamma) = space(&info, &mut notes);
    if let Some(gamma) = gamma {
        let exponent = 1.0 / gamma;
        samples.iter_mut().for_each(|v| *v = v.powf(exponent));
    }
    Ok(Picture { image: from_interleaved(path, (rows, cols, channels), &samples, space)?, bits, notes })
}

/// The samples of a picture, pixel by pixel.
struct Unpacked {
    info: Info<'static>,
    /// Rows and columns.
    size: (usize, usize),
    /// 1 to 4, of which the second of two and the fourth are alpha.
    channels: usize,
    samples: Samples,
}

/// Samples as they are stored.
enum Samples {
    Eight(Vec<u8>),
    /// Big-endian.
    Sixteen(Vec<u8>),
}

impl Samples {
    /// The largest number is 1; and the bits of a sample.
    fn to_f32(&self) -> (Vec<f32>, u8) {
        match self {
            Self::Sixteen(bytes) => (
                bytes.as_chunks().0.iter().map(|b| f32::from(u16::from_be_bytes(*b)) / 65535.0).collect(),
                16,
            ),
            Self::Eight(bytes) => (bytes.iter().map(|b| f32::from(*b) / 255.0).collect(), 8),
        }
    }
}

fn unpack(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Unpacked, IoError> {
    let wrong = |e: png::DecodingError| IoError::Decode {
        path: path.to_owned(),
        format: "PNG",
        message: e.to_string(),
    };
    guarded(path, "PNG", || {
        let limit = usize::try_from(options.limits.decoded_bytes).unwrap_or(usize::MAX);
        let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: limit });
        decoder.set_transformations(Transformations::EXPAND);
        decoder.set_ignore_text_chunk(true);
        let header = decoder.read_header_info().map_err(wrong)?;
        let (rows, pixels) =
            (u64::from(header.height), u64::from(header.width).saturating_mul(u64::from(header.height)));
        let raw = (header.raw_row_length_from_width(header.width) as u64).saturating_mul(rows);
        options.limits.check(path, "the picture", raw, bytes.len() as u64)?;
        let mut reader = decoder.read_info().map_err(wrong)?;
        let size = reader.output_buffer_size().unwrap_or(usize::MAX);
        // Three planes of f32 beside what is unpacked.
        let memory = pixels.saturating_mul(12).saturating_add(size as u64);
        let allowed = options.limits.decoded_bytes;
        if memory > allowed {
            let path = path.to_owned();
            return Err(IoError::TooLarge { path, what: "the picture", bytes: memory, limit: allowed });
        }
        let mut buffer = vec![0; size];
        let frame = reader.next_frame(&mut buffer).map_err(wrong)?;
        buffer.truncate(frame.buffer_size());
        let channels = match frame.color_type {
            ColorType::Grayscale => 1,
            ColorType::GrayscaleAlpha => 2,
            ColorType::Rgb | ColorType::Indexed => 3,
            ColorType::Rgba => 4,
        };
        let samples = match frame.bit_depth {
            BitDepth::Sixteen => Samples::Sixteen(buffer),
            _ => Samples::Eight(buffer),
        };
        let size = (frame.height as usize, frame.width as usize);
        Ok(Unpacked { info: reader.info().clone(), size, channels, samples })
    })
}

/// The colour space and, where it must be undone, the encoding exponent. cICP goes before iCCP, that before sRGB,
/// that before gAMA (PNG section 4.3).
fn space(info: &Info<'_>, notes: &mut Vec<String>) -> (ColorSpace, Option<f32>) {
    // Code points of ITU-T H.273: primaries 1 (sRGB) and 12 (Display P3), transfer 13 (sRGB) and 8 (linear).
    if let Some(c) = &info.coding_independent_code_points {
        match (c.color_primaries, c.transfer_function) {
            (1, 13) => return (ColorSpace::Srgb, None),
            (1, 8) => return (ColorSpace::LinearSrgb, None),
            (12, 13) => return (ColorSpace::DisplayP3, None),
            (12, 8) => return (ColorSpace::LinearDisplayP3, None),
            (p, t) => notes.push(format!("cICP primaries {p}, transfer {t} are ignored: taken as sRGB")),
        }
        return (ColorSpace::Srgb, None);
    }
    if let Some(profile) = &info.icc_profile {
        for space in [ColorSpace::Srgb, ColorSpace::DisplayP3] {
            if icc::profile(space).is_some_and(|p| p.as_slice() == profile.as_ref()) {
                return (space, None);
            }
        }
        notes.push(PROFILE_NOTE.to_owned());
        return (ColorSpace::Srgb, None);
    }
    match info.gama_chunk.map(png::ScaledFloat::into_value) {
        // 1/2.2 is how programs before the sRGB chunk said sRGB.
        Some(gamma) if info.srgb.is_none() && gamma > 0.0 && (gamma - 1.0 / 2.2).abs() > 0.005 => {
            (ColorSpace::LinearSrgb, Some(gamma).filter(|g| *g != 1.0))
        }
        _ => (ColorSpace::Srgb, None),
    }
}
