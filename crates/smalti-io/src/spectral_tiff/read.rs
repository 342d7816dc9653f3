//! Reading spectral TIFF.

use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use crate::file::stem;
use crate::raster::{Cube, FileSource, Kind, Shared, Source};
use crate::scene_file::cube_file::CubeFile;
use crate::scene_file::facts::{Comment, Facts};
use crate::scene_file::stated::{Bands, known_quantity, wavelength_in};
use crate::scene_file::tiles::{Tiles, load};
use crate::text::utf16;
use crate::tiff::{self, Directory, Images, tags};
use crate::{IoError, Quantity, ReadOptions, SpectralFile};

/// Bands from which on a file that is not colour is a spectrum, though it does not say so: grey, RGB and either with alpha have
/// fewer.
const SURELY_SPECTRAL: usize = 5;

/// A spectral image: a band for each image of the file, for each sample of a pixel, or both. `docs/formats-scenes.md` describes what
/// states the wavelengths.
///
/// # Errors
/// When the file cannot be read, is malformed or of a kind that is not supported, or wavelengths are neither stated nor given.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Box<dyn Tiles>, IoError> {
    Ok(Box::new(opened(FileSource::open(path)?, path, options)?))
}

/// As [`open`] and [`load`], from memory; `path` is only named.
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    load(&opened(bytes, path, options)?, path, options)
}

/// Whether a TIFF file is a spectral image and no picture. It is where it states the wavelength of each of its bands, where it has
/// five bands or more, or where it is grey and as many wavelengths are given as it has bands.
///
/// # Errors
/// When the file cannot be read or its directories are malformed.
pub fn is_spectral(path: &Path, options: &ReadOptions) -> Result<bool, IoError> {
    Ok(spectral(&pages(&FileSource::open(path)?, path)?, options))
}

fn spectral(pages: &[Directory], options: &ReadOptions) -> bool {
    let samples = |d: &Directory| d.integer(tags::SAMPLES_PER_PIXEL).unwrap_or(1);
    let count = pages.iter().map(samples).fold(0, u64::saturating_add);
    let Some(first) = pages.first() else { return false };
    let stated = stated(pages, usize::try_from(count).unwrap_or(usize::MAX)).is_some();
    // 0 and 1 are grey; several colour pictures in a file are pictures still, however many.
    let grey = first.integer(tags::PHOTOMETRIC).unwrap_or(1) <= 1;
    let given = options.grid.is_some_and(|g| g.len() > 1 && g.len() as u64 == count);
    let many = if grey { count } else { samples(first) } >= SURELY_SPECTRAL as u64;
    (stated && count > 1) || many || (grey && given)
}

/// The images that are no reduced copies or masks of others.
fn pages(source: &dyn Source, path: &Path) -> Result<Vec<Directory>, IoError> {
    let mut images = Images::new(source, path, false)?.collect::<Result<Vec<_>, _>>()?;
    images.retain(|d| d.integer(tags::NEW_SUBFILE_TYPE).unwrap_or(0) & 0b101 == 0);
    Ok(images)
}

/// What the descriptions of a file say.
struct Stated {
    facts: Option<Facts>,
    /// What states the wavelengths.
    key: &'static str,
    nm: Vec<f64>,
    quantity: Option<String>,
}

/// Wavelengths of all bands, from the first of what may state them.
fn stated(pages: &[Directory], count: usize) -> Option<Stated> {
    let first = pages.first()?;
    let description = first.text(tags::IMAGE_DESCRIPTION).unwrap_or_default();
    let json: Option<Value> = serde_json::from_str(&description).ok();
    let get = |key: &str| json.as_ref().and_then(|j| j.get(key));
    let quantity = get("quantity").and_then(Value::as_str).map(str::to_owned);
    let of = |key: &'static str, nm: Vec<f64>| {
        let facts = Comment::parse(&description);
        (nm.len() == count).then_some(Stated { facts, key, nm, quantity: quantity.clone() })
    };
    for key in ["wavelengths_nm", "wavelengths", "wavelength"] {
        let numbers = get(key).and_then(Value::as_array);
        let numbers: Option<Vec<f64>> = numbers.and_then(|a| a.iter().map(Value::as_f64).collect());
        if let Some(found) = numbers.and_then(|nm| of(key, nm)) {
            return Some(found);
        }
    }
    let named = |texts: Vec<String>| texts.iter().map(|t| wavelength_in(t)).collect::<Option<Vec<f64>>>();
    for key in ["labels", "Labels"] {
        let labels = get(key).and_then(Value::as_array);
        let labels = labels.map(|a| a.iter().map(|v| v.as_str().unwrap_or("").to_owned()).collect());
        if let Some(found) = labels.and_then(named).and_then(|nm| of("labels", nm)) {
            return Some(found);
        }
    }
    if let Some(found) = imagej_labels(first).and_then(named).and_then(|nm| of("the labels of ImageJ", nm)) {
        return Some(found);
    }
    for (tag, key) in [(tags::PAGE_NAME, "PageName"), (tags::IMAGE_DESCRIPTION, "ImageDescription")] {
        let names: Vec<String> = pages.iter().map(|p| p.text(tag).unwrap_or_default()).collect();
        if let Some(found) = named(names).and_then(|nm| of(key, nm)) {
            return Some(found);
        }
    }
    None
}

