//! The ColorChecker on a camera: the positions and the scores of its patches.

use crate::camera::CameraError;
use crate::color::Image;
use crate::metrics::color_accuracy::{ColorAccuracy, LabWhite, color_accuracy};
use crate::metrics::{Rect, patch_means};
use crate::scene::macbeth;
use crate::spectrum::{Observer, Spectrum};

/// Pixels of the sensor that a patch of the chart spans.
const PATCH_PX: usize = 40;
/// Side of the measured centre of a patch, pixels, as in ISETCam.
const PATCH_CORE_PX: usize = 25;
/// Samples of the scene per patch. Fewer samples than pixels suffice for uniform patches, as in ISETCam.
pub(super) const PATCH_SAMPLES: usize = 32;
/// Rows and columns of the sensor that the chart covers.
pub(super) const SIZE_PX: [usize; 2] = [macbeth::ROWS * PATCH_PX, macbeth::COLS * PATCH_PX];
/// Indices of the grey series, from white to black.
pub(crate) const GREYS: std::ops::Range<usize> = 18..24;
pub(super) const WHITE: usize = 18;
/// The plane Y of a picture in XYZ.
pub(crate) const LUMINANCE: usize = 1;

/// The measured centre of every patch, row by row from dark skin.
pub(crate) fn patches() -> Vec<Rect> {
    let inset = (PATCH_PX - PATCH_CORE_PX) / 2;
    let patch = |i: usize| Rect {
        row: i / macbeth::COLS * PATCH_PX + inset,
        col: i % macbeth::COLS * PATCH_PX + inset,
        rows: PATCH_CORE_PX,
        cols: PATCH_CORE_PX,
    };
    (0..macbeth::ROWS * macbeth::COLS).map(patch).collect()
}

/// Reference X, Y, Z of every patch under an illuminant (photons).
pub(crate) fn expected(light: &Spectrum) -> Result<Vec<[f64; 3]>, CameraError> {
    let xyz = |s: &Spectrum| Ok(Observer::Cie1931.xyz_from_photons(&s.times(light)?)?);
    macbeth::reflectances(light.grid())?.iter().map(xyz).collect()
}

/// Colour differences between measured patches and their [reference](expected()).
pub(crate) fn accuracy(measured: &[[f64; 3]], expected: &[[f64; 3]]) -> Result<ColorAccuracy, CameraError> {
    Ok(color_accuracy(measured, expected, WHITE, LabWhite::Reference)?)
}

/// Mean X, Y, Z of the patches of a picture.
pub(crate) fn means(picture: &Image, patches: &[Rect]) -> Result<Vec<[f64; 3]>, CameraError> {
    Ok(patch_means(picture.planes(), patches)?.iter().map(|m| [m[0], m[1], m[2]]).collect())
}

/// Colour differences of a picture of the chart under an illuminant (photons) from the reference.
pub(super) fn colors(clean: &Image, light: &Spectrum) -> Result<ColorAccuracy, CameraError> {
    accuracy(&means(clean, &patches())?, &expected(light)?)
}
