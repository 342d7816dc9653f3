//! Scenes from files of any format that holds one.

pub(crate) mod blocks;
pub(crate) mod crop;
pub(crate) mod cube_file;
pub(crate) mod facts;
mod into_scene;
mod spectral;
pub(crate) mod stated;
pub(crate) mod tiles;
mod upsampling;
mod write;

use std::path::Path;

use smalti::color::{ColorSpace, Image};
use smalti::scene::{Scene, Setting};
use smalti::spectrum::Illuminant;

use crate::error::At;
use crate::{IoError, bands, envi, exr, hdf5, matlab, memory, npz, picture, spectral_tiff};

pub use crop::Crop;
pub use spectral::{Quantity, ReadOptions, SpectralFile};
pub use tiles::{Cropped, Header, Tiles, Whole, load};
pub use upsampling::Upsampling;
pub use write::{Photons, Restated, WriteOptions, write};

/// A format of spectral images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Spectral OpenEXR.
    Exr,
    /// ENVI: header and samples.
    Envi,
    /// NumPy: an array, or an archive of arrays.
    Numpy,
    /// TIFF of many bands.
    Tiff,
    /// A folder of pictures, one for each band.
    Bands,
    /// MATLAB, level 5 or version 7.3.
    Mat,
    /// HDF5.
    Hdf5,
}

impl Format {
    /// The format that the extension of a file determines.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        Some(match extension(path)?.as_str() {
            "exr" => Self::Exr,
            "hdr" | "img" | "dat" | "raw" | "bsq" | "bil" | "bip" => Self::Envi,
            "npy" | "npz" => Self::Numpy,
            "tif" | "tiff" => Self::Tiff,
            "mat" => Self::Mat,
            "h5" | "hdf5" => Self::Hdf5,
            _ => return None,
        })
    }

    /// As [`Self::of`], and by what is there: folders, and samples of ENVI under any name with their header beside them.
    #[must_use]
    pub fn find(path: &Path) -> Option<Self> {
        if path.is_dir() {
            return bands::is_folder(path).then_some(Self::Bands);
        }
        Self::of(path).or_else(|| {
            let picture = extension(path).is_some_and(|e| PICTURES.contains(&e.as_str()));
            (!picture && path.is_file() && envi::header_beside(path).is_some()).then_some(Self::Envi)
        })
    }
}

/// Extensions of all files that a scene is read from.
pub const EXTENSIONS: [&str; 18] = [
    "exr", "hdr", "img", "dat", "raw", "bsq", "bil", "bip", "npy", "npz", "tif", "tiff", "mat", "h5", "hdf5",
    "png", "jpg", "jpeg",
];

/// Extensions of pictures, which hold no spectra; a TIFF may.
const PICTURES: [&str; 5] = ["png", "tif", "tiff", "jpg", "jpeg"];

/// Whether the name of a scene is that of a file: the file exists, or the name has the extension of one, or it is a folder of bands.
#[must_use]
pub fn is_meant(name: &str) -> bool {
    let path = Path::new(name);
    let picture = || extension(path).is_some_and(|e| PICTURES.contains(&e.as_str()));
    path.is_file() || Format::find(path).is_some() || picture()
}

fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// A spectral image whose samples are read as they are needed; none where the file is a picture. Of the options, the part is not
/// looked at.
///
/// # Errors
/// When the header cannot be read or is not valid, or the options state how a picture is upsampled and the file holds spectra.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Option<Box<dyn Tiles>>, IoError> {
    let tiles = spectral_tiles(path, options)?;
    if let Some(Header { rows, cols, .. }) = tiles.as_ref().map(|t| t.header())
        && (*rows == 0 || *cols == 0)
    {
        let found = format!("of {rows} rows and {cols} columns");
        return Err(IoError::field(path, "the image", found, "at least one row and one column"));
    }
    match options.upsampling {
        Some(upsampling) if tiles.is_some() => Err(IoError::field(
            path,
            "upsampling",
            upsampling.name().to_owned(),
            "a picture: this file holds spectra",
        )),
        _ => Ok(tiles),
    }
}

