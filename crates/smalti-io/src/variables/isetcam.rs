//! Scenes of ISETCam: the struct `scene`, photons with their wavelengths, and photons compressed to a few basis functions.

use std::path::Path;

use rayon::prelude::*;
use smalti::spectrum::units::photons_per_joule;
use smalti::spectrum::{Spectrum, WavelengthGrid};

use super::cube::{Placed, check, on_grid};
use super::{Fields, Numbers, Value, numbers_at, text_at, wavelengths};
use crate::arrays::Axes;
use crate::error::At;
use crate::file::stem;
use crate::scene_file::facts::Comment;
use crate::{IoError, Quantity, ReadOptions, SpectralFile};

/// The scene of ISETCam among the variables of a file, in the order in which `sceneFromFile` looks for it.
pub(super) fn find(
    fields: &dyn Fields,
    path: &Path,
    options: &ReadOptions,
) -> Result<Option<SpectralFile>, IoError> {
    if let Some(Value::Fields(scene)) = fields.get("scene")? {
        let facts = text_at(fields, "comment")?.and_then(|c| Comment::parse(&c));
        let mut file = scene_struct(&*scene, path, options, facts.as_ref())?;
        if let Some(facts) = facts {
            facts.state(&mut file, path)?;
        }
        return Ok(Some(file));
    }
    if let Some(coefficients) = numbers_at(fields, "mcCOEF")? {
        return compressed(fields, &coefficients, path, options).map(Some);
    }
    for name in ["photons", "data"] {
        let Some(photons) = numbers_at(fields, name)?.filter(|n| n.array.dims.len() == 3) else { continue };
        // `data` is a common name: it takes wavelengths beside it to be a cube.
        let Some((nm, _)) = wavelengths::beside(fields, path, options)?.or_else(|| given(options)) else {
            continue;
        };
        let placed = placed(photons, name, nm, path)?;
        let mut file = from_cube(&placed, fields, ["dist", "fov"], path, options)?;
        file.quantity = options.quantity.filter(|_| name == "data").unwrap_or(Quantity::Photons);
        return Ok(Some(file));
    }
    Ok(None)
}

fn given(options: &ReadOptions) -> Option<(Vec<f64>, String)> {
    options.grid.map(|g| (g.wavelengths_nm().collect(), "the given wavelengths".to_owned()))
}

/// A struct `scene`.
pub(super) fn scene_struct(
    scene: &dyn Fields,
    path: &Path,
    options: &ReadOptions,
    facts: Option<&crate::scene_file::facts::Facts>,
) -> Result<SpectralFile, IoError> {
    let missing = |field: &str| {
        IoError::field(path, format!("scene.{field}"), "absent", "the photons of a scene of ISETCam")
    };
    let photons = numbers_at(scene, "data.photons")?.ok_or_else(|| missing("data.photons"))?;
    let wave = numbers_at(scene, "spectrum.wave")?;
    let nm = match wave {
        Some(wave) => wavelengths::in_nm(&wave, "scene.spectrum.wave", path, options)?,
        None => given(options).ok_or_else(|| missing("spectrum.wave"))?.0,
    };
    let mut placed = placed(photons, "scene.data.photons", nm, path)?;
    // Before 2015 photons were packed into whole numbers (`ieCompressData`).
    let limits = [scalar(scene, "data.dmin", path, options)?, scalar(scene, "data.dmax", path, options)?];
    if let [Some(low), Some(high)] = limits {
        let bits = scalar(scene, "data.bitDepth", path, options)?
            .unwrap_or(8.0 * placed.numbers.array.element.size() as f64);
        placed.packed = Some(((high - low) / (bits.exp2() - 1.0), low));
    }
    let cube = placed.read(facts, path, options)?;
    let grid = cube.grid();
    Ok(SpectralFile {
        name: text_at(scene, "name")?.unwrap_or_else(|| stem(path)),
        quantity: Quantity::Photons,
        illuminant: illuminant(scene, grid, &placed.wavelengths_nm, path, options)?,
        distance_m: scalar(scene, "distance", path, options)?,
        horizontal_fov_deg: scalar(scene, "wAngular", path, options)?,
        cube,
    })
}

/// A cube rows × columns × bands.
fn placed(numbers: Numbers, name: &str, nm: Vec<f64>, path: &Path) -> Result<Placed, IoError> {
    if numbers.array.dim(2) != nm.len() {
        let found = numbers.shape();
        let expected = format!("rows × columns × {} wavelengths", nm.len());
        return Err(IoError::field(path, name, found, expected));
    }
    Ok(Placed { numbers, axes: Axes::MATLAB, wavelengths_nm: nm, packed: None })
}

