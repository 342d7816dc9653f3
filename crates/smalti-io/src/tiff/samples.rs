//! The samples of one image of a TIFF file: strips or tiles, compressed or not.

use std::path::Path;

use super::directory::Directory;
use super::tags;
use crate::raster::{Axis, Blocks, Cube, Filter, Kind, Place, Raster, Shared, Storage};
use crate::{IoError, Limits};

/// The samples of an image, each a band.
pub(crate) fn cube<'a>(
    directory: &Directory,
    source: &Shared<'a>,
    path: &Path,
    limits: Limits,
) -> Result<Cube<'a>, IoError> {
    let wrong = |field: &str, found: String, expected: &str| IoError::field(path, field, found, expected);
    let length = |tag: u16, name: &str| {
        let n = directory.size(tag).filter(|n| *n > 0);
        n.ok_or_else(|| wrong(name, "absent or 0".into(), "a length above 0"))
    };
    let rows = length(tags::IMAGE_LENGTH, "ImageLength")?;
    let cols = length(tags::IMAGE_WIDTH, "ImageWidth")?;
    let samples = directory.size(tags::SAMPLES_PER_PIXEL).unwrap_or(1);
    let same = |tag: u16, default: u64, name: &str| match directory.integers(tag) {
        None => Ok(default),
        Some(all) => match all.as_slice() {
            [first, rest @ ..] if rest.iter().all(|v| v == first) => Ok(*first),
            _ => Err(wrong(name, format!("{all:?}"), "the same for all samples")),
        },
    };
    let bits = same(tags::BITS_PER_SAMPLE, 1, "BitsPerSample")?;
    let format = same(tags::SAMPLE_FORMAT, 1, "SampleFormat")?;
    let kind = match (format, bits) {
        (1, 8) => Kind::U8,
        (1, 16) => Kind::U16,
        (1, 32) => Kind::U32,
        (2, 8) => Kind::I8,
        (2, 16) => Kind::I16,
        (2, 32) => Kind::I32,
        (3, 16) => Kind::F16,
        (3, 32) => Kind::F32,
        (3, 64) => Kind::F64,
        _ => {
            let found = format!("{bits} bits of format {format}");
            let expected = "8, 16 or 32 bits, or 16, 32 or 64 bits floating point";
            return Err(wrong("BitsPerSample", found, expected));
        }
    };
    let packed = match directory.integer(tags::COMPRESSION).unwrap_or(1) {
        1 => None,
        5 => Some(Filter::Lzw),
        8 | 32946 => Some(Filter::Deflate),
        32773 => Some(Filter::PackBits),
        other => return Err(wrong("Compression", other.to_string(), "none, LZW, Deflate or PackBits")),
    };
    let predictor = match directory.integer(tags::PREDICTOR).unwrap_or(1) {
        1 => None,
        2 => Some(Filter::Differences),
        3 if matches!(kind, Kind::F16 | Kind::F32 | Kind::F64) => Some(Filter::FloatDifferences),
        other => return Err(wrong("Predictor", other.to_string(), "1, 2, or 3 for floating point")),
    };
    // The predictor has no meaning for samples that are not compressed.
    let filters: Vec<Filter> = packed.map_or(Vec::new(), |p| predictor.into_iter().chain([p]).collect());
    if directory.integer(tags::FILL_ORDER).unwrap_or(1) != 1 {
        return Err(wrong("FillOrder", "2".into(), "1"));
    }
    let planar = directory.integer(tags::PLANAR_CONFIGURATION) == Some(2) && samples > 1;
    let tiled = directory.has(tags::TILE_WIDTH);
    let (high, wide, offsets, counts) = if tiled {
        let (high, wide) = (length(tags::TILE_LENGTH, "TileLength")?, length(tags::TILE_WIDTH, "TileWidth")?);
        (high, wide, tags::TILE_OFFSETS, tags::TILE_BYTE_COUNTS)
    } else {
        let high = directory.size(tags::ROWS_PER_STRIP).unwrap_or(rows).clamp(1, rows);
        (high, cols, tags::STRIP_OFFSETS, tags::STRIP_BYTE_COUNTS)
    };
    let planes = if planar { samples } else { 1 };
    let (down, across) = (rows.div_ceil(high), cols.div_ceil(wide));
    let expected = down.checked_mul(across).and_then(|n| n.checked_mul(planes)).unwrap_or(usize::MAX);
    let offsets = directory.integers(offsets).unwrap_or_default();
    let counts = directory.integers(counts).unwrap_or_default();
    let raster = Raster {
        kind,
        big_endian: directory.big_endian || filters.contains(&Filter::FloatDifferences),
        bands: samples,
        rows,
        cols,
        order: [Axis::Row, Axis::Col, Axis::Band],
    };
    let size = [if planar { 1 } else { samples }, high, wide];
    // Old writers leave out the length of the only strip.
    let counts = if counts.is_empty() && packed.is_none() && offsets.len() == 1 {
        let block = Raster { bands: size[0], cols: wide, ..raster };
        vec![block.bytes().unwrap_or(u64::MAX)]
    } else {
        counts
    };
    if samples == 0 || offsets.len() != expected || counts.len() != expected {
        let found = format!("{} offsets and {} lengths", offsets.len(), counts.len());
        let expected = format!("{expected} of each for {rows} × {cols} pixels of {samples} samples");
        return Err(IoError::field(path, "the strips or tiles", found, expected));
    }
    let places =
        offsets.into_iter().zip(counts).map(|(offset, bytes)| Place { offset, bytes, skipped: 0 }).collect();
    let strides = [down * across, across, 1];
    let blocks = Blocks { size, strides, places, filters, heads: [].into(), unpack: None, cut: !tiled };
    let cube = Cube { source: Shared::clone(source), raster, storage: Storage::Blocks(blocks) };
    cube.check(path, "a strip or tile", limits)?;
    Ok(cube)
}
