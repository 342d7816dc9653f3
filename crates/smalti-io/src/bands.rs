//! A folder of pictures, one for each band, as the CAVE database has them.
//!
//! Yasuma, Mitsunaga, Iso and Nayar, *Generalized Assorted Pixel Camera* \[yasuma2010\]: 31 PNG of 16 bits, reflectances from 400 to
//! 700 nm.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use smalti::numeric::Planes;
use smalti::spectrum::{SpectralCube, WavelengthGrid};

use crate::error::At;
use crate::file;
use crate::picture::png::{Samples, eight, sixteen, unpack};
use crate::raster::zeros;
use crate::scene_file::stated::{Bands, wavelength_in};
use crate::scene_file::tiles::{Crop, cropped, resampled};
use crate::wavelengths::places;
use crate::{IoError, Quantity, ReadOptions, SpectralFile};

// Pictures numbered 1 to 31 that state no wavelengths are those of CAVE.
const CAVE: WavelengthGrid = WavelengthGrid::VISIBLE;
/// Numbers that all are this large are wavelengths in nm; smaller ones count the bands.
const SMALLEST_WAVELENGTH: f64 = 200.0;

/// Whether a folder has at least two pictures that may be bands.
#[must_use]
pub fn is_folder(path: &Path) -> bool {
    folder_of_pictures(path, true).is_some()
}

/// A spectral image from the PNG of a folder, or of the only folder in it. See `docs/formats-scenes.md` for how their names state
/// wavelengths. Values are reflectances unless the options say otherwise; the largest number is 1.
///
/// # Errors
/// When the folder has no bands, the wavelengths are neither stated nor given, one is missing or stated twice, pictures are
/// malformed, of colour or of unequal size, or the cube is larger than the limits.
pub fn read(path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    let (folder, names) = folder_of_pictures(path, true)
        .ok_or_else(|| IoError::field(path, "the folder", "without two PNG", "a PNG for each band"))?;
    let load = |name: &str| file::read(&folder.join(name), options.limits.file_bytes);
    assembled(path, &names, load, options)
}

/// As [`read`], from names and contents in memory; `path` is only named.
///
/// # Errors
/// As [`read`].
pub fn from_files(
    files: &[(String, Vec<u8>)],
    path: &Path,
    options: &ReadOptions,
) -> Result<SpectralFile, IoError> {
    let names: Vec<String> = files.iter().map(|f| f.0.clone()).collect();
    let load = |name: &str| {
        let found = files.iter().find(|f| f.0 == name);
        Ok(found.map(|f| f.1.clone()).unwrap_or_default())
    };
    assembled(path, &names, load, options)
}

/// The folder that has the pictures, and their names in order.
fn folder_of_pictures(path: &Path, descend: bool) -> Option<(PathBuf, Vec<String>)> {
    let mut folders = Vec::new();
    let mut names = Vec::new();
    for entry in std::fs::read_dir(path).ok()?.flatten() {
        let name = entry.file_name().into_string().ok()?;
        // What systems and other programs hide there is none of the user's.
        if name.starts_with('.') || name.starts_with("__") {
            continue;
        }
        if entry.path().is_dir() {
            folders.push(entry.path());
        } else if Path::new(&name).extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            names.push(name);
        }
    }
    match (names.len(), folders.as_slice()) {
        // CAVE's archives have the folder in a folder of the same name.
        (0, [only]) if descend => folder_of_pictures(only, false),
        (0 | 1, _) => None,
        _ => {
            names.sort_unstable();
            Some((path.to_owned(), names))
        }
    }
}

