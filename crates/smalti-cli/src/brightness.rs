//! How bright a picture is shown.

use smalti::color::Image;
use smalti::numeric::Planes;

/// The share of pixels that may be brighter than white when the brightness of a picture is chosen.
const BRIGHT_SHARE: f64 = 0.005;

/// The factor that makes a picture as bright as a viewer expects: all but the brightest half percent within the range of
/// the display.
pub(crate) fn brightness_gain(picture: &Image) -> f64 {
    let mut luminance: Vec<f32> = picture.planes().plane(1).to_vec();
    let at = ((luminance.len() - 1) as f64 * (1.0 - BRIGHT_SHARE)) as usize;
    let (_, &mut bright, _) = luminance.select_nth_unstable_by(at, f32::total_cmp);
    if bright > 0.0 { 1.0 / f64::from(bright) } else { 1.0 }
}

pub(crate) fn scaled(image: &Image, factor: f64) -> anyhow::Result<Image> {
    let planes = image.planes();
    let data = planes.data().iter().map(|&v| (f64::from(v) * factor) as f32).collect();
    Ok(Image::new(image.space(), Planes::new(planes.rows(), planes.cols(), planes.count(), data)?)?)
}
