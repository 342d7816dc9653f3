//! Writing spectral TIFF.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use serde_json::json;

use crate::scene_file::blocks::{by_pixel, little_endian, row_blocks, write_planes};
use crate::scene_file::facts::Facts;
use crate::scene_file::tiles::{Crop, Header, Tiles};
use crate::text::ascii_json;
use crate::tiff_tags as tags;
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
/// wavelengths (`wavelengths_nm`) and what TIFF has no field for, so that [`super::read()`] returns an equal value. The image is
/// read by rows, so that it need not fit into memory.
///
/// # Errors
/// When the file cannot be written, or the image cannot be read; where there are more bands than a pixel can have samples.
pub fn write(path: &Path, image: &dyn Tiles, options: WriteOptions) -> Result<(), IoError> {
    let header = image.header();
    let io = |source| IoError::Write { path: path.to_owned(), source };
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
        let mut places = Directories { bytes: Vec::new(), at: at + at % 2, wide };
        if at % 2 == 1 {
            out.write_all(&[0]).map_err(io)?;
        }
        let first = places.at;
        let last = strips.len().saturating_sub(1);
        for (i, strips) in strips.iter().enumerate() {
            places.push(&fields(header, i, samples, strips, (rows_per_strip, options.deflate)), i == last);
        }
        out.write_all(&places.bytes).map_err(io)?;
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
    let io = |source| IoError::Write { path: path.to_owned(), source };
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

/// Content of a field.
enum Content {
    Text(String),
    Short(Vec<u16>),
    Long(Vec<u32>),
    /// As wide as places are in the file.
    Places(Vec<u64>),
}

fn fields(
    header: &Header,
    image: usize,
    samples: usize,
    strips: &[(u64, u64)],
    (rows_per_strip, deflate): (usize, bool),
) -> Vec<(u16, Content)> {
    let nm = |i: usize| header.wavelengths_nm.get(i).copied().unwrap_or(0.0);
    let description = (image == 0).then(|| {
        let facts = json!({
            "smalti": Facts::of(header),
            "wavelengths_nm": header.wavelengths_nm,
            "quantity": header.quantity.name(),
        });
        (tags::IMAGE_DESCRIPTION, Content::Text(ascii_json(&facts)))
    });
    let mut fields = vec![
        (tags::NEW_SUBFILE_TYPE, Content::Long(vec![0])),
        (tags::IMAGE_WIDTH, Content::Long(vec![header.cols as u32])),
        (tags::IMAGE_LENGTH, Content::Long(vec![header.rows as u32])),
        (tags::BITS_PER_SAMPLE, Content::Short(vec![32; samples])),
        (tags::COMPRESSION, Content::Short(vec![if deflate { 8 } else { 1 }])),
        (tags::PHOTOMETRIC, Content::Short(vec![1])),
    ];
    fields.extend(description);
    fields.extend([
        (tags::STRIP_OFFSETS, Content::Places(strips.iter().map(|s| s.0).collect())),
        (tags::SAMPLES_PER_PIXEL, Content::Short(vec![samples as u16])),
        (tags::ROWS_PER_STRIP, Content::Long(vec![rows_per_strip as u32])),
        (tags::STRIP_BYTE_COUNTS, Content::Places(strips.iter().map(|s| s.1).collect())),
        (tags::PLANAR_CONFIGURATION, Content::Short(vec![1])),
    ]);
    if samples == 1 {
        fields.push((PAGE_NAME, Content::Text(format!("{} nm", nm(image)))));
    }
    fields.push((tags::SOFTWARE, Content::Text("Smalti".into())));
    if samples > 1 {
        fields.push((EXTRA_SAMPLES, Content::Short(vec![0; samples - 1])));
    }
    fields.push((tags::SAMPLE_FORMAT, Content::Short(vec![3; samples])));
    fields
}

const PAGE_NAME: u16 = 285;
const EXTRA_SAMPLES: u16 = 338;

/// Directories one after another, from a place of the file on.
struct Directories {
    bytes: Vec<u8>,
    at: u64,
    wide: bool,
}

impl Directories {
    fn push(&mut self, fields: &[(u16, Content)], last: bool) {
        let (count_len, entry_len, place_len) = if self.wide { (8, 20, 8) } else { (2, 12, 4) };
        let begin = self.at + self.bytes.len() as u64;
        let values_at = begin + count_len + entry_len * fields.len() as u64 + place_len;
        let mut values: Vec<u8> = Vec::new();
        let place = |v: u64| v.to_le_bytes().into_iter().take(place_len as usize);
        self.bytes.extend((fields.len() as u64).to_le_bytes().into_iter().take(count_len as usize));
        for (tag, content) in fields {
            let (kind, count, mut bytes): (u16, usize, Vec<u8>) = match content {
                Content::Text(s) => (2, s.len() + 1, s.bytes().chain([0]).collect()),
                Content::Short(v) => (3, v.len(), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
                Content::Long(v) => (4, v.len(), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
                Content::Places(v) => {
                    (if self.wide { 16 } else { 4 }, v.len(), v.iter().flat_map(|x| place(*x)).collect())
                }
            };
            self.bytes.extend(tag.to_le_bytes());
            self.bytes.extend(kind.to_le_bytes());
            self.bytes.extend(place(count as u64));
            if bytes.len() as u64 <= place_len {
                bytes.resize(place_len as usize, 0);
                self.bytes.extend(bytes);
            } else {
                self.bytes.extend(place(values_at + values.len() as u64));
                bytes.resize(bytes.len().next_multiple_of(8), 0);
                values.extend(bytes);
            }
        }
        let next = values_at + values.len() as u64;
        self.bytes.extend(place(if last { 0 } else { next }));
        self.bytes.extend(values);
    }
}
