//! Conversion of images between colour spaces.

use rayon::prelude::*;

use super::display::{ENCODED_KNEE, LINEAR_KNEE, Matrices, decode_srgb};
use super::matrix::{IDENTITY, Matrix3, product};
use super::{ColorSpace, Image, ImageError};
use crate::numeric::Planes;

/// Pixels per task.
const CHUNK: usize = 16_384;

impl ColorSpace {
    /// To and from XYZ; for XYZ itself the identity.
    fn matrices(self) -> Matrices {
        match self {
            Self::Xyz => Matrices { xyz_from_rgb: IDENTITY, rgb_from_xyz: IDENTITY },
            Self::LinearSrgb | Self::Srgb => Matrices::SRGB,
            Self::LinearDisplayP3 | Self::DisplayP3 => Matrices::DISPLAY_P3,
        }
    }

    /// Whether values are encoded by the sRGB curve.
    fn is_encoded(self) -> bool {
        matches!(self, Self::Srgb | Self::DisplayP3)
    }
}

impl Image {
    /// The image in another colour space.
    ///
    /// [`ColorSpace::Xyz`] here is relative to the white of the display spaces (D65) at Y = 1; absolute
    /// values need scaling first. Linear spaces represent colours outside the gamut by values below 0 or
    /// above 1. Encoded spaces cannot, so encoding clips each channel to 0–1. No chromatic adaptation takes
    /// place. The encoding is accurate to 1e-6.
    ///
    /// # Errors
    /// None at present; reserved for spaces without a conversion.
    pub fn converted(&self, to: ColorSpace) -> Result<Self, ImageError> {
        if self.space() == to {
            return Ok(self.clone());
        }
        let matrix = between(to, self.space());
        let decode = self.space().is_encoded().then(DecodeTable::new);
        let encode = to.is_encoded().then(EncodeTable::new);
        let source = self.channels();
        let mut planes = Planes::zeros(self.rows(), self.cols(), 3);
        let n = planes.plane_len();
        let (x, rest) = planes.data_mut().split_at_mut(n);
        let (y, z) = rest.split_at_mut(n);
        let m = matrix.map(|row| row.map(|v| v as f32));
        let chunks = x.par_chunks_mut(CHUNK).zip(y.par_chunks_mut(CHUNK)).zip(z.par_chunks_mut(CHUNK));
        chunks.enumerate().for_each(|(chunk, ((x, y), z))| {
            let start = chunk * CHUNK;
            let [a, b, c] = source.map(|p| &p[start..start + x.len()]);
            let outputs = x.iter_mut().zip(y).zip(z);
            for (((x, y), z), ((&a, &b), &c)) in outputs.zip(a.iter().zip(b).zip(c)) {
                let v = match &decode {
                    Some(table) => [a, b, c].map(|v| table.at(v)),
                    None => [a, b, c],
                };
                let v = m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
                [*x, *y, *z] = match &encode {
                    Some(table) => v.map(|v| table.at(v)),
                    None => v,
                };
            }
        });
        Self::new(to, planes)
    }
}

/// The matrix from linear values of `from` to linear values of `to`.
fn between(to: ColorSpace, from: ColorSpace) -> Matrix3 {
    let (to, from) = (to.matrices(), from.matrices());
    if to == from { IDENTITY } else { product(&to.rgb_from_xyz, &from.xyz_from_rgb) }
}

/// The sRGB decoding curve above its linear segment, interpolated between samples evenly spaced in encoded
/// value.
struct DecodeTable(Vec<f32>);

impl DecodeTable {
    /// The interpolation error is (1/4096)²/8 times the curvature, at most 3.2, hence below 3e-8.
    const STEPS: usize = 4096;

    fn new() -> Self {
        Self((0..=Self::STEPS + 1).map(|i| power_branch(i as f64 / Self::STEPS as f64)).collect())
    }

    fn at(&self, encoded: f32) -> f32 {
        let v = encoded.clamp(0.0, 1.0);
        if v > ENCODED_KNEE as f32 {
            let x = v * Self::STEPS as f32;
            let i = x as usize;
            let t = x - i as f32;
            self.0[i] + t * (self.0[i + 1] - self.0[i])
        } else {
            v / 12.92 // and NaN
        }
    }
}

/// The power segment of the curve, extended below the linear segment so that interpolation next to it stays
/// smooth.
fn power_branch(encoded: f64) -> f32 {
    if encoded > ENCODED_KNEE {
        decode_srgb(encoded) as f32
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4) as f32
    }
}

