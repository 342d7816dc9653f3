//! A camera with another mosaic: the filters of the camera, arranged in another tile.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{CfaDescription, PatternDescription};
use crate::sensor::cfa::{self, CfaInfo, Mosaic};
use crate::sensor::{CfaError, Filter};

/// Another mosaic with the filters of a camera; see [`CfaDescription::with_mosaic_of`].
#[derive(Debug, Clone, PartialEq)]
pub struct ExchangedMosaic {
    /// The colour filter array.
    pub cfa: CfaDescription,
    /// Letters whose filter is the default of the catalogue, with the name of that filter, because the camera has none for them.
    pub from_catalog: Vec<(char, String)>,
    /// Letters of filters that were stated for the new mosaic, and that it does not have.
    pub unused: Vec<char>,
}

/// Why a camera cannot have a mosaic.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ExchangeError {
    /// The camera has no filter for some letters of the mosaic, and states filters of its own, which a generic filter does not fit.
    #[error("the mosaic has the {} {}, for which the camera has no filter; it has {}", if .missing.len() == 1 { "letter" } else { "letters" }, listed(.missing), listed(.known))]
    NoFilter {
        /// The letters without a filter, in alphabetical order, each with the kind of filter that it needs if the catalogue tells it.
        missing: Vec<(char, Option<String>)>,
        /// The letters of the camera's filters. A letter that is also missing has the kind of the camera's filter if it is known; this kind differs from the one needed.
        known: Vec<(char, Option<String>)>,
    },
    /// The filters of the camera are not named by single letters.
    #[error("the camera calls a filter '{name}'; expected a single letter")]
    NoLetter {
        /// The name.
        name: String,
    },
    /// The mosaic is not in the catalogue, or its pattern is invalid.
    #[error(transparent)]
    Mosaic(#[from] CfaError),
}

fn listed(letters: &[(char, Option<String>)]) -> String {
    let shown = |(letter, kind): &(char, Option<String>)| match kind {
        Some(kind) => format!("{letter} ({kind})"),
        None => letter.to_string(),
    };
    match letters {
        [] => "none".into(),
        letters => letters.iter().map(shown).collect::<Vec<_>>().join(", "),
    }
}

/// A filter of an array and its kind, which decides which letters of other mosaics it serves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterWithKind {
    /// Its letter.
    pub letter: char,
    /// The filter.
    pub filter: Filter,
    /// The kind of filter, by the name of its generic form; `None` when only the letter tells it.
    pub kind: Option<String>,
}

impl FilterWithKind {
    /// The filter among `all` that serves a letter of a kind: one with the same letter, unless both kinds are known and differ; otherwise one of the same kind. `None` if
    /// there is neither.
    #[must_use]
    pub fn serving<'a>(all: &'a [Self], letter: char, kind: Option<&str>) -> Option<&'a Self> {
        let fits = |own: &&Self| own.kind.is_none() || kind.is_none() || own.kind.as_deref() == kind;
        let of_kind = |own: &&Self| kind.is_some() && own.kind.as_deref() == kind;
        all.iter().filter(|own| own.letter == letter).find(fits).or_else(|| all.iter().find(of_kind))
    }

    /// Whether it is a filter of the catalogue.
    fn is_generic(&self) -> bool {
        matches!(&self.filter, Filter::Builtin(name) if self.kind.as_deref() == Some(kind_of(name)))
    }
}

