//! Filters with continuous parameters, whose derivatives are known.

use serde::{Deserialize, Serialize};

use super::super::error::DesignError;
use crate::camera::CameraError;
use crate::numeric::philox::Stream;
use crate::sensor::Filter;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// `filters` of a design: the filters that can be made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum FilterSpace {
    /// Mixtures of pigments: any smooth filters that a factory can make of them.
    Pigments(Pigments),
    /// Any smooth curve: the bound that no real filter surpasses.
    Free(FreeCurves),
}

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
            clear: 0.95,
        }
    }
}

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

/// Largest absorbance of a pigment: transmittances of a measured filter below e⁻⁷ are noise.
const MAX_ABSORBANCE: f64 = 7.0;
/// The parameter of a pigment that is not in a filter: its thickness is 0.
pub(super) const ABSENT: f64 = -60.0;

/// A space of filters on the wavelengths of a camera. A filter has as many parameters as [`SampledSpace::parameters`], any numbers.
#[derive(Debug, Clone)]
pub struct SampledSpace {
    grid: WavelengthGrid,
    /// The weights of the parameters at each wavelength: absorbances of pigments, or hats of knots.
    curves: Vec<Vec<f64>>,
    kind: Kind,
    most: f64,
    max_pigments: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Pigments { max_thickness: f64 },
    Free,
}

impl FilterSpace {
    /// The space on a wavelength grid.
    ///
    /// # Errors
    /// When a parameter is out of its range or a filter of the library is invalid.
    pub fn sampled(&self, grid: WavelengthGrid) -> Result<SampledSpace, DesignError> {
        let check = |key: &str, fits: bool, found: f64, expected: &str| {
            if fits { Ok(()) } else { Err(DesignError::key(key, format!("{found}; expected {expected}"))) }
        };
        match self {
            Self::Pigments(Pigments { library, max_thickness, max_pigments, clear }) => {
                check(
                    "pigments.max_thickness",
                    *max_thickness > 0.0 && *max_thickness <= 10.0,
                    *max_thickness,
                    "more than 0 and at most 10",
                )?;
                check("pigments.clear", *clear > 0.0 && *clear <= 1.0, *clear, "more than 0 and at most 1")?;
                check("pigments.max_pigments", *max_pigments > 0, *max_pigments as f64, "at least 1")?;
                if library.is_empty() {
                    return Err(DesignError::key("pigments.library", "expected at least one pigment"));
                }
                let absorbance = |(at, filter): (usize, &Filter)| {
                    let wrong =
                        |e: &dyn ToString| DesignError::key(format!("pigments.library[{at}]"), e.to_string());
                    let t = filter.spectrum(grid).map_err(|e| wrong(&e))?;
                    let most = t.max();
                    if most <= 0.0 {
                        return Err(wrong(
                            &"it transmits no light; expected a pigment with some transmittance",
                        ));
                    }
                    let of = |v: &f64| -libm::log((v / most).max(libm::exp(-MAX_ABSORBANCE)));
                    Ok(t.values().iter().map(of).collect())
                };
                let curves =
                    library.iter().enumerate().map(absorbance).collect::<Result<_, DesignError>>()?;
                let kind = Kind::Pigments { max_thickness: *max_thickness };
                Ok(SampledSpace { grid, curves, kind, most: *clear, max_pigments: *max_pigments })
            }
            Self::Free(FreeCurves { knots, max_transmittance: most }) => {
                check("free.knots", (3..=40).contains(knots), *knots as f64, "3 to 40")?;
                check(
                    "free.max_transmittance",
                    *most > 0.0 && *most <= 1.0,
                    *most,
                    "more than 0 and at most 1",
                )?;
                let (first, last) = (grid.start_nm(), grid.end_nm());
                let step = ((last - first) / (knots - 1) as f64).max(f64::MIN_POSITIVE);
                let hat = |knot: usize| {
                    let at = first + knot as f64 * step;
                    grid.wavelengths_nm().map(|nm| (1.0 - (nm - at).abs() / step).max(0.0)).collect()
                };
                let curves = (0..*knots).map(hat).collect();
                Ok(SampledSpace { grid, curves, kind: Kind::Free, most: *most, max_pigments: usize::MAX })
            }
        }
    }
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-x))
}

