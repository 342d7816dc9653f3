//! Families of filter sets. A family counts its sets of N filters and computes any of them from its number.

mod figures;
mod gaussian_grid;
mod library;
mod list;
mod rule;
mod set;
mod steps;

use serde::{Deserialize, Serialize};

pub use figures::FilterFigures;
pub(super) use figures::mean_wavelength_nm;
pub use gaussian_grid::GaussianGrid;
pub use library::{Dye, Dyes, Library, Series};
pub use list::ListedSet;
pub use rule::{Rule, RuleName, RuleTarget};
pub use set::FilterSet;

use super::error::DesignError;
use crate::sensor::Filter;

/// `[filters]` of a study: one table, named after the family. `[filters.gaussian_grid]` without keys is the search of
/// `[cfaresolution]`, section 3.4; `gaussian-grid` is accepted as well.
///
/// The family is the name of a table rather than the value of a key `family`, because serde would then report errors at the
/// line of the table instead of the line of the key.
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
    /// Combinations of the filters of a library.
    Library(Library),
    /// Listed sets.
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

    /// The set with a number below [`FilterFamily::count`], computed without a list of all sets.
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

    /// Samples the filters that the family states and both ends of every series.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the path of the first filter that cannot be sampled: a file that has not been read, or a
    /// parameter out of range.
    pub(super) fn validate(&self) -> Result<(), DesignError> {
        match self {
            Self::GaussianGrid(_) | Self::Rule(_) => Ok(()),
            Self::Library(family) => family.validate(),
            Self::List(sets) => list::validate(sets),
        }
    }

    /// The filters that the family states, with their paths below `[filters]`, so that the caller can read files and replace
    /// each [`Filter::File`] with [`Filter::Samples`].
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