/// The sRGB encoding curve above its linear segment, interpolated between samples evenly spaced within each
/// octave of linear light. The relative error is then uniform: 2⁻¹⁶/8 × 0.25 × 1.055 = 5e-7.
struct EncodeTable(Vec<f32>);

impl EncodeTable {
    const BITS: u32 = 8;
    /// The lowest float of the table, 2⁻⁹, which lies in the linear segment.
    const FIRST: u32 = 0x3b00_0000;

    fn new() -> Self {
        let last = Self::index(1.0) + 1;
        let sample = |i: usize| {
            let linear = f64::from(f32::from_bits(Self::FIRST + ((i as u32) << (23 - Self::BITS))));
            (1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055) as f32
        };
        Self((0..=last).map(sample).collect())
    }

    fn index(linear: f32) -> usize {
        ((linear.to_bits() - Self::FIRST) >> (23 - Self::BITS)) as usize
    }

    fn at(&self, linear: f32) -> f32 {
        let v = linear.clamp(0.0, 1.0);
        if v > LINEAR_KNEE as f32 {
            let i = Self::index(v);
            let mask = (1 << (23 - Self::BITS)) - 1;
            let t = (v.to_bits() & mask) as f32 / (mask + 1) as f32;
            // Rounding can carry the curve above 1.
            (self.0[i] + t * (self.0[i + 1] - self.0[i])).min(1.0)
        } else {
            12.92 * v // and NaN
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::display::encode_srgb;

    const ALL: [ColorSpace; 5] = [
        ColorSpace::Xyz,
        ColorSpace::LinearSrgb,
        ColorSpace::Srgb,
        ColorSpace::LinearDisplayP3,
        ColorSpace::DisplayP3,
    ];

    /// An image of colours within the sRGB gamut, longer than one chunk.
    fn picture() -> Image {
        let n = 3 * 70_000;
        let data = (0..n).map(|i| ((i * 7919) % 4093) as f32 / 4092.0).collect();
        Image::new(ColorSpace::LinearSrgb, Planes::new(700, 100, 3, data).unwrap()).unwrap()
    }

    #[test]
    fn every_pair_of_spaces_round_trips() {
        let original = picture();
        for a in ALL {
            let in_a = original.converted(a).unwrap();
            for b in ALL {
                let back = in_a.converted(b).unwrap().converted(a).unwrap();
                let worst = back
                    .planes()
                    .data()
                    .iter()
                    .zip(in_a.planes().data())
                    .map(|(x, y)| (x - y).abs())
                    .fold(0.0, f32::max);
                // Near black the curve multiplies rounding errors by 12.92.
                assert!(worst < 2e-5, "{a:?} → {b:?}: {worst}");
            }
        }
    }

    #[test]
    fn tables_follow_the_curve() {
        let (encode, decode) = (EncodeTable::new(), DecodeTable::new());
        for i in 0..=100_000 {
            let v = i as f32 / 100_000.0;
            assert!((f64::from(encode.at(v)) - encode_srgb(f64::from(v))).abs() < 1e-6, "encode {v}");
            assert!((f64::from(decode.at(v)) - decode_srgb(f64::from(v))).abs() < 2e-7, "decode {v}");
        }
        assert_eq!((encode.at(-1.0), encode.at(2.0)), (0.0, 1.0));
        assert_eq!((decode.at(-1.0), decode.at(2.0)), (0.0, 1.0));
        assert!(encode.at(f32::NAN).is_nan() && decode.at(f32::NAN).is_nan());
    }

    #[test]
    fn colours_outside_the_gamut_are_kept_until_encoded() {
        let green = Planes::new(1, 1, 3, vec![0.0, 1.0, 0.0]).unwrap();
        let green = Image::new(ColorSpace::LinearDisplayP3, green).unwrap();
        let linear = green.converted(ColorSpace::LinearSrgb).unwrap();
        assert!(linear.channels()[0][0] < -0.2 && linear.channels()[1][0] > 1.0);
        let srgb = green.converted(ColorSpace::Srgb).unwrap();
        assert_eq!((srgb.channels()[0][0], srgb.channels()[1][0]), (0.0, 1.0));
    }

    #[test]
    fn white_is_d65_at_unit_luminance() {
        let white = Image::new(ColorSpace::Srgb, Planes::new(1, 1, 3, vec![1.0; 3]).unwrap()).unwrap();
        let xyz = white.converted(ColorSpace::Xyz).unwrap();
        for (c, expected) in [0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290].into_iter().enumerate()
        {
            assert!((f64::from(xyz.channels()[c][0]) - expected).abs() < 1e-6);
        }
    }
}
