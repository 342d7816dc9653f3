//! Reading spectral TIFF.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::Value;
use smalti::numeric::Planes;

use super::directory::{Directory, directories};
use super::page::Page;
use crate::error::At;
use crate::file::{Negative, stem};
use crate::raster::{Bad, FileSource, Part, Source, Values, zeros};
use crate::scene_file::facts::{Comment, Facts};
use crate::scene_file::stated::{Bands, quantity_in, wavelength_in};
use crate::scene_file::tiles::{Crop, Header, Tiles, bad_to_error, load, negative};
use crate::tiff_tags as tags;
use crate::{IoError, Quantity, ReadOptions, SpectralFile};

const PAGE_NAME: u16 = 285;
const IMAGEJ_LENGTHS: u16 = 50838;
const IMAGEJ_METADATA: u16 = 50839;
/// Bands from which on a file that is not colour is a spectrum, though it does not say so: grey, RGB and either with alpha have
/// fewer.
const SURELY_SPECTRAL: usize = 5;

/// A spectral image, whole or the part that the options ask for: a band for each image of the file, for each sample of a pixel, or
/// both. See `docs/formats-scenes.md` for what states the wavelengths.
///
/// # Errors
/// When the file cannot be read, is malformed or of a kind that is not read, wavelengths are neither stated nor given, a sample is
/// NaN, infinite or negative (with its band and place), or the cube is larger than the limits.
pub fn read(path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    load(&opened(FileSource::open(path)?, path, options)?, path, options)
}

/// As [`read`], samples to be read as they are needed. Of the options, the part is not looked at.
///
/// # Errors
/// As [`read`], but for the samples.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Box<dyn Tiles>, IoError> {
    Ok(Box::new(opened(FileSource::open(path)?, path, options)?))
}

/// As [`read`], from memory; `path` is only named.
///
/// # Errors
/// As [`read`].
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    load(&opened(bytes, path, options)?, path, options)
}

/// Whether a TIFF file is a spectral image and no picture. It is where it states the wavelength of each of its bands, where it has
/// five bands or more, or where it is grey and as many wavelengths are given as it has bands.
///
/// # Errors
/// When the file cannot be read or its directories are malformed.
pub fn is_spectral(path: &Path, options: &ReadOptions) -> Result<bool, IoError> {
    let source = FileSource::open(path)?;
    let pages = pages(&directories(&source, path)?);
    Ok(spectral(&pages, options))
}

fn spectral(pages: &[Directory], options: &ReadOptions) -> bool {
    let samples = |d: &Directory| d.number(tags::SAMPLES_PER_PIXEL).unwrap_or(1);
    let count = pages.iter().map(samples).fold(0, u64::saturating_add);
    let Some(first) = pages.first() else { return false };
    let stated = stated(pages, usize::try_from(count).unwrap_or(usize::MAX)).is_some();
    // 0 and 1 are grey; several colour pictures in a file are pictures still, however many.
    let grey = first.number(tags::PHOTOMETRIC).unwrap_or(1) <= 1;
    let given = options.grid.is_some_and(|g| g.len() > 1 && g.len() as u64 == count);
    let many = if grey { count } else { samples(first) } >= SURELY_SPECTRAL as u64;
    (stated && count > 1) || many || (grey && given)
}

/// The images that are no reduced copies or masks of others.
fn pages(directories: &[Directory]) -> Vec<Directory> {
    let whole = |d: &&Directory| d.number(tags::NEW_SUBFILE_TYPE).unwrap_or(0) & 0b101 == 0;
    directories.iter().filter(whole).cloned().collect()
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
    for (tag, key) in [(PAGE_NAME, "PageName"), (tags::IMAGE_DESCRIPTION, "ImageDescription")] {
        let names: Vec<String> = pages.iter().map(|p| p.text(tag).unwrap_or_default()).collect();
        if let Some(found) = named(names).and_then(|nm| of(key, nm)) {
            return Some(found);
        }
    }
    None
}

