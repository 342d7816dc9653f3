//! Reading MAT-files of level 5. Only the beginnings of arrays are read until an array is requested.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use flate2::{Decompress, FlushDecompress, Status};

use super::{HEADER_BYTES, class, flag, tag};
use crate::raster::{Kind, Shared, bytes_at};
use crate::text::utf16;
use crate::variables::{Array, Fields, Layout, Numbers, Value};
use crate::{IoError, Limits};

// What MATLAB itself holds names to; a longer one is no name.
const MAX_NAME_BYTES: u64 = 1024;
const MAX_DIMS: u64 = 32;
const MAX_FIELDS: u64 = 1 << 16;
// More than the header of an array with the longest name.
const PEEK_BYTES: usize = 4096;

/// The name of the format in messages.
pub(in crate::matlab) const FORMAT: &str = "MATLAB";

/// The variables of a file, or the fields of a struct.
pub(in crate::matlab) struct Members {
    members: Vec<(String, Place)>,
    file: File,
}

/// What is read, and how.
#[derive(Clone)]
struct File {
    source: Shared<'static>,
    big_endian: bool,
    limits: Limits,
    path: PathBuf,
}

/// Where an array is: its data element behind its tag, or the compressed stream of element and tag.
#[derive(Debug, Clone, Copy)]
struct Place {
    offset: u64,
    bytes: u64,
    compressed: bool,
}

/// The byte order of a file that states level 5: big-endian or not.
pub(in crate::matlab) fn is_level_5(header: &[u8]) -> Option<bool> {
    match header.get(124..128)? {
        [0, 1, b'I', b'M'] => Some(false),
        [1, 0, b'M', b'I'] => Some(true),
        _ => None,
    }
}

/// Lists the variables of a file.
pub(in crate::matlab) fn open(
    source: Shared<'static>,
    big_endian: bool,
    path: &Path,
    limits: Limits,
) -> Result<Members, IoError> {
    let file = File { source, big_endian, limits, path: path.to_owned() };
    let mut members = Vec::new();
    let mut at = HEADER_BYTES;
    // Less than a tag may follow the last element.
    while at.saturating_add(8) <= file.source.len() {
        let element = file.tag(at)?;
        let compressed = element.kind == tag::COMPRESSED;
        let name = match element.kind {
            tag::MATRIX => file.header(element.data, element.bytes)?.map(|h| h.name),
            tag::COMPRESSED => file.peek(element)?,
            _ => None,
        };
        // The subsystem data of objects have no name.
        let place = Place { offset: element.data, bytes: element.bytes, compressed };
        members.extend(name.filter(|name| !name.is_empty()).map(|name| (name, place)));
        at = if compressed { element.data + element.bytes } else { element.next };
    }
    Ok(Members { members, file })
}

impl Fields for Members {
    fn names(&self) -> Vec<String> {
        self.members.iter().map(|(name, _)| name.clone()).collect()
    }

    fn get(&self, name: &str) -> Result<Option<Value>, IoError> {
        let Some((_, place)) = self.members.iter().find(|(n, _)| n == name) else { return Ok(None) };
        if !place.compressed {
            return self.file.value(place.offset, place.bytes).map(Some);
        }
        let file = self.file.inflated(place.offset, place.bytes)?;
        let element = file.tag(0)?;
        file.value(element.data, element.bytes).map(Some)
    }
}

/// The beginning of a data element.
#[derive(Debug, Clone, Copy)]
struct Tag {
    kind: u32,
    /// Where its data are, and how many bytes.
    data: u64,
    bytes: u64,
    /// Where the next element begins.
    next: u64,
}

/// The beginning of an array.
struct Header {
    class: u8,
    flags: u8,
    dims: Vec<usize>,
    name: String,
    /// Where its content begins, and ends.
    body: u64,
    end: u64,
}

impl File {
    fn decode(&self, message: impl ToString) -> IoError {
        IoError::decode(&self.path, FORMAT, message)
    }

    fn bytes(&self, offset: u64, len: u64, what: &'static str) -> Result<Vec<u8>, IoError> {
        bytes_at(&*self.source, offset, len, what, &self.path)
    }

    fn number(&self, bytes: &[u8]) -> u32 {
        let bytes: [u8; 4] = bytes.first_chunk().copied().unwrap_or_default();
        if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
    }

