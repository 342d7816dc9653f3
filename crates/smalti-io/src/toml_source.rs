//! A TOML file that a user writes, and errors about it at their line.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use smalti::names::nearest;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::diagnostic::Diagnostic;
use crate::text;

/// A file as text, before it is parsed.
#[derive(Debug, Clone)]
pub struct TomlSource {
    /// What to call it in messages.
    pub name: String,
    /// Where files that it names are looked for.
    pub folder: PathBuf,
    /// The TOML.
    pub text: String,
}

/// A file that the program brings along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuiltinFile {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// Its text.
    pub toml: &'static str,
}

/// A file of the crate: `builtin!("cameras", "bayer", "what it is")` is `cameras/bayer.toml`.
macro_rules! builtin {
    ($folder:literal, $name:literal, $summary:literal) => {
        $crate::toml_source::BuiltinFile {
            name: $name,
            summary: $summary,
            toml: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", $folder, "/", $name, ".toml")),
        }
    };
}
pub(crate) use builtin;

impl TomlSource {
    /// A built-in file by its name, else one on disk. `what` names the subject of the file in messages.
    ///
    /// # Errors
    /// When there is none of that name, with the nearest one, or the file cannot be read.
    pub(crate) fn find(what: &str, built_in: &[BuiltinFile], name: &str) -> Result<Self, Box<Diagnostic>> {
        if let Some(file) = built_in.iter().find(|f| f.name == name) {
            return Ok(Self { name: name.into(), folder: PathBuf::new(), text: file.toml.into() });
        }
        let path = Path::new(name);
        if !(is_toml(path) || path.is_file()) {
            let known: Vec<&str> = built_in.iter().map(|f| f.name).collect();
            let list = format!("built in: {}; or give a .toml file", known.join(", "));
            let help = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean '{near}'? {list}"),
                None => list,
            };
            let message = format!("no such {what}");
            return Err(Box::new(Diagnostic { help: Some(help), ..Diagnostic::new(name, message) }));
        }
        let text = text::read_to_string(path).map_err(|e| Box::new(Diagnostic::new(what, e.to_string())))?;
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        Ok(Self { name: name.into(), folder, text })
    }

    /// The content of the file.
    ///
    /// # Errors
    /// On the first key or value that does not fit: its line, what was expected, the nearest valid key.
    pub(crate) fn parse<T: DeserializeOwned>(&self) -> Result<T, Box<Diagnostic>> {
        toml::from_str(&self.text).map_err(|e| Box::new(self.at(e.span(), e.message())))
    }

    /// As [`TomlSource::parse`]. If the file has a top-level key of another kind of file, the error states this.
    pub(crate) fn parse_or_tell<T: DeserializeOwned>(
        &self,
        others: &[&str],
        help: impl FnOnce() -> String,
    ) -> Result<T, Box<Diagnostic>> {
        self.parse().map_err(|error| {
            let is_other = toml::from_str::<toml::Table>(&self.text)
                .is_ok_and(|table| others.iter().any(|key| table.contains_key(*key)));
            if is_other { Box::new(Diagnostic { help: Some(help()), ..*error }) } else { error }
        })
    }

    /// An error about the value of a key, shown at its line where the file states it, else at the innermost table around it. A
    /// key is a path such as `conditions.list[2].luminance_cd_m2`; keys with dots in them are found as they stand.
    #[must_use]
    pub fn about_key(&self, key: &str, message: &str) -> Diagnostic {
        let table = DeTable::parse(&self.text).ok();
        self.at(table.and_then(|table| span_in(table.get_ref(), key)), &format!("`{key}`: {message}"))
    }

    /// An error at a place of the text.
    pub(crate) fn at(&self, span: Option<Range<usize>>, message: &str) -> Diagnostic {
        let (message, help) = explain(message);
        let diagnostic = Diagnostic { help, ..Diagnostic::new(self.name.clone(), message) };
        match span {
            Some(span) => diagnostic.with_span(&self.text, span),
            None => diagnostic,
        }
    }
}

/// Where the value of a path is, or the innermost value on the way to it; `None` where not even the first step is there.
fn span_in(table: &DeTable<'_>, path: &str) -> Option<Range<usize>> {
    let fits = |key: &str| {
        path.strip_prefix(key)
            .filter(|rest| rest.is_empty() || rest.starts_with('.') || rest.starts_with('['))
    };
    let entries = table.iter().filter_map(|(k, v)| Some((k.get_ref().len(), fits(k.get_ref())?, v)));
    // A key may have dots of its own, in quotes: the longest that fits.
    let (_, rest, value) = entries.max_by_key(|(len, _, _)| *len)?;
    Some(span_below(value, rest))
}

