//! Spectral images that are read by parts, so that they need not fit into memory.

use std::ops::Deref;
use std::path::Path;

use smalti::numeric::Planes;
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

use super::crop::Crop;
use super::spectral::{Quantity, ReadOptions, SpectralFile};
use super::stated::Bands;
use crate::IoError;
use crate::error::At;
use crate::wavelengths::{Between, places};

/// The facts that a spectral file states beside its samples; see [`SpectralFile`] for units.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// What the image is called.
    pub name: String,
    /// Rows of the image.
    pub rows: usize,
    /// Columns of the image.
    pub cols: usize,
    /// The wavelengths of the file, ascending, nm.
    pub wavelengths_nm: Vec<f64>,
    /// The uniform grid that the bands are resampled to in a [`SpectralFile`].
    pub grid: WavelengthGrid,
    /// What the values are.
    pub quantity: Quantity,
    /// The light, on `grid`.
    pub illuminant: Option<Spectrum>,
    /// Distance, m.
    pub distance_m: Option<f64>,
    /// Full horizontal field of view, degrees.
    pub horizontal_fov_deg: Option<f64>,
}

impl Header {
    /// That of a file which states no more than this.
    pub(crate) fn plain(
        name: String,
        (rows, cols): (usize, usize),
        bands: Bands,
        quantity: Quantity,
    ) -> Self {
        Self {
            name,
            rows,
            cols,
            wavelengths_nm: bands.wavelengths_nm,
            grid: bands.grid,
            quantity,
            illuminant: None,
            distance_m: None,
            horizontal_fov_deg: None,
        }
    }

    /// That of a file in memory.
    #[must_use]
    pub fn of(file: &SpectralFile) -> Self {
        Self {
            name: file.name.clone(),
            rows: file.cube.rows(),
            cols: file.cube.cols(),
            wavelengths_nm: file.cube.grid().wavelengths_nm().collect(),
            grid: file.cube.grid(),
            quantity: file.quantity,
            illuminant: file.illuminant.clone(),
            distance_m: file.distance_m,
            horizontal_fov_deg: file.horizontal_fov_deg,
        }
    }

    /// Bytes of the samples in memory.
    #[must_use]
    pub fn decoded_bytes(&self) -> u64 {
        let pixels = (self.rows as u64).saturating_mul(self.cols as u64);
        pixels.saturating_mul(self.wavelengths_nm.len() as u64).saturating_mul(4)
    }

    fn cropped(&self, crop: Crop) -> Self {
        let fov = self.horizontal_fov_deg.map(|deg| crop.field_of_view_deg(deg, self.cols));
        Self { rows: crop.rows, cols: crop.cols, horizontal_fov_deg: fov, ..self.clone() }
    }
}

/// A spectral image whose header has been read, and whose samples are read as they are needed.
pub trait Tiles: Send + Sync {
    /// The facts that the file states beside its samples.
    fn header(&self) -> &Header;

    /// A part of the image: one plane for each wavelength of the header, finite and not negative.
    ///
    /// # Errors
    /// When the part reaches beyond the image, the file cannot be read, or a sample is not valid (with its band and place).
    fn read(&self, part: Crop) -> Result<Planes, IoError>;

    /// Number of rows, counted from the first, that are best read together because they are unpacked together. 1 if each is read
    /// on its own.
    fn rows_at_once(&self) -> usize {
        1
    }
}

/// A file in memory.
pub struct Whole<'a> {
    header: Header,
    cube: &'a SpectralCube,
}

impl<'a> Whole<'a> {
    /// The file as one that is read by parts.
    #[must_use]
    pub fn new(file: &'a SpectralFile) -> Self {
        Self { header: Header::of(file), cube: &file.cube }
    }
}

impl Tiles for Whole<'_> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read(&self, part: Crop) -> Result<Planes, IoError> {
        let path = Path::new(&self.header.name);
        let part = part.within(self.header.rows, self.header.cols, path)?;
        cropped(self.cube.planes(), part, path)
    }
}

