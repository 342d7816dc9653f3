//! Writing spectral TIFF.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use serde_json::json;

use crate::scene_file::blocks::{by_pixel, little_endian, row_blocks, write_planes};
use crate::scene_file::crop::Crop;
use crate::scene_file::facts::Facts;
use crate::scene_file::tiles::{Header, Tiles};
use crate::text::ascii_json;
use crate::tiff::{Fields, Value, directory, tags};
use crate::{IoError, write};

/// Where the bands of a file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layout {
    /// An image for each.
    #[default]
    Pages,
    /// A sample of each pixel for each.
    Samples,
}

/// How a file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WriteOptions {
    /// Where its bands are.
    pub layout: Layout,
    /// Whether samples are compressed (Deflate, without loss).
    pub deflate: bool,
}

/// A strip of a compressed image, unpacked.
const STRIP_BYTES: usize = 1 << 18;
/// What a file of 32-bit places can hold beside directories.
const SMALL_LIMIT: u64 = (u32::MAX as u64) - (64 << 20);

/// Writes 32-bit floating point, as BigTIFF where it does not fit into 4 GiB. The first image is described by JSON: the
/// wavelengths (`wavelengths_nm`) and what TIFF has no field for, so that [`super::open`] returns an equal value. The image is
/// read by rows, so that it need not fit into memory.
///
/// # Errors
/// When the file cannot be written, or the image cannot be read; where there are more bands than a pixel can have samples.
pub fn write(path: &Path, image: &dyn Tiles, options: WriteOptions) -> Result<(), IoError> {
    let header = image.header();
    let io = IoError::writing(path);
    let bands = header.wavelengths_nm.len();
    let samples = match options.layout {
        Layout::Pages => 1,
        Layout::Samples => bands,
    };
    let too_large = |n: usize| u32::try_from(n).is_err();
    if samples > usize::from(u16::MAX) || too_large(header.rows) || too_large(header.cols) {
        let found = format!("{} × {} pixels of {bands} bands", header.rows, header.cols);
        let expected =
            "at most 65535 samples of a pixel (an image for each band holds more), and 32-bit lengths";
        return Err(IoError::field(path, "the image", found, expected));
    }
    let wide = header.decoded_bytes() > SMALL_LIMIT;
    write::atomic(path, |out| {
        let base = if wide { 16u64 } else { 8 };
        out.write_all(&vec![0; base as usize]).map_err(io)?;
        let (strips, rows_per_strip) = match (options.deflate, options.layout) {
            (true, _) => compressed(out, base, image, samples, path)?,
            (false, Layout::Pages) => {
                write_planes(out, base, image, path, |_, _| {})?;
                let plane = header.decoded_bytes() / bands.max(1) as u64;
                let strip = |i| vec![(base + i as u64 * plane, plane)];
                ((0..bands).map(strip).collect(), header.rows)
            }
            (false, Layout::Samples) => {
                for block in row_blocks(image) {
                    let samples = by_pixel(&image.read(block)?);
                    out.write_all(bytemuck::cast_slice(&samples)).map_err(io)?;
                }
                (vec![vec![(base, header.decoded_bytes())]], header.rows)
            }
        };
        let at = out.stream_position().map_err(io)?;
        let first = at + at % 2;
        let mut directories = vec![0; (at % 2) as usize];
        let last = strips.len().saturating_sub(1);
        for (i, strips) in strips.iter().enumerate() {
            let fields = fields(header, i, samples, strips, (rows_per_strip, options.deflate));
            directories.extend(directory(&fields, at + directories.len() as u64, (wide, 8), i == last));
        }
        out.write_all(&directories).map_err(io)?;
        out.seek(SeekFrom::Start(0)).map_err(io)?;
        let head = if wide {
            [&b"II\x2b\0\x08\0\0\0"[..], &first.to_le_bytes()].concat()
        } else {
            // Compressed samples and directories are checked here too.
            let first = u32::try_from(first).map_err(|_| io(std::io::ErrorKind::FileTooLarge.into()))?;
            [&b"II*\0"[..], &first.to_le_bytes()].concat()
        };
        out.write_all(&head).map_err(io)
    })
}

/// Places and lengths of the strips of every image.
type Strips = Vec<Vec<(u64, u64)>>;

