//! Scenes of ISETCam: the struct `scene`, photons with their wavelengths, and photons compressed to a few basis functions.

use std::path::Path;

use smalti::spectrum::Spectrum;
use smalti::spectrum::units::photons_per_joule;

use super::array::doubles;
use super::coefficients::Combined;
use super::{Axes, Fields, Numbers, Reading, Value, bands, numbers_at, placed, text_at, wavelengths};
use crate::error::At;
use crate::file::stem;
use crate::raster::Storage;
use crate::scene_file::facts::{Comment, Facts};
use crate::scene_file::tiles::{Header, Tiles};
use crate::{IoError, Quantity};

/// The scene of ISETCam among the variables of a file, in the order in which `sceneFromFile` looks for it.
pub(super) fn find(fields: &dyn Fields, of: Reading<'_>) -> Result<Option<Box<dyn Tiles>>, IoError> {
    if let Some(Value::Fields(scene)) = fields.get("scene")? {
        let facts = text_at(fields, "comment")?.and_then(|c| Comment::parse(&c));
        return scene_struct(&*scene, of, facts).map(Some);
    }
    if let Some(coefficients) = numbers_at(fields, "mcCOEF")? {
        return compressed(fields, &coefficients, of).map(Some);
    }
    for name in ["photons", "data"] {
        let Some(photons) = numbers_at(fields, name)?.filter(|n| n.array.dims.len() == 3) else { continue };
        // `data` is a common name: it takes wavelengths beside it to be a cube.
        let stated = wavelengths::beside(fields, of)?.or_else(|| wavelengths::given(of));
        let Some((nm, _)) = stated else { continue };
        let quantity = of.options.quantity.filter(|_| name == "data").unwrap_or(Quantity::Photons);
        refuse_other_axes(&photons, name, nm.len(), of.path)?;
        let called = (stem(of.path), quantity);
        let mut file = placed(&photons.array, Axes::MATLAB, called, &nm, None, of)?;
        state(&mut file.header, fields, ["dist", "fov"], of)?;
        return Ok(Some(Box::new(file)));
    }
    Ok(None)
}

/// A struct `scene`.
pub(super) fn scene_struct(
    scene: &dyn Fields,
    of: Reading<'_>,
    facts: Option<Facts>,
) -> Result<Box<dyn Tiles>, IoError> {
    let missing = |field: &str| {
        IoError::field(of.path, format!("scene.{field}"), "absent", "the photons of a scene of ISETCam")
    };
    let photons = numbers_at(scene, "data.photons")?.ok_or_else(|| missing("data.photons"))?;
    let wave = numbers_at(scene, "spectrum.wave")?;
    let nm = match wave {
        Some(wave) => wavelengths::in_nm(&wave, "scene.spectrum.wave", of)?,
        None => wavelengths::given(of).ok_or_else(|| missing("spectrum.wave"))?.0,
    };
    refuse_other_axes(&photons, "scene.data.photons", nm.len(), of.path)?;
    let quantity = facts.as_ref().and_then(Facts::quantity).unwrap_or(Quantity::Photons);
    let called = (stem(of.path), quantity);
    let mut file = placed(&photons.array, Axes::MATLAB, called, &nm, facts.as_ref(), of)?;
    // Before 2015 photons were packed into whole numbers (`ieCompressData`).
    let limits = [scalar(scene, "data.dmin", of)?, scalar(scene, "data.dmax", of)?];
    if let [Some(low), Some(high)] = limits {
        let bits = scalar(scene, "data.bitDepth", of)?.unwrap_or(8.0 * photons.array.kind.size() as f64);
        file.gains = vec![((high - low) / (bits.exp2() - 1.0), low); nm.len()];
    }
    state(&mut file.header, scene, ["distance", "wAngular"], of)?;
    Facts::state(facts, &mut file.header, of.path)?;
    Ok(Box::new(file))
}

/// A cube is rows × columns × bands.
fn refuse_other_axes(numbers: &Numbers, name: &str, count: usize, path: &Path) -> Result<(), IoError> {
    if numbers.array.dim(2) == count && numbers.array.count() > 0 {
        return Ok(());
    }
    let expected = format!("rows × columns × {count} wavelengths");
    Err(IoError::field(path, name, numbers.shape(), expected))
}

/// Takes the name, the illuminant, the distance and the field of view beside a cube.
fn state(
    header: &mut Header,
    fields: &dyn Fields,
    [distance, fov]: [&str; 2],
    of: Reading<'_>,
) -> Result<(), IoError> {
    if let Some(name) = text_at(fields, "name")? {
        header.name = name;
    }
    header.illuminant = illuminant(fields, header, of)?;
    header.distance_m = scalar(fields, distance, of)?;
    header.horizontal_fov_deg = scalar(fields, fov, of)?;
    Ok(())
}

