//! Reading DNG.

use std::path::Path;

use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling};

use super::levels::{one_black_level, opcode_lists};
use super::samples::{Coding, Shape, decode};
use super::{
    CFA, COLOR_LETTERS, ColorMatrix, Crop, Description, Dng, DngInfo, Facts, LINEAR_RAW, color_codes,
    plane_order,
};
use crate::error::At;
use crate::tiff::{Directory, Images, tags};
use crate::{IoError, Limits, file};

/// The raw image of a DNG: CFA or LinearRaw; 8 to 16 bits or floating point of 16, 24 or 32; uncompressed, lossless
/// JPEG, Deflate or JPEG XL; both byte orders, strips or tiles. The image is cropped to its active area and its linearisation
/// table applied. Where black levels differ from pixel to pixel, their difference to the highest is taken off the
/// samples, so that one level holds for all. Opcode lists are ignored, with a note.
///
/// # Errors
/// When the file cannot be read, is not a DNG, is compressed otherwise, has another layout than a rectangular mosaic, ends
/// too early, or its levels make no range.
pub fn read(path: &Path, limits: Limits) -> Result<Dng, IoError> {
    parse(&file::read(path, limits.file_bytes)?, path, limits)
}

/// As [`read`], from memory; `path` is only named.
pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Dng, IoError> {
    parse(bytes, path, Limits::default())
}

/// Most images of a DNG that are looked at.
const MAX_IMAGES: usize = 64;

fn parse(bytes: &[u8], path: &Path, limits: Limits) -> Result<Dng, IoError> {
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
    opcode_lists(ifd, &mut notes);

    let (sampling, names) = sampling(ifd, shape, path)?;
    let full = if shape.float { 1.0 } else { f64::from((1u32 << shape.bits) - 1) };
    let white = ifd.number(tags::WHITE_LEVEL).unwrap_or(full);
    let (rows, cols) = (area.rows, area.cols);
    let black = one_black_level(ifd, (rows, cols, shape.planes), &mut samples, path, &mut notes)?;
    let facts =
        first.text(tags::IMAGE_DESCRIPTION).and_then(|t| serde_json::from_str::<Description>(&t).ok());
    let facts = facts.and_then(|d| described(d.smalti, &sampling, ifd));
    let (sampling, names, order, black, white) = match facts {
        Some((f, sampling, order)) => (sampling, f.channels, order, f.black_level, f.white_level),
        None => {
            let order = (0..sampling.channels()).collect();
            (sampling, names, order, black, white)
        }
    };
    let raw = RawImage::new(rows, cols, samples, sampling, names, black, white).at(path)?;
    let default_crop = default_crop(ifd, rows, cols);
    Ok(Dng { raw, default_crop, info: info(first, &order), notes })
}

/// The sampling in the words of the description, and its channels in the order of DNG's planes. `None` where the
/// description is not of this mosaic: left behind by a program that changed the image.
fn described(facts: Facts, stated: &Sampling, ifd: &Directory) -> Option<(Facts, Sampling, Vec<usize>)> {
    if facts.channels.len() != stated.channels() {
        return None;
    }
    match (stated, &facts.mosaic) {
        (Sampling::Full { channels }, None) => Some((facts, stated.clone(), (0..*channels).collect())),
        (Sampling::Mosaic(m), Some(rows)) => {
            let codes = color_codes(&facts.channels)?;
            let cells = rows.concat();
            let pattern: Option<Vec<u8>> =
                cells.iter().map(|c| codes.get(usize::from(*c)).copied()).collect();
            let same_tile = rows.len() == m.rows() && rows.iter().all(|r| r.len() == m.cols());
            if !same_tile || pattern.as_deref() != ifd.bytes(tags::CFA_PATTERN) {
                return None;
            }
            let mosaic = Mosaic::new(m.rows(), m.cols(), cells).ok()?;
            Some((facts, Sampling::Mosaic(mosaic), plane_order(&codes)))
        }
        _ => None,
    }
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

/// The mosaic and names for its channels, from DNG's own fields.
fn sampling(ifd: &Directory, shape: Shape, path: &Path) -> Result<(Sampling, Vec<String>), IoError> {
    let name = |code: &u8| match COLOR_LETTERS.get(usize::from(*code)) {
        Some(letter) => (*letter).to_owned(),
        None => format!("code {code}"),
    };
    if ifd.integer(tags::PHOTOMETRIC) == Some(u64::from(LINEAR_RAW)) {
        let names = match shape.planes {
            3 => (0..3).map(|c| name(&c)).collect(),
            n => (1..=n).map(|i| i.to_string()).collect(),
        };
        return Ok((Sampling::Full { channels: shape.planes }, names));
    }
    if shape.planes != 1 {
        let found = format!("{} samples a pixel", shape.planes);
        return Err(IoError::field(path, "the mosaic", found, "1"));
    }
    let layout = ifd.size(tags::CFA_LAYOUT).unwrap_or(1);
    if layout != 1 {
        return Err(IoError::field(path, "CFALayout", layout.to_string(), "1 (rectangular)"));
    }
    let dim = ifd.numbers(tags::CFA_REPEAT_PATTERN_DIM).unwrap_or_default();
    let (rows, cols) = match dim.as_slice() {
        [rows, cols] => (*rows as usize, *cols as usize),
        _ => return Err(IoError::field(path, "CFARepeatPatternDim", format!("{dim:?}"), "rows and columns")),
    };
    let pattern = ifd.bytes(tags::CFA_PATTERN).unwrap_or_default();
    let plane_colors = ifd.bytes(tags::CFA_PLANE_COLOR).unwrap_or(&[0, 1, 2]);
    // Planes that no cell has would be channels without samples.
    let used: Vec<u8> = plane_colors.iter().copied().filter(|c| pattern.contains(c)).collect();
    let channel = |code: &u8| {
        used.iter().position(|c| c == code).and_then(|c| u8::try_from(c).ok()).ok_or_else(|| {
            let expected = format!("colours that CFAPlaneColor lists: {plane_colors:?}");
            IoError::field(path, "CFAPattern", format!("with colour {code}"), expected)
        })
    };
    let cells = pattern.iter().map(channel).collect::<Result<Vec<u8>, _>>()?;
    let mosaic = Mosaic::new(rows, cols, cells).at(path)?;
    Ok((Sampling::Mosaic(mosaic), used.iter().map(name).collect()))
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
