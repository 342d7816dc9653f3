//! Published tables, as numbers. Written by `tools/generate_tables.py`.

// Some reflectances begin with the digits of 1/π, which Clippy reports.
#[allow(clippy::approx_constant)]
mod colorchecker;
mod illuminants;
#[allow(clippy::approx_constant)]
mod natural;
mod observers;
#[allow(clippy::approx_constant)]
mod paint;
#[allow(clippy::approx_constant)]
mod surfaces;

pub use colorchecker::{COLORCHECKER, COLORCHECKER_NAMES};
pub use illuminants::{D65_TABLE, DAYLIGHT_BASIS, F2, F11, LED_B3};
pub use natural::{NATURAL, NATURAL_NAMES};
pub use observers::{CIE_1931_2DEG, CIE_1964_10DEG, CIE_2015_2DEG};
pub use paint::{PAINT, PAINT_NAMES};
pub use surfaces::{SURFACE_NAMES, SURFACES};

use super::{Extrapolation, Spectrum, SpectrumError, WavelengthGrid};

/// `N` functions tabulated on a uniform wavelength grid.
#[derive(Debug)]
pub struct Table<const N: usize> {
    /// First wavelength, nm.
    pub start_nm: f64,
    /// Step, nm.
    pub step_nm: f64,
    /// One row per wavelength.
    pub rows: &'static [[f64; N]],
}

impl<const N: usize> Table<N> {
    /// Column `column` on another grid, interpolated linearly.
    ///
    /// # Errors
    /// When there is no such column, or the grid reaches beyond the table and `extrapolation` is
    /// [`Extrapolation::Error`].
    pub fn spectrum(
        &self,
        column: usize,
        grid: WavelengthGrid,
        extrapolation: Extrapolation,
    ) -> Result<Spectrum, SpectrumError> {
        if column >= N {
            return Err(SpectrumError::NoColumn { column, count: N });
        }
        let own = WavelengthGrid::new(self.start_nm, self.step_nm, self.rows.len())?;
        let values = self.rows.iter().map(|r| r[column]).collect();
        Spectrum::new(own, values)?.resampled(grid, extrapolation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_beyond_the_last_is_an_error() {
        let grid = WavelengthGrid::VISIBLE;
        assert!(DAYLIGHT_BASIS.spectrum(2, grid, Extrapolation::Error).is_ok());
        let beyond = DAYLIGHT_BASIS.spectrum(3, grid, Extrapolation::Error);
        assert_eq!(beyond, Err(SpectrumError::NoColumn { column: 3, count: 3 }));
    }
}
