//! Reading TIFF 6.0 and BigTIFF: grey and RGB of 8 or 16 bits or floating point.

use std::path::Path;
use std::sync::Arc;

use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;

use super::decoded::{PROFILE_NOTE, Picture, alpha_note};
use crate::error::At;
use crate::file::Negative;
use crate::raster::{self, Bad, Kind, Shared, Values};
use crate::scene_file::cube_file::bad_to_error;
use crate::tiff::{Images, cube, tags};
use crate::{IoError, Orientation, ReadOptions, icc};

const WHITE_IS_ZERO: u64 = 0;

pub(super) fn decode(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    let absent = || IoError::field(path, "the image", "absent", "an image");
    let directory = Images::new(&bytes, path, false)?.next().ok_or_else(absent)??;
    let photometric = directory.integer(tags::PHOTOMETRIC);
    let channels = match photometric {
        Some(WHITE_IS_ZERO | 1) => 1,
        Some(2) => 3,
        other => {
            let found = other.map_or_else(|| "absent".to_owned(), |p| p.to_string());
            return Err(IoError::field(path, "PhotometricInterpretation", found, "0 or 1 (grey) or 2 (RGB)"));
        }
    };
    let source: Shared<'_> = Arc::new(bytes);
    let cube = cube(&directory, &source, path, options.limits)?;
    let (rows, cols, samples) = (cube.raster.rows, cube.raster.cols, cube.raster.bands);
    if samples < channels {
        let expected = format!("at least {channels}");
        return Err(IoError::field(path, "SamplesPerPixel", samples.to_string(), expected));
    }
    let (bits, full) = match cube.raster.kind {
        Kind::U8 => (8, Some(255.0)),
        Kind::U16 => (16, Some(65535.0)),
        Kind::F16 => (16, None),
        Kind::F32 => (32, None),
        other => {
            let found = format!("{} of another type", 8 * other.size());
            let expected = "8 or 16 bits, or 16 or 32 bits floating point";
            return Err(IoError::field(path, "BitsPerSample", found, expected));
        }
    };
    let raw = cube.raster.bytes().unwrap_or(u64::MAX);
    options.limits.check(path, "the picture", raw, bytes.len() as u64)?;
    let planes = (rows as u64).saturating_mul(cols as u64).saturating_mul(4 * 3);
    options.limits.check_memory(path, "the picture", raw.saturating_add(planes))?;

    let negative = options.negative_or(Negative::Keep);
    let values = Values { gains: &[], ignore: None, negative };
    let check = |plane: usize, samples: &mut [f32], row: usize| {
        values.check(plane, samples, (row, 0, cols)).map_err(Bad::Sample)
    };
    let bands: Vec<(usize, usize)> = (0..channels).map(|band| (0, band)).collect();
    let mut data: Vec<f32> = raster::read(&[cube], &bands, (0..rows, 0..cols), check)
        .map_err(|bad| bad_to_error(bad, (path, "TIFF"), |band| band.to_string()))?;
    if photometric == Some(WHITE_IS_ZERO) {
        data.iter_mut().for_each(|v| *v = full.unwrap_or(1.0) - *v);
    }
    if let Some(full) = full {
        data.iter_mut().for_each(|v| *v /= full);
    }
    let data = if channels == 1 { data.repeat(3) } else { data };

    let mut notes = Vec::new();
    alpha_note(&mut notes, samples > channels);
    let profile = directory.bytes(tags::ICC_PROFILE);
    let known = [ColorSpace::Srgb, ColorSpace::DisplayP3];
    let ours = known.into_iter().find(|s| profile.is_some() && icc::profile(*s) == profile);
    if full.is_some() && profile.is_some() && ours.is_none() {
        notes.push(PROFILE_NOTE.to_owned());
    }
    let space = if full.is_some() { ours.unwrap_or(ColorSpace::Srgb) } else { ColorSpace::LinearSrgb };
    let planes = Planes::new(rows, cols, 3, data).at(path)?;
    let orientation =
        directory.integer(tags::ORIENTATION).map_or_else(Orientation::default, Orientation::from_exif);
    Ok(Picture { image: Image::new(space, planes).at(path)?, bits, orientation, notes })
}
