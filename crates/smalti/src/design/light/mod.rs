//! Statistics of the light on the pixels of a camera, before any colour filter: what all colour filter arrays have in common.
//!
//! The light of a patch of pixels is described by a few spectral components per pixel ([`SpectralBasis`]). [`LightStatistics`]
//! holds the mean and the covariance of these coefficients for each class of patches. A colour filter array maps them linearly to
//! samples, so the error of the best linear pipeline for it follows from them without simulation
//! ([`Screen`](super::screen::Screen)).

mod basis;
mod class_names;
mod classes;
mod colors;
mod gather;
mod parts;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use basis::SpectralBasis;
pub use classes::LightClasses;
pub use colors::{COLOR_GROUPS, ClassColors};
pub use gather::LightGatherer;
pub use parts::{ClassParts, LightParts};

use super::error::DesignError;
use crate::camera::Camera;
use crate::l3::Moments;

/// Settings of [`LightStatistics`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LightSettings {
    /// Side of the patch, pixels: 3, 5, 7 or 9. Statistics for a camera with crosstalk have two more than the samples of its patches.
    pub side: usize,
    /// Greatest number of spectral components, 3 to 12.
    pub max_components: usize,
    /// The share of the energy of the spectra that the components may leave out, 0 to 0.1. Fewer components than `max_components` are
    /// used when they suffice.
    pub max_left_out: f64,
    /// The classes of patches.
    pub classes: LightClasses,
    /// Every how many pixels a patch is taken in each direction, 1 to 16.
    pub step_px: usize,
}

impl Default for LightSettings {
    fn default() -> Self {
        Self { side: 5, max_components: 8, max_left_out: 1e-4, classes: LightClasses::default(), step_px: 2 }
    }
}

impl LightSettings {
    /// The settings of the statistics for a camera: with crosstalk, the light of one more ring of pixels reaches the samples of a patch.
    ///
    /// # Errors
    /// [`DesignError::Key`] when the patch would be too large.
    pub fn around(&self, camera: &Camera) -> Result<Self, DesignError> {
        if camera.sensor.crosstalk.is_none() {
            return Ok(self.clone());
        }
        if self.side > 7 {
            let message = format!("{}; expected at most 7 pixels for a camera with crosstalk", self.side);
            return Err(DesignError::key("light.side", message));
        }
        Ok(Self { side: self.side + 2, ..self.clone() })
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the first field that is out of its range.
    pub fn validate(&self) -> Result<(), DesignError> {
        let range = |key, fits: bool, found: f64, expected: &str| {
            if fits { Ok(()) } else { Err(DesignError::key(key, format!("{found}; expected {expected}"))) }
        };
        range("side", [3, 5, 7, 9].contains(&self.side), self.side as f64, "3, 5, 7 or 9 pixels")?;
        let components = self.max_components;
        range("max_components", (3..=12).contains(&components), components as f64, "3 to 12")?;
        range("max_left_out", (0.0..=0.1).contains(&self.max_left_out), self.max_left_out, "0 to 0.1")?;
        range("step_px", (1..=16).contains(&self.step_px), self.step_px as f64, "1 to 16 pixels")?;
        self.classes.validate()
    }
}

/// The patches of a class: Σ z zᵀ with z = (1, coefficients of every pixel), row by row, and what scores need.
#[derive(Debug, Clone, PartialEq)]
pub struct LightClass {
    /// Count, sums and products of the coefficients, per cd/m² of the mean luminance of the scene.
    pub moments: Moments,
    /// Σ 1/w² over the patches, w the luminance of display white of their scene relative to its mean.
    pub per_white_squared: f64,
    /// The colours of the middle pixels, relative to w.
    pub colors: ClassColors,
}

impl LightClass {
    fn new(coefficients: usize) -> Self {
        Self {
            moments: Moments::new(coefficients, 0),
            per_white_squared: 0.0,
            colors: ClassColors::default(),
        }
    }

    fn merge(&mut self, other: &Self) {
        self.moments.merge(&other.moments);
        self.per_white_squared += other.per_white_squared;
        self.colors.merge(&other.colors);
    }
}

/// The mean and covariance of the light on patches of pixels, for each class of patches, behind one lens, on one pixel geometry, under
/// one kind of light. They are sums over patches, so that statistics of several sets of scenes can be merged.
#[derive(Debug, Clone, PartialEq)]
pub struct LightStatistics {
    settings: LightSettings,
    basis: SpectralBasis,
    /// X, Y, Z of each component of the basis, on the scale of the coefficients: Y = 1 for the mean luminance of a scene.
    xyz: Vec<[f64; 3]>,
    /// X, Y, Z of white with Y = 1.
    white: [f64; 3],
    /// The coefficients of a white surface of 1 cd/m².
    white_coefficients: Vec<f64>,
    /// Lens, pixel geometry and wavelengths, as text.
    source: String,
    classes: BTreeMap<usize, LightClass>,
    scenes: u64,
    /// Σ over the pixels of the squared Y, and of the squared difference between Y and that of the components.
    energy: [f64; 2],
}

impl LightStatistics {
    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &LightSettings {
        &self.settings
    }

    /// The spectral components.
    #[must_use]
    pub fn basis(&self) -> &SpectralBasis {
        &self.basis
    }

    /// X, Y, Z of each component, Y = 1 for the mean luminance of a scene.
    #[must_use]
    pub fn xyz(&self) -> &[[f64; 3]] {
        &self.xyz
    }

    /// X, Y, Z of white with Y = 1.
    #[must_use]
    pub fn white(&self) -> [f64; 3] {
        self.white
    }

    /// The coefficients of a white surface of 1 cd/m².
    #[must_use]
    pub fn white_coefficients(&self) -> &[f64] {
        &self.white_coefficients
    }

    /// The classes that have patches, by their numbers.
    #[must_use]
    pub fn classes(&self) -> &BTreeMap<usize, LightClass> {
        &self.classes
    }

    /// Number of patches.
    #[must_use]
    pub fn patches(&self) -> u64 {
        self.classes.values().map(|c| c.moments.count()).sum()
    }

    /// Number of scenes.
    #[must_use]
    pub fn scenes(&self) -> u64 {
        self.scenes
    }

    /// Lens, pixel geometry, wavelengths and light that the statistics are of, as text: equal for statistics that can be merged.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The root mean square of the luminance that the components leave out, relative to that of the luminance.
    #[must_use]
    pub fn luminance_error(&self) -> f64 {
        let [all, left] = self.energy;
        if all > 0.0 { (left / all).sqrt() } else { 0.0 }
    }

    /// Adds statistics of other scenes.
    ///
    /// # Errors
    /// [`DesignError::OtherLight`] unless both are of the same lens, pixel geometry, light and settings.
    pub fn merge(&mut self, other: &Self) -> Result<(), DesignError> {
        let differs = if self.source != other.source {
            Some("lens, pixel or light")
        } else if self.settings != other.settings || self.basis != other.basis {
            Some("settings")
        } else {
            None
        };
        if let Some(what) = differs {
            return Err(DesignError::OtherLight { what });
        }
        let empty = self.empty_class();
        for (number, class) in &other.classes {
            self.classes.entry(*number).or_insert_with(|| empty.clone()).merge(class);
        }
        self.scenes += other.scenes;
        self.energy.iter_mut().zip(other.energy).for_each(|(a, b)| *a += b);
        Ok(())
    }

    fn empty_class(&self) -> LightClass {
        LightClass::new(self.coefficients())
    }

    /// Number of coefficients of a patch.
    #[must_use]
    pub fn coefficients(&self) -> usize {
        self.settings.side * self.settings.side * self.basis.len()
    }
}
