//! Filters of pigments by the Beer–Lambert law.

use serde::{Deserialize, Serialize};

use super::curves::{Curves, check, check_share, library, logistic};
use crate::design::error::DesignError;
use crate::numeric::dense::{cholesky, substitute};
use crate::numeric::philox::Stream;
use crate::sensor::Filter;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Filters of pigments by the Beer–Lambert law: the absorbances of the pigments, times their thicknesses, add up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Pigments {
    /// The pigments, as filters of thickness 1. The absorbance is the logarithm of the transmittance relative to its maximum.
    pub library: Vec<Filter>,
    /// Greatest thickness of a pigment, relative to that of the filter in the library, above 0.
    pub max_thickness: f64,
    /// Greatest number of pigments in one filter, at least 1.
    pub max_pigments: usize,
    /// Greatest number of different pigments in the whole array, at least 1. The default is all.
    pub max_materials: Option<usize>,
    /// Transmittance without pigment, above 0, at most 1.
    pub clear: f64,
}

impl Default for Pigments {
    /// The red, green and blue pigments of a colour sensor, and the cyan, magenta and yellow ones of another.
    fn default() -> Self {
        let names =
            ["pigment/R", "pigment/G", "pigment/B", "pigment/C", "pigment/M", "pigment/Y"].map(String::from);
        Self {
            library: names.into_iter().map(Filter::Builtin).collect(),
            max_thickness: 2.0,
            max_pigments: 2,
            max_materials: None,
            clear: 0.95,
        }
    }
}

/// Largest absorbance of a pigment: transmittances of a measured filter below e⁻⁷ are noise.
const MAX_ABSORBANCE: f64 = 7.0;
/// The parameter of a pigment that is not in a filter: its thickness is 0.
const ABSENT: f64 = -60.0;
/// A filter is one of some pigments if its transmittance differs from theirs by less at every wavelength.
const APART: f64 = 0.005;

/// Absorbances on a grid. A parameter is the logit of a thickness relative to the greatest.
#[derive(Debug)]
pub(super) struct Sampled {
    absorbances: Vec<Vec<f64>>,
    max_thickness: f64,
    max_pigments: usize,
    max_materials: usize,
    clear: f64,
}

impl Sampled {
    pub(super) fn new(family: &Pigments, grid: WavelengthGrid) -> Result<Self, DesignError> {
        let Pigments { max_thickness, max_pigments, max_materials, clear, .. } = *family;
        let fits = max_thickness > 0.0 && max_thickness <= 10.0;
        check("pigments.max_thickness", fits, max_thickness, "more than 0 and at most 10")?;
        check_share("pigments.clear", clear)?;
        check("pigments.max_pigments", max_pigments > 0, max_pigments as f64, "at least 1")?;
        check("pigments.max_materials", max_materials != Some(0), 0.0, "at least 1")?;
        let absorbance = |t: &Spectrum| {
            let most = t.max();
            let of = |v: &f64| -libm::log((v / most).max(libm::exp(-MAX_ABSORBANCE)));
            t.values().iter().map(of).collect()
        };
        let absorbances =
            library("pigments.library", &family.library, grid)?.iter().map(absorbance).collect();
        let max_materials = max_materials.unwrap_or(usize::MAX);
        Ok(Self { absorbances, max_thickness, max_pigments, max_materials, clear })
    }

    fn thickness(&self, parameter: f64) -> f64 {
        self.max_thickness * logistic(parameter)
    }

    /// The transmittance of layers of the pigments, by their thicknesses.
    fn of_layers(&self, thicknesses: &[f64]) -> Vec<f64> {
        let count = self.absorbances.first().map_or(0, Vec::len);
        let sum = |i: usize| thicknesses.iter().zip(&self.absorbances).map(|(d, a)| d * a[i]).sum::<f64>();
        (0..count).map(|i| self.clear * libm::exp(-sum(i))).collect()
    }

