//! Reading spectral OpenEXR.

use std::collections::HashMap;
use std::io::{BufReader, Seek};
use std::path::Path;
use std::sync::Arc;

use exr::prelude::{AttributeValue, MetaData, Text};
use smalti::spectrum::WavelengthGrid;

use super::blocks;
use super::layout::{self, bands};
use crate::error::At;
use crate::file::{guarded, plausible, stem};
use crate::raster::{FileSource, Shared, Span};
use crate::scene_file::cube_file::CubeFile;
use crate::scene_file::facts::{Comment, Facts};
use crate::scene_file::stated::Bands;
use crate::scene_file::tiles::{Tiles, load};
use crate::wavelengths::uniform_grid;
use crate::{IoError, Quantity, ReadOptions, SpectralFile, UnstatedProperty};

// A file in PBRT's layout that states no wavelengths has 31 bands by convention, 400 to 700 nm.
const PBRT_GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

/// A spectral image in either layout, which the names of its channels identify.
///
/// In the layout of Fichet et al. radiance is W m⁻² sr⁻¹ nm⁻¹ unless `emissiveUnits` begins with `photons`; without
/// that attribute it is relative. In PBRT's it is relative energy, and 31 bands that state no wavelengths are
/// 400–700 nm. Of polarised files the first Stokes component is taken; where a file has radiance and reflectance,
/// radiance.
///
/// Samples are unpacked by blocks of lines or tiles.
///
/// # Errors
/// When the file cannot be read, is not OpenEXR, has no spectral channels or states no wavelengths.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Box<dyn Tiles>, IoError> {
    Ok(Box::new(opened(Arc::new(FileSource::open(path)?), path, options)?))
}

/// As [`open`] and [`load`], from memory; `path` is only named.
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    load(&opened(Arc::new(bytes), path, options)?, path, options)
}

