//! NumPy's `.npy` (format 1.0 and 2.0), little-endian in C order: `f4`, `f8`, `u2`; written also `u1`, `u4`, `u8`.

use std::io::Write;
use std::path::Path;

use crate::{IoError, Limits, file, write};

const MAGIC: &[u8; 6] = b"\x93NUMPY";
// NumPy aligns the data so that they can be mapped into memory.
const ALIGNMENT: usize = 64;
const EXPECTED: &str = "a NumPy .npy file of format 1, 2 or 3";
/// Bytes before the text of the longest header.
const PREFIX: usize = 12;
/// Headers of arrays without structures take less than a line.
const HEADER_LIMIT: usize = 1 << 16;

/// A type of element.
pub trait Element: Copy + sealed::Sealed {
    /// How NumPy calls it.
    const DESCR: &'static str;
    #[doc(hidden)]
    fn extend(self, out: &mut Vec<u8>);
    /// From as many bytes as it has; 0 from fewer.
    #[doc(hidden)]
    fn from_le(bytes: &[u8]) -> Self;
}

mod sealed {
    pub trait Sealed {}
}

macro_rules! element {
    ($($t:ty => $descr:literal),*) => {$(
        impl sealed::Sealed for $t {}
        impl Element for $t {
            const DESCR: &'static str = $descr;
            fn extend(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn from_le(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or(Self::default(), |b| Self::from_le_bytes(*b))
            }
        }
    )*};
}
element!(f32 => "<f4", f64 => "<f8", u8 => "|u1", u16 => "<u2", u32 => "<u4", u64 => "<u8");

/// The elements of an array.
#[derive(Debug, Clone, PartialEq)]
pub enum NpyData {
    /// `<f4`.
    F32(Vec<f32>),
    /// `<f8`.
    F64(Vec<f64>),
    /// `<u2`.
    U16(Vec<u16>),
}

/// An array: its elements in C order (the last index runs fastest).
#[derive(Debug, Clone, PartialEq)]
pub struct NpyArray {
    /// Length of every axis; none for a single number.
    pub shape: Vec<usize>,
    /// As many elements as the shape states.
    pub data: NpyData,
}

impl NpyArray {
    /// The elements in single precision.
    #[must_use]
    pub fn to_f32(&self) -> Vec<f32> {
        match &self.data {
            NpyData::F32(v) => v.clone(),
            NpyData::F64(v) => v.iter().map(|&x| x as f32).collect(),
            NpyData::U16(v) => v.iter().map(|&x| f32::from(x)).collect(),
        }
    }
}

/// Writes an array in C order.
///
/// # Errors
/// When the number of elements is not that of the shape, or the file cannot be written.
pub fn write<T: Element>(path: &Path, shape: &[usize], data: &[T]) -> Result<(), IoError> {
    if shape.iter().try_fold(1usize, |p, &n| p.checked_mul(n)) != Some(data.len()) {
        let found = format!("{shape:?}");
        return Err(IoError::field(path, "shape", found, format!("a shape of {} elements", data.len())));
    }
    let header = header(T::DESCR, shape)
        .ok_or_else(|| IoError::field(path, "shape", format!("{} axes", shape.len()), "fewer axes"))?;
    write::stream(path, |out| {
        out.write_all(&header)?;
        let mut bytes = Vec::with_capacity(1 << 16);
        for chunk in data.chunks(1 << 13) {
            bytes.clear();
            chunk.iter().for_each(|v| v.extend(&mut bytes));
            out.write_all(&bytes)?;
        }
        Ok(())
    })
}

/// The header of an array in C order; `None` when it has too many axes.
pub(crate) fn header(descr: &str, shape: &[usize]) -> Option<Vec<u8>> {
    let mut axes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    // A tuple of one keeps its comma.
    if shape.len() > 1 {
        axes.truncate(axes.len() - 2);
    }
    let mut text =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({}), }}", axes.trim_end());
    let unpadded = MAGIC.len() + 4 + text.len() + 1;
    text.push_str(&" ".repeat(unpadded.next_multiple_of(ALIGNMENT) - unpadded));
    text.push('\n');
    let length = u16::try_from(text.len()).ok()?;
    Some([MAGIC, &[1, 0][..], &length.to_le_bytes(), text.as_bytes()].concat())
}

