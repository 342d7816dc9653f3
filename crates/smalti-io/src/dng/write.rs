//! Writing DNG.

use std::io::Write;
use std::path::Path;

use smalti::sensor::{RawImage, RawSamples, Sampling};

use super::ljpeg;
use super::mosaic::{color_codes, plane_order};
use super::{CFA, Crop, Description, DngInfo, Facts, LINEAR_RAW};
use crate::text::ascii_json;
use crate::tiff::{Fields, Value, tags, write_header};
use crate::{IoError, Orientation, write};

/// How samples are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Compression {
    /// As they are.
    #[default]
    None,
    /// Lossless JPEG: digital numbers only, at most 65535 rows or columns, and four planes.
    LosslessJpeg,
}

/// As [`write_compressed`], uncompressed.
pub fn write(path: &Path, raw: &RawImage, info: &DngInfo) -> Result<(), IoError> {
    write_compressed(path, raw, info, Compression::None)
}

/// Writes a raw image: digital numbers as 16-bit, volts as 32-bit floating point; a mosaic as CFA, full sampling as
/// LinearRaw. Levels that are not whole numbers are rounded in the DNG fields (white) or written as fractions
/// (black, 0 where negative) and stand exactly in the description.
///
/// # Errors
/// When matrix or neutral do not have a row per channel, there are more channels than DNG has codes for, the
/// compression cannot hold the image, the file would pass 4 GiB, or it cannot be written.
pub fn write_compressed(
    path: &Path,
    raw: &RawImage,
    info: &DngInfo,
    compression: Compression,
) -> Result<(), IoError> {
    write_viewed(path, raw, info, compression, (Orientation::default(), None))
}

/// The bytes that [`write()`] writes; `path` is only named in errors.
///
/// # Errors
/// As [`write_compressed`].
pub fn to_bytes(raw: &RawImage, info: &DngInfo, path: &Path) -> Result<Vec<u8>, IoError> {
    let mut bytes = Vec::new();
    let viewed = (Orientation::default(), None);
    put(path, raw, info, Compression::None, viewed)?(&mut bytes).map_err(IoError::writing(path))?;
    Ok(bytes)
}

/// As [`write_compressed`], with the orientation of the picture and its part that is shown.
pub(super) fn write_viewed(
    path: &Path,
    raw: &RawImage,
    info: &DngInfo,
    compression: Compression,
    viewed: (Orientation, Option<Crop>),
) -> Result<(), IoError> {
    write::stream(path, put(path, raw, info, compression, viewed)?)
}

/// What writes the file to a target. Everything that may be wrong with the image is found before.
fn put<'a, W: Write>(
    path: &Path,
    raw: &'a RawImage,
    info: &DngInfo,
    compression: Compression,
    (orientation, default_crop): (Orientation, Option<Crop>),
) -> Result<impl FnOnce(&mut W) -> std::io::Result<()> + use<'a, W>, IoError> {
    let mut fields = fields(path, raw, info)?;
    fields.insert(tags::ORIENTATION, Value::Short(vec![orientation.exif().into()]));
    if let Some(crop) = default_crop {
        // Horizontal before vertical.
        let pair = |across: usize, down: usize| Value::Long(vec![across as u32, down as u32]);
        fields.insert(tags::DEFAULT_CROP_ORIGIN, pair(crop.col, crop.row));
        fields.insert(tags::DEFAULT_CROP_SIZE, pair(crop.cols, crop.rows));
    }
    let coded = match compression {
        Compression::None => None,
        Compression::LosslessJpeg => {
            fields.insert(tags::COMPRESSION, Value::Short(vec![7]));
            Some(lossless_jpeg(path, raw)?)
        }
    };
    let digital = matches!(raw.samples(), RawSamples::Digital(_));
    let plain = raw.samples().len() as u64 * if digital { 2 } else { 4 };
    let bytes = coded.as_ref().map_or(plain, |c| c.len() as u64);
    let rows = raw.rows() as u32;
    Ok(move |out: &mut W| {
        write_header(out, fields, rows, bytes)?;
        match (coded, raw.samples()) {
            (Some(coded), _) => out.write_all(&coded),
            (None, RawSamples::Digital(v)) => write_interleaved(out, v, raw, |x| x.to_le_bytes()),
            (None, RawSamples::Analog(v)) => write_interleaved(out, v, raw, |x| x.to_le_bytes()),
        }
    })
}