/// A part of planes that has been found to lie within them.
pub(crate) fn cropped(planes: &Planes, part: Crop, path: &Path) -> Result<Planes, IoError> {
    planes.cropped(part.row, part.col, part.rows, part.cols).at(path)
}

/// A part of an image as an image.
pub struct Cropped<T> {
    inner: T,
    part: Crop,
    header: Header,
}

impl<T: Tiles> Cropped<T> {
    /// A part of an image; `path` is only named.
    ///
    /// # Errors
    /// When it reaches beyond.
    pub fn new(inner: T, part: Crop, path: &Path) -> Result<Self, IoError> {
        let whole = inner.header();
        let part = part.within(whole.rows, whole.cols, path)?;
        let header = whole.cropped(part);
        Ok(Self { inner, part, header })
    }
}

impl<T: Tiles> Tiles for Cropped<T> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read(&self, part: Crop) -> Result<Planes, IoError> {
        let part = part.within(self.header.rows, self.header.cols, Path::new(&self.header.name))?;
        self.inner.read(Crop { row: self.part.row + part.row, col: self.part.col + part.col, ..part })
    }

    fn rows_at_once(&self) -> usize {
        self.inner.rows_at_once()
    }
}

impl<P: Deref<Target: Tiles> + Send + Sync> Tiles for P {
    fn header(&self) -> &Header {
        (**self).header()
    }

    fn read(&self, part: Crop) -> Result<Planes, IoError> {
        (**self).read(part)
    }

    fn rows_at_once(&self) -> usize {
        (**self).rows_at_once()
    }
}

/// The whole of an image, or the part that the options ask for, on a uniform grid.
///
/// # Errors
/// When it takes more memory than the limits allow, or as [`Tiles::read`].
pub fn load(tiles: &dyn Tiles, path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    match options.crop {
        Some(crop) => load_whole(&Cropped::new(tiles, crop, path)?, path, options),
        None => load_whole(tiles, path, options),
    }
}

fn load_whole(tiles: &dyn Tiles, path: &Path, options: &ReadOptions) -> Result<SpectralFile, IoError> {
    let header = tiles.header();
    let grid = header.grid;
    let places = places(&header.wavelengths_nm, grid);
    let same = places.len() == header.wavelengths_nm.len()
        && places.iter().enumerate().all(|(i, p)| *p == Between { index: i, weight: 0.0 });
    let pixels = (header.rows as u64).saturating_mul(header.cols as u64);
    let planes = header.wavelengths_nm.len() as u64 + if same { 0 } else { grid.len() as u64 };
    let bytes = pixels.saturating_mul(planes).saturating_mul(4);
    options.limits.check_memory(path, "the cube", bytes)?;
    let planes = tiles.read(Crop::whole(header.rows, header.cols))?;
    let planes = if same { planes } else { resampled(&planes, &places, path)? };
    Ok(SpectralFile {
        name: header.name.clone(),
        cube: SpectralCube::new(grid, planes).at(path)?,
        quantity: header.quantity,
        illuminant: header.illuminant.clone(),
        distance_m: header.distance_m,
        horizontal_fov_deg: header.horizontal_fov_deg,
    })
}

/// Planes between those of the file, linearly.
pub(crate) fn resampled(planes: &Planes, places: &[Between], path: &Path) -> Result<Planes, IoError> {
    let mut data = Vec::with_capacity(places.len() * planes.plane_len());
    for place in places {
        let below = planes.plane(place.index).at(path)?;
        if place.weight > 0.0 {
            let (above, t) = (planes.plane(place.index + 1).at(path)?, place.weight as f32);
            data.extend(below.iter().zip(above).map(|(a, b)| a * (1.0 - t) + b * t));
        } else {
            data.extend_from_slice(below);
        }
    }
    Planes::new(planes.rows(), planes.cols(), places.len(), data).at(path)
}
