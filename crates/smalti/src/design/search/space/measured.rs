//! A choice among filters that exist.

use serde::{Deserialize, Serialize};

use super::curves::{Curves, library};
use crate::design::error::DesignError;
use crate::numeric::philox::Stream;
use crate::sensor::Filter;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// A choice among filters that exist, such as measured curves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// The filters to choose from, at least two.
    pub library: Vec<Filter>,
}

/// Transmittances on a grid. The parameter is the number of a filter.
#[derive(Debug)]
pub(super) struct Sampled {
    library: Vec<Spectrum>,
}

impl Sampled {
    pub(super) fn new(family: &Measured, grid: WavelengthGrid) -> Result<Self, DesignError> {
        let library = library("measured.library", &family.library, grid)?;
        if library.len() < 2 {
            let message = "one filter leaves nothing to choose; expected at least two";
            return Err(DesignError::key("measured.library", message));
        }
        Ok(Self { library })
    }
}

impl Curves for Sampled {
    fn parameters(&self) -> usize {
        1
    }

    fn random(&self, random: &mut Stream) -> Vec<f64> {
        vec![f64::from(random.below(self.library.len() as u32))]
    }

    fn transmittance(&self, parameters: &[f64]) -> Vec<f64> {
        let at = parameters.first().map_or(0, |p| *p as usize);
        self.library.get(at).map_or_else(Vec::new, |s| s.values().to_vec())
    }

    fn by_parameters(&self, parameters: &[f64], _: &[f64]) -> Vec<f64> {
        vec![0.0; parameters.len()]
    }

    fn choices(&self) -> Option<usize> {
        Some(self.library.len())
    }
}
