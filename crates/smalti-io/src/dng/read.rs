//! Reading DNG.

use std::path::Path;

use smalti::sensor::{RawImage, RawSamples};

use super::levels::one_black_level;
use super::mosaic::{StatedMosaic, described, sampling};
use super::samples::{Coding, Shape, decode};
use super::{CFA, ColorMatrix, Crop, Description, Dng, DngInfo, LINEAR_RAW, opcodes};
use crate::error::At;
use crate::tiff::{Directory, Images, tags};
use crate::{IoError, Limits, Orientation, file};

/// The raw image of a DNG: CFA or LinearRaw; 8 to 16 bits or floating point of 16, 24 or 32; uncompressed, lossless
/// JPEG, Deflate or JPEG XL; both byte orders, strips or tiles. The image is cropped to its active area and its linearisation
/// table applied. Where black levels differ from pixel to pixel, their difference to the highest is taken off the
/// samples, so that one level holds for all. Gain maps of the linear raw image (`OpcodeList2`) are applied; other opcodes are
/// ignored. Notes tell of both.
///
/// # Errors
/// When the file cannot be read, is not a DNG, is compressed otherwise, has another layout than a rectangular mosaic, ends
/// too early, or its levels make no range.
pub fn read(path: &Path, limits: Limits) -> Result<Dng, IoError> {
    read_as(path, limits, None)
}

/// As [`read`], with a mosaic that is stated in place of the file's own, if it has one.
///
/// # Errors
/// As [`read`], and when a mosaic is stated for an image with several samples in a pixel.
pub fn read_as(path: &Path, limits: Limits, mosaic: Option<&StatedMosaic>) -> Result<Dng, IoError> {
    parse(&file::read(path, limits.file_bytes)?, path, limits, mosaic)
}

/// As [`read`], from memory; `path` is only named.
pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Dng, IoError> {
    parse(bytes, path, Limits::default(), None)
}

/// Most images of a DNG that are looked at.
const MAX_IMAGES: usize = 64;

fn parse(bytes: &[u8], path: &Path, limits: Limits, stated: Option<&StatedMosaic>) -> Result<Dng, IoError> {
    let not_dng = || IoError::unknown(path, "a DNG file");
    // A damaged preview does not matter where the raw image is whole.
    let mut damaged = None;
    let mut images = Vec::new();
    for image in Images::new(&bytes, path, true).map_err(|_| not_dng())?.take(MAX_IMAGES) {
        match image {
            Ok(image) => images.push(image),
            Err(error) => damaged = damaged.or(Some(error)),
        }
    }
    let first = images.first().filter(|i| i.has(tags::DNG_VERSION));
    let is_raw = |i: &&Directory| {
        i.integer(tags::PHOTOMETRIC).is_some_and(|p| p == u64::from(CFA) || p == u64::from(LINEAR_RAW))
            && i.integer(tags::NEW_SUBFILE_TYPE).unwrap_or(0) == 0
    };
    let (first, ifd) = match (first, images.iter().find(is_raw), damaged) {
        (Some(first), Some(ifd), _) => (first, ifd),
        (_, _, Some(error)) => return Err(error),
        (None, ..) => return Err(not_dng()),
        (Some(_), None, None) => {
            let expected = "PhotometricInterpretation CFA (32803) or LinearRaw (34892)";
            return Err(IoError::field(path, "the raw image", "absent", expected));
        }
    };

    let shape = shape(ifd, path)?;
    let area = active_area(ifd, shape, path)?;
    let mut samples = decode(bytes, ifd, shape, area, limits, path)?;
    let mut notes = Vec::new();
    let table = ifd.numbers(tags::LINEARIZATION_TABLE).filter(|t| !t.is_empty());
    if let (RawSamples::Digital(values), Some(table)) = (&mut samples, &table) {
        for v in values {
            let at = usize::from(*v).min(table.len() - 1);
            *v = table.get(at).map_or(0, |t| *t as u16);
        }
    }
    let (sampling, names) = sampling(ifd, shape, stated, path, &mut notes)?;
    let full = if shape.float { 1.0 } else { f64::from((1u32 << shape.bits) - 1) };
    let white = ifd.number(tags::WHITE_LEVEL).unwrap_or(full);
    let (rows, cols) = (area.rows, area.cols);
    let black = one_black_level(ifd, (rows, cols, shape.planes), &mut samples, path, &mut notes)?;
    opcodes::apply(ifd, (rows, cols, shape.planes), &mut samples, black, &mut notes);
    let facts =
        first.text(tags::IMAGE_DESCRIPTION).and_then(|t| serde_json::from_str::<Description>(&t).ok());
    let facts = facts.filter(|_| stated.is_none()).and_then(|d| described(d.smalti, &sampling, ifd));
    let (sampling, names, order, black, white) = match facts {
        Some((f, sampling, order)) => (sampling, f.channels, order, f.black_level, f.white_level),
        None => {
            let order = (0..sampling.channels()).collect();
            (sampling, names, order, black, white)
        }
    };
    let raw = RawImage::new(rows, cols, samples, sampling, names, black, white).at(path)?;
    let default_crop = default_crop(ifd, rows, cols);
    // The first image states it for all.
    let orientation = [first, ifd]
        .iter()
        .find_map(|d| d.integer(tags::ORIENTATION))
        .map_or_else(Orientation::default, Orientation::from_exif);
    let noise = [ifd, first].iter().find_map(|d| noise(d));
    Ok(Dng { raw, default_crop, orientation, noise, info: info(first, &order), notes })
}