impl CfaDescription {
    /// The same filters in another mosaic, that of `other`; filters that `other` states take precedence. `stated` are the letters of
    /// filters in `self` that were stated for the new mosaic: they apply to these letters in any case.
    ///
    /// A filter serves a letter of the same kind: clear (`C` of `rccb`) is white (`W` of `rgbw`), and it is not cyan (`C` of `cygm`); the band `W` of `multispectral-5x5`
    /// is not white either. The kind is known in mosaics of the catalogue, and of built-in filters that such a mosaic has, whether the camera names its mosaic or states its letters.
    /// Where one of the two kinds is not known, a filter serves the same letter. If the camera has no filter for a letter, that of the catalogue is taken, provided that
    /// all filters of the camera are those of the catalogue.
    ///
    /// # Errors
    /// When letters remain without a filter, or a mosaic is invalid.
    pub fn with_mosaic_of(
        &self,
        other: &Self,
        stated: &BTreeSet<char>,
    ) -> Result<ExchangedMosaic, ExchangeError> {
        let own = self.filters_with_kind()?;
        let is_generic =
            !own.is_empty() && own.iter().all(|own| stated.contains(&own.letter) || own.is_generic());
        let wanted = other.wanted_filters()?;
        let mut filters = other.filters.clone();
        let (mut from_catalog, mut missing) = (Vec::new(), Vec::new());
        for (letter, default) in &wanted {
            let by_letter = || own.iter().find(|o| o.letter == *letter);
            if stated.contains(letter) {
                filters.extend(by_letter().map(|o| (letter.to_string(), o.filter.clone())));
                continue;
            }
            if filters.contains_key(&letter.to_string()) {
                continue;
            }
            let kind = default.as_deref().map(kind_of);
            match (FilterWithKind::serving(&own, *letter, kind), default) {
                (Some(found), default) => {
                    let default = default.as_ref().map(|name| Filter::Builtin(name.clone()));
                    if !default.is_some_and(|default| is_same(&default, &found.filter)) {
                        filters.insert(letter.to_string(), found.filter.clone());
                    }
                }
                (None, Some(default)) if is_generic => from_catalog.push((*letter, default.clone())),
                (None, _) => missing.push((*letter, kind.map(str::to_owned))),
            }
        }
        if !missing.is_empty() {
            missing.sort_unstable();
            let is_missing = |o: &&FilterWithKind| missing.iter().any(|(letter, _)| *letter == o.letter);
            let known =
                own.iter().map(|o| (o.letter, Some(o).filter(is_missing).and_then(|o| o.kind.clone())));
            let known = known.collect();
            return Err(ExchangeError::NoFilter { missing, known });
        }
        let has = |letter: &char| wanted.iter().any(|(l, _)| l == letter);
        let unused = stated.iter().copied().filter(|letter| !has(letter)).collect();
        let cfa = Self { pattern: other.pattern.clone(), filters, mixtures: other.mixtures.clone() };
        Ok(ExchangedMosaic { cfa, from_catalog, unused })
    }

    /// The filters of this array, those of the catalogue included.
    ///
    /// # Errors
    /// When a filter is not named by a single letter, or the mosaic is not in the catalogue.
    pub fn filters_with_kind(&self) -> Result<Vec<FilterWithKind>, ExchangeError> {
        let mut stated = BTreeMap::new();
        for (name, filter) in &self.filters {
            let letter = single(name).ok_or_else(|| ExchangeError::NoLetter { name: name.clone() })?;
            stated.insert(letter, filter.clone());
        }
        let mut own = Vec::new();
        if let PatternDescription::Name(name) = &self.pattern {
            for (letter, default) in cfa::default_filters(name)? {
                let kind = Some(kind_of(&default).to_owned());
                let filter = stated.remove(&letter).unwrap_or(Filter::Builtin(default));
                own.push(FilterWithKind { letter, filter, kind });
            }
        }
        own.extend(stated.into_iter().map(|(letter, filter)| {
            let kind = match &filter {
                Filter::Builtin(name) if is_of_catalog(kind_of(name)) => Some(kind_of(name).to_owned()),
                _ => None,
            };
            FilterWithKind { letter, filter, kind }
        }));
        Ok(own)
    }

    /// The same array with its tile in letters and with all of its filters, those of the catalogue included.
    ///
    /// # Errors
    /// When the mosaic is not in the catalogue.
    pub fn in_full(&self) -> Result<Self, ExchangeError> {
        let PatternDescription::Name(name) = &self.pattern else { return Ok(self.clone()) };
        let default = |(letter, name): (char, String)| (letter.to_string(), Filter::Builtin(name));
        let mut filters: BTreeMap<_, _> = cfa::default_filters(name)?.into_iter().map(default).collect();
        filters.extend(self.filters.clone());
        let pattern = PatternDescription::Letters(cfa::pattern(name)?);
        Ok(Self { pattern, filters, mixtures: self.mixtures.clone() })
    }

    /// The letters of the filters that this array needs.
    ///
    /// # Errors
    /// When the mosaic is not in the catalogue, or its pattern is invalid.
    pub fn letters(&self) -> Result<Vec<char>, ExchangeError> {
        Ok(self.wanted_filters()?.into_iter().map(|(letter, _)| letter).collect())
    }

