//! A spectral image: one plane per wavelength.

use rayon::prelude::*;

use super::{Spectrum, SpectrumError, WavelengthGrid};
use crate::numeric::{Planes, ShapeError, first_invalid};

/// Planes that are summed at once: each sum waits for its last addition, while those of other planes proceed.
const TOGETHER: usize = 4;

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
            // The range excludes NaN and infinity.
            let at = first_invalid(plane, |v| (0.0..=f32::MAX).contains(&v))?;
            Some((i, plane[at]))
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

    /// The sum of every plane, each in the order of its pixels and so the same for any number of threads.
    #[must_use]
    pub fn plane_sums(&self) -> Vec<f64> {
        let planes: Vec<&[f32]> = self.planes.planes().collect();
        planes.par_chunks(TOGETHER).flat_map_iter(sums).collect()
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

/// The sums of a few planes of equal length.
fn sums(planes: &[&[f32]]) -> Vec<f64> {
    let [a, b, c, d] = planes else {
        return planes.iter().map(|plane| plane.iter().map(|&v| f64::from(v)).sum()).collect();
    };
    let mut sums = [0.0; TOGETHER];
    for (((a, b), c), d) in a.iter().zip(*b).zip(*c).zip(*d) {
        for (sum, v) in sums.iter_mut().zip([a, b, c, d]) {
            *sum += f64::from(*v);
        }
    }
    sums.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_summed_in_the_order_of_their_pixels() {
        let grid = WavelengthGrid::new(400.0, 10.0, 11).unwrap();
        let values: Vec<f32> = (0..11 * 35).map(|i| 1.0 / (1.0 + (i * i % 97) as f32)).collect();
        let cube = SpectralCube::new(grid, Planes::new(5, 7, 11, values.clone()).unwrap()).unwrap();
        let sum = |plane: &[f32]| plane.iter().fold(0.0, |sum, v| sum + f64::from(*v));
        assert_eq!(cube.plane_sums(), values.chunks(35).map(sum).collect::<Vec<f64>>());
    }
}
