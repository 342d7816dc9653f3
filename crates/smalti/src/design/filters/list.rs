//! Filter sets listed in the study file.

use serde::{Deserialize, Serialize};

use super::set::{FilterSet, ascending, index_checked, sampled};
use crate::design::error::{DesignError, colors_checked};
use crate::sensor::Filter;

/// `[[filters.list]]`: one set of filters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ListedSet {
    /// Its name in results. The default is its number in the list, counted from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// The filters, in any order: they are sorted by their mean wavelength.
    pub filters: Vec<Filter>,
}

impl ListedSet {
    /// Its label, or its number in the list.
    fn name(&self, place: usize) -> String {
        self.label.clone().unwrap_or_else(|| format!("set {}", place + 1))
    }
}

fn of(sets: &[ListedSet], colors: usize) -> impl Iterator<Item = (usize, &ListedSet)> {
    sets.iter().enumerate().filter(move |(_, s)| s.filters.len() == colors)
}

pub(super) fn validate(sets: &[ListedSet]) -> Result<(), DesignError> {
    for (i, set) in sets.iter().enumerate() {
        for (j, filter) in set.filters.iter().enumerate() {
            sampled(&format!("list[{i}].filters[{j}]"), filter)?;
        }
    }
    Ok(())
}

pub(super) fn count(sets: &[ListedSet], colors: usize) -> Result<u128, DesignError> {
    colors_checked(colors)?;
    Ok(of(sets, colors).count() as u128)
}

pub(super) fn set(sets: &[ListedSet], colors: usize, index: u128) -> Result<FilterSet, DesignError> {
    let count = count(sets, colors)?;
    let what = "the family list";
    index_checked(what, colors, index, count)?;
    let (place, set) =
        of(sets, colors).nth(index as usize).ok_or(DesignError::Index { what, colors, index, count })?;
    let label = set.name(place);
    let named = set.filters.iter().enumerate().map(|(i, f)| (format!("{label}, {}", i + 1), f.clone()));
    let filters = ascending(named.collect())?.into_iter().map(|(_, filter)| filter).collect();
    Ok(FilterSet { label, filters })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A filter that cannot be sampled is named by its place in the study file.
    #[test]
    fn filters_that_cannot_be_sampled_are_named() {
        let set = |last: Filter| ListedSet { label: None, filters: vec![Filter::Flat(0.5), last] };
        let good = || set(Filter::Gaussian { center_nm: 500.0, sigma_nm: 30.0, peak: 1.0 });
        assert_eq!(validate(&[good(), good()]), Ok(()));
        let unknown = Filter::Builtin("no such filter".into());
        match validate(&[good(), set(unknown), good()]) {
            Err(DesignError::Key { key, .. }) => assert_eq!(key, "list[1].filters[1]"),
            other => panic!("{other:?}"),
        }
    }
}
