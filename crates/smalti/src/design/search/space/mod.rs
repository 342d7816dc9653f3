//! The filters that can be made, as curves with parameters whose derivatives are known.

mod curves;
mod dichroic;
mod free;
mod measured;
mod mixtures;
mod nearest;
mod pigments;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use dichroic::Dichroic;
pub use free::FreeCurves;
pub use measured::Measured;
pub use mixtures::Mixtures;
pub use pigments::Pigments;

use self::curves::Curves;
use crate::camera::CameraError;
use crate::design::error::DesignError;
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
    /// Interference filters that transmit a band.
    Dichroic(Dichroic),
    /// Weighted means of filters, as in learned arrays ([henz2018]).
    ///
    /// [henz2018]: https://github.com/bernardohenz/deep_joint_design_cfa_demosaicing
    Mixtures(Mixtures),
    /// A choice among filters that exist.
    Measured(Measured),
    /// Any smooth curve: the bound that no real filter surpasses.
    Free(FreeCurves),
}

/// A space of filters on the wavelengths of a camera. A filter has as many parameters as [`SampledSpace::parameters`], any numbers.
#[derive(Debug, Clone)]
pub struct SampledSpace {
    grid: WavelengthGrid,
    clear: f64,
    curves: Arc<dyn Curves>,
}

impl FilterSpace {
    /// The space on a wavelength grid.
    ///
    /// # Errors
    /// When a parameter is out of its range or a filter of the library is invalid.
    pub fn sampled(&self, grid: WavelengthGrid) -> Result<SampledSpace, DesignError> {
        let curves: Arc<dyn Curves> = match self {
            Self::Pigments(family) => Arc::new(pigments::Sampled::new(family, grid)?),
            Self::Dichroic(family) => Arc::new(dichroic::Sampled::new(family, grid)?),
            Self::Mixtures(family) => Arc::new(mixtures::Sampled::new(family, grid)?),
            Self::Measured(family) => Arc::new(measured::Sampled::new(family, grid)?),
            Self::Free(family) => Arc::new(free::Sampled::new(family, grid)?),
        };
        Ok(SampledSpace { grid, clear: self.clear(), curves })
    }

    /// The transmittance of a filter without any absorbance.
    #[must_use]
    pub fn clear(&self) -> f64 {
        match self {
            Self::Pigments(family) => family.clear,
            Self::Dichroic(family) => family.max_transmittance,
            Self::Free(family) => family.max_transmittance,
            Self::Mixtures(_) | Self::Measured(_) => 1.0,
        }
    }

    /// The filters of its library, if it has one, and the key of the library.
    #[must_use]
    pub fn library_mut(&mut self) -> Option<(&'static str, &mut Vec<Filter>)> {
        match self {
            Self::Pigments(family) => Some(("pigments.library", &mut family.library)),
            Self::Mixtures(family) => Some(("mixtures.library", &mut family.library)),
            Self::Measured(family) => Some(("measured.library", &mut family.library)),
            Self::Dichroic(_) | Self::Free(_) => None,
        }
    }
}