/// The labels of slices in the metadata of ImageJ: a list of kinds and their counts, then the texts in UTF-16.
fn imagej_labels(page: &Directory) -> Option<Vec<String>> {
    let lengths = page.numbers(IMAGEJ_LENGTHS)?;
    let bytes = page.bytes(IMAGEJ_METADATA)?;
    let (&head_len, lengths) = lengths.split_first()?;
    let (head, mut rest) = bytes.split_at_checked(usize::try_from(head_len).ok()?)?;
    let number = |b: &[u8; 4]| if page.big_endian { u32::from_be_bytes(*b) } else { u32::from_le_bytes(*b) };
    let words: Vec<u32> = head.as_chunks().0.iter().map(number).collect();
    let mut lengths = lengths.iter();
    for pair in words.get(1..)?.chunks_exact(2) {
        let (kind, count) = (pair.first()?, *pair.get(1)? as usize);
        let mut texts = Vec::new();
        for length in lengths.by_ref().take(count) {
            let (text, after) = rest.split_at_checked(usize::try_from(*length).ok()?)?;
            rest = after;
            let unit =
                |b: &[u8; 2]| if page.big_endian { u16::from_be_bytes(*b) } else { u16::from_le_bytes(*b) };
            let units: Vec<u16> = text.as_chunks().0.iter().map(unit).collect();
            texts.push(String::from_utf16_lossy(&units));
        }
        // The four letters `labl` as a number.
        if *kind == 0x6c61_626c {
            return Some(texts);
        }
    }
    None
}

/// A file whose samples are read as they are needed.
struct SpectralTiff<'a> {
    path: PathBuf,
    source: Box<dyn Source + 'a>,
    pages: Vec<Page>,
    /// The band of the file for each wavelength.
    order: Vec<usize>,
    /// Image and sample of each band of the file.
    places: Vec<(usize, usize)>,
    gains: Vec<(f64, f64)>,
    negative: Negative,
    header: Header,
}

fn opened<'a>(
    source: impl Source + 'a,
    path: &Path,
    options: &ReadOptions,
) -> Result<SpectralTiff<'a>, IoError> {
    let directories = pages(&directories(&source, path)?);
    let Some(first) = directories.first() else {
        return Err(IoError::field(path, "the image", "absent", "an image"));
    };
    refuse_hidden(first, directories.len(), path)?;
    let pages: Vec<Page> =
        directories.iter().map(|d| Page::new(d, &source, path, options.limits)).collect::<Result<_, _>>()?;
    let (rows, cols) = pages.first().map_or((0, 0), |p| (p.rows, p.cols));
    if let Some((i, p)) = pages.iter().enumerate().find(|(_, p)| (p.rows, p.cols) != (rows, cols)) {
        let found = format!("{} × {}", p.rows, p.cols);
        return Err(IoError::field(
            path,
            format!("the size of image {}", i + 1),
            found,
            format!("{rows} × {cols}, as the first"),
        ));
    }
    let places: Vec<(usize, usize)> =
        pages.iter().enumerate().flat_map(|(i, p)| (0..p.samples).map(move |s| (i, s))).collect();
    let stated = stated(&directories, places.len());
    let bands = match &stated {
        Some(stated) => {
            let bands = Bands::sorted(path, stated.key, stated.nm.iter().copied().enumerate())?;
            match &stated.facts {
                Some(facts) => bands.on(facts.start_nm, facts.step_nm),
                None => bands,
            }
        }
        None => Bands::given(path, places.len(), options)?,
    };
    let facts = stated.as_ref().and_then(|s| s.facts.as_ref());
    let text = stated.as_ref().and_then(|s| s.quantity.as_deref());
    let (quantity, factor) = match (facts.and_then(Facts::quantity), text) {
        (Some(quantity), _) => (quantity, 1.0),
        (None, Some(text)) => quantity_in(text).ok_or_else(|| {
            let expected = "photons, energy, relative, reflectance, or a unit such as W m^-2 sr^-1 nm^-1";
            IoError::field(path, "quantity", format!("'{text}'"), expected)
        })?,
        (None, None) => (options.quantity.unwrap_or(Quantity::RelativeEnergy), 1.0),
    };
    // Whole numbers of pictures: the largest is 1.
    let full = |page: &Page| match quantity {
        Quantity::Reflectance => page.kind.largest().unwrap_or(1.0),
        _ => 1.0,
    };
    let gains = places.iter().map(|(i, _)| (factor / pages.get(*i).map_or(1.0, full), 0.0)).collect();
    let mut header = Header {
        name: stem(path),
        rows,
        cols,
        wavelengths_nm: bands.wavelengths_nm,
        grid: bands.grid,
        quantity,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    };
    if let Some(facts) = stated.and_then(|s| s.facts) {
        facts.state_header(&mut header, path)?;
    }
    let negative = negative(options);
    let (path, source) = (path.to_owned(), Box::new(source));
    Ok(SpectralTiff { path, source, pages, order: bands.order, places, gains, negative, header })
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
                format!("{images}, as its description says; ImageJ writes them for stacks below 4 GiB");
            Err(IoError::field(path, "the images of the stack", count.to_string(), expected))
        }
        _ => Ok(()),
    }
}

