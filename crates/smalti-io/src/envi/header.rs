//! The text of an ENVI header: `key = value`, values over several lines in braces.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use crate::IoError;
use crate::raster::{Axis, Kind};

/// The fields of a header by their keys, in lower case.
pub(super) struct Fields<'a> {
    path: &'a Path,
    fields: BTreeMap<String, String>,
}

impl<'a> Fields<'a> {
    pub(super) fn parse(bytes: &[u8], path: &'a Path) -> Result<Self, IoError> {
        // Headers are of many encodings; what is read here is ASCII.
        let text = String::from_utf8_lossy(bytes);
        let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate();
        if lines.next().is_none_or(|(_, first)| first.trim() != "ENVI") {
            return Err(IoError::unknown(path, "an ENVI header (its first line is ENVI)"));
        }
        let wrong = |at: usize, found: String, expected: &str| IoError::line(path, at + 1, found, expected);
        let mut fields = BTreeMap::new();
        while let Some((number, line)) = lines.next() {
            let Some((key, value)) = line.split_once('=').filter(|_| !line.starts_with(';')) else {
                continue;
            };
            let key = key.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
            let mut value = value.trim().to_owned();
            if value.starts_with('{') {
                while !value.ends_with('}') {
                    let Some((_, next)) = lines.next() else {
                        let found = format!("'{key} = {{'");
                        return Err(wrong(number, found, "a closing brace at the end of a line"));
                    };
                    if !next.starts_with(';') {
                        value.push('\n');
                        value.push_str(next.trim());
                    }
                }
            }
            if fields.insert(key.clone(), value).is_some() {
                return Err(wrong(number, format!("'{key}' a second time"), "each key once"));
            }
        }
        Ok(Self { path, fields })
    }

    /// As it is written in the file, braces included.
    pub(super) fn raw(&self, key: &str) -> Option<&str> {
        self.fields.get(key).map(String::as_str).filter(|v| !v.is_empty())
    }

    /// Without braces.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        let raw = self.raw(key)?;
        let inner = raw.strip_prefix('{').and_then(|r| r.strip_suffix('}'));
        Some(inner.unwrap_or(raw).trim()).filter(|t| !t.is_empty())
    }

    pub(super) fn error(&self, key: &str, expected: impl Into<String>) -> IoError {
        let found = match self.raw(key) {
            Some(value) => format!("'{}'", value.chars().take(60).collect::<String>()),
            None => "absent".into(),
        };
        IoError::field(self.path, key, found, expected)
    }

    fn parsed<T: FromStr>(&self, key: &str, expected: &str) -> Result<Option<T>, IoError> {
        let parse = |t: &str| t.parse().map_err(|_| self.error(key, expected));
        self.text(key).map(parse).transpose()
    }

    /// A length that must be there.
    pub(super) fn length(&self, key: &str) -> Result<usize, IoError> {
        let expected = "a whole number above 0";
        let number: Option<usize> = self.parsed(key, expected)?;
        number.filter(|n| *n > 0).ok_or_else(|| self.error(key, expected))
    }

    pub(super) fn whole_number(&self, key: &str) -> Result<Option<u64>, IoError> {
        self.parsed(key, "a whole number, not negative")
    }

    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, IoError> {
        self.parsed(key, "a number")
    }

    /// One text for each band.
    pub(super) fn list(&self, key: &str, bands: usize) -> Result<Option<Vec<&str>>, IoError> {
        let Some(text) = self.text(key) else { return Ok(None) };
        let items: Vec<&str> = text.split(',').map(str::trim).filter(|t| !t.is_empty()).collect();
        if items.len() != bands {
            let found = format!("a list of {}", items.len());
            return Err(IoError::field(self.path, key, found, format!("one for each of the {bands} bands")));
        }
        Ok(Some(items))
    }

    /// One finite number for each band.
    pub(super) fn numbers(&self, key: &str, bands: usize) -> Result<Option<Vec<f64>>, IoError> {
        let Some(items) = self.list(key, bands)? else { return Ok(None) };
        let number = |(i, item): (usize, &&str)| {
            item.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
                IoError::field(self.path, key, format!("'{item}' in band {}", i + 1), "a finite number")
            })
        };
        items.iter().enumerate().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// How samples are stored.
    pub(super) fn kind(&self) -> Result<Kind, IoError> {
        Ok(match self.text("data type") {
            Some("1") => Kind::U8,
            Some("2") => Kind::I16,
            Some("3") => Kind::I32,
            Some("4") => Kind::F32,
            Some("5") => Kind::F64,
            Some("12") => Kind::U16,
            Some("13") => Kind::U32,
            Some("14") => Kind::I64,
            Some("15") => Kind::U64,
            Some("6" | "9") => {
                let expected = "real numbers, as radiance and reflectance are (6 and 9 are complex)";
                return Err(self.error("data type", expected));
            }
            _ => return Err(self.error("data type", "1, 2, 3, 4, 5, 12, 13, 14 or 15")),
        })
    }

    /// Whether the most significant byte comes first. A file of a byte a sample need not say.
    pub(super) fn big_endian(&self, kind: Kind) -> Result<bool, IoError> {
        match self.text("byte order") {
            Some("0") => Ok(false),
            Some("1") => Ok(true),
            None if kind.size() == 1 => Ok(false),
            _ => Err(self.error("byte order", "0 (least significant byte first) or 1")),
        }
    }

    /// The axes, slowest first.
    pub(super) fn order(&self) -> Result<[Axis; 3], IoError> {
        let interleave = self.text("interleave").map(str::to_lowercase);
        Ok(match interleave.as_deref() {
            Some("bsq") => [Axis::Band, Axis::Row, Axis::Col],
            Some("bil") => [Axis::Row, Axis::Band, Axis::Col],
            Some("bip") => [Axis::Row, Axis::Col, Axis::Band],
            _ => return Err(self.error("interleave", "bsq, bil or bip")),
        })
    }
}
