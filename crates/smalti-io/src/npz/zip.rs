//! Reading ZIP archives (APPNOTE 6.3.10): stored and deflated members, sizes of 64 bits.

use std::io::{self, BufReader, Read};
use std::path::Path;
use std::sync::Arc;

use crc32fast::Hasher;
use flate2::bufread::DeflateDecoder;

use crate::file::plausible;
use crate::raster::{Shared, Source, Span, Stream, part};
use crate::{IoError, Limits};

const LIST_ENTRY: &[u8] = b"PK\x01\x02";
const LOCAL_ENTRY: &[u8] = b"PK\x03\x04";
const END: &[u8] = b"PK\x05\x06";
const END_64: &[u8] = b"PK\x06\x06";
const LOCATOR_64: &[u8] = b"PK\x06\x07";
const END_LEN: usize = 22;
const LOCATOR_LEN: usize = 20;
/// Numbers that have a wider one elsewhere.
const WIDE_16: u64 = u16::MAX as u64;
const WIDE_32: u64 = u32::MAX as u64;
/// Of the extra field with numbers of 64 bits.
const EXTRA_64: u64 = 1;
/// Bytes of the longest list; lists of arrays are short.
const LIST_LIMIT: u64 = 64 << 20;

/// A file of an archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Member {
    pub(crate) name: String,
    deflated: bool,
    crc: u32,
    /// The place of its bytes in the archive.
    pub(crate) at: u64,
    compressed: u64,
    /// Length of its content, bytes.
    pub(crate) size: u64,
}

/// An archive whose list has been read.
pub(crate) struct Archive<'p, 'a> {
    pub(crate) path: &'p Path,
    source: Shared<'a>,
    pub(crate) members: Vec<Member>,
    limits: Limits,
}

/// Fields of an archive, numbers with the least significant byte first.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(head)
    }

    /// A number of so many bytes.
    fn number(&mut self, bytes: usize) -> Option<u64> {
        Some(self.take(bytes)?.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)))
    }

    /// As [`Self::number`], for lengths of texts and extra fields.
    fn length(&mut self) -> Option<usize> {
        usize::try_from(self.number(2)?).ok()
    }
}

fn wrong(path: &Path, message: impl Into<String>) -> IoError {
    IoError::decode(path, "ZIP", message.into())
}

impl<'p, 'a> Archive<'p, 'a> {
    pub(crate) fn open(source: &Shared<'a>, path: &'p Path, limits: Limits) -> Result<Self, IoError> {
        let io = IoError::reading(path);
        let source = Arc::clone(source);
        let len = source.len();
        // The end has a comment of up to 65535 bytes behind it.
        let tail_len = len.min((END_LEN + LOCATOR_LEN + 65_535) as u64);
        let tail = part(&*source, len - tail_len, tail_len as usize).map_err(io)?;
        let not_zip = || IoError::unknown(path, "a ZIP archive of NumPy arrays");
        let end = tail.windows(END_LEN).rposition(|w| w.starts_with(END)).ok_or_else(not_zip)?;
        let (size, at) =
            list_place(&*source, &tail, end).ok_or_else(|| wrong(path, "its end is cut short"))?;
        if at.checked_add(size).is_none_or(|end| end > len) || size > LIST_LIMIT {
            return Err(wrong(path, format!("its list of {size} bytes at {at} is not within the file")));
        }
        let list = part(&*source, at, size as usize).map_err(io)?;
        let mut rest = Bytes(&list);
        let mut members = Vec::new();
        while rest.0.starts_with(LIST_ENTRY) {
            members.push(entry(&mut rest, &*source).map_err(|m| wrong(path, m))?);
        }
        Ok(Self { path, source, members, limits })
    }

    /// The content of a member, in the file or as a stream, and the offset at which it begins.
    pub(crate) fn source(&self, member: &Member) -> Result<(Shared<'a>, u64), IoError> {
        if !member.deflated {
            return Ok((Arc::clone(&self.source), member.at));
        }
        plausible(self.path, "an array", member.size, member.compressed)?;
        let (source, of) = (Arc::clone(&self.source), member.clone());
        let stream = Stream::new(&member.name, member.size, move || Ok(reader(&source, &of, 1 << 16)));
        Ok((Arc::new(stream), 0))
    }

    /// The first bytes of a member, or all of it where it is shorter.
    pub(crate) fn start(&self, member: &Member, len: usize) -> Result<Vec<u8>, IoError> {
        let len = len.min(usize::try_from(member.size).unwrap_or(usize::MAX));
        self.limits.check(self.path, "an array", len as u64, self.source.len())?;
        let mut out = Vec::with_capacity(len);
        reader(&self.source, member, 1 << 9)
            .take(len as u64)
            .read_to_end(&mut out)
            .map_err(|e| wrong(self.path, format!("{}: {e}", member.name)))?;
        Ok(out)
    }

    /// All of a member, compared with its check sum.
    pub(crate) fn content(&self, member: &Member) -> Result<Vec<u8>, IoError> {
        self.limits.check(self.path, "an array", member.size, member.compressed)?;
        let mut out = vec![0; usize::try_from(member.size).unwrap_or(usize::MAX)];
        reader(&self.source, member, 1 << 16)
            .read_exact(&mut out)
            .map_err(|e| wrong(self.path, format!("{}: {e}", member.name)))?;
        Ok(out)
    }
}

