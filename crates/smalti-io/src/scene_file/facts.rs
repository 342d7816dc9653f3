//! Facts of a scene that a format has no place for: JSON in its comment, description or a field of their own.

use std::path::Path;

use serde::{Deserialize, Serialize};
use smalti::spectrum::Spectrum;

use super::spectral::SpectralFile;
use crate::IoError;
use crate::error::At;

/// The JSON object that stands in the comment.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Comment {
    pub(crate) smalti: Facts,
}

/// What [`SpectralFile`] says beside its samples.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Facts {
    name: String,
    quantity: String,
    pub(crate) start_nm: f64,
    pub(crate) step_nm: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    illuminant_photons: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    distance_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    horizontal_fov_deg: Option<f64>,
}

impl Comment {
    /// Those of a file.
    pub(crate) fn of(file: &SpectralFile) -> Self {
        let grid = file.cube.grid();
        Self {
            smalti: Facts {
                name: file.name.clone(),
                quantity: file.quantity.name().to_owned(),
                start_nm: grid.start_nm(),
                step_nm: grid.step_nm(),
                illuminant_photons: file.illuminant.as_ref().map(|s| s.values().to_vec()),
                distance_m: file.distance_m,
                horizontal_fov_deg: file.horizontal_fov_deg,
            },
        }
    }

    /// Comments of other programs are no error; they hold no facts.
    pub(crate) fn parse(text: &str) -> Option<Facts> {
        serde_json::from_str::<Self>(text).ok().map(|c| c.smalti)
    }
}

impl Facts {
    /// The file with what is stated here.
    pub(crate) fn state(self, file: &mut SpectralFile, path: &Path) -> Result<(), IoError> {
        if let Ok(quantity) = self.quantity.parse() {
            file.quantity = quantity;
        }
        file.name = self.name;
        if let Some(values) = self.illuminant_photons {
            file.illuminant = Some(Spectrum::new(file.cube.grid(), values).at(path)?);
        }
        file.distance_m = self.distance_m;
        file.horizontal_fov_deg = self.horizontal_fov_deg;
        Ok(())
    }
}