/// Whether a file has spectral channels in either layout; only its header is looked at.
///
/// # Errors
/// When the file cannot be read or is not OpenEXR.
pub fn is_spectral(path: &Path) -> Result<bool, IoError> {
    let (meta, _) = headers(&(Arc::new(FileSource::open(path)?) as Shared<'_>), path)?;
    Ok(spectral(&meta, path)?.is_some())
}

/// All headers, and where they end.
fn headers(source: &Shared<'_>, path: &Path) -> Result<(MetaData, u64), IoError> {
    let decode = |message: String| IoError::decode(path, "OpenEXR", message);
    guarded(path, "OpenEXR", || {
        let mut reader = BufReader::new(Span::whole(source));
        let meta = MetaData::read_from_buffered(&mut reader, false).map_err(|e| decode(e.to_string()))?;
        MetaData::validate(&meta.headers, false).map_err(|e| decode(e.to_string()))?;
        let end = reader.stream_position().map_err(|e| decode(e.to_string()))?;
        Ok((meta, end))
    })
}

/// The first layer that has spectral channels, with the names of all its channels.
fn spectral(meta: &MetaData, path: &Path) -> Result<Option<(usize, Vec<String>, layout::Bands)>, IoError> {
    for (i, header) in meta.headers.iter().enumerate() {
        let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
        if let Some(bands) = bands(names.iter().map(String::as_str), path)? {
            return Ok(Some((i, names, bands)));
        }
    }
    Ok(None)
}

/// What the samples of all layers take in memory, at four bytes each.
///
/// # Errors
/// When the samples are deep or subsampled.
pub(super) fn declared_bytes(meta: &MetaData, path: &Path) -> Result<u64, IoError> {
    let mut sum = 0u64;
    for header in &meta.headers {
        if header.deep {
            return Err(IoError::field(path, "the image", "deep data", "one sample per pixel"));
        }
        if let Some(c) = header.channels.list.iter().find(|c| c.sampling.0 != 1 || c.sampling.1 != 1) {
            let field = format!("channel {}", c.name);
            return Err(IoError::field(path, field, "subsampled", "a sample for every pixel"));
        }
        let pixels = (header.layer_size.0 as u64).saturating_mul(header.layer_size.1 as u64);
        sum = sum.saturating_add(pixels.saturating_mul(header.channels.list.len() as u64).saturating_mul(4));
    }
    Ok(sum)
}

fn text(attributes: &HashMap<Text, AttributeValue>, name: &str) -> Option<String> {
    attributes.iter().find(|(key, _)| **key == *name).and_then(|(_, value)| match value {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    })
}

fn opened<'a>(source: Shared<'a>, path: &Path, options: &ReadOptions) -> Result<CubeFile<'a>, IoError> {
    let (meta, end) = headers(&source, path)?;
    let Some((layer, names, channels)) = spectral(&meta, path)? else {
        let expected = "channels Radiance.C01, Radiance.C02, … or S0.400,0nm, … or T.400,0nm, …";
        return Err(IoError::field(path, "the spectrum", "absent", expected));
    };
    plausible(path, "the image", declared_bytes(&meta, path)?, source.len())?;
    let Some(header) = meta.headers.get(layer) else {
        return Err(IoError::field(path, "the image", "absent", "a layer"));
    };
    let attributes = &header.own_attributes;
    let facts = Comment::parse(&attributes.comments.as_ref().map(Text::to_string).unwrap_or_default());
    let count = match &channels {
        layout::Bands::Numbered(order) => order.len(),
        layout::Bands::Wavelengths { bands, .. } => bands.len(),
    };
    let stated_grid = facts.as_ref().and_then(|f| WavelengthGrid::new(f.start_nm, f.step_nm, count).ok());

    let (wavelengths_nm, wanted, grid, from_layout) = match channels {
        layout::Bands::Numbered(order) => {
            let known = stated_grid.or(options.grid).or((count == PBRT_GRID.len()).then_some(PBRT_GRID));
            let grid = known.filter(|g| g.len() == count).ok_or_else(|| {
                let found = format!("not stated for {count} bands");
                let expected = "31 bands (400–700 nm)";
                IoError::field(path, "the wavelengths", found, expected)
                    .or_given(UnstatedProperty::Wavelengths)
            })?;
            (grid.wavelengths_nm().collect::<Vec<_>>(), order, grid, Quantity::RelativeEnergy)
        }
        layout::Bands::Wavelengths { bands, reflectance } => {
            let (nm, order): (Vec<f64>, Vec<usize>) = bands.into_iter().unzip();
            let same = |g: &WavelengthGrid| g.wavelengths_nm().zip(&nm).all(|(a, b)| (a - b).abs() < 1e-6);
            let grid = match stated_grid.filter(same) {
                Some(grid) => grid,
                None => uniform_grid(&nm, 2 * nm.len()).at(path)?,
            };
            let units = text(&attributes.other, "emissiveUnits");
            let quantity = match (reflectance, units) {
                (true, _) => Quantity::Reflectance,
                (false, Some(u)) if u.trim_start().starts_with("photons") => Quantity::Photons,
                (false, Some(u)) if u.trim_start().starts_with('W') => Quantity::Energy,
                (false, None) => Quantity::RelativeEnergy,
                (false, Some(u)) => {
                    return Err(IoError::field(path, "emissiveUnits", format!("'{u}'"), "W.m^-2.sr^-1"));
                }
            };
            (nm, order, grid, quantity)
        }
    };
    let (order, channels) = match blocks::plain(header) {
        Some(_) => (wanted.clone(), names),
        None => ((0..count).collect(), wanted.iter().filter_map(|i| names.get(*i).cloned()).collect()),
    };
    let quantity = facts.as_ref().and_then(Facts::quantity).unwrap_or(from_layout);
    let bands = Bands { order, wavelengths_nm, grid };
    let cube = blocks::cube(source, meta, (layer, wanted), end, (path, options.limits))?;
    let mut file = CubeFile::new((path, "OpenEXR"), vec![cube], (stem(path), bands, quantity), options);
    file.channels = channels;
    Facts::state(facts, &mut file.header, path)?;
    Ok(file)
}
