//! Uncompressed samples in strips or tiles.

use std::path::Path;

use smalti::sensor::RawSamples;

use crate::IoError;
use crate::tiff_tags::{self as tags, Ifd, Tiff};

/// How the samples of an image lie in the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    pub(super) rows: usize,
    pub(super) cols: usize,
    pub(super) planes: usize,
    pub(super) bits: usize,
    pub(super) float: bool,
}

/// The part of the image that is light-sensitive: rows and columns from, to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Area {
    pub(super) top: usize,
    pub(super) left: usize,
    pub(super) bottom: usize,
    pub(super) right: usize,
}

/// Samples of the area, ordered plane, row, column.
pub(super) fn decode(
    tiff: Tiff<'_>,
    ifd: &Ifd<'_>,
    shape: Shape,
    area: Area,
    path: &Path,
) -> Result<RawSamples, IoError> {
    let have = tiff.bytes().len() as u64;
    let truncated =
        |need: u64| IoError::Truncated { path: path.to_owned(), what: "the raw image", need, have };
    // Nothing is compressed: what the file cannot hold is refused before memory is taken.
    let need = [shape.rows, shape.cols, shape.planes, shape.bits]
        .iter()
        .try_fold(1u64, |product, &n| product.checked_mul(n as u64))
        .map_or(u64::MAX, |bits| bits / 8);
    if need > have {
        return Err(truncated(need));
    }
    let (height, width) = (area.bottom - area.top, area.right - area.left);
    let len = height * width * shape.planes;
    let mut digital = vec![0u16; if shape.float { 0 } else { len }];
    let mut analog = vec![0f32; if shape.float { len } else { 0 }];

    let chunks = chunks(ifd, shape, path)?;
    for chunk in chunks.list {
        let samples = chunks.cols.saturating_mul(shape.planes);
        let row_bytes = samples.saturating_mul(shape.bits).div_ceil(8);
        for r in 0..chunks.rows.min(shape.rows - chunk.row) {
            let start = chunk.offset.saturating_add(r.saturating_mul(row_bytes));
            let end = start.saturating_add(row_bytes);
            let bytes = tiff.bytes().get(start..end).ok_or_else(|| truncated(end as u64))?;
            let row = chunk.row + r;
            if row < area.top || row >= area.bottom {
                continue;
            }
            let from = area.left.max(chunk.col);
            let to = area.right.min(chunk.col.saturating_add(chunks.cols));
            for col in from..to {
                for p in 0..shape.planes {
                    let i = (col - chunk.col) * shape.planes + p;
                    let at = (p * height + row - area.top) * width + col - area.left;
                    if shape.float {
                        if let Some(v) = analog.get_mut(at) {
                            *v = float(bytes, i, tiff.big_endian());
                        }
                    } else if let Some(v) = digital.get_mut(at) {
                        *v = integer(bytes, i, shape.bits, tiff.big_endian());
                    }
                }
            }
        }
    }
    if let Some(i) = analog.iter().position(|v| !v.is_finite()) {
        return Err(IoError::Pixel {
            path: path.to_owned(),
            channel: (i / (height * width).max(1)).to_string(),
            row: i / width.max(1) % height.max(1),
            col: i % width.max(1),
            value: f64::from(analog.get(i).copied().unwrap_or(f32::NAN)),
            expected: "a finite number",
        });
    }
    Ok(if shape.float { RawSamples::Analog(analog) } else { RawSamples::Digital(digital) })
}

struct Chunk {
    row: usize,
    col: usize,
    offset: usize,
}

/// Strips or tiles, all of one size.
struct Chunks {
    rows: usize,
    cols: usize,
    list: Vec<Chunk>,
}

fn chunks(ifd: &Ifd<'_>, shape: Shape, path: &Path) -> Result<Chunks, IoError> {
    let tiled = ifd.size(tags::TILE_WIDTH).is_some();
    let (rows, cols, tag, field) = if tiled {
        let (rows, cols) =
            (ifd.size(tags::TILE_LENGTH).unwrap_or(0), ifd.size(tags::TILE_WIDTH).unwrap_or(0));
        (rows, cols, tags::TILE_OFFSETS, "TileOffsets")
    } else {
        let rows = ifd.size(tags::ROWS_PER_STRIP).unwrap_or(shape.rows).min(shape.rows);
        (rows, shape.cols, tags::STRIP_OFFSETS, "StripOffsets")
    };
    if rows == 0 || cols == 0 {
        return Err(IoError::field(
            path,
            "the strip or tile size",
            format!("{rows} × {cols}"),
            "more than 0",
        ));
    }
    let (down, across) = (shape.rows.div_ceil(rows), shape.cols.div_ceil(cols));
    let offsets = ifd.numbers(tag).unwrap_or_default();
    if offsets.len() != down * across {
        let found = format!("{} long", offsets.len());
        return Err(IoError::field(path, field, found, format!("{} offsets", down * across)));
    }
    let chunk = |(i, offset): (usize, &f64)| Chunk {
        row: i / across * rows,
        col: i % across * cols,
        offset: *offset as usize,
    };
    Ok(Chunks { rows, cols, list: offsets.iter().enumerate().map(chunk).collect() })
}

/// Sample `i` of a row. Sizes below 16 bits are packed, the most significant bit first, in either byte order.
fn integer(bytes: &[u8], i: usize, bits: usize, big_endian: bool) -> u16 {
    let byte = |at: usize| u32::from(bytes.get(at).copied().unwrap_or(0));
    match bits {
        8 => byte(i) as u16,
        16 => {
            let (a, b) = (byte(2 * i) as u16, byte(2 * i + 1) as u16);
            if big_endian { a << 8 | b } else { b << 8 | a }
        }
        _ => {
            let at = i * bits / 8;
            let three = byte(at) << 16 | byte(at + 1) << 8 | byte(at + 2);
            let shift = 24 - bits - i * bits % 8;
            (three >> shift & ((1 << bits) - 1)) as u16
        }
    }
}

fn float(bytes: &[u8], i: usize, big_endian: bool) -> f32 {
    let four: [u8; 4] = bytes.get(4 * i..4 * i + 4).and_then(|b| b.try_into().ok()).unwrap_or_default();
    if big_endian { f32::from_be_bytes(four) } else { f32::from_le_bytes(four) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_samples_begin_with_the_highest_bit() {
        let bytes = [0xab, 0xcd, 0xef, 0x12];
        assert_eq!(integer(&bytes, 0, 12, false), 0xabc);
        assert_eq!(integer(&bytes, 1, 12, true), 0xdef);
        assert_eq!(integer(&bytes, 0, 14, false), 0xabcd >> 2);
        assert_eq!(integer(&bytes, 1, 14, false), ((0xabcd_ef12u32 >> 4) & 0x3fff) as u16);
        assert_eq!(integer(&bytes, 2, 10, false), ((0xabcd_ef12u32 >> 2) & 0x3ff) as u16);
        assert_eq!(integer(&bytes, 1, 16, true), 0xef12);
        assert_eq!(integer(&bytes, 1, 16, false), 0x12ef);
    }
}
