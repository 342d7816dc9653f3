//! Parsers of numbers on the command line.

use std::fmt::Display;

use anyhow::bail;

/// Any number; the library checks its range.
pub(crate) fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| "expected a number".into())
}

/// A finite number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let found = number(text).ok();
    found.filter(|v| v.is_finite() && *v > 0.0).ok_or_else(|| "expected a number above 0".into())
}

/// A number from 0 to 1.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    let found = number(text).ok();
    found.filter(|v| (0.0..=1.0).contains(v)).ok_or_else(|| "expected a number from 0 to 1".into())
}

/// Checks that no value of an option is given twice, which would count it twice.
pub(crate) fn ensure_distinct<T: PartialEq + Display>(option: &str, values: &[T]) -> anyhow::Result<()> {
    match values.iter().enumerate().find(|(i, value)| values[..*i].contains(value)) {
        Some((_, twice)) => bail!("{option}: {twice} is given twice; expected each value once"),
        None => Ok(()),
    }
}
