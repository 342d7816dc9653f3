//! Reading spectral OpenEXR.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannels, AttributeValue, FlatSamples, Layer, MetaData, ReadChannels, ReadLayers, Text,
};
use smalti::numeric::Planes;
use smalti::spectrum::{SpectralCube, WavelengthGrid};

use super::layout::{Bands, bands};
use crate::error::At;
use crate::file::{Negative, guarded, sample, stem};
use crate::scene_file::facts::Comment;
use crate::wavelengths::{Between, places, uniform_grid};
use crate::{IoError, Limits, file};
use crate::{Quantity, ReadOptions, SpectralFile};

// A file in PBRT's layout that states no wavelengths has 31 bands by convention, 400 to 700 nm.
const PBRT_GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

/// A spectral image in either layout, told apart by the names of its channels.
///
/// In the layout of Fichet et al. radiance is W m⁻² sr⁻¹ nm⁻¹ unless `emissiveUnits` begins with `photons`; without
/// that attribute it is relative. In PBRT's it is relative energy, and 31 bands that state no wavelengths are
/// 400–700 nm. Of polarised files the first Stokes component is taken; where a file has radiance and reflectance,
/// radiance.
///
/// # Errors
/// When the file cannot be read, is not OpenEXR, has no spectral channels, states no wavelengths, has a NaN,
/// infinite or negative value (with its band and pixel), or is larger than the limits.
pub fn read(path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    from_bytes(&file::read(path, options.limits.file_bytes)?, path, options)
}

/// As [`read`], from memory; `path` is only named.
///
/// # Errors
/// As [`read`].
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    for layer in load(bytes, path, options.limits)? {
        let names: Vec<String> = layer.channel_data.list.iter().map(|c| c.name.to_string()).collect();
        if let Some(bands) = bands(names.iter().map(String::as_str), path)? {
            return spectral(&layer, &names, bands, path, options);
        }
    }
    let expected = "channels Radiance.C01, Radiance.C02, … or S0.400,0nm, … or T.400,0nm, …";
    Err(IoError::field(path, "the spectrum", "absent", expected))
}

