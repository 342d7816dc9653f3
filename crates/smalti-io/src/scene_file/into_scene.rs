//! Conversion between spectral files and scenes.

use std::path::Path;

use smalti::numeric::Planes;
use smalti::scene::{Scene, Setting};
use smalti::spectrum::units::photons_per_joule;
use smalti::spectrum::{Observer, SpectralCube};

use super::spectral::{Quantity, SpectralFile};
use crate::IoError;
use crate::error::At;

// Where a file gives no light, the white diffuser is as bright as the scene's brightest surfaces. The brightest
// hundredth is left out: highlights and lamps are not surfaces.
const WHITE_PERCENTILE: f64 = 0.99;

impl SpectralFile {
    /// The scene as a file: photons, every fact stated, so that a round trip is exact.
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Self {
        Self {
            name: scene.name().to_owned(),
            cube: scene.radiance().clone(),
            quantity: Quantity::Photons,
            illuminant: Some(scene.illuminant().clone()),
            distance_m: Some(scene.distance_m()),
            horizontal_fov_deg: Some(scene.horizontal_fov_deg()),
        }
    }

    /// The same radiance in energy units, as other programs expect it. Back in photons it agrees within two units
    /// in the last place of f32. Other quantities are returned as they are.
    ///
    /// # Errors
    /// Never for a valid file.
    pub fn into_energy(self) -> Result<Self, IoError> {
        if self.quantity != Quantity::Photons {
            return Ok(self);
        }
        let cube = scaled(self.cube, |nm| 1.0 / photons_per_joule(nm), Path::new(&self.name))?;
        Ok(Self { cube, quantity: Quantity::Energy, ..self })
    }

    /// A scene on the wavelengths of the file, with missing facts from `defaults`.
    ///
    /// - Absolute radiance is kept, converted to photons.
    /// - Relative radiance is scaled to the mean luminance of the defaults.
    /// - A reflectance is multiplied by the light (that of the file or the default) and scaled in the same way.
    ///
    /// If the light of a radiance is unknown, the default illuminant is scaled to the 99th percentile of the
    /// scene's luminance, which is assumed to be that of a white surface.
    ///
    /// # Errors
    /// When the image is black throughout but must be scaled, a default is out of range, or the illuminant does
    /// not cover the wavelengths.
    pub fn into_scene(self, defaults: &Setting) -> Result<Scene, IoError> {
        let path = std::path::PathBuf::from(&self.name);
        let grid = self.cube.grid();
        let default_light = || defaults.illuminant.photons(grid).at(&path);

        let (mut radiance, mut light) = match self.quantity {
            Quantity::Photons => (self.cube, self.illuminant),
            Quantity::Energy | Quantity::RelativeEnergy => {
                (scaled(self.cube, photons_per_joule, &path)?, self.illuminant)
            }
            Quantity::Reflectance => {
                let light = self.illuminant.map_or_else(default_light, Ok)?;
                // Photon radiances near 1e15 leave f32 no room for the illuminant's arbitrary scale.
                let light = light.scaled(1.0 / light.max().max(f64::MIN_POSITIVE)).at(&path)?;
                let at = |nm: f64| light.at(nm).unwrap_or(0.0);
                (scaled(self.cube, at, &path)?, Some(light.clone()))
            }
        };

        if matches!(self.quantity, Quantity::RelativeEnergy | Quantity::Reflectance) {
            let luminance = defaults.luminance_cd_m2;
            if !(luminance.is_finite() && luminance > 0.0) {
                let found = luminance.to_string();
                return Err(IoError::field(&path, "luminance_cd_m2", found, "more than 0"));
            }
            let mean = mean_luminance(&radiance, &path)?;
            if mean <= 0.0 {
                return Err(IoError::field(&path, "the mean luminance", "0", "light to scale"));
            }
            let factor = luminance / mean;
            radiance = scaled(radiance, |_| factor, &path)?;
            light = light.map(|l| l.scaled(factor)).transpose().at(&path)?;
        }
        let light = match light {
            Some(light) => light,
            None => {
                let light = default_light()?;
                let white = Observer::Cie1931.xyz_from_photons(&light).at(&path)?[1];
                let target = percentile_luminance(&radiance, &path)?;
                light.scaled(if white > 0.0 { target / white } else { 0.0 }).at(&path)?
            }
        };
        let distance_m = self.distance_m.unwrap_or(defaults.distance_m);
        let fov_deg = self.horizontal_fov_deg.unwrap_or(defaults.horizontal_fov_deg);
        Scene::new(self.name, radiance, light, distance_m, fov_deg).at(&path)
    }
}

/// Every plane times a factor of its wavelength.
fn scaled(cube: SpectralCube, factor: impl Fn(f64) -> f64, path: &Path) -> Result<SpectralCube, IoError> {
    let grid = cube.grid();
    let mut planes: Planes = cube.into_planes();
    for (i, nm) in grid.wavelengths_nm().enumerate() {
        let factor = factor(nm);
        for v in planes.plane_mut(i).at(path)? {
            *v = (f64::from(*v) * factor) as f32;
        }
    }
    SpectralCube::new(grid, planes).at(path)
}

fn mean_luminance(photons: &SpectralCube, path: &Path) -> Result<f64, IoError> {
    let y = &Observer::Cie1931.photon_weights(photons.grid()).at(path)?[1];
    let sum = photons.plane_sums().iter().zip(y.values()).map(|(s, w)| s * w).sum::<f64>();
    Ok(sum / photons.planes().plane_len() as f64)
}

fn percentile_luminance(photons: &SpectralCube, path: &Path) -> Result<f64, IoError> {
    let xyz = Observer::Cie1931.xyz_planes_from_photons(photons).at(path)?;
    let mut y = xyz.plane(1).at(path)?.to_vec();
    let rank = ((y.len().saturating_sub(1)) as f64 * WHITE_PERCENTILE) as usize;
    if y.is_empty() {
        return Ok(0.0);
    }
    let (_, value, _) = y.select_nth_unstable_by(rank, f32::total_cmp);
    Ok(f64::from(*value))
}
