//! ZIP archives (APPNOTE 6.3.10), read and written without those of its parts that archives of arrays do not use.

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
/// Of the extra field with numbers of 64 bits.
const EXTRA_64: u16 = 1;
/// A list of more is none of arrays.
const LIST_LIMIT: u64 = 64 << 20;

/// A file of an archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Member {
    pub(crate) name: String,
    deflated: bool,
    crc: u32,
    /// Where its bytes stand in the archive.
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

/// Numbers, least significant byte first.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(head)
    }

    fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.take(2)?.try_into().ok()?))
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }
}

fn wrong(path: &Path, message: impl Into<String>) -> IoError {
    IoError::Decode { path: path.to_owned(), format: "ZIP", message: message.into() }
}

impl<'p, 'a> Archive<'p, 'a> {
    pub(crate) fn open(source: &Shared<'a>, path: &'p Path, limits: Limits) -> Result<Self, IoError> {
        let io = |source| IoError::Read { path: path.to_owned(), source };
        let source = Arc::clone(source);
        let len = source.len();
        // The end has a comment of up to 65535 bytes behind it.
        let tail_len = len.min((END_LEN + LOCATOR_LEN + 65_535) as u64);
        let tail = part(&*source, len - tail_len, tail_len as usize).map_err(io)?;
        let expected = "a ZIP archive of NumPy arrays";
        let not_zip = || IoError::UnknownFormat { path: path.to_owned(), expected };
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
            let member = entry(&mut rest, &*source).map_err(|m| wrong(path, m))?;
            members.push(member);
        }
        Ok(Self { path, source, members, limits })
    }

    /// The content of a member, where it lies or as a stream, and where in it the content begins.
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
        // What is more than was stated is not looked at, but it is wrong.
        if self.left == 0 && (self.seen.clone().finalize() != self.stated || self.inner.read(&mut [0])? != 0)
        {
            let message = "it has not the length and check sum stated";
            return Err(io::Error::new(io::ErrorKind::InvalidData, message));
        }
        Ok(count)
    }
}

/// Length and place of the list, from the record at `end` of the last bytes of an archive.
fn list_place(source: &dyn Source, tail: &[u8], end: usize) -> Option<(u64, u64)> {
    let mut record = Bytes(tail.get(end..)?);
    // Signature, disks, counts.
    record.take(4 + 2 + 2)?;
    let count = record.u16().max(record.u16())?;
    let (size, at) = (record.u32()?, record.u32()?);
    if count != u16::MAX && size != u32::MAX && at != u32::MAX {
        return Some((u64::from(size), u64::from(at)));
    }
    let mut locator = Bytes(tail.get(end.checked_sub(LOCATOR_LEN)?..)?);
    if locator.take(4)? != LOCATOR_64 {
        return Some((u64::from(size), u64::from(at)));
    }
    locator.take(4)?;
    let record = part(source, locator.u64()?, 56).ok()?;
    let mut record = Bytes(&record);
    if record.take(4)? != END_64 {
        return None;
    }
    // Its length, versions, disks, counts.
    record.take(8 + 4 + 8 + 16)?;
    Some((record.u64()?, record.u64()?))
}

fn entry(list: &mut Bytes<'_>, source: &dyn Source) -> Result<Member, String> {
    let short = || "its list is cut short".to_owned();
    let mut read = || {
        list.take(8)?;
        let (flags, method) = (list.u16()?, list.u16()?);
        list.take(4)?;
        let crc = list.u32()?;
        let (compressed, size) = (list.u32()?, list.u32()?);
        let (name, extra, comment) = (list.u16()?, list.u16()?, list.u16()?);
        list.take(8)?;
        let at = list.u32()?;
        let name = String::from_utf8_lossy(list.take(usize::from(name))?).into_owned();
        let extra = list.take(usize::from(extra))?;
        list.take(usize::from(comment))?;
        let (size, compressed, at) = extended(extra, size, compressed, at)?;
        Some((flags, method, Member { name, deflated: method == 8, crc, at, compressed, size }))
    };
    let (flags, method, mut member) = read().ok_or_else(short)?;
    let name = member.name.clone();
    if flags & 1 != 0 || ![0, 8].contains(&method) {
        return Err(format!(
            "{name} is encrypted or compressed by method {method}; stored or deflated ones are read"
        ));
    }
    if method == 0 && member.size != member.compressed {
        return Err(format!("{name} is stored, but its two lengths differ"));
    }
    // What stands before the content may be of another length than in the list.
    let outside = || format!("{name} is not within the file");
    let local = part(source, member.at, 30).map_err(|_| outside())?;
    let mut local = Bytes(&local);
    if local.take(4) != Some(LOCAL_ENTRY) {
        return Err(format!("{name} is not where the list says"));
    }
    let mut lengths = || {
        local.take(22)?;
        Some(u64::from(local.u16()?) + u64::from(local.u16()?))
    };
    let begin = lengths().and_then(|n| member.at.checked_add(30 + n));
    let end = begin.and_then(|at| at.checked_add(member.compressed));
    match (begin, end) {
        (Some(begin), Some(end)) if end <= source.len() => member.at = begin,
        _ => return Err(outside()),
    }
    Ok(member)
}

/// Sizes and place, from the extra field where they do not fit into 32 bits.
fn extended(extra: &[u8], size: u32, compressed: u32, at: u32) -> Option<(u64, u64, u64)> {
    let mut fields = Bytes(extra);
    let mut wide = None;
    while fields.0.len() >= 4 {
        let (id, len) = (fields.u16()?, usize::from(fields.u16()?));
        let Some(content) = fields.take(len) else { break };
        if id == EXTRA_64 {
            wide = Some(content);
        }
    }
    let mut wide = Bytes(wide.unwrap_or_default());
    let mut number = |short: u32| if short == u32::MAX { wide.u64() } else { Some(u64::from(short)) };
    Some((number(size)?, number(compressed)?, number(at)?))
}
