//! Blocks of lines, and tiles, of OpenEXR (*Technical Introduction to OpenEXR*: "Chunk offset table").

use std::path::Path;
use std::sync::Arc;

use exr::block::UncompressedBlock;
use exr::block::chunk::Chunk;
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::{Compression, MetaData, SampleType, Vec2, f16};

use crate::file::caught;
use crate::raster::{Axis, Blocks, Cube, Kind, Place, Raster, Shared, Storage, Unpack, bytes_at};
use crate::{IoError, Limits};

/// Bytes of the longest header of a block.
const BLOCK_HEAD_BYTES: u64 = 24;

/// How samples are stored that can be read where they lie: lines that are not compressed, all channels of one type.
pub(super) fn plain(header: &Header) -> Option<Kind> {
    let types = || header.channels.list.iter().map(|c| c.sample_type);
    let first = types().next()?;
    let kind = match first {
        SampleType::F32 => Kind::F32,
        SampleType::F16 => Kind::F16,
        SampleType::U32 => Kind::U32,
    };
    let lines =
        header.blocks == BlockDescription::ScanLines && header.compression == Compression::Uncompressed;
    (lines && types().all(|t| t == first)).then_some(kind)
}

/// The wanted channels of a layer, or all channels if they are [`plain`]. The tables of the blocks of all layers follow the headers.
pub(super) fn cube<'a>(
    source: Shared<'a>,
    meta: MetaData,
    (layer, channels): (usize, Vec<usize>),
    tables: u64,
    (path, limits): (&Path, Limits),
) -> Result<Cube<'a>, IoError> {
    let absent = || IoError::field(path, "the image", "absent", "a layer");
    let header = meta.headers.get(layer).ok_or_else(absent)?;
    let Vec2(cols, rows) = header.layer_size;
    let Vec2(wide, high) = header.max_block_pixel_size();
    let (wide, high) = (wide.clamp(1, cols.max(1)), high.clamp(1, rows.max(1)));
    // Blocks of the full resolution are the first, by rows.
    let across = cols.div_ceil(wide);
    let count = (across as u64).saturating_mul(rows.div_ceil(high) as u64);
    let before = meta.headers.iter().take(layer).fold(0u64, |n, h| n.saturating_add(h.chunk_count as u64));
    let table = tables.saturating_add(before.saturating_mul(8));
    let table = bytes_at(&*source, table, count.saturating_mul(8), "the table of blocks", path)?;
    let offsets: Vec<u64> = table.as_chunks().0.iter().map(|b| u64::from_le_bytes(*b)).collect();

    let pixels = (wide as u64).saturating_mul(high as u64);
    let largest = pixels.saturating_mul(header.channels.bytes_per_pixel as u64);
    // As it is in the file, or as single precision.
    let unpacked = pixels.saturating_mul(4).saturating_mul(channels.len() as u64).max(largest);
    limits.check(path, "a block", unpacked, source.len())?;
    let plain = plain(header);
    let (places, heads) = match plain {
        Some(_) => lines(&meta, layer, (&offsets, largest), path)?,
        None => (packed(&offsets, largest, source.len()), Arc::default()),
    };
    let bands = if plain.is_some() { header.channels.list.len() } else { channels.len() };
    let raster = Raster {
        kind: plain.unwrap_or(Kind::F32),
        big_endian: plain.is_none() && cfg!(target_endian = "big"),
        bands,
        rows,
        cols,
        order: [Axis::Row, Axis::Band, Axis::Col],
    };
    let layer = Layer { meta, layer, channels, size: [high, wide], across };
    let blocks = Blocks {
        size: [bands.max(1), high, wide],
        strides: [0, across, 1],
        places,
        heads,
        filters: Vec::new(),
        unpack: plain.is_none().then(|| Arc::new(layer) as Arc<dyn Unpack>),
        cut: false,
    };
    let cube = Cube { source, raster, storage: Storage::Blocks(blocks) };
    cube.check(path, "a block", limits)?;
    Ok(cube)
}

/// Where compressed blocks are: one ends where the next one begins, and is no larger than it was before.
fn packed(offsets: &[u64], largest: u64, file_bytes: u64) -> Arc<[Place]> {
    let mut ends = offsets.to_vec();
    ends.push(file_bytes);
    ends.sort_unstable();
    let place = |offset: &u64| {
        let next = ends.get(ends.partition_point(|end| end <= offset)).copied().unwrap_or(file_bytes);
        let bytes = next.saturating_sub(*offset).min(largest.saturating_add(BLOCK_HEAD_BYTES));
        Place { offset: *offset, bytes, skipped: 0 }
    };
    offsets.iter().map(place).collect()
}