/// Whether a file has spectral channels in either layout; only its header is looked at.
///
/// # Errors
/// When the file cannot be read or is not OpenEXR.
pub fn is_spectral(path: &Path, options: &ReadOptions) -> Result<bool, IoError> {
    let bytes = file::read(path, options.limits.file_bytes)?;
    let meta = guarded(path, "OpenEXR", || {
        MetaData::read_from_buffered(Cursor::new(&bytes), false).map_err(|e| IoError::Decode {
            path: path.to_owned(),
            format: "OpenEXR",
            message: e.to_string(),
        })
    })?;
    for header in &meta.headers {
        let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
        if bands(names.iter().map(String::as_str), path)?.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// All layers, flat, at full resolution, after the header was compared with the length of the file.
pub(super) fn load(
    bytes: &[u8],
    path: &Path,
    limits: Limits,
) -> Result<Vec<Layer<AnyChannels<FlatSamples>>>, IoError> {
    let decode = |e: exr::error::Error| IoError::Decode {
        path: path.to_owned(),
        format: "OpenEXR",
        message: e.to_string(),
    };
    guarded(path, "OpenEXR", || {
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(decode)?;
        let mut declared = 0u64;
        for header in &meta.headers {
            if header.deep {
                return Err(IoError::field(path, "the image", "deep data", "one sample per pixel"));
            }
            if let Some(c) = header.channels.list.iter().find(|c| c.sampling.0 != 1 || c.sampling.1 != 1) {
                let field = format!("channel {}", c.name);
                return Err(IoError::field(path, field, "subsampled", "a sample for every pixel"));
            }
            let pixels = (header.layer_size.0 as u64).saturating_mul(header.layer_size.1 as u64);
            // In memory the samples of a pixel take at most four bytes each and are held once more as f32.
            let channels = header.channels.list.len() as u64;
            declared = declared.saturating_add(pixels.saturating_mul(channels).saturating_mul(4));
        }
        limits.check(path, "the image", declared, bytes.len() as u64)?;
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(decode)?;
        Ok(image.layer_data.into_vec())
    })
}

fn text(attributes: &HashMap<Text, AttributeValue>, name: &str) -> Option<String> {
    attributes.iter().find(|(key, _)| **key == *name).and_then(|(_, value)| match value {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    })
}

fn spectral(
    layer: &Layer<AnyChannels<FlatSamples>>,
    names: &[String],
    bands: Bands,
    path: &Path,
    options: &ReadOptions,
) -> Result<SpectralFile, IoError> {
    let comment = layer.attributes.comments.as_ref().map(Text::to_string).unwrap_or_default();
    let facts = Comment::parse(&comment);
    let stated_grid =
        facts.as_ref().and_then(|f| WavelengthGrid::new(f.start_nm, f.step_nm, band_count(&bands)).ok());

    let (wavelengths_nm, order, grid, from_layout) = match bands {
        Bands::Numbered(order) => {
            let known =
                stated_grid.or(options.grid).or((order.len() == PBRT_GRID.len()).then_some(PBRT_GRID));
            let grid = known.filter(|g| g.len() == order.len()).ok_or_else(|| {
                let found = format!("not stated for {} bands", order.len());
                IoError::field(
                    path,
                    "the wavelengths",
                    found,
                    "31 bands (400–700 nm), or a grid given by hand",
                )
            })?;
            (grid.wavelengths_nm().collect::<Vec<_>>(), order, grid, Quantity::RelativeEnergy)
        }
        Bands::Wavelengths { bands, reflectance } => {
            let (nm, order): (Vec<f64>, Vec<usize>) = bands.into_iter().unzip();
            let same = |g: &WavelengthGrid| g.wavelengths_nm().zip(&nm).all(|(a, b)| (a - b).abs() < 1e-6);
            let grid = match stated_grid.filter(same) {
                Some(grid) => grid,
                None => uniform_grid(&nm, 2 * nm.len()).at(path)?,
            };
            let units = text(&layer.attributes.other, "emissiveUnits");
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

    let (cols, rows) = (layer.size.0, layer.size.1);
    let negative = if options.clamp_negative { Negative::Clamp } else { Negative::Refuse };
    let mut planes: Vec<Vec<f32>> = Vec::with_capacity(order.len());
    for &channel in &order {
        let (Some(c), Some(name)) = (layer.channel_data.list.get(channel), names.get(channel)) else {
            continue;
        };
        planes.push(checked(&c.sample_data, name, cols, path, negative)?);
    }
    let data = resampled(planes, &places(&wavelengths_nm, grid));
    let planes = Planes::new(rows, cols, grid.len(), data).at(path)?;
    let cube = SpectralCube::new(grid, planes).at(path)?;

    let mut file = SpectralFile {
        name: stem(path),
        cube,
        quantity: from_layout,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    };
    if let Some(facts) = facts {
        facts.state(&mut file, path)?;
    }
    Ok(file)
}

fn band_count(bands: &Bands) -> usize {
    match bands {
        Bands::Numbered(order) => order.len(),
        Bands::Wavelengths { bands, .. } => bands.len(),
    }
}

/// The samples of a channel as f32; an error names the first that is not what `negative` allows.
pub(super) fn checked(
    samples: &FlatSamples,
    channel: &str,
    cols: usize,
    path: &Path,
    negative: Negative,
) -> Result<Vec<f32>, IoError> {
    let check = |(i, v): (usize, f32)| {
        sample(v, negative).map_err(|expected| IoError::Pixel {
            path: path.to_owned(),
            channel: channel.to_owned(),
            row: i / cols.max(1),
            col: i % cols.max(1),
            value: f64::from(v),
            expected,
        })
    };
    match samples {
        FlatSamples::F16(v) => v.iter().map(|x| x.to_f32()).enumerate().map(check).collect(),
        FlatSamples::F32(v) => v.iter().copied().enumerate().map(check).collect(),
        FlatSamples::U32(v) => v.iter().map(|&x| x as f32).enumerate().map(check).collect(),
    }
}

/// The planes of the grid, one after another.
fn resampled(planes: Vec<Vec<f32>>, places: &[Between]) -> Vec<f32> {
    let mut data = Vec::with_capacity(places.len() * planes.first().map_or(0, Vec::len));
    for place in places {
        let Some(below) = planes.get(place.index) else { continue };
        match planes.get(place.index + 1) {
            Some(above) if place.weight > 0.0 => {
                let t = place.weight as f32;
                data.extend(below.iter().zip(above).map(|(a, b)| a * (1.0 - t) + b * t));
            }
            _ => data.extend_from_slice(below),
        }
    }
    data
}
