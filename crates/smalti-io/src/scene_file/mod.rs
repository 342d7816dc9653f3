//! Scenes from files of any format that holds one.

pub(crate) mod facts;
mod into_scene;
mod spectral;

use std::path::Path;

use smalti::color::ColorSpace;
use smalti::color::jakob_hanika2019::Uplift;
use smalti::scene::{Scene, Setting};
use smalti::spectrum::{Illuminant, Observer};

use crate::{IoError, exr, hdf5, matlab, picture};

pub use into_scene::SceneDefaults;
pub use spectral::{Quantity, ReadOptions, SpectralFile};

/// A format of spectral images, told by the end of the file's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Spectral OpenEXR.
    Exr,
    /// MATLAB, level 5 or version 7.3.
    Mat,
    /// HDF5.
    Hdf5,
}

impl Format {
    /// The one that the name of a file tells.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        Some(match extension(path)?.as_str() {
            "exr" => Self::Exr,
            "mat" => Self::Mat,
            "h5" | "hdf5" => Self::Hdf5,
            _ => return None,
        })
    }
}

/// Extensions of pictures, which hold no spectra.
const PICTURES: [&str; 5] = ["png", "tif", "tiff", "jpg", "jpeg"];

/// Whether a scene is meant as a file: it is one, or its name ends as one.
#[must_use]
pub fn is_meant(name: &str) -> bool {
    let path = Path::new(name);
    let picture = || extension(path).is_some_and(|e| PICTURES.contains(&e.as_str()));
    path.is_file() || Format::of(path).is_some() || picture()
}

fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// A spectral image of any format; none where the file is a picture.
///
/// # Errors
/// When the file cannot be read or is not valid.
pub fn read_spectral(path: &Path, options: &ReadOptions) -> Result<Option<SpectralFile>, IoError> {
    match Format::of(path) {
        Some(Format::Exr) if exr::is_spectral(path, options)? => exr::read(path, options).map(Some),
        Some(Format::Mat) => matlab::read(path, options).map(Some),
        Some(Format::Hdf5) => hdf5::read(path, options).map(Some),
        _ => Ok(None),
    }
}

/// A file as a scene on its own wavelengths: spectra as they are, a picture lifted to spectra on the wavelengths of the setting.
/// What the file leaves unsaid is that of the setting, but for the light: files that say nothing of it are taken for daylight (D65).
///
/// # Errors
/// When the file cannot be read or holds no scene.
pub fn read(path: &Path, setting: &Setting, options: &ReadOptions) -> Result<Scene, IoError> {
    let defaults = SceneDefaults {
        luminance_cd_m2: setting.luminance_cd_m2,
        distance_m: setting.distance_m,
        horizontal_fov_deg: setting.horizontal_fov_deg,
        illuminant: Illuminant::D65,
    };
    // Messages about the file call it by the name that was typed.
    let name = path.display().to_string();
    let file = match read_spectral(path, options)? {
        Some(spectral) => SpectralFile { name, ..spectral },
        None => lifted(path, name, setting, options)?,
    };
    file.into_scene(&defaults)
}

/// A picture as reflectances.
fn lifted(
    path: &Path,
    name: String,
    setting: &Setting,
    options: &ReadOptions,
) -> Result<SpectralFile, IoError> {
    let image = picture::read(path, options)?.image.converted(ColorSpace::LinearSrgb);
    let image = image.map_err(|source| IoError::Image { path: path.to_owned(), source })?;
    let uplift = |source| IoError::Uplift { path: path.to_owned(), source };
    let cube = Uplift::new(setting.grid, Observer::Cie1931).and_then(|u| u.uplift_image(&image));
    Ok(SpectralFile {
        name,
        cube: cube.map_err(uplift)?,
        quantity: Quantity::Reflectance,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    })
}
