//! Colour filter arrays by name.

use super::catalog_data::{CATALOG, Layout};
use super::named;
use super::random::blue_noise;
use super::{Cfa, CfaError, Channel, Mosaic, WeightedMosaic};
use crate::names::nearest;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// One entry of the catalogue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CfaInfo {
    /// Its name.
    pub name: &'static str,
    /// Other names it answers to.
    pub aliases: &'static [&'static str],
    /// What it is.
    pub summary: &'static str,
    /// Where the pattern was published, and where it could not be checked against that publication, that.
    pub source: &'static str,
    /// The default filter of each letter, by its name among the [`builtin_filters`](super::builtin_filters);
    /// of each primary, where cells are mixtures of primaries. They are generic: the publications behind the
    /// patterns have filters of their own.
    pub filters: &'static [(char, &'static str)],
    pub(super) layout: Layout,
}

impl CfaInfo {
    /// The pattern, one text per row. Cells that are mixtures have a letter for each distinct mixture, from `a`
    /// on; the random mosaic is shown with its default parameters.
    #[must_use]
    pub fn pattern(&self) -> Vec<String> {
        let lower: Vec<char> = ('a'..='z').collect();
        let lettered = |mosaic: Mosaic, letters: &[char]| mosaic.to_letters(letters).unwrap_or_default();
        match self.layout {
            Layout::Letters(lines) => lines.iter().map(|&l| l.into()).collect(),
            Layout::Weighted { .. } => self
                .weighted()
                .and_then(|w| w.distinct())
                .map(|(mosaic, _)| lettered(mosaic, &lower))
                .unwrap_or_default(),
            Layout::Random => RandomTile::default()
                .mosaic()
                .map(|mosaic| lettered(mosaic, &RandomTile::default().letters()))
                .unwrap_or_default(),
        }
    }

    /// The pattern of an entry whose letters are single filters; `None` where cells are mixtures of filters, or the
    /// tile is made from parameters.
    #[must_use]
    pub fn fixed_pattern(&self) -> Option<&'static [&'static str]> {
        match self.layout {
            Layout::Letters(lines) => Some(lines),
            Layout::Weighted { .. } | Layout::Random => None,
        }
    }

    /// Rows of the tile.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.pattern().len()
    }

    /// Columns of the tile.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.pattern().first().map_or(0, |l| l.chars().count())
    }

    fn weighted(&self) -> Result<WeightedMosaic, CfaError> {
        match self.layout {
            Layout::Weighted { rows, cols, carrier, primaries } => {
                WeightedMosaic::modulated(rows, cols, carrier, primaries)
            }
            _ => Err(CfaError::Tile { rows: 0, cols: 0, cells: 0 }),
        }
    }
}

/// All entries.
#[must_use]
pub fn names() -> &'static [CfaInfo] {
    CATALOG
}

/// The entry of a name or alias. Case does not count, and parameters after a `?` are left aside.
///
/// # Errors
/// When there is none; the error suggests the nearest name.
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

/// The pattern of a name, one text per row: [`CfaInfo::pattern`], with the parameters of the name.
///
/// # Errors
/// When no entry has that name, or a parameter is wrong.
pub fn pattern(name: &str) -> Result<Vec<String>, CfaError> {
    let entry = info(name)?;
    match parameters(name, entry)? {
        Some(random) => Ok(random.mosaic()?.to_letters(&random.letters()).unwrap_or_default()),
        None => Ok(entry.pattern()),
    }
}

/// A colour filter array of the catalogue with its default filters on a grid. The random mosaic takes
/// parameters: `random?channels=4&rows=8&cols=8&seed=1`, each optional.
///
/// # Errors
/// When no entry has that name, or a parameter is wrong.
pub fn builtin(name: &str, grid: WavelengthGrid) -> Result<Cfa, CfaError> {
    builtin_with(name, grid, &[])
}

/// As [`builtin`], with some or all of its filters (those of the primaries, where cells are mixtures) replaced.
///
/// # Errors
/// As [`builtin`]; and when a letter is not one of the array's, or as [`Cfa::new`].
pub fn builtin_with(name: &str, grid: WavelengthGrid, filters: &[(char, Spectrum)]) -> Result<Cfa, CfaError> {
    let entry = info(name)?;
    let random = parameters(name, entry)?;
    let defaults: Vec<(char, String)> = match &random {
        Some(r) => r.filters(),
        None => entry.filters.iter().map(|&(l, f)| (l, f.to_owned())).collect(),
    };
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
    if let Layout::Weighted { .. } = entry.layout {
        let channel =
            |(letter, transmittance): (char, Spectrum)| Channel { name: letter.into(), transmittance };
        let primaries: Vec<Channel> = spectra.into_iter().map(channel).collect();
        return entry.weighted()?.cfa(entry.name, &primaries);
    }
    Cfa::from_pattern(if random.is_some() { name } else { entry.name }, &pattern(name)?, &spectra)
}

/// The parameters behind the `?`; `None` for entries that take none.
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
        // Anything beyond usize is beyond every limit as well.
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

/// The parameters of the random mosaic.
struct RandomTile {
    channels: usize,
    rows: usize,
    cols: usize,
    seed: u64,
}

impl Default for RandomTile {
    fn default() -> Self {
        Self { channels: 3, rows: 8, cols: 8, seed: 1 }
    }
}

impl RandomTile {
    /// The tile, its channels renumbered in order of appearance, as patterns in letters are.
    fn mosaic(&self) -> Result<Mosaic, CfaError> {
        blue_noise(self.channels, self.rows, self.cols, self.seed)
    }

    /// Red, green, blue, white where that makes sense, and bands side by side elsewhere.
    fn filters(&self) -> Vec<(char, String)> {
        let common = [('R', "red"), ('G', "green"), ('B', "blue"), ('W', "white")];
        match self.channels {
            n @ 3..=4 => common.iter().take(n).map(|&(l, f)| (l, f.to_owned())).collect(),
            n => {
                ('A'..='Z').take(n).enumerate().map(|(k, l)| (l, format!("band-{}-of-{n}", k + 1))).collect()
            }
        }
    }

    fn letters(&self) -> Vec<char> {
        self.filters().into_iter().map(|(l, _)| l).collect()
    }
}
