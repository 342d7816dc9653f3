//! Kernels and inputs in the layout of the inner loop.

use super::super::blocks::LANES;
use super::super::vectors::{PIXELS, Register, interleave_f32};
use super::inputs::{COUNT, LINEAR, Lines, OUTPUTS, SIDE_XZ, SIDE_Y, SMOOTH};
use super::roots::{ROOTS, roots_of_row};
use super::stages::{FINE, MARGIN, SCALES, Stages};

/// Registers of an output's kernel: those of the two patches and of the roots, and one for the smooth pictures.
pub(super) const REGISTERS: usize = (PATCH_Y + PATCH_XZ + ROOTS).div_ceil(LANES) + 1;
/// The kernels of a class: outputs × registers.
pub(super) type Kernels = [[Register<f32, LANES>; REGISTERS]; OUTPUTS];

// The inputs in the order of lanes: the patch of Y column by column, that of X and Z (those of X, then those of Z in each column), the roots, and in
// the last register the fine smooth pictures, the coarse ones and 1, the input of the offset.
pub(super) const PATCH_Y: usize = SIDE_Y * SIDE_Y;
pub(super) const PATCH_XZ: usize = 2 * SIDE_XZ * SIDE_XZ;
pub(super) const FIRST_ROOT: usize = PATCH_Y + PATCH_XZ;
pub(super) const INPUTS_FINE: usize = 3 * FINE;
pub(super) const INPUTS_COARSE: usize = 3 * (SCALES - FINE) + 1;
pub(super) const FIRST_SMOOTH: usize = LANES * (REGISTERS - 1);
const OFFSET: usize = LANES * REGISTERS - 1;

/// The lane of an input in the order of [`Lines::read`].
fn lane_of(input: usize) -> usize {
    let in_patch = |i: usize, side: usize| [i / side, i % side];
    if let Some(root) = input.checked_sub(LINEAR) {
        return FIRST_ROOT + root;
    }
    if let Some(smooth) = input.checked_sub(SMOOTH) {
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
    pub(super) roots: Vec<f32>,
    pub(super) fine: Vec<f32>,
    /// For every second pixel.
    pub(super) coarse: Vec<f32>,
    /// The row of the coarse pictures that is read.
    row: Option<usize>,
    ones: Vec<f32>,
    /// The roots before they are interleaved.
    root_lines: [Vec<f32>; ROOTS],
}

impl RowInputs {
    /// Reads a row of `cols` pixels.
    pub(super) fn read(&mut self, stages: &Stages, row: usize, cols: usize) {
        let lines = Lines::of(stages, row);
        let colours = lines.of_roots();
        let Lines { neighbours, smooth } = lines;
        let (y, xz) = neighbours.split_at(SIDE_Y);
        let (fine, coarse) = smooth.split_at(INPUTS_FINE);
        let from = |lines: &[&[f32]], margin: usize, columns: usize, out: &mut Vec<f32>| {
            let mut all = [&[] as &[f32]; INPUTS_FINE + INPUTS_COARSE];
            let all = &mut all[..lines.len()];
            all.iter_mut().zip(lines).for_each(|(all, line)| *all = &line[MARGIN - margin..]);
            interleave_f32(all, columns, out);
        };
        let cols = cols.next_multiple_of(PIXELS);
        from(y, SIDE_Y / 2, cols + SIDE_Y - 1, &mut self.y);
        from(xz, SIDE_XZ / 2, cols + SIDE_XZ - 1, &mut self.xz);
        from(fine, 0, cols, &mut self.fine);
        let padded = MARGIN + cols + LANES;
        self.root_lines.iter_mut().for_each(|line| line.resize(padded, 0.0));
        roots_of_row(colours.map(|line| &line[..padded]), &mut self.root_lines);
        from(&self.root_lines.each_ref().map(Vec::as_slice), 0, cols, &mut self.roots);
        if self.row != Some(row / 2) {
            self.ones.resize(MARGIN + (cols / 2).next_multiple_of(LANES), 1.0);
            let mut all = [&*self.ones; INPUTS_COARSE];
            all[..coarse.len()].copy_from_slice(coarse);
            from(&all, 0, cols / 2, &mut self.coarse);
            self.row = Some(row / 2);
        }
    }
}
