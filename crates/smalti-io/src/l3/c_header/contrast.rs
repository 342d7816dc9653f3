//! Contrast and edges by integers.

use smalti::l3::{ContrastPairs, Pipeline};

/// Longest shift of the mosaic to itself by which gradients are taken in 64 bits.
pub(super) const MAX_SHIFT: usize = 1000;

/// Fractional bits of the squared contrast, and those that the last coefficient has beyond them.
const BITS: u32 = 16;
const MORE_BITS: u32 = 24;
/// What any number may reach: a bit of 64 is left free for rounding.
const LIMIT: f64 = 9.2e18;

/// When a patch is flat: `2^bits · contrast² ≤ c₀ + light (c₁ + light c₂ / 2^more_bits)`, where contrast is the sum of the
/// differences and light that of the samples above black.
pub(super) struct Flat {
    pub(super) coefficients: [u64; 3],
    pub(super) bits: u32,
    pub(super) more_bits: u32,
}

/// The limit of the axes for sums of digital numbers; `None` when it needs more than 64 bits.
pub(super) fn flat(pipeline: &Pipeline) -> Option<Flat> {
    let axes = pipeline.axes();
    let range = pipeline.white_level() - pipeline.black_level();
    let (taps, [v0, v1, v2]) = (axes.taps() as f64, axes.contrast_limit());
    let count: usize = axes.contrast_pairs().iter().map(ContrastPairs::count).sum();
    let (count, brightest) = (count as f64, taps * 65535.0);
    // Mean difference = contrast / (count range), mean response = light / (taps range).
    let square = count * count;
    let c = [v0 * square * range * range, v1 * square * range / taps, v2 * square / (taps * taps)];
    let most = (count * 65535.0).powi(2).max(c[0] + brightest * (c[1] + brightest * c[2]));
    let bits = (0..=BITS).rev().find(|&b| most * f64::from(1u32 << b) < LIMIT)?;
    let scale = f64::from(1u32 << bits);
    let more_bits =
        (0..=MORE_BITS).rev().find(|&m| c[2] * brightest * scale * f64::from(1u32 << m) < LIMIT)?;
    let rounded = [c[0] * scale, c[1] * scale, c[2] * scale * f64::from(1u32 << more_bits)];
    Some(Flat { coefficients: rounded.map(|v| v.round() as u64), bits, more_bits })
}

/// Both ends of two differences around a pixel: row, column, row, column.
pub(super) fn ends(pairs: &[ContrastPairs; 2]) -> [[isize; 4]; 2] {
    pairs.map(|p| {
        let [row, col] = p.shift.map(|s| -s.div_euclid(2));
        [row, col, row + p.shift[0], col + p.shift[1]]
    })
}

/// The matrix from differences to the gradient in rows and columns, times [`determinant`].
pub(super) fn gradient(pairs: &[ContrastPairs; 2]) -> [[isize; 2]; 2] {
    let [[a, b], [c, d]] = pairs.map(|p| p.shift);
    [[d, -b], [-c, a]]
}

/// The common factor of [`gradient`], on which directions do not depend.
pub(super) fn determinant(pairs: &[ContrastPairs; 2]) -> isize {
    let [[a, b], [c, d]] = pairs.map(|p| p.shift);
    a * d - b * c
}
