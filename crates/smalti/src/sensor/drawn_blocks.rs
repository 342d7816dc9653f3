//! Random numbers of the photodiodes of a window, drawn in blocks of lanes.

use crate::numeric::Rect;
use crate::numeric::poisson::LANES;
use crate::numeric::simd::Kernel;

/// What draws the random numbers of a block of photodiodes.
pub(super) trait BlockSource: Copy {
    type Block;

    /// The block from row, column and plane. Implementations are `#[inline(always)]`, as all that a [`Kernel`] calls.
    fn block(self, at: (u32, u32, u32)) -> Self::Block;
}

/// The blocks of every photodiode of a window: for each plane, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DrawnBlocks<B> {
    pub(super) window: Rect,
    pub(super) blocks: Vec<B>,
}

impl<B> DrawnBlocks<B> {
    /// The block from row, column and plane within the window, whose column is a multiple of [`LANES`] from that of the window.
    #[inline(always)]
    pub(super) fn at(&self, (row, col, plane): (u32, u32, u32)) -> &B {
        let (row, col) = (row as usize - self.window.row, col as usize - self.window.col);
        debug_assert!(col.is_multiple_of(LANES), "{col}");
        let blocks_per_row = self.window.cols.div_ceil(LANES);
        &self.blocks[(plane as usize * self.window.rows + row) * blocks_per_row + col / LANES]
    }
}

/// Draws the blocks of a row of a window.
pub(super) struct DrawRow<S> {
    pub(super) source: S,
    pub(super) window: Rect,
    /// The row of the window.
    pub(super) row: usize,
    pub(super) plane: usize,
}

impl<S: BlockSource> Kernel for DrawRow<S> {
    type Output = Vec<S::Block>;

    #[inline(always)]
    fn run(self) -> Vec<S::Block> {
        let Self { source, window, row, plane } = self;
        let mut blocks = Vec::with_capacity(window.cols.div_ceil(LANES));
        // A loop, because `collect` is not inlined and would be compiled for the baseline.
        for col in (window.col..window.col + window.cols).step_by(LANES) {
            blocks.push(source.block(((window.row + row) as u32, col as u32, plane as u32)));
        }
        blocks
    }
}