    /// The letters of filters that this array needs, with the name of the default filter if it is of the catalogue.
    fn wanted_filters(&self) -> Result<Vec<(char, Option<String>)>, ExchangeError> {
        let lines = match &self.pattern {
            PatternDescription::Name(name) => {
                let defaults = cfa::default_filters(name)?;
                return Ok(defaults.into_iter().map(|(letter, name)| (letter, Some(name))).collect());
            }
            PatternDescription::Letters(lines) => lines,
        };
        let (_, letters) = Mosaic::from_letters(lines)?;
        let mut wanted = BTreeSet::new();
        for letter in letters {
            match self.mixtures.get(&letter.to_string()) {
                Some(mixture) => wanted.extend(mixture.keys().filter_map(|name| single(name))),
                None => drop(wanted.insert(letter)),
            }
        }
        Ok(wanted.into_iter().map(|letter| (letter, None)).collect())
    }
}

/// Whether a mosaic of the catalogue has filters of this kind, such as red, white or one of several bands. A built-in filter of such a kind has it whatever its letter is.
fn is_of_catalog(kind: &str) -> bool {
    let is_default = |entry: &CfaInfo| entry.filters.iter().any(|(_, name)| kind_of(name) == kind);
    kind.starts_with("band-") || cfa::names().iter().any(is_default)
}

/// The kind of a built-in filter: its name, without the infrared that it leaks; clear and white are one kind.
fn kind_of(name: &str) -> &str {
    match name.strip_suffix("+infrared").unwrap_or(name) {
        "clear" => "white",
        kind => kind,
    }
}

/// Whether two filters have the same curve by their names. The catalogue has two names for the lack of a filter.
fn is_same(a: &Filter, b: &Filter) -> bool {
    let is_white = |f: &Filter| matches!(f, Filter::Builtin(name) if name == "clear" || name == "white");
    a == b || (is_white(a) && is_white(b))
}

