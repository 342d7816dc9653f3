//! Text files.

use std::path::Path;

use crate::{IoError, file};

/// Largest text file that is read, bytes.
pub const TEXT_LIMIT: u64 = 64 << 20;

const BOM: char = '\u{feff}';

/// A whole UTF-8 text file, without a byte order mark.
///
/// # Errors
/// When the file cannot be read, is larger than [`TEXT_LIMIT`], or is not UTF-8 (with the line of the bad byte).
pub fn read_to_string(path: &Path) -> Result<String, IoError> {
    from_bytes(file::read(path, TEXT_LIMIT)?, path)
}

/// As [`read_to_string`], from memory; `path` is only named in errors.
///
/// # Errors
/// When the bytes are not UTF-8.
pub fn from_bytes(bytes: Vec<u8>, path: &Path) -> Result<String, IoError> {
    match String::from_utf8(bytes) {
        Ok(mut text) => {
            if text.starts_with(BOM) {
                text.drain(..BOM.len_utf8());
            }
            Ok(text)
        }
        Err(error) => {
            let good = error.utf8_error().valid_up_to();
            let lines = error.as_bytes().iter().take(good).filter(|&&b| b == b'\n').count();
            Err(IoError::NotUtf8 { path: path.to_owned(), line: lines + 1 })
        }
    }
}

/// A text of UTF-16 units in a byte order.
pub(crate) fn utf16(big_endian: bool, bytes: &[u8]) -> String {
    let load = if big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
    let units: Vec<u16> = bytes.as_chunks().0.iter().map(|b| load(*b)).collect();
    String::from_utf16_lossy(&units)
}

/// JSON in ASCII, for the text fields of formats that know nothing else. Empty where the value has no JSON, which
/// the plain structures written here always have.
pub(crate) fn ascii_json(value: &impl serde::Serialize) -> String {
    let json = serde_json::to_string(value).unwrap_or_default();
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() {
            out.push(c);
        } else {
            out.extend(c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_a_bad_byte_is_named() {
        let error = from_bytes(b"a\nb\n\xff".to_vec(), Path::new("x.toml")).unwrap_err();
        assert_eq!(error.to_string(), "x.toml: line 3 is not UTF-8 text");
    }

    #[test]
    fn a_byte_order_mark_is_dropped() {
        assert_eq!(from_bytes("\u{feff}a = 1".into(), Path::new("x")).unwrap(), "a = 1");
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = read_to_string(Path::new("no-such-file.toml")).unwrap_err();
        assert!(error.to_string().starts_with("cannot read no-such-file.toml"));
    }
}
