//! How spectral files name their channels.

use std::path::Path;

use smalti::spectrum::units::LIGHT_M_PER_S;

use crate::IoError;

/// How wavelengths are put into channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// `Radiance.C01`, `Radiance.C02`, …, as pbrt's spectral forks write. The names do not state wavelengths; files
    /// written here state them in the attribute `comments`.
    Pbrt,
    /// `S0.400,0nm`, … (radiance) or `T.400,0nm`, … (reflectance): Fichet, Pacanowski & Wilkie, *An OpenEXR Layout
    /// for Spectral Images*, JCGT 10(3), 2021.
    Fichet2021,
}

/// What a channel of a file holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Band {
    /// Number `n` of a PBRT file, from 1.
    Numbered(usize),
    /// Radiance (first Stokes component) at a wavelength, nm.
    Radiance(f64),
    /// Reflectance at a wavelength, nm.
    Reflectance(f64),
    /// Polarisation beyond the first Stokes component.
    Polarisation,
    /// Re-radiation from one wavelength to another.
    Fluorescence,
}

/// Reads a channel name; `None` for names that are not spectral.
pub(super) fn parse(name: &str) -> Option<Band> {
    if let Some(number) = name.strip_prefix("Radiance.C") {
        let plain = !number.is_empty() && number.len() <= 6 && number.bytes().all(|b| b.is_ascii_digit());
        return if plain { number.parse().ok().map(Band::Numbered) } else { None };
    }
    let (kind, wavelength) = name.split_once('.')?;
    match (kind, wavelength.split_once('.')) {
        ("T", Some((from, to))) => {
            parse_wavelength_nm(from).and(parse_wavelength_nm(to)).map(|_| Band::Fluorescence)
        }
        ("T", None) => parse_wavelength_nm(wavelength).map(Band::Reflectance),
        ("S0", None) => parse_wavelength_nm(wavelength).map(Band::Radiance),
        ("S1" | "S2" | "S3", None) => parse_wavelength_nm(wavelength).map(|_| Band::Polarisation),
        _ => None,
    }
}

/// A number with decimal comma, an SI prefix and `m` or `Hz`, as in `400,0nm`, `0,4um`, `749,48THz`; in nm.
fn parse_wavelength_nm(text: &str) -> Option<f64> {
    let (rest, hertz) = match text.strip_suffix("Hz") {
        Some(rest) => (rest, true),
        None => (text.strip_suffix('m')?, false),
    };
    const PREFIXES: [(&str, f64); 17] = [
        ("da", 1e1),
        ("Y", 1e24),
        ("Z", 1e21),
        ("E", 1e18),
        ("P", 1e15),
        ("T", 1e12),
        ("G", 1e9),
        ("M", 1e6),
        ("k", 1e3),
        ("h", 1e2),
        ("d", 1e-1),
        ("c", 1e-2),
        ("m", 1e-3),
        ("u", 1e-6),
        ("µ", 1e-6),
        ("n", 1e-9),
        ("p", 1e-12),
    ];
    let found = PREFIXES.iter().find_map(|(p, scale)| rest.strip_suffix(p).map(|r| (r, *scale)));
    let (number, scale) = found.unwrap_or((rest, 1.0));
    if number.is_empty() || !number.starts_with(|c: char| c.is_ascii_digit() || c == ',') {
        return None;
    }
    let value: f64 = number.replace(',', ".").parse().ok()?;
    let nm = match (hertz, scale) {
        // Without the detour over metres, nanometres read back exactly.
        (false, 1e-9) => value,
        (false, _) => value * scale * 1e9,
        (true, _) => LIGHT_M_PER_S / (value * scale) * 1e9,
    };
    (nm.is_finite() && nm > 0.0).then_some(nm)
}

/// The channel of a wavelength in the layout of Fichet et al.
pub(super) fn fichet_name(kind: &str, wavelength_nm: f64) -> String {
    let number = wavelength_nm.to_string();
    let number = if number.contains('.') { number.replace('.', ",") } else { number + ",0" };
    format!("{kind}.{number}nm")
}

/// The bands in ascending order of wavelength (or number), each with the index of its channel, and whether they
/// are reflectances. Radiance is preferred where a file has both.
pub(super) enum Bands {
    /// Index of the channel of every number, 1, 2, ….
    Numbered(Vec<usize>),
    /// Wavelength and index of the channel.
    Wavelengths { bands: Vec<(f64, usize)>, reflectance: bool },
}

