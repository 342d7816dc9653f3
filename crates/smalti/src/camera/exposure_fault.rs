//! Exposures with which a target of an evaluation cannot be measured.

use std::fmt;

/// What is wrong with the exposure of a target.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ExposureFault {
    /// Most samples saturate.
    Saturated {
        /// Saturated samples, percent.
        percent: f64,
        /// The longest time at which at most half a percent of the samples saturates, s.
        longest_s: f64,
    },
    /// There is too little light.
    Dark {
        /// Mean number of electrons in the brightest sample.
        brightest_e: f64,
    },
}

/// A number with three significant digits, without an exponent.
fn significant(value: f64) -> String {
    if value <= 0.0 {
        return "0".into();
    }
    let digits = (2 - value.log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A time with its unit.
fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{} s", significant(s)),
        s if s >= 1e-3 => format!("{} ms", significant(s * 1e3)),
        s => format!("{} µs", significant(s * 1e6)),
    }
}

/// The message about a target, its exposure time, s, and the fault.
pub(super) struct Told<'a>(pub(super) &'a str, pub(super) f64, pub(super) &'a ExposureFault);

impl fmt::Display for Told<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(target, time_s, fault) = self;
        let time_s = time(*time_s);
        match fault {
            ExposureFault::Saturated { percent, longest_s } => write!(
                f,
                "{} % of the samples of {target} saturate in {time_s}, so that it cannot be measured; expected an exposure time of at most {}",
                significant(*percent),
                time(*longest_s)
            ),
            ExposureFault::Dark { brightest_e } => write!(
                f,
                "{target} is too dark to be measured: its brightest sample collects {} electrons in {time_s}; expected more light or a longer exposure",
                significant(*brightest_e)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_numbers_have_three_digits() {
        for (value, text) in
            [(0.0, "0"), (0.012_34, "0.0123"), (99.96, "100"), (1234.5, "1234"), (2.5, "2.5")]
        {
            assert_eq!(significant(value), text);
        }
        for (seconds, text) in [(33.0, "33 s"), (0.0331, "33.1 ms"), (2.5e-6, "2.5 µs")] {
            assert_eq!(time(seconds), text);
        }
    }
}