/// The bands among names of files, each with its number or wavelength.
fn chosen(path: &Path, names: &[String]) -> Result<(Vec<usize>, Vec<f64>, bool), IoError> {
    let stem = |name: &str| name.rsplit_once('.').map_or(name, |s| s.0).to_owned();
    let stems: Vec<String> = names.iter().map(|n| stem(n)).collect();
    let with_unit: Vec<(usize, f64)> =
        stems.iter().enumerate().filter_map(|(i, s)| Some((i, wavelength_in(s)?))).collect();
    if with_unit.len() > 1 {
        let (which, nm) = with_unit.into_iter().unzip();
        return Ok((which, nm, true));
    }
    // `object_ms_01`: what stands before the number is the same for all bands.
    let mut groups: BTreeMap<&str, Vec<(usize, f64)>> = BTreeMap::new();
    for (i, s) in stems.iter().enumerate() {
        let digits = s.len() - s.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (before, number) = s.split_at(s.len() - digits);
        if let Ok(number) = number.parse() {
            groups.entry(before).or_default().push((i, number));
        }
    }
    groups.retain(|_, members| members.len() > 1);
    let expected =
        "names that end in the number of the band (scene_01.png) or have its wavelength (scene_450nm.png)";
    let mut groups = groups.into_iter();
    match (groups.next(), groups.next()) {
        (Some((_, mut members)), None) => {
            members.sort_by(|a, b| a.1.total_cmp(&b.1));
            let wavelengths = members.iter().all(|m| m.1 >= SMALLEST_WAVELENGTH);
            let first = members.first().map_or(0.0, |m| m.1);
            let gap = members.iter().enumerate().find(|(i, m)| m.1 != first + *i as f64);
            if let (false, Some((i, m))) = (wavelengths, gap) {
                let found = format!("number {} after {}", m.1, first + i as f64 - 1.0);
                return Err(IoError::field(path, "the bands", found, "numbers without gaps, each once"));
            }
            let (which, numbers) = members.into_iter().unzip();
            Ok((which, numbers, wavelengths))
        }
        (None, _) => {
            Err(IoError::field(path, "the bands", "not told by the names of the pictures", expected))
        }
        (Some((a, _)), Some((b, _))) => {
            let found = format!("of two series, '{a}…' and '{b}…'");
            Err(IoError::field(path, "the bands", found, "one series in a folder"))
        }
    }
}

fn assembled(
    path: &Path,
    names: &[String],
    load: impl Fn(&str) -> Result<Vec<u8>, IoError> + Sync,
    options: &ReadOptions,
) -> Result<SpectralFile, IoError> {
    let (which, numbers, wavelengths) = chosen(path, names)?;
    let bands = if wavelengths {
        Bands::sorted(path, "the names of the pictures", numbers.iter().copied().enumerate())?
    } else {
        let cave = options.grid.is_none() && numbers.len() == CAVE.len();
        let grid = if cave { Some(CAVE) } else { options.grid };
        Bands::given(path, numbers.len(), &ReadOptions { grid, ..options.clone() })?
    };
    let ordered: Vec<&str> =
        bands.order.iter().filter_map(|i| names.get(*which.get(*i)?)).map(String::as_str).collect();
    let quantity = options.quantity.unwrap_or(Quantity::Reflectance);
    let allowed = options.limits.decoded_bytes / (ordered.len().max(1) as u64);
    let decoded: Vec<Result<Planes, IoError>> = ordered
        .par_iter()
        .map(|name| {
            let path = path.join(name);
            let plane = decode(&load(name)?, &path, allowed, options)?;
            let whole = Crop::whole(plane.rows(), plane.cols());
            let part = options.crop.unwrap_or(whole).within(plane.rows(), plane.cols(), &path)?;
            if part == whole { Ok(plane) } else { cropped(&plane, part, &path) }
        })
        .collect();
    let mut size = None;
    let mut data = Vec::new();
    let mut filled = 0;
    for (plane, name) in decoded.into_iter().zip(&ordered) {
        let plane = plane?;
        let (rows, cols) = *size.get_or_insert((plane.rows(), plane.cols()));
        if (plane.rows(), plane.cols()) != (rows, cols) {
            let found = format!("{} × {}", plane.rows(), plane.cols());
            return Err(IoError::field(
                &path.join(name),
                "the size",
                found,
                format!("{rows} × {cols}, as the first band"),
            ));
        }
        if data.is_empty() {
            data = zeros(plane.data().len() * ordered.len());
        }
        let rest = data.get_mut(filled..).unwrap_or_default();
        rest.iter_mut().zip(plane.data()).for_each(|(to, v)| *to = *v);
        filled += plane.data().len();
    }
    let (rows, cols) = size.unwrap_or((0, 0));
    let planes = Planes::new(rows, cols, ordered.len(), data).at(path)?;
    let places = places(&bands.wavelengths_nm, bands.grid);
    let uniform =
        bands.grid.wavelengths_nm().len() == ordered.len() && places.iter().all(|p| p.weight == 0.0);
    let planes = if uniform { planes } else { resampled(&planes, &places, path)? };
    Ok(SpectralFile {
        name: file::stem(path),
        cube: SpectralCube::new(bands.grid, planes).at(path)?,
        quantity,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    })
}

