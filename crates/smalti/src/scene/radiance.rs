//! The scene: a flat image of spectral radiance at a distance.

use std::sync::Arc;

use rayon::prelude::*;

use super::SceneError;
use super::glints::Glints;
use super::setting::{require_distance, require_fov, require_luminance, require_reflectance};
use crate::numeric::{Planes, require};
use crate::spectrum::{
    Extrapolation, Illuminant, Observer, SpectralCube, Spectrum, SpectrumError, WavelengthGrid,
};

/// Below this fraction of its maximum, an illuminant counts as absent when a scene is relit. The division
/// would recover rounding errors there, not reflectance.
const NO_LIGHT: f64 = 1e-6;

/// Spectral radiance of a plane that is perpendicular to the optical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    name: String,
    /// Shared, so that a scene under another field of view is no copy of it.
    radiance: Arc<SpectralCube>,
    illuminant: Spectrum,
    distance_m: f64,
    horizontal_fov_deg: f64,
}

impl Scene {
    /// A scene from its parts. `radiance` and `illuminant` (the radiance of a perfect white diffuser in the
    /// scene) are in photons s⁻¹ m⁻² sr⁻¹ nm⁻¹ on the same grid.
    ///
    /// # Errors
    /// When the grids differ, or the distance or the field of view is out of the range of [`Setting`](super::Setting).
    pub fn new(
        name: impl Into<String>,
        radiance: SpectralCube,
        illuminant: Spectrum,
        distance_m: f64,
        horizontal_fov_deg: f64,
    ) -> Result<Self, SceneError> {
        if radiance.grid() != illuminant.grid() {
            return Err(
                SpectrumError::GridMismatch { left: radiance.grid(), right: illuminant.grid() }.into()
            );
        }
        require_distance(distance_m)?;
        require_fov(horizontal_fov_deg)?;
        let radiance = Arc::new(radiance);
        Ok(Self { name: name.into(), radiance, illuminant, distance_m, horizontal_fov_deg })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Spectral radiance, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹.
    #[must_use]
    pub fn radiance(&self) -> &SpectralCube {
        &self.radiance
    }

    /// Radiance of a perfect white diffuser under the scene's illuminant, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹.
    #[must_use]
    pub fn illuminant(&self) -> &Spectrum {
        &self.illuminant
    }

    /// Distance from the lens, m.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        self.distance_m
    }

    /// Full horizontal field of view, degrees.
    #[must_use]
    pub fn horizontal_fov_deg(&self) -> f64 {
        self.horizontal_fov_deg
    }

    /// Mean luminance, cd/m² (CIE 1931).
    ///
    /// # Errors
    /// Never for a valid scene.
    pub fn mean_luminance_cd_m2(&self) -> Result<f64, SceneError> {
        let y = &Observer::Cie1931.photon_weights(self.radiance.grid())?[1];
        Ok(self.plane_means().iter().zip(y.values()).map(|(mean, weight)| mean * weight).sum())
    }

    /// Tristimulus values of every pixel as three planes X, Y, Z (CIE 1931), absolute: Y in cd/m².
    ///
    /// # Errors
    /// Never for a valid scene.
    pub fn xyz(&self) -> Result<Planes, SceneError> {
        Ok(Observer::Cie1931.xyz_planes_from_photons(&self.radiance)?)
    }

    /// Luminance of every pixel, cd/m² (CIE 1931), in row order.
    ///
    /// # Errors
    /// Never for a valid scene.
    pub fn luminance_cd_m2(&self) -> Result<Vec<f32>, SceneError> {
        Ok(Observer::Cie1931.luminance_from_photons(&self.radiance)?)
    }

    /// The scene with its radiance and its illuminant scaled to a mean luminance, cd/m².
    ///
    /// # Errors
    /// When the luminance is not within 0–10¹² cd/m², or the scene has none.
    pub fn with_mean_luminance(self, cd_m2: f64) -> Result<Self, SceneError> {
        require_luminance(cd_m2)?;
        let factor = cd_m2 / self.some_luminance(self.mean_luminance_cd_m2()?)?;
        let factors = vec![factor; self.radiance.grid().len()];
        let illuminant = self.illuminant.scaled(factor)?;
        self.multiplied(&factors, illuminant)
    }

