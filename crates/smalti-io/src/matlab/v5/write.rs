//! Writing MAT-files of level 5, little-endian and not compressed.

use std::io::{self, Write};

use super::super::content::{Item, column_major};
use super::{class, tag};

// MATLAB itself refuses variables of level 5 that are larger.
pub(in crate::matlab) const LARGEST: u64 = (1 << 31) - 1;

/// Bytes of the largest variable.
pub(in crate::matlab) fn largest(variables: &[(&str, Item)]) -> u64 {
    variables.iter().map(|(name, item)| matrix_bytes(name, item)).max().unwrap_or(0)
}

/// Writes a file.
pub(in crate::matlab) fn write(out: &mut impl Write, variables: &[(&str, Item)]) -> io::Result<()> {
    let text = "MATLAB 5.0 MAT-file, written by Smalti";
    out.write_all(format!("{text:116}").as_bytes())?;
    // No subsystem data; version 1.0; the byte order.
    out.write_all(&[0; 8])?;
    out.write_all(&[0, 1, b'I', b'M'])?;
    variables.iter().try_for_each(|(name, item)| matrix(out, name, item))
}

/// Bytes of an element of so many bytes with its tag, padded.
fn padded(bytes: u64) -> u64 {
    8 + bytes.next_multiple_of(8)
}

/// Bytes of the data of a matrix element, without its tag.
fn matrix_bytes(name: &str, item: &Item) -> u64 {
    let dims = if matches!(item, Item::Cube(_)) { 12 } else { 8 };
    let header = padded(8) + padded(dims) + padded(name.len() as u64);
    header
        + match item {
            Item::Cube(planes) => padded(4 * planes.data().len() as u64),
            Item::Column(values) => padded(8 * values.len() as u64),
            Item::Text(text) => padded(2 * text.encode_utf16().count() as u64),
            Item::Struct(fields) => {
                let names = padded(field_width(fields) as u64 * fields.len() as u64);
                // The length of a name is a small element.
                8 + names + fields.iter().map(|(_, item)| 8 + matrix_bytes("", item)).sum::<u64>()
            }
        }
}

/// Bytes of the names of fields, with a zero at the end of each.
fn field_width(fields: &[(&str, Item)]) -> usize {
    fields.iter().map(|(name, _)| name.len() + 1).max().unwrap_or(1)
}

fn tag(out: &mut impl Write, kind: u32, bytes: u64) -> io::Result<()> {
    out.write_all(&kind.to_le_bytes())?;
    // Larger ones were refused before.
    out.write_all(&(bytes as u32).to_le_bytes())
}

fn element(out: &mut impl Write, kind: u32, bytes: &[u8]) -> io::Result<()> {
    tag(out, kind, bytes.len() as u64)?;
    out.write_all(bytes)?;
    pad(out, bytes.len() as u64)
}

fn pad(out: &mut impl Write, bytes: u64) -> io::Result<()> {
    let zeros = (bytes.next_multiple_of(8) - bytes) as usize;
    out.write_all([0; 8].get(..zeros).unwrap_or_default())
}

fn matrix(out: &mut impl Write, name: &str, item: &Item) -> io::Result<()> {
    tag(out, tag::MATRIX, matrix_bytes(name, item))?;
    let (class, dims) = match item {
        Item::Cube(p) => (class::SINGLE, vec![p.rows(), p.cols(), p.count()]),
        Item::Column(values) => (class::DOUBLE, vec![values.len(), 1]),
        Item::Text(text) => (class::CHAR, vec![usize::from(!text.is_empty()), text.encode_utf16().count()]),
        Item::Struct(_) => (class::STRUCT, vec![1, 1]),
    };
    element(out, tag::UINT32, &[class, 0, 0, 0, 0, 0, 0, 0])?;
    let dims: Vec<u8> = dims.iter().flat_map(|&d| (d as u32).to_le_bytes()).collect();
    element(out, tag::INT32, &dims)?;
    element(out, tag::INT8, name.as_bytes())?;
    match item {
        Item::Cube(planes) => {
            let bytes = 4 * planes.data().len() as u64;
            tag(out, tag::SINGLE, bytes)?;
            for plane in planes.planes() {
                let column_major: Vec<u8> =
                    column_major(plane, planes.rows()).flat_map(f32::to_le_bytes).collect();
                out.write_all(&column_major)?;
            }
            pad(out, bytes)
        }
        Item::Column(values) => {
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            element(out, tag::DOUBLE, &bytes)
        }
        Item::Text(text) => {
            let bytes: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
            // As MATLAB does: SciPy takes the first for the encoding of the system.
            element(out, if text.is_ascii() { tag::UINT16 } else { tag::UTF16 }, &bytes)
        }
        Item::Struct(fields) => {
            let width = field_width(fields);
            out.write_all(&[5, 0, 4, 0])?;
            out.write_all(&(width as u32).to_le_bytes())?;
            let mut names = Vec::with_capacity(width * fields.len());
            for (name, _) in fields {
                names.extend_from_slice(name.as_bytes());
                names.resize(names.len().next_multiple_of(width), 0);
            }
            element(out, tag::INT8, &names)?;
            fields.iter().try_for_each(|(_, item)| matrix(out, "", item))
        }
    }
}
