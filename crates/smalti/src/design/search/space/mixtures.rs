//! Weighted means of filters.

use serde::{Deserialize, Serialize};

use super::curves::{Curves, library};
use crate::design::error::DesignError;
use crate::numeric::philox::Stream;
use crate::sensor::Filter;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Weighted means of filters: the weights are not negative, and their sum is at most 1. Learned arrays are of this kind ([henz2018]: weights of
/// red, green and blue), although no pigment adds transmittances.
///
/// [henz2018]: https://github.com/bernardohenz/deep_joint_design_cfa_demosaicing
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Mixtures {
    /// The filters that are mixed.
    pub library: Vec<Filter>,
}

/// Transmittances on a grid. The weights are shares exp(p) / (1 + Σ exp(p)).
#[derive(Debug)]
pub(super) struct Sampled {
    library: Vec<Spectrum>,
}

impl Sampled {
    pub(super) fn new(family: &Mixtures, grid: WavelengthGrid) -> Result<Self, DesignError> {
        Ok(Self { library: library("mixtures.library", &family.library, grid)? })
    }
}

fn shares(parameters: &[f64]) -> Vec<f64> {
    // The opaque part has the parameter 0.
    let most = parameters.iter().copied().fold(0.0, f64::max);
    let powers: Vec<f64> = parameters.iter().map(|p| libm::exp(p - most)).collect();
    let sum = libm::exp(-most) + powers.iter().sum::<f64>();
    powers.iter().map(|p| p / sum).collect()
}

impl Curves for Sampled {
    fn parameters(&self) -> usize {
        self.library.len()
    }

    fn random(&self, random: &mut Stream) -> Vec<f64> {
        (0..self.parameters()).map(|_| 6.0 * random.uniform() - 2.0).collect()
    }

    fn transmittance(&self, parameters: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.library.first().map_or(0, |s| s.values().len())];
        for (share, filter) in shares(parameters).iter().zip(&self.library) {
            sum.iter_mut().zip(filter.values()).for_each(|(s, t)| *s += share * t);
        }
        sum
    }

    fn by_parameters(&self, parameters: &[f64], by_transmittance: &[f64]) -> Vec<f64> {
        let shares = shares(parameters);
        let by_share =
            |s: &Spectrum| s.values().iter().zip(by_transmittance).map(|(t, g)| t * g).sum::<f64>();
        let by_share: Vec<f64> = self.library.iter().map(by_share).collect();
        let mean: f64 = shares.iter().zip(&by_share).map(|(w, g)| w * g).sum();
        shares.iter().zip(&by_share).map(|(w, g)| w * (g - mean)).collect()
    }
}
