//! The samples of one image of a TIFF file: strips or tiles, compressed or not.

use std::path::Path;

use flate2::{Decompress, FlushDecompress};
use weezl::BitOrder;

use super::directory::Directory;
use crate::raster::{Axis, Bad, Kind, Part, Raster, Source, Target, part};
use crate::tiff_tags as tags;
use crate::{IoError, Limits};

pub(super) const FILL_ORDER: u16 = 266;
pub(super) const PREDICTOR: u16 = 317;
pub(super) const TILE_BYTE_COUNTS: u16 = 325;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Compression {
    None,
    Lzw,
    Deflate,
    PackBits,
}

/// An image of equal samples.
#[derive(Debug, Clone)]
pub(super) struct Page {
    pub(super) rows: usize,
    pub(super) cols: usize,
    /// Samples of a pixel.
    pub(super) samples: usize,
    pub(super) kind: Kind,
    big_endian: bool,
    /// Whether each sample has strips or tiles of its own.
    pub(super) planar: bool,
    compression: Compression,
    predictor: u64,
    chunk_rows: usize,
    chunk_cols: usize,
    tiled: bool,
    /// Place and length of the strips or tiles.
    chunks: Vec<(u64, u64)>,
    limits: Limits,
}

impl Page {
    pub(super) fn new(
        directory: &Directory,
        source: &dyn Source,
        path: &Path,
        limits: Limits,
    ) -> Result<Self, IoError> {
        let wrong = |field: &str, found: String, expected: &str| IoError::field(path, field, found, expected);
        let length = |tag: u16, name: &str| {
            let n = directory.number(tag).and_then(|n| usize::try_from(n).ok()).filter(|n| *n > 0);
            n.ok_or_else(|| wrong(name, "absent or 0".into(), "a length above 0"))
        };
        let rows = length(tags::IMAGE_LENGTH, "ImageLength")?;
        let cols = length(tags::IMAGE_WIDTH, "ImageWidth")?;
        let samples = usize::try_from(directory.number(tags::SAMPLES_PER_PIXEL).unwrap_or(1)).unwrap_or(0);
        let same = |tag: u16, default: u64, name: &str| match directory.numbers(tag) {
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
                return Err(wrong(
                    "BitsPerSample",
                    found,
                    "8, 16 or 32 bits, or 16, 32 or 64 bits floating point",
                ));
            }
        };
        let compression = match directory.number(tags::COMPRESSION).unwrap_or(1) {
            1 => Compression::None,
            5 => Compression::Lzw,
            8 | 32946 => Compression::Deflate,
            32773 => Compression::PackBits,
            other => {
                return Err(wrong("Compression", other.to_string(), "none, LZW, Deflate or PackBits"));
            }
        };
        let predictor = directory.number(PREDICTOR).unwrap_or(1);
        let predictable = match predictor {
            1 | 2 => true,
            3 => matches!(kind, Kind::F16 | Kind::F32 | Kind::F64),
            _ => false,
        };
        if !predictable {
            return Err(wrong("Predictor", predictor.to_string(), "1, 2, or 3 for floating point"));
        }
        if directory.number(FILL_ORDER).unwrap_or(1) != 1 {
            return Err(wrong("FillOrder", "2".into(), "1"));
        }
        let planar = directory.number(tags::PLANAR_CONFIGURATION) == Some(2) && samples > 1;
        let tiled = directory.has(tags::TILE_WIDTH);
        let (chunk_rows, chunk_cols, offsets, counts) = if tiled {
            let (high, wide) =
                (length(tags::TILE_LENGTH, "TileLength")?, length(tags::TILE_WIDTH, "TileWidth")?);
            (high, wide, tags::TILE_OFFSETS, TILE_BYTE_COUNTS)
        } else {
            let rows_per_strip = directory.number(tags::ROWS_PER_STRIP).and_then(|n| usize::try_from(n).ok());
            let high = rows_per_strip.unwrap_or(rows).clamp(1, rows);
            (high, cols, tags::STRIP_OFFSETS, tags::STRIP_BYTE_COUNTS)
        };
        let planes = if planar { samples } else { 1 };
        let expected = rows.div_ceil(chunk_rows).checked_mul(cols.div_ceil(chunk_cols));
        let expected = expected.and_then(|n| n.checked_mul(planes)).unwrap_or(usize::MAX);
        let offsets = directory.numbers(offsets).unwrap_or_default();
        let counts = directory.numbers(counts).unwrap_or_default();
        let mut page = Self {
            rows,
            cols,
            samples,
            kind,
            big_endian: directory.big_endian,
            planar,
            compression,
            predictor,
            chunk_rows,
            chunk_cols,
            tiled,
            chunks: Vec::new(),
            limits,
        };
        // Old writers of one strip leave its length out.
        let counts = if counts.is_empty() && compression == Compression::None && offsets.len() == 1 {
            vec![page.chunk_bytes(0).unwrap_or(u64::MAX)]
        } else {
            counts
        };
        if samples == 0 || offsets.len() != expected || counts.len() != expected {
            let found = format!("{} places and {} lengths", offsets.len(), counts.len());
            let expected = format!("{expected} of each for {rows} × {cols} pixels of {samples} samples");
            return Err(IoError::field(path, "the strips or tiles", found, expected));
        }
        page.chunks = offsets.into_iter().zip(counts).collect();
        page.check(source, path)?;
        Ok(page)
    }

    /// Rows of the strip or tile; the last strip may be shorter.
    fn rows_of_chunk(&self, chunk_row: usize) -> usize {
        if self.tiled {
            self.chunk_rows
        } else {
            self.chunk_rows.min(self.rows - chunk_row * self.chunk_rows)
        }
    }

    /// Bytes of a strip or tile, unpacked.
    fn chunk_bytes(&self, chunk_row: usize) -> Option<u64> {
        let samples = if self.planar { 1 } else { self.samples as u64 };
        let pixels = (self.rows_of_chunk(chunk_row) as u64).checked_mul(self.chunk_cols as u64)?;
        pixels.checked_mul(samples)?.checked_mul(self.kind.size() as u64)
    }

    /// Compares what is declared with the length of the file.
    fn check(&self, source: &dyn Source, path: &Path) -> Result<(), IoError> {
        let (down, across) = self.grid();
        for (i, (at, len)) in self.chunks.iter().enumerate() {
            let bytes = self.chunk_bytes(i / across % down).unwrap_or(u64::MAX);
            if self.compression == Compression::None {
                let need = at.saturating_add(bytes);
                if need > source.len() || *len < bytes {
                    let have = if need > source.len() { source.len() } else { *len };
                    let need = if need > source.len() { need } else { bytes };
                    return Err(IoError::Truncated {
                        path: path.to_owned(),
                        what: "a strip or tile",
                        need,
                        have,
                    });
                }
            } else {
                if at.saturating_add(*len) > source.len() {
                    let (need, have) = (at.saturating_add(*len), source.len());
                    return Err(IoError::Truncated {
                        path: path.to_owned(),
                        what: "a strip or tile",
                        need,
                        have,
                    });
                }
                self.limits.check(path, "a strip or tile", bytes, *len)?;
            }
        }
        Ok(())
    }

    /// Strips or tiles from top to bottom and from left to right.
    fn grid(&self) -> (usize, usize) {
        (self.rows.div_ceil(self.chunk_rows), self.cols.div_ceil(self.chunk_cols))
    }

    /// The rows that are best read at once: those that are unpacked at once, or about a mebibyte.
    pub(super) fn rows_at_once(&self) -> (usize, bool) {
        if self.compression != Compression::None {
            return (self.chunk_rows, true);
        }
        let samples = if self.planar { 1 } else { self.samples };
        let row = self.cols.saturating_mul(samples).saturating_mul(self.kind.size());
        (((1 << 20) / row.max(1)).max(1), false)
    }

    /// Reads rows and columns of samples of this image, which share their strips or tiles, to where they belong.
    pub(super) fn read_into(
        &self,
        source: &dyn Source,
        wanted: &Part<'_>,
        planes: &mut [&mut [f32]],
        buffer: &mut Vec<u8>,
    ) -> Result<(), Bad> {
        let (down, across) = self.grid();
        let width = wanted.cols.len();
        let first_plane = if self.planar { wanted.bands.first().copied().unwrap_or(0) } else { 0 };
        let chunk_rows = wanted.rows.start / self.chunk_rows..wanted.rows.end.div_ceil(self.chunk_rows);
        let chunk_cols = wanted.cols.start / self.chunk_cols..wanted.cols.end.div_ceil(self.chunk_cols);
        for chunk_row in chunk_rows {
            let top = chunk_row * self.chunk_rows;
            let high = self.rows_of_chunk(chunk_row);
            let rows = wanted.rows.start.max(top)..wanted.rows.end.min(top + high);
            for chunk_col in chunk_cols.clone() {
                let left = chunk_col * self.chunk_cols;
                let cols = wanted.cols.start.max(left)..wanted.cols.end.min(left + self.chunk_cols);
                let index = (first_plane * down + chunk_row) * across + chunk_col;
                let Some((at, len)) = self.chunks.get(index).copied() else { continue };
                let mut raster = Raster {
                    offset: at,
                    kind: self.kind,
                    big_endian: self.big_endian,
                    bands: if self.planar { 1 } else { self.samples },
                    rows: high,
                    cols: self.chunk_cols,
                    order: [Axis::Row, Axis::Col, Axis::Band],
                };
                let unpacked;
                let mut from = source;
                if self.compression != Compression::None {
                    let packed = part(source, at, usize::try_from(len).unwrap_or(usize::MAX))?;
                    unpacked = self.unpacked(&packed, chunk_row)?;
                    from = &unpacked;
                    raster.offset = 0;
                    // The predictor of floating point leaves the first byte first.
                    raster.big_endian |= self.predictor == 3;
                }
                let local = Part {
                    bands: if self.planar { &[0] } else { wanted.bands },
                    rows: rows.start - top..rows.end - top,
                    cols: cols.start - left..cols.end - left,
                };
                let skipped = (rows.start - wanted.rows.start) * width;
                let mut below: Vec<&mut [f32]> =
                    planes.iter_mut().map(|p| p.get_mut(skipped..).unwrap_or_default()).collect();
                let target = Target { bands: &mut below, width, col: cols.start - wanted.cols.start };
                raster.read_into(from, &local, target, buffer)?;
            }
        }
        Ok(())
    }

    fn unpacked(&self, packed: &[u8], chunk_row: usize) -> Result<Vec<u8>, Bad> {
        let len = self.chunk_bytes(chunk_row).and_then(|n| usize::try_from(n).ok()).unwrap_or(usize::MAX);
        let short =
            |what: &str| Bad::Block(format!("a strip or tile does not unpack to {len} bytes: {what}"));
        let mut out = vec![0; len];
        match self.compression {
            Compression::Deflate => {
                let mut inflater = Decompress::new(true);
                inflater
                    .decompress(packed, &mut out, FlushDecompress::Finish)
                    .map_err(|e| short(&e.to_string()))?;
                if inflater.total_out() != len as u64 {
                    return Err(short("it ends before"));
                }
            }
            Compression::Lzw => {
                let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(BitOrder::Msb, 8);
                let (mut from, mut to) = (packed, out.as_mut_slice());
                while !to.is_empty() {
                    let step = decoder.decode_bytes(from, to);
                    step.status.map_err(|e| short(&e.to_string()))?;
                    if step.consumed_in == 0 && step.consumed_out == 0 {
                        return Err(short("it ends before"));
                    }
                    from = from.get(step.consumed_in..).unwrap_or_default();
                    to = to.get_mut(step.consumed_out..).unwrap_or_default();
                }
            }
            Compression::PackBits => unpack_bits(packed, &mut out).ok_or_else(|| short("it ends before"))?,
            Compression::None => {}
        }
        let samples = if self.planar { 1 } else { self.samples };
        let row = self.chunk_cols.saturating_mul(samples).saturating_mul(self.kind.size()).max(1);
        match self.predictor {
            2 => out.chunks_mut(row).for_each(|r| add_up(r, samples, self.kind.size(), self.big_endian)),
            3 => out.chunks_mut(row).for_each(|r| put_together(r, samples, self.kind.size())),
            _ => {}
        }
        Ok(out)
    }
}

