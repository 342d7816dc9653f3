//! Reading `.npy` and `.npz`.

use std::path::Path;
use std::sync::Arc;

use smalti::spectrum::Spectrum;

use super::array::{Array, Type, axes, named_axes};
use super::zip::{Archive, Member};
use crate::error::At;
use crate::file::{at_most, stem};
use crate::raster::{Cube, FileSource, Shared, Storage, part};
use crate::scene_file::cube_file::CubeFile;
use crate::scene_file::stated::{Bands, known_quantity};
use crate::scene_file::tiles::{Tiles, load};
use crate::wavelengths::places;
use crate::{IoError, Quantity, ReadOptions, SpectralFile, UnstatedProperty};

/// Elements of an array that is not the cube, bytes.
const LIST_LIMIT: u64 = 64 << 20;

/// A spectral image from a single array (`.npy`) or an archive of named ones (`.npz`), which its first bytes identify.
/// `docs/formats-scenes.md` lists the names of the arrays and what is assumed where one is absent.
///
/// Samples of a compressed archive are unpacked from the beginning, as far as they are needed.
///
/// # Errors
/// When the file cannot be read, is no array or archive, has no cube or several, the axis of wavelengths is not clear, or wavelengths
/// are neither stated nor given.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Box<dyn Tiles>, IoError> {
    Ok(Box::new(opened(Arc::new(FileSource::open(path)?), path, options)?))
}

/// As [`open`] and [`load`], from memory; `path` is only named.
pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    load(&opened(Arc::new(bytes), path, options)?, path, options)
}

fn opened<'a>(source: Shared<'a>, path: &Path, options: &ReadOptions) -> Result<CubeFile<'a>, IoError> {
    let io = IoError::reading(path);
    let magic = part(&*source, 0, source.len().min(6) as usize).map_err(io)?;
    if magic.starts_with(b"PK") { archive(source, path, options) } else { single(source, path, options) }
}

fn single<'a>(source: Shared<'a>, path: &Path, options: &ReadOptions) -> Result<CubeFile<'a>, IoError> {
    let io = IoError::reading(path);
    let start = |n: usize| part(&*source, 0, n.min(usize::try_from(source.len()).unwrap_or(n))).map_err(io);
    let array = Array::parse("", path, start)?;
    let given = options.grid.map(|g| g.len()).ok_or_else(|| {
        let expected = "an .npz with an array `wavelengths_nm`";
        IoError::field(path, "the wavelengths", "not stated: a single array", expected)
            .or_given(UnstatedProperty::Wavelengths)
    })?;
    let axes = axes(path, &array.shape, given)?;
    let bands = Bands::given(path, given, options)?;
    let cube =
        Cube { source, raster: array.raster(axes, path)?, storage: Storage::Run { offset: array.start } };
    cube.check(path, "the array", options.limits)?;
    let quantity = options.quantity.unwrap_or(Quantity::RelativeEnergy);
    Ok(CubeFile::new((path, "NumPy"), vec![cube], (stem(path), bands, quantity), options))
}

/// The arrays of an archive.
struct Arrays<'p, 'a> {
    archive: Archive<'p, 'a>,
    arrays: Vec<(Array, Member)>,
}

fn archive<'a>(source: Shared<'a>, path: &Path, options: &ReadOptions) -> Result<CubeFile<'a>, IoError> {
    let archive = Archive::open(&source, path, options.limits)?;
    let mut arrays = Vec::new();
    for member in &archive.members {
        // Files of other kinds are ignored.
        if let Some(name) = member.name.strip_suffix(".npy") {
            arrays.push((Array::parse(name, path, |n| archive.start(member, n))?, member.clone()));
        }
    }
    let arrays = Arrays { archive, arrays };
    let (cube, member) = arrays.cube(options)?;
    let (cube, member) = (cube.clone(), member.clone());

    let stated = arrays.list(&["wavelengths_nm", "wavelengths", "wavelength_nm", "wavelength"])?;
    let given = stated.as_ref().map(|(_, nm)| nm.len()).or(options.grid.map(|g| g.len()));
    let axes = match arrays.text("axes")? {
        Some(text) => named_axes(&text).ok_or_else(|| {
            let expected = "'band row column' or another order of the three";
            IoError::field(path, "axes", format!("'{text}'"), expected)
        })?,
        None => match given {
            Some(count) => axes(path, &cube.shape, count)?,
            None => {
                let expected = "an array `wavelengths_nm`";
                let error = IoError::field(path, "the wavelengths", "absent", expected);
                return Err(error.or_given(UnstatedProperty::Wavelengths));
            }
        },
    };
    if cube.shape.len() != 3 {
        let found = format!("{:?}", cube.shape);
        return Err(IoError::field(path, format!("{}: shape", cube.name), found, "three axes"));
    }
    let raster = cube.raster(axes, path)?;
    let light = arrays.list(&["illuminant_photons", "illuminant"])?;
    let not_of_bands = |name: &str, count: usize| {
        let expected = format!("{}, as many as bands", raster.bands);
        IoError::field(path, name, format!("{count} numbers"), expected)
    };
    let bands = match stated {
        Some((name, nm)) if nm.len() == raster.bands => {
            Bands::sorted(path, name, nm.into_iter().enumerate())?
        }
        Some((name, nm)) => return Err(not_of_bands(name, nm.len())),
        None => Bands::given(path, raster.bands, options)?,
    };
    let (quantity, factor) = match arrays.text("quantity")? {
        Some(text) => known_quantity(path, &text)?,
        None => (options.quantity.unwrap_or(Quantity::RelativeEnergy), 1.0),
    };
    let illuminant = match light {
        Some((name, values)) if values.len() != raster.bands => return Err(not_of_bands(name, values.len())),
        Some((name, values)) => {
            let wrong = |e| IoError::field(path, name, e, "finite values, not negative");
            Some(on_grid(&values, &bands).at(path).map_err(|e| wrong(e.to_string()))?)
        }
        None => None,
    };
    let (source, begin) = arrays.archive.source(&member)?;
    let need = raster.bytes().and_then(|n| n.checked_add(cube.start)).unwrap_or(u64::MAX);
    if need > member.size {
        return Err(IoError::truncated(path, "the cube", need, member.size));
    }
    let name = arrays.text("name")?.unwrap_or_else(|| stem(path));
    let distance_m = arrays.single(&["distance_m", "distance"])?;
    let horizontal_fov_deg = arrays.single(&["horizontal_fov_deg", "fov_deg", "fov"])?;
    let cube = Cube { source, raster, storage: Storage::Run { offset: begin + cube.start } };
    cube.check(path, "the cube", options.limits)?;
    let mut file = CubeFile::new((path, "NumPy"), vec![cube], (name, bands, quantity), options);
    file.header.illuminant = illuminant;
    file.header.distance_m = distance_m;
    file.header.horizontal_fov_deg = horizontal_fov_deg;
    if factor != 1.0 {
        file.gains = vec![(factor, 0.0); raster.bands];
    }
    Ok(file)
}