fn shape(ifd: &Directory, path: &Path) -> Result<Shape, IoError> {
    let coding = coding(ifd, path)?;
    let planes = ifd.size(tags::SAMPLES_PER_PIXEL).unwrap_or(1);
    let (rows, cols) = (ifd.size(tags::IMAGE_LENGTH).unwrap_or(0), ifd.size(tags::IMAGE_WIDTH).unwrap_or(0));
    if rows == 0 || cols == 0 || planes == 0 {
        let found = format!("{rows} × {cols} pixels of {planes} samples");
        return Err(IoError::field(path, "the raw image", found, "at least one sample"));
    }
    if planes > 1 && ifd.size(tags::PLANAR_CONFIGURATION).unwrap_or(1) != 1 {
        return Err(IoError::field(path, "PlanarConfiguration", "2", "1: samples of a pixel side by side"));
    }
    let bits = ifd.numbers(tags::BITS_PER_SAMPLE).unwrap_or_else(|| vec![1.0]);
    let float = ifd.number(tags::SAMPLE_FORMAT) == Some(3.0);
    let first = bits.first().copied().unwrap_or(0.0);
    let in_range = if float { [16.0, 24.0, 32.0].contains(&first) } else { (8.0..=16.0).contains(&first) };
    if !in_range || first.fract() != 0.0 || bits.iter().any(|b| *b != first) {
        let expected = "8 to 16 bits, or floating point of 16, 24 or 32, the same for every sample";
        return Err(IoError::field(path, "BitsPerSample", format!("{bits:?}"), expected));
    }
    let shape = Shape { rows, cols, planes, bits: first as usize, float, coding };
    if float && shape.coding == Coding::LosslessJpeg {
        return Err(IoError::field(path, "SampleFormat", "floating point", "integers in lossless JPEG"));
    }
    Ok(shape)
}

fn coding(ifd: &Directory, path: &Path) -> Result<Coding, IoError> {
    let compression = ifd.size(tags::COMPRESSION).unwrap_or(1);
    let name = match compression {
        1 => return Ok(Coding::None),
        7 => return Ok(Coding::LosslessJpeg),
        8 | 32946 => return Ok(Coding::Deflate),
        52546 => return Ok(Coding::JpegXl),
        34892 => " (lossy JPEG)",
        34713 => " (Nikon NEF)",
        _ => "",
    };
    let expected = "1 (none), 7 (lossless JPEG), 8 (Deflate) or 52546 (JPEG XL); Adobe's converter writes the first two from other DNG with -u or -c";
    Err(IoError::field(path, "Compression", format!("{compression}{name}"), expected))
}

