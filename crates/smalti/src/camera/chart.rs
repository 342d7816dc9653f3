//! The ColorChecker on a camera: the positions and the scores of its patches.

use crate::camera::CameraError;
use crate::color::Image;
use crate::metrics::color_accuracy::{ColorAccuracy, LabWhite, color_accuracy};
use crate::metrics::luminance_noise::luminance_noise;
use crate::metrics::visual_snr::visual_snr;
use crate::metrics::{MetricError, Rect, patch_means};
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
const WHITE: usize = 18;
/// The plane Y of a picture in XYZ.
pub(crate) const LUMINANCE: usize = 1;
/// Viewing resolution for visual noise, pixels per degree, as in [`ScoreSettings`](super::ScoreSettings).
const VIEWING_PX_PER_DEGREE: f64 = 60.0;

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

/// The noise of the grey series, from white to black.
pub(super) struct GreyNoise {
    /// `100 · std(Y) / mean(Y)`.
    pub(super) luminance_noise_percent: Vec<f64>,
    /// Visual signal-to-noise ratio: reciprocal standard deviation in S-CIELAB.
    pub(super) visual_snr: Vec<f64>,
}

/// Noise of a picture of the chart under an illuminant (photons).
///
/// The observer is assumed to be adapted to the picture: white has the chromaticity of the illuminant and the luminance of the
/// white patch.
pub(super) fn noise(noisy: &Image, light: &Spectrum) -> Result<GreyNoise, CameraError> {
    let rects = patches();
    let luminance_noise_percent = luminance_noise(noisy.planes(), LUMINANCE, &rects[GREYS])?.percent;
    let white_y = patch_means(noisy.planes(), &rects[WHITE..=WHITE])?.concat()[LUMINANCE];
    let white = Observer::Cie1931.xyz_from_photons(light)?;
    let white = white.map(|v| v / white[LUMINANCE] * white_y);
    let visual = |rect: &Rect| visual_snr(noisy, *rect, white, VIEWING_PX_PER_DEGREE);
    let visual_snr = rects[GREYS].iter().map(visual).collect::<Result<Vec<f64>, MetricError>>()?;
    Ok(GreyNoise { luminance_noise_percent, visual_snr })
}
