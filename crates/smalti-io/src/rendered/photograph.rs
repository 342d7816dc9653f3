//! Stored photographs, and reflectances as spectral files.

use std::path::Path;

use smalti::color::{ColorSpace, Image};
use smalti::spectrum::SpectralCube;

use crate::error::At;
use crate::{IoError, Quantity, ReadOptions, SpectralFile, picture};

/// A photograph, a JPEG file, in linear sRGB.
pub(super) fn decode(name: &str, bytes: &[u8]) -> Result<Image, IoError> {
    let path = Path::new(name);
    let image = picture::from_jpeg(bytes, path, &ReadOptions::default())?.image;
    image.converted(ColorSpace::LinearSrgb).at(path)
}

/// A file that states reflectances and nothing else.
pub(super) fn reflectances(name: &str, cube: SpectralCube) -> SpectralFile {
    SpectralFile {
        name: name.to_owned(),
        cube,
        quantity: Quantity::Reflectance,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    }
}