fn spectral_tiles(path: &Path, options: &ReadOptions) -> Result<Option<Box<dyn Tiles>>, IoError> {
    match Format::find(path) {
        Some(Format::Envi) => envi::open(path, options).map(Some),
        Some(Format::Numpy) => npz::open(path, options).map(Some),
        Some(Format::Tiff) if spectral_tiff::is_spectral(path, options)? => {
            spectral_tiff::open(path, options).map(Some)
        }
        Some(Format::Exr) if exr::is_spectral(path)? => exr::open(path, options).map(Some),
        Some(Format::Bands) => bands::open(path, options).map(Some),
        Some(Format::Mat) => matlab::open(path, options).map(Some),
        Some(Format::Hdf5) => hdf5::open(path, options).map(Some),
        _ => Ok(None),
    }
}

/// A spectral image of any format, whole or the part that the options ask for; none where the file is a picture.
///
/// # Errors
/// When the file cannot be read or is not valid.
pub fn read_spectral(path: &Path, options: &ReadOptions) -> Result<Option<SpectralFile>, IoError> {
    open(path, options)?.map(|tiles| load(&tiles, path, options)).transpose()
}

/// A file as a scene on its own wavelengths: spectra as they are, a picture spectrally upsampled on the wavelengths of the setting.
/// Facts that the file does not state are those of the setting, except for the light: without one, daylight (D65) is assumed.
///
/// # Errors
/// When the file cannot be read or holds no scene.
pub fn read(path: &Path, setting: &Setting, options: &ReadOptions) -> Result<Scene, IoError> {
    // Messages about the file call it by the name that was typed.
    let name = path.display().to_string();
    let file = match read_spectral(path, options)? {
        Some(spectral) => SpectralFile { name, ..spectral },
        None => upsampled(path, name, setting, options)?,
    };
    // Light is put on it in a second cube.
    memory::ensure_available(path, "the scene", Header::of(&file).decoded_bytes())?;
    file.into_scene(&Setting { illuminant: Illuminant::D65, ..setting.clone() })
}

/// A picture as reflectances.
fn upsampled(
    path: &Path,
    name: String,
    setting: &Setting,
    options: &ReadOptions,
) -> Result<SpectralFile, IoError> {
    let image = picture::read(path, options)?.image.converted(ColorSpace::LinearSrgb).at(path)?;
    let image = match options.crop {
        Some(part) => {
            let part = part.within(image.rows(), image.cols(), path)?;
            Image::new(image.space(), tiles::cropped(image.planes(), part, path)?).at(path)?
        }
        None => image,
    };
    // The darkest reflectance that is upsampled is not 0, and a mean luminance would scale it to white.
    if image.planes().data().iter().all(|&v| v <= 0.0) {
        let expected =
            "a pixel that is not black, since a scene without light cannot be scaled to a luminance";
        return Err(IoError::field(path, "every pixel of the picture", "0".to_owned(), expected));
    }
    let pixels = (image.rows() as u64).saturating_mul(image.cols() as u64);
    let bytes = pixels.saturating_mul(setting.grid.len() as u64).saturating_mul(4);
    options.limits.check_memory(path, "the cube of spectra of the picture", bytes)?;
    let cube = options.upsampling.unwrap_or_default().spectra(&image, setting.grid).at(path)?;
    Ok(SpectralFile {
        name,
        cube,
        quantity: Quantity::Reflectance,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    })
}

#[cfg(test)]
mod tests {
    use smalti::numeric::Planes;

    use super::*;
    use crate::Limits;

    /// A picture is small, and its spectra are not.
    #[test]
    fn the_spectra_of_a_picture_are_limited() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let planes = Planes::new(50, 50, 3, vec![0.5; 7500]).unwrap();
        picture::write_png(&path, &Image::new(ColorSpace::Srgb, planes).unwrap(), picture::Depth::Eight)
            .unwrap();
        // 50 × 50 pixels of 31 wavelengths in single precision take 310 000 bytes.
        let read = |decoded_bytes, crop| {
            let limits = Limits { decoded_bytes, ..Limits::default() };
            read(&path, &Setting::default(), &ReadOptions { limits, crop, ..ReadOptions::default() })
        };
        let error = read(309_999, None).unwrap_err().to_string();
        assert!(
            error.ends_with(
                "the cube of spectra of the picture takes 310000 bytes; at most 309999 are allowed"
            ),
            "{error}"
        );
        read(310_000, None).unwrap();
        // The part alone counts.
        read(309_999, Some(Crop { row: 0, col: 0, rows: 10, cols: 10 })).unwrap();
    }
}