impl SampledSpace {
    /// Number of parameters of a filter.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.curves.parameters()
    }

    /// The wavelengths.
    #[must_use]
    pub fn grid(&self) -> WavelengthGrid {
        self.grid
    }

    /// The transmittance of a filter without any absorbance.
    #[must_use]
    pub fn clear(&self) -> f64 {
        self.clear
    }

    /// Random parameters of a filter.
    pub(super) fn random(&self, random: &mut Stream) -> Vec<f64> {
        self.curves.random(random)
    }

    /// The transmittance of a filter.
    #[must_use]
    pub fn transmittance(&self, parameters: &[f64]) -> Vec<f64> {
        self.curves.transmittance(parameters)
    }

    /// The transmittance of a filter as a spectrum.
    ///
    /// # Errors
    /// Never for finite parameters.
    pub fn spectrum(&self, parameters: &[f64]) -> Result<Spectrum, DesignError> {
        Ok(Spectrum::new(self.grid, self.transmittance(parameters)).map_err(CameraError::from)?)
    }

    /// The derivative with respect to the parameters from that with respect to the transmittance at each wavelength.
    pub(super) fn by_parameters(&self, parameters: &[f64], by_transmittance: &[f64]) -> Vec<f64> {
        self.curves.by_parameters(parameters, by_transmittance)
    }

    /// The thickness of each pigment of a filter; `None` for other families.
    #[must_use]
    pub fn thicknesses(&self, parameters: &[f64]) -> Option<Vec<f64>> {
        self.curves.thicknesses(parameters)
    }

    /// The thickness of each pigment of a filter with a transmittance on the wavelengths of the space, relative to that of its filter in the library: of the fewest pigments that make it, at most
    /// [`Pigments::max_pigments`], 0 for the others. Their transmittance differs from that of the filter by less than 0.005 everywhere. Thicknesses have no upper
    /// limit. `None` for filters that no pigments make, and for other families.
    #[must_use]
    pub fn layers(&self, transmittance: &Spectrum) -> Option<Vec<f64>> {
        self.curves.layers(transmittance.values())
    }

    /// Removes what a factory cannot make of the filters of an array. Returns whether it removed anything.
    pub(super) fn prune(&self, filters: &mut [Vec<f64>]) -> bool {
        self.curves.prune(filters)
    }

    /// Number of filters to choose from; `None` for families of continuous parameters.
    pub(super) fn choices(&self) -> Option<usize> {
        self.curves.choices()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn builtin(names: &[&str]) -> Vec<Filter> {
        names.iter().map(|n| Filter::Builtin((*n).into())).collect()
    }

    pub(super) fn continuous() -> [FilterSpace; 4] {
        [
            FilterSpace::Pigments(Pigments::default()),
            FilterSpace::Dichroic(Dichroic::default()),
            FilterSpace::Mixtures(Mixtures { library: builtin(&["pigment/R", "pigment/G", "pigment/B"]) }),
            FilterSpace::Free(FreeCurves::default()),
        ]
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        for space in continuous() {
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
                assert!((found - derivative[at]).abs() < 1e-7 * (1.0 + found.abs()), "{space:?} {at}");
            }
        }
    }

    #[test]
    fn filters_stay_within_what_can_be_made() {
        for space in continuous() {
            let space = space.sampled(WavelengthGrid::VISIBLE).unwrap();
            let mut random = Stream::new(4, 5, 6);
            for _ in 0..20 {
                let mut filters = vec![space.random(&mut random), space.random(&mut random)];
                space.prune(&mut filters);
                for parameters in &filters {
                    assert!(space.transmittance(parameters).iter().all(|t| (0.0..=0.98).contains(t)));
                }
                assert!(!space.prune(&mut filters));
            }
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
        let edges = Dichroic { edge_nm: 0.0, ..Dichroic::default() };
        assert_eq!(key(FilterSpace::Dichroic(edges)), "dichroic.edge_nm");
        assert_eq!(
            key(FilterSpace::Measured(Measured { library: builtin(&["pigment/R"]) })),
            "measured.library"
        );
        let mixture = Mixtures { library: builtin(&["no such filter"]) };
        assert_eq!(key(FilterSpace::Mixtures(mixture)), "mixtures.library[0]");
    }

    /// A filter of pigments has the layers of its parameters; filters of other families have none.
    #[test]
    fn layers_are_those_of_pigments_alone() {
        for family in continuous() {
            let space = family.sampled(WavelengthGrid::VISIBLE).unwrap();
            // Green and yellow, if they are pigments: others are absent.
            let mut parameters = vec![-60.0; space.parameters()];
            (parameters[1], parameters[space.parameters() - 1]) = (-0.6, 2.9);
            let filter = space.spectrum(&parameters).unwrap();
            assert_eq!(filter.values(), space.transmittance(&parameters));
            let (found, stated) = (space.layers(&filter), space.thicknesses(&parameters));
            let is_pigments = matches!(family, FilterSpace::Pigments(_));
            assert_eq!((found.is_some(), stated.is_some()), (is_pigments, is_pigments), "{family:?}");
            for (found, stated) in found.iter().flatten().zip(stated.iter().flatten()) {
                assert!((found - stated).abs() < 1e-9, "{found} {stated}");
            }
            assert_eq!((space.choices(), space.clear()), (None, family.clear()));
        }
        let measured = FilterSpace::Measured(Measured { library: builtin(&["pigment/R", "pigment/G"]) });
        let space = measured.sampled(WavelengthGrid::VISIBLE).unwrap();
        assert_eq!((space.choices(), space.parameters(), space.clear()), (Some(2), 1, 1.0));
        assert_eq!(space.layers(&space.spectrum(&[1.0]).unwrap()), None);
    }

    /// A library can be exchanged, and errors of its filters have its key.
    #[test]
    fn libraries_are_those_of_their_keys() {
        let measured = FilterSpace::Measured(Measured { library: builtin(&["pigment/R", "pigment/G"]) });
        for mut space in continuous().into_iter().chain([measured]) {
            let has_none = matches!(space, FilterSpace::Dichroic(_) | FilterSpace::Free(_));
            let Some((key, library)) = space.library_mut() else {
                assert!(has_none, "{space:?}");
                continue;
            };
            assert!(!has_none, "{key}");
            *library = builtin(&["pigment/R", "no such filter"]);
            match space.sampled(WavelengthGrid::VISIBLE) {
                Err(DesignError::Key { key: found, .. }) => assert_eq!(found, format!("{key}[1]")),
                other => panic!("{other:?}"),
            }
        }
    }
}
