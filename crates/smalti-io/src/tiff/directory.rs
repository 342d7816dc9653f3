//! Reading the directories of TIFF 6.0 and BigTIFF files, which need not be in memory.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::tags::SUB_IFDS;
use crate::IoError;
use crate::raster::{Kind, Source, part};

/// Most images of a file: more than any cube has bands.
const MAX_IMAGES: usize = 8192;
/// Bytes that the fields of all directories may take beyond twice the length of the file.
const FIELDS_LIMIT: u64 = 16 << 20;
/// The fields of TIFF itself have smaller numbers.
const FIRST_PRIVATE: u16 = 32768;

const RATIONAL: u16 = 5;
const SIGNED_RATIONAL: u16 = 10;

/// A field whose content is in memory.
#[derive(Debug, Clone)]
struct Field {
    kind: u16,
    bytes: Vec<u8>,
}

/// The fields of one image.
#[derive(Debug, Clone)]
pub(crate) struct Directory {
    pub(crate) big_endian: bool,
    fields: BTreeMap<u16, Field>,
}

/// The numbers that a field of this type consists of. A fraction consists of two.
fn kind_of(kind: u16) -> Option<Kind> {
    match kind {
        1 | 2 | 7 => Some(Kind::U8),
        3 => Some(Kind::U16),
        4 | RATIONAL | 13 => Some(Kind::U32),
        6 => Some(Kind::I8),
        8 => Some(Kind::I16),
        9 | SIGNED_RATIONAL => Some(Kind::I32),
        11 => Some(Kind::F32),
        12 => Some(Kind::F64),
        16 | 18 => Some(Kind::U64),
        17 => Some(Kind::I64),
        _ => None,
    }
}

fn size_of(kind: u16) -> Option<usize> {
    let numbers = if matches!(kind, RATIONAL | SIGNED_RATIONAL) { 2 } else { 1 };
    Some(numbers * kind_of(kind)?.size())
}

/// A whole number of any length.
fn whole(bytes: &[u8], big_endian: bool) -> u64 {
    let join = |n: u64, b: &u8| n << 8 | u64::from(*b);
    if big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
}

/// The images of a file, read one by one. An image that cannot be read is an error that names the file and the tag; the images after
/// it follow where their places are known.
pub(crate) struct Images<'a> {
    source: &'a dyn Source,
    path: &'a Path,
    big_endian: bool,
    wide: bool,
    sub_images: bool,
    /// Bytes of fields that may still be read.
    left: u64,
    /// Directories to read, the next one last.
    pending: Vec<u64>,
    seen: BTreeSet<u64>,
}

impl<'a> Images<'a> {
    /// The images in the order of their chain; with `sub_images`, the sub-images of each before the next one.
    ///
    /// # Errors
    /// When the file does not begin as a TIFF file does.
    pub(crate) fn new(source: &'a dyn Source, path: &'a Path, sub_images: bool) -> Result<Self, IoError> {
        let head = part(source, 0, source.len().min(16) as usize).map_err(IoError::reading(path))?;
        let (big_endian, wide) = match head.as_slice() {
            [b'I', b'I', 42, 0, ..] => (false, false),
            [b'M', b'M', 0, 42, ..] => (true, false),
            [b'I', b'I', 43, 0, 8, 0, 0, 0, ..] => (false, true),
            [b'M', b'M', 0, 43, 0, 8, 0, 0, ..] => (true, true),
            _ => return Err(IoError::unknown(path, "a TIFF file")),
        };
        let first = if wide { head.get(8..16) } else { head.get(4..8) };
        let first = first.ok_or_else(|| IoError::decode(path, "TIFF", "it ends within its first bytes"))?;
        let left = source.len().saturating_mul(2).saturating_add(FIELDS_LIMIT);
        let pending = vec![whole(first, big_endian)];
        Ok(Self { source, path, big_endian, wide, sub_images, left, pending, seen: BTreeSet::new() })
    }

    fn part(&mut self, at: u64, len: u64) -> Option<Vec<u8>> {
        self.left = self.left.checked_sub(len)?;
        part(self.source, at, usize::try_from(len).ok()?).ok()
    }

    /// The entries of the directory at a place, each of `entry_len` bytes, and the place of the next directory.
    fn entries(&mut self, at: u64, entry_len: u64, place_len: u64) -> Option<(Vec<u8>, u64)> {
        let count_len = if self.wide { 8 } else { 2 };
        let count = whole(&self.part(at, count_len)?, self.big_endian);
        let len = count.checked_mul(entry_len)?;
        let mut entries = self.part(at.checked_add(count_len)?, len.checked_add(place_len)?)?;
        let next = entries.split_off(usize::try_from(len).ok()?);
        Some((entries, whole(&next, self.big_endian)))
    }