impl SampledSpace {
    /// Number of parameters of a filter.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.curves.len()
    }

    /// Random parameters of a filter.
    pub(super) fn random(&self, random: &mut Stream) -> Vec<f64> {
        let count = self.parameters();
        match self.kind {
            // One or two pigments of some thickness, and traces of the others.
            Kind::Pigments { .. } => {
                let mut parameters = vec![-4.0; count];
                for _ in 0..2 {
                    parameters[random.below(count as u32) as usize] = 3.0 * random.uniform() - 2.0;
                }
                parameters
            }
            Kind::Free => (0..count).map(|_| 5.0 * (random.uniform() - 0.5)).collect(),
        }
    }

    /// The transmittance of a filter.
    #[must_use]
    pub fn transmittance(&self, parameters: &[f64]) -> Vec<f64> {
        (0..self.grid.len()).map(|i| self.at(parameters, i)).collect()
    }

    /// The transmittance of a filter as a spectrum.
    ///
    /// # Errors
    /// Never for finite parameters.
    pub fn spectrum(&self, parameters: &[f64]) -> Result<Spectrum, DesignError> {
        Ok(Spectrum::new(self.grid, self.transmittance(parameters)).map_err(CameraError::from)?)
    }

    fn at(&self, parameters: &[f64], i: usize) -> f64 {
        let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
            parameters.iter().zip(&self.curves).map(|(p, curve)| of(*p) * curve[i]).sum()
        };
        match self.kind {
            Kind::Pigments { max_thickness } => self.most * libm::exp(-sum(&|p| max_thickness * logistic(p))),
            Kind::Free => self.most * logistic(sum(&|p| p)),
        }
    }

    /// The derivative with respect to the parameters from that with respect to the transmittance at each wavelength.
    pub(super) fn by_parameters(&self, parameters: &[f64], by_transmittance: &[f64]) -> Vec<f64> {
        let transmittance = self.transmittance(parameters);
        let of = |(p, curve): (&f64, &Vec<f64>)| -> f64 {
            let each = curve.iter().zip(&transmittance).zip(by_transmittance);
            match self.kind {
                Kind::Pigments { max_thickness } => {
                    let slope = max_thickness * logistic(*p) * (1.0 - logistic(*p));
                    -slope * each.map(|((a, t), g)| g * t * a).sum::<f64>()
                }
                Kind::Free => each.map(|((h, t), g)| g * t * (1.0 - t / self.most) * h).sum(),
            }
        };
        parameters.iter().zip(&self.curves).map(of).collect()
    }

    /// The thickness of each pigment of a filter; `None` for other families.
    #[must_use]
    pub fn thicknesses(&self, parameters: &[f64]) -> Option<Vec<f64>> {
        match self.kind {
            Kind::Pigments { max_thickness } => {
                Some(parameters.iter().map(|p| max_thickness * logistic(*p)).collect())
            }
            Kind::Free => None,
        }
    }

    /// Removes the pigments of a filter that absorb least, until it has as many as it may. Returns whether it had more.
    pub(super) fn prune(&self, parameters: &mut [f64]) -> bool {
        let Some(thicknesses) = self.thicknesses(parameters) else { return false };
        let mean = |curve: &Vec<f64>| curve.iter().sum::<f64>() / curve.len() as f64;
        let mut strengths: Vec<(f64, usize)> =
            thicknesses.iter().zip(&self.curves).map(|(d, curve)| d * mean(curve)).zip(0..).collect();
        strengths.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut pruned = false;
        for (_, at) in strengths.into_iter().skip(self.max_pigments) {
            pruned |= parameters[at] > ABSENT;
            parameters[at] = ABSENT;
        }
        pruned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        for space in [FilterSpace::Pigments(Pigments::default()), FilterSpace::Free(FreeCurves::default())] {
            let space = space.sampled(WavelengthGrid::VISIBLE).unwrap();
            let parameters = space.random(&mut Stream::new(1, 2, 3));
            let weights: Vec<f64> = (0..31).map(|i| f64::from(i % 7) - 3.0).collect();
            let value =
                |p: &[f64]| -> f64 { space.transmittance(p).iter().zip(&weights).map(|(t, w)| t * w).sum() };
            let derivative = space.by_parameters(&parameters, &weights);
            for at in 0..space.parameters() {
                let moved = |by: f64| {
                    let mut p = parameters.clone();
                    p[at] += by;
                    value(&p)
                };
                let found = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                assert!((found - derivative[at]).abs() < 1e-7 * (1.0 + found.abs()), "{at}");
            }
        }
    }

    #[test]
    fn filters_stay_within_what_can_be_made() {
        let space = FilterSpace::Pigments(Pigments::default()).sampled(WavelengthGrid::VISIBLE).unwrap();
        let mut random = Stream::new(4, 5, 6);
        for _ in 0..20 {
            let mut parameters = space.random(&mut random);
            assert!(space.transmittance(&parameters).iter().all(|t| (0.0..=0.95).contains(t)));
            space.prune(&mut parameters);
            let thick = space.thicknesses(&parameters).unwrap();
            assert!(thick.iter().filter(|d| **d > 1e-12).count() <= 2 && thick.iter().all(|d| *d <= 2.0));
            assert!(!space.prune(&mut parameters));
        }
    }

    #[test]
    fn impossible_spaces_name_the_key() {
        let key = |space: FilterSpace| match space.sampled(WavelengthGrid::VISIBLE) {
            Err(DesignError::Key { key, .. }) => key,
            other => panic!("{other:?}"),
        };
        let pigments = |library| FilterSpace::Pigments(Pigments { library, ..Pigments::default() });
        assert_eq!(key(pigments(Vec::new())), "pigments.library");
        assert_eq!(key(pigments(vec![Filter::Flat(0.0)])), "pigments.library[0]");
        assert_eq!(key(FilterSpace::Free(FreeCurves { knots: 2, ..FreeCurves::default() })), "free.knots");
    }
}