/// Sorts out the channels of a layer; `None` when none is spectral.
pub(super) fn bands<'a>(
    names: impl Iterator<Item = &'a str> + Clone,
    path: &Path,
) -> Result<Option<Bands>, IoError> {
    let parsed = || names.clone().enumerate().filter_map(|(i, name)| Some((i, name, parse(name)?)));

    let mut radiance: Vec<(f64, usize)> = Vec::new();
    let mut reflectance: Vec<(f64, usize)> = Vec::new();
    let mut numbered: Vec<(usize, usize)> = Vec::new();
    for (i, name, band) in parsed() {
        match band {
            Band::Radiance(nm) => radiance.push((nm, i)),
            Band::Reflectance(nm) => reflectance.push((nm, i)),
            Band::Numbered(n) => numbered.push((n, i)),
            Band::Polarisation => {}
            Band::Fluorescence => {
                return Err(IoError::field(path, "channel", name, "a scene without fluorescence (no T.….…)"));
            }
        }
    }
    let reflective = radiance.is_empty();
    let mut bands = if reflective { reflectance } else { radiance };
    if !bands.is_empty() {
        bands.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(pair) = bands.windows(2).find(|w| w[1].0 - w[0].0 < 1e-6) {
            let field = format!("wavelength {} nm", pair[0].0);
            return Err(IoError::field(path, field, "in two channels", "each wavelength once"));
        }
        if bands.len() < 2 {
            return Err(IoError::field(path, "the spectrum", "one band", "at least two wavelengths"));
        }
        return Ok(Some(Bands::Wavelengths { bands, reflectance: reflective }));
    }
    if numbered.is_empty() {
        return Ok(None);
    }
    numbered.sort_unstable();
    if let Some((i, (n, _))) = numbered.iter().enumerate().find(|(i, (n, _))| *n != i + 1) {
        let expected = format!("Radiance.C{:02}: numbers from 1 without gaps", i + 1);
        return Err(IoError::field(path, "channel", format!("Radiance.C{n:02}"), expected));
    }
    Ok(Some(Bands::Numbered(numbered.into_iter().map(|(_, i)| i).collect())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nm(name: &str) -> Option<f64> {
        match parse(name) {
            Some(Band::Radiance(nm) | Band::Reflectance(nm)) => Some(nm),
            _ => None,
        }
    }

    #[test]
    fn units_and_prefixes_of_the_layout_are_read() {
        assert_eq!(nm("S0.400,0nm"), Some(400.0));
        assert_eq!(nm("S0.400nm"), Some(400.0));
        assert_eq!(nm("T.4,5E2nm"), Some(450.0));
        for name in ["S0.0,4um", "S0.0,4µm", "T.4e-7m", "S0.0,0004mm"] {
            assert!((nm(name).unwrap() - 400.0).abs() < 1e-9, "{name}");
        }
        // c / 749.481145 THz = 400 nm.
        assert!((nm("S0.749,481145THz").unwrap() - 400.0).abs() < 1e-9);
        assert_eq!(parse("S1.400,0nm"), Some(Band::Polarisation));
        assert_eq!(parse("T.400,0nm.500,0nm"), Some(Band::Fluorescence));
        assert_eq!(parse("Radiance.C07"), Some(Band::Numbered(7)));
    }

    #[test]
    fn other_names_are_not_spectral() {
        for name in [
            "R",
            "S0",
            "S0.",
            "S0.nm",
            "S0.-400,0nm",
            "S0.infnm",
            "S4.400nm",
            "Radiance.C",
            "Radiance.C+1",
            "T.0nm",
        ] {
            assert_eq!(parse(name), None, "{name}");
        }
    }

    #[test]
    fn names_read_back_exactly() {
        for v in [400.0, 403.333_333_333_333_3, 1e3 / 3.0] {
            assert_eq!(nm(&fichet_name("S0", v)), Some(v));
        }
        assert_eq!(fichet_name("S0", 400.0), "S0.400,0nm");
    }

    #[test]
    fn gaps_and_repetitions_are_errors() {
        let path = Path::new("f.exr");
        let of = |names: &[&'static str]| {
            bands(names.iter().copied(), path).map(|_| ()).map_err(|e| e.to_string())
        };
        assert!(of(&["Radiance.C01", "Radiance.C03"]).unwrap_err().contains("Radiance.C02"));
        assert!(of(&["S0.400nm", "S0.400,0nm"]).unwrap_err().contains("in two channels"));
        assert!(of(&["S0.400nm"]).unwrap_err().contains("at least two"));
        assert!(of(&["T.1nm.2nm"]).unwrap_err().contains("fluorescence"));
        assert!(of(&["R", "G"]).is_ok());
    }
}