/// Reads an array of `f4`, `f8` or `u2`, little-endian, in C order.
///
/// # Errors
/// When the file cannot be read, is not an `.npy`, holds another type or order, or its length is not that of its
/// shape.
pub fn read(path: &Path, limits: Limits) -> Result<NpyArray, IoError> {
    from_bytes(&file::read(path, limits.file_bytes)?, path)
}

/// As [`read`], from memory; `path` is only named.
pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<NpyArray, IoError> {
    let start = |n: usize| Ok(bytes.get(..n).unwrap_or(bytes).to_vec());
    let Header { descr, fortran, shape, start } = Header::parse("", path, start)?;
    if fortran {
        return Err(IoError::field(path, "fortran_order", "True", "False: elements in C order"));
    }
    let size = match descr.as_str() {
        "<f4" => 4,
        "<f8" => 8,
        "<u2" => 2,
        _ => return Err(IoError::field(path, "descr", format!("'{descr}'"), "'<f4', '<f8' or '<u2'")),
    };
    let data = bytes.get(start..).unwrap_or_default();
    let need = shape.iter().try_fold(size, |p: usize, &n| p.checked_mul(n)).unwrap_or(usize::MAX);
    if need > data.len() {
        return Err(IoError::truncated(path, "the array", need as u64, data.len() as u64));
    }
    if need < data.len() {
        let found = format!("{} bytes long", data.len());
        return Err(IoError::field(path, "the data", found, format!("{need} bytes for the shape {shape:?}")));
    }
    let data = match size {
        2 => NpyData::U16(data.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect()),
        4 => NpyData::F32(data.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()),
        _ => NpyData::F64(data.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()),
    };
    Ok(NpyArray { shape, data })
}

/// The header of an array.
pub(crate) struct Header {
    /// The type of the elements in the words of NumPy, without quotation marks; of a structure not its fields.
    pub(crate) descr: String,
    /// Whether the first index runs fastest.
    pub(crate) fortran: bool,
    pub(crate) shape: Vec<usize>,
    /// Where the elements begin.
    pub(crate) start: usize,
}

impl Header {
    /// From the first bytes of a file: `start(n)` gives `n` of them, or all where there are fewer. Errors call the array by its name,
    /// if it has one.
    pub(crate) fn parse(
        name: &str,
        path: &Path,
        start: impl Fn(usize) -> Result<Vec<u8>, IoError>,
    ) -> Result<Self, IoError> {
        let field = |key: &str| if name.is_empty() { key.to_owned() } else { format!("{name}: {key}") };
        let wrong = |what: &str| {
            IoError::field(path, if name.is_empty() { "the array" } else { name }, what, EXPECTED)
        };
        let (begin, length) = match start(PREFIX)?.strip_prefix(MAGIC) {
            Some([1, _, a, b, ..]) => (10, usize::from(u16::from_le_bytes([*a, *b]))),
            Some([2 | 3, _, a, b, c, d, ..]) => (PREFIX, u32::from_le_bytes([*a, *b, *c, *d]) as usize),
            _ if name.is_empty() => return Err(IoError::unknown(path, EXPECTED)),
            _ => return Err(wrong("something else")),
        };
        if length > HEADER_LIMIT {
            return Err(wrong("one with a header of more than 65536 bytes"));
        }
        let bytes = start(begin + length)?;
        let text = bytes.get(begin..begin + length).ok_or_else(|| wrong("cut short"))?;
        let text = String::from_utf8_lossy(text);
        // The header is a Python dictionary in one line.
        let value = |key: &str| {
            let (_, rest) = text.split_once(&format!("'{key}'"))?;
            rest.trim_start().strip_prefix(':').map(str::trim_start)
        };
        let descr = value("descr").unwrap_or("absent");
        let descr = descr.strip_prefix('\'').and_then(|d| d.split_once('\'')).map_or("a structure", |d| d.0);
        let fortran = match value("fortran_order") {
            Some(v) if v.starts_with("True") => true,
            Some(v) if v.starts_with("False") => false,
            _ => return Err(IoError::field(path, field("fortran_order"), "absent", "True or False")),
        };
        let lengths = |tuple: &str| -> Option<Vec<usize>> {
            let (tuple, _) = tuple.strip_prefix('(')?.split_once(')')?;
            tuple.split(',').map(str::trim).filter(|n| !n.is_empty()).map(|n| n.parse().ok()).collect()
        };
        let shape = value("shape").and_then(lengths).ok_or_else(|| {
            IoError::field(path, field("shape"), "absent or no lengths", "a tuple of lengths")
        })?;
        Ok(Self { descr: descr.to_owned(), fortran, shape, start: begin + length })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn bytes_of<T: Element>(shape: &[usize], data: &[T]) -> Vec<u8> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.npy");
        write(&path, shape, data).unwrap();
        std::fs::read(path).unwrap()
    }

