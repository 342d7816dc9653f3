//! A folder of pictures, one for each band, as the CAVE database has them.
//!
//! Yasuma, Mitsunaga, Iso and Nayar, *Generalized Assorted Pixel Camera* \[yasuma2010\]: 31 PNG of 16 bits, reflectances from 400 to
//! 700 nm.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use smalti::spectrum::WavelengthGrid;

use crate::file::stem;
use crate::picture::grey;
use crate::raster::{Cube, FileSource, Shared, Storage, Stream};
use crate::scene_file::cube_file::CubeFile;
use crate::scene_file::stated::{Bands, wavelength_in};
use crate::scene_file::tiles::{Tiles, load};
use crate::{IoError, Limits, Quantity, ReadOptions, SpectralFile};

// Pictures numbered 1 to 31 that state no wavelengths are those of CAVE.
const CAVE: WavelengthGrid = WavelengthGrid::VISIBLE;
/// Numbers that all are this large are wavelengths in nm; smaller ones count the bands.
const SMALLEST_WAVELENGTH: f64 = 200.0;

/// Whether a folder has at least two pictures that may be bands.
#[must_use]
pub fn is_folder(path: &Path) -> bool {
    folder_of_pictures(path, true).is_some()
}

/// A spectral image from the PNG of a folder, or of the only folder in it. `docs/formats-scenes.md` describes how their names state
/// wavelengths. Values are reflectances unless the options say otherwise; the largest number is 1.
///
/// Each picture is unpacked at most once if its rows are read in their order.
///
/// # Errors
/// When the folder has no bands, the wavelengths are neither stated nor given, one is missing or stated twice, or pictures are
/// malformed or of unequal size.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Box<dyn Tiles>, IoError> {
    let (folder, names) = folder_of_pictures(path, true)
        .ok_or_else(|| IoError::field(path, "the folder", "without two PNG", "a PNG for each band"))?;
    // Files are opened as they are read: there may be more of them than may be open.
    let source = move |name: &str| Ok(Arc::new(FileSource::open(&folder.join(name))?) as Shared<'static>);
    Ok(Box::new(opened(path, &names, source, options)?))
}

/// As [`open`] and [`load`], from names and contents in memory; `path` is only named.
pub fn from_files(
    files: &[(String, Vec<u8>)],
    path: &Path,
    options: &ReadOptions,
) -> Result<SpectralFile, IoError> {
    let names: Vec<String> = files.iter().map(|f| f.0.clone()).collect();
    let source = |name: &str| {
        let found = files.iter().find(|f| f.0 == name);
        Ok(Arc::new(found.map_or(&[][..], |f| f.1.as_slice())) as Shared<'_>)
    };
    load(&opened(path, &names, source, options)?, path, options)
}

/// The folder that has the pictures, and their names in order.
fn folder_of_pictures(path: &Path, descend: bool) -> Option<(PathBuf, Vec<String>)> {
    let mut folders = Vec::new();
    let mut names = Vec::new();
    for entry in std::fs::read_dir(path).ok()?.flatten() {
        let name = entry.file_name().into_string().ok()?;
        // Hidden files of the system and of other programs are not pictures of the user.
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
    // `object_ms_01`: the text before the number is the same for all bands.
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
                return Err(IoError::field(path, "a band", found, "numbers without gaps, each once"));
            }
            let (which, numbers) = members.into_iter().unzip();
            Ok((which, numbers, wavelengths))
        }
        (None, _) => {
            Err(IoError::field(path, "the order of the bands", "not stated by the file names", expected))
        }
        (Some((a, _)), Some((b, _))) => {
            let found = format!("of two series, '{a}…' and '{b}…'");
            Err(IoError::field(path, "the set of pictures", found, "one series in a folder"))
        }
    }
}