/// Band of the file, sample, and what is left of its plane to read.
type Band<'a> = (usize, usize, &'a mut [f32]);

/// Rows of planes that come from the same strips or tiles.
struct Work<'a> {
    page: usize,
    rows: Range<usize>,
    /// Band of the file, and sample.
    bands: Vec<(usize, usize)>,
    planes: Vec<&'a mut [f32]>,
}

impl SpectralTiff<'_> {
    /// What is to be done, in pieces that are independent.
    fn work<'d>(&self, data: &'d mut [f32], part: Crop) -> Vec<Work<'d>> {
        let mut stacks: BTreeMap<(usize, usize), Vec<Band<'d>>> = BTreeMap::new();
        for (band, plane) in self.order.iter().zip(data.chunks_mut((part.rows * part.cols).max(1))) {
            let (page, sample) = self.places.get(*band).copied().unwrap_or_default();
            let alone = self.pages.get(page).is_some_and(|p| p.planar);
            stacks.entry((page, if alone { sample } else { 0 })).or_default().push((*band, sample, plane));
        }
        let mut all = Vec::new();
        for ((page, _), mut stack) in stacks {
            let (step, aligned) = self.pages.get(page).map_or((1, false), Page::rows_at_once);
            let (mut row, end) = (part.row, part.row + part.rows);
            while row < end {
                let last = if aligned { (row / step + 1).saturating_mul(step) } else { row + step };
                let last = last.min(end);
                let mut work = Work { page, rows: row..last, bands: Vec::new(), planes: Vec::new() };
                for (band, sample, rest) in &mut stack {
                    let len = ((last - row) * part.cols).min(rest.len());
                    let (now, later) = std::mem::take(rest).split_at_mut(len);
                    *rest = later;
                    work.bands.push((*band, *sample));
                    work.planes.push(now);
                }
                all.push(work);
                row = last;
            }
        }
        all
    }
}

impl Tiles for SpectralTiff<'_> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read(&self, part: Crop) -> Result<Planes, IoError> {
        let part = part.within(self.header.rows, self.header.cols, &self.path)?;
        let mut data = zeros(self.order.len() * part.rows * part.cols);
        let values = Values { gains: &self.gains, ignore: None, negative: self.negative };
        let cols = part.col..part.col + part.cols;
        let read = |buffer: &mut Vec<u8>, work: &mut Work<'_>| {
            let Some(page) = self.pages.get(work.page) else { return Ok(()) };
            let samples: Vec<usize> = work.bands.iter().map(|(_, sample)| *sample).collect();
            let wanted = Part { bands: &samples, rows: work.rows.clone(), cols: cols.clone() };
            page.read_into(&*self.source, &wanted, &mut work.planes, buffer)?;
            for ((band, _), plane) in work.bands.iter().zip(&mut work.planes) {
                values.check(*band, plane, (work.rows.start, part.col, part.cols)).map_err(Bad::Sample)?;
            }
            Ok(())
        };
        let mut work = self.work(&mut data, part);
        let done: Vec<Result<(), Bad>> = work.par_iter_mut().map_init(Vec::new, read).collect();
        drop(work);
        let done: Result<(), Bad> = done.into_iter().collect();
        done.map_err(|bad| bad_to_error(bad, &self.path, &self.header, &self.order))?;
        Planes::new(part.rows, part.cols, self.order.len(), data).at(&self.path)
    }
}