/// The letter of a name of one letter.
fn single(name: &str) -> Option<char> {
    let mut chars = name.chars();
    chars.next().filter(|_| chars.next().is_none())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn named(pattern: &str) -> CfaDescription {
        CfaDescription { pattern: PatternDescription::Name(pattern.into()), ..Default::default() }
    }

    fn with(mut cfa: CfaDescription, filters: &[(&str, Filter)]) -> CfaDescription {
        cfa.filters.extend(filters.iter().map(|(l, f)| ((*l).to_owned(), f.clone())));
        cfa
    }

    fn builtin(name: &str) -> Filter {
        Filter::Builtin(name.into())
    }

    fn exchanged(from: &CfaDescription, to: &CfaDescription) -> Result<ExchangedMosaic, ExchangeError> {
        from.with_mosaic_of(to, &BTreeSet::new())
    }

    #[test]
    fn generic_filters_stay_generic() {
        let e = exchanged(&named("bayer"), &named("quad-bayer")).unwrap();
        assert_eq!(e.cfa, named("quad-bayer"));
        let e = exchanged(&named("bayer"), &named("rgbw-sony")).unwrap();
        assert_eq!((e.cfa, e.from_catalog), (named("rgbw-sony"), vec![('W', "white".into())]));
        // The same mosaic is the same array, for all of the catalogue.
        for entry in cfa::names() {
            let e = exchanged(&named(entry.name), &named(entry.name)).unwrap();
            assert_eq!((e.cfa, e.from_catalog.len()), (named(entry.name), 0), "{}", entry.name);
        }
    }

    #[test]
    fn filters_of_the_camera_move_with_it() {
        let own = [("R", builtin("imx219/R")), ("G", builtin("imx219/G")), ("B", builtin("imx219/B"))];
        let bayer = with(named("bayer"), &own);
        assert_eq!(exchanged(&bayer, &named("xtrans")).unwrap().cfa, with(named("xtrans"), &own));
        // Mixtures of primaries take them as well, and patterns in letters.
        assert_eq!(exchanged(&bayer, &named("condat2011")).unwrap().cfa, with(named("condat2011"), &own));
        let lines = PatternDescription::Letters(vec!["RGB".into()]);
        let stripes = CfaDescription { pattern: lines, ..Default::default() };
        assert_eq!(exchanged(&bayer, &stripes).unwrap().cfa, with(stripes, &own));
    }

    #[test]
    fn a_measured_camera_gets_no_generic_filter() {
        let own = [("R", builtin("pigment/R")), ("B", builtin("pigment/B"))];
        let rccb = with(named("rccb"), &own);
        // Its clear pixels are white ones; green it does not have.
        let error = exchanged(&rccb, &named("rgbw")).unwrap_err();
        let known = ['R', 'C', 'B'].map(|letter| (letter, None)).to_vec();
        assert_eq!(error, ExchangeError::NoFilter { missing: vec![('G', Some("green".into()))], known });
        let stated = with(rccb, &[("G", builtin("pigment/G"))]);
        let e = stated.with_mosaic_of(&named("rgbw"), &BTreeSet::from(['G'])).unwrap();
        assert_eq!(e.cfa.filters.len(), 3, "{:?}", e.cfa);
        assert!(e.from_catalog.is_empty() && e.unused.is_empty());
    }

    #[test]
    fn letters_of_two_kinds_are_kept_apart() {
        // C is clear in one and cyan in the other.
        let e = exchanged(&named("rccb"), &named("cygm")).unwrap();
        let letters: Vec<char> = e.from_catalog.iter().map(|(l, _)| *l).collect();
        assert_eq!((letters.as_slice(), e.cfa), (['C', 'Y', 'G', 'M'].as_slice(), named("cygm")));
        // A filter of the camera's own serves clear pixels under their other letter.
        let rccb = with(named("rccb"), &[("C", Filter::Flat(0.8))]);
        let e = rccb.with_mosaic_of(&named("rgbw"), &BTreeSet::from(['C'])).unwrap();
        assert_eq!(e.cfa.filters.get("W"), Some(&Filter::Flat(0.8)));
        assert_eq!(e.unused, ['C']);
    }

    /// An array of the catalogue gets the same filters in another mosaic, whether it is stated by its name or in full.
    #[test]
    fn an_array_of_the_catalogue_may_be_stated_in_full() {
        let catalog = || cfa::names().iter().filter(|info| info.fixed_pattern().is_some());
        for from in catalog() {
            let full = named(from.name).in_full().unwrap();
            assert!(matches!(&full.pattern, PatternDescription::Letters(_)) && !full.filters.is_empty());
            for to in catalog() {
                let [by_name, in_full] =
                    [named(from.name), full.clone()].map(|own| exchanged(&own, &named(to.name)).unwrap());
                assert_eq!(in_full, by_name, "{}@{}", from.name, to.name);
            }
        }
    }

    #[test]
    fn a_band_serves_no_other_kind_of_its_letter() {
        let bands = named("multispectral-5x5").in_full().unwrap();
        // W is the band 23 of 25 and not white, and G is a band and not green.
        for (other, letters) in [("mono", vec!['W']), ("rgbw", vec!['R', 'G', 'B', 'W'])] {
            let e = exchanged(&bands, &named(other)).unwrap();
            let taken: Vec<char> = e.from_catalog.iter().map(|(letter, _)| *letter).collect();
            assert_eq!((e.cfa, taken), (named(other), letters));
        }
        // One filter of its own, and generic ones do not fit.
        let own = with(bands, &[("A", Filter::Flat(0.4))]);
        let error = exchanged(&own, &named("mono")).unwrap_err();
        let ExchangeError::NoFilter { missing, known } = &error else { panic!("{error}") };
        assert_eq!(missing, &[('W', Some("white".to_owned()))]);
        assert_eq!((known.len(), &known[22]), (25, &('W', Some("band-23-of-25".to_owned()))));
        let text = error.to_string();
        assert!(
            text.contains("the letter W (white), for which the camera has no filter; it has A, B,"),
            "{text}"
        );
        // A curve of its own in a tile of letters serves the same letter.
        let curve = Filter::Samples { start_nm: 400.0, step_nm: 300.0, values: vec![0.8, 0.9] };
        let e = exchanged(&with(own, &[("W", curve.clone())]), &named("mono")).unwrap();
        assert_eq!(e.cfa, with(named("mono"), &[("W", curve)]));
    }

    #[test]
    fn filters_of_a_mosaic_file_take_precedence() {
        let own = [("R", builtin("imx219/R")), ("G", builtin("imx219/G")), ("B", builtin("imx219/B"))];
        let file = with(named("rgbw"), &[("W", Filter::Flat(0.9)), ("G", builtin("emerald"))]);
        let e = exchanged(&with(named("bayer"), &own), &file).unwrap();
        assert_eq!(e.cfa.filters.get("G"), Some(&builtin("emerald")));
        assert_eq!(e.cfa.filters.get("R"), Some(&builtin("imx219/R")));
        assert_eq!(e.cfa.filters.len(), 4);
    }
}
