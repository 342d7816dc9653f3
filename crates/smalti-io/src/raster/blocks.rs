//! Samples in blocks of equal size, each compressed by itself or not compressed: the chunks of HDF5, the strips and tiles of TIFF, the
//! lines and tiles of OpenEXR.

use std::io;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::copy::{Strides, Target, gather};
use super::filters::{Filter, Scratch};
use super::kind::Sample;
use super::run::{Raster, gathered};
use super::source::Source;
use super::{Axis, Bad, Part};
use crate::{IoError, Limits};

/// Bytes between lines that are read with them.
const LINE_GAP_BYTES: u64 = 64;

/// The places of the blocks of a cube, and the filters that were applied to them. Blocks have the type of sample and the order of axes
/// of the cube.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    /// Bands, rows and columns of a block, none of them 0.
    pub(crate) size: [usize; 3],
    /// The distances in `places` from a block to the next along bands, rows and columns.
    pub(crate) strides: [usize; 3],
    pub(crate) places: Arc<[Place]>,
    /// The headers of all blocks, each of the same length. A block with another header is not the expected one.
    pub(crate) heads: Arc<[u8]>,
    /// In the order in which they were applied.
    pub(crate) filters: Vec<Filter>,
    /// Unpacks blocks in place of filters.
    pub(crate) unpack: Option<Arc<dyn Unpack>>,
    /// Whether blocks that reach beyond the last row are stored only up to it, as strips are, and not whole.
    pub(crate) cut: bool,
}

/// Unpacks the blocks of a format.
pub(crate) trait Unpack: std::fmt::Debug + Send + Sync {
    /// Fills `out` with the samples of a block, by its number among the places, from what is stored of it. An error in words.
    fn unpack(&self, block: usize, stored: &[u8], out: &mut Vec<u8>) -> Result<(), String>;
}

/// A block in a file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) offset: u64,
    pub(crate) bytes: u64,
    /// Bit `i` is set if the filter `i` was not used.
    pub(crate) skipped: u32,
}

impl Blocks {
    /// Whether blocks are unpacked before they are read.
    pub(super) fn packed(&self) -> bool {
        !self.filters.is_empty() || self.unpack.is_some()
    }

