//! Reading DNG.

use std::path::Path;

use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling};

use super::samples::{Area, Shape, decode};
use super::{CFA, COLOR_LETTERS, ColorMatrix, Description, Dng, DngInfo, Facts, LINEAR_RAW};
use crate::error::At;
use crate::tiff_tags::{self as tags, Ifd, Tiff};
use crate::{IoError, Limits, file};

/// The raw image of an uncompressed DNG: CFA or LinearRaw; 8, 10, 12, 14 or 16 bits or 32-bit floating point; both
/// byte orders, strips or tiles. The image is cropped to its active area, its linearisation table applied. Black
/// levels that differ from cell to cell are averaged, with a note.
///
/// # Errors
/// When the file cannot be read, is not a DNG, is compressed, has another layout than a rectangular mosaic, ends
/// too early, or its levels make no range.
pub fn read(path: &Path, limits: Limits) -> Result<Dng, IoError> {
    from_bytes(&file::read(path, limits.file_bytes)?, path)
}

/// As [`read`], from memory; `path` is only named.
///
/// # Errors
/// As [`read`].
pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Dng, IoError> {
    let not_dng = || IoError::UnknownFormat { path: path.to_owned(), expected: "a DNG file" };
    let tiff = Tiff::new(bytes).ok_or_else(not_dng)?;
    let ifds = tiff.ifds();
    let first = ifds.first().ok_or_else(not_dng)?;
    first.raw(tags::DNG_VERSION).ok_or_else(not_dng)?;
    let is_raw = |i: &&Ifd<'_>| {
        matches!(i.size(tags::PHOTOMETRIC), Some(p) if p == usize::from(CFA) || p == usize::from(LINEAR_RAW))
            && i.size(tags::NEW_SUBFILE_TYPE).unwrap_or(0) == 0
    };
    let ifd = ifds.iter().find(is_raw).ok_or_else(|| {
        IoError::field(
            path,
            "the raw image",
            "absent",
            "PhotometricInterpretation CFA (32803) or LinearRaw (34892)",
        )
    })?;

    let shape = shape(ifd, path)?;
    let area = active_area(ifd, shape, path)?;
    let mut samples = decode(tiff, ifd, shape, area, path)?;
    let mut notes = Vec::new();
    let table = ifd.numbers(tags::LINEARIZATION_TABLE).filter(|t| !t.is_empty());
    if let (RawSamples::Digital(values), Some(table)) = (&mut samples, &table) {
        for v in values {
            let at = usize::from(*v).min(table.len() - 1);
            *v = table.get(at).map_or(0, |t| *t as u16);
        }
    }
    for (tag, name) in
        [(tags::BLACK_LEVEL_DELTA_H, "BlackLevelDeltaH"), (tags::BLACK_LEVEL_DELTA_V, "BlackLevelDeltaV")]
    {
        if ifd.raw(tag).is_some() {
            notes.push(format!("{name} is ignored"));
        }
    }

    let (sampling, names) = sampling(ifd, shape, path)?;
    let white = ifd.number(tags::WHITE_LEVEL).unwrap_or(if shape.float {
        1.0
    } else {
        f64::from((1u32 << shape.bits) - 1)
    });
    let black = black_level(ifd, &mut notes);
    let facts =
        first.text(tags::IMAGE_DESCRIPTION).and_then(|t| serde_json::from_str::<Description>(&t).ok());
    let facts = facts.map(|d| d.smalti).filter(|f| agrees(f, &sampling));
    let (names, black, white) = match facts {
        Some(f) => (f.channels, f.black_level, f.white_level),
        None => (names, black, white),
    };
    let (rows, cols) = (area.bottom - area.top, area.right - area.left);
    let channels = sampling.channels();
    let raw = RawImage::new(rows, cols, samples, sampling, names, black, white).at(path)?;
    Ok(Dng { raw, info: info(first, channels), notes })
}

/// Whether the description was written for this mosaic, and not left behind by a program that changed it.
fn agrees(facts: &Facts, sampling: &Sampling) -> bool {
    let same_mosaic = match (sampling, &facts.mosaic) {
        (Sampling::Full { .. }, None) => true,
        (Sampling::Mosaic(m), Some(rows)) => {
            rows.len() == m.rows() && rows.iter().map(Vec::as_slice).eq(m.cells().chunks(m.cols()))
        }
        _ => false,
    };
    same_mosaic && facts.channels.len() == sampling.channels()
}

