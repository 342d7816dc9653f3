//! One set of filters.

use super::figures::{FilterFigures, mean_wavelength_nm};
use crate::design::error::DesignError;
use crate::sensor::Filter;
use crate::spectrum::WavelengthGrid;

/// The filters of one design.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterSet {
    /// Its name in results.
    pub label: String,
    /// The filters, ascending in wavelength: channel i of the mosaic has filter i.
    pub filters: Vec<Filter>,
}

impl FilterSet {
    /// The figures of every filter.
    ///
    /// # Errors
    /// When a filter cannot be sampled.
    pub fn figures(&self) -> Result<Vec<FilterFigures>, DesignError> {
        let of = |filter| {
            FilterFigures::new(filter)
                .map_err(|problem| DesignError::Filter { name: self.label.clone(), problem })
        };
        self.filters.iter().map(of).collect()
    }
}

/// Checks that a set with this number exists.
pub(super) fn index_checked(
    what: &'static str,
    colors: usize,
    index: u128,
    count: u128,
) -> Result<(), DesignError> {
    if index < count { Ok(()) } else { Err(DesignError::Index { what, colors, index, count }) }
}

/// Checks that a filter can be sampled; `key` is its path in the study file.
pub(super) fn sampled(key: &str, filter: &Filter) -> Result<(), DesignError> {
    filter.spectrum(WavelengthGrid::VISIBLE).map(drop).map_err(|e| DesignError::key(key, e))
}

/// The filters of a set in ascending order of their mean wavelength, with their names. Equal ones keep their order.
pub(super) fn ascending(filters: Vec<(String, Filter)>) -> Result<Vec<(String, Filter)>, DesignError> {
    let place = |(name, filter): (String, Filter)| match mean_wavelength_nm(&filter) {
        Ok(nm) => Ok((nm, (name, filter))),
        Err(problem) => Err(DesignError::Filter { name, problem }),
    };
    let mut placed = filters.into_iter().map(place).collect::<Result<Vec<_>, _>>()?;
    placed.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(placed.into_iter().map(|(_, filter)| filter).collect())
}
