//! Reading TIFF 6.0 and BigTIFF: grey and RGB of 8 or 16 bits or floating point.

use std::io::Cursor;
use std::path::Path;

use smalti::color::ColorSpace;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::{PROFILE_NOTE, Picture, alpha_note, check_float, from_interleaved};
use crate::ReadOptions;
use crate::file::guarded;
use crate::{IoError, icc, tiff_tags};

pub(super) fn decode(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    let wrong = |e: tiff::TiffError| IoError::Decode {
        path: path.to_owned(),
        format: "TIFF",
        message: e.to_string(),
    };
    guarded(path, "TIFF", || {
        let file_len = bytes.len() as u64;
        let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(wrong)?;
        let (cols, rows) = decoder.dimensions().map_err(wrong)?;
        let color = decoder.colortype().map_err(wrong)?;
        let channels = match color {
            ColorType::Gray(_) => 1,
            ColorType::GrayA(_) => 2,
            ColorType::RGB(_) => 3,
            ColorType::RGBA(_) => 4,
            other => {
                return Err(IoError::field(path, "the colour type", format!("{other:?}"), "grey or RGB"));
            }
        };
        let bits = color.bit_depth();
        let samples = u64::from(rows).saturating_mul(u64::from(cols)).saturating_mul(channels as u64);
        let raw = samples.saturating_mul(u64::from(bits).div_ceil(8));
        options.limits.check(path, "the picture", raw, file_len)?;
        let memory = raw.saturating_add(samples.saturating_mul(4 + 4));
        if memory > options.limits.decoded_bytes {
            let limit = options.limits.decoded_bytes;
            return Err(IoError::TooLarge {
                path: path.to_owned(),
                what: "the picture",
                bytes: memory,
                limit,
            });
        }
        let mut limits = Limits::default();
        limits.decoding_buffer_size = usize::try_from(raw).unwrap_or(usize::MAX).saturating_add(1 << 16);
        limits.intermediate_buffer_size = limits.decoding_buffer_size;
        limits.ifd_value_size = bytes.len().max(1 << 16);
        let mut decoder = decoder.with_limits(limits);

        let profile = decoder.get_tag_u8_vec(Tag::Unknown(tiff_tags::ICC_PROFILE)).ok();
        let (rows, cols) = (rows as usize, cols as usize);
        let max = |bits: u8| ((1u64 << bits.min(32)) - 1) as f32;
        let mut decoded = DecodingResult::U8(Vec::new());
        let layout = decoder.read_image_to_buffer(&mut decoded).map_err(wrong)?;
        let (mut samples, float): (Vec<f32>, bool) = match decoded {
            DecodingResult::U8(v) if bits == 8 => (v.iter().map(|&x| f32::from(x) / 255.0).collect(), false),
            DecodingResult::U16(v) => (v.iter().map(|&x| f32::from(x) / max(bits)).collect(), false),
            DecodingResult::F16(v) => (v.iter().map(|x| x.to_f32()).collect(), true),
            DecodingResult::F32(v) => (v, true),
            _ => {
                let expected = "8 or 16 bits, or 16 or 32 bits floating point";
                return Err(IoError::field(path, "BitsPerSample", bits.to_string(), expected));
            }
        };
        if layout.planes > 1 {
            let pixels = samples.len() / layout.planes;
            let place = |i: usize| i % layout.planes * pixels + i / layout.planes;
            samples = (0..samples.len()).filter_map(|i| samples.get(place(i)).copied()).collect();
        }
        let mut notes = Vec::new();
        alpha_note(&mut notes, channels);
        let space = if float {
            check_float(path, (cols, channels), &mut samples, options.clamp_negative)?;
            ColorSpace::LinearSrgb
        } else {
            let known = [ColorSpace::Srgb, ColorSpace::DisplayP3];
            let ours = known.into_iter().find(|s| icc::profile(*s).is_some() && icc::profile(*s) == profile);
            if profile.is_some() && ours.is_none() {
                notes.push(PROFILE_NOTE.to_owned());
            }
            ours.unwrap_or(ColorSpace::Srgb)
        };
        Ok(Picture { image: from_interleaved(path, (rows, cols, channels), &samples, space)?, bits, notes })
    })
}
