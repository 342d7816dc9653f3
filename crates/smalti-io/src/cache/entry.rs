//! The file of an entry: a header with the key of the entry and a checksum, then the content.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;

use blake3::Hash;

use crate::{IoError, Limits, write};

const MAGIC: &[u8; 8] = b"SMALTICE";
// Part of every entry: one of another version is ignored.
const VERSION: u32 = 1;
/// Magic, version, key, length of the content, CRC-32 of the content, CRC-32 of the header before it.
pub(super) const HEADER_LEN: usize = 8 + 4 + 32 + 8 + 4 + 4;

/// Bytes of the file with this content.
pub(super) fn size(pieces: &[&[u8]]) -> u64 {
    HEADER_LEN as u64 + pieces.iter().map(|p| p.len() as u64).sum::<u64>()
}

/// Writes an entry.
pub(super) fn write(path: &Path, key: &Hash, pieces: &[&[u8]]) -> Result<(), IoError> {
    let mut sum = crc32fast::Hasher::new();
    pieces.iter().for_each(|piece| sum.update(piece));
    let mut header = MAGIC.to_vec();
    header.extend(VERSION.to_le_bytes());
    header.extend(key.as_bytes());
    header.extend((size(pieces) - HEADER_LEN as u64).to_le_bytes());
    header.extend(sum.finalize().to_le_bytes());
    let own = crc32fast::hash(&header);
    header.extend(own.to_le_bytes());
    write::stream(path, |out| {
        out.write_all(&header)?;
        pieces.iter().try_for_each(|piece| out.write_all(piece))
    })
}

/// An entry whose header is that of its key, and whose file has the length that the header states.
pub(super) struct Opened {
    /// Behind the header.
    pub(super) file: File,
    /// Length of the content, bytes.
    pub(super) len: usize,
    /// CRC-32 of the content: it finds damage, not malice.
    pub(super) checksum: u32,
}

/// Opens the entry of a key; `None` when there is none that can be used.
pub(super) fn open(path: &Path, key: &Hash) -> Option<Opened> {
    // Opening a pipe would wait for its writer.
    fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    let mut file = File::open(path).ok()?;
    let mut header = [0; HEADER_LEN];
    file.read_exact(&mut header).ok()?;
    let (body, own) = header.split_last_chunk::<4>()?;
    if crc32fast::hash(body) != u32::from_le_bytes(*own) {
        return None;
    }
    let rest =
        body.strip_prefix(MAGIC)?.strip_prefix(&VERSION.to_le_bytes())?.strip_prefix(key.as_bytes())?;
    let (len, checksum) = rest.split_first_chunk::<8>()?;
    let (len, checksum) = (u64::from_le_bytes(*len), u32::from_le_bytes(*checksum.first_chunk()?));
    // Before memory is taken, the file must have the length that its header states.
    let whole = file.metadata().ok()?.len() == len.checked_add(HEADER_LEN as u64)?;
    (whole && len <= Limits::default().file_bytes).then_some(())?;
    Some(Opened { file, len: usize::try_from(len).ok()?, checksum })
}

/// The content of the entry of a key; `None` when there is none that is whole.
pub(super) fn read(path: &Path, key: &Hash) -> Option<Vec<u8>> {
    let mut opened = open(path, key)?;
    let mut content = bytemuck::allocation::try_zeroed_vec::<u8>(opened.len).ok()?;
    opened.file.read_exact(&mut content).ok()?;
    (crc32fast::hash(&content) == opened.checksum).then_some(content)
}
