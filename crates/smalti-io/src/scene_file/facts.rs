//! Facts of a scene that a format has no place for: JSON in its comment, description or a field of their own.

use std::path::Path;

use serde::{Deserialize, Serialize};
use smalti::spectrum::Spectrum;

use super::spectral::{Quantity, SpectralFile};
use super::stated::Bands;
use super::tiles::Header;
use crate::IoError;
use crate::error::At;

/// The JSON object in the comment.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Comment {
    pub(crate) smalti: Facts,
}

/// The properties of a [`SpectralFile`] beside its samples.
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
        Self { smalti: Facts::of(&Header::of(file)) }
    }

    /// Comments of other programs are no error; they hold no facts.
    pub(crate) fn parse(text: &str) -> Option<Facts> {
        serde_json::from_str::<Self>(text).ok().map(|c| c.smalti)
    }
}

impl Facts {
    /// Those that a header states.
    pub(crate) fn of(header: &Header) -> Self {
        Self {
            name: header.name.clone(),
            quantity: header.quantity.name().to_owned(),
            start_nm: header.grid.start_nm(),
            step_nm: header.grid.step_nm(),
            illuminant_photons: header.illuminant.as_ref().map(|s| s.values().to_vec()),
            distance_m: header.distance_m,
            horizontal_fov_deg: header.horizontal_fov_deg,
        }
    }

    /// The quantity, where it is one that is known.
    pub(crate) fn quantity(&self) -> Option<Quantity> {
        self.quantity.parse().ok()
    }

    /// The bands on the grid that facts state, where they state one of these wavelengths.
    pub(crate) fn regrid(facts: Option<&Self>, bands: Bands) -> Bands {
        match facts {
            Some(facts) => bands.on(facts.start_nm, facts.step_nm),
            None => bands,
        }
    }

    /// Puts what facts state into a header that has its grid and quantity.
    pub(crate) fn state(facts: Option<Self>, header: &mut Header, path: &Path) -> Result<(), IoError> {
        let Some(facts) = facts else { return Ok(()) };
        header.name = facts.name;
        if let Some(values) = facts.illuminant_photons {
            header.illuminant = Some(Spectrum::new(header.grid, values).at(path)?);
        }
        header.distance_m = facts.distance_m;
        header.horizontal_fov_deg = facts.horizontal_fov_deg;
        Ok(())
    }
}