/// A cube and what lies beside it: the illuminant, distance, field of view and name.
fn from_cube(
    placed: &Placed,
    fields: &dyn Fields,
    [distance, fov]: [&str; 2],
    path: &Path,
    options: &ReadOptions,
) -> Result<SpectralFile, IoError> {
    let cube = placed.read(None, path, options)?;
    let grid = cube.grid();
    Ok(SpectralFile {
        name: text_at(fields, "name")?.unwrap_or_else(|| stem(path)),
        cube,
        quantity: Quantity::Photons,
        illuminant: illuminant(fields, grid, &placed.wavelengths_nm, path, options)?,
        distance_m: scalar(fields, distance, path, options)?,
        horizontal_fov_deg: scalar(fields, fov, path, options)?,
    })
}

/// Photons as the mean spectrum (if any) and, for every pixel, the weights of a few basis functions.
fn compressed(
    fields: &dyn Fields,
    coefficients: &Numbers,
    path: &Path,
    options: &ReadOptions,
) -> Result<SpectralFile, IoError> {
    let absent = |field: &str| IoError::field(path, field, "absent", "the basis of mcCOEF");
    let basis = numbers_at(fields, "basis.basis")?.ok_or_else(|| absent("basis.basis"))?;
    let wave = match numbers_at(fields, "basis.wave")? {
        Some(wave) => wave,
        None => numbers_at(fields, "basis.wavelength")?.ok_or_else(|| absent("basis.wave"))?,
    };
    let nm = wavelengths::in_nm(&wave, "basis.wave", path, options)?;
    let (count, weights) = (nm.len(), coefficients.array.dim(2));
    if basis.array.dims != [count, weights] {
        let expected = format!("{count} wavelengths × {weights} coefficients");
        return Err(IoError::field(path, "basis.basis", basis.shape(), expected));
    }
    let basis = basis.list("basis.basis", path, options.limits)?;
    let mean = match numbers_at(fields, "imgMean")? {
        Some(mean) => mean.list("imgMean", path, options.limits)?,
        None => Vec::new(),
    };
    if !mean.is_empty() && mean.len() != count {
        let found = format!("{} numbers", mean.len());
        return Err(IoError::field(path, "imgMean", found, format!("{count}, one per wavelength")));
    }
    let array = &coefficients.array;
    let (rows, cols) = (array.dim(0), array.dim(1));
    // The planes that come out may be many more than the coefficients that came in.
    let bytes = [rows, cols, count].iter().fold(4u64, |n, &d| n.saturating_mul(d as u64));
    if bytes > options.limits.decoded_bytes {
        let (what, limit) = ("the photons of mcCOEF", options.limits.decoded_bytes);
        return Err(IoError::TooLarge { path: path.to_owned(), what, bytes, limit });
    }
    let coefficients: Vec<f64> = array.planes(Axes::MATLAB, path, options.limits, |_, _| Ok(()))?;
    let pixels = rows * cols;
    if pixels == 0 || weights == 0 {
        return Err(IoError::field(path, "mcCOEF", "empty", "rows × columns × coefficients"));
    }
    let mut samples = vec![0f32; pixels * count];
    samples.par_chunks_mut(pixels).enumerate().try_for_each(|(band, plane)| {
        let mut sum = vec![mean.get(band).copied().unwrap_or(0.0); pixels];
        for (k, coefficients) in coefficients.chunks_exact(pixels).enumerate() {
            let weight = basis.get(k * count + band).copied().unwrap_or(0.0);
            sum.iter_mut().zip(coefficients).for_each(|(sum, c)| *sum += weight * c);
        }
        plane.iter_mut().zip(&sum).for_each(|(v, sum)| *v = *sum as f32);
        // Few basis functions undershoot where there is little light: ISETCam takes that as darkness too.
        check(plane, nm.get(band).copied().unwrap_or_default(), cols, true, path)
    })?;
    let cube = on_grid(samples, rows, cols, &nm, None, path)?;
    let grid = cube.grid();
    Ok(SpectralFile {
        name: text_at(fields, "name")?.unwrap_or_else(|| stem(path)),
        cube,
        quantity: Quantity::Photons,
        illuminant: illuminant(fields, grid, &nm, path, options)?,
        distance_m: scalar(fields, "dist", path, options)?,
        horizontal_fov_deg: scalar(fields, "fov", path, options)?,
    })
}

