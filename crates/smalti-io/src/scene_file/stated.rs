//! Wavelengths and quantities as files state them.

use std::path::Path;

use smalti::spectrum::WavelengthGrid;

use super::spectral::{Quantity, ReadOptions};
use crate::error::At;
use crate::wavelengths::uniform_grid;
use crate::{IoError, UnstatedProperty};

/// No spectral camera sees beyond: from the extreme ultraviolet to thermal infrared.
const PLAUSIBLE_NM: std::ops::RangeInclusive<f64> = 100.0..=100_000.0;
/// Two bands nearer than this are one twice.
const NEAREST_NM: f64 = 1e-6;

/// Wavelengths in ascending order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bands {
    /// The band of the file for each wavelength.
    pub(crate) order: Vec<usize>,
    /// nm, ascending.
    pub(crate) wavelengths_nm: Vec<f64>,
    /// The uniform grid that they are resampled to.
    pub(crate) grid: WavelengthGrid,
}

impl Bands {
    /// Sorts the wavelengths of the bands `numbers` of a file; `key` is what states them.
    ///
    /// # Errors
    /// When one is no plausible wavelength, two are equal, or there are fewer than two.
    pub(crate) fn sorted(
        path: &Path,
        key: &str,
        bands: impl IntoIterator<Item = (usize, f64)>,
    ) -> Result<Self, IoError> {
        let mut bands: Vec<(usize, f64)> = bands.into_iter().collect();
        if let Some((i, nm)) = bands.iter().find(|(_, nm)| !PLAUSIBLE_NM.contains(nm)) {
            let found = format!("{nm} nm in band {}", i + 1);
            return Err(IoError::field(path, key, found, "wavelengths of 100 to 100000 nm"));
        }
        bands.sort_by(|a, b| a.1.total_cmp(&b.1));
        if let Some(pair) = bands.windows(2).find(|w| w[1].1 - w[0].1 < NEAREST_NM) {
            let found = format!("{} nm in the bands {} and {}", pair[0].1, pair[0].0 + 1, pair[1].0 + 1);
            return Err(IoError::field(path, key, found, "each wavelength once"));
        }
        if bands.len() < 2 {
            return Err(IoError::field(path, "the spectrum", "one band", "at least two wavelengths"));
        }
        let (order, wavelengths_nm): (Vec<usize>, Vec<f64>) = bands.into_iter().unzip();
        let grid = uniform_grid(&wavelengths_nm, 2 * wavelengths_nm.len()).at(path)?;
        Ok(Self { order, wavelengths_nm, grid })
    }

    /// The wavelengths of the option, for a file that states none.
    ///
    /// # Errors
    /// When none were given, or not as many as there are bands.
    pub(crate) fn given(path: &Path, count: usize, options: &ReadOptions) -> Result<Self, IoError> {
        let Some(grid) = options.grid else {
            let found = format!("not stated for {count} bands");
            let error = IoError::field(path, "the wavelengths", found, "wavelengths in the file");
            return Err(error.or_given(UnstatedProperty::Wavelengths));
        };
        if grid.len() != count {
            let found = format!("not stated for {count} bands, and {} were given", grid.len());
            return Err(IoError::field(path, "the wavelengths", found, format!("{count} of them")));
        }
        let mut bands = Self::sorted(path, "the wavelengths given", grid.wavelengths_nm().enumerate())?;
        bands.grid = grid;
        Ok(bands)
    }

    /// The grid that the file states, where it has these wavelengths.
    pub(crate) fn on(mut self, start_nm: f64, step_nm: f64) -> Self {
        let grid = WavelengthGrid::new(start_nm, step_nm, self.wavelengths_nm.len()).ok();
        let same = |g: &WavelengthGrid| {
            g.wavelengths_nm().zip(&self.wavelengths_nm).all(|(a, b)| (a - b).abs() < NEAREST_NM)
        };
        if let Some(grid) = grid.filter(same) {
            self.wavelengths_nm = grid.wavelengths_nm().collect();
            self.grid = grid;
        }
        self
    }
}