    fn tag(&self, at: u64) -> Result<Tag, IoError> {
        let bytes = self.bytes(at, 8, "a tag")?;
        let (first, second) = bytes.split_at(4);
        let first = self.number(first);
        // Four bytes and fewer stand in the tag itself.
        if first >> 16 != 0 {
            let (kind, len) = (first & 0xffff, u64::from(first >> 16));
            if len > 4 {
                return Err(self.decode(format!("a small element of {len} bytes at {at}")));
            }
            return Ok(Tag { kind, data: at + 4, bytes: len, next: at + 8 });
        }
        let len = u64::from(self.number(second));
        let have = self.source.len() - (at + 8);
        if len > have {
            return Err(IoError::truncated(&self.path, "an element", len, have));
        }
        Ok(Tag { kind: first, data: at + 8, bytes: len, next: at + 8 + len.next_multiple_of(8) })
    }

    /// An element of one type and of a bounded length, and where the next one begins.
    fn part(&self, at: u64, kind: u32, most: u64, what: &'static str) -> Result<(Vec<u8>, u64), IoError> {
        let tag = self.tag(at)?;
        if tag.kind != kind || tag.bytes > most {
            return Err(self.decode(format!("{what} of type {} and {} bytes at {at}", tag.kind, tag.bytes)));
        }
        Ok((self.bytes(tag.data, tag.bytes, what)?, tag.next))
    }

    /// The header of the array whose data element is at this offset. `None` if the array is empty.
    fn header(&self, offset: u64, bytes: u64) -> Result<Option<Header>, IoError> {
        if bytes == 0 {
            return Ok(None);
        }
        let (flags, at) = self.part(offset, tag::UINT32, 8, "the flags of an array")?;
        let word = self.number(&flags);
        let (dims, at) = self.part(at, tag::INT32, 4 * MAX_DIMS, "the dimensions of an array")?;
        let dims: Vec<usize> = dims
            .chunks_exact(4)
            .map(|d| usize::try_from(self.number(d) as i32))
            .collect::<Result<_, _>>()
            .map_err(|_| self.decode(format!("a negative dimension of the array at {offset}")))?;
        let (name, body) = self.part(at, tag::INT8, MAX_NAME_BYTES, "the name of an array")?;
        let name = String::from_utf8_lossy(&name).into_owned();
        let [class, flags, ..] = word.to_le_bytes();
        Ok(Some(Header { class, flags, dims, name, body, end: offset + bytes }))
    }

    /// The name of a compressed array; only the beginning of the stream is inflated.
    fn peek(&self, element: Tag) -> Result<Option<String>, IoError> {
        let input = self.bytes(element.data, element.bytes.min(2 * PEEK_BYTES as u64), "a variable")?;
        let mut start = vec![0; PEEK_BYTES];
        let mut stream = Decompress::new(true);
        let damaged = |_| self.decode(format!("the compressed variable at {} is damaged", element.data));
        stream.decompress(&input, &mut start, FlushDecompress::None).map_err(damaged)?;
        start.truncate(stream.total_out() as usize);
        if start.len() < 16 {
            return Ok(None);
        }
        let whole = u64::from(self.number(start.get(4..).unwrap_or_default()));
        // The bytes that were not inflated do not matter: no header is so long.
        let file = File { source: Arc::new(start), ..self.clone() };
        Ok(file.header(8, whole)?.map(|h| h.name))
    }

    /// A compressed element, as a file of its own.
    fn inflated(&self, offset: u64, bytes: u64) -> Result<Self, IoError> {
        let input = self.bytes(offset, bytes, "a variable")?;
        let damaged = || self.decode(format!("the compressed variable at {offset} is damaged"));
        let mut stream = Decompress::new(true);
        let mut tag = [0; 8];
        stream.decompress(&input, &mut tag, FlushDecompress::None).map_err(|_| damaged())?;
        if stream.total_out() < 8 {
            return Err(damaged());
        }
        let len = 8 + u64::from(self.number(tag.get(4..).unwrap_or_default()));
        self.limits.check(&self.path, "a variable", len, bytes)?;
        let mut whole = vec![0; usize::try_from(len).map_err(|_| damaged())?];
        if let Some(start) = whole.first_chunk_mut() {
            *start = tag;
        }
        let rest = input.get(stream.total_in() as usize..).unwrap_or_default();
        let into = whole.get_mut(8..).unwrap_or_default();
        let status = stream.decompress(rest, into, FlushDecompress::Finish);
        if !matches!(status, Ok(Status::StreamEnd)) || stream.total_out() != len {
            return Err(damaged());
        }
        Ok(Self { source: Arc::new(whole), ..self.clone() })
    }

