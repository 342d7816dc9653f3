//! What the second stage computes, as data for exports and for counting.

use super::axes::{MAX_STRENGTHS, RefinementAxes};
use super::inputs::{COUNT, OUTPUTS};
use super::layout::{Kernels, REGISTERS};
use super::refinement::Refinement;
use super::roots::ROOTS;
use super::stages::{BEYOND, HALF, PICTURES, STEPS, rows_read_again, squares_of};
use crate::l3::blocks::LANES;
use crate::l3::vectors::Register;

/// Inputs of a pixel in the order of summation, the constant 1 of the offset and zeros included. Lane i of 16 sums the products of inputs i, i + 16,
/// i + 32 and i + 48 in this order.
pub const REFINEMENT_LANES: usize = REGISTERS * LANES;

/// A picture of the second stage. Each is computed from the one before; the first is that of the first stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinementPicture {
    /// Distance of the neighbours over which it is averaged, in its own pixels. `None` for the first picture, and for the one that has every
    /// second row and column of the one before and is not averaged.
    pub step: Option<usize>,
    /// Whether it has every second row and column.
    pub is_half: bool,
    /// Coefficients of 1, Y and Y² in the greatest squared difference of colours that counts: X² / 2 + Y² + Z² / 2 of the differences to a
    /// neighbour. Zeros where there is no step.
    pub squares: [f32; 3],
    /// Its rows, in its own rows, beyond an output row that depends on them.
    pub beyond: usize,
    /// Its latest rows that are read again while the outputs are computed row by row.
    pub kept: usize,
}

impl RefinementAxes {
    /// The seven pictures, in the order of computation: the picture, three smooth ones, every second pixel of the last, and two smooth ones.
    #[must_use]
    pub fn pictures(&self) -> [RefinementPicture; PICTURES] {
        std::array::from_fn(|index| {
            let step = Some(STEPS[index]).filter(|&step| step > 0);
            RefinementPicture {
                step,
                is_half: index >= HALF,
                squares: step.map_or([0.0; 3], |_| squares_of(index, self.noise())),
                beyond: BEYOND[index],
                kept: 1 + rows_read_again(index),
            }
        })
    }
}

impl Refinement {
    /// The weights and offsets in the order class, output, lane ([`REFINEMENT_LANES`]). The first 25 lanes are Y of the 5 × 5 pixels around
    /// the pixel, column by column; the next 18 are, for each of 3 columns, X of 3 rows, then Z of 3 rows; then follow the three roots, two zeros, X, Y, Z of
    /// the five smooth pictures, and the offset.
    pub fn lanes(&self) -> impl Iterator<Item = f32> {
        let of_class = |kernels: &Kernels| kernels.map(|kernel| Register::flat(&kernel).to_vec());
        self.kernels().iter().flat_map(of_class).flatten()
    }
}

/// Multiplications of a pixel of a smooth picture: three for what is tolerated, two for the weight of the centre, for each of eight neighbours
/// three squares and two for the weight, the weights times the three colours, and three by the reciprocal of the sum of weights.
const SMOOTHING: usize = 3 + 2 + 8 * (OUTPUTS + 2) + 9 * OUTPUTS + OUTPUTS;
/// Those of a class: gradients and their products, tents of five over three products in both directions, the mean, the noise, every strength that
/// may exist, and the orientation.
const CLASS: usize = 2 + 3 + 2 * 3 * 5 + 5 + 2 + MAX_STRENGTHS + 7;

/// Those of the roots: three channels, three products and as many square roots.
const OF_ROOTS: usize = 3 * 3 + 2 * ROOTS;

/// Those of the contrast around a refined pixel: down the columns and along the rows, four of light and four of darkness, and its share. A pixel that is
/// corrected has 78 more, and 19 for the comparison with its sample in a tile of two rows.
const OF_CONTRAST: usize = 2 * (4 + 4) + 1;

/// Multiplications per pixel of the smooth pictures, of the classes, of the kernels and of the contrast around highlights, as the portable loops are written, without those of rows that
/// are computed again for the next group of rows.
pub(in super::super) fn multiply_adds(axes: &RefinementAxes) -> [f64; 4] {
    let smooth = axes.pictures().into_iter().filter(|p| p.step.is_some());
    let smooth: f64 = smooth.map(|p| SMOOTHING as f64 * if p.is_half { 0.25 } else { 1.0 }).sum();
    [smooth, CLASS as f64, (OUTPUTS * COUNT + OF_ROOTS) as f64, OF_CONTRAST as f64]
}
