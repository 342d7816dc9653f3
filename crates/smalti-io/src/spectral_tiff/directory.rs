//! Directories of TIFF 6.0 and BigTIFF files that need not be in memory.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::IoError;
use crate::raster::{Source, part};

/// More images than any cube has bands.
const MOST_PAGES: usize = 8192;
/// Fields of all directories together, bytes, of a file that is not longer.
const FIELDS_LIMIT: u64 = 16 << 20;
/// Fields of TIFF itself have smaller numbers.
const FIRST_PRIVATE: u16 = 32768;

/// A field whose content is in memory.
#[derive(Debug, Clone)]
struct Field {
    kind: u16,
    bytes: Vec<u8>,
}

/// The fields of one image.
#[derive(Debug, Clone)]
pub(super) struct Directory {
    pub(super) big_endian: bool,
    fields: BTreeMap<u16, Field>,
}

fn size_of(kind: u16) -> Option<u64> {
    match kind {
        1 | 2 | 6 | 7 => Some(1),
        3 | 8 => Some(2),
        4 | 9 | 11 | 13 => Some(4),
        5 | 10 | 12 | 16..=18 => Some(8),
        _ => None,
    }
}

/// A file whose numbers are of one byte order.
struct Reader<'a> {
    source: &'a dyn Source,
    big_endian: bool,
    wide: bool,
    /// Bytes of fields that may still be read.
    left: u64,
}

impl Reader<'_> {
    fn part(&mut self, at: u64, len: u64) -> Option<Vec<u8>> {
        self.left = self.left.checked_sub(len)?;
        part(self.source, at, usize::try_from(len).ok()?).ok()
    }

    fn number(&self, bytes: &[u8]) -> u64 {
        let join = |n: u64, b: &u8| n << 8 | u64::from(*b);
        if self.big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
    }

    /// The fields of a directory, and where the next one stands. What is of no known type is left out, and what other programs put
    /// beyond the end.
    fn directory(&mut self, at: u64) -> Option<(Directory, u64)> {
        let (count_len, entry_len, place_len) = if self.wide { (8, 20, 8) } else { (2, 12, 4) };
        let count = self.part(at, count_len)?;
        let count = self.number(&count);
        let len = count.checked_mul(entry_len)?.checked_add(place_len)?;
        let bytes = self.part(at.checked_add(count_len)?, len)?;
        let (entries, next) = bytes.split_at_checked(bytes.len() - place_len as usize)?;
        let mut fields = BTreeMap::new();
        for entry in entries.chunks_exact(entry_len as usize) {
            let (head, content) = entry.split_at_checked(entry.len() - place_len as usize)?;
            let tag = self.number(head.get(..2)?) as u16;
            let kind = self.number(head.get(2..4)?) as u16;
            let count = self.number(head.get(4..)?);
            let Some(len) = size_of(kind).and_then(|s| s.checked_mul(count)) else { continue };
            let content = if len <= place_len {
                content.get(..len as usize).map(<[u8]>::to_vec)
            } else {
                self.part(self.number(content), len)
            };
            match content {
                Some(bytes) => drop(fields.insert(tag, Field { kind, bytes })),
                // Without its own fields an image would be read as another.
                None if tag < FIRST_PRIVATE => return None,
                None => {}
            }
        }
        Some((Directory { big_endian: self.big_endian, fields }, self.number(next)))
    }
}

/// The images of a file in their order, sub-images left aside.
pub(super) fn directories(source: &dyn Source, path: &Path) -> Result<Vec<Directory>, IoError> {
    let wrong =
        |message: &str| IoError::Decode { path: path.to_owned(), format: "TIFF", message: message.into() };
    let head = part(source, 0, source.len().min(16) as usize)
        .map_err(|source| IoError::Read { path: path.to_owned(), source })?;
    let (big_endian, wide) = match head.as_slice() {
        [b'I', b'I', 42, 0, ..] => (false, false),
        [b'M', b'M', 0, 42, ..] => (true, false),
        [b'I', b'I', 43, 0, 8, 0, 0, 0, ..] => (false, true),
        [b'M', b'M', 0, 43, 0, 8, 0, 0, ..] => (true, true),
        _ => return Err(IoError::UnknownFormat { path: path.to_owned(), expected: "a TIFF file" }),
    };
    let left = source.len().saturating_mul(2).saturating_add(FIELDS_LIMIT);
    let mut reader = Reader { source, big_endian, wide, left };
    let first = if wide { head.get(8..16) } else { head.get(4..8) };
    let mut at = reader.number(first.ok_or_else(|| wrong("it ends within its first bytes"))?);
    let mut found = Vec::new();
    let mut seen = BTreeSet::new();
    // Zero ends a chain; a place seen before would never end.
    while at != 0 && seen.insert(at) {
        if found.len() == MOST_PAGES {
            return Err(wrong("it has more than 8192 images"));
        }
        let Some((directory, next)) = reader.directory(at) else {
            return Err(wrong(&format!("the directory of image {} is cut short", found.len() + 1)));
        };
        found.push(directory);
        at = next;
    }
    Ok(found)
}

impl Directory {
    pub(super) fn has(&self, tag: u16) -> bool {
        self.fields.contains_key(&tag)
    }

    pub(super) fn bytes(&self, tag: u16) -> Option<&[u8]> {
        self.fields.get(&tag).map(|f| f.bytes.as_slice())
    }

    /// A text up to its first zero byte.
    pub(super) fn text(&self, tag: u16) -> Option<String> {
        let bytes = self.bytes(tag)?;
        let text = bytes.split(|b| *b == 0).next().unwrap_or_default();
        Some(String::from_utf8_lossy(text).into_owned())
    }

    /// The whole numbers of a field; `None` where it is absent or of another type.
    pub(super) fn numbers(&self, tag: u16) -> Option<Vec<u64>> {
        let field = self.fields.get(&tag)?;
        let size = match field.kind {
            1 | 3 | 4 | 13 | 16 | 18 => size_of(field.kind)? as usize,
            _ => return None,
        };
        let join = |n: u64, b: &u8| n << 8 | u64::from(*b);
        let number =
            |b: &[u8]| if self.big_endian { b.iter().fold(0, join) } else { b.iter().rev().fold(0, join) };
        Some(field.bytes.chunks_exact(size).map(number).collect())
    }

    /// The first number of a field.
    pub(super) fn number(&self, tag: u16) -> Option<u64> {
        self.numbers(tag)?.first().copied()
    }
}