/// Values of the bands of a file, resampled to the grid of their wavelengths.
fn on_grid(values: &[f64], bands: &Bands) -> Result<Spectrum, smalti::spectrum::SpectrumError> {
    let sorted: Vec<f64> = bands.order.iter().filter_map(|i| values.get(*i).copied()).collect();
    let values = places(&bands.wavelengths_nm, bands.grid).iter().map(|p| p.of(&sorted)).collect();
    Spectrum::new(bands.grid, values)
}

impl Arrays<'_, '_> {
    /// The cube: the one that was requested, else `cube`, else the only one of three axes.
    fn cube(&self, options: &ReadOptions) -> Result<&(Array, Member), IoError> {
        let path = self.archive.path;
        let named = |name: &str| self.arrays.iter().find(|(a, _)| a.name == name);
        let cubes: Vec<&(Array, Member)> = self
            .arrays
            .iter()
            .filter(|(a, _)| a.shape.len() == 3 && matches!(a.kind, Type::Number(_)))
            .collect();
        let names =
            |of: &[&(Array, Member)]| of.iter().map(|(a, _)| a.name.clone()).collect::<Vec<_>>().join(", ");
        if let Some(name) = &options.variable {
            return named(name).ok_or_else(|| {
                let all: Vec<&(Array, Member)> = self.arrays.iter().collect();
                let expected = format!("one of {}", names(&all));
                IoError::field(path, format!("the array '{name}'"), "absent", expected)
            });
        }
        match (named("cube"), cubes.as_slice()) {
            (Some(cube), _) => Ok(cube),
            (None, [only]) => Ok(only),
            (None, []) => Err(IoError::field(path, "the cube", "absent", "an array of three axes")),
            (None, several) => {
                let found = format!("one of {}", names(several));
                let error = IoError::field(path, "the cube", found, "one called `cube`");
                Err(error.or_given(UnstatedProperty::Variable))
            }
        }
    }

    fn elements(&self, array: &Array, member: &Member) -> Result<Vec<u8>, IoError> {
        at_most(LIST_LIMIT, self.archive.path, "an array beside the cube", member.size)?;
        let content = self.archive.content(member)?;
        Ok(content.get(array.start as usize..).unwrap_or_default().to_vec())
    }

    /// The numbers of the list that is called one of these; two of them would be two answers.
    fn list<'n>(&self, names: &[&'n str]) -> Result<Option<(&'n str, Vec<f64>)>, IoError> {
        let path = self.archive.path;
        let mut found =
            names.iter().filter_map(|name| Some((*name, self.arrays.iter().find(|(a, _)| a.name == *name)?)));
        let Some((name, (array, member))) = found.next() else { return Ok(None) };
        if let Some((other, _)) = found.next() {
            let found = format!("stated twice: {name} and {other}");
            return Err(IoError::field(path, name, found, "one of them"));
        }
        let Some(count) = array.list_len() else {
            let found = format!("an array of shape {:?}", array.shape);
            return Err(IoError::field(path, name, found, "a list of numbers"));
        };
        let numbers = array.numbers(&self.elements(array, member)?);
        if numbers.len() != count {
            let found = format!("{} numbers", numbers.len());
            return Err(IoError::field(path, name, found, format!("{count}, as its shape states")));
        }
        Ok(Some((name, numbers)))
    }

    fn single(&self, names: &[&str]) -> Result<Option<f64>, IoError> {
        let path = self.archive.path;
        match self.list(names)? {
            None => Ok(None),
            Some((_, numbers)) if numbers.len() == 1 => Ok(numbers.first().copied()),
            Some((name, numbers)) => {
                Err(IoError::field(path, name, format!("{} numbers", numbers.len()), "one number"))
            }
        }
    }

    fn text(&self, name: &str) -> Result<Option<String>, IoError> {
        let Some((array, member)) = self.arrays.iter().find(|(a, _)| a.name == name) else { return Ok(None) };
        let text = array.text(&self.elements(array, member)?);
        let wrong = || IoError::field(self.archive.path, name, "no text", "a string");
        text.map(Some).ok_or_else(wrong)
    }
}
