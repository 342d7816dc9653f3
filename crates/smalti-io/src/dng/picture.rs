//! Rendered pictures as linear DNG, which raw developers go on from.
//!
//! A developer that does not know a mosaic refuses its raw file. A rendered picture has every colour at every pixel: DNG holds it as
//! LinearRaw, before white balance, tone curve and gamut mapping, which stay with the developer.

use std::path::Path;

use smalti::color::display::Primaries;
use smalti::color::matrix::apply;
use smalti::color::{ColorSpace, Image};
use smalti::sensor::{RawImage, RawSamples, Sampling};

use super::write::{Compression, write_viewed};
use super::{ColorMatrix, Crop, DngInfo};
use crate::{IoError, Orientation};

/// The level of zero light. Noise below it is clipped: RawTherapee 5.9 and darktable 4.2 read a linear DNG with another level wrongly, with a
/// red cast or without subtracting it.
const BLACK: f64 = 0.0;
/// The level of the brightest sample.
const WHITE: f64 = 65535.0;

/// What a linear DNG states about its picture.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DngPicture {
    /// X, Y, Z of the illuminant (`AsShotNeutral`).
    pub white: [f64; 3],
    /// By which a developer multiplies the picture, above 0 (`BaselineExposure`).
    pub gain: f64,
    /// The model of the camera.
    pub model: String,
    /// How the picture is to be turned for viewing.
    pub orientation: Orientation,
    /// The part that a developer shows, as that of the raw file; `None` for the whole.
    pub default_crop: Option<Crop>,
}

/// Writes a picture in XYZ, in which a white diffuser has at most Y = 1, as linear DNG of 16 bits. Its channels are the primaries of
/// ROMM RGB (ISO 22028-2), which contain the colours of all surfaces; `ColorMatrix1` is their matrix. Samples below zero
/// light are clipped.
///
/// # Errors
/// When the picture is not in XYZ, has a value that is not finite, or the file cannot be written.
pub fn write_picture(path: &Path, picture: &Image, stated: &DngPicture) -> Result<(), IoError> {
    let DngPicture { white, gain, .. } = *stated;
    let wrong = |found: String, expected: &str| IoError::field(path, "the picture", found, expected);
    if picture.space() != ColorSpace::Xyz {
        return Err(wrong(format!("in {}", picture.space().name()), "a picture in XYZ"));
    }
    picture.check_finite().map_err(|e| wrong(e.to_string(), "finite values"))?;
    let unfit = || wrong(format!("white {white:?}"), "X, Y, Z of a light");
    let matrix = Primaries::ROMM.rgb_from_xyz().ok_or_else(unfit)?;
    let [x, y, z] = picture.channels();
    let plane = |[a, b, c]: [f64; 3]| {
        let xyz = x.iter().zip(y).zip(z);
        xyz.map(move |((x, y), z)| a * f64::from(*x) + b * f64::from(*y) + c * f64::from(*z))
    };
    let neutral = apply(&matrix, white);
    let brightest = neutral.into_iter().fold(0.0, f64::max);
    if !(neutral.iter().all(|v| *v > 0.0) && brightest.is_finite() && gain > 0.0) {
        return Err(unfit());
    }
    // What is brighter than a white diffuser, such as a lamp, is kept.
    let full = matrix.into_iter().flat_map(plane).fold(brightest, f64::max);
    let level = |v: f64| (v / full * WHITE).round().clamp(BLACK, WHITE) as u16;
    let samples: Vec<u16> = matrix.into_iter().flat_map(plane).map(level).collect();
    let raw = RawImage::new(
        picture.rows(),
        picture.cols(),
        RawSamples::Digital(samples),
        Sampling::Full { channels: 3 },
        ["R", "G", "B"].map(str::to_owned).to_vec(),
        BLACK,
        WHITE,
    )
    .map_err(|e| wrong(e.to_string(), "a picture with pixels"))?;
    let info = DngInfo {
        make: "Smalti".into(),
        model: stated.model.clone(),
        color_matrix: Some(ColorMatrix {
            camera_from_xyz: matrix.to_vec(),
            light_source: DngInfo::OTHER_LIGHT,
        }),
        as_shot_neutral: Some(neutral.map(|v| v / brightest).to_vec()),
        baseline_exposure_stops: Some((gain * full).log2()),
    };
    write_viewed(path, &raw, &info, Compression::LosslessJpeg, (stated.orientation, stated.default_crop))
}
