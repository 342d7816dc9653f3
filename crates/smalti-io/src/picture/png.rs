//! Reading PNG (W3C PNG, third edition).

use std::io::Cursor;
use std::path::Path;

use png::{BitDepth, Decoder, Info, Limits, Transformations};
use smalti::color::ColorSpace;

use super::decoded::{PROFILE_NOTE, Picture, alpha_note, from_interleaved};
use crate::file::guarded;
use crate::{IoError, Orientation, ReadOptions, icc};

pub(super) fn decode(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    let wrong = |e: png::DecodingError| IoError::decode(path, "PNG", e);
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
        // Three planes of f32 beside the decoded samples.
        let memory = pixels.saturating_mul(12).saturating_add(size as u64);
        options.limits.check_memory(path, "the picture", memory)?;
        let mut buffer = vec![0; size];
        let frame = reader.next_frame(&mut buffer).map_err(wrong)?;
        buffer.truncate(frame.buffer_size());
        let (bits, mut samples): (u8, Vec<f32>) = match frame.bit_depth {
            BitDepth::Sixteen => {
                let sixteen = |b: &[u8; 2]| f32::from(u16::from_be_bytes(*b)) / 65535.0;
                (16, buffer.as_chunks().0.iter().map(sixteen).collect())
            }
            _ => (8, buffer.iter().map(|b| f32::from(*b) / 255.0).collect()),
        };
        // Palettes are expanded: 1 to 4, of which the second of two and the fourth are alpha.
        let channels = frame.color_type.samples();
        let mut notes = Vec::new();
        alpha_note(&mut notes, channels == 2 || channels == 4);
        let (space, gamma) = space(reader.info(), &mut notes);
        if let Some(gamma) = gamma {
            let exponent = 1.0 / gamma;
            samples.iter_mut().for_each(|v| *v = v.powf(exponent));
        }
        let size = (frame.height as usize, frame.width as usize, channels);
        let image = from_interleaved(path, size, &samples, space)?;
        Ok(Picture { image, bits, orientation: Orientation::default(), notes })
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
            if icc::profile(space).is_some_and(|p| p == profile.as_ref()) {
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
