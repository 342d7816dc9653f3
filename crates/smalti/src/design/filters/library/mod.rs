//! Sets drawn from a library of filters that can be manufactured: measured filters, and shapes closer to real filters than
//! a Gaussian.

mod series;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use series::{Dye, Dyes, Series};

use super::set::{FilterSet, ascending, index_checked, sampled};
use crate::design::combinations::{binomial, combination};
use crate::design::error::{DesignError, colors_checked};
use crate::sensor::Filter;

const WHAT: &str = "the family library";

/// Maximum number of filters of a library.
const MAX_FILTERS: u64 = 1_000_000;

/// `[filters.library]`: every combination of N filters of a library. The filters of a set are sorted by their mean
/// wavelength between 400 and 700 nm.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Library {
    /// Filters by name: files, built-in filters, formulas.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub filters: BTreeMap<String, Filter>,
    /// Series of filters.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub series: Vec<Series>,
}

impl Library {
    /// Number of filters.
    fn len(&self) -> Result<u64, DesignError> {
        let mut sum = self.filters.len() as u64;
        for (i, series) in self.series.iter().enumerate() {
            sum = sum.saturating_add(series.len(&key(i))?);
        }
        if sum <= MAX_FILTERS {
            return Ok(sum);
        }
        Err(DesignError::key("library", format!("{sum} filters; at most {MAX_FILTERS} are expected")))
    }

    /// A filter by its number, with its name; `None` when there is none.
    fn at(&self, index: u64) -> Result<Option<(String, Filter)>, DesignError> {
        let given = self.filters.len() as u64;
        if index < given {
            return Ok(self.filters.iter().nth(index as usize).map(|(n, f)| (n.clone(), f.clone())));
        }
        let mut rest = index - given;
        for (i, series) in self.series.iter().enumerate() {
            let len = series.len(&key(i))?;
            if rest < len {
                return series.at(&key(i), rest);
            }
            rest -= len;
        }
        Ok(None)
    }

    pub(super) fn validate(&self) -> Result<(), DesignError> {
        for (name, filter) in &self.filters {
            sampled(&format!("library.filters.{name}"), filter)?;
        }
        for (i, series) in self.series.iter().enumerate() {
            let len = series.len(&key(i))?;
            // Parameters are monotone along a series, so that checking both ends suffices.
            for at in [0, len.saturating_sub(1)] {
                if let Some((_, filter)) = series.at(&key(i), at)? {
                    sampled(&key(i), &filter)?;
                }
            }
        }
        Ok(())
    }

    pub(super) fn count(&self, colors: usize) -> Result<u128, DesignError> {
        let k = colors_checked(colors)?;
        binomial(self.len()?.into(), k).ok_or(DesignError::Uncountable { what: WHAT, colors })
    }

    pub(super) fn set(&self, colors: usize, index: u128) -> Result<FilterSet, DesignError> {
        let count = self.count(colors)?;
        index_checked(WHAT, colors, index, count)?;
        let missing = DesignError::Index { what: WHAT, colors, index, count };
        let chosen = combination(self.len()?, colors_checked(colors)?, index).ok_or(missing.clone())?;
        let filter = |i| self.at(i)?.ok_or(missing.clone());
        let filters = ascending(chosen.into_iter().map(filter).collect::<Result<_, _>>()?)?;
        let label: Vec<&str> = filters.iter().map(|(name, _)| name.as_str()).collect();
        let label = label.join(", ");
        Ok(FilterSet { label, filters: filters.into_iter().map(|(_, filter)| filter).collect() })
    }
}

fn key(series: usize) -> String {
    format!("library.series[{series}]")
}

#[cfg(test)]
mod tests {
    use super::series::MEASURED;
    use super::*;
    use crate::sensor::cfa::builtin_filters;

    #[test]
    fn every_measured_filter_is_in_the_series() {
        let measured = builtin_filters().iter().filter(|f| f.source.starts_with("Measured")).map(|f| f.name);
        assert!(measured.eq(MEASURED));
    }

    /// What cannot be sampled is named: a filter that is stated, or either end of a series.
    #[test]
    fn filters_that_cannot_be_sampled_are_named() {
        let named = |name: &str, filter: Filter| BTreeMap::from([(name.to_owned(), filter)]);
        let peak = |peak| Series::RaisedCosine {
            centers_nm: [450.0, 100.0, 650.0],
            fwhms_nm: [60.0, 20.0, 80.0],
            peak,
        };
        let key = |library: Library| match library.validate() {
            Err(DesignError::Key { key, .. }) => key,
            other => panic!("{other:?}"),
        };
        let filters = named("green", Filter::File("green.csv".into()));
        assert_eq!(key(Library { filters, ..Library::default() }), "library.filters.green");
        let series = vec![Series::Measured, peak(1.5)];
        assert_eq!(key(Library { series, ..Library::default() }), "library.series[1]");
        let good = Library {
            filters: named("clear", Filter::Flat(0.9)),
            series: vec![Series::Measured, peak(1.0), Series::Dyes(Dyes::default())],
        };
        assert_eq!(good.validate(), Ok(()));
        assert_eq!(Library::default().validate(), Ok(()));
    }
}