    /// Compares what is declared with the length of the file; `what` is how a message calls a block.
    pub(super) fn check(
        &self,
        cube: &Raster,
        source: &dyn Source,
        (path, what): (&Path, &'static str),
        limits: Limits,
    ) -> Result<(), IoError> {
        let truncated = |need, have| Err(IoError::truncated(path, what, need, have));
        let (below, last) = (self.strides[1], cube.rows.div_ceil(self.size[1]).saturating_sub(1));
        for (i, place) in self.places.iter().enumerate() {
            let row = if self.cut && last > 0 { i / below.max(1) % (last + 1) } else { 0 };
            let bytes = self.shape(cube, row).bytes().unwrap_or(u64::MAX);
            let plain = !self.packed();
            let end = place.offset.saturating_add(if plain { bytes } else { place.bytes });
            if end > source.len() {
                return truncated(end, source.len());
            }
            if plain && place.bytes < bytes {
                return truncated(bytes, place.bytes);
            }
            // What a format unpacks itself, it has compared with the length of the file.
            if self.unpack.is_none() {
                limits.check(path, what, bytes, place.bytes)?;
            }
        }
        Ok(())
    }

    /// The samples of a block, by its number among the blocks of a column.
    fn shape(&self, cube: &Raster, row: usize) -> Raster {
        let [bands, mut rows, cols] = self.size;
        if self.cut {
            rows = rows.min(cube.rows.saturating_sub(row * rows));
        }
        Raster { bands, rows, cols, ..*cube }
    }

    /// Reads a part, whose bands are in the same blocks, to its place. If `shared` is true, all threads unpack.
    pub(super) fn read_into<S: Sample>(
        &self,
        cube: &Raster,
        source: &dyn Source,
        part: &Part<'_>,
        mut target: Target<'_, '_, S>,
        (scratch, shared): (&mut Scratch, bool),
    ) -> Result<(), Bad> {
        let [high_band, high, wide] = self.size;
        let band = part.bands.first().map_or(0, |b| b / high_band);
        let places: Vec<usize> = part.bands.iter().map(|b| b % high_band).collect();
        let rows = part.rows.start / high..part.rows.end.div_ceil(high);
        let cols = part.cols.start / wide..part.cols.end.div_ceil(wide);
        let all: Vec<[usize; 2]> = rows.flat_map(|row| cols.clone().map(move |col| [row, col])).collect();
        let index =
            |[row, col]: [usize; 2]| band * self.strides[0] + row * self.strides[1] + col * self.strides[2];
        // Copies what is wanted of a block.
        let mut copy = |at @ [row, col]: [usize; 2], from: (&dyn Source, u64), window: &mut Vec<u8>| {
            let [top, left] = [row * high, col * wide];
            let rows = part.rows.start.max(top)..part.rows.end.min(top + high);
            let cols = part.cols.start.max(left)..part.cols.end.min(left + wide);
            let local = Part {
                bands: &places,
                rows: rows.start - top..rows.end - top,
                cols: cols.start - left..cols.end - left,
            };
            let above = (rows.start - part.rows.start) * target.width;
            let mut below: Vec<&mut [S]> =
                target.bands.iter_mut().map(|p| p.get_mut(above..).unwrap_or_default()).collect();
            let col = target.col + cols.start - part.cols.start;
            let target = Target { bands: &mut below, width: target.width, col };
            self.shape(cube, at[0]).read_into(from, &local, target, window)
        };
        if !self.packed() {
            if let Some((bytes, strides)) = self.window(cube, source, part, &mut scratch.window)? {
                let extent = (places.as_slice(), part.rows.len(), part.cols.len());
                return gathered(gather(bytes, (cube.kind, cube.big_endian), strides, extent, &mut target));
            }
            let mut head = vec![0; self.head_bytes()];
            for at in all {
                let offset = self.place(index(at))?.offset;
                source.read_at(offset.saturating_sub(head.len() as u64), &mut head)?;
                self.check_head(index(at), &head)?;
                copy(at, (source, offset), &mut scratch.window)?;
            }
            return Ok(());
        }
        if !shared {
            for at in all {
                self.unpacked(&self.shape(cube, at[0]), source, index(at), scratch)?;
                let Scratch { block, window, .. } = scratch;
                copy(at, (&block.as_slice(), 0), window)?;
            }
            return Ok(());
        }
        let mut several: Vec<Scratch> = Vec::new();
        several.resize_with(2 * rayon::current_num_threads(), Scratch::default);
        for some in all.chunks(several.len()) {
            let unpacked: Vec<Result<(), Bad>> = several
                .par_iter_mut()
                .zip(some)
                .map(|(scratch, &at)| self.unpacked(&self.shape(cube, at[0]), source, index(at), scratch))
                .collect();
            unpacked.into_iter().collect::<Result<(), Bad>>()?;
            for (scratch, &at) in several.iter().zip(some) {
                copy(at, (&scratch.block.as_slice(), 0), &mut Vec::new())?;
            }
        }
        Ok(())
    }

    /// Lines at equal distances, most of whose samples are wanted, are read at once with the bytes between them: read one by one, each
    /// line would cost a call to the system.
    fn window<'s>(
        &self,
        cube: &Raster,
        source: &dyn Source,
        part: &Part<'_>,
        buffer: &'s mut Vec<u8>,
    ) -> Result<Option<(&'s [u8], Strides)>, Bad> {
        let line = cube.bands * cube.cols;
        let lines =
            cube.order == [Axis::Row, Axis::Band, Axis::Col] && self.size == [cube.bands, 1, cube.cols];
        let most = 2 * part.bands.len() * part.cols.len() >= line;
        let places = self.places.get(part.rows.clone()).unwrap_or_default();
        let [first, second, ..] = places else { return Ok(None) };
        let (size, pitch) = (cube.kind.size() as u64, second.offset.saturating_sub(first.offset));
        let line_bytes = line as u64 * size;
        let gap = pitch.checked_sub(line_bytes);
        let near = gap.is_some_and(|bytes| bytes <= LINE_GAP_BYTES.min(line_bytes) && bytes % size == 0);
        let equal = || places.is_sorted_by(|a, b| a.offset.checked_add(pitch) == Some(b.offset));
        if source.memory().is_some() || !lines || !most || !near || !equal() {
            return Ok(None);
        }
        let (row, head) = ((pitch / size) as usize, self.head_bytes());
        buffer.resize(head + ((places.len() - 1) * row + line) * size as usize, 0);
        source.read_at(first.offset.saturating_sub(head as u64), buffer)?;
        for (block, bytes) in part.rows.clone().zip(buffer.chunks(row * size as usize)) {
            self.check_head(block, bytes.get(..head).unwrap_or_default())?;
        }
        let samples = buffer.get(head..).unwrap_or_default();
        Ok(Some((samples, Strides { first: part.cols.start, band: cube.cols, row, col: 1 })))
    }

    fn head_bytes(&self) -> usize {
        self.heads.len().checked_div(self.places.len()).unwrap_or(0)
    }

    fn check_head(&self, block: usize, head: &[u8]) -> Result<(), Bad> {
        match self.heads.get(block * head.len()..).is_some_and(|heads| heads.starts_with(head)) {
            true => Ok(()),
            false => Err(Bad::Block(format!("the header of block {block} is that of another block"))),
        }
    }

    fn place(&self, index: usize) -> Result<Place, Bad> {
        self.places.get(index).copied().ok_or(Bad::Io(io::ErrorKind::UnexpectedEof.into()))
    }

    /// A block as it was before it was written, in `scratch.block`.
    fn unpacked(
        &self,
        shape: &Raster,
        source: &dyn Source,
        index: usize,
        scratch: &mut Scratch,
    ) -> Result<(), Bad> {
        let place = self.place(index)?;
        scratch.block.resize(usize::try_from(place.bytes).unwrap_or(usize::MAX), 0);
        source.read_at(place.offset, &mut scratch.block)?;
        if let Some(format) = &self.unpack {
            return scratch.replaced(shape, |stored, out| format.unpack(index, stored, out));
        }
        let used = self
            .filters
            .iter()
            .enumerate()
            .filter(|(i, _)| place.skipped.checked_shr(*i as u32).unwrap_or(0) & 1 == 0);
        scratch.undo(used.map(|(_, filter)| *filter), shape)
    }
}