/// A wavelength with its unit anywhere in a text, as in `band 3 (450.5 nm)` or `0.45 µm`; in nm.
pub(crate) fn wavelength_in(text: &str) -> Option<f64> {
    let lower = text.to_lowercase();
    let mut rest = lower.as_str();
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let from = rest.get(start..)?;
        let end = from.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(from.len());
        let (number, after) = (from.get(..end)?, from.get(end..)?);
        let unit = after.trim_start_matches([' ', '_', '-']);
        let ends = |u: &&str| !unit.get(u.len()..).unwrap_or("").starts_with(char::is_alphanumeric);
        let scale = NM_PER_UNIT.iter().find(|(u, _)| unit.starts_with(u) && ends(u)).map(|(_, s)| *s);
        if let (Some(scale), Ok(value)) = (scale, number.parse::<f64>()) {
            return Some(scaled(value, scale));
        }
        rest = after;
    }
    None
}

/// Names of units of wavelength, in lower case, and how many nm they are; longer names first.
const NM_PER_UNIT: [(&str, f64); 12] = [
    ("nanometers", 1.0),
    ("nanometres", 1.0),
    ("nanometer", 1.0),
    ("micrometers", 1e3),
    ("micrometres", 1e3),
    ("micrometer", 1e3),
    ("microns", 1e3),
    ("micron", 1e3),
    ("nm", 1.0),
    ("um", 1e3),
    ("µm", 1e3),
    ("μm", 1e3),
];

/// How many nm a unit of this name is.
pub(crate) fn nm_per_unit(name: &str) -> Option<f64> {
    let name = name.trim().to_lowercase();
    NM_PER_UNIT.iter().find(|(u, _)| *u == name).map(|(_, s)| *s)
}

/// Rounded to what the decimals of a file can have meant, so that 0.45 µm is 450 nm.
pub(crate) fn scaled(value: f64, nm_per_unit: f64) -> f64 {
    if nm_per_unit == 1.0 { value } else { (value * nm_per_unit * 1e6).round() / 1e6 }
}

/// A quantity in the words of a file, and the factor to its unit here; `None` for words that are not known.
///
/// Known are [`Quantity::name`], the words of the command line (`photons`, `energy`, `relative`, `reflectance`), and units of
/// spectral radiance, as in `W m^-2 sr^-1 um^-1` or `uW/(cm^2*sr*nm)`.
pub(crate) fn quantity_in(text: &str) -> Option<(Quantity, f64)> {
    if let Ok(quantity) = text.trim().parse() {
        return Some((quantity, 1.0));
    }
    let lower = text.trim().to_lowercase();
    match lower.as_str() {
        "photons" => return Some((Quantity::Photons, 1.0)),
        "energy" => return Some((Quantity::Energy, 1.0)),
        "relative" => return Some((Quantity::RelativeEnergy, 1.0)),
        "reflectance" | "transmittance" => return Some((Quantity::Reflectance, 1.0)),
        _ => {}
    }
    radiance(text)
}

/// As [`quantity_in`]; an error where the words are not known.
pub(crate) fn known_quantity(path: &Path, text: &str) -> Result<(Quantity, f64), IoError> {
    quantity_in(text).ok_or_else(|| {
        let expected = "photons, energy, relative, reflectance, or a unit such as W m^-2 sr^-1 nm^-1";
        IoError::field(path, "quantity", format!("'{text}'"), expected)
    })
}

