//! Interference filters with edges.

use serde::{Deserialize, Serialize};

use super::curves::{Curves, check, check_share, logistic};
use crate::design::error::DesignError;
use crate::numeric::philox::Stream;
use crate::spectrum::WavelengthGrid;

/// Interference filters that transmit a band between two edges. An edge may lie outside the wavelengths of the camera, which makes a
/// long-pass, a short-pass or a clear filter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Dichroic {
    /// Width of an edge from 10 to 90 % of the transmittance, nm, 1 to 200.
    pub edge_nm: f64,
    /// Least distance of the two edges of a band, nm, 0 to 300.
    pub min_band_nm: f64,
    /// Greatest transmittance, above 0, at most 1.
    pub max_transmittance: f64,
}

impl Default for Dichroic {
    fn default() -> Self {
        Self { edge_nm: 20.0, min_band_nm: 30.0, max_transmittance: 0.95 }
    }
}

/// Logistic edges on a grid. The parameters are those of the lower edge, within the wavelengths and a margin beyond them, and of the
/// distance of the upper one.
#[derive(Debug)]
pub(super) struct Sampled {
    wavelengths_nm: Vec<f64>,
    /// The first place of an edge, and the range of places.
    first_nm: f64,
    range_nm: f64,
    min_band_nm: f64,
    /// The scale of the logistic function.
    scale_nm: f64,
    most: f64,
}

/// From 10 to 90 %, a logistic function takes 2 ln 9 of its scale.
const SCALES_PER_EDGE: f64 = 4.394_449_154_672_439;

impl Sampled {
    pub(super) fn new(family: &Dichroic, grid: WavelengthGrid) -> Result<Self, DesignError> {
        let Dichroic { edge_nm, min_band_nm, max_transmittance: most } = *family;
        check("dichroic.edge_nm", (1.0..=200.0).contains(&edge_nm), edge_nm, "1 to 200 nm")?;
        check("dichroic.min_band_nm", (0.0..=300.0).contains(&min_band_nm), min_band_nm, "0 to 300 nm")?;
        check_share("dichroic.max_transmittance", most)?;
        let margin = 2.0 * edge_nm;
        Ok(Self {
            wavelengths_nm: grid.wavelengths_nm().collect(),
            first_nm: grid.start_nm() - margin,
            range_nm: grid.end_nm() - grid.start_nm() + 2.0 * margin,
            min_band_nm,
            scale_nm: edge_nm / SCALES_PER_EDGE,
            most,
        })
    }

    /// The two edges, and their derivatives with respect to the two parameters: lower by first, upper by first, upper by second.
    fn edges(&self, parameters: &[f64]) -> ([f64; 2], [f64; 3]) {
        let at = |i: usize| parameters.get(i).copied().unwrap_or_default();
        let (a, b) = (logistic(at(0)), logistic(at(1)));
        let lower = self.first_nm + self.range_nm * a;
        let free = self.range_nm * (1.0 - a);
        let (by_a, by_b) = (self.range_nm * a * (1.0 - a), b * (1.0 - b));
        ([lower, lower + self.min_band_nm + free * b], [by_a, by_a * (1.0 - b), free * by_b])
    }

    /// The rise at the lower edge, and the fall at the upper one.
    fn slopes(&self, [lower, upper]: [f64; 2], nm: f64) -> [f64; 2] {
        [logistic((nm - lower) / self.scale_nm), logistic((upper - nm) / self.scale_nm)]
    }
}

impl Curves for Sampled {
    fn parameters(&self) -> usize {
        2
    }

    fn random(&self, random: &mut Stream) -> Vec<f64> {
        (0..2).map(|_| 4.0 * (random.uniform() - 0.5)).collect()
    }

    fn transmittance(&self, parameters: &[f64]) -> Vec<f64> {
        let (edges, _) = self.edges(parameters);
        let of = |&nm: &f64| {
            let [rise, fall] = self.slopes(edges, nm);
            self.most * rise * fall
        };
        self.wavelengths_nm.iter().map(of).collect()
    }

    fn by_parameters(&self, parameters: &[f64], by_transmittance: &[f64]) -> Vec<f64> {
        let (edges, [lower_by_first, upper_by_first, upper_by_second]) = self.edges(parameters);
        let (mut by_lower, mut by_upper) = (0.0, 0.0);
        for (nm, g) in self.wavelengths_nm.iter().zip(by_transmittance) {
            let [rise, fall] = self.slopes(edges, *nm);
            let by_edge = g * self.most * rise * fall / self.scale_nm;
            by_lower -= by_edge * (1.0 - rise);
            by_upper += by_edge * (1.0 - fall);
        }
        vec![by_lower * lower_by_first + by_upper * upper_by_first, by_upper * upper_by_second]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_have_their_width_and_their_distance() {
        let sampled = Sampled::new(&Dichroic::default(), WavelengthGrid::VISIBLE).unwrap();
        for parameters in [[0.0, 0.0], [-9.0, 9.0], [2.0, -50.0]] {
            let ([lower, upper], _) = sampled.edges(&parameters);
            assert!(upper - lower >= 30.0 && lower >= 360.0 && upper <= 740.0 + 30.0);
            let [ten, ninety] = [lower - 10.0, lower + 10.0].map(|nm| sampled.slopes([lower, upper], nm)[0]);
            assert!((ten - 0.1).abs() < 1e-12 && (ninety - 0.9).abs() < 1e-12);
        }
    }
}
