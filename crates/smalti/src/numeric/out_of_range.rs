//! The error of a parameter that is out of its range.

use thiserror::Error;

/// A parameter is out of its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name} is {value}; expected {expected}")]
pub struct OutOfRange {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// The range.
    pub expected: &'static str,
}

/// `Ok` when `value` is finite and `good`; otherwise an error that names the parameter.
pub(crate) fn require(
    good: bool,
    name: impl Into<String>,
    value: f64,
    expected: &'static str,
) -> Result<(), OutOfRange> {
    if good && value.is_finite() { Ok(()) } else { Err(OutOfRange { name: name.into(), value, expected }) }
}
