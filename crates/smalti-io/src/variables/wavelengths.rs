//! Wavelengths among the variables of a file.

use std::path::Path;

use super::{Attribute, Fields, Numbers, Reading, numbers_at};
use crate::IoError;

/// Names under which wavelengths are looked for, in this order: ISETCam, ICVL and ARAD, others.
pub(super) const NAMES: [&str; 9] = [
    "wave",
    "wavelength",
    "bands",
    "wavelengths",
    "wavelengths_nm",
    "wavelength_nm",
    "spectrum.wave",
    "wavelist",
    "lambda",
];

// Cameras see from the ultraviolet to the thermal infrared; a list outside is not of nanometres.
const PLAUSIBLE_NM: std::ops::RangeInclusive<f64> = 100.0..=30_000.0;

/// The wavelengths beside a cube, nm, and their name.
pub(super) fn beside(fields: &dyn Fields, of: Reading<'_>) -> Result<Option<(Vec<f64>, String)>, IoError> {
    for name in NAMES {
        if let Some(numbers) = numbers_at(fields, name)? {
            return in_nm(&numbers, name, of).map(|nm| Some((nm, name.to_owned())));
        }
    }
    Ok(None)
}

/// The wavelengths that the options give, and what messages call them.
pub(super) fn given(of: Reading<'_>) -> Option<(Vec<f64>, String)> {
    of.options.grid.map(|g| (g.wavelengths_nm().collect(), "the given wavelengths".to_owned()))
}

/// The wavelengths that an attribute of the cube states.
pub(super) fn attribute(cube: &Numbers, path: &Path) -> Result<Option<(Vec<f64>, String)>, IoError> {
    for name in NAMES {
        let stated = cube.attributes.iter().find(|(n, _)| n.eq_ignore_ascii_case(name));
        if let Some((_, Attribute::Numbers(values))) = stated {
            return converted(values.clone(), None, name, path).map(|nm| Some((nm, name.to_owned())));
        }
    }
    Ok(None)
}

/// Wavelengths in nm, converted where an attribute states their unit.
pub(super) fn in_nm(numbers: &Numbers, name: &str, of: Reading<'_>) -> Result<Vec<f64>, IoError> {
    let unit = numbers.attributes.iter().find_map(|(name, value)| match value {
        Attribute::Text(text) if name.to_ascii_lowercase().starts_with("unit") => Some(text.as_str()),
        _ => None,
    });
    converted(numbers.list(name, of.path, of.options.limits)?, unit, name, of.path)
}

fn converted(values: Vec<f64>, unit: Option<&str>, name: &str, path: &Path) -> Result<Vec<f64>, IoError> {
    let factor = match unit.map(|u| u.trim().to_ascii_lowercase()).as_deref() {
        None | Some("" | "nm" | "nanometer" | "nanometers" | "nanometre" | "nanometres") => 1.0,
        Some("um" | "µm" | "μm" | "micrometer" | "micrometers" | "micrometre" | "micrometres" | "micron") => {
            1e3
        }
        Some("m" | "meter" | "meters" | "metre" | "metres") => 1e9,
        Some(_) => {
            let found = format!("'{}'", unit.unwrap_or_default());
            return Err(IoError::field(path, format!("the unit of {name}"), found, "nm, um or m"));
        }
    };
    let nm: Vec<f64> = values.iter().map(|v| v * factor).collect();
    let inside = nm.iter().filter(|v| PLAUSIBLE_NM.contains(*v)).count();
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
    let wrong = |found: String| {
        let expected =
            "wavelengths in nm, ascending, 100 to 30000, or an attribute `units` that says otherwise";
        Err(IoError::field(path, name, found, expected))
    };
    if nm.iter().any(|v| !v.is_finite()) {
        return wrong("not finite throughout".into());
    }
    if inside > 0 && inside < nm.len() {
        return wrong(format!("{low} to {high}, which mixes units"));
    }
    if inside == 0 {
        return wrong(match values.len() {
            0 => "empty".into(),
            _ => format!("{low} to {high}"),
        });
    }
    if nm.len() < 2 || nm.is_sorted_by(|a, b| a < b) {
        return Ok(nm);
    }
    wrong(format!("{low} to {high}, not ascending"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_converted_or_refused_and_never_guessed() {
        let nm = |v: &[f64], unit| {
            converted(v.to_vec(), unit, "wave", Path::new("a.mat")).map_err(|e| e.to_string())
        };
        assert_eq!(nm(&[400.0, 700.0], None).unwrap(), [400.0, 700.0]);
        assert_eq!(nm(&[0.5, 0.75], Some("um")).unwrap(), [500.0, 750.0]);
        assert_eq!(nm(&[400.0], Some("Nanometers")).unwrap(), [400.0]);
        let error = |v: &[f64], unit| nm(v, unit).unwrap_err();
        assert!(error(&[0.4, 0.7], None).contains("wave is 0.4 to 0.7; expected wavelengths in nm"));
        assert!(error(&[4e-7, 7e-7], None).contains("0.0000004 to 0.0000007"));
        assert!(error(&[400.0, 0.5], None).contains("mixes units"));
        assert!(error(&[1.0, 2.0, 31.0], None).contains("1 to 31"));
        assert!(error(&[500.0, 400.0], None).contains("not ascending"));
        assert!(error(&[400.0, 400.0], None).contains("not ascending"));
        assert!(error(&[400.0, f64::NAN], None).contains("not finite"));
        assert!(error(&[-400.0, -300.0], None).contains("-400 to -300"));
        assert!(error(&[], None).contains("empty"));
        assert!(error(&[400.0], Some("eV")).contains("the unit of wave is 'eV'"));
    }
}