fn lossless_jpeg(path: &Path, raw: &RawImage) -> Result<Vec<u8>, IoError> {
    let expected = "digital numbers of at most 65535 rows or columns and four planes for lossless JPEG";
    let RawSamples::Digital(samples) = raw.samples() else {
        return Err(IoError::field(path, "the raw image", "in volts", expected));
    };
    let (cols, planes) = (raw.cols(), raw.sampling().planes());
    let plane_len = raw.rows() * cols;
    let interleaved: Vec<u16>;
    // Two columns of a mosaic make a pixel of two components, so that like is predicted from like.
    let (samples, cols, components) = match planes {
        1 if cols.is_multiple_of(2) => (samples, cols / 2, 2),
        1 => (samples, cols, 1),
        _ => {
            let pixel = |i: usize| (0..planes).filter_map(move |p| samples.get(p * plane_len + i).copied());
            interleaved = (0..plane_len).flat_map(pixel).collect();
            (&interleaved, cols, planes)
        }
    };
    ljpeg::encode(samples, cols, components, 1, 0).ok_or_else(|| {
        let found = format!("{} × {} pixels of {planes} planes", raw.rows(), raw.cols());
        IoError::field(path, "the raw image", found, expected)
    })
}

/// Row by row, the planes of each pixel side by side.
fn write_interleaved<T: Copy, const N: usize>(
    out: &mut impl Write,
    values: &[T],
    raw: &RawImage,
    bytes: fn(T) -> [u8; N],
) -> std::io::Result<()> {
    let (cols, planes) = (raw.cols(), raw.sampling().planes());
    let plane_len = raw.rows() * cols;
    let mut row_bytes = vec![[0u8; N]; cols * planes];
    for row in 0..raw.rows() {
        for p in 0..planes {
            let from = values.iter().skip(p * plane_len + row * cols).take(cols);
            for (to, &v) in row_bytes.iter_mut().skip(p).step_by(planes).zip(from) {
                *to = bytes(v);
            }
        }
        out.write_all(row_bytes.as_flattened())?;
    }
    Ok(())
}

