//! The published mosaics of the catalogue.

use std::collections::BTreeSet;

use crate::design::error::{DesignError, colors_checked};
use crate::design::filters::mean_wavelength_nm;
use crate::sensor::cfa::{CfaInfo, names};
use crate::sensor::{Filter, Mosaic};

/// The mosaics of the [catalogue](names) with `colors` filters, each with its first entry in the catalogue.
///
/// Channels are ordered by the mean wavelength of the filters of the entry between 400 and 700 nm. In the Bayer mosaic,
/// blue is channel 0, green 1 and red 2. White lies between green and red, and infrared comes last.
///
/// The list omits entries whose cells are mixtures of filters (`hirakawa2008`, `condat2011`), the `random` mosaic, and every
/// entry that is a shift of an earlier one (the other Bayer phases, and `rccb`, `ryyb` and `cyym`, which are Bayer mosaics of
/// other filters).
///
/// # Errors
/// When `colors` is not 1 to 26.
pub fn published(colors: usize) -> Result<Vec<(&'static CfaInfo, Mosaic)>, DesignError> {
    colors_checked(colors)?;
    let (mut found, mut seen) = (Vec::new(), BTreeSet::new());
    for entry in names() {
        let Some(lines) = entry.fixed_pattern() else { continue };
        let (mosaic, letters) = Mosaic::from_letters(lines)?;
        if letters.len() != colors {
            continue;
        }
        let mut rank = vec![0u8; colors];
        ordered(entry, &letters)?.iter().zip(0..).for_each(|((channel, _), place)| rank[*channel] = place);
        let cells = mosaic.cells().iter().map(|&c| rank[usize::from(c)]).collect();
        let mosaic = Mosaic::new(mosaic.rows(), mosaic.cols(), cells)?;
        let canonical = mosaic.canonical();
        if seen.insert((canonical.rows(), canonical.cells().to_vec())) {
            found.push((entry, mosaic));
        }
    }
    Ok(found)
}

/// The built-in filters of an entry of [`published`], channel by channel of its mosaic there.
///
/// # Errors
/// Never for the entries of the catalogue.
pub(crate) fn published_filters(entry: &CfaInfo) -> Result<Vec<Filter>, DesignError> {
    let (_, letters) = Mosaic::from_letters(entry.fixed_pattern().unwrap_or_default())?;
    Ok(ordered(entry, &letters)?.into_iter().map(|(_, filter)| filter).collect())
}

/// The filters of the letters of an entry in ascending order of their mean wavelengths, each with the number of its letter.
fn ordered(entry: &CfaInfo, letters: &[char]) -> Result<Vec<(usize, Filter)>, DesignError> {
    let mut places = Vec::new();
    for (channel, letter) in letters.iter().enumerate() {
        let name = entry.filters.iter().find(|(l, _)| l == letter).map_or("", |(_, f)| f);
        let filter = Filter::Builtin(name.into());
        places.push((mean_wavelength_nm(&filter)?, channel, filter));
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(places.into_iter().map(|(_, channel, filter)| (channel, filter)).collect())
}