/// Writes compressed strips as their rows come, of all bands in turn.
fn compressed(
    out: &mut write::Target,
    base: u64,
    image: &dyn Tiles,
    samples: usize,
    path: &Path,
) -> Result<(Strips, usize), IoError> {
    let io = IoError::writing(path);
    let header = image.header();
    let row_bytes = (header.cols * samples * 4).max(1);
    let high = (STRIP_BYTES / row_bytes).clamp(1, header.rows.max(1));
    // Whole strips at a time.
    let at_once = row_blocks(image).next().map_or(1, |b| b.rows).next_multiple_of(high);
    let images = if samples == 1 { header.wavelengths_nm.len() } else { 1 };
    let mut strips: Strips = vec![Vec::new(); images];
    let mut at = base;
    for row in (0..header.rows).step_by(at_once) {
        let rows = at_once.min(header.rows - row);
        let planes = image.read(Crop { row, col: 0, rows, cols: header.cols })?;
        let parts: Vec<(usize, Vec<u8>)> = if samples == 1 {
            let plane = |(i, plane)| strips_of(&little_endian(plane), high * header.cols, i);
            planes.planes().enumerate().map(plane).collect::<Vec<_>>().concat()
        } else {
            strips_of(&by_pixel(&planes), high * header.cols * samples, 0)
        };
        let packed: Vec<std::io::Result<(usize, Vec<u8>)>> = parts
            .into_par_iter()
            .map(|(i, bytes)| {
                let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(&bytes)?;
                Ok((i, encoder.finish()?))
            })
            .collect();
        for part in packed {
            let (i, bytes) = part.map_err(io)?;
            out.write_all(&bytes).map_err(io)?;
            if let Some(strips) = strips.get_mut(i) {
                strips.push((at, bytes.len() as u64));
            }
            at += bytes.len() as u64;
        }
    }
    Ok((strips, high))
}

fn strips_of(samples: &[f32], len: usize, image: usize) -> Vec<(usize, Vec<u8>)> {
    samples.chunks(len.max(1)).map(|c| (image, bytemuck::cast_slice(c).to_vec())).collect()
}

fn fields(
    header: &Header,
    image: usize,
    samples: usize,
    strips: &[(u64, u64)],
    (rows_per_strip, deflate): (usize, bool),
) -> Fields {
    let mut fields = Fields::from([
        (tags::NEW_SUBFILE_TYPE, Value::Long(vec![0])),
        (tags::IMAGE_WIDTH, Value::Long(vec![header.cols as u32])),
        (tags::IMAGE_LENGTH, Value::Long(vec![header.rows as u32])),
        (tags::BITS_PER_SAMPLE, Value::Short(vec![32; samples])),
        (tags::COMPRESSION, Value::Short(vec![if deflate { 8 } else { 1 }])),
        (tags::PHOTOMETRIC, Value::Short(vec![1])),
        (tags::STRIP_OFFSETS, Value::Places(strips.iter().map(|s| s.0).collect())),
        (tags::SAMPLES_PER_PIXEL, Value::Short(vec![samples as u16])),
        (tags::ROWS_PER_STRIP, Value::Long(vec![rows_per_strip as u32])),
        (tags::STRIP_BYTE_COUNTS, Value::Places(strips.iter().map(|s| s.1).collect())),
        (tags::PLANAR_CONFIGURATION, Value::Short(vec![1])),
        (tags::SOFTWARE, Value::Ascii("Smalti".into())),
        (tags::SAMPLE_FORMAT, Value::Short(vec![3; samples])),
    ]);
    if image == 0 {
        let facts = json!({
            "smalti": Facts::of(header),
            "wavelengths_nm": header.wavelengths_nm,
            "quantity": header.quantity.name(),
        });
        fields.insert(tags::IMAGE_DESCRIPTION, Value::Ascii(ascii_json(&facts)));
    }
    if samples == 1 {
        let nm = header.wavelengths_nm.get(image).copied().unwrap_or(0.0);
        fields.insert(tags::PAGE_NAME, Value::Ascii(format!("{nm} nm")));
    } else {
        fields.insert(tags::EXTRA_SAMPLES, Value::Short(vec![0; samples.saturating_sub(1)]));
    }
    fields
}
