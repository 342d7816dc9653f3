//! An image: three planes in a stated colour space.

use thiserror::Error;

use crate::numeric::{Planes, first_invalid};

/// The meaning of the three planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColorSpace {
    /// CIE X, Y, Z of the 1931 observer. The function that makes the image states the scale where it matters.
    Xyz,
    /// Linear light, primaries of IEC 61966-2-1, D65 white = (1, 1, 1).
    LinearSrgb,
    /// As [`ColorSpace::LinearSrgb`], encoded by the sRGB curve, 0 to 1.
    Srgb,
    /// Linear light, Display P3 primaries (SMPTE EG 432-1 with D65 white).
    LinearDisplayP3,
    /// As [`ColorSpace::LinearDisplayP3`], encoded by the sRGB curve, 0 to 1.
    DisplayP3,
}

impl ColorSpace {
    /// Its name in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Xyz => "XYZ",
            Self::LinearSrgb => "linear sRGB",
            Self::Srgb => "sRGB",
            Self::LinearDisplayP3 => "linear Display P3",
            Self::DisplayP3 => "Display P3",
        }
    }
}

/// Errors of an image.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The number of planes, this one, is not three.
    #[error("an image has 3 planes, got {0}")]
    Planes(usize),
    /// The operation is defined in another colour space.
    #[error("expected an image in {}, got {}", expected.name(), got.name())]
    Space {
        /// The space it is defined in.
        expected: ColorSpace,
        /// The space of the image.
        got: ColorSpace,
    },
    /// A value is NaN or infinite.
    #[error(
        "plane {plane} of the image is {value} at row {row}, column {col} (all counted from 0); a finite number was expected"
    )]
    Value {
        /// Plane, from 0.
        plane: usize,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        col: usize,
        /// The value.
        value: f32,
    },
    /// Two images that are compared differ in size.
    #[error("the images differ in size: {} × {} and {} × {}", left.0, left.1, right.0, right.1)]
    Size {
        /// Rows and columns of the first.
        left: (usize, usize),
        /// Rows and columns of the second.
        right: (usize, usize),
    },
    /// A picture cannot be adapted from this white.
    #[error(
        "the white with X, Y, Z of {0:?} cannot be adapted to D65: its cone responses (Bradford) must be finite and above 0, which those of light of few wavelengths are not; choose a broader illuminant"
    )]
    White([f64; 3]),
}

/// Three planes of equal size in a colour space.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    space: ColorSpace,
    planes: Planes,
}

impl Image {
    /// An image from three planes.
    ///
    /// # Errors
    /// When the number of planes is not three.
    pub fn new(space: ColorSpace, planes: Planes) -> Result<Self, ImageError> {
        if planes.count() == 3 { Ok(Self { space, planes }) } else { Err(ImageError::Planes(planes.count())) }
    }

    /// Checks that the image is in a colour space.
    pub(super) fn check_space(&self, expected: ColorSpace) -> Result<(), ImageError> {
        let got = self.space;
        if got == expected { Ok(()) } else { Err(ImageError::Space { expected, got }) }
    }

    /// Checks that every value is finite.
    ///
    /// # Errors
    /// [`ImageError::Value`] for the first value that is not.
    pub fn check_finite(&self) -> Result<(), ImageError> {
        match first_invalid(self.planes.data(), f32::is_finite) {
            None => Ok(()),
            Some(i) => {
                let (n, cols) = (self.planes.plane_len(), self.cols());
                let (plane, row, col) = (i / n, i % n / cols, i % cols);
                Err(ImageError::Value { plane, row, col, value: self.planes.data()[i] })
            }
        }
    }

    /// The colour space.
    #[must_use]
    pub fn space(&self) -> ColorSpace {
        self.space
    }

    /// Rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.planes.rows()
    }

    /// Columns.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.planes.cols()
    }

    /// The three planes.
    #[must_use]
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// The values of the three planes, each in row order.
    #[must_use]
    pub fn channels(&self) -> [&[f32]; 3] {
        // `Image::new` has counted the planes.
        let (first, rest) = self.planes.data().split_at(self.planes.plane_len());
        let (second, third) = rest.split_at(self.planes.plane_len());
        [first, second, third]
    }

    pub(super) fn planes_mut(&mut self) -> &mut Planes {
        &mut self.planes
    }

    /// The three planes by value.
    #[must_use]
    pub fn into_planes(self) -> Planes {
        self.planes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_value_that_is_not_finite_is_named_by_its_place() {
        let mut planes = Planes::zeros(3, 4, 3);
        planes.data_mut()[2 * 12 + 4 + 2] = f32::INFINITY;
        let found = Image::new(ColorSpace::Xyz, planes).unwrap().check_finite();
        assert!(matches!(found, Err(ImageError::Value { plane: 2, row: 1, col: 2, .. })), "{found:?}");
    }
}