fn span_below(value: &Spanned<DeValue<'_>>, rest: &str) -> Range<usize> {
    let below = || match value.get_ref() {
        DeValue::Table(inner) => span_in(inner, rest.strip_prefix('.')?),
        DeValue::Array(items) => {
            let (index, rest) = rest.strip_prefix('[')?.split_once(']')?;
            Some(span_below(items.get(index.parse::<usize>().ok()?)?, rest))
        }
        _ => None,
    };
    below().unwrap_or_else(|| value.span())
}

/// Serde's message in the words of who writes the file: what is wrong, and what to do about an unknown key.
pub(crate) fn explain(message: &str) -> (String, Option<String>) {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown field") || message.starts_with("unknown variant");
    match quoted.next() {
        Some(wrong) if unknown => {
            let known: Vec<&str> = quoted.collect();
            let what = if message.starts_with("unknown field") { "key" } else { "value" };
            let list = known.join(", ");
            // A name without its unit may be that of several keys.
            let start = format!("{wrong}_");
            let units: Vec<String> =
                known.iter().filter(|key| key.starts_with(&start)).map(|key| format!("`{key}`")).collect();
            let help = match nearest(wrong, known.iter().copied()) {
                Some(_) if units.len() > 1 => {
                    format!("did you mean {}? valid here: {list}", units.join(" or "))
                }
                Some(near) => format!("did you mean `{near}`? valid here: {list}"),
                None if known.contains(&"builtin") => {
                    format!("valid here: {list}; a built-in one by its name, say {{ builtin = \"silicon\" }}")
                }
                None => format!("valid here: {list}"),
            };
            (format!("unknown {what} `{wrong}`"), Some(help))
        }
        _ => (in_plain_words(message.trim_end()), None),
    }
}

/// A text in which numbers of more than twenty digits have an exponent. Serde writes all digits of 1e308.
fn with_short_numbers(text: &str) -> String {
    const LONGEST: usize = 20;
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let mut out = String::with_capacity(text.len().min(1 << 10));
    let mut rest = text;
    while let Some(at) = rest.find(is_part) {
        let (before, from) = rest.split_at(at);
        let (number, after) = from.split_at(from.find(|c| !is_part(c)).unwrap_or(from.len()));
        out += before;
        match number.parse::<f64>() {
            Ok(value) if number.len() > LONGEST => out += &format!("{value:e}"),
            _ => out += number,
        }
        rest = after;
    }
    out + rest
}

/// Names of Rust types say nothing to who writes a camera file.
fn in_plain_words(message: &str) -> String {
    let found = |what: &str| message.strip_prefix(what).map(|rest| format!("found {rest}"));
    let message =
        found("invalid type: ").or_else(|| found("invalid value: ")).unwrap_or_else(|| message.to_owned());
    let message = with_short_numbers(&message.replace("missing field", "missing key"));
    let Some((start, expected)) = message.split_once(", expected ") else { return message };
    let expected = match expected {
        "f64" | "f32" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, not negative",
        s if s.starts_with("struct ") => "a table",
        other => other,
    };
    format!("{start}; expected {expected}")
}

/// Whether a name is that of a TOML file.
pub(crate) fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}

/// The path of a file that another file names, relative to the folder of that file.
#[must_use]
pub(crate) fn beside(folder: &Path, name: &str) -> PathBuf {
    let path = Path::new(name);
    if path.is_absolute() { path.to_owned() } else { folder.join(path) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_messages_are_short() {
        let long = format!("invalid type: floating point `1{}.0`, expected usize", "0".repeat(308));
        let (message, _) = explain(&long);
        assert_eq!(message, "found floating point `1e308`; expected a whole number, not negative");
        let (message, _) = explain("invalid type: floating point `0.1000000000000000055`, expected usize");
        assert_eq!(message, "found floating point `1e-1`; expected a whole number, not negative");
        for same in ["found 1.25, not 1.2.3 or 18446744073709551615", "", "no number…"] {
            assert_eq!(with_short_numbers(same), same);
        }
    }

    #[test]
    fn a_value_is_found_by_its_path() {
        let text = "a = [1, { b = 2 }]\n\"c.d\" = 3\n[[e]]\nf = 4\n[[e]]\nf = 5\n[g]\n\"h.i\" = 6\n";
        let source = TomlSource { name: "file.toml".into(), folder: PathBuf::new(), text: text.into() };
        let line = |key| {
            let place = source.about_key(key, "wrong").place;
            place.map(|(line, column, _, _)| (line, column))
        };
        assert_eq!(line("a[0]"), Some((1, 6)));
        assert_eq!(line("a[1].b"), Some((1, 15)));
        assert_eq!(line("c.d"), Some((2, 9)));
        assert_eq!(line("e[1].f"), Some((6, 5)));
        assert_eq!(line("g.h.i"), Some((8, 9)));
        // The innermost that is there.
        assert_eq!(line("a[7].b"), Some((1, 5)));
        assert_eq!(line("a[1].x"), Some((1, 9)));
        assert_eq!(line("z.y"), None);
    }
}
