//! Reading ENVI.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::header::Fields;
use crate::file::{self, stem};
use crate::raster::{Cube, FileSource, Raster, Shared, Storage};
use crate::scene_file::cube_file::CubeFile;
use crate::scene_file::facts::{Comment, Facts};
use crate::scene_file::stated::{Bands, nm_per_unit, quantity_in, scaled, wavelength_in};
use crate::scene_file::tiles::{Tiles, load};
use crate::{IoError, Quantity, ReadOptions, SpectralFile, UnstatedProperty};

/// Headers of thousands of bands take a hundred kilobytes.
const HEADER_LIMIT: u64 = 16 << 20;
/// What the file of samples is called beside `NAME.hdr`, apart from `NAME` itself.
pub(super) const DATA_EXTENSIONS: [&str; 6] = ["img", "dat", "raw", "bsq", "bil", "bip"];
/// Wavelengths of an unknown unit are taken for nm in this range alone.
const SURELY_NM: std::ops::RangeInclusive<f64> = 200.0..=20_000.0;

/// A spectral image. `path` is the header (`.hdr`) or the file of samples. `docs/formats-scenes.md` describes what is stated and what is
/// assumed otherwise.
///
/// # Errors
/// When header or samples cannot be found or read, a key is missing, contradictory or out of range, the file of samples is too
/// short, or the wavelengths are neither stated nor given.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Box<dyn Tiles>, IoError> {
    let (header, data) = files(path)?;
    let text = file::read(&header, HEADER_LIMIT)?;
    Ok(Box::new(described(&text, Arc::new(FileSource::open(&data)?), &header, options)?))
}

/// As [`open`] and [`load`], from memory; `path` is only named.
pub fn from_bytes(
    header: &[u8],
    data: &[u8],
    path: &Path,
    options: &ReadOptions,
) -> Result<SpectralFile, IoError> {
    load(&described(header, Arc::new(data), path, options)?, path, options)
}

/// The header beside a file of samples: `NAME.hdr`, or `NAME.img.hdr`.
pub(crate) fn header_beside(data: &Path) -> Option<PathBuf> {
    let mut appended = data.as_os_str().to_owned();
    appended.push(".hdr");
    [PathBuf::from(appended), data.with_extension("hdr"), data.with_extension("HDR")]
        .into_iter()
        .find(|p| p.is_file())
}

/// Header and samples of either.
fn files(path: &Path) -> Result<(PathBuf, PathBuf), IoError> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("hdr")) {
        let header = header_beside(path).ok_or_else(|| {
            let beside = path.with_extension("hdr");
            IoError::field(path, "the ENVI header", "absent", format!("a file {}", beside.display()))
        })?;
        return Ok((header, path.to_owned()));
    }
    let stem = path.with_extension("");
    let mut found: Vec<PathBuf> = Vec::new();
    let named = |extension: String| {
        let mut name = stem.as_os_str().to_owned();
        name.push(".");
        name.push(extension);
        PathBuf::from(name)
    };
    let upper = DATA_EXTENSIONS.iter().map(|e| e.to_uppercase());
    let others = DATA_EXTENSIONS.iter().map(|e| (*e).to_owned()).chain(upper).map(named);
    for candidate in std::iter::once(stem.clone()).chain(others) {
        // Where names know no capitals, one file answers to two.
        let again = |f: &PathBuf| f.as_os_str().eq_ignore_ascii_case(candidate.as_os_str());
        if candidate.is_file() && !found.iter().any(again) {
            found.push(candidate);
        }
    }
    match found.as_slice() {
        [data] => Ok((path.to_owned(), data.clone())),
        [] => {
            let expected =
                format!("a file {} or one that ends in .img, .dat, .raw, .bsq, .bil or .bip", stem.display());
            Err(IoError::field(path, "the file of samples", "absent", expected))
        }
        several => {
            let names: Vec<String> = several.iter().map(|p| p.display().to_string()).collect();
            let expected = "one (give its name instead of the header's)";
            Err(IoError::field(path, "the file of samples", names.join(" and "), expected))
        }
    }
}

