//! Kernels in the layout of the inner loop, and the products of a row.

use super::super::blocks::LANES;
#[cfg(target_arch = "x86_64")]
use super::super::render::Avx512;
use super::super::render::{PIXELS, Register, tree};
use super::inputs::{COUNT, Lines, SIDE_XZ, SIDE_Y};
use super::refinement::OUTPUTS;
use super::stages::{FINE, MARGIN, SCALES, Stages};
use crate::numeric::simd::{Kernel, dispatch};

/// Registers of an output's kernel: those of the two patches, and one for the smooth pictures.
pub(super) const REGISTERS: usize = (PATCH_Y + PATCH_XZ).div_ceil(LANES) + 1;
/// The kernels of a class: outputs × registers.
pub(super) type Kernels = [[Register<f32, LANES>; REGISTERS]; OUTPUTS];

// The inputs in the order of lanes: the patch of Y column by column, that of X and Z (those of X, then those of Z in each column), and in
// the last register the fine smooth pictures, the coarse ones and 1, the input of the offset.
pub(super) const PATCH_Y: usize = SIDE_Y * SIDE_Y;
pub(super) const PATCH_XZ: usize = 2 * SIDE_XZ * SIDE_XZ;
pub(super) const INPUTS_FINE: usize = 3 * FINE;
pub(super) const INPUTS_COARSE: usize = 3 * (SCALES - FINE) + 1;
const FIRST_SMOOTH: usize = LANES * (REGISTERS - 1);
const OFFSET: usize = LANES * REGISTERS - 1;

/// The lane of an input in the order of [`Lines::read`].
fn lane_of(input: usize) -> usize {
    let in_patch = |i: usize, side: usize| [i / side, i % side];
    if let Some(smooth) = input.checked_sub(PATCH_Y + PATCH_XZ) {
        return FIRST_SMOOTH + smooth;
    }
    match input.checked_sub(PATCH_Y) {
        None => {
            let [row, col] = in_patch(input, SIDE_Y);
            col * SIDE_Y + row
        }
        Some(i) => {
            let (is_z, [row, col]) = (i / SIDE_XZ.pow(2), in_patch(i % SIDE_XZ.pow(2), SIDE_XZ));
            PATCH_Y + col * 2 * SIDE_XZ + is_z * SIDE_XZ + row
        }
    }
}

/// The kernels of a class from weights in the order output, input, and offsets.
pub(super) fn arranged(weights: &[f32], offsets: &[f32]) -> Kernels {
    let mut kernels = [[Register([0.0; LANES]); REGISTERS]; OUTPUTS];
    for ((kernel, weights), offset) in kernels.iter_mut().zip(weights.chunks_exact(COUNT)).zip(offsets) {
        let lanes = Register::flat_mut(kernel);
        weights.iter().enumerate().for_each(|(input, weight)| lanes[lane_of(input)] = *weight);
        lanes[OFFSET] = *offset;
    }
    kernels
}

/// The weights of a class in the order output, input.
pub(super) fn weights_of(kernels: &Kernels) -> impl Iterator<Item = f32> {
    kernels.iter().flat_map(|kernel| (0..COUNT).map(|input| Register::flat(kernel)[lane_of(input)]))
}

/// The inputs of a row of pixels. Each list has those of the first pixel, then those of the next.
#[derive(Debug, Default)]
pub(super) struct RowInputs {
    /// Columns of patches, from that two pixels to the left of the first pixel on.
    pub(super) y: Vec<f32>,
    /// The same, from one pixel to the left on.
    pub(super) xz: Vec<f32>,
    pub(super) fine: Vec<f32>,
    /// For every second pixel.
    pub(super) coarse: Vec<f32>,
    /// The row of the coarse pictures that is read.
    row: Option<usize>,
    ones: Vec<f32>,
}