    /// The scene under another illuminant: its radiance is divided by the old illuminant and multiplied by
    /// the new one, wavelength by wavelength. Since the power of an [`Illuminant`] is relative, the mean
    /// luminance is kept, as in ISETCam's `sceneAdjustIlluminant`; [`Scene::with_mean_luminance`] sets
    /// another.
    ///
    /// # Errors
    /// When the old illuminant has less than 10⁻⁶ of its maximum at a wavelength where the new one has power,
    /// when the new one does not cover the grid, or when the result has no luminance.
    pub fn relit(self, illuminant: &Illuminant) -> Result<Self, SceneError> {
        let new = illuminant.photons(self.radiance.grid())?;
        let mut factors = self.ratios_to(&new)?;
        let scale = self.keep_luminance(&mut factors)?;
        self.multiplied(&factors, new.scaled(scale)?)
    }

    /// The scene with its radiance multiplied by the ratio of two illuminants, `light` ÷ `instead_of`, wavelength by wavelength, at the
    /// same mean luminance: what a part of a larger scene sends out that light reaches from coloured walls or the evening sun. The
    /// [illuminant](Scene::illuminant) remains that of the whole scene.
    ///
    /// # Errors
    /// When an illuminant does not cover the grid, the second one is dark where the first one is not, or the result has no luminance.
    pub fn in_local_light(self, light: &Illuminant, instead_of: &Illuminant) -> Result<Self, SceneError> {
        let grid = self.radiance.grid();
        let mut factors = ratios(&instead_of.photons(grid)?, &light.photons(grid)?)?;
        self.keep_luminance(&mut factors)?;
        let illuminant = self.illuminant.clone();
        self.multiplied(&factors, illuminant)
    }

    /// The scene with its radiance multiplied by a reflectance, wavelength by wavelength: white becomes a surface of this reflectance, and
    /// every other colour is multiplied by it. Lamps and highlights are dimmed as well; the [illuminant](Scene::illuminant) remains.
    ///
    /// # Errors
    /// When the reflectance is on another grid, or negative or not finite somewhere.
    pub fn multiplied_by(self, reflectance: &Spectrum) -> Result<Self, SceneError> {
        require_reflectance(reflectance, self.radiance.grid())?;
        let illuminant = self.illuminant.clone();
        self.multiplied(reflectance.values(), illuminant)
    }

    /// The scene with glints added to its radiance. Its mean luminance increases by theirs.
    ///
    /// # Errors
    /// When a parameter of the glints is out of range.
    pub fn with_glints(self, glints: &Glints) -> Result<Self, SceneError> {
        let grid = self.radiance.grid();
        let mut planes = Arc::unwrap_or_clone(self.radiance).into_planes();
        let len = planes.plane_len().max(1);
        let drawn = glints.draw(planes.plane_len())?;
        planes.data_mut().par_chunks_mut(len).zip(self.illuminant.values()).for_each(|(plane, white)| {
            drawn.iter().for_each(|&(sample, brightness)| plane[sample] += (brightness * white) as f32);
        });
        Ok(Self { radiance: Arc::new(SpectralCube::new(grid, planes)?), ..self })
    }

    /// Scales the factors of its planes so that its mean luminance is kept, and returns the scale.
    ///
    /// # Errors
    /// When there is no luminance with these factors.
    fn keep_luminance(&self, factors: &mut [f64]) -> Result<f64, SceneError> {
        let y = &Observer::Cie1931.photon_weights(self.radiance.grid())?[1];
        let means = self.plane_means();
        let luminance = |factors: &[f64]| -> f64 {
            means.iter().zip(y.values()).zip(factors).map(|((m, w), f)| m * w * f).sum()
        };
        let before = luminance(&vec![1.0; factors.len()]);
        let scale = before / self.some_luminance(luminance(factors))?;
        factors.iter_mut().for_each(|f| *f *= scale);
        Ok(scale)
    }

    /// The ratio of another light (photons, on the wavelengths of the scene) to the illuminant, for each wavelength; 0 where both are
    /// dark.
    ///
    /// # Errors
    /// When the illuminant has less than 10⁻⁶ of its maximum at a wavelength where the other light has power.
    pub(crate) fn ratios_to(&self, light: &Spectrum) -> Result<Vec<f64>, SceneError> {
        ratios(&self.illuminant, light)
    }

    /// The scene on a wavelength grid, unchanged if that is its own; radiance and illuminant are interpolated linearly.
    ///
    /// # Errors
    /// When the new grid extends beyond the old one.
    pub fn resampled(self, grid: WavelengthGrid) -> Result<Self, SceneError> {
        let own = self.radiance.grid();
        if grid == own {
            return Ok(self);
        }
        let illuminant = self.illuminant.resampled(grid, Extrapolation::Error)?;
        let (rows, cols) = (self.radiance.rows(), self.radiance.cols());
        let planes: Vec<&[f32]> = self.radiance.planes().planes().collect();
        let mut out = Vec::with_capacity(rows * cols * grid.len());
        for nm in grid.wavelengths_nm() {
            let at = ((nm - own.start_nm()) / own.step_nm()).clamp(0.0, (own.len() - 1) as f64);
            let (low, share) = (at.floor() as usize, at.fract() as f32);
            let (below, above) = (planes[low], planes[(low + 1).min(own.len() - 1)]);
            out.extend(below.iter().zip(above).map(|(a, b)| a + share * (b - a)));
        }
        let out = Planes::new(rows, cols, grid.len(), out).map_err(SpectrumError::from)?;
        Ok(Self { radiance: Arc::new(SpectralCube::new(grid, out)?), illuminant, ..self })
    }

