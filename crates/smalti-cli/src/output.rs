//! All output to the terminal: results on standard output, everything else on standard error. Nothing that comes from a file, a name or
//! an argument can steer the terminal; no other module writes to it.

use std::borrow::Cow;
use std::error::Error;
use std::io::Write;

use serde::Serialize;
use smalti::names::{harmless, in_one_line, steers};
use smalti_io::Diagnostic;

use crate::args::Common;

/// Writes results to standard output.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    write(&harmless(text))
}

/// Writes a drawing, which may hold control codes: every text in it has gone through [`harmless`] or [`in_one_line`].
pub(crate) fn print_drawing(drawing: &str) -> anyhow::Result<()> {
    write(drawing)
}

/// Writes JSON to standard output.
pub(crate) fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print_document(&(serde_json::to_string_pretty(value)? + "\n"))
}

/// Writes a document that is JSON already.
pub(crate) fn print_document(json: &str) -> anyhow::Result<()> {
    write(&escaped(json))
}

/// JSON with the same meaning, in which characters that steer a terminal are escaped. Outside of strings there are none.
pub(crate) fn escaped(json: &str) -> Cow<'_, str> {
    let wrong = |c: char| steers(c) && c != '\n';
    if !json.contains(wrong) {
        return Cow::Borrowed(json);
    }
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        // All of them are in the basic plane.
        if wrong(c) { out += &format!("\\u{:04x}", u32::from(c)) } else { out.push(c) }
    }
    Cow::Owned(out)
}

fn write(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Prints a note to standard error, unless quiet. While work is in progress, [`Progress::note`] prints it above the bar.
///
/// [`Progress::note`]: smalti::experiment::Progress::note
pub(crate) fn note(text: &str, common: &Common) {
    if !common.quiet {
        tell(&format!("note: {}", in_one_line(text)));
    }
}

/// Prints an error with its causes to standard error. A diagnostic has lines, which it lays out itself; all other errors have one.
pub(crate) fn error(error: &(dyn Error + 'static), hint: &str) {
    let (mut has_lines, mut cause) = (false, Some(error));
    while let Some(e) = cause {
        has_lines |= e.is::<Diagnostic>() || e.is::<Box<Diagnostic>>();
        cause = e.source();
    }
    let text = smalti_report::in_one_line(error) + hint;
    tell(&format!("error: {}", if has_lines { harmless(&text) } else { in_one_line(&text) }));
}

/// Prints lines to standard error. Nothing can be done where it is closed.
pub(crate) fn tell(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", harmless(text));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escaped_json_means_the_same() {
        let value = serde_json::json!({"na\u{9b}me": "a\u{1b}[1m\n\u{202e}\u{7f} é", "n": 1.5});
        let text = serde_json::to_string_pretty(&value).unwrap();
        let safe = escaped(&text);
        assert!(safe.chars().all(|c| !steers(c) || c == '\n'), "{safe}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&safe).unwrap(), value);
        assert!(matches!(escaped("{\n  \"é\": 1\n}"), Cow::Borrowed(_)));
    }
}
