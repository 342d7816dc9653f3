//! Filters as any smooth curve.

use serde::{Deserialize, Serialize};

use super::curves::{Curves, check, check_share, logistic};
use crate::design::error::DesignError;
use crate::numeric::philox::Stream;
use crate::spectrum::WavelengthGrid;

/// Filters as smooth curves through equally spaced knots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct FreeCurves {
    /// Number of knots from the first to the last wavelength of the camera, 3 to 40.
    pub knots: usize,
    /// Greatest transmittance, above 0, at most 1.
    pub max_transmittance: f64,
}

impl Default for FreeCurves {
    fn default() -> Self {
        Self { knots: 9, max_transmittance: 0.95 }
    }
}

/// Hats about the knots on a grid. A parameter is the logit of the transmittance at a knot.
#[derive(Debug)]
pub(super) struct Sampled {
    hats: Vec<Vec<f64>>,
    most: f64,
}

impl Sampled {
    pub(super) fn new(family: &FreeCurves, grid: WavelengthGrid) -> Result<Self, DesignError> {
        let FreeCurves { knots, max_transmittance: most } = *family;
        check("free.knots", (3..=40).contains(&knots), knots as f64, "3 to 40")?;
        check_share("free.max_transmittance", most)?;
        let (first, last) = (grid.start_nm(), grid.end_nm());
        let step = ((last - first) / (knots - 1) as f64).max(f64::MIN_POSITIVE);
        let hat = |knot: usize| {
            let at = first + knot as f64 * step;
            grid.wavelengths_nm().map(|nm| (1.0 - (nm - at).abs() / step).max(0.0)).collect()
        };
        Ok(Self { hats: (0..knots).map(hat).collect(), most })
    }
}

impl Curves for Sampled {
    fn parameters(&self) -> usize {
        self.hats.len()
    }

    fn random(&self, random: &mut Stream) -> Vec<f64> {
        (0..self.parameters()).map(|_| 5.0 * (random.uniform() - 0.5)).collect()
    }

    fn transmittance(&self, parameters: &[f64]) -> Vec<f64> {
        let count = self.hats.first().map_or(0, Vec::len);
        let sum = |i: usize| parameters.iter().zip(&self.hats).map(|(p, hat)| p * hat[i]).sum::<f64>();
        (0..count).map(|i| self.most * logistic(sum(i))).collect()
    }

    fn by_parameters(&self, parameters: &[f64], by_transmittance: &[f64]) -> Vec<f64> {
        let transmittance = self.transmittance(parameters);
        let of = |hat: &Vec<f64>| -> f64 {
            let each = hat.iter().zip(&transmittance).zip(by_transmittance);
            each.map(|((h, t), g)| g * t * (1.0 - t / self.most) * h).sum()
        };
        self.hats.iter().map(of).collect()
    }

    /// It is that of logistic regression: the logit of the transmittance is linear in the parameters.
    fn is_divergence_convex(&self) -> bool {
        true
    }
}
