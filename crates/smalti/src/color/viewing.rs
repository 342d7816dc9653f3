//! Conversion of relative XYZ images for viewing on a display.

use super::adaptation::bradford;
use super::display::{D65_XYZ, Matrices, encode_srgb};
use super::matrix::apply;
use super::{ColorSpace, Image, ImageError, xyz_from_lab};
use crate::numeric::Planes;
use crate::numeric::elementary::whole_part_f32;
use crate::numeric::simd::{Kernel, dispatch};

/// White point of sRGB as rounded in IEC 61966-2-1: X, Y, Z with Y = 1.
pub const SRGB_WHITE: [f64; 3] = [0.95047, 1.0, 1.08883];

/// The fraction of pixels that may exceed display white with [`Image::brightness_gain`].
const BRIGHT_SHARE: f64 = 0.005;

impl Image {
    /// The gain that brings all but the brightest half percent of the pixels of an XYZ image within the range
    /// of the display. It is 1 for a dark image.
    #[must_use]
    pub fn brightness_gain(&self) -> f64 {
        let mut luminance: Vec<f32> = self.channels()[1].to_vec();
        let at = (luminance.len().saturating_sub(1) as f64 * (1.0 - BRIGHT_SHARE)) as usize;
        if luminance.is_empty() {
            return 1.0;
        }
        let (_, &mut bright, _) = luminance.select_nth_unstable_by(at, f32::total_cmp);
        if bright > 0.0 { 1.0 / f64::from(bright) } else { 1.0 }
    }

    /// The image with every value multiplied by a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.planes_mut().data_mut().iter_mut().for_each(|v| *v = (f64::from(*v) * factor) as f32);
        self
    }

    /// The planes as 8-bit red, green and blue, pixel by pixel; 0 is black and 1 full.
    #[must_use]
    pub fn rgb8(&self) -> Vec<u8> {
        let planes = self.channels();
        let mut bytes = vec![0; 3 * planes[0].len()];
        let pieces = bytes.chunks_mut(3 * Bytes::PIXELS).zip((0..).step_by(Bytes::PIXELS));
        pieces.for_each(|(out, first)| {
            let channels = planes.map(|plane| &plane[first..first + out.len() / 3]);
            dispatch(Bytes { channels, out });
        });
        bytes
    }

    /// The same with a fourth byte, full opacity, after those of each pixel.
    #[must_use]
    pub fn rgba8(&self) -> Vec<u8> {
        self.rgb8().as_chunks().0.iter().flat_map(|&[r, g, b]| [r, g, b, u8::MAX]).collect()
    }

    /// Converts a picture in XYZ to sRGB for viewing. Its white (X, Y, Z with Y = 1) is adapted to that of sRGB (Bradford), and it is multiplied by
    /// `gain`. Without a white, colours are not adapted. These are the steps by which a camera with the white balance of the illuminant makes its picture, so that
    /// equal pictures are shown by equal bits.
    ///
    /// # Errors
    /// [`ImageError::Space`] when the picture is not in XYZ; [`ImageError::White`] when the white cannot be adapted.
    pub fn shown(&self, white: Option<[f64; 3]>, gain: f64) -> Result<Self, ImageError> {
        self.balanced(white)?.scaled(gain).converted(ColorSpace::Srgb)
    }

    /// A picture in XYZ with its white (X, Y, Z with Y = 1) adapted to that of sRGB (Bradford); without a white, as it is.
    ///
    /// # Errors
    /// [`ImageError::Space`] when the picture is not in XYZ; [`ImageError::White`] when the white cannot be adapted.
    pub fn balanced(&self, white: Option<[f64; 3]>) -> Result<Self, ImageError> {
        self.check_space(ColorSpace::Xyz)?;
        white.map_or_else(|| Ok(self.clone()), |white| self.adapted(D65_XYZ, white))
    }

    /// A picture in XYZ with its white (X, Y, Z with Y = 1) adapted to another (Bradford).
    ///
    /// # Errors
    /// [`ImageError::Space`] when the picture is not in XYZ; [`ImageError::White`] when the white cannot be adapted.
    pub fn adapted(&self, white_to: [f64; 3], white_from: [f64; 3]) -> Result<Self, ImageError> {
        let matrix = bradford(white_to, white_from).ok_or(ImageError::White(white_from))?;
        self.check_space(ColorSpace::Xyz)?;
        let ([x, y, z], mut out) = (self.channels(), Planes::zeros(self.rows(), self.cols(), 3));
        for (out, row) in out.planes_mut().zip(&matrix) {
            let [a, b, c] = row.map(|v| v as f32);
            let xyz = x.iter().zip(y).zip(z);
            out.iter_mut().zip(xyz).for_each(|(o, ((x, y), z))| *o = a * x + b * y + c * z);
        }
        Self::new(ColorSpace::Xyz, out)
    }
}