impl RowInputs {
    /// Reads a row of `cols` pixels.
    pub(super) fn read(&mut self, stages: &Stages, row: usize, cols: usize) {
        let Lines { neighbours, smooth } = Lines::of(stages, row);
        let (y, xz) = neighbours.split_at(SIDE_Y);
        let (fine, coarse) = smooth.split_at(INPUTS_FINE);
        let from = |lines: &[&[f32]], margin: usize, columns: usize, out: &mut Vec<f32>| {
            let mut all = [&[] as &[f32]; INPUTS_FINE + INPUTS_COARSE];
            let all = &mut all[..lines.len()];
            all.iter_mut().zip(lines).for_each(|(all, line)| *all = &line[MARGIN - margin..]);
            interleave(all, columns, out);
        };
        let cols = cols.next_multiple_of(PIXELS);
        from(y, SIDE_Y / 2, cols + SIDE_Y - 1, &mut self.y);
        from(xz, SIDE_XZ / 2, cols + SIDE_XZ - 1, &mut self.xz);
        from(fine, 0, cols, &mut self.fine);
        if self.row != Some(row / 2) {
            self.ones.resize(MARGIN + (cols / 2).next_multiple_of(LANES), 1.0);
            let mut all = [&*self.ones; INPUTS_COARSE];
            all[..coarse.len()].copy_from_slice(coarse);
            from(&all, 0, cols / 2, &mut self.coarse);
            self.row = Some(row / 2);
        }
    }
}

fn interleave(lines: &[&[f32]], columns: usize, out: &mut Vec<f32>) {
    #[cfg(target_arch = "x86_64")]
    if let Some(set) = Avx512::detect() {
        return set.interleave_f32(lines, columns, out);
    }
    super::super::render::interleave(lines, columns, out);
}

/// Writes X, Y and Z of a row: Σ weight · input over the kernels of each pixel's class. `classes` are padded to whole vectors of pixels.
pub(super) fn products(kernels: &[Kernels], classes: &[u32], inputs: &RowInputs, out: [&mut [f32]; OUTPUTS]) {
    #[cfg(target_arch = "x86_64")]
    if let Some(set) = Avx512::detect() {
        return super::x86::products(set, kernels, classes, inputs, out);
    }
    dispatch(Products { kernels, classes, inputs, out });
}

/// The portable loop, which defines the order of summation: lane i sums the products of inputs i, i + 16, …, and a fixed tree the lanes.
struct Products<'a> {
    kernels: &'a [Kernels],
    classes: &'a [u32],
    inputs: &'a RowInputs,
    out: [&'a mut [f32]; OUTPUTS],
}

impl Kernel for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { kernels, classes, inputs, mut out } = self;
        let mut registers = [Register([0.0; LANES]); REGISTERS];
        for (col, &class) in classes.iter().enumerate().take(out[0].len()) {
            let Some(kernels) = kernels.get(class as usize) else { continue };
            let lanes = Register::flat_mut(&mut registers);
            let mut copy = |from: &[f32], each: usize, at: usize, to: usize, count: usize| {
                if let Some(found) = from.get(at * each..at * each + count) {
                    lanes[to..to + count].copy_from_slice(found);
                }
            };
            copy(&inputs.y, SIDE_Y, col, 0, PATCH_Y);
            copy(&inputs.xz, 2 * SIDE_XZ, col, PATCH_Y, PATCH_XZ);
            copy(&inputs.fine, INPUTS_FINE, col, FIRST_SMOOTH, INPUTS_FINE);
            copy(&inputs.coarse, INPUTS_COARSE, col / 2, FIRST_SMOOTH + INPUTS_FINE, INPUTS_COARSE);
            for (kernel, plane) in kernels.iter().zip(&mut out) {
                let mut sums = [0.0f32; LANES];
                for (register, (values, weights)) in registers.iter().zip(kernel).enumerate() {
                    for ((sum, value), weight) in sums.iter_mut().zip(values.0).zip(weights.0) {
                        *sum = if register == 0 { value * weight } else { *sum + value * weight };
                    }
                }
                plane[col] = tree(&sums);
            }
        }
    }
}