    /// The content of a field, where it is stored: in the entry itself if it fits there, else at the place that the entry states.
    fn content(&mut self, stored: &[u8], len: u64) -> Option<Vec<u8>> {
        match usize::try_from(len).ok().and_then(|len| stored.get(..len)) {
            Some(inside) => Some(inside.to_vec()),
            None => self.part(whole(stored, self.big_endian), len),
        }
    }

    fn read(&mut self, at: u64) -> Result<Directory, IoError> {
        let number = self.seen.len();
        let (entry_len, place_len) = if self.wide { (20, 8) } else { (12, 4) };
        let Some((entries, next)) = self.entries(at, entry_len, place_len) else {
            let message = format!("the directory of image {number} is cut short");
            return Err(IoError::decode(self.path, "TIFF", message));
        };
        self.pending.push(next);
        let mut fields = BTreeMap::new();
        for entry in entries.chunks_exact(entry_len as usize) {
            let number_at =
                |from: usize, to: usize| whole(entry.get(from..to).unwrap_or_default(), self.big_endian);
            let stored_at = entry.len() - place_len as usize;
            let (tag, kind) = (number_at(0, 2) as u16, number_at(2, 4) as u16);
            let count = number_at(4, stored_at);
            // Fields of unknown types are left out.
            let Some(len) = size_of(kind).and_then(|s| count.checked_mul(s as u64)) else { continue };
            match self.content(entry.get(stored_at..).unwrap_or_default(), len) {
                Some(bytes) => drop(fields.insert(tag, Field { kind, bytes })),
                // Without a field of TIFF itself the image would be read as another one.
                None if tag < FIRST_PRIVATE => {
                    let message = format!("tag {tag} of image {number} reaches beyond the end of the file");
                    return Err(IoError::decode(self.path, "TIFF", message));
                }
                None => {}
            }
        }
        let directory = Directory { big_endian: self.big_endian, fields };
        if self.sub_images {
            self.pending.extend(directory.integers(SUB_IFDS).unwrap_or_default().iter().take(MAX_IMAGES));
        }
        Ok(directory)
    }
}

impl Iterator for Images<'_> {
    type Item = Result<Directory, IoError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let at = self.pending.pop()?;
            // Zero ends a chain. A place that was seen before would never end.
            if at == 0 || !self.seen.insert(at) {
                continue;
            }
            if self.seen.len() > MAX_IMAGES {
                self.pending.clear();
                let message = format!("it has more than {MAX_IMAGES} images");
                return Some(Err(IoError::decode(self.path, "TIFF", message)));
            }
            return Some(self.read(at));
        }
    }
}

impl Directory {
    pub(crate) fn has(&self, tag: u16) -> bool {
        self.fields.contains_key(&tag)
    }

    /// The content of a field as it is stored.
    pub(crate) fn bytes(&self, tag: u16) -> Option<&[u8]> {
        self.fields.get(&tag).map(|f| f.bytes.as_slice())
    }

    /// A text up to its first zero byte.
    pub(crate) fn text(&self, tag: u16) -> Option<String> {
        let text = self.bytes(tag)?.split(|b| *b == 0).next()?;
        Some(String::from_utf8_lossy(text).into_owned())
    }

    /// The numbers of a field of unsigned whole numbers. `None` where it is absent or of another type.
    pub(crate) fn integers(&self, tag: u16) -> Option<Vec<u64>> {
        let field = self.fields.get(&tag)?;
        let size = match field.kind {
            1 | 3 | 4 | 13 | 16 | 18 => size_of(field.kind)?,
            _ => return None,
        };
        Some(field.bytes.chunks_exact(size).map(|b| whole(b, self.big_endian)).collect())
    }

    /// The first number of a field of unsigned whole numbers.
    pub(crate) fn integer(&self, tag: u16) -> Option<u64> {
        self.integers(tag)?.first().copied()
    }

    /// The same for a count or length.
    pub(crate) fn size(&self, tag: u16) -> Option<usize> {
        self.integer(tag).and_then(|n| usize::try_from(n).ok())
    }

    /// The numbers of a field of any type, fractions divided.
    pub(crate) fn numbers(&self, tag: u16) -> Option<Vec<f64>> {
        let field = self.fields.get(&tag)?;
        let numbers: Vec<f64> = kind_of(field.kind)?.numbers(self.big_endian, &field.bytes);
        Some(match field.kind {
            RATIONAL | SIGNED_RATIONAL => numbers.as_chunks().0.iter().map(|[n, d]| n / d).collect(),
            _ => numbers,
        })
    }

    /// The first number of a field of any type.
    pub(crate) fn number(&self, tag: u16) -> Option<f64> {
        self.numbers(tag)?.first().copied()
    }
}