/// Three channels, of which 0 is black and 1 full, as 8-bit numbers, pixel by pixel.
struct Bytes<'a> {
    channels: [&'a [f32]; 3],
    out: &'a mut [u8],
}

impl Bytes<'_> {
    /// The most pixels at a time, so that their numbers stay in the L1 cache.
    const PIXELS: usize = 1024;
}

impl Kernel for Bytes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut numbers = [[0u8; Self::PIXELS]; 3];
        for (numbers, values) in numbers.iter_mut().zip(self.channels) {
            for (number, value) in numbers.iter_mut().zip(values) {
                #[allow(clippy::manual_clamp)] // which would keep NaN
                let scaled = value.max(0.0).min(1.0) * 255.0;
                let whole = whole_part_f32(scaled);
                *number = (whole + u32::from(scaled - whole as f32 >= 0.5)) as u8;
            }
        }
        let [r, g, b] = &numbers;
        for (out, ((r, g), b)) in self.out.as_chunks_mut().0.iter_mut().zip(r.iter().zip(g).zip(b)) {
            *out = [*r, *g, *b];
        }
    }
}

/// CIELAB as 8-bit sRGB. The white of CIELAB becomes that of the display, and what the display cannot show is clipped.
#[must_use]
pub fn srgb8_from_lab(lab: [f64; 3]) -> [u8; 3] {
    let linear = apply(&Matrices::SRGB.rgb_from_xyz, xyz_from_lab(lab, SRGB_WHITE));
    linear.map(|v| (encode_srgb(v) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes are the nearest numbers, in images of several pieces; what is beyond the range is its nearest end.
    #[test]
    fn bytes_are_rounded_pixel_by_pixel() {
        let count = 2 * Bytes::PIXELS + 5;
        let value = |i: usize| match i % 7 {
            0 => -0.25,
            1 => 1.75,
            2 => (i % 255) as f32 / 255.0 + 0.5 / 255.0,
            3 => [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][i % 3],
            _ => (i * i % 1009) as f32 / 1008.0,
        };
        let data: Vec<f32> = (0..3 * count).map(value).collect();
        let image = Image::new(ColorSpace::Srgb, Planes::new(1, count, 3, data.clone()).unwrap()).unwrap();
        let bytes = image.rgb8();
        assert_eq!(bytes.len(), 3 * count);
        for (i, byte) in bytes.into_iter().enumerate() {
            let value = data[i % 3 * count + i / 3];
            assert_eq!(byte, (value.clamp(0.0, 1.0) * 255.0).round() as u8, "{i}: {value}");
        }
    }

    /// Greys from the definitions of L* (CIE 15) and of the curve (IEC 61966-2-1); the primaries' CIELAB under D65 from Lindbloom.
    #[test]
    fn colours_of_cielab_on_a_display() {
        for (lab, rgb) in [
            ([100.0, 0.0, 0.0], [255; 3]),
            ([0.0; 3], [0; 3]),
            ([53.585, 0.0, 0.0], [128; 3]),
            ([53.24, 80.09, 67.20], [255, 0, 0]),
            ([87.73, -86.18, 83.18], [0, 255, 0]),
        ] {
            let got = srgb8_from_lab(lab);
            assert!(
                got.iter().zip(rgb).all(|(a, b): (&u8, u8)| a.abs_diff(b) <= 1),
                "{lab:?}: {got:?}, not {rgb:?}"
            );
        }
    }

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
    fn a_white_that_cannot_be_adapted_is_refused() {
        let picture = Image::new(ColorSpace::Xyz, Planes::zeros(2, 2, 3)).unwrap();
        for white in [[0.0; 3], [f64::NAN, 1.0, 1.0], [0.1, -0.1, 20.0]] {
            assert!(matches!(picture.shown(Some(white), 1.0), Err(ImageError::White(_))), "{white:?}");
        }
        assert!(picture.shown(None, 1.0).is_ok());
    }

    #[test]
    fn half_a_percent_may_be_brighter_than_white() {
        let mut planes = Planes::zeros(20, 50, 3);
        planes.plane_mut(1).unwrap().fill(0.5);
        planes.plane_mut(1).unwrap()[..5].fill(100.0);
        let picture = Image::new(ColorSpace::Xyz, planes).unwrap();
        assert_eq!(picture.brightness_gain(), 2.0);
    }
}
