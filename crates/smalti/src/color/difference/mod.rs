//! Colour differences in CIELAB, each formula in a file of its own, and maps of them over pictures.

mod cie76;
mod cie94;
mod ciede2000;

use rayon::prelude::*;

pub use cie76::delta_e_76;
pub use cie94::delta_e_94;
pub use ciede2000::delta_e_2000;

use super::cie1976::lab_from_xyz;
use super::{ColorSpace, Image, ImageError};
use crate::numeric::Planes;

/// Pixels that one task works on; fixed, so that results do not depend on the number of threads.
const CHUNK: usize = 4096;

/// A colour difference formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum DeltaE {
    /// Euclidean distance in CIELAB.
    Cie1976,
    /// CIE 1994 for graphic arts; the first colour is the standard.
    Cie1994,
    /// CIEDE2000.
    #[default]
    Ciede2000,
}

impl DeltaE {
    /// The difference between two colours in CIELAB.
    #[must_use]
    pub fn between(self, lab1: [f64; 3], lab2: [f64; 3]) -> f64 {
        match self {
            Self::Cie1976 => delta_e_76(lab1, lab2),
            Self::Cie1994 => delta_e_94(lab1, lab2),
            Self::Ciede2000 => delta_e_2000(lab1, lab2),
        }
    }
}

/// A colour difference at every pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct DifferenceMap {
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub cols: usize,
    /// ΔE in row order.
    pub values: Vec<f32>,
}

impl DifferenceMap {
    /// The mean over all pixels; 0 for an empty map.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|&v| f64::from(v)).sum::<f64>() / self.values.len().max(1) as f64
    }

    /// The largest value; 0 for an empty map.
    #[must_use]
    pub fn max(&self) -> f32 {
        self.values.iter().copied().fold(0.0, f32::max)
    }
}

/// ΔE at every pixel of two pictures of equal size in [`ColorSpace::Xyz`], against a white in the same scale.
///
/// # Errors
/// When a picture is not in XYZ, or the sizes differ.
pub fn delta_e_map(
    reference: &Image,
    test: &Image,
    white: [f64; 3],
    formula: DeltaE,
) -> Result<DifferenceMap, ImageError> {
    check_pair(reference, test)?;
    let size = (reference.rows(), reference.cols());
    Ok(map_of_planes(size, three(reference.planes()), three(test.planes()), white, formula))
}

/// Whether two pictures can be compared.
pub(super) fn check_pair(reference: &Image, test: &Image) -> Result<(), ImageError> {
    for image in [reference, test] {
        if image.space() != ColorSpace::Xyz {
            return Err(ImageError::Space { expected: ColorSpace::Xyz, got: image.space() });
        }
    }
    if (reference.rows(), reference.cols()) != (test.rows(), test.cols()) {
        return Err(ImageError::Size {
            left_rows: reference.rows(),
            left_cols: reference.cols(),
            right_rows: test.rows(),
            right_cols: test.cols(),
        });
    }
    Ok(())
}

/// The planes of a picture.
pub(super) fn three(planes: &Planes) -> [&[f32]; 3] {
    [planes.plane(0), planes.plane(1), planes.plane(2)]
}

/// ΔE of planes that are known to have equal length.
pub(super) fn map_of_planes(
    (rows, cols): (usize, usize),
    reference: [&[f32]; 3],
    test: [&[f32]; 3],
    white: [f64; 3],
    formula: DeltaE,
) -> DifferenceMap {
    let mut values = vec![0.0f32; rows * cols];
    values.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
        for (i, value) in out.iter_mut().enumerate() {
            let at = chunk * CHUNK + i;
            let lab = |p: [&[f32]; 3]| lab_from_xyz([0, 1, 2].map(|c| f64::from(p[c][at])), white);
            *value = formula.between(lab(reference), lab(test)) as f32;
        }
    });
    DifferenceMap { rows, cols, values }
}