/// Blocks and their headers.
type Placed = (Arc<[Place]>, Arc<[u8]>);

/// Where the samples of lines are, and their headers: number and length, in files of several layers after the number of the layer.
fn lines(
    meta: &MetaData,
    layer: usize,
    (offsets, bytes): (&[u64], u64),
    path: &Path,
) -> Result<Placed, IoError> {
    let first = meta.headers.get(layer).map_or(0, |h| i64::from(h.own_attributes.layer_position.1));
    let layer = meta.requirements.has_multiple_layers.then_some(layer as i64);
    let head_bytes = if layer.is_some() { 12 } else { 8 };
    let head = |row: usize| {
        let numbers = layer.into_iter().chain([first + row as i64, i64::try_from(bytes).unwrap_or(i64::MAX)]);
        numbers.map(i32::try_from).collect::<Result<Vec<i32>, _>>()
    };
    let heads = (0..offsets.len()).map(head).collect::<Result<Vec<_>, _>>();
    let heads = heads.map_err(|_| {
        IoError::field(path, "a block", format!("{bytes} bytes"), "numbers and lengths below 2³¹")
    })?;
    let place = |o: &u64| Place { offset: o.saturating_add(head_bytes), bytes, skipped: 0 };
    Ok((
        offsets.iter().map(place).collect(),
        heads.into_iter().flatten().flat_map(i32::to_le_bytes).collect(),
    ))
}

#[derive(Debug)]
struct Layer {
    meta: MetaData,
    layer: usize,
    channels: Vec<usize>,
    /// Rows and columns of a block.
    size: [usize; 2],
    /// Blocks in a row of them.
    across: usize,
}

impl Unpack for Layer {
    fn unpack(&self, block: usize, stored: &[u8], out: &mut Vec<u8>) -> Result<(), String> {
        let unpacked = caught(|| {
            Chunk::read(&mut &*stored, &self.meta)
                .and_then(|chunk| UncompressedBlock::decompress_chunk(chunk, &self.meta, false))
        })?;
        let unpacked = unpacked.map_err(|e| e.to_string())?;
        let header = self.meta.headers.get(self.layer).ok_or("a layer is absent")?;
        self.copy(header, block, &unpacked, out)
            .ok_or_else(|| format!("the header of block {block} is that of another block"))
    }
}

impl Layer {
    /// The wanted channels by rows, filled up with zeros where the block is cut by the edge of the image.
    fn copy(&self, header: &Header, block: usize, from: &UncompressedBlock, out: &mut Vec<u8>) -> Option<()> {
        let [high, wide] = self.size;
        let [row, col] = [block / self.across.max(1) * high, block % self.across.max(1) * wide];
        let index = from.index;
        if (index.layer, index.level, index.pixel_position) != (self.layer, Vec2(0, 0), Vec2(col, row)) {
            return None;
        }
        let Vec2(cols, rows) = index.pixel_size;
        let mut begin = 0;
        let mut line = 0;
        let mut places = Vec::with_capacity(header.channels.list.len());
        for channel in &header.channels.list {
            places.push((line, channel.sample_type));
            line += cols * channel.sample_type.bytes_per_sample();
        }
        out.resize(high * self.channels.len() * wide * 4, 0);
        for row in out.chunks_exact_mut((self.channels.len() * wide * 4).max(1)).take(rows) {
            for (to, channel) in row.chunks_exact_mut(wide * 4).zip(&self.channels) {
                let (place, kind) = places.get(*channel)?;
                let samples = from.data.get(begin + place..)?.get(..cols * kind.bytes_per_sample())?;
                let to = to.get_mut(..cols * 4)?;
                match kind {
                    SampleType::F32 => to.copy_from_slice(samples),
                    SampleType::F16 => put(to, samples, |b| f16::from_ne_bytes(b).to_f32()),
                    SampleType::U32 => put(to, samples, |b| u32::from_ne_bytes(b) as f32),
                }
            }
            begin += line;
        }
        Some(())
    }
}

fn put<const N: usize>(to: &mut [u8], samples: &[u8], load: impl Fn([u8; N]) -> f32) {
    for (to, sample) in to.as_chunks_mut().0.iter_mut().zip(samples.as_chunks().0) {
        *to = load(*sample).to_ne_bytes();
    }
}