/// A unit of spectral radiance: factors with exponents, the denominator behind a slash.
fn radiance(text: &str) -> Option<(Quantity, f64)> {
    let text = text.replace('⁻', "-").replace('¹', "1").replace('²', "2").replace("**", "^");
    let (above, below) = text.split_once('/').unwrap_or((&text, ""));
    let mut factor = 1.0;
    // Powers of photons or watts, metres of area, metres of wavelength, steradians.
    let (mut watts, mut photons, mut seconds, mut area, mut length, mut solid) = (0, 0, 0, 0, 0, 0);
    for (part, sign) in [(above, 1), (below, -1)] {
        let separators = |c: char| c.is_whitespace() || "()[]*·./".contains(c);
        for word in part.split(separators).filter(|w| !w.is_empty()) {
            let end = word.find(|c: char| c == '^' || c == '-' || c.is_ascii_digit()).unwrap_or(word.len());
            let (name, exponent) = word.split_at_checked(end)?;
            let exponent = exponent.trim_start_matches('^');
            let exponent: i32 = if exponent.is_empty() { 1 } else { exponent.parse().ok()? };
            let power = sign * exponent;
            if !(-2..=2).contains(&power) {
                return None;
            }
            let (base, scale) = match name {
                "W" => (&mut watts, 1.0),
                "mW" => (&mut watts, 1e-3),
                "uW" | "µW" | "μW" => (&mut watts, 1e-6),
                "photons" | "photon" => (&mut photons, 1.0),
                "s" | "sec" => (&mut seconds, 1.0),
                "sr" | "str" | "ster" => (&mut solid, 1.0),
                "cm" => (&mut area, 1e-2),
                // Metres are of area; what is counted per wavelength is nm or µm.
                "m" => (&mut area, 1.0),
                "nm" => (&mut length, 1.0),
                "um" | "µm" | "μm" | "micron" | "microns" => (&mut length, 1e3),
                _ => return None,
            };
            *base += power;
            factor *= f64::powi(scale, power);
        }
    }
    match (watts, photons, seconds, area, solid, length) {
        (1, 0, 0, -2, -1, -1) => Some((Quantity::Energy, factor)),
        (0, 1, -1, -2, -1, -1) => Some((Quantity::Photons, factor)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(nm: &[f64]) -> Result<Vec<usize>, String> {
        let path = Path::new("f");
        Bands::sorted(path, "wavelength", nm.iter().copied().enumerate())
            .map(|b| b.order)
            .map_err(|e| e.to_string())
    }

    #[test]
    fn bands_are_sorted_and_absurd_wavelengths_refused() {
        assert_eq!(order(&[700.0, 400.0, 500.0]), Ok(vec![1, 2, 0]));
        for (nm, expected) in [
            (&[400.0, 0.0][..], "f: wavelength is 0 nm in band 2; expected wavelengths of 100 to 100000 nm"),
            (&[400.0, 1e9], "1000000000 nm in band 2"),
            (&[f64::NAN, 400.0], "NaN nm in band 1"),
            (&[400.0, 500.0, 400.0], "400 nm in the bands 1 and 3; expected each wavelength once"),
            (&[400.0], "one band"),
        ] {
            let error = order(nm).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn wavelengths_in_names_need_a_unit() {
        for (text, nm) in [
            ("400 nm", 400.0),
            ("band 3 (450.5 nm)", 450.5),
            ("scene_0450nm", 450.0),
            ("0.45 µm", 450.0),
            ("x_550_nm.", 550.0),
            ("Channel 2: 0.4005 Micrometers", 400.5),
        ] {
            assert_eq!(wavelength_in(text), Some(nm), "{text}");
        }
        for text in ["400", "band 3", "", "nm", "3 nmr", "12 number", "1.2.3 nm"] {
            assert_eq!(wavelength_in(text), None, "{text}");
        }
    }

    #[test]
    fn units_of_radiance_are_understood() {
        for (text, quantity, factor) in [
            ("W m^-2 sr^-1 nm^-1", Quantity::Energy, 1.0),
            ("W/(m^2*sr*um)", Quantity::Energy, 1e-3),
            ("uW/(cm^2*sr*nm)", Quantity::Energy, 1e-2),
            ("mW cm-2 sr-1 um-1", Quantity::Energy, 1e-2),
            ("photons s^-1 m^-2 sr^-1 nm^-1", Quantity::Photons, 1.0),
            ("Reflectance", Quantity::Reflectance, 1.0),
            ("relative energy", Quantity::RelativeEnergy, 1.0),
            ("W·m⁻²·sr⁻¹·nm⁻¹", Quantity::Energy, 1.0),
        ] {
            let (q, f) = quantity_in(text).unwrap_or_else(|| panic!("{text}"));
            assert!(q == quantity && (f / factor - 1.0).abs() < 1e-12, "{text}: {q:?} {f}");
        }
        for text in ["", "W", "W m^-2 sr^-1", "DN", "W m^-2 nm^-1", "furlongs", "W^99 m^-2 sr^-1 nm^-1"] {
            assert_eq!(quantity_in(text), None, "{text}");
        }
    }
}