    /// How much each pigment of a filter absorbs.
    fn strengths(&self, parameters: &[f64]) -> Vec<f64> {
        let mean = |curve: &Vec<f64>| curve.iter().sum::<f64>() / curve.len() as f64;
        parameters.iter().zip(&self.absorbances).map(|(p, curve)| self.thickness(*p) * mean(curve)).collect()
    }
}

/// The numbers of all but the `count` strongest.
fn weakest(strengths: &[f64], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..strengths.len()).collect();
    order.sort_by(|&a, &b| strengths[b].total_cmp(&strengths[a]).then(a.cmp(&b)));
    order.split_off(count.min(order.len()))
}

impl Curves for Sampled {
    fn parameters(&self) -> usize {
        self.absorbances.len()
    }

    /// One or two pigments of some thickness, and traces of the others.
    fn random(&self, random: &mut Stream) -> Vec<f64> {
        let count = self.parameters();
        let mut parameters = vec![-4.0; count];
        for _ in 0..2 {
            parameters[random.below(count as u32) as usize] = 3.0 * random.uniform() - 2.0;
        }
        parameters
    }

    fn transmittance(&self, parameters: &[f64]) -> Vec<f64> {
        self.of_layers(&parameters.iter().map(|p| self.thickness(*p)).collect::<Vec<_>>())
    }

    fn by_parameters(&self, parameters: &[f64], by_transmittance: &[f64]) -> Vec<f64> {
        let transmittance = self.transmittance(parameters);
        let of = |(p, absorbance): (&f64, &Vec<f64>)| -> f64 {
            let slope = self.thickness(*p) * (1.0 - logistic(*p));
            let each = absorbance.iter().zip(&transmittance).zip(by_transmittance);
            -slope * each.map(|((a, t), g)| g * t * a).sum::<f64>()
        };
        parameters.iter().zip(&self.absorbances).map(of).collect()
    }

    /// Keeps the strongest pigments of the array, then those of each filter. A filter that is given has no parameters.
    fn prune(&self, filters: &mut [Vec<f64>]) -> bool {
        let mut pruned = false;
        let mut remove = |parameter: &mut f64| {
            pruned |= *parameter > ABSENT;
            *parameter = ABSENT;
        };
        let mut of_array = vec![0.0; self.parameters()];
        for parameters in &*filters {
            of_array.iter_mut().zip(self.strengths(parameters)).for_each(|(sum, s)| *sum += s);
        }
        let unused = weakest(&of_array, self.max_materials);
        for parameters in filters.iter_mut().filter(|p| !p.is_empty()) {
            unused.iter().for_each(|&at| remove(&mut parameters[at]));
            let strengths = self.strengths(parameters);
            weakest(&strengths, self.max_pigments).iter().for_each(|&at| remove(&mut parameters[at]));
        }
        pruned
    }

    fn thicknesses(&self, parameters: &[f64]) -> Option<Vec<f64>> {
        Some(parameters.iter().map(|p| self.thickness(*p)).collect())
    }