/// The labels of slices in the metadata of ImageJ: a list of kinds and their counts, then the texts in UTF-16.
fn imagej_labels(page: &Directory) -> Option<Vec<String>> {
    let lengths = page.integers(tags::IMAGEJ_LENGTHS)?;
    let bytes = page.bytes(tags::IMAGEJ_METADATA)?;
    let (&head_len, lengths) = lengths.split_first()?;
    let (head, mut rest) = bytes.split_at_checked(usize::try_from(head_len).ok()?)?;
    let words: Vec<f64> = Kind::U32.numbers(page.big_endian, head);
    let mut lengths = lengths.iter();
    for pair in words.get(1..)?.chunks_exact(2) {
        let (kind, count) = (*pair.first()?, *pair.get(1)? as usize);
        let mut texts = Vec::new();
        for length in lengths.by_ref().take(count) {
            let (text, after) = rest.split_at_checked(usize::try_from(*length).ok()?)?;
            rest = after;
            texts.push(utf16(page.big_endian, text));
        }
        // The four letters `labl` as a number.
        if kind == f64::from(0x6c61_626c) {
            return Some(texts);
        }
    }
    None
}

fn opened<'a>(source: impl Source + 'a, path: &Path, options: &ReadOptions) -> Result<CubeFile<'a>, IoError> {
    let source: Shared<'a> = Arc::new(source);
    let directories = pages(&*source, path)?;
    let Some(first) = directories.first() else {
        return Err(IoError::field(path, "the image", "absent", "an image"));
    };
    refuse_hidden(first, directories.len(), path)?;
    let cubes: Vec<Cube<'a>> =
        directories.iter().map(|d| tiff::cube(d, &source, path, options.limits)).collect::<Result<_, _>>()?;
    let size = |c: &Cube<'_>| (c.raster.rows, c.raster.cols);
    let (rows, cols) = cubes.first().map_or((0, 0), size);
    if let Some((i, (high, wide))) = cubes.iter().map(size).enumerate().find(|(_, s)| *s != (rows, cols)) {
        let field = format!("the size of image {}", i + 1);
        let expected = format!("{rows} × {cols}, as the first");
        return Err(IoError::field(path, field, format!("{high} × {wide}"), expected));
    }
    let count = cubes.iter().map(|c| c.raster.bands).sum();
    let stated = stated(&directories, count);
    let bands = match &stated {
        Some(stated) => {
            let bands = Bands::sorted(path, stated.key, stated.nm.iter().copied().enumerate())?;
            Facts::regrid(stated.facts.as_ref(), bands)
        }
        None => Bands::given(path, count, options)?,
    };
    let facts = stated.as_ref().and_then(|s| s.facts.as_ref());
    let text = stated.as_ref().and_then(|s| s.quantity.as_deref());
    let (quantity, factor) = match (facts.and_then(Facts::quantity), text) {
        (Some(quantity), _) => (quantity, 1.0),
        (None, Some(text)) => known_quantity(path, text)?,
        (None, None) => (options.quantity.unwrap_or(Quantity::RelativeEnergy), 1.0),
    };
    // Whole numbers of pictures: the largest is 1.
    let full = |cube: &Cube<'_>| match quantity {
        Quantity::Reflectance => cube.raster.kind.largest().unwrap_or(1.0),
        _ => 1.0,
    };
    let gains =
        cubes.iter().flat_map(|c| std::iter::repeat_n((factor / full(c), 0.0), c.raster.bands)).collect();
    let mut file = CubeFile::new((path, "TIFF"), cubes, (stem(path), bands, quantity), options);
    file.gains = gains;
    Facts::state(stated.and_then(|s| s.facts), &mut file.header, path)?;
    Ok(file)
}

/// ImageJ leaves out the directories of large stacks: what they hold would be missing without a word.
fn refuse_hidden(first: &Directory, count: usize, path: &Path) -> Result<(), IoError> {
    let description = first.text(tags::IMAGE_DESCRIPTION).unwrap_or_default();
    let images = description.starts_with("ImageJ=").then_some(()).and_then(|()| {
        description.lines().find_map(|l| l.strip_prefix("images=")?.trim().parse::<usize>().ok())
    });
    match images {
        Some(images) if images > count => {
            let expected =
                format!("{images}, as its description states; ImageJ writes them for stacks below 4 GiB");
            Err(IoError::field(path, "the images of the stack", count.to_string(), expected))
        }
        _ => Ok(()),
    }
}
