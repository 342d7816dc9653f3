//! What a pixel costs.

use smalti::l3::{ContrastPairs, Pipeline, Textures};

/// What the first stage of the exported reference in integers does for a pixel, reading and indexing apart, and the memory of its tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operations {
    /// Multiplications for the outputs alone: taps × outputs.
    pub kernel_multiplications: u64,
    /// All multiplications.
    pub multiplications: u64,
    /// Additions and subtractions.
    pub additions: u64,
    /// Comparisons and absolute values.
    pub comparisons: u64,
    /// Bytes of kernels (16 bits), offsets, shifts, thresholds and the tile.
    pub table_bytes: u64,
}

/// Counts what a pixel of the first stage of the exported reference in integers costs, every sum taken anew. Of an unclipped patch: what follows from clipped
/// channels costs `saturations` comparisons more. Clamping samples to 16 bits is left out: those of a sensor fit.
#[must_use]
pub fn operations(pipeline: &Pipeline) -> Operations {
    let axes = pipeline.axes();
    let (taps, outputs) = (axes.taps() as u64, pipeline.outputs().len() as u64);
    let levels = axes.level_count() as u64;
    let kernel_multiplications = taps * outputs;
    let mut multiplications = kernel_multiplications;
    // Outputs, samples less black, the sum of the patch.
    let mut additions = taps * outputs + taps + (taps - 1);
    let mut comparisons = taps + (levels - 1);
    let mut small_tables = axes.mosaic().cells().len() as u64 + 4 * pipeline.saturations().len() as u64;
    small_tables += 4 * axes.levels().len() as u64 * (levels - 1);
    if axes.textures() != Textures::None {
        let pairs: usize = axes.contrast_pairs().iter().map(ContrastPairs::count).sum();
        // The square, two of the polynomial; a difference and a sum for each pair, the light, two of the polynomial.
        multiplications += 3;
        additions += 2 * pairs as u64 + 3;
        comparisons += pairs as u64 + 2;
        small_tables += 2 * 12 + 3 * 8;
    }
    if axes.textures() == Textures::Oriented {
        // For each tap two differences, a gradient, three products and their sums; then the eigenvalues and the direction.
        multiplications += taps * 7 + 4;
        additions += taps * 7 + 3;
        comparisons += 5;
        small_tables += 2 * 12;
    }
    let classes = pipeline.classes().len() as u64;
    let table_bytes = classes * (outputs * (2 * taps + 4) + 1) + small_tables;
    Operations { kernel_multiplications, multiplications, additions, comparisons, table_bytes }
}
