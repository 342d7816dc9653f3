//! Pictures in 8-bit sRGB.

use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;
use smalti::spectrum::{Extrapolation, Illuminant, Observer, Spectrum, WavelengthGrid};

use crate::{ReportError, Sheet};

/// A sheet with one more picture, in sRGB, and the caption below it.
pub(crate) fn add(sheet: Sheet, caption: impl Into<String>, picture: &Image) -> Sheet {
    sheet.picture(caption, picture.cols(), picture.rows(), &picture.rgb8())
}

/// A picture of 8-bit sRGB: three bytes a pixel, row by row.
#[derive(Clone)]
pub(crate) struct Pixels {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) rgb: Vec<u8>,
}

impl Pixels {
    /// Of an image in sRGB.
    pub(crate) fn of(image: &Image) -> Self {
        Self { width: image.cols(), height: image.rows(), rgb: image.rgb8() }
    }
}

/// The colour of daylight behind a filter, in sRGB from 0.25 to 1. A filter that passes no visible light is grey.
///
/// # Errors
/// When the spectrum of the filter cannot be resampled.
pub fn filter_color(filter: &Spectrum) -> Result<[f32; 3], ReportError> {
    // Daylight is not tabulated over the whole range of sensors.
    let filter = filter.resampled(WavelengthGrid::VISIBLE, Extrapolation::Zero)?;
    let light = Illuminant::D65.photons(filter.grid())?;
    let xyz = Observer::Cie1931.xyz_from_photons(&filter.times(&light)?)?;
    let white = Observer::Cie1931.xyz_from_photons(&light)?[1].max(f64::MIN_POSITIVE);
    let planes = Planes::new(1, 1, 3, xyz.map(|v| (v / white) as f32).to_vec())?;
    let rgb = Image::new(ColorSpace::Xyz, planes)?.converted(ColorSpace::Srgb)?;
    Ok(rgb.channels().map(|c| c[0].clamp(0.25, 1.0)))
}
