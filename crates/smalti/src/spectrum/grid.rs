//! The uniform wavelength grid that every spectral quantity is sampled on.

use serde::Serialize;

use thiserror::Error;

use crate::names::did_you_mean;
use crate::numeric::{OutOfRange, ShapeError};

/// What can be wrong with spectral input.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SpectrumError {
    /// The grid is empty, or not finite, positive and ascending.
    #[error(
        "a wavelength grid needs a positive start and step and at least one sample, got start {start_nm} nm, step {step_nm} nm, {count} samples"
    )]
    Grid {
        /// First wavelength.
        start_nm: f64,
        /// Step.
        step_nm: f64,
        /// Samples.
        count: usize,
    },
    /// A spectrum has another number of values than its grid has samples.
    #[error("expected {expected} values, one per wavelength, got {got}")]
    Length {
        /// Samples of the grid.
        expected: usize,
        /// Values that came.
        got: usize,
    },
    /// Two spectra that meet are on different grids.
    #[error("the wavelength grids differ: {left} and {right}")]
    GridMismatch {
        /// One grid.
        left: WavelengthGrid,
        /// The other.
        right: WavelengthGrid,
    },
    /// The data do not cover the requested grid.
    #[error(
        "the data cover {have_start_nm}–{have_end_nm} nm, but {need_start_nm}–{need_end_nm} nm are needed"
    )]
    Coverage {
        /// First wavelength of the data.
        have_start_nm: f64,
        /// Last wavelength of the data.
        have_end_nm: f64,
        /// First wavelength needed.
        need_start_nm: f64,
        /// Last wavelength needed.
        need_end_nm: f64,
    },
    /// A value is NaN, infinite, or negative where that has no meaning.
    #[error("{quantity} at {wavelength_nm} nm is {value}; {expected}")]
    Value {
        /// What it is.
        quantity: &'static str,
        /// Where.
        wavelength_nm: f64,
        /// The value.
        value: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// A table has no such column.
    #[error("a table of {count} functions has no column {column} (counted from 0)")]
    NoColumn {
        /// The column.
        column: usize,
        /// Columns of the table.
        count: usize,
    },
    /// A parameter of a formula is out of its range.
    #[error(transparent)]
    Parameter(#[from] OutOfRange),
    /// No data set has this name.
    #[error("unknown {what} '{name}'{}; expected one of {expected}", did_you_mean(*suggestion))]
    UnknownName {
        /// The requested name.
        what: &'static str,
        /// The name.
        name: String,
        /// The known name nearest to it, if one is near.
        suggestion: Option<&'static str>,
        /// The known names.
        expected: String,
    },
    /// Something with a name does not fit.
    #[error("{what}: {problem}")]
    Of {
        /// What it is, such as `the illuminant D65`.
        what: String,
        /// What is wrong with it.
        problem: Box<SpectrumError>,
    },
    /// The shape of a cube does not match its data.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}

impl SpectrumError {
    /// Data on the grid `have` do not cover the wavelengths from `need_start_nm` to `need_end_nm`.
    pub(crate) fn coverage(have: WavelengthGrid, need_start_nm: f64, need_end_nm: f64) -> Self {
        Self::Coverage {
            have_start_nm: have.start_nm,
            have_end_nm: have.end_nm(),
            need_start_nm,
            need_end_nm,
        }
    }

    /// The error with what it is about.
    pub(crate) fn of(self, what: impl Into<String>) -> Self {
        Self::Of { what: what.into(), problem: Box::new(self) }
    }
}

/// Wavelengths `start_nm + i * step_nm`, `i` in `0..count`, in nanometres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WavelengthGrid {
    start_nm: f64,
    step_nm: f64,
    count: usize,
}

impl WavelengthGrid {
    /// The default grid, 400–700 nm in steps of 10 (31 samples).
    pub const VISIBLE: Self = Self { start_nm: 400.0, step_nm: 10.0, count: 31 };

    /// A grid from its first wavelength, step and number of samples.
    ///
    /// # Errors
    /// When start or step is not positive and finite, or there is no sample.
    pub fn new(start_nm: f64, step_nm: f64, count: usize) -> Result<Self, SpectrumError> {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        if positive(start_nm) && positive(step_nm) && count > 0 {
            Ok(Self { start_nm, step_nm, count })
        } else {
            Err(SpectrumError::Grid { start_nm, step_nm, count })
        }
    }

    /// First wavelength, nm.
    #[must_use]
    pub fn start_nm(&self) -> f64 {
        self.start_nm
    }

    /// Step, nm.
    #[must_use]
    pub fn step_nm(&self) -> f64 {
        self.step_nm
    }

    /// Last wavelength, nm.
    #[must_use]
    pub fn end_nm(&self) -> f64 {
        self.wavelength_nm(self.count - 1)
    }

    /// Number of samples, at least one.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.count
    }

    /// Wavelength of sample `i`, nm.
    #[must_use]
    pub fn wavelength_nm(&self, i: usize) -> f64 {
        self.start_nm + i as f64 * self.step_nm
    }

    /// All wavelengths, nm, ascending.
    pub fn wavelengths_nm(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        (0..self.count).map(|i| self.wavelength_nm(i))
    }
}

impl Default for WavelengthGrid {
    fn default() -> Self {
        Self::VISIBLE
    }
}

impl std::fmt::Display for WavelengthGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{} nm", self.start_nm, self.step_nm, self.end_nm())
    }
}
