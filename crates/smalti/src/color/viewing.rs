//! Pictures in relative XYZ made ready to be looked at on a screen.

use super::display::{Primaries, matrices};
use super::matrix::{IDENTITY, Matrix3, product};
use super::{Adaptation, ColorSpace, Image, ImageError};
use crate::numeric::Planes;

/// White of sRGB as IEC 61966-2-1 rounds it: X, Y, Z, Y = 1.
pub const SRGB_WHITE: [f64; 3] = [0.95047, 1.0, 1.08883];

/// The share of pixels that may be brighter than white when the brightness of a picture is chosen.
pub const BRIGHT_SHARE: f64 = 0.005;

/// X, Y, Z under a light of this white as sRGB shows it.
fn adapted(white: Option<[f64; 3]>) -> Matrix3 {
    white.and_then(|w| Adaptation::Bradford.matrix(SRGB_WHITE, w)).unwrap_or(IDENTITY)
}

/// Linear sRGB from X, Y, Z as [`Image::shown`] makes it, but for the gain.
#[must_use]
pub fn shown_from_xyz(white: Option<[f64; 3]>) -> Matrix3 {
    product(&matrices(&Primaries::SRGB).1, &adapted(white))
}

impl Image {
    /// The factor that makes a picture in XYZ as bright as a viewer expects: all but the brightest half percent of its pixels within
    /// the range of the display. 1 where that is dark.
    #[must_use]
    pub fn brightness_gain(&self) -> f64 {
        let mut luminance: Vec<f32> = self.planes().plane(1).to_vec();
        let at = (luminance.len().saturating_sub(1) as f64 * (1.0 - BRIGHT_SHARE)) as usize;
        if luminance.is_empty() {
            return 1.0;
        }
        let (_, &mut bright, _) = luminance.select_nth_unstable_by(at, f32::total_cmp);
        if bright > 0.0 { 1.0 / f64::from(bright) } else { 1.0 }
    }

    /// The picture with every value times a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.planes_mut().data_mut().iter_mut().for_each(|v| *v = (f64::from(*v) * factor) as f32);
        self
    }

    /// A picture in XYZ in sRGB as one looks at it: `gain` times as bright, and the white of its light, X, Y, Z with Y = 1, made
    /// that of sRGB (Bradford). Without a white, or with one that cannot be adapted, colours stay as they are.
    ///
    /// # Errors
    /// [`ImageError::Space`] when the picture is not in XYZ.
    pub fn shown(&self, white: Option<[f64; 3]>, gain: f64) -> Result<Self, ImageError> {
        if self.space() != ColorSpace::Xyz {
            return Err(ImageError::Space { expected: ColorSpace::Xyz, got: self.space() });
        }
        let (planes, mut out) = (self.planes(), Planes::zeros(self.rows(), self.cols(), 3));
        for (i, row) in adapted(white).iter().enumerate() {
            let [a, b, c] = row.map(|v| (v * gain) as f32);
            let xyz = planes.plane(0).iter().zip(planes.plane(1)).zip(planes.plane(2));
            out.plane_mut(i).iter_mut().zip(xyz).for_each(|(o, ((x, y), z))| *o = a * x + b * y + c * z);
        }
        Self::new(ColorSpace::Xyz, out)?.converted(ColorSpace::Srgb)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_under_any_light_is_shown_as_white() {
        let tungsten = [1.0985, 1.0, 0.3558];
        let data = tungsten.iter().flat_map(|v| [*v as f32 * 0.25; 400]).collect();
        let picture = Image::new(ColorSpace::Xyz, Planes::new(20, 20, 3, data).unwrap()).unwrap();
        assert!((picture.brightness_gain() - 4.0).abs() < 1e-6);
        let shown = picture.shown(Some(tungsten), picture.brightness_gain()).unwrap();
        assert!(
            shown.planes().data().iter().all(|v| (v - 1.0).abs() < 1e-3),
            "{:?}",
            shown.planes().data()[0]
        );
        let darker = picture.clone().scaled(0.5);
        assert!((darker.brightness_gain() - 8.0).abs() < 1e-6);
        assert!(shown.shown(None, 1.0).is_err());
    }

    #[test]
    fn half_a_percent_may_be_brighter_than_white() {
        let mut planes = Planes::zeros(20, 50, 3);
        planes.plane_mut(1).fill(0.5);
        planes.plane_mut(1)[..5].fill(100.0);
        let picture = Image::new(ColorSpace::Xyz, planes).unwrap();
        assert_eq!(picture.brightness_gain(), 2.0);
    }
}