fn opened<'a>(
    path: &Path,
    names: &[String],
    source: impl Fn(&str) -> Result<Shared<'a>, IoError> + Clone + Send + Sync + 'a,
    options: &ReadOptions,
) -> Result<CubeFile<'a>, IoError> {
    let (which, numbers, wavelengths) = chosen(path, names)?;
    let bands = if wavelengths {
        Bands::sorted(path, "the names of the pictures", numbers.iter().copied().enumerate())?
    } else {
        let cave = options.grid.is_none() && numbers.len() == CAVE.len();
        let grid = if cave { Some(CAVE) } else { options.grid };
        Bands::given(path, numbers.len(), &ReadOptions { grid, ..options.clone() })?
    };
    let members: Vec<&String> = which.iter().filter_map(|i| names.get(*i)).collect();
    let mut cubes: Vec<Cube<'a>> = Vec::new();
    // All interlaced pictures are unpacked at the same time.
    let decoded_bytes = options.limits.decoded_bytes / members.len().max(1) as u64;
    let each = Limits { decoded_bytes, ..options.limits };
    for name in &members {
        let file = path.join(name.as_str());
        let raster = grey::raster(&source(name)?, &file, each)?;
        if let Some(first) = cubes.first().map(|c| c.raster)
            && (first.rows, first.cols) != (raster.rows, raster.cols)
        {
            let found = format!("{} × {}", raster.rows, raster.cols);
            let expected = format!("{} × {}, as the first band", first.rows, first.cols);
            return Err(IoError::field(&file, "the size", found, expected));
        }
        let (source, of) = (source.clone(), (*name).clone());
        let begin = move || {
            grey::rows(&source(&of).map_err(|e| match e {
                IoError::Read { source, .. } => source,
                e => io::Error::other(e.to_string()),
            })?)
        };
        let stream = Stream::new(name, raster.bytes().unwrap_or(u64::MAX), begin);
        cubes.push(Cube { source: Arc::new(stream), raster, storage: Storage::Run { offset: 0 } });
    }
    // The largest number is 1.
    let gains = cubes.iter().map(|c| (1.0 / c.raster.kind.largest().unwrap_or(1.0), 0.0)).collect();
    let quantity = options.quantity.unwrap_or(Quantity::Reflectance);
    let mut file = CubeFile::new((path, "PNG"), cubes, (stem(path), bands, quantity), options);
    file.gains = gains;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 × 1 of 16 bits; grey, or red, green and blue.
    fn png_of(samples: &[u16], interlaced: bool) -> Vec<u8> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, 1, 1);
        encoder.set_color(if samples.len() == 3 { png::ColorType::Rgb } else { png::ColorType::Grayscale });
        encoder.set_depth(png::BitDepth::Sixteen);
        let bytes: Vec<u8> = samples.iter().flat_map(|v| v.to_be_bytes()).collect();
        encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
        if interlaced {
            // Of one pixel, the first pass is all.
            out[28] = 1;
            let crc = crc32fast::hash(&out[12..29]);
            out[29..33].copy_from_slice(&crc.to_be_bytes());
        }
        out
    }

    fn read_two(first: Vec<u8>) -> Result<Vec<f32>, String> {
        let files = [("400nm.png".to_owned(), first), ("500nm.png".to_owned(), png_of(&[13107], false))];
        let file = from_files(&files, Path::new("f"), &ReadOptions::default()).map_err(|e| e.to_string())?;
        Ok(file.cube.planes().data().to_vec())
    }

    #[test]
    fn pictures_of_any_kind_are_bands_but_those_of_colour() {
        for first in [png_of(&[65535], false), png_of(&[65535], true), png_of(&[65535; 3], false)] {
            assert_eq!(read_two(first), Ok(vec![1.0, 0.2]));
        }
        let colour = read_two(png_of(&[1, 2, 2], false)).unwrap_err();
        assert_eq!(
            colour,
            "f: not a valid PNG file: 400nm.png: it is of colour; expected grey, or equal red, green and blue"
        );
        let good = png_of(&[65535], false);
        assert!(read_two(good[..20].to_vec()).unwrap_err().starts_with("f/400nm.png: not a valid PNG file"));
        for end in 34..good.len() - 12 {
            assert!(read_two(good[..end].to_vec()).is_err(), "cut at {end}");
        }
    }

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
            (&["a.png", "b.png"], "the order of the bands is not stated by the file names"),
            (&["a_1.png", "b_1.png"], "the order of the bands is not stated by the file names"),
        ] {
            let error = names(of).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