fn shape(ifd: &Ifd<'_>, path: &Path) -> Result<Shape, IoError> {
    let compression = ifd.size(tags::COMPRESSION).unwrap_or(1);
    if compression != 1 {
        let name = match compression {
            7 => " (lossless JPEG)",
            8 => " (Deflate)",
            34892 => " (lossy JPEG)",
            52546 => " (JPEG XL)",
            _ => "",
        };
        let expected = "1: only uncompressed DNG is read (Adobe's converter writes it with -u)";
        return Err(IoError::field(path, "Compression", format!("{compression}{name}"), expected));
    }
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
    let allowed: &[f64] = if float { &[32.0] } else { &[8.0, 10.0, 12.0, 14.0, 16.0] };
    if !allowed.contains(&first) || bits.iter().any(|b| *b != first) {
        let expected = "8, 10, 12, 14 or 16 bits, or 32-bit floating point, the same for every sample";
        return Err(IoError::field(path, "BitsPerSample", format!("{bits:?}"), expected));
    }
    Ok(Shape { rows, cols, planes, bits: first as usize, float })
}

fn active_area(ifd: &Ifd<'_>, shape: Shape, path: &Path) -> Result<Area, IoError> {
    let whole = Area { top: 0, left: 0, bottom: shape.rows, right: shape.cols };
    let Some(stated) = ifd.numbers(tags::ACTIVE_AREA) else { return Ok(whole) };
    let area = match stated.as_slice() {
        [top, left, bottom, right] => Area {
            top: *top as usize,
            left: *left as usize,
            bottom: *bottom as usize,
            right: *right as usize,
        },
        _ => Area { top: 0, left: 0, bottom: 0, right: 0 },
    };
    if area.top < area.bottom
        && area.bottom <= shape.rows
        && area.left < area.right
        && area.right <= shape.cols
    {
        return Ok(area);
    }
    let expected = format!("top, left, bottom, right within {} × {}", shape.rows, shape.cols);
    Err(IoError::field(path, "ActiveArea", format!("{stated:?}"), expected))
}

/// The mosaic and names for its channels, from DNG's own fields.
fn sampling(ifd: &Ifd<'_>, shape: Shape, path: &Path) -> Result<(Sampling, Vec<String>), IoError> {
    let name = |code: &u8| match COLOR_LETTERS.get(usize::from(*code)) {
        Some(letter) => (*letter).to_owned(),
        None => format!("code {code}"),
    };
    if ifd.size(tags::PHOTOMETRIC) == Some(usize::from(LINEAR_RAW)) {
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
    let pattern = ifd.raw(tags::CFA_PATTERN).unwrap_or_default();
    let plane_colors = ifd.raw(tags::CFA_PLANE_COLOR).unwrap_or(&[0, 1, 2]);
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

fn black_level(ifd: &Ifd<'_>, notes: &mut Vec<String>) -> f64 {
    let levels = ifd.numbers(tags::BLACK_LEVEL).unwrap_or_default();
    let Some(first) = levels.first() else { return 0.0 };
    if levels.iter().all(|l| l == first) {
        return *first;
    }
    let mean = levels.iter().sum::<f64>() / levels.len() as f64;
    notes.push(format!("black levels {levels:?} are averaged to {mean}"));
    mean
}

fn info(first: &Ifd<'_>, channels: usize) -> DngInfo {
    let matrix = first.numbers(tags::COLOR_MATRIX_1).filter(|m| m.len() == 3 * channels);
    let rows = matrix.map(|m| m.as_chunks::<3>().0.to_vec());
    let light_source = first.size(tags::CALIBRATION_ILLUMINANT_1).unwrap_or(0) as u16;
    let usable = |rows: &Vec<[f64; 3]>| rows.iter().flatten().all(|v| v.is_finite());
    DngInfo {
        make: first.text(tags::MAKE).unwrap_or_default(),
        model: first.text(tags::MODEL).unwrap_or_default(),
        color_matrix: rows
            .filter(usable)
            .map(|camera_from_xyz| ColorMatrix { camera_from_xyz, light_source }),
        as_shot_neutral: first
            .numbers(tags::AS_SHOT_NEUTRAL)
            .filter(|n| n.len() == channels && n.iter().all(|v| v.is_finite())),
    }
}
