//! Writing stored ZIP archives of any size.

use std::io::{self, Write};

/// 1 January 1980, the earliest date there is: equal arrays give equal files.
const DATE: u16 = 1 << 5 | 1;
/// 2.0, the version of plain archives; 4.5, that of numbers of 64 bits.
const VERSION: u16 = 20;
const VERSION_64: u16 = 45;

/// A file that is stored as it is.
pub(crate) struct Stored {
    pub(crate) name: String,
    pub(crate) crc: u32,
    pub(crate) size: u64,
    /// The offset of its header.
    pub(crate) at: u64,
}

fn narrow(v: u64) -> u32 {
    u32::try_from(v).unwrap_or(u32::MAX)
}

impl Stored {
    /// Writes an array that consists of these pieces, with its header at the offset `at`, which is moved to its end.
    pub(crate) fn write(
        out: &mut impl Write,
        array: &str,
        pieces: &[&[u8]],
        at: &mut u64,
    ) -> io::Result<Self> {
        let mut crc = crc32fast::Hasher::new();
        pieces.iter().for_each(|p| crc.update(p));
        let size = pieces.iter().map(|p| p.len() as u64).sum();
        let stored = Self { name: format!("{array}.npy"), crc: crc.finalize(), size, at: *at };
        let local = stored.local();
        *at += local.len() as u64 + size;
        out.write_all(&local)?;
        pieces.iter().try_for_each(|piece| out.write_all(piece))?;
        Ok(stored)
    }

    fn wide(&self) -> bool {
        self.size >= u64::from(u32::MAX)
    }

    /// The fields that the header before the file and its entry in the list share, up to the length of the extra field.
    fn common(&self, version: u16, extra: usize) -> Vec<u8> {
        let mut out = Vec::new();
        // Version needed, no flags, stored, time, date.
        [version, 0, 0, 0, DATE].iter().for_each(|v| out.extend(v.to_le_bytes()));
        let size = if self.wide() { u32::MAX } else { narrow(self.size) };
        [self.crc, size, size].iter().for_each(|v| out.extend(v.to_le_bytes()));
        [self.name.len() as u16, extra as u16].iter().for_each(|v| out.extend(v.to_le_bytes()));
        out
    }

    /// The header before the file. Its length does not depend on the check sum.
    pub(crate) fn local(&self) -> Vec<u8> {
        let mut extra = Vec::new();
        if self.wide() {
            [1u16, 16].iter().for_each(|v| extra.extend(v.to_le_bytes()));
            [self.size; 2].iter().for_each(|v| extra.extend(v.to_le_bytes()));
        }
        let version = if self.wide() { VERSION_64 } else { VERSION };
        [b"PK\x03\x04", &*self.common(version, extra.len()), self.name.as_bytes(), &extra].concat()
    }

    fn list(&self, out: &mut Vec<u8>) {
        let (wide, far) = (self.wide(), self.at >= u64::from(u32::MAX));
        let mut numbers: Vec<u64> = Vec::new();
        if wide {
            numbers.extend([self.size; 2]);
        }
        if far {
            numbers.push(self.at);
        }
        let mut extra = Vec::new();
        if !numbers.is_empty() {
            [1u16, 8 * numbers.len() as u16].iter().for_each(|v| extra.extend(v.to_le_bytes()));
            numbers.iter().for_each(|v| extra.extend(v.to_le_bytes()));
        }
        let version = if wide || far { VERSION_64 } else { VERSION };
        out.extend(b"PK\x01\x02");
        out.extend(version.to_le_bytes());
        out.extend(self.common(version, extra.len()));
        // No comment, first disk, no attributes.
        out.extend([0; 10]);
        out.extend(if far { u32::MAX } else { narrow(self.at) }.to_le_bytes());
        out.extend(self.name.as_bytes());
        out.extend(extra);
    }
}

/// The end of an archive: its list, which is at the offset `at`, and the records that state where it is.
pub(crate) fn end(members: &[Stored], at: u64) -> Vec<u8> {
    let mut out = Vec::new();
    members.iter().for_each(|m| m.list(&mut out));
    let size = out.len() as u64;
    if at >= u64::from(u32::MAX) {
        let record = at + size;
        out.extend(b"PK\x06\x06");
        out.extend(44u64.to_le_bytes());
        [VERSION_64; 2].iter().for_each(|v| out.extend(v.to_le_bytes()));
        out.extend([0; 8]);
        [members.len() as u64, members.len() as u64, size, at]
            .iter()
            .for_each(|v| out.extend(v.to_le_bytes()));
        out.extend(b"PK\x06\x07\0\0\0\0");
        out.extend(record.to_le_bytes());
        out.extend(1u32.to_le_bytes());
    }
    out.extend(b"PK\x05\x06\0\0\0\0");
    [members.len() as u16; 2].iter().for_each(|v| out.extend(v.to_le_bytes()));
    [narrow(size), narrow(at)].iter().for_each(|v| out.extend(v.to_le_bytes()));
    out.extend([0, 0]);
    out
}
