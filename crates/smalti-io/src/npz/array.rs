//! The header of a NumPy array.

use std::path::Path;

use crate::IoError;
use crate::npy::Header;
use crate::raster::{Axis, Kind, Raster};

/// Elements of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    Number(Kind),
    /// Characters of four bytes.
    Unicode,
    /// Characters of one byte.
    Bytes,
    /// Complex numbers, structures, objects, times.
    Other,
}

/// An array whose elements have not been read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    /// In an archive its name without `.npy`.
    pub(super) name: String,
    descr: String,
    pub(super) kind: Type,
    big_endian: bool,
    fortran: bool,
    pub(super) shape: Vec<usize>,
    /// Where the elements begin in its file.
    pub(super) start: u64,
}

impl Array {
    /// From the first bytes of its file: `start(n)` gives `n` of them, or all where there are fewer.
    pub(super) fn parse(
        name: &str,
        path: &Path,
        start: impl Fn(usize) -> Result<Vec<u8>, IoError>,
    ) -> Result<Self, IoError> {
        let Header { descr, fortran, shape, start } = Header::parse(name, path, start)?;
        let (kind, big_endian) = kind(&descr);
        Ok(Self { name: name.to_owned(), descr, kind, big_endian, fortran, shape, start: start as u64 })
    }

    /// The layout of the cube in its file, for these axes.
    pub(super) fn raster(&self, axes: [Axis; 3], path: &Path) -> Result<Raster, IoError> {
        let Type::Number(kind) = self.kind else {
            let key = if self.name.is_empty() { "descr" } else { &self.name };
            let found = format!("of type '{}'", self.descr);
            return Err(IoError::field(path, key, found, "f2, f4, f8, u1 to u8 or i1 to i8"));
        };
        let len = |axis: Axis| axes.iter().zip(&self.shape).find(|(a, _)| **a == axis).map_or(0, |(_, n)| *n);
        let mut order = axes;
        if self.fortran {
            order.reverse();
        }
        Ok(Raster {
            kind,
            big_endian: self.big_endian,
            bands: len(Axis::Band),
            rows: len(Axis::Row),
            cols: len(Axis::Col),
            order,
        })
    }

    /// Length of a plain list, or 1 of a single number.
    pub(super) fn list_len(&self) -> Option<usize> {
        let count = self.shape.iter().try_fold(1usize, |n, len| n.checked_mul(*len))?;
        (matches!(self.kind, Type::Number(_)) && (self.shape.len() < 2 || count == 1)).then_some(count)
    }

    /// The numbers of a list.
    pub(super) fn numbers(&self, elements: &[u8]) -> Vec<f64> {
        let Type::Number(kind) = self.kind else { return Vec::new() };
        kind.numbers(self.big_endian, elements)
    }

    /// The text of a single string.
    pub(super) fn text(&self, elements: &[u8]) -> Option<String> {
        let text: String = match self.kind {
            Type::Unicode => {
                let load = if self.big_endian { u32::from_be_bytes } else { u32::from_le_bytes };
                elements.as_chunks().0.iter().filter_map(|b| char::from_u32(load(*b))).collect()
            }
            Type::Bytes => String::from_utf8_lossy(elements).into_owned(),
            _ => return None,
        };
        Some(text.trim_end_matches('\0').to_owned())
    }
}

fn kind(descr: &str) -> (Type, bool) {
    let big_endian = descr.starts_with('>');
    let name = descr.trim_start_matches(['<', '>', '|']);
    let number = match name {
        "u1" | "b1" => Kind::U8,
        "i1" => Kind::I8,
        "u2" => Kind::U16,
        "i2" => Kind::I16,
        "u4" => Kind::U32,
        "i4" => Kind::I32,
        "u8" => Kind::U64,
        "i8" => Kind::I64,
        "f2" => Kind::F16,
        "f4" => Kind::F32,
        "f8" => Kind::F64,
        _ if name.starts_with('U') => return (Type::Unicode, big_endian),
        _ if name.starts_with('S') => return (Type::Bytes, big_endian),
        _ => return (Type::Other, big_endian),
    };
    (Type::Number(number), big_endian)
}

/// The axes of a cube of `bands` wavelengths: the one that has their number, then rows and columns.
pub(super) fn axes(path: &Path, shape: &[usize], bands: usize) -> Result<[Axis; 3], IoError> {
    let matching: Vec<bool> = shape.iter().map(|n| *n == bands).collect();
    match matching[..] {
        [true, false, false] => Ok([Axis::Band, Axis::Row, Axis::Col]),
        [false, true, false] => Ok([Axis::Row, Axis::Band, Axis::Col]),
        [false, false, true] => Ok([Axis::Row, Axis::Col, Axis::Band]),
        [false, false, false] => {
            let expected = format!("an axis of {bands}, the number of wavelengths");
            Err(IoError::field(path, "shape", format!("{shape:?}"), expected))
        }
        [_, _, _] => {
            let found = format!("{shape:?}, where more than one axis has as many as there are wavelengths");
            let expected =
                "one, or an array `axes` that says 'band row column' or another order of the three";
            Err(IoError::field(path, "shape", found, expected))
        }
        _ => Err(IoError::field(path, "shape", format!("{shape:?}"), "three axes")),
    }
}

/// Axes by their names.
pub(super) fn named_axes(text: &str) -> Option<[Axis; 3]> {
    let axis = |word: &str| match word {
        "band" | "bands" | "wavelength" | "wavelengths" => Some(Axis::Band),
        "row" | "rows" => Some(Axis::Row),
        "col" | "cols" | "column" | "columns" => Some(Axis::Col),
        _ => None,
    };
    let words = text.split(|c: char| !c.is_ascii_alphabetic()).filter(|w| !w.is_empty());
    let axes: Option<Vec<Axis>> = words.map(axis).collect();
    let axes: [Axis; 3] = axes?.try_into().ok()?;
    let all = [Axis::Band, Axis::Row, Axis::Col].iter().all(|a| axes.contains(a));
    all.then_some(axes)
}
