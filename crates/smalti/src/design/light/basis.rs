//! The spectral components that the light is described with.

use super::super::error::DesignError;
use crate::camera::{Camera, CameraError};
use crate::numeric::dense::{Eigen, dot};
use crate::spectrum::{Observer, Spectrum, WavelengthGrid};

/// Transmittance of the lens below which the light before it is not reconstructed.
const OPAQUE: f64 = 1e-4;

/// A few spectra whose sums are the light of scenes, as closely as the camera and the standard observer see it.
///
/// Before the analysis, a wavelength is weighted by what any filter on the camera and the observer can see of it. The components are
/// the principal components of a set of spectra about zero.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralBasis {
    /// Light before the lens, arbitrary unit.
    pub(super) components: Vec<Spectrum>,
    /// For each component, the weights of the light before the lens whose sum is its coefficient.
    pub(super) analysis: Vec<Vec<f64>>,
    /// The share of the weighted energy that the components leave out of the spectra they were made of.
    pub(super) left_out: f64,
}

impl SpectralBasis {
    /// The basis of spectra before the lens of a camera, with at least one and at most `max_components` components, as many as leave
    /// out no more than `max_left_out` of the energy.
    ///
    /// # Errors
    /// When a curve of the camera does not cover its wavelengths, or the spectra are dark.
    pub fn new(
        camera: &Camera,
        spectra: &[Spectrum],
        max_components: usize,
        max_left_out: f64,
    ) -> Result<Self, DesignError> {
        let grid = camera.grid();
        let weights = weights(camera)?;
        let n = grid.len();
        let seen: Vec<Vec<f64>> = spectra
            .iter()
            .map(|s| s.values().iter().zip(&weights).map(|(l, w)| l * w).collect::<Vec<f64>>())
            // Each spectrum counts equally, whatever its strength.
            .filter_map(|s| {
                let length = dot(&s, &s).sqrt();
                (length > 0.0 && length.is_finite()).then(|| s.iter().map(|v| v / length).collect())
            })
            .collect();
        let mut moments = vec![0.0; n * n];
        for s in &seen {
            for (line, a) in moments.chunks_exact_mut(n).zip(s) {
                line.iter_mut().zip(s).for_each(|(sum, b)| *sum += a * b);
            }
        }
        let dark = || DesignError::key("illuminant", "no filter and no observer sees light of it");
        let eigen = Eigen::of(&moments, n).filter(|_| !seen.is_empty()).ok_or_else(dark)?;
        let total: f64 = eigen.values.iter().sum();
        let mut left = total;
        let (mut components, mut analysis) = (Vec::new(), Vec::new());
        let descending = eigen.values.iter().zip(eigen.vectors.chunks_exact(n)).rev();
        for (value, vector) in descending.take(max_components.max(1)) {
            if !components.is_empty() && left <= max_left_out * total {
                break;
            }
            left -= value;
            let before: Vec<f64> =
                vector.iter().zip(&weights).map(|(u, w)| if *w > 0.0 { u / w } else { 0.0 }).collect();
            components.push(Spectrum::new(grid, before).map_err(CameraError::from)?);
            analysis.push(vector.iter().zip(&weights).map(|(u, w)| u * w).collect());
        }
        Ok(Self { components, analysis, left_out: (left / total).max(0.0) })
    }

    /// Number of components.
    #[must_use]
    pub fn len(&self) -> usize {
        self.components.len()
    }

    /// Whether there is no component; never true.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.components.is_empty()
    }

    /// The wavelengths.
    #[must_use]
    pub fn grid(&self) -> WavelengthGrid {
        self.components.first().map_or_else(WavelengthGrid::default, Spectrum::grid)
    }

    /// The components: spectra of the light before the lens, arbitrary unit.
    #[must_use]
    pub fn components(&self) -> &[Spectrum] {
        &self.components
    }

    /// The share of the energy that the components leave out of the spectra they were made of, 0 to 1.
    #[must_use]
    pub fn left_out(&self) -> f64 {
        self.left_out
    }

    /// The weights of the light *behind* the lens whose sum is the coefficient of each component.
    pub(super) fn analysis_behind(&self, camera: &Camera) -> Result<Vec<Vec<f64>>, CameraError> {
        let lens = camera.optics.transmittance_on(camera.grid())?;
        let behind = |weights: &Vec<f64>| {
            weights.iter().zip(lens.values()).map(|(w, &t)| if t >= OPAQUE { w / t } else { 0.0 }).collect()
        };
        Ok(self.analysis.iter().map(behind).collect())
    }

    /// The response of sensitivities to each component, Σ sensitivity · component.
    #[must_use]
    pub fn response(&self, sensitivity: &Spectrum) -> Vec<f64> {
        self.components.iter().map(|c| dot(c.values(), sensitivity.values())).collect()
    }
}