fn active_area(ifd: &Directory, shape: Shape, path: &Path) -> Result<Crop, IoError> {
    let Some(stated) = ifd.numbers(tags::ACTIVE_AREA) else {
        return Ok(Crop::whole(shape.rows, shape.cols));
    };
    let area = match stated.iter().map(|v| *v as usize).collect::<Vec<_>>()[..] {
        [row, col, bottom, right] => {
            let (rows, cols) = (bottom.saturating_sub(row), right.saturating_sub(col));
            Crop { row, col, rows, cols }.within(shape.rows, shape.cols, path).ok()
        }
        _ => None,
    };
    area.ok_or_else(|| {
        let expected = format!("top, left, bottom, right within {} × {}", shape.rows, shape.cols);
        IoError::field(path, "ActiveArea", format!("{stated:?}"), expected)
    })
}

/// `None` where it is not stated, or not in whole pixels within the image.
fn default_crop(ifd: &Directory, rows: usize, cols: usize) -> Option<Crop> {
    let (origin, size) = (ifd.numbers(tags::DEFAULT_CROP_ORIGIN)?, ifd.numbers(tags::DEFAULT_CROP_SIZE)?);
    // Horizontal before vertical.
    let ([col, row], [wide, high]) = (origin.as_slice(), size.as_slice()) else { return None };
    if [col, row, wide, high].iter().any(|v| !(v.fract() == 0.0 && **v >= 0.0)) {
        return None;
    }
    let crop = Crop { row: *row as usize, col: *col as usize, rows: *high as usize, cols: *wide as usize };
    crop.within(rows, cols, Path::new("")).ok()
}

/// The mean over the pairs of numbers, one for all channels or one for each, in `NoiseProfile`.
fn noise(ifd: &Directory) -> Option<[f64; 2]> {
    let numbers = ifd.numbers(tags::NOISE_PROFILE)?;
    let (pairs, rest) = numbers.as_chunks::<2>();
    let mean = |i: usize| pairs.iter().map(|pair| pair[i]).sum::<f64>() / pairs.len() as f64;
    let is_noise = !pairs.is_empty() && rest.is_empty() && numbers.iter().all(|v| v.is_finite() && *v >= 0.0);
    is_noise.then(|| [mean(0), mean(1)])
}

/// Names and colour; `order` gives the channel of each of DNG's planes.
fn info(first: &Directory, order: &[usize]) -> DngInfo {
    let channels = order.len();
    let plane = |c: usize| order.iter().position(|&o| o == c);
    let light_source = first.size(tags::CALIBRATION_ILLUMINANT_1).unwrap_or(0) as u16;
    let matrix = first.numbers(tags::COLOR_MATRIX_1).filter(|m| m.len() == 3 * channels && finite(m));
    let row = |m: &[f64], c: usize| m.as_chunks::<3>().0.get(plane(c)?).copied();
    let matrix = matrix.and_then(|m| (0..channels).map(|c| row(&m, c)).collect());
    let neutral = first.numbers(tags::AS_SHOT_NEUTRAL).filter(|n| n.len() == channels && finite(n));
    DngInfo {
        make: first.text(tags::MAKE).unwrap_or_default(),
        model: first.text(tags::MODEL).unwrap_or_default(),
        color_matrix: matrix.map(|camera_from_xyz| ColorMatrix { camera_from_xyz, light_source }),
        as_shot_neutral: neutral.and_then(|n| (0..channels).map(|c| n.get(plane(c)?).copied()).collect()),
        baseline_exposure_stops: first
            .numbers(tags::BASELINE_EXPOSURE)
            .filter(|v| finite(v))
            .and_then(|v| v.first().copied()),
    }
}

fn finite(values: &[f64]) -> bool {
    values.iter().all(|v| v.is_finite())
}