/// A grey picture; the largest number is 1. One of colour is taken where its channels are equal.
fn decode(bytes: &[u8], path: &Path, allowed: u64, options: &ReadOptions) -> Result<Planes, IoError> {
    let picture = unpack(bytes, path, options, ("a band", 4, allowed))?;
    let (channels, (rows, cols)) = (picture.channels, picture.size);
    let compared = if channels > 2 { 3 } else { 1 };
    let data: Option<Vec<f32>> = match &picture.samples {
        Samples::Sixteen(buffer) if channels == 1 => Some(buffer.as_chunks().0.iter().map(sixteen).collect()),
        Samples::Sixteen(buffer) => grey(buffer, 2 * channels, 2, compared)
            .map(|firsts| firsts.filter_map(|b| b.first_chunk().map(sixteen)).collect()),
        Samples::Eight(buffer) => grey(buffer, channels, 1, compared)
            .map(|firsts| firsts.filter_map(|b| b.first().map(eight)).collect()),
    };
    let data = data.ok_or_else(|| {
        IoError::field(path, "the colour type", "colour", "grey, or equal red, green and blue")
    })?;
    Planes::new(rows, cols, 1, data).at(path)
}

/// The first sample of each pixel, where the samples of its colours are equal.
fn grey(buffer: &[u8], pixel: usize, sample: usize, compared: usize) -> Option<impl Iterator<Item = &[u8]>> {
    let equal = |p: &[u8]| {
        let mut samples = p.chunks_exact(sample).take(compared);
        let first = samples.next();
        samples.all(|s| Some(s) == first)
    };
    buffer.chunks_exact(pixel).all(equal).then(|| buffer.chunks_exact(pixel))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(of: &[&str]) -> Result<(Vec<usize>, Vec<f64>, bool), String> {
        let names: Vec<String> = of.iter().map(|n| (*n).to_owned()).collect();
        chosen(Path::new("f"), &names).map_err(|e| e.to_string())
    }

    #[test]
    fn names_tell_the_bands() {
        assert_eq!(names(&["a_ms_02.png", "a_ms_01.png", "x.png"]), Ok((vec![1, 0], vec![1.0, 2.0], false)));
        assert_eq!(
            names(&["s_450nm.png", "s_400nm.png", "rgb.png"]),
            Ok((vec![0, 1], vec![450.0, 400.0], true))
        );
        assert_eq!(names(&["400.png", "420.png"]), Ok((vec![0, 1], vec![400.0, 420.0], true)));
        for (of, expected) in [
            (&["a_1.png", "a_3.png"][..], "number 3 after 1; expected numbers without gaps"),
            (&["a_1.png", "a_01.png"], "number 1 after 1"),
            (&["a_1.png", "a_2.png", "b_1.png", "b_2.png"], "of two series, 'a_…' and 'b_…'"),
            (&["a.png", "b.png"], "not told by the names"),
            (&["a_1.png", "b_1.png"], "not told by the names"),
        ] {
            let error = names(of).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
