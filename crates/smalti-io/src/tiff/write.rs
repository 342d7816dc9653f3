//! Writing the directories of TIFF files, little-endian.

use std::collections::BTreeMap;
use std::io::{self, Write};

use super::tags::{ROWS_PER_STRIP, STRIP_BYTE_COUNTS, STRIP_OFFSETS};

/// The fields of an image by their tags.
pub(crate) type Fields = BTreeMap<u16, Value>;

/// Content of a field.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Byte(Vec<u8>),
    Ascii(String),
    Short(Vec<u16>),
    Long(Vec<u32>),
    /// Numerators and denominators.
    Rational(Vec<[u32; 2]>),
    SignedRational(Vec<[i32; 2]>),
    Undefined(Vec<u8>),
    /// Places and lengths, of 32 bits or, in BigTIFF, of 64.
    Places(Vec<u64>),
}

impl Value {
    /// Type, count and bytes.
    fn encoded(&self, wide: bool) -> (u16, usize, Vec<u8>) {
        match self {
            Self::Byte(v) => (1, v.len(), v.clone()),
            Self::Ascii(s) => (2, s.len() + 1, s.bytes().chain([0]).collect()),
            Self::Short(v) => (3, v.len(), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Self::Long(v) => (4, v.len(), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Self::Rational(v) => (5, v.len(), v.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()),
            Self::Undefined(v) => (7, v.len(), v.clone()),
            Self::SignedRational(v) => {
                (10, v.len(), v.iter().flatten().flat_map(|x| x.to_le_bytes()).collect())
            }
            Self::Places(v) => {
                let (kind, len) = if wide { (16, 8) } else { (4, 4) };
                (kind, v.len(), v.iter().flat_map(|x| x.to_le_bytes().into_iter().take(len)).collect())
            }
        }
    }
}

/// A directory at an offset of the file, followed by the content of its fields. Each content begins at a multiple of
/// `align` bytes behind the entries. The next directory follows unless this is the last.
pub(crate) fn directory(fields: &Fields, at: u64, (wide, align): (bool, usize), last: bool) -> Vec<u8> {
    let (count_len, entry_len, place_len) = if wide { (8, 20, 8) } else { (2, 12, 4) };
    let place = |v: u64| v.to_le_bytes().into_iter().take(place_len);
    let values_at = at + (count_len + entry_len * fields.len() + place_len) as u64;
    let mut values: Vec<u8> = Vec::new();
    let mut out: Vec<u8> = (fields.len() as u64).to_le_bytes().into_iter().take(count_len).collect();
    for (tag, value) in fields {
        let (kind, count, mut bytes) = value.encoded(wide);
        out.extend(tag.to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(place(count as u64));
        if bytes.len() <= place_len {
            bytes.resize(place_len, 0);
            out.extend(bytes);
        } else {
            out.extend(place(values_at + values.len() as u64));
            bytes.resize(bytes.len().next_multiple_of(align), 0);
            values.extend(bytes);
        }
    }
    let next = values_at + values.len() as u64;
    out.extend(place(if last { 0 } else { next }));
    out.extend(values);
    out
}

/// Writes header and fields of a file with one image in one strip of `rows` rows and `data_len` bytes, which the caller writes next.
pub(crate) fn write_header(
    out: &mut impl Write,
    mut fields: Fields,
    rows: u32,
    data_len: u64,
) -> io::Result<()> {
    const BEGIN: &[u8] = b"II*\0\x08\0\0\0";
    let narrow = |n: u64| {
        let too_long = |_| io::Error::new(io::ErrorKind::FileTooLarge, "a TIFF file ends at 4 GiB");
        u32::try_from(n).map(|n| Value::Long(vec![n])).map_err(too_long)
    };
    let directory = |fields: &Fields| directory(fields, BEGIN.len() as u64, (false, 2), true);
    fields.insert(ROWS_PER_STRIP, Value::Long(vec![rows]));
    fields.insert(STRIP_BYTE_COUNTS, narrow(data_len)?);
    // The length of the directory does not depend on the place of the strip.
    fields.insert(STRIP_OFFSETS, Value::Long(vec![0]));
    let data_at = (BEGIN.len() + directory(&fields).len()).next_multiple_of(16);
    narrow(data_at as u64 + data_len)?;
    fields.insert(STRIP_OFFSETS, narrow(data_at as u64)?);
    let mut head = [BEGIN, &directory(&fields)].concat();
    head.resize(data_at, 0);
    out.write_all(&head)
}
