//! Scenes that ISETCam compressed to a few basis functions.

use std::path::PathBuf;

use rayon::prelude::*;
use smalti::numeric::Planes;

use crate::error::At;
use crate::file::Negative;
use crate::raster::{self, Bad, Cube, Values, zeros};
use crate::scene_file::crop::Crop;
use crate::scene_file::cube_file::bad_to_error;
use crate::scene_file::tiles::{Header, Tiles};
use crate::{IoError, Limits};

/// Photons as the mean spectrum and, for every pixel, the weights of basis functions.
pub(super) struct Combined {
    pub(super) path: PathBuf,
    /// A band for each basis function.
    pub(super) coefficients: Cube<'static>,
    /// One basis function after another.
    pub(super) basis: Vec<f64>,
    /// Empty where it is zero.
    pub(super) mean: Vec<f64>,
    pub(super) header: Header,
    pub(super) limits: Limits,
}

/// Pixels whose sums are in the cache together.
const PIXELS: usize = 1 << 10;

impl Tiles for Combined {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read(&self, part: Crop) -> Result<Planes, IoError> {
        let part = part.within(self.header.rows, self.header.cols, &self.path)?;
        let (count, weights) = (self.header.wavelengths_nm.len(), self.coefficients.raster.bands);
        let pixels = part.rows * part.cols;
        // The planes that come out may be many more than the coefficients that came in.
        let bytes = (pixels as u64).saturating_mul(4 * count as u64 + 8 * weights as u64);
        self.limits.check_memory(&self.path, "the photons of mcCOEF", bytes)?;
        let nm = |band: usize| self.header.wavelengths_nm.get(band).copied().unwrap_or_default();
        let error = |bad| {
            let channel = |band: usize| format!("{} nm (band {})", nm(band), band + 1);
            bad_to_error(bad, (&self.path, super::array::FORMAT), channel)
        };
        let bands: Vec<(usize, usize)> = (0..weights).map(|k| (0, k)).collect();
        let cubes = std::slice::from_ref(&self.coefficients);
        let coefficients: Vec<f64> =
            raster::read(cubes, &bands, part.ranges(), |_, _, _| Ok(())).map_err(error)?;
        // Few basis functions undershoot where there is little light: ISETCam takes that as darkness too.
        let values = Values { gains: &[], ignore: None, negative: Negative::Clamp };
        let mut samples: Vec<f32> = zeros(pixels * count);
        let planes = samples.par_chunks_mut(pixels.max(1)).enumerate();
        let done: Vec<Result<(), Bad>> = planes
            .map(|(band, plane)| {
                let mean = self.mean.get(band).copied().unwrap_or(0.0);
                for (i, out) in plane.chunks_mut(PIXELS).enumerate() {
                    let mut sums = [mean; PIXELS];
                    for (k, plane) in coefficients.chunks_exact(pixels).enumerate() {
                        let weight = self.basis.get(k * count + band).copied().unwrap_or(0.0);
                        let of_pixels = plane.get(i * PIXELS..).unwrap_or_default();
                        sums.iter_mut().zip(of_pixels).for_each(|(sum, c)| *sum += weight * c);
                    }
                    out.iter_mut().zip(&sums).for_each(|(v, sum)| *v = *sum as f32);
                }
                values.check(band, plane, (part.row, part.col, part.cols)).map_err(Bad::Sample)
            })
            .collect();
        done.into_iter().collect::<Result<(), Bad>>().map_err(error)?;
        Planes::new(part.rows, part.cols, count, samples).at(&self.path)
    }

    fn rows_at_once(&self) -> usize {
        self.coefficients.rows_at_once()
    }
}
