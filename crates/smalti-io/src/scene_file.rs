//! Scenes from files of any format that holds one.

use std::path::Path;

use smalti::color::ColorSpace;
use smalti::color::jakob_hanika2019::Uplift;
use smalti::scene::{Scene, Setting};
use smalti::spectrum::{Illuminant, Observer};

use crate::exr::{self, Quantity, ReadOptions, SceneDefaults, SpectralFile};
use crate::{IoError, picture};

/// Extensions of the files that hold scenes.
const EXTENSIONS: [&str; 6] = ["exr", "png", "tif", "tiff", "jpg", "jpeg"];

/// Whether a scene is meant as a file: it is one, or its name ends as one.
#[must_use]
pub fn is_meant(name: &str) -> bool {
    let path = Path::new(name);
    path.is_file() || extension(path).is_some_and(|e| EXTENSIONS.contains(&e.as_str()))
}

fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// A file as a scene on its own wavelengths: a spectral EXR as it is, a picture lifted to spectra on the wavelengths of the setting.
/// What the file leaves unsaid is that of the setting, but for the light: files that say nothing of it are taken for daylight (D65).
///
/// # Errors
/// When the file cannot be read or holds no scene.
pub fn read(path: &Path, setting: &Setting) -> Result<Scene, IoError> {
    let read = ReadOptions::default();
    let defaults = SceneDefaults {
        luminance_cd_m2: setting.luminance_cd_m2,
        distance_m: setting.distance_m,
        horizontal_fov_deg: setting.horizontal_fov_deg,
        illuminant: Illuminant::D65,
    };
    // Messages about the file call it by the name that was typed.
    let name = path.display().to_string();
    if extension(path).is_some_and(|e| e == "exr") && exr::is_spectral(path, &read)? {
        return SpectralFile { name, ..exr::read(path, &read)? }.into_scene(&defaults);
    }
    let uplift = |source| IoError::Uplift { path: path.to_owned(), source };
    let image = picture::read(path, &read)?.image.converted(ColorSpace::LinearSrgb);
    let image = image.map_err(|source| IoError::Image { path: path.to_owned(), source })?;
    let lifted = SpectralFile {
        name,
        cube: Uplift::new(setting.grid, Observer::Cie1931)
            .and_then(|u| u.uplift_image(&image))
            .map_err(uplift)?,
        quantity: Quantity::Reflectance,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    };
    lifted.into_scene(&defaults)
}
