//! Spectral images from principal components of their spectra.

use rayon::prelude::*;

use crate::numeric::simd::{Kernel, dispatch};
use crate::numeric::{Planes, ShapeError};

/// Pixels whose coefficients and sums stay in the L1 cache.
const TILE: usize = 256;
/// Bands for which coefficients are converted once.
const TOGETHER: usize = 8;

/// The spectra of an image: at each pixel, a mean plus components times their coefficients, limited at 0, and all of it times a level.
#[derive(Debug, Clone, Copy)]
pub struct Components<'a> {
    /// The mean, band by band.
    pub mean: &'a [f64],
    /// The components, one after another, band by band.
    pub basis: &'a [f64],
    /// A plane of whole numbers for each component. Their multiples of `step` are the coefficients.
    pub coefficients: &'a [i32],
    /// The step of the coefficients.
    pub step: f64,
    /// The level of every pixel. A level that is not above 0 gives a dark spectrum.
    pub levels: &'a [f64],
}

impl Components<'_> {
    /// The planes of an image of `rows` × `cols` pixels, one for each band.
    ///
    /// # Errors
    /// When the components have other numbers of bands than the mean, or the planes other numbers of pixels.
    pub fn planes(&self, rows: usize, cols: usize) -> Result<Planes, ShapeError> {
        let (bands, area) = (self.mean.len(), self.levels.len());
        let components = self.basis.len().checked_div(bands).unwrap_or(0);
        let shape = |count: usize, rows: usize, cols: usize, got| {
            let expected = count.saturating_mul(rows).saturating_mul(cols);
            let fits = expected == got;
            if fits { Ok(()) } else { Err(ShapeError { count, rows, cols, expected, got }) }
        };
        shape(1, rows, cols, area)?;
        shape(components, 1, bands, self.basis.len())?;
        shape(components, rows, cols, self.coefficients.len())?;
        let mut planes = Planes::zeros(rows, cols, bands);
        if area == 0 || bands == 0 {
            return Ok(planes);
        }
        let groups = planes.data_mut().par_chunks_mut(TOGETHER * area).enumerate();
        groups.for_each(|(group, planes)| {
            let mut scaled = vec![[0.0; TILE]; components];
            let mut planes: Vec<&mut [f32]> = planes.chunks_exact_mut(area).collect();
            for first in (0..area).step_by(TILE) {
                let pixels = first..area.min(first + TILE);
                let (first_band, scaled) = (group * TOGETHER, &mut scaled[..]);
                let out: Vec<&mut [f32]> = planes.iter_mut().map(|p| &mut p[pixels.clone()]).collect();
                dispatch(Tile { of: self, first, first_band, scaled, out });
            }
        });
        Ok(planes)
    }
}

/// Some bands of some pixels.
struct Tile<'a, 'b> {
    of: &'a Components<'a>,
    /// The first pixel.
    first: usize,
    first_band: usize,
    /// Scratch memory for the coefficients of each component.
    scaled: &'a mut [[f64; TILE]],
    /// The pixels of each band.
    out: Vec<&'b mut [f32]>,
}

impl Kernel for Tile<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { of, first, first_band, scaled, out } = self;
        let (all, area) = (of.mean.len(), of.levels.len());
        let count = out.first().map_or(0, |out| out.len());
        let pixels = first..first + count;
        for (scaled, coefficients) in scaled.iter_mut().zip(of.coefficients.chunks_exact(area)) {
            for (scaled, coefficient) in scaled.iter_mut().zip(&coefficients[pixels.clone()]) {
                *scaled = of.step * f64::from(*coefficient);
            }
        }
        for (out, band) in out.into_iter().zip(first_band..) {
            let mut shape = [of.mean[band]; TILE];
            for (scaled, basis) in scaled.iter().zip(of.basis.chunks_exact(all)) {
                let basis = basis[band];
                for (shape, scaled) in shape.iter_mut().zip(scaled) {
                    *shape += scaled * basis;
                }
            }
            for ((out, shape), level) in out.iter_mut().zip(&shape).zip(&of.levels[pixels.clone()]) {
                let value = (shape.max(0.0) * level) as f32;
                *out = if *level > 0.0 { value } else { 0.0 };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the definition says, pixel by pixel, in images of several tiles and groups of bands.
    #[test]
    fn planes_are_those_of_the_definition() {
        let number = |i: usize| ((i * 7919 + i * i % 31) % 101) as f64 / 50.0 - 1.0;
        let (rows, cols, bands, components) = (31, 17, 11, 3);
        let area = rows * cols;
        let mean: Vec<f64> = (0..bands).map(number).collect();
        let basis: Vec<f64> = (0..bands * components).map(|i| number(i + 5)).collect();
        let coefficients: Vec<i32> = (0..components * area).map(|i| (i * i % 23) as i32 - 11).collect();
        let levels: Vec<f64> = (0..area).map(|i| number(i + 9)).collect();
        let all = Components {
            mean: &mean,
            basis: &basis,
            coefficients: &coefficients,
            step: 0.25,
            levels: &levels,
        };
        let planes = all.planes(rows, cols).unwrap();
        assert_eq!((planes.rows(), planes.cols(), planes.count()), (rows, cols, bands));
        for (band, plane) in planes.planes().enumerate() {
            for (i, found) in plane.iter().enumerate() {
                let terms = (0..components)
                    .map(|c| 0.25 * f64::from(coefficients[c * area + i]) * basis[c * bands + band]);
                let shape = terms.fold(mean[band], |sum, term| sum + term);
                let expected = if levels[i] > 0.0 { (shape.max(0.0) * levels[i]) as f32 } else { 0.0 };
                assert_eq!(found.to_bits(), expected.to_bits(), "{band}, {i}");
            }
        }
        assert!(all.planes(rows, cols + 1).is_err());
        assert!(Components { basis: &basis[1..], ..all }.planes(rows, cols).is_err());
        assert!(Components { coefficients: &coefficients[1..], ..all }.planes(rows, cols).is_err());
        assert!(Components { mean: &[], basis: &[], coefficients: &[], ..all }.planes(rows, cols).is_ok());
    }
}
