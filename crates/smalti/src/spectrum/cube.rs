//! A spectral image: one plane per wavelength.

use rayon::prelude::*;

use super::{Spectrum, SpectrumError, WavelengthGrid};
use crate::numeric::{Planes, ShapeError};

/// Image planes over a wavelength grid, plane `i` at wavelength `i`.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralCube {
    grid: WavelengthGrid,
    planes: Planes,
}

impl SpectralCube {
    /// A cube of non-negative finite values.
    ///
    /// # Errors
    /// When the number of planes is not that of the grid, or a value is negative, NaN or infinite.
    pub fn new(grid: WavelengthGrid, planes: Planes) -> Result<Self, SpectrumError> {
        if planes.count() != grid.len() {
            return Err(SpectrumError::Length { expected: grid.len(), got: planes.count() });
        }
        if planes.plane_len() == 0 {
            let (count, rows, cols) = (planes.count(), planes.rows(), planes.cols());
            return Err(ShapeError { count, rows, cols, expected: 1, got: 0 }.into());
        }
        let bands = planes.data().par_chunks(planes.plane_len()).enumerate();
        let bad = bands.find_map_first(|(i, plane)| {
            // The comparison excludes NaN and infinity. Chunks are tested without a branch, because nearly
            // all are valid.
            let well = |v: &f32| (*v >= 0.0) & (*v <= f32::MAX);
            let bad = plane.chunks(4096).find(|piece| !piece.iter().fold(true, |all, v| all & well(v)))?;
            bad.iter().find(|v| !well(v)).map(|&v| (i, v))
        });
        if let Some((i, bad)) = bad {
            return Err(SpectrumError::Value {
                quantity: "the spectral image",
                wavelength_nm: grid.wavelength_nm(i),
                value: f64::from(bad),
                expected: "radiance and irradiance are finite and not negative",
            });
        }
        Ok(Self { grid, planes })
    }

    /// The wavelengths.
    #[must_use]
    pub fn grid(&self) -> WavelengthGrid {
        self.grid
    }

    /// Rows of the image.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.planes.rows()
    }

    /// Columns of the image.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.planes.cols()
    }

    /// The planes, one per wavelength.
    #[must_use]
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// The planes by value.
    #[must_use]
    pub fn into_planes(self) -> Planes {
        self.planes
    }

    /// The spectrum of one pixel; `None` outside the image.
    #[must_use]
    pub fn pixel(&self, row: usize, col: usize) -> Option<Spectrum> {
        if row >= self.rows() || col >= self.cols() {
            return None;
        }
        let at = row * self.cols() + col;
        let values = self.planes.planes().map(|p| f64::from(p[at])).collect();
        // `SpectralCube::new` has checked that the values are finite.
        Spectrum::new(self.grid, values).ok()
    }
}
