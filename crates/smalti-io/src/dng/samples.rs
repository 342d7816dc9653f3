//! Samples in strips or tiles.

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use rayon::prelude::*;
use smalti::sensor::RawSamples;

use super::packed::{Predictor, float, integer};
use super::{jxl, ljpeg};
use crate::file::{self, LARGEST_EXPANSION};
use crate::scene_file::Crop;
use crate::tiff::{Directory, tags};
use crate::{IoError, Limits};

/// How strips or tiles are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    None,
    LosslessJpeg,
    Deflate,
    JpegXl,
}

/// How the samples of an image lie in the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    pub(super) rows: usize,
    pub(super) cols: usize,
    pub(super) planes: usize,
    pub(super) bits: usize,
    pub(super) float: bool,
    pub(super) coding: Coding,
}

/// Samples of the area that is light-sensitive, ordered plane, row, column.
pub(super) fn decode(
    bytes: &[u8],
    ifd: &Directory,
    shape: Shape,
    area: Crop,
    limits: Limits,
    path: &Path,
) -> Result<RawSamples, IoError> {
    check_size(bytes, shape, limits, path)?;
    let Crop { row: top, col: left, rows: height, cols: width } = area;
    let len = height * width * shape.planes;
    let mut digital = vec![0u16; if shape.float { 0 } else { len }];
    let mut analog = vec![0f32; if shape.float { len } else { 0 }];

    let rows_at = interleaved(ifd, tags::ROW_INTERLEAVE_FACTOR, shape.rows, path)?;
    let cols_at = interleaved(ifd, tags::COLUMN_INTERLEAVE_FACTOR, shape.cols, path)?;
    let chunks = chunks(ifd, shape, path)?;
    if shape.coding == Coding::JpegXl {
        let at_once = rayon::current_num_threads().min(chunks.list.len()) as u64;
        let memory = jxl::memory(chunks.size(shape)).saturating_mul(at_once);
        let have = assumed_len(shape.coding, bytes.len() as u64);
        limits.check(path, "the strips or tiles that are unpacked at once", memory, have)?;
    }
    // Enough for all threads, and few in memory.
    for batch in chunks.list.chunks(4 * rayon::current_num_threads()) {
        let read = |chunk| content(bytes, ifd, shape, &chunks, chunk, limits, path);
        // The first error in their order is reported: the same for any number of threads.
        let contents: Vec<Result<Content<'_>, IoError>> = batch.par_iter().map(read).collect();
        for (chunk, content) in batch.iter().zip(contents) {
            let content = content?;
            for (r, row) in rows_at.iter().skip(chunk.row).take(chunks.rows).enumerate() {
                let Some(row) = row.checked_sub(top).filter(|r| *r < height) else { continue };
                let cols = cols_at.iter().skip(chunk.col).take(chunks.cols).enumerate();
                let within = cols.filter_map(|(c, col)| Some((c, col.checked_sub(left)?)));
                let places = within.filter(|(_, col)| *col < width).flat_map(|(c, col)| {
                    (0..shape.planes).map(move |p| (c * shape.planes + p, (p * height + row) * width + col))
                });
                match content.row(r) {
                    Row::Samples(s) => put(&mut digital, places, |i| s.get(i).copied()),
                    Row::Shares(s) if shape.float => put(&mut analog, places, |i| s.get(i).copied()),
                    Row::Shares(s) => {
                        let white = f32::from(u16::MAX >> (16 - shape.bits));
                        let digital_number = |share: &f32| (share * white).round().clamp(0.0, white) as u16;
                        put(&mut digital, places, |i| s.get(i).map(digital_number));
                    }
                    Row::Bytes(b, big) if shape.float => {
                        put(&mut analog, places, |i| Some(float(b, i, shape.bits, big)));
                    }
                    Row::Bytes(b, big) => {
                        put(&mut digital, places, |i| Some(integer(b, i, shape.bits, big)));
                    }
                }
            }
        }
    }
    if let Some(i) = analog.iter().position(|v| !v.is_finite()) {
        let (plane, value) = (height * width, analog.get(i).copied().unwrap_or(f32::NAN));
        let (channel, place) = ((i / plane).to_string(), [i % plane / width, i % width]);
        return Err(IoError::pixel(path, channel, place, value, "a finite number"));
    }
    Ok(if shape.float { RawSamples::Analog(analog) } else { RawSamples::Digital(digital) })
}

/// Puts samples to their places, those that are there.
fn put<T>(into: &mut [T], places: impl Iterator<Item = (usize, usize)>, sample: impl Fn(usize) -> Option<T>) {
    for (from, to) in places {
        if let (Some(v), Some(sample)) = (into.get_mut(to), sample(from)) {
            *v = sample;
        }
    }
}

