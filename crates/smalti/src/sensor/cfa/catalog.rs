//! The catalogue of colour filter arrays.

use super::catalog_data::CATALOG;
use super::catalog_entry::{CfaInfo, Layout, RandomTile};
use super::named;
use super::{Cfa, CfaError, Channel, WeightedMosaic};
use crate::names::nearest;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// All entries.
#[must_use]
pub fn names() -> &'static [CfaInfo] {
    CATALOG
}

/// The entry with a name or alias. Case and any parameters after `?` are ignored.
///
/// # Errors
/// When there is none; the error suggests the closest name.
pub fn info(name: &str) -> Result<&'static CfaInfo, CfaError> {
    let wanted = name.split_once('?').map_or(name, |(n, _)| n);
    let all = || {
        CATALOG
            .iter()
            .flat_map(|i| std::iter::once((i.name, i)).chain(i.aliases.iter().map(move |&a| (a, i))))
    };
    all().find(|(n, _)| n.eq_ignore_ascii_case(wanted)).map(|(_, i)| i).ok_or_else(|| CfaError::UnknownName {
        what: "CFA",
        name: wanted.into(),
        suggestion: nearest(wanted, all().map(|(n, _)| n)).map(str::to_owned),
    })
}

/// The pattern of a name, one string per row: [`CfaInfo::pattern`] with the parameters in the name.
///
/// # Errors
/// When no entry has that name, or a parameter is invalid.
pub fn pattern(name: &str) -> Result<Vec<String>, CfaError> {
    let entry = info(name)?;
    match parameters(name, entry)? {
        Some(random) => random.pattern(),
        None => entry.pattern(),
    }
}

/// The default filter of each letter of a name (of each primary, where cells are mixtures): [`CfaInfo::filters`] with the parameters
/// in the name.
///
/// # Errors
/// When no entry has that name, or a parameter is invalid.
pub fn default_filters(name: &str) -> Result<Vec<(char, String)>, CfaError> {
    let entry = info(name)?;
    Ok(filters_of(entry, parameters(name, entry)?.as_ref()))
}

fn filters_of(entry: &CfaInfo, random: Option<&RandomTile>) -> Vec<(char, String)> {
    match random {
        Some(tile) => tile.filters(),
        None => entry.filters.iter().map(|&(letter, filter)| (letter, filter.to_owned())).collect(),
    }
}

/// A colour filter array of the catalogue with its default filters on a grid. The random mosaic accepts
/// optional parameters: `random?channels=4&rows=8&cols=8&seed=1`.
///
/// # Errors
/// When no entry has that name, or a parameter is invalid.
pub fn builtin(name: &str, grid: WavelengthGrid) -> Result<Cfa, CfaError> {
    builtin_with(name, grid, &[])
}

/// Like [`builtin`], with some or all of its filters replaced (those of the primaries, where cells are
/// mixtures).
///
/// # Errors
/// As for [`builtin`], as for [`Cfa::new`], and when the array does not have a given letter.
pub fn builtin_with(name: &str, grid: WavelengthGrid, filters: &[(char, Spectrum)]) -> Result<Cfa, CfaError> {
    let entry = info(name)?;
    let random = parameters(name, entry)?;
    let defaults = filters_of(entry, random.as_ref());
    if let Some((letter, _)) = filters.iter().find(|(l, _)| !defaults.iter().any(|(d, _)| d == l)) {
        let known: Vec<String> = defaults.iter().map(|(l, _)| l.to_string()).collect();
        return Err(CfaError::UnknownName {
            what: "letter of this CFA",
            name: letter.to_string(),
            suggestion: nearest(&letter.to_string(), known.iter().map(String::as_str)).map(str::to_owned),
        });
    }
    let chosen = |(letter, default): &(char, String)| match filters.iter().find(|(l, _)| l == letter) {
        Some((_, f)) => Ok((*letter, f.clone())),
        None => Ok((*letter, named::spectrum(default, grid)?)),
    };
    let spectra = defaults.iter().map(chosen).collect::<Result<Vec<_>, CfaError>>()?;
    if let Layout::Weighted { rows, cols, carrier, primaries: modulations } = entry.layout {
        let channel =
            |(letter, transmittance): (char, Spectrum)| Channel { name: letter.into(), transmittance };
        let primaries: Vec<Channel> = spectra.into_iter().map(channel).collect();
        return WeightedMosaic::modulated(rows, cols, carrier, modulations)?.cfa(entry.name, &primaries);
    }
    Cfa::from_pattern(if random.is_some() { name } else { entry.name }, &pattern(name)?, &spectra)
}

/// The parameters after the `?`; `None` for entries without parameters.
fn parameters(name: &str, entry: &CfaInfo) -> Result<Option<RandomTile>, CfaError> {
    let text = name.split_once('?').map_or("", |(_, p)| p);
    let mut tile = RandomTile::default();
    for pair in text.split('&').filter(|p| !p.is_empty()) {
        let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
        if entry.layout != Layout::Random {
            let what = "parameter of a CFA with a fixed pattern";
            return Err(CfaError::UnknownName { what, name: key.into(), suggestion: None });
        }
        let number = value.parse::<u64>().map_err(|_| CfaError::ParameterText {
            name: key.into(),
            value: value.into(),
            expected: "a whole number",
        })?;
        // A value beyond usize exceeds every limit as well.
        let size = usize::try_from(number).unwrap_or(usize::MAX);
        match key {
            "channels" => tile.channels = size,
            "rows" => tile.rows = size,
            "cols" => tile.cols = size,
            "seed" => tile.seed = number,
            _ => {
                return Err(CfaError::UnknownName {
                    what: "parameter of the random CFA",
                    name: key.into(),
                    suggestion: nearest(key, ["channels", "rows", "cols", "seed"]).map(str::to_owned),
                });
            }
        }
    }
    Ok((entry.layout == Layout::Random).then_some(tile))
}