    #[test]
    fn the_header_is_that_of_numpy() {
        let bytes = bytes_of(&[2, 3], &[0f32; 6]);
        assert_eq!(bytes.len(), 128 + 24);
        assert!(bytes[10..].starts_with(b"{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }  "));
        assert_eq!(bytes[127], b'\n');
        assert!(bytes_of(&[6], &[0u16; 6]).windows(14).any(|w| w == b"'shape': (6,),"));
        assert!(bytes_of(&[], &[0f64]).windows(12).any(|w| w == b"'shape': (),"));
    }

    #[test]
    fn what_is_not_read_is_said() {
        let path = Path::new("a.npy");
        let error = |b: &[u8]| from_bytes(b, path).unwrap_err().to_string();
        assert!(error(b"x").contains("a NumPy .npy file"));
        let good = bytes_of(&[2, 3], &[0f32; 6]);
        assert!(error(&good[..140]).contains("the array needs 24 bytes, but the file has 12"));
        let text = |from: &str, to: &str| {
            let at = good.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
            let mut b = good.clone();
            b[at..at + from.len()].copy_from_slice(to.as_bytes());
            error(&b)
        };
        assert!(text("<f4", ">f4").contains("descr is '>f4'; expected '<f4', '<f8' or '<u2'"));
        assert!(text("False", "True ").contains("C order"));
        assert!(text("False", "Fals ").contains("fortran_order is absent"));
        assert!(text("(2, 3)", "(2, 2)").contains("24 bytes long; expected 16 bytes"));
        assert!(write(path, &[4], &[1u16; 3]).unwrap_err().to_string().contains("a shape of 3 elements"));
    }

    proptest! {
        #[test]
        fn arrays_read_back_equal((r, c) in (0usize..6, 0usize..6), seed in any::<u32>()) {
            let floats: Vec<f32> = (0..r * c).map(|i| f32::from_bits((seed ^ i as u32) & 0x7f7f_ffff)).collect();
            let back = from_bytes(&bytes_of(&[r, c], &floats), Path::new("a")).unwrap();
            prop_assert_eq!(back, NpyArray { shape: vec![r, c], data: NpyData::F32(floats) });
        }

        #[test]
        fn mutated_and_random_files_are_read_or_refused(at in any::<prop::sample::Index>(), v in any::<u8>(), rest in prop::collection::vec(any::<u8>(), 0..200)) {
            let mut bytes = bytes_of(&[2, 3], &[0f32; 6]);
            let i = at.index(bytes.len());
            bytes[i] = v;
            let _ = from_bytes(&bytes, Path::new("a"));
            let _ = from_bytes(&[MAGIC, &rest[..]].concat(), Path::new("a"));
        }
    }
}
