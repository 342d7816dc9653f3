//! The light on the pixels as a few principal components: small enough to embed in a page, and sufficient for captures through
//! any filters.

use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::numeric::dense::{Eigen, dot};
use crate::numeric::{Planes, ShapeError};
use crate::sensor::{PixelSpectra, Sensor, SensorError};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Rows per task. The sums of the tasks are added in order, so that the bits do not depend on the number of threads.
const BAND: usize = 16;
/// Maximum number of products in the sums of the moments, about one second of work. Larger images are subsampled evenly.
const MAX_PRODUCTS: usize = 500_000_000;

/// The light of a scene on the pixels of a camera as principal components, in photoelectrons without colour filters. A few
/// components suffice because the spectra of surfaces are smooth.
///
/// A channel of transmittance T has Σₖ planeₖ · ∫ T · spectrumₖ dλ photoelectrons per second.
#[derive(Debug, Clone)]
pub struct PixelLight {
    planes: Planes,
    spectra: Vec<Spectrum>,
}

impl PixelLight {
    /// The first `max_components` principal components of the light on the pixels of a sensor.
    ///
    /// # Errors
    /// When a curve of the sensor does not cover the wavelengths, or the light is not finite.
    pub fn new(sensor: &Sensor, light: &PixelSpectra, max_components: usize) -> Result<Self, SensorError> {
        let (window, grid) = (light.window(), light.grid());
        let bare = sensor.bare_responsivity_on(grid)?;
        // At each wavelength, every `step`-th pixel of a row. The first pixel differs between rows.
        let electrons = |row: usize, step: usize| -> Vec<Vec<f64>> {
            let line = |(i, r): (usize, &f64)| {
                let photons = light.line(window.row + row, i).iter().skip(row * 5 % step).step_by(step);
                photons.map(|&v| f64::from(v) * r).collect()
            };
            bare.values().iter().enumerate().map(line).collect()
        };
        let n = grid.len();
        let step =
            (window.rows * window.cols).saturating_mul(n * n).div_ceil(MAX_PRODUCTS).clamp(1, window.cols);
        let bands: Vec<Vec<f64>> = (0..window.rows.div_ceil(BAND))
            .into_par_iter()
            .map(|band| {
                let mut moments = vec![0.0; n * n];
                for row in band * BAND..((band + 1) * BAND).min(window.rows) {
                    let lines = electrons(row, step);
                    for (i, a) in lines.iter().enumerate() {
                        for (j, b) in lines.iter().enumerate().skip(i) {
                            moments[i * n + j] += dot(a, b);
                        }
                    }
                }
                moments
            })
            .collect();
        let mut moments = vec![0.0; n * n];
        for band in bands {
            moments.iter_mut().zip(band).for_each(|(sum, v)| *sum += v);
        }
        for i in 0..n {
            (0..i).for_each(|j| moments[i * n + j] = moments[j * n + i]);
        }
        let eigen = Eigen::of(&moments, n).ok_or(SensorError::NoLight)?;
        // The eigenvalues ascend.
        let found: Vec<&[f64]> = eigen.above(0.0).map(|(_, vector)| vector).collect();
        let vectors: Vec<&[f64]> = found.into_iter().rev().take(max_components).collect();
        // The components of the pixels of a row, one component after the other.
        let row = |row: usize| -> Vec<f32> {
            let lines = electrons(row, 1);
            let along = |vector: &&[f64], col: usize| -> f64 {
                vector.iter().zip(&lines).map(|(v, line)| v * line[col]).sum()
            };
            let values = vectors.iter().flat_map(|v| (0..window.cols).map(move |col| (v, col)));
            values.map(|(v, col)| along(v, col) as f32).collect()
        };
        let rows: Vec<Vec<f32>> = (0..window.rows).into_par_iter().map(row).collect();
        let mut planes = Planes::zeros(window.rows, window.cols, vectors.len());
        for (r, values) in rows.iter().enumerate() {
            for (k, line) in values.chunks_exact(window.cols).enumerate() {
                planes.plane_mut(k)?[r * window.cols..][..window.cols].copy_from_slice(line);
            }
        }
        let spectra = vectors.iter().map(|v| Spectrum::new(grid, v.to_vec())).collect::<Result<_, _>>()?;
        Ok(Self { planes, spectra })
    }

    /// One plane per component, photoelectrons s⁻¹ nm⁻¹, the strongest component first.
    #[must_use]
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// The spectrum of each component; as vectors they are orthonormal.
    #[must_use]
    pub fn spectra(&self) -> &[Spectrum] {
        &self.spectra
    }