    fn value(&self, offset: u64, bytes: u64) -> Result<Value, IoError> {
        let Some(header) = self.header(offset, bytes)? else { return Ok(Value::Other("empty")) };
        let one = header.dims.iter().all(|&d| d == 1);
        match header.class {
            _ if header.flags & flag::COMPLEX != 0 => Ok(Value::Other("complex numbers")),
            class::STRUCT | class::OBJECT if one => self.fields(&header).map(|f| Value::Fields(Box::new(f))),
            class::STRUCT | class::OBJECT => Ok(Value::Other("an array of structs")),
            class::CELL if one => {
                let inner = self.tag(header.body)?;
                // A cell in a cell in a cell … is of no use, and may go deep.
                match self.header(inner.data, inner.bytes)? {
                    Some(h) if h.class == class::CELL => Ok(Value::Other("a cell in a cell")),
                    _ => self.value(inner.data, inner.bytes),
                }
            }
            class::CELL => Ok(Value::Other("a cell array")),
            class::CHAR => self.text(&header).map(Value::Text),
            class::SPARSE => Ok(Value::Other("a sparse matrix")),
            class::DOUBLE..=class::UINT64 => self.numbers(header).map(Value::Numbers),
            _ => Ok(Value::Other("neither numbers nor text")),
        }
    }

    fn text(&self, header: &Header) -> Result<String, IoError> {
        const MAX_TEXT_BYTES: u64 = 1 << 20;
        let tag = self.tag(header.body)?;
        if tag.bytes > MAX_TEXT_BYTES {
            return Err(self.decode(format!("the text {} of {} bytes", header.name, tag.bytes)));
        }
        let bytes = self.bytes(tag.data, tag.bytes, "a text")?;
        Ok(match tag.kind {
            tag::UTF8 | tag::INT8 | tag::UINT8 => String::from_utf8_lossy(&bytes).into_owned(),
            tag::UTF16 | tag::UINT16 => utf16(self.big_endian, &bytes),
            tag::UTF32 | tag::UINT32 => Kind::U32
                .numbers::<f64>(self.big_endian, &bytes)
                .iter()
                .map(|&u| char::from_u32(u as u32).unwrap_or(char::REPLACEMENT_CHARACTER))
                .collect(),
            _ => return Err(self.decode(format!("the text {} of type {}", header.name, tag.kind))),
        })
    }

    fn numbers(&self, header: Header) -> Result<Numbers, IoError> {
        let tag = self.tag(header.body)?;
        // MATLAB keeps whole numbers in the smallest type that holds them, whatever the class of the array.
        let kind = match tag.kind {
            tag::INT8 => Kind::I8,
            tag::UINT8 => Kind::U8,
            tag::INT16 => Kind::I16,
            tag::UINT16 => Kind::U16,
            tag::INT32 => Kind::I32,
            tag::UINT32 => Kind::U32,
            tag::INT64 => Kind::I64,
            tag::UINT64 => Kind::U64,
            tag::SINGLE => Kind::F32,
            tag::DOUBLE => Kind::F64,
            _ => return Err(self.decode(format!("the array {} of type {}", header.name, tag.kind))),
        };
        let array = Array {
            dims: header.dims,
            kind,
            big_endian: self.big_endian,
            source: Arc::clone(&self.source),
            layout: Layout::Run { offset: tag.data },
        };
        if array.bytes() != tag.bytes {
            return Err(self.decode(format!("{} bytes for an array of {:?}", tag.bytes, array.dims)));
        }
        Ok(Numbers { array, matlab: true, attributes: Vec::new() })
    }

    fn fields(&self, header: &Header) -> Result<Members, IoError> {
        let mut at = header.body;
        if header.class == class::OBJECT {
            at = self.part(at, tag::INT8, MAX_NAME_BYTES, "the class of an object")?.1;
        }
        let (longest, at) = self.part(at, tag::INT32, 4, "the length of field names")?;
        let longest = u64::from(self.number(&longest)).clamp(1, MAX_NAME_BYTES);
        let (names, mut at) = self.part(at, tag::INT8, MAX_FIELDS * longest, "the names of fields")?;
        let mut members = Vec::new();
        for name in names.chunks_exact(longest as usize) {
            let name = name.split(|&b| b == 0).next().unwrap_or_default();
            let tag = self.tag(at)?;
            if tag.kind != tag::MATRIX || tag.next > header.end.next_multiple_of(8) {
                return Err(self.decode(format!("a field of type {} at {at}", tag.kind)));
            }
            let place = Place { offset: tag.data, bytes: tag.bytes, compressed: false };
            members.push((String::from_utf8_lossy(name).into_owned(), place));
            at = tag.next;
        }
        Ok(Members { members, file: self.clone() })
    }
}
