//! Families of filter sets: how many sets of N filters each has, and any of them by its number.

mod gaussian_grid;
mod library;
mod list;
mod rule;

use serde::{Deserialize, Serialize};

pub use gaussian_grid::GaussianGrid;
pub use library::{Dye, Dyes, Library, Series};
pub use list::ListedSet;
pub use rule::{Rule, RuleName, RuleTarget};

use super::error::DesignError;
use crate::sensor::Filter;
use crate::spectrum::{Outside, Spectrum, WavelengthGrid};

/// The filters of one design.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterSet {
    /// What it is called in results.
    pub label: String,
    /// The filters, ascending in wavelength: channel i of the mosaic has filter i.
    pub filters: Vec<Filter>,
}

/// `[filters]` of a study: one table, named by the family. `[filters.gaussian_grid]` with no key below it is the
/// search of `[cfaresolution]`, section 3.4; a hyphen does as well as the underscore.
///
/// The family is the name of the table and not the value of a key `family`: serde reads a table with such a key to its
/// end before it looks at the others, and errors about them would name the line of the table in place of their own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum FilterFamily {
    /// Gaussian filters on a grid of centres and widths.
    #[serde(alias = "gaussian-grid")]
    GaussianGrid(GaussianGrid),
    /// Filters by rule.
    Rule(Rule),
    /// Combinations out of a library of filters.
    Library(Library),
    /// Sets written out.
    List(Vec<ListedSet>),
}

impl Default for FilterFamily {
    fn default() -> Self {
        Self::GaussianGrid(GaussianGrid::default())
    }
}

impl FilterFamily {
    /// The number of sets of `colors` filters.
    ///
    /// # Errors
    /// When `colors` is not 1 to 26, a key has an impossible value, or there are more than 2¹²⁸ − 1.
    pub fn count(&self, colors: usize) -> Result<u128, DesignError> {
        match self {
            Self::GaussianGrid(family) => family.count(colors),
            Self::Rule(family) => family.count(colors),
            Self::Library(family) => family.count(colors),
            Self::List(sets) => list::count(sets, colors),
        }
    }

    /// The set of a number below [`FilterFamily::count`]: computed alone, no list is made.
    ///
    /// # Errors
    /// As [`FilterFamily::count`]; when the number is too large, or a filter of the set cannot be sampled (a file that
    /// has not been read, a parameter out of range).
    pub fn set(&self, colors: usize, index: u128) -> Result<FilterSet, DesignError> {
        match self {
            Self::GaussianGrid(family) => family.set(colors, index),
            Self::Rule(family) => family.set(colors, index),
            Self::Library(family) => family.set(colors, index),
            Self::List(sets) => list::set(sets, colors, index),
        }
    }

    /// Tries the filters that are written out in the family, and the ends of every series.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the place of the first that cannot be sampled: a file that has not been read, a parameter
    /// out of range.
    pub(super) fn validate(&self) -> Result<(), DesignError> {
        match self {
            Self::GaussianGrid(_) | Self::Rule(_) => Ok(()),
            Self::Library(family) => family.validate(),
            Self::List(sets) => list::validate(sets),
        }
    }

    /// The filters that are written out in the family and where they stand below `[filters]`, so that whoever opens
    /// files can replace each [`Filter::File`] by [`Filter::Samples`].
    pub fn filters_mut(&mut self) -> Vec<(String, &mut Filter)> {
        match self {
            Self::GaussianGrid(_) | Self::Rule(_) => Vec::new(),
            Self::Library(family) => {
                family.filters.iter_mut().map(|(name, f)| (format!("library.filters.{name}"), f)).collect()
            }
            Self::List(sets) => {
                let mut all = Vec::new();
                for (i, set) in sets.iter_mut().enumerate() {
                    let filters = set.filters.iter_mut().enumerate();
                    all.extend(filters.map(|(j, f)| (format!("list[{i}].filters[{j}]"), f)));
                }
                all
            }
        }
    }
}

/// Full width at half maximum of a Gaussian, standard deviations: 2 √(2 ln 2).
const FWHM_PER_SIGMA: f64 = 2.354_820_045_030_949_3;

/// Where a filter passes light: for tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterFigures {
    /// Its middle where it is formed by one, else its mean wavelength, nm.
    pub center_nm: f64,
    /// Width in which it passes at least half of its peak, nm.
    pub fwhm_nm: f64,
    /// Largest transmittance.
    pub peak: f64,
}