/// Which rows, or columns, of the image are stored, in their order: with a factor `n` first every `n`th from the first, then
/// every `n`th from the second, and so on (DNG 1.7). So the colours of a mosaic lie apart.
fn interleaved(ifd: &Directory, tag: u16, count: usize, path: &Path) -> Result<Vec<usize>, IoError> {
    let factor = ifd.size(tag).unwrap_or(1);
    if factor == 0 || factor > count {
        let name =
            if tag == tags::ROW_INTERLEAVE_FACTOR { "RowInterleaveFactor" } else { "ColumnInterleaveFactor" };
        return Err(IoError::field(path, name, factor.to_string(), format!("1 to {count}")));
    }
    Ok((0..factor).flat_map(|first| (first..count).step_by(factor)).collect())
}

/// What the file cannot hold is refused before memory is taken.
fn check_size(bytes: &[u8], shape: Shape, limits: Limits, path: &Path) -> Result<(), IoError> {
    const WHAT: &str = "the raw image";
    let have = bytes.len() as u64;
    let samples = [shape.rows, shape.cols, shape.planes]
        .iter()
        .try_fold(1u64, |product, &n| product.checked_mul(n as u64))
        .unwrap_or(u64::MAX);
    let least_bits = match shape.coding {
        Coding::None => shape.bits as u64,
        // One bit for a sample that is as predicted.
        Coding::LosslessJpeg => 1,
        Coding::Deflate | Coding::JpegXl => 0,
    };
    let need = samples.checked_mul(least_bits).map_or(u64::MAX, |bits| bits / 8);
    if need > have {
        return Err(IoError::truncated(path, WHAT, need, have));
    }
    let memory = samples.saturating_mul(if shape.float { 4 } else { 2 });
    limits.check(path, WHAT, memory, assumed_len(shape.coding, have))
}

/// The length of a file as its limits see it. A uniform JPEG XL image of any size takes a few bytes, so a minimum file
/// length is assumed.
fn assumed_len(coding: Coding, file_len: u64) -> u64 {
    const JPEG_XL_BYTES: u64 = 256 << 20;
    if coding == Coding::JpegXl { file_len.max(JPEG_XL_BYTES / LARGEST_EXPANSION) } else { file_len }
}

struct Chunk {
    row: usize,
    col: usize,
    offset: usize,
    /// Bytes in the file, where they are stated.
    len: Option<usize>,
}

/// Strips or tiles, all of one size.
struct Chunks {
    rows: usize,
    cols: usize,
    list: Vec<Chunk>,
}

impl Chunks {
    /// Of a strip or tile, the last of which may have fewer rows.
    fn size(&self, shape: Shape) -> jxl::Size {
        jxl::Size { least_rows: self.rows, most_rows: self.rows, cols: self.cols, planes: shape.planes }
    }
}

fn chunks(ifd: &Directory, shape: Shape, path: &Path) -> Result<Chunks, IoError> {
    let tiled = ifd.size(tags::TILE_WIDTH).is_some();
    let (rows, cols, tag, count_tag, field) = if tiled {
        let (rows, cols) =
            (ifd.size(tags::TILE_LENGTH).unwrap_or(0), ifd.size(tags::TILE_WIDTH).unwrap_or(0));
        (rows, cols, tags::TILE_OFFSETS, tags::TILE_BYTE_COUNTS, "TileOffsets")
    } else {
        let rows = ifd.size(tags::ROWS_PER_STRIP).unwrap_or(shape.rows).min(shape.rows);
        (rows, shape.cols, tags::STRIP_OFFSETS, tags::STRIP_BYTE_COUNTS, "StripOffsets")
    };
    if rows == 0 || cols == 0 {
        let found = format!("{rows} × {cols}");
        return Err(IoError::field(path, "the strip or tile size", found, "more than 0"));
    }
    let (down, across) = (shape.rows.div_ceil(rows), shape.cols.div_ceil(cols));
    let offsets = ifd.integers(tag).unwrap_or_default();
    if down.checked_mul(across) != Some(offsets.len()) {
        let found = format!("{} long", offsets.len());
        return Err(IoError::field(path, field, found, format!("{down} × {across} offsets")));
    }
    let lens = ifd.integers(count_tag).unwrap_or_default();
    let chunk = |(i, offset): (usize, &u64)| Chunk {
        row: i / across * rows,
        col: i % across * cols,
        offset: *offset as usize,
        len: lens.get(i).map(|n| *n as usize),
    };
    Ok(Chunks { rows, cols, list: offsets.iter().enumerate().map(chunk).collect() })
}