fn fields(path: &Path, raw: &RawImage, info: &DngInfo) -> Result<Fields, IoError> {
    let channels = raw.sampling().channels();
    let planes = raw.sampling().planes();
    let size = |n: usize, what: &str| {
        u32::try_from(n).map_err(|_| IoError::field(path, what, n.to_string(), "less than 2³²"))
    };
    let (rows, cols) = (size(raw.rows(), "rows")?, size(raw.cols(), "cols")?);
    let samples_per_pixel = u16::try_from(planes)
        .map_err(|_| IoError::field(path, "channels", planes.to_string(), "at most 65535"))?;
    let (bits, format, backward) = match raw.samples() {
        RawSamples::Digital(_) => (16, 1, 1),
        // Floating point came with DNG 1.4.
        RawSamples::Analog(_) => (32, 3, 4),
    };
    let model = format!("{} {}", info.make, info.model).trim().to_owned();
    let model = if model.is_empty() { "Smalti".to_owned() } else { model };
    let mosaic = match raw.sampling() {
        Sampling::Mosaic(m) => Some(m.cells().chunks(m.cols()).map(<[u8]>::to_vec).collect()),
        Sampling::Full { .. } => None,
    };
    let facts = Facts {
        channels: raw.channel_names().to_vec(),
        mosaic,
        unit: if bits == 16 { "digital numbers".into() } else { "V".into() },
        black_level: raw.black_level(),
        white_level: raw.white_level(),
    };

    let mut fields = Fields::from([
        (tags::NEW_SUBFILE_TYPE, Value::Long(vec![0])),
        (tags::IMAGE_WIDTH, Value::Long(vec![cols])),
        (tags::IMAGE_LENGTH, Value::Long(vec![rows])),
        (tags::BITS_PER_SAMPLE, Value::Short(vec![bits; planes])),
        (tags::COMPRESSION, Value::Short(vec![1])),
        (tags::IMAGE_DESCRIPTION, Value::Ascii(ascii_json(&Description { smalti: facts }))),
        (tags::SAMPLES_PER_PIXEL, Value::Short(vec![samples_per_pixel])),
        (tags::PLANAR_CONFIGURATION, Value::Short(vec![1])),
        (tags::SOFTWARE, Value::Ascii(concat!("smalti ", env!("CARGO_PKG_VERSION")).into())),
        (tags::SAMPLE_FORMAT, Value::Short(vec![format; planes])),
        (tags::DNG_VERSION, Value::Byte(vec![1, 4, 0, 0])),
        (tags::DNG_BACKWARD_VERSION, Value::Byte(vec![1, backward, 0, 0])),
        (tags::UNIQUE_CAMERA_MODEL, Value::Ascii(ascii(&model))),
        (tags::BLACK_LEVEL_REPEAT_DIM, Value::Short(vec![1, 1])),
        (tags::BLACK_LEVEL, black(raw.black_level(), planes)),
        (tags::WHITE_LEVEL, Value::Long(vec![raw.white_level().round().clamp(1.0, 4e9) as u32; planes])),
        (tags::ACTIVE_AREA, Value::Long(vec![0, 0, rows, cols])),
    ]);
    for (tag, text) in [(tags::MAKE, &info.make), (tags::MODEL, &info.model)] {
        if !text.is_empty() {
            fields.insert(tag, Value::Ascii(ascii(text)));
        }
    }
    // Rows of the matrix are in the order of the colour planes.
    let order = match raw.sampling() {
        Sampling::Full { channels } => {
            fields.insert(tags::PHOTOMETRIC, Value::Short(vec![LINEAR_RAW]));
            (0..*channels).collect()
        }
        Sampling::Mosaic(mosaic) => {
            let codes = color_codes(raw.channel_names()).ok_or_else(|| {
                let expected = "at most 248 without a letter of DNG";
                IoError::field(path, "channels", channels.to_string(), expected)
            })?;
            let code = |c: &u8| codes.get(usize::from(*c)).copied().unwrap_or(0);
            let too_large = |n: usize| {
                IoError::field(path, "the mosaic", n.to_string(), "at most 65535 cells in a row or column")
            };
            let side = |n: usize| u16::try_from(n).map_err(|_| too_large(n));
            let dim = vec![side(mosaic.rows())?, side(mosaic.cols())?];
            fields.insert(tags::PHOTOMETRIC, Value::Short(vec![CFA]));
            fields.insert(tags::CFA_REPEAT_PATTERN_DIM, Value::Short(dim));
            fields.insert(tags::CFA_PATTERN, Value::Byte(mosaic.cells().iter().map(code).collect()));
            let order = plane_order(&codes);
            let colors = order.iter().filter_map(|c| codes.get(*c).copied()).collect();
            fields.insert(tags::CFA_PLANE_COLOR, Value::Byte(colors));
            fields.insert(tags::CFA_LAYOUT, Value::Short(vec![1]));
            order
        }
    };
    let signed = |v: &f64| fraction(*v, i32::MAX.into()).map(|n| n as i32);
    if let Some(stops) = info.baseline_exposure_stops {
        fields.insert(tags::BASELINE_EXPOSURE, Value::SignedRational(vec![signed(&stops)]));
    }
    let per_channel = |field: &str, got: usize| {
        if got == channels {
            return Ok(());
        }
        let expected = format!("one entry for each of {channels} channels");
        Err(IoError::field(path, field, format!("{got} long"), expected))
    };
    if let Some(matrix) = &info.color_matrix {
        per_channel("color_matrix", matrix.camera_from_xyz.len())?;
        let rows = order.iter().filter_map(|&c| matrix.camera_from_xyz.get(c));
        let values = rows.flatten().map(signed).collect();
        fields.insert(tags::COLOR_MATRIX_1, Value::SignedRational(values));
        fields.insert(tags::CALIBRATION_ILLUMINANT_1, Value::Short(vec![matrix.light_source]));
    }
    if let Some(neutral) = &info.as_shot_neutral {
        per_channel("as_shot_neutral", neutral.len())?;
        let values = order.iter().filter_map(|&c| neutral.get(c)).map(|&v| unsigned(v)).collect();
        fields.insert(tags::AS_SHOT_NEUTRAL, Value::Rational(values));
    }
    Ok(fields)
}

fn black(level: f64, planes: usize) -> Value {
    if level >= 0.0 && level.fract() == 0.0 && level <= f64::from(u32::MAX) {
        Value::Long(vec![level as u32; planes])
    } else {
        Value::Rational(vec![unsigned(level); planes])
    }
}

/// The nearest fraction over a power of ten; 0 for what is negative.
fn unsigned(v: f64) -> [u32; 2] {
    fraction(v.max(0.0), u32::MAX.into()).map(|n| n as u32)
}

/// Numerator and denominator, a power of ten; the size of the first is at most `most`.
fn fraction(v: f64, most: f64) -> [f64; 2] {
    let mut denominator = 1e9;
    while denominator > 1.0 && (v * denominator).abs() > most {
        denominator /= 10.0;
    }
    [(v * denominator).round(), denominator]
}

/// TIFF supports ASCII only.
fn ascii(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
}