impl From<&Filter> for FilterFigures {
    /// By its formula where that says it, else from samples at every nanometre from 400 to 700; NaN where the filter cannot be
    /// sampled there.
    fn from(filter: &Filter) -> Self {
        match *filter {
            Filter::Gaussian { center_nm, sigma_nm, peak } => {
                Self { center_nm, fwhm_nm: FWHM_PER_SIGMA * sigma_nm, peak }
            }
            Filter::RaisedCosine { center_nm, fwhm_nm, peak }
            | Filter::Butterworth { center_nm, fwhm_nm, peak, .. } => Self { center_nm, fwhm_nm, peak },
            ref other => {
                let grid = WavelengthGrid::new(400.0, 1.0, 301);
                let curve = grid.ok().and_then(|g| other.spectrum(g).ok());
                let (peak, wide) = curve.map_or((f64::NAN, f64::NAN), |c| {
                    let peak = c.max();
                    (peak, c.values().iter().filter(|v| **v >= 0.5 * peak).count() as f64)
                });
                let center_nm = mean_wavelength_nm(other).unwrap_or(f64::NAN);
                Self { center_nm, fwhm_nm: wide, peak }
            }
        }
    }
}

/// Whether a filter can be sampled; `key` is where it stands.
fn sampled(key: &str, filter: &Filter) -> Result<(), DesignError> {
    filter.spectrum(WavelengthGrid::VISIBLE).map(drop).map_err(|e| DesignError::key(key, e))
}

/// Refuses a number that no set has.
fn index_checked(what: &'static str, colors: usize, index: u128, count: u128) -> Result<(), DesignError> {
    if index < count { Ok(()) } else { Err(DesignError::Index { what, colors, index, count }) }
}

/// Evenly spaced values, given as first, step and last (which need not be on a step).
struct Steps {
    first: f64,
    step: f64,
    len: u64,
}

/// Three numbers; of more or fewer the error says which they are.
fn first_step_last<'de, D: serde::Deserializer<'de>>(from: D) -> Result<[f64; 3], D::Error> {
    let found = Vec::<f64>::deserialize(from)?;
    let wrong = |v: Vec<f64>| format!("found {} numbers; expected three: [first, step, last] in nm", v.len());
    found.try_into().map_err(|v| serde::de::Error::custom(wrong(v)))
}

impl Steps {
    fn new(key: &str, [first, step, last]: [f64; 3]) -> Result<Self, DesignError> {
        let range = 1e-3..=1e5;
        let steps = (last - first) / step;
        if range.contains(&first) && range.contains(&last) && step > 0.0 && (0.0..1e6).contains(&steps) {
            return Ok(Self { first, step, len: (steps + 1e-9).floor() as u64 + 1 });
        }
        let message = format!(
            "[{first}, {step}, {last}] is no range; expected [first, step, last] in nm, above 0, ascending, at most a \
             million values"
        );
        Err(DesignError::key(key, message))
    }

    fn at(&self, i: u64) -> f64 {
        // Free of the digits that products of decimal fractions leave: 430.3 and not 430.30000000000001.
        ((self.first + i as f64 * self.step) * 1e6).round() / 1e6
    }
}

/// The filters of a set in ascending order of their mean wavelength, with their names. Equal ones keep their order.
fn ascending(filters: Vec<(String, Filter)>) -> Result<Vec<(String, Filter)>, DesignError> {
    let place = |(name, filter): (String, Filter)| match mean_wavelength_nm(&filter) {
        Ok(nm) => Ok((nm, (name, filter))),
        Err(problem) => Err(DesignError::Filter { name, problem }),
    };
    let mut placed = filters.into_iter().map(place).collect::<Result<Vec<_>, _>>()?;
    placed.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(placed.into_iter().map(|(_, filter)| filter).collect())
}

/// Mean wavelength of what a filter passes of equal numbers of photons between 400 and 700 nm; infinite when it passes
/// nothing there, so that infrared filters come last.
pub(super) fn mean_wavelength_nm(filter: &Filter) -> Result<f64, crate::sensor::CfaError> {
    let grid = WavelengthGrid::VISIBLE;
    let curve = match filter {
        // A measured curve may end within the range; here that means dark.
        Filter::Samples { start_nm, step_nm, values } => {
            let own = WavelengthGrid::new(*start_nm, *step_nm, values.len())?;
            Spectrum::new(own, values.clone())?.resampled(grid, Outside::Zero)?
        }
        other => other.spectrum(grid)?,
    };
    let sum = curve.integral();
    Ok(if sum > 0.0 { curve.map(|nm, v| nm * v).integral() / sum } else { f64::INFINITY })
}