/// The largest of the camera's bare pixel and the three functions of the observer at each wavelength, each relative to its maximum.
fn weights(camera: &Camera) -> Result<Vec<f64>, CameraError> {
    let grid = camera.grid();
    let lens = camera.optics.transmittance_on(grid)?;
    let bare = camera.sensor.bare_responsivity_on(grid)?.times(&lens)?;
    let observer = Observer::Cie1931.photon_weights(grid)?;
    let relative = |s: &Spectrum| {
        let most = s.max();
        s.values().iter().map(|v| if most > 0.0 { v / most } else { 0.0 }).collect::<Vec<f64>>()
    };
    let mut sum = relative(&bare);
    for function in &observer {
        sum.iter_mut().zip(relative(function)).for_each(|(w, v)| *w = w.max(v));
    }
    sum.iter_mut().zip(lens.values()).for_each(|(w, &t)| *w = if t >= OPAQUE { *w } else { 0.0 });
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;

    fn camera() -> Camera {
        Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap()
    }

    fn spectrum(number: usize) -> Spectrum {
        let of = |nm: f64| 1.0 + 0.8 * libm::sin(nm / (25.0 + 10.0 * number as f64));
        Spectrum::from_fn(WavelengthGrid::VISIBLE, of).unwrap()
    }

    /// As many components as spectra describe any sum of these: whatever sees the light responds to the sum of its components.
    #[test]
    fn the_response_to_light_is_that_to_its_components() {
        let (camera, spectra) = (camera(), [1, 2, 3].map(spectrum));
        let basis = SpectralBasis::new(&camera, &spectra, 3, 0.0).unwrap();
        assert_eq!((basis.len(), basis.is_empty(), basis.grid()), (3, false, camera.grid()));
        assert!(basis.left_out() < 1e-12, "{}", basis.left_out());
        let lens = camera.optics.transmittance_on(camera.grid()).unwrap();
        let behind = basis.analysis_behind(&camera).unwrap();
        let sum = |wavelength: usize| {
            spectra.iter().zip([0.5, 3.0, -0.2]).map(|(s, times)| times * s.values()[wavelength]).sum::<f64>()
        };
        let light: Vec<f64> = (0..camera.grid().len()).map(sum).collect();
        let on_pixel: Vec<f64> = light.iter().zip(lens.values()).map(|(l, t)| l * t).collect();
        let coefficients: Vec<f64> = basis.analysis.iter().map(|weights| dot(weights, &light)).collect();
        for (found, weights) in coefficients.iter().zip(&behind) {
            assert!((dot(weights, &on_pixel) - found).abs() < 1e-9 * found.abs().max(1.0));
        }
        let bare = camera.sensor.bare_responsivity_on(camera.grid()).unwrap();
        let observer = Observer::Cie1931.photon_weights(camera.grid()).unwrap();
        for sensitivity in observer.iter().chain([&bare]) {
            let response = basis.response(sensitivity);
            assert_eq!(response.len(), 3);
            let (found, seen) = (dot(&coefficients, &response), dot(&light, sensitivity.values()));
            // The weights, by which the light is divided, are small at the ends of the wavelengths.
            assert!((found / seen - 1.0).abs() < 1e-6, "{found} {seen}");
        }
    }

    /// What the components leave out falls with their number, which ends as soon as little enough is left. Dark spectra have none.
    #[test]
    fn components_are_as_many_as_are_needed() {
        let (camera, spectra) = (camera(), [1, 2, 3, 4, 5].map(spectrum));
        let basis = |most, left_out| SpectralBasis::new(&camera, &spectra, most, left_out).unwrap();
        let left: Vec<f64> = (1..=5).map(|count| basis(count, 0.0).left_out()).collect();
        assert!(left.windows(2).all(|w| w[1] < w[0]) && left[0] < 1.0, "{left:?}");
        assert_eq!(basis(5, 1.1 * left[1]).len(), 2);
        assert_eq!(basis(5, 0.9 * left[1]).len(), 3);
        // A spectrum counts as much as another, however strong it is.
        let strong: Vec<Spectrum> =
            spectra.iter().enumerate().map(|(i, s)| s.scaled([1.0, 100.0][i % 2]).unwrap()).collect();
        let of_strong = SpectralBasis::new(&camera, &strong, 2, 0.0).unwrap();
        assert!((of_strong.left_out() / left[1] - 1.0).abs() < 1e-6, "{} {left:?}", of_strong.left_out());
        let dark = [Spectrum::constant(camera.grid(), 0.0).unwrap()];
        assert!(matches!(SpectralBasis::new(&camera, &dark, 3, 0.0), Err(DesignError::Key { .. })));
    }
}