/// A strip or tile, decompressed.
enum Content<'a> {
    /// Rows of so many bytes, and whether the most significant is first.
    Bytes(Cow<'a, [u8]>, usize, bool),
    /// Rows of so many samples.
    Samples(Vec<u16>, usize),
    /// The same as shares of the largest number, or as they are where they are floating point.
    Shares(Vec<f32>, usize),
}

enum Row<'a> {
    Bytes(&'a [u8], bool),
    Samples(&'a [u16]),
    Shares(&'a [f32]),
}

impl Content<'_> {
    fn row(&self, r: usize) -> Row<'_> {
        match self {
            Self::Bytes(bytes, len, big) => Row::Bytes(bytes.chunks(*len).nth(r).unwrap_or_default(), *big),
            Self::Samples(samples, len) => Row::Samples(samples.chunks(*len).nth(r).unwrap_or_default()),
            Self::Shares(shares, len) => Row::Shares(shares.chunks(*len).nth(r).unwrap_or_default()),
        }
    }
}

fn content<'a>(
    bytes: &'a [u8],
    ifd: &Directory,
    shape: Shape,
    chunks: &Chunks,
    chunk: &Chunk,
    limits: Limits,
    path: &Path,
) -> Result<Content<'a>, IoError> {
    let have = bytes.len() as u64;
    let truncated = |need: u64| IoError::truncated(path, "the raw image", need, have);
    // The last strip ends with the image; tiles are always whole, but a writer may have cut the last ones.
    let rows = chunks.rows.min(shape.rows - chunk.row);
    let samples = chunks.cols.checked_mul(shape.planes).ok_or_else(|| truncated(u64::MAX))?;
    let row_bytes = samples.checked_mul(shape.bits).ok_or_else(|| truncated(u64::MAX))?.div_ceil(8);
    let bytes_from = |len: usize| {
        let end = chunk.offset.saturating_add(len);
        bytes.get(chunk.offset..end).ok_or_else(|| truncated(end as u64))
    };
    let needed = rows.checked_mul(row_bytes).ok_or_else(|| truncated(u64::MAX))?;
    if shape.coding == Coding::None {
        return Ok(Content::Bytes(Cow::Borrowed(bytes_from(needed)?), row_bytes, ifd.big_endian));
    }
    let len = chunk
        .len
        .ok_or_else(|| IoError::field(path, "the byte counts", "too short", "one for every strip or tile"))?;
    let coded = bytes_from(len)?;
    let place = format!("the strip or tile at row {}, column {} (counted from 0)", chunk.row, chunk.col);
    let wrong = |what: String| IoError::decode(path, "DNG", format!("{place}: {what}"));
    if shape.coding == Coding::LosslessJpeg {
        let (least, most) = (rows.checked_mul(samples), chunks.rows.checked_mul(samples));
        let (Some(least), Some(most)) = (least, most) else { return Err(truncated(u64::MAX)) };
        let decoded = ljpeg::decode(coded, least..=most).map_err(|m| wrong(format!("lossless JPEG: {m}")))?;
        return Ok(Content::Samples(decoded, samples));
    }
    if shape.coding == Coding::JpegXl {
        let size = jxl::Size { least_rows: rows, ..chunks.size(shape) };
        let decoded = file::guarded(path, "DNG", || {
            jxl::decode(coded, size).map_err(|m| wrong(format!("JPEG XL: {m}")))
        })?;
        return Ok(Content::Shares(decoded, samples));
    }
    let code = ifd.size(tags::PREDICTOR).unwrap_or(1);
    let predictor = Predictor::of(code, shape.planes)
        .filter(|p| match p {
            Predictor::None => true,
            Predictor::Difference(_) => !shape.float && matches!(shape.bits, 8 | 16),
            Predictor::FloatingPoint(_) => shape.float,
        })
        .ok_or_else(|| {
            let expected =
                "1 (none); 2, 34892 or 34893 with 8 or 16 bits; 3, 34894 or 34895 with floating point";
            IoError::field(path, "Predictor", code.to_string(), expected)
        })?;
    limits.check(path, "a strip or tile", needed as u64, len as u64)?;
    let mut inflated = Vec::new();
    flate2::read::ZlibDecoder::new(coded)
        .take(needed as u64)
        .read_to_end(&mut inflated)
        .map_err(|e| wrong(format!("Deflate: {e}")))?;
    if inflated.len() < needed {
        return Err(wrong(format!("Deflate: it has {} bytes of {needed}", inflated.len())));
    }
    for row in inflated.chunks_exact_mut(row_bytes) {
        predictor.undo(row, shape.bits / 8, ifd.big_endian);
    }
    let big = ifd.big_endian || matches!(predictor, Predictor::FloatingPoint(_));
    Ok(Content::Bytes(Cow::Owned(inflated), row_bytes, big))
}
