//! Camera files: TOML read strictly, errors shown at their line.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use smalti::camera::description::CameraDescription;
use smalti::names::nearest;

use crate::diagnostic::Diagnostic;

/// A camera file as text, before anything is made of it.
#[derive(Debug, Clone)]
pub struct CameraSource {
    /// What to call it in messages.
    pub name: String,
    /// Where files that it names are looked for.
    pub folder: PathBuf,
    /// The TOML.
    pub text: String,
}

/// `key=value` from the command line: replaces one key of a camera file.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    /// Dotted path, such as `sensor.pixel.pitch_um`.
    pub key: String,
    /// A TOML value; what is none is taken as a string.
    pub value: String,
}

impl std::str::FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => {
                Ok(Self { key: key.trim().into(), value: value.trim().into() })
            }
            _ => Err(format!("expected KEY=VALUE, such as sensor.pixel.pitch_um=1.4; got '{text}'")),
        }
    }
}

impl Override {
    fn toml_value(&self) -> toml::Value {
        let parsed = toml::from_str::<toml::Table>(&format!("v = {}", self.value));
        match parsed.ok().and_then(|mut t| if t.len() == 1 { t.remove("v") } else { None }) {
            Some(value) => value,
            None => toml::Value::String(self.value.clone()),
        }
    }

    fn fail(&self, message: impl Into<String>, help: Option<String>) -> Diagnostic {
        Diagnostic { help, ..Diagnostic::new(format!("--set {}={}", self.key, self.value), message) }
    }

    /// Sets the key in a document, making tables on the way.
    fn apply(&self, document: &mut toml::Table) -> Result<(), Diagnostic> {
        let mut table = document;
        let mut parts = self.key.split('.').peekable();
        while let Some(part) = parts.next() {
            if parts.peek().is_none() {
                // The two ways to expose exclude each other: the later one holds.
                let other = match self.key.as_str() {
                    "exposure.auto" => "time_ms",
                    "exposure.time_ms" => "auto",
                    _ => "",
                };
                table.remove(other);
                table.insert(part.into(), self.toml_value());
                return Ok(());
            }
            let entry = table.entry(part).or_insert_with(|| toml::Value::Table(toml::Table::new()));
            // A value in the way, such as the name of a pattern, gives way to the table that the key asks for.
            if !entry.is_table() {
                *entry = toml::Value::Table(toml::Table::new());
            }
            match entry {
                toml::Value::Table(inner) => table = inner,
                _ => return Err(self.fail(format!("`{part}` is not a table"), None)),
            }
        }
        Ok(())
    }
}

impl CameraSource {
    /// The description in the file, with overrides applied in order. Files that it names are not read yet.
    ///
    /// # Errors
    /// On the first key or value that does not fit: its line, what was expected, the nearest valid key.
    pub fn describe(&self, overrides: &[Override]) -> Result<CameraDescription, Box<Diagnostic>> {
        let description = toml::from_str::<CameraDescription>(&self.text)
            .map_err(|e| Box::new(self.at(e.span(), e.message())))?;
        if overrides.is_empty() {
            return Ok(description);
        }
        let mut document = toml::from_str::<toml::Table>(&self.text)
            .map_err(|e| Box::new(self.at(e.span(), e.message())))?;
        let mut description = description;
        for o in overrides {
            o.apply(&mut document)?;
            description = CameraDescription::deserialize(document.clone()).map_err(|e| {
                let (message, help) = explain(e.message());
                Box::new(o.fail(message, help))
            })?;
        }
        Ok(description)
    }

    /// An error about the value of a dotted key, shown at its line where the file states it.
    #[must_use]
    pub fn about_key(&self, key: &str, message: &str) -> Diagnostic {
        self.at(self.span_of(key), &format!("`{key}`: {message}"))
    }

    fn at(&self, span: Option<Range<usize>>, message: &str) -> Diagnostic {
        let (message, help) = explain(message);
        let diagnostic = Diagnostic { help, ..Diagnostic::new(self.name.clone(), message) };
        match span {
            Some(span) => diagnostic.with_span(&self.text, span),
            None => diagnostic,
        }
    }

    fn span_of(&self, key: &str) -> Option<Range<usize>> {
        let document = toml::de::DeTable::parse(&self.text).ok()?;
        let mut table = document.get_ref();
        let mut parts = key.split('.').peekable();
        loop {
            let part = parts.next()?;
            let value = table.iter().find(|(k, _)| k.get_ref() == part).map(|(_, v)| v)?;
            if parts.peek().is_none() {
                return Some(value.span());
            }
            match value.get_ref() {
                toml::de::DeValue::Table(inner) => table = inner,
                _ => return Some(value.span()),
            }
        }
    }
}

/// Splits serde's message on an unknown key into what is wrong and what to do.
fn explain(message: &str) -> (String, Option<String>) {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown field") || message.starts_with("unknown variant");
    match quoted.next() {
        Some(wrong) if unknown => {
            let known: Vec<&str> = quoted.collect();
            let what = if message.starts_with("unknown field") { "key" } else { "value" };
            let list = known.join(", ");
            let help = match nearest(wrong, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`? valid here: {list}"),
                None => format!("valid here: {list}"),
            };
            (format!("unknown {what} `{wrong}`"), Some(help))
        }
        _ => (message.trim_end().to_owned(), None),
    }
}

/// The path of a file that a camera file names, relative to the folder of that file.
#[must_use]
pub(crate) fn beside(folder: &Path, name: &str) -> PathBuf {
    let path = Path::new(name);
    if path.is_absolute() { path.to_owned() } else { folder.join(path) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> CameraSource {
        CameraSource { name: "camera.toml".into(), folder: PathBuf::new(), text: text.into() }
    }

    #[test]
    fn an_unknown_key_shows_its_line_and_the_nearest_valid_one() {
        let e = source("[sensor.pixel]\npich_um = 2.2\n").describe(&[]).unwrap_err().to_string();
        assert!(
            e.contains("camera.toml:2") && e.contains("pich_um") && e.contains("did you mean `pitch_um`?"),
            "{e}"
        );
    }

    #[test]
    fn an_override_replaces_one_key_and_is_checked() {
        let set = |s: &str| s.parse::<Override>().unwrap();
        let d = source("name = \"a\"")
            .describe(&[set("sensor.pixel.pitch_um=1.4"), set("sensor.cfa.pattern=rgbw")]);
        assert_eq!(d.unwrap().sensor.pixel.pitch_um, 1.4);
        let e = source("").describe(&[set("sensor.pixel.pich_um=1.4")]).unwrap_err().to_string();
        assert!(e.contains("--set") && e.contains("pitch_um"), "{e}");
        assert!("sensor".parse::<Override>().is_err());
    }

    #[test]
    fn a_wrong_type_says_what_was_expected() {
        let e = source("[sensor.cfa]\npattern = 3\n").describe(&[]).unwrap_err().to_string();
        assert!(e.contains(":2") && e.contains("the name of a CFA"), "{e}");
        let e = source("[optics]\nf_number = \"wide\"\n").describe(&[]).unwrap_err().to_string();
        assert!(e.contains(":2"), "{e}");
    }

    #[test]
    fn a_value_is_found_by_its_key() {
        let s = source("[sensor]\nrows = 4\n[sensor.pixel]\nfill_factor = 1.5\n");
        let e = s.about_key("sensor.pixel.fill_factor", "1.5 is above 1").to_string();
        assert!(e.contains("camera.toml:4"), "{e}");
    }
}