    fn layers(&self, transmittance: &[f64]) -> Option<Vec<f64>> {
        let count = self.parameters();
        // A difference of absorbance changes the transmittance in proportion to it.
        let product = |a: &[f64], b: &[f64]| -> f64 {
            transmittance.iter().zip(a.iter().zip(b)).map(|(t, (a, b))| t * t * a * b).sum()
        };
        let absorbance = |t: &f64| -libm::log(t.max(f64::MIN_POSITIVE) / self.clear);
        let wanted: Vec<f64> = transmittance.iter().map(absorbance).collect();
        let with_wanted: Vec<f64> = self.absorbances.iter().map(|a| product(a, &wanted)).collect();
        let gram: Vec<f64> =
            self.absorbances.iter().flat_map(|a| self.absorbances.iter().map(|b| product(a, b))).collect();
        // The thicknesses of a set of pigments with the least squared difference, and their largest difference from the filter.
        let made = |set: &[usize]| {
            let row = |i: &usize| set.iter().map(|j| gram[i * count + j]).collect::<Vec<f64>>();
            let mut normal = set.iter().map(row).collect::<Vec<_>>().concat();
            let mut solved: Vec<f64> = set.iter().map(|i| with_wanted[*i]).collect();
            if !set.is_empty() {
                if !cholesky(&mut normal, set.len(), f64::MIN_POSITIVE) {
                    return None;
                }
                substitute(&normal, set.len(), &mut solved);
            }
            let mut thicknesses = vec![0.0; count];
            set.iter().zip(&solved).for_each(|(pigment, d)| thicknesses[*pigment] = *d);
            let transmitted = self.of_layers(&thicknesses);
            let most = transmitted.iter().zip(transmittance).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            (solved.iter().all(|d| *d > 0.0) && most < APART).then_some((most, thicknesses))
        };
        let mut sets: Vec<Vec<usize>> = vec![Vec::new()];
        for _ in 0..=self.max_pigments.min(count) {
            let best = sets.iter().filter_map(|set| made(set)).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, thicknesses)) = best {
                return Some(thicknesses);
            }
            let larger = |set: &Vec<usize>| {
                let next = set.last().map_or(0, |last| last + 1);
                (next..count).map(|pigment| [set.as_slice(), &[pigment]].concat()).collect::<Vec<_>>()
            };
            sets = sets.iter().flat_map(larger).collect();
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Filters state the pigments that they were made of, with their thicknesses, and no others.
    #[test]
    fn filters_state_their_pigments() {
        let family = Pigments { max_pigments: 3, ..Pigments::default() };
        let sampled = Sampled::new(&family, WavelengthGrid::VISIBLE).unwrap();
        for layers in [
            [0.0; 6],
            [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.03, 0.0, 0.0, 2.0],
            [0.0, 0.7, 0.0, 0.0, 0.0, 1.9],
            [0.0, 0.0, 0.0, 3.5, 0.2, 0.4],
        ] {
            let found = sampled.layers(&sampled.of_layers(&layers)).unwrap();
            for (found, stated) in found.iter().zip(layers) {
                assert!((found - stated).abs() < 1e-9, "{found:?} {layers:?}");
            }
        }
        // Four pigments are more than a filter may have, a comb is of none, and a curve next to that of pigments is of them.
        assert_eq!(sampled.layers(&sampled.of_layers(&[0.4, 0.3, 0.0, 0.0, 0.6, 0.5])), None);
        let comb: Vec<f64> = (0..31).map(|i| f64::from(i % 2)).collect();
        assert_eq!(sampled.layers(&comb), None);
        let mut near = sampled.of_layers(&[0.0, 0.7, 0.0, 0.0, 0.0, 1.9]);
        near.iter_mut().enumerate().for_each(|(i, t)| *t += if i % 2 == 0 { 0.002 } else { -0.0001 });
        let found = sampled.layers(&near).unwrap();
        assert!((found[1] - 0.7).abs() < 0.02 && (found[5] - 1.9).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn an_array_has_no_more_materials_than_it_may() {
        let family = Pigments { max_materials: Some(3), max_pigments: 2, ..Pigments::default() };
        let sampled = Sampled::new(&family, WavelengthGrid::VISIBLE).unwrap();
        let mut random = Stream::new(7, 8, 9);
        let mut filters: Vec<Vec<f64>> = (0..6).map(|_| sampled.random(&mut random)).collect();
        // One more is given.
        filters.push(Vec::new());
        assert!(sampled.prune(&mut filters) && !sampled.prune(&mut filters));
        let present = |p: &[f64]| -> Vec<usize> {
            let thick = sampled.thicknesses(p).unwrap();
            (0..thick.len()).filter(|i| thick[*i] > 1e-12).collect()
        };
        assert!(filters.iter().all(|p| present(p).len() <= 2) && filters[6].is_empty());
        let all: std::collections::BTreeSet<usize> = filters.iter().flat_map(|p| present(p)).collect();
        assert!(!all.is_empty() && all.len() <= 3, "{all:?}");
    }
}