/// PackBits (TIFF 6.0, section 9).
fn unpack_bits(packed: &[u8], out: &mut [u8]) -> Option<()> {
    let (mut from, mut to) = (packed, out);
    while !to.is_empty() {
        let (&head, rest) = from.split_first()?;
        let count;
        match head as i8 {
            -128 => {
                from = rest;
                continue;
            }
            n @ 0.. => {
                count = (n as usize + 1).min(to.len());
                to.get_mut(..count)?.copy_from_slice(rest.get(..count)?);
                from = rest.get(n as usize + 1..).unwrap_or_default();
            }
            n => {
                count = (1 + usize::from(n.unsigned_abs())).min(to.len());
                to.get_mut(..count)?.fill(*rest.first()?);
                from = rest.get(1..)?;
            }
        }
        to = to.get_mut(count..)?;
    }
    Some(())
}

/// Undoes horizontal differencing (TIFF 6.0, section 14) of samples of any size, taken as whole numbers.
fn add_up(row: &mut [u8], samples: usize, size: usize, big_endian: bool) {
    macro_rules! of {
        ($t:ty) => {{
            let (load, store): (fn(_) -> $t, fn($t) -> _) = if big_endian {
                (<$t>::from_be_bytes, <$t>::to_be_bytes)
            } else {
                (<$t>::from_le_bytes, <$t>::to_le_bytes)
            };
            let numbers = row.as_chunks_mut().0;
            for i in samples..numbers.len() {
                numbers[i] = store(load(numbers[i]).wrapping_add(load(numbers[i - samples])));
            }
        }};
    }
    match size {
        1 => of!(u8),
        2 => of!(u16),
        4 => of!(u32),
        _ => of!(u64),
    }
}

/// Undoes the predictor of floating point (TIFF Technical Note 3): differences of bytes, the first bytes of all samples first.
fn put_together(row: &mut [u8], samples: usize, size: usize) {
    for i in samples..row.len() {
        row[i] = row[i].wrapping_add(row[i - samples]);
    }
    let count = row.len() / size.max(1);
    let shuffled = row.to_vec();
    for (i, number) in row.chunks_exact_mut(size.max(1)).enumerate() {
        for (k, byte) in number.iter_mut().enumerate() {
            *byte = shuffled.get(k * count + i).copied().unwrap_or(0);
        }
    }
}