/// A single number. A depth map in the place of a distance is not one.
fn scalar(
    fields: &dyn Fields,
    name: &str,
    path: &Path,
    options: &ReadOptions,
) -> Result<Option<f64>, IoError> {
    match numbers_at(fields, name)? {
        Some(numbers) if numbers.array.dims.iter().all(|&d| d == 1) => {
            Ok(numbers.list(name, path, options.limits)?.first().copied())
        }
        _ => Ok(None),
    }
}

/// The light, as photons on the grid of the cube. A struct with `type` holds photons, one without it (before 2012)
/// energy, as `illuminantModernize` has it; of a light that differs from pixel to pixel the mean is taken.
fn illuminant(
    fields: &dyn Fields,
    grid: WavelengthGrid,
    cube_nm: &[f64],
    path: &Path,
    options: &ReadOptions,
) -> Result<Option<Spectrum>, IoError> {
    let Some(Value::Fields(light)) = fields.get("illuminant")? else { return Ok(None) };
    let light = &*light;
    let (stated, bare) = match numbers_at(light, "data.photons")? {
        Some(photons) => (photons, false),
        None => match numbers_at(light, "data")? {
            Some(energy) => (energy, true),
            None => return Ok(None),
        },
    };
    let packed = [scalar(light, "data.min", path, options)?, scalar(light, "data.max", path, options)?];
    let is_energy = bare || (text_at(light, "type")?.is_none() && packed[0].is_none());
    let mut nm = cube_nm.to_vec();
    for name in ["spectrum.wave", "wavelength", "wave"] {
        if let Some(wave) = numbers_at(light, name)? {
            nm = wavelengths::in_nm(&wave, "the wavelengths of the illuminant", path, options)?;
            break;
        }
    }
    let array = &stated.array;
    let numbers = array.dims.iter().fold(1u64, |n, &d| n.saturating_mul(d as u64));
    let mut values = if numbers == nm.len() as u64 {
        stated.list("the illuminant", path, options.limits)?
    } else if array.dims.len() == 3 && array.dim(2) == nm.len() && numbers > 0 {
        let planes: Vec<f64> = array.planes(Axes::MATLAB, path, options.limits, |_, _| Ok(()))?;
        let pixels = planes.len() / nm.len();
        planes.chunks_exact(pixels).map(|p| p.iter().sum::<f64>() / pixels as f64).collect()
    } else if numbers == 0 {
        return Ok(None);
    } else {
        let expected = format!("{} numbers, one per wavelength", nm.len());
        return Err(IoError::field(path, "the illuminant", stated.shape(), expected));
    };
    if let [Some(low), Some(high)] = packed {
        let steps = (8.0 * array.element.size() as f64).exp2() - 1.0;
        values.iter_mut().for_each(|v| *v = *v * (high - low) / steps + low);
    }
    let mut photons = Vec::with_capacity(grid.len());
    for at in grid.wavelengths_nm() {
        let value = interpolated(&nm, &values, at).ok_or_else(|| {
            let (first, last) = (nm.first().copied().unwrap_or(0.0), nm.last().copied().unwrap_or(0.0));
            let expected = format!("all wavelengths of the scene, {} nm among them", at);
            IoError::field(path, "the illuminant", format!("known from {first} to {last} nm"), expected)
        })?;
        photons.push(if is_energy { value * photons_per_joule(at) } else { value });
    }
    if let Some((i, &value)) = photons.iter().enumerate().find(|(_, v)| !(v.is_finite() && **v >= 0.0)) {
        let field = format!("the illuminant at {} nm", grid.wavelength_nm(i));
        return Err(IoError::field(path, field, value.to_string(), "a finite number, not negative"));
    }
    Spectrum::new(grid, photons).at(path).map(Some)
}

/// Between neighbours, linearly; none outside.
fn interpolated(nm: &[f64], values: &[f64], at: f64) -> Option<f64> {
    // Files round wavelengths.
    const SLACK_NM: f64 = 1e-3;
    let above = nm.partition_point(|&n| n < at - SLACK_NM);
    let (&upper_nm, &upper) = (nm.get(above)?, values.get(above)?);
    if (upper_nm - at).abs() <= SLACK_NM {
        return Some(upper);
    }
    let below = above.checked_sub(1)?;
    let (&lower_nm, &lower) = (nm.get(below)?, values.get(below)?);
    Some(lower + (upper - lower) * (at - lower_nm) / (upper_nm - lower_nm))
}