fn described<'a>(
    text: &[u8],
    source: Shared<'a>,
    path: &Path,
    options: &ReadOptions,
) -> Result<CubeFile<'a>, IoError> {
    let fields = Fields::parse(text, path)?;
    if let Some(kind) = fields.text("file type").filter(|t| !t.to_lowercase().starts_with("envi standard")) {
        return Err(IoError::field(path, "file type", format!("'{kind}'"), "ENVI Standard: an image"));
    }
    if fields.whole_number("file compression")?.unwrap_or(0) != 0 {
        return Err(fields.error("file compression", "0: samples as they are"));
    }
    let (rows, cols, count) = (fields.length("lines")?, fields.length("samples")?, fields.length("bands")?);
    let kind = fields.kind()?;
    let raster = Raster {
        kind,
        big_endian: fields.big_endian(kind)?,
        bands: count,
        rows,
        cols,
        order: fields.order()?,
    };
    let offset = fields.whole_number("header offset")?.unwrap_or(0);
    let cube = Cube { source, raster, storage: Storage::Run { offset } };
    // Before anything is made for each band.
    cube.check(path, "the samples", options.limits)?;
    let facts = fields.raw("smalti").and_then(|json| Comment::parse(&format!("{{\"smalti\":{json}}}")));
    let bands = bands(&fields, count, facts.as_ref(), path, options)?;
    let (quantity, factor) = quantity(&fields, facts.as_ref(), options)?;
    let mut file = CubeFile::new((path, "ENVI"), vec![cube], (stem(path), bands, quantity), options);
    Facts::state(facts, &mut file.header, path)?;
    let gains = fields.numbers("data gain values", count)?;
    let offsets = fields.numbers("data offset values", count)?;
    let of = |list: &Option<Vec<f64>>, i: usize, default| {
        list.as_ref().and_then(|l| l.get(i)).copied().unwrap_or(default)
    };
    if gains.is_some() || offsets.is_some() || factor != 1.0 {
        file.gains =
            (0..count).map(|i| (of(&gains, i, 1.0) * factor, of(&offsets, i, 0.0) * factor)).collect();
    }
    file.ignore = fields.number("data ignore value")?.map(|v| v as f32);
    Ok(file)
}

/// The bands that are good, by their wavelengths.
fn bands(
    fields: &Fields<'_>,
    count: usize,
    facts: Option<&Facts>,
    path: &Path,
    options: &ReadOptions,
) -> Result<Bands, IoError> {
    let good = |i: &usize, bad: &Option<Vec<f64>>| bad.as_ref().is_none_or(|b| b.get(*i) != Some(&0.0));
    let bad = fields.numbers("bbl", count)?;
    let with_unit = |key: &str, nm: Vec<f64>| {
        Bands::sorted(path, key, nm.into_iter().enumerate().filter(|(i, _)| good(i, &bad)))
    };
    if let Some(values) = fields.numbers("wavelength", count)? {
        let unit = fields.text("wavelength units").unwrap_or("Unknown");
        let scale = match nm_per_unit(unit) {
            Some(scale) => scale,
            None if unit.eq_ignore_ascii_case("unknown") => {
                if let Some(v) = values.iter().find(|v| !SURELY_NM.contains(v)) {
                    let found = format!("of an unknown unit and includes {v}");
                    let expected =
                        "'wavelength units' of Nanometers or Micrometers, or values of 200 to 20000 (nm)";
                    return Err(IoError::field(path, "wavelength", found, expected));
                }
                1.0
            }
            None => return Err(fields.error("wavelength units", "Nanometers, Micrometers or Unknown")),
        };
        let nm = values.into_iter().map(|v| scaled(v, scale)).collect();
        return Ok(Facts::regrid(facts, with_unit("wavelength", nm)?));
    }
    let names = fields.list("band names", count).ok().flatten();
    let named: Option<Vec<f64>> = names.and_then(|n| n.into_iter().map(wavelength_in).collect());
    match named {
        Some(nm) => with_unit("band names", nm),
        None => {
            let bands = Bands::given(path, count, options)?;
            match bad {
                Some(_) => with_unit("the wavelengths given", bands.wavelengths_nm),
                None => Ok(bands),
            }
        }
    }
}

/// What the values are, and the factor that brings them to its unit.
fn quantity(
    fields: &Fields<'_>,
    facts: Option<&Facts>,
    options: &ReadOptions,
) -> Result<(Quantity, f64), IoError> {
    if let Some(quantity) = facts.and_then(Facts::quantity) {
        return Ok((quantity, 1.0));
    }
    if let Some(factor) = fields.number("reflectance scale factor")? {
        if !(factor.is_finite() && factor > 0.0) {
            return Err(fields.error("reflectance scale factor", "a number above 0"));
        }
        return Ok((Quantity::Reflectance, 1.0 / factor));
    }
    let unit = ["data units", "units"].into_iter().find_map(|key| Some((key, fields.text(key)?)));
    match unit {
        Some((key, text)) => match (quantity_in(text), options.quantity) {
            (Some(known), _) => Ok(known),
            (None, Some(quantity)) => Ok((quantity, 1.0)),
            (None, None) => {
                let expected = "reflectance, a unit of spectral radiance such as W m^-2 sr^-1 nm^-1";
                Err(fields.error(key, expected).or_given(UnstatedProperty::Quantity))
            }
        },
        None => Ok((options.quantity.unwrap_or(Quantity::RelativeEnergy), 1.0)),
    }
}