/// Photons as the mean spectrum (if any) and, for every pixel, the weights of a few basis functions.
fn compressed(
    fields: &dyn Fields,
    coefficients: &Numbers,
    of @ Reading { path, options }: Reading<'_>,
) -> Result<Box<dyn Tiles>, IoError> {
    let absent = |field: &str| IoError::field(path, field, "absent", "the basis of mcCOEF");
    let basis = numbers_at(fields, "basis.basis")?.ok_or_else(|| absent("basis.basis"))?;
    let wave = match numbers_at(fields, "basis.wave")? {
        Some(wave) => wave,
        None => numbers_at(fields, "basis.wavelength")?.ok_or_else(|| absent("basis.wave"))?,
    };
    let nm = wavelengths::in_nm(&wave, "basis.wave", of)?;
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
    if coefficients.array.count() == 0 {
        return Err(IoError::field(path, "mcCOEF", "empty", "rows × columns × coefficients"));
    }
    let cube = coefficients.array.cube(Axes::MATLAB, path, options.limits)?;
    let size = (cube.raster.rows, cube.raster.cols);
    let mut header = Header::plain(stem(path), size, bands(&nm, None, path)?, Quantity::Photons);
    state(&mut header, fields, ["dist", "fov"], of)?;
    let (path, limits) = (path.to_owned(), options.limits);
    Ok(Box::new(Combined { path, coefficients: cube, basis, mean, header, limits }))
}

/// A single number. A depth map in the place of a distance is not one.
fn scalar(fields: &dyn Fields, name: &str, of: Reading<'_>) -> Result<Option<f64>, IoError> {
    match numbers_at(fields, name)? {
        Some(numbers) if numbers.array.dims.iter().all(|&d| d == 1) => {
            Ok(numbers.list(name, of.path, of.options.limits)?.first().copied())
        }
        _ => Ok(None),
    }
}

/// The light, as photons on the grid of the cube. A struct with `type` holds photons, one without it (before 2012)
/// energy, as `illuminantModernize` has it; of a light that differs from pixel to pixel the mean is taken.
fn illuminant(
    fields: &dyn Fields,
    header: &Header,
    of @ Reading { path, options }: Reading<'_>,
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
    let packed = [scalar(light, "data.min", of)?, scalar(light, "data.max", of)?];
    let is_energy = bare || (text_at(light, "type")?.is_none() && packed[0].is_none());
    let mut nm = header.wavelengths_nm.clone();
    for name in ["spectrum.wave", "wavelength", "wave"] {
        if let Some(wave) = numbers_at(light, name)? {
            nm = wavelengths::in_nm(&wave, "the wavelengths of the illuminant", of)?;
            break;
        }
    }
    let array = &stated.array;
    let mut values = if array.count() == nm.len() as u64 {
        stated.list("the illuminant", path, options.limits)?
    } else if array.dims.len() == 3 && array.dim(2) == nm.len() && array.count() > 0 {
        let cube = array.cube(Axes::MATLAB, path, options.limits)?;
        let together = match &cube.storage {
            Storage::Blocks(blocks) => blocks.size[0],
            Storage::Run { .. } => 1,
        };
        let pixels = (cube.raster.rows * cube.raster.cols).max(1);
        let bytes = (pixels as u64).saturating_mul(8 * together.min(nm.len()) as u64);
        options.limits.check(path, "the illuminant", bytes, cube.source.len())?;
        let mut means = Vec::with_capacity(nm.len());
        for first in (0..nm.len()).step_by(together) {
            let planes = doubles(&cube, first..(first + together).min(nm.len()), path)?;
            means.extend(planes.chunks_exact(pixels).map(|p| p.iter().sum::<f64>() / pixels as f64));
        }
        means
    } else if array.count() == 0 {
        return Ok(None);
    } else {
        let expected = format!("{} numbers, one per wavelength", nm.len());
        return Err(IoError::field(path, "the illuminant", stated.shape(), expected));
    };
    if let [Some(low), Some(high)] = packed {
        let steps = (8.0 * array.kind.size() as f64).exp2() - 1.0;
        values.iter_mut().for_each(|v| *v = *v * (high - low) / steps + low);
    }
    let grid = header.grid;
    let mut photons = Vec::with_capacity(grid.len());
    for at in grid.wavelengths_nm() {
        let value = interpolated(&nm, &values, at).ok_or_else(|| {
            let (first, last) = (nm.first().copied().unwrap_or(0.0), nm.last().copied().unwrap_or(0.0));
            let expected = format!("all wavelengths of the scene, including {} nm", at);
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
