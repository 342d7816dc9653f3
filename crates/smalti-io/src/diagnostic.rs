//! An error in a text file, shown at its line.

use std::fmt;
use std::ops::Range;

use smalti::names::in_one_line;

/// What is wrong, where, and what to do about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnostic {
    /// The file, or the argument.
    pub origin: String,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
    /// Line and column from 1, the text of the line and the length to underline.
    pub place: Option<(usize, usize, String, usize)>,
}

impl Diagnostic {
    /// An error without a place.
    #[must_use]
    pub fn new(origin: impl Into<String>, message: impl Into<String>) -> Self {
        Self { origin: origin.into(), message: message.into(), help: None, place: None }
    }

    /// Points at bytes of a text.
    #[must_use]
    pub fn with_span(mut self, text: &str, span: Range<usize>) -> Self {
        let start = (0..=span.start.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0);
        let before = &text[..start];
        let line = before.matches('\n').count() + 1;
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let shown = text[line_start..].lines().next().unwrap_or("");
        let column = text[line_start..start].chars().count() + 1;
        let marked = span.len().clamp(1, shown.chars().count().saturating_sub(column - 1).max(1));
        self.place = Some((line, column, shown.to_owned(), marked));
        self
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The line breaks are those of the layout alone.
        write!(f, "{}", in_one_line(&self.origin))?;
        if let Some((line, column, _, _)) = &self.place {
            write!(f, ":{line}:{column}")?;
        }
        write!(f, ": {}", in_one_line(&self.message))?;
        if let Some((line, column, shown, marked)) = &self.place {
            let gutter = " ".repeat(line.to_string().len());
            let indent = " ".repeat(column - 1);
            let shown = in_one_line(shown);
            write!(f, "\n {line} | {shown}\n {gutter} | {indent}{}", "^".repeat(*marked))?;
        }
        match &self.help {
            Some(help) => write!(f, "\n   {}", in_one_line(help)),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Diagnostic {}