    /// The largest norm of the components over the pixels, the scale of the signal behind a filter.
    #[must_use]
    pub fn brightest(&self) -> f64 {
        let squares = |i: usize| self.planes.planes().map(|p| f64::from(p[i]).powi(2)).sum::<f64>();
        (0..self.planes.plane_len()).map(squares).fold(0.0, f64::max).sqrt()
    }

    /// The light on the pixels, multiplied by `factor`, for captures. The sensor must have the responsivity and the number of
    /// pixels that the components were computed for.
    ///
    /// # Errors
    /// As [`PixelSpectra::of_components`].
    pub fn pixels(&self, sensor: &Sensor, factor: f64) -> Result<PixelSpectra, SensorError> {
        let grid = self.spectra.first().map(Spectrum::grid).ok_or(SensorError::NoLight)?;
        let bare = sensor.bare_responsivity_on(grid)?;
        // The components are 0 at wavelengths where the responsivity is 0.
        let photons = |s: &Spectrum| {
            let each = s.values().iter().zip(bare.values());
            let values = each.map(|(&v, &r)| if r > 0.0 { factor * v / r } else { 0.0 });
            Spectrum::new(grid, values.collect())
        };
        let spectra = self.spectra.iter().map(photons).collect::<Result<Vec<_>, _>>()?;
        PixelSpectra::of_components(sensor, &self.planes, &spectra)
    }

    /// The part of the light in a window of a sensor, multiplied by `factor`, behind a lens with a transmittance. The components must be those
    /// of bare pixels behind a clear lens: photons.
    ///
    /// # Errors
    /// As [`PixelSpectra::of_components`].
    pub(super) fn behind(
        &self,
        sensor: &Sensor,
        lens: &Spectrum,
        factor: f64,
    ) -> Result<PixelSpectra, SensorError> {
        let passed = |s: &Spectrum| s.times(lens).and_then(|s| s.scaled(factor));
        let spectra = self.spectra.iter().map(passed).collect::<Result<Vec<_>, _>>()?;
        PixelSpectra::of_components(sensor, &self.planes, &spectra)
    }

    /// The components in integer steps; [`PixelLight::brightest`] is `steps` steps.
    #[must_use]
    pub fn quantized(&self, steps: f64) -> QuantizedLight {
        let spectra = self.spectra.iter().map(|s| s.values().to_vec()).collect();
        QuantizedLight { planes: QuantizedPlanes::new(&self.planes, self.brightest() / steps), spectra }
    }
}

/// Planes quantised to integers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QuantizedPlanes {
    /// Rows of a plane.
    pub rows: usize,
    /// Columns of a plane.
    pub cols: usize,
    /// Number of planes.
    pub count: usize,
    /// Value of one step.
    pub step: f64,
    /// The integers, plane after plane in row order. They are not part of the JSON; a file or a page stores them separately.
    #[serde(skip)]
    pub codes: Arc<Vec<i32>>,
}

impl QuantizedPlanes {
    /// The nearest integers; all are 0 when the step is 0.
    #[must_use]
    pub fn new(planes: &Planes, step: f64) -> Self {
        let code = |v: &f32| if step > 0.0 { (f64::from(*v) / step).round() as i32 } else { 0 };
        Self {
            rows: planes.rows(),
            cols: planes.cols(),
            count: planes.count(),
            step,
            codes: Arc::new(planes.data().iter().map(code).collect()),
        }
    }

    /// The planes, accurate to half a step.
    ///
    /// # Errors
    /// When the number of integers is not the number of samples.
    pub fn planes(&self) -> Result<Planes, ShapeError> {
        let values = self.codes.iter().map(|&code| (f64::from(code) * self.step) as f32).collect();
        Planes::new(self.rows, self.cols, self.count, values)
    }
}

/// [`PixelLight`] quantised to integers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QuantizedLight {
    /// The planes of the components.
    pub planes: QuantizedPlanes,
    /// The spectrum of each component.
    pub spectra: Vec<Vec<f64>>,
}

impl QuantizedLight {
    /// The light on its wavelength grid.
    ///
    /// # Errors
    /// When the number of integers or of spectral samples is wrong.
    pub fn light(&self, grid: WavelengthGrid) -> Result<PixelLight, SensorError> {
        let spectra =
            self.spectra.iter().map(|v| Spectrum::new(grid, v.clone())).collect::<Result<_, _>>()?;
        Ok(PixelLight { planes: self.planes.planes()?, spectra })
    }
}
