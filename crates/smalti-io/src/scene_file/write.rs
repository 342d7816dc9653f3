//! Spectral images into any format that is written.

use std::path::Path;

use smalti::numeric::Planes;
use smalti::spectrum::units::photons_per_joule;

use super::crop::Crop;
use super::spectral::{Quantity, ReadOptions};
use super::tiles::{Header, Tiles, load};
use super::{Format, extension};
use crate::envi::Interleave;
use crate::error::At;
use crate::file::{Negative, sample};
use crate::{IoError, Limits, envi, exr, hdf5, matlab, memory, npz, spectral_tiff};

/// Choices that formats leave.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Order of the samples of ENVI; otherwise that of the file's extension, BSQ if the extension determines none.
    pub interleave: Option<Interleave>,
    /// Channels of OpenEXR; otherwise those of Fichet et al.
    pub exr: Option<exr::Layout>,
    /// Version of a MAT-file; otherwise level 5.
    pub matlab: Option<matlab::Version>,
    /// Bands of TIFF.
    pub tiff: spectral_tiff::WriteOptions,
}

/// Writes a spectral image in the format that the extension of the file determines: OpenEXR, MATLAB, HDF5, ENVI, NumPy or TIFF. The last
/// three are written by rows, so that the image need not fit into memory.
///
/// Returns notes on the facts that the file does not hold.
///
/// # Errors
/// When the extension names no format that can be written, the image cannot be read, or the file cannot be written.
pub fn write(path: &Path, image: &dyn Tiles, options: &WriteOptions) -> Result<Vec<String>, IoError> {
    let header = image.header();
    let mut notes = Vec::new();
    match Format::of(path) {
        Some(Format::Envi) => {
            let by_name = match extension(path).as_deref() {
                Some("bil") => Interleave::Bil,
                Some("bip") => Interleave::Bip,
                _ => Interleave::Bsq,
            };
            envi::write(path, image, options.interleave.unwrap_or(by_name))?;
        }
        Some(Format::Numpy) if extension(path).is_some_and(|e| e == "npz") => npz::write(path, image)?,
        Some(Format::Numpy) => {
            let lost =
                "the wavelengths, the quantity, the light, distance and field of view (an .npz holds them)";
            notes.push(format!("{} holds {} alone, without {lost}", path.display(), header.quantity.name()));
            npz::write_npy(path, image)?;
        }
        Some(Format::Tiff) => spectral_tiff::write(path, image, options.tiff)?,
        Some(whole @ (Format::Exr | Format::Mat | Format::Hdf5)) => {
            if !header.wavelengths_nm.iter().copied().eq(header.grid.wavelengths_nm()) {
                let (path, grid) = (path.display(), header.grid);
                notes.push(format!("{path} holds the spectrum at {grid}, linear between the bands"));
            }
            // These formats are written from memory. The file states the size, and no other limit holds.
            let stated = header.decoded_bytes().saturating_mul(copies(whole));
            memory::ensure_available(path, "the image and its encoding", stated)?;
            let limits = Limits { decoded_bytes: u64::MAX, ..Limits::default() };
            let file = load(image, path, &ReadOptions { limits, ..ReadOptions::default() })?;
            match whole {
                Format::Mat => matlab::write(path, &file, options.matlab.unwrap_or_default())?,
                Format::Hdf5 => hdf5::write(path, &file)?,
                _ => exr::write(path, &file.into_energy()?, options.exr.unwrap_or(exr::Layout::Fichet2021))?,
            }
        }
        Some(Format::Bands) | None => {
            let expected =
                "a name that ends in .exr, .mat, .h5, .hdr (or .img, .bsq, .bil, .bip), .npz, .npy or .tif";
            return Err(IoError::unknown(path, expected));
        }
    }
    Ok(notes)
}

/// How often the samples of an image are in memory at once while it is written, at most; a test of this crate counts.
fn copies(format: Format) -> u64 {
    match format {
        Format::Mat => 4,
        _ => 3,
    }
}

/// An image with facts other than its own.
pub struct Restated<T> {
    inner: T,
    header: Header,
}

impl<T: Tiles> Restated<T> {
    /// The image at another distance (m) or of another horizontal field of view (degrees), where one is given.
    pub fn new(inner: T, distance_m: Option<f64>, horizontal_fov_deg: Option<f64>) -> Self {
        let mut header = inner.header().clone();
        header.distance_m = distance_m.or(header.distance_m);
        header.horizontal_fov_deg = horizontal_fov_deg.or(header.horizontal_fov_deg);
        Self { inner, header }
    }
}

impl<T: Tiles> Tiles for Restated<T> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read(&self, part: Crop) -> Result<Planes, IoError> {
        self.inner.read(part)
    }

    fn rows_at_once(&self) -> usize {
        self.inner.rows_at_once()
    }
}

/// Radiance in photons.
pub struct Photons<T> {
    inner: T,
    header: Header,
}

impl<T: Tiles> Photons<T> {
    /// The image, where it is absolute radiance in photons or in energy; otherwise it is given back.
    ///
    /// # Errors
    /// The image itself, where it is relative or a reflectance: it becomes radiance as a scene alone.
    pub fn new(inner: T) -> Result<Self, T> {
        match inner.header().quantity {
            Quantity::Photons | Quantity::Energy => {
                let header = Header { quantity: Quantity::Photons, ..inner.header().clone() };
                Ok(Self { inner, header })
            }
            Quantity::RelativeEnergy | Quantity::Reflectance => Err(inner),
        }
    }
}

impl<T: Tiles> Tiles for Photons<T> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read(&self, part: Crop) -> Result<Planes, IoError> {
        let planes = self.inner.read(part)?;
        if self.inner.header().quantity == Quantity::Photons {
            return Ok(planes);
        }
        let path = Path::new(&self.header.name);
        let (rows, cols, count) = (planes.rows(), planes.cols(), planes.count());
        let mut data = planes.into_data();
        let plane = (rows * cols).max(1);
        for (nm, plane) in self.header.wavelengths_nm.iter().zip(data.chunks_mut(plane)) {
            let factor = photons_per_joule(*nm);
            for (i, v) in plane.iter_mut().enumerate() {
                let photons = (f64::from(*v) * factor) as f32;
                *v = sample(photons, Negative::Refuse).map_err(|expected| {
                    let place = [part.row + i / cols, part.col + i % cols];
                    IoError::pixel(path, format!("{nm} nm"), place, *v, expected)
                })?;
            }
        }
        Planes::new(rows, cols, count, data).at(path)
    }

    fn rows_at_once(&self) -> usize {
        self.inner.rows_at_once()
    }
}
