//! Errors of the library as Python exceptions.

use std::error::Error;
use std::fmt::Display;
use std::io;

use pyo3::create_exception;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use smalti_report::in_one_line;

create_exception!(
    smalti,
    SmaltiError,
    PyValueError,
    "What cannot be computed, read or written, in the words of the `smalti` command: what it is, what was expected.\n\n\
     A file that the operating system refuses is an OSError instead, of the fitting kind (FileNotFoundError, PermissionError, …)."
);

/// Converts errors of the library to exceptions.
pub(crate) trait OrRaise<T> {
    /// The value, or the exception.
    fn or_raise(self) -> PyResult<T>;
    /// The same, with the subject before the message.
    fn or_raise_about(self, about: impl Display) -> PyResult<T>;
}

impl<T, E: Error + 'static> OrRaise<T> for Result<T, E> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(|e| raised(&e, in_one_line(&e)))
    }

    fn or_raise_about(self, about: impl Display) -> PyResult<T> {
        self.map_err(|e| raised(&e, format!("{about}: {}", in_one_line(&e))))
    }
}

/// The exception for an invalid argument.
pub(crate) fn wrong(message: impl Into<String>) -> PyErr {
    SmaltiError::new_err(message.into())
}

/// The value of a name; the exception for another name lists the known ones.
pub(crate) fn one_of<T: Copy>(what: &str, name: &str, known: &[(&str, T)]) -> PyResult<T> {
    if let Some((_, value)) = known.iter().find(|(n, _)| *n == name) {
        return Ok(*value);
    }
    let names: Vec<&str> = known.iter().map(|(n, _)| *n).collect();
    let (last, others) = names.split_last().unwrap_or((&"", &[]));
    Err(wrong(format!("{what} is '{name}'; expected {} or {last}", others.join(", "))))
}

/// The exception for an error: an OSError with its number for errors of the operating system, else a SmaltiError.
fn raised(error: &(dyn Error + 'static), text: String) -> PyErr {
    let mut cause = Some(error);
    while let Some(e) = cause {
        if let Some(io) = e.downcast_ref::<io::Error>() {
            return match io.raw_os_error() {
                Some(number) => PyOSError::new_err((number, text)),
                None => PyOSError::new_err(text),
            };
        }
        cause = e.source();
    }
    SmaltiError::new_err(text)
}

/// A number with four significant digits.
pub(crate) fn short(value: f64) -> String {
    const DIGITS: i32 = 4;
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..9).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let places = (DIGITS - 1 - magnitude).max(0) as usize;
    let text = format!("{value:.places$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