    /// The scene at another distance, m. The field of view stays the same, so the size on the scene plane
    /// scales with the distance.
    ///
    /// # Errors
    /// When the distance is not positive.
    pub fn with_distance(self, distance_m: f64) -> Result<Self, SceneError> {
        require_distance(distance_m)?;
        Ok(Self { distance_m, ..self })
    }

    /// The scene with another horizontal field of view, degrees.
    ///
    /// # Errors
    /// When it is not within 10⁻⁶ to 170°.
    pub fn with_fov(self, horizontal_fov_deg: f64) -> Result<Self, SceneError> {
        require_fov(horizontal_fov_deg)?;
        Ok(Self { horizontal_fov_deg, ..self })
    }

    /// The part of `rows` × `cols` pixels from `row`, `col`. Pixels keep their size on the scene plane, so
    /// the field of view shrinks. The mean luminance becomes that of the part.
    ///
    /// # Errors
    /// When the part is empty or extends beyond the scene.
    pub fn cropped(self, row: usize, col: usize, rows: usize, cols: usize) -> Result<Self, SceneError> {
        let (all_rows, all_cols) = (self.radiance.rows(), self.radiance.cols());
        let fits = |from: usize, count: usize, all: usize| count > 0 && from <= all && count <= all - from;
        require(fits(row, rows, all_rows), "rows", rows as f64, "at least 1, within the scene")?;
        require(fits(col, cols, all_cols), "cols", cols as f64, "at least 1, within the scene")?;
        let part = self.radiance.planes().cropped(row, col, rows, cols).map_err(SpectrumError::from)?;
        let half = (self.horizontal_fov_deg / 2.0).to_radians().tan() * cols as f64 / all_cols as f64;
        let horizontal_fov_deg = 2.0 * half.atan().to_degrees();
        let radiance = Arc::new(SpectralCube::new(self.radiance.grid(), part)?);
        Ok(Self { radiance, horizontal_fov_deg, ..self })
    }

    /// Mean of every plane.
    fn plane_means(&self) -> Vec<f64> {
        let count = self.radiance.planes().plane_len().max(1) as f64;
        self.radiance.plane_sums().into_iter().map(|sum| sum / count).collect()
    }

    fn some_luminance(&self, cd_m2: f64) -> Result<f64, SceneError> {
        let grid = self.radiance.grid();
        if cd_m2 > 0.0 {
            Ok(cd_m2)
        } else {
            Err(SceneError::Dark { start_nm: grid.start_nm(), end_nm: grid.end_nm() })
        }
    }

    /// Each plane multiplied by its factor, with a new illuminant.
    fn multiplied(self, factors: &[f64], illuminant: Spectrum) -> Result<Self, SceneError> {
        let grid = self.radiance.grid();
        let mut planes = Arc::unwrap_or_clone(self.radiance).into_planes();
        let len = planes.plane_len().max(1);
        planes.data_mut().par_chunks_mut(len).zip(factors).for_each(|(plane, &factor)| {
            // A single rounding limits the loss when a change is undone later.
            plane.iter_mut().for_each(|v| *v = (f64::from(*v) * factor) as f32);
        });
        Ok(Self { radiance: Arc::new(SpectralCube::new(grid, planes)?), illuminant, ..self })
    }
}

/// The ratio of a light to another one on the same wavelengths, for each wavelength; 0 where both are dark.
fn ratios(old: &Spectrum, new: &Spectrum) -> Result<Vec<f64>, SceneError> {
    let (grid, old_max) = (old.grid(), old.max());
    let mut factors = Vec::with_capacity(grid.len());
    for (i, (&old, &new)) in old.values().iter().zip(new.values()).enumerate() {
        let present = old > NO_LIGHT * old_max;
        if !present && new > 0.0 {
            let fraction = if old_max > 0.0 { old / old_max } else { 0.0 };
            return Err(SceneError::NoLightToDivideBy { wavelength_nm: grid.wavelength_nm(i), fraction });
        }
        factors.push(if present { new / old } else { 0.0 });
    }
    Ok(factors)
}
