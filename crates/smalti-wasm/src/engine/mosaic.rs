//! A design with another mosaic of the catalogue.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use serde::de::{DeserializeOwned, Error};
use serde_json::Value;
use smalti::camera::description::{CfaDescription, ExchangeError, FilterWithKind, PatternDescription};

use super::EngineError;
use super::request::MosaicRequest;

/// Whether the design can have that mosaic, and its array with it.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Exchanged {
    /// The camera has curves of its own, and no filter for some letters.
    Missing { missing: Vec<char> },
    /// It can have the mosaic.
    Array(Box<ExchangedArray>),
}

#[derive(Debug, Serialize)]
pub(super) struct ExchangedArray {
    /// The array of `CAMERA@MOSAIC`, for the camera that was opened.
    given: CfaDescription,
    /// The same with its tile in letters and with all of its filters.
    in_full: CfaDescription,
    /// The same with the filters that were changed by hand.
    array: CfaDescription,
    /// The filters that were changed by hand.
    changed: Vec<FilterWithKind>,
    /// Whether it is the array of the camera that was opened.
    is_own: bool,
}

/// The array of a design with another mosaic: that of `CAMERA@MOSAIC` ([`CfaDescription::with_mosaic_of`]) for the camera that was opened, with the filters that were
/// changed by hand in place of those of their kind.
pub(super) fn exchanged(request: &MosaicRequest) -> Result<Exchanged, EngineError> {
    let base: CfaDescription = read("base", &request.base)?;
    let last = read("given", &request.given)?;
    let present = read("array", &request.array)?;
    let before = read("changed", &request.changed)?;
    let pattern = PatternDescription::Name(request.mosaic.clone());
    let wanted = CfaDescription { pattern, ..CfaDescription::default() };
    let changed = changed_by_hand(&last, &present, before)?;
    let generic = wanted.filters_with_kind()?;
    let mut by_hand = BTreeMap::new();
    for FilterWithKind { letter, kind, .. } in &generic {
        let serving = FilterWithKind::serving(&changed, *letter, kind.as_deref());
        by_hand.extend(serving.map(|own| (letter.to_string(), own.filter.clone())));
    }
    let with = |filters| base.with_mosaic_of(&CfaDescription { filters, ..wanted.clone() }, &BTreeSet::new());
    let new = match with(BTreeMap::new()) {
        Err(ExchangeError::NoFilter { missing, .. }) => {
            let is_missing = |letter: char| missing.iter().any(|(l, _)| *l == letter);
            let missing: Vec<char> =
                missing.iter().map(|(l, _)| *l).filter(|l| !by_hand.contains_key(&l.to_string())).collect();
            if !missing.is_empty() {
                return Ok(Exchanged::Missing { missing });
            }
            // Where the camera has none, that of the catalogue stands for a filter by hand, which thus remains one.
            let own = generic.into_iter().filter(|own| is_missing(own.letter));
            with(own.map(|own| (own.letter.to_string(), own.filter)).collect())?.cfa
        }
        other => other?.cfa,
    };
    let kept = with(by_hand)?.cfa;
    let in_full = new.in_full()?;
    let is_own = in_full == base.in_full()?;
    let array = kept.in_full()?;
    Ok(Exchanged::Array(Box::new(ExchangedArray { given: new, in_full, array, changed, is_own })))
}

/// An array with its tile in letters and with all of its filters.
pub(super) fn in_full(array: &Value) -> Result<CfaDescription, EngineError> {
    let array: CfaDescription = read("array", array)?;
    Ok(array.in_full()?)
}

/// A part of the request, with its key in errors.
fn read<T: DeserializeOwned>(key: &str, value: &Value) -> Result<T, EngineError> {
    T::deserialize(value).map_err(|e| serde_json::Error::custom(format!("{key}: {e}")).into())
}

/// The filters of an array that were added to those that it was given or differ from them, and those that were changed before and that it does not have.
fn changed_by_hand(
    given: &CfaDescription,
    array: &CfaDescription,
    before: Vec<FilterWithKind>,
) -> Result<Vec<FilterWithKind>, ExchangeError> {
    let given = given.filters_with_kind()?;
    let is_added = |own: &FilterWithKind| given.iter().all(|before| before.letter != own.letter);
    let added = array.filters_with_kind()?.into_iter().filter(is_added).map(|own| (true, own));
    let mut now: Vec<_> = added.collect();
    for own in given.iter().cloned() {
        let present = array.filters.get(&own.letter.to_string());
        now.extend(
            present.map(|filter| (*filter != own.filter, FilterWithKind { filter: filter.clone(), ..own })),
        );
    }
    let is_older = |old: &FilterWithKind| {
        !now.iter().any(|(_, own)| match &old.kind {
            None => own.letter == old.letter,
            Some(_) => own.kind == old.kind,
        })
    };
    let older: Vec<FilterWithKind> = before.into_iter().filter(is_older).collect();
    Ok(now.into_iter().filter(|(is_changed, _)| *is_changed).map(|(_, own)| own).chain(older).collect())
}
