//! The error of a parameter that is out of its range.

use std::fmt;

use thiserror::Error;

/// A parameter is out of its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name} is {}; expected {expected}", Number(*value))]
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

/// A number in a message: with an exponent where it would have many zeros.
pub(crate) struct Number(pub(crate) f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = self;
        let size = value.abs();
        if value.is_finite() && (size >= 1e10 || (size < 1e-6 && size > 0.0)) {
            write!(f, "{value:e}")
        } else {
            write!(f, "{value}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_few_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-1.5, "-1.5"),
            (1e-6, "0.000001"),
            (1e-300, "1e-300"),
            (-1e308, "-1e308"),
            (536_870_912.0, "536870912"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Number(value).to_string(), text);
        }
    }
}