fn reader<'a>(source: &Shared<'a>, member: &Member, at_once: usize) -> Box<dyn Read + Send + 'a> {
    let raw = Span::new(source, member.at, member.at + member.compressed);
    let raw = BufReader::with_capacity(at_once, raw);
    let (left, stated) = (member.size, member.crc);
    match member.deflated {
        true => Box::new(Checked { inner: DeflateDecoder::new(raw), left, stated, seen: Hasher::new() }),
        false => Box::new(Checked { inner: raw, left, stated, seen: Hasher::new() }),
    }
}

/// Content that is compared with its length and check sum when its end is reached.
struct Checked<R> {
    inner: R,
    left: u64,
    stated: u32,
    seen: Hasher,
}

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let len = out.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
        if len == 0 {
            return Ok(0);
        }
        let count = self.inner.read(out.get_mut(..len).unwrap_or_default())?;
        self.seen.update(out.get(..count).unwrap_or_default());
        self.left = self.left.saturating_sub(count as u64);
        // A stream that continues beyond the stated length is damaged too.
        if self.left == 0 && (self.seen.clone().finalize() != self.stated || self.inner.read(&mut [0])? != 0)
        {
            let message = "its length or check sum is not the one stated";
            return Err(io::Error::new(io::ErrorKind::InvalidData, message));
        }
        Ok(count)
    }
}

/// Length and place of the list, from the record at `end` of the last bytes of an archive.
fn list_place(source: &dyn Source, tail: &[u8], end: usize) -> Option<(u64, u64)> {
    let mut record = Bytes(tail.get(end..)?);
    // Signature, disks.
    record.take(4 + 2 + 2)?;
    let count = record.number(2)?.max(record.number(2)?);
    let (size, at) = (record.number(4)?, record.number(4)?);
    let locator = end.checked_sub(LOCATOR_LEN).and_then(|at| tail.get(at..)?.strip_prefix(LOCATOR_64));
    let Some(locator) = locator.filter(|_| count == WIDE_16 || size == WIDE_32 || at == WIDE_32) else {
        return Some((size, at));
    };
    let mut locator = Bytes(locator);
    locator.take(4)?;
    let record = part(source, locator.number(8)?, 56).ok()?;
    let mut record = Bytes(record.strip_prefix(END_64)?);
    // Its length, versions, disks, counts.
    record.take(8 + 4 + 8 + 16)?;
    Some((record.number(8)?, record.number(8)?))
}

/// The next member of a list and its method, with the bits of its flags.
fn listed(list: &mut Bytes<'_>) -> Option<(u64, u64, Member)> {
    list.take(8)?;
    let (flags, method) = (list.number(2)?, list.number(2)?);
    list.take(4)?;
    let crc = list.number(4)? as u32;
    let (compressed, size) = (list.number(4)?, list.number(4)?);
    let (name, extra, comment) = (list.length()?, list.length()?, list.length()?);
    list.take(8)?;
    let at = list.number(4)?;
    let name = String::from_utf8_lossy(list.take(name)?).into_owned();
    let mut fields = Bytes(list.take(extra)?);
    list.take(comment)?;
    // Numbers that do not fit into 32 bits are in an extra field.
    let mut wide = Bytes(&[]);
    while let (Some(id), Some(len)) = (fields.number(2), fields.length()) {
        let Some(content) = fields.take(len) else { break };
        if id == EXTRA_64 {
            wide = Bytes(content);
        }
    }
    let mut number = |short: u64| if short == WIDE_32 { wide.number(8) } else { Some(short) };
    let (size, compressed, at) = (number(size)?, number(compressed)?, number(at)?);
    Some((flags, method, Member { name, deflated: method == 8, crc, at, compressed, size }))
}

fn entry(list: &mut Bytes<'_>, source: &dyn Source) -> Result<Member, String> {
    let (flags, method, member) = listed(list).ok_or("its list is cut short")?;
    let name = &member.name;
    if flags & 1 != 0 || ![0, 8].contains(&method) {
        let expected = "expected a stored or deflated member";
        return Err(format!("{name} is encrypted or compressed by method {method}; {expected}"));
    }
    if method == 0 && member.size != member.compressed {
        return Err(format!("{name} is stored, but its two lengths differ"));
    }
    let outside = || format!("{name} is not within the file");
    let local = part(source, member.at, 30).map_err(|_| outside())?;
    let Some(local) = local.strip_prefix(LOCAL_ENTRY) else {
        return Err(format!("{name} is not at the place that the directory of the archive states"));
    };
    // The name and the extra field before the content may have other lengths than in the list.
    let mut local = Bytes(local);
    let mut begin = || {
        local.take(22)?;
        member.at.checked_add(30 + local.number(2)? + local.number(2)?)
    };
    match begin().map(|at| (at, at.checked_add(member.compressed))) {
        Some((at, Some(end))) if end <= source.len() => Ok(Member { at, ..member }),
        _ => Err(outside()),
    }
}
