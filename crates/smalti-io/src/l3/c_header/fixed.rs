//! Kernels in fixed point. It follows the rule of the fixed-point renderer of the library and gives way to it once kernels can
//! be had from there.

use smalti::l3::Pipeline;

/// Kernels of 16 bits for digital numbers, sums of 32 bits.
pub(super) struct Fixed {
    /// What is taken from every sample.
    pub(super) black: i32,
    /// `output = sum / 2^shift`, the same for all classes.
    pub(super) shift: u32,
    /// Ordered class, output, tap.
    pub(super) weights: Vec<i16>,
    /// Ordered class, output.
    pub(super) offsets: Vec<i32>,
}

/// Largest number of fractional bits.
const MAX_SHIFT: u32 = 30;
/// Largest sum of the sizes of a kernel's weights.
const MAX_SUM: f64 = 65535.0;

/// The finest quantisation by which no sum overflows 32 bits, whatever the 16-bit samples; `None` when there is none.
pub(super) fn quantise(pipeline: &Pipeline) -> Option<Fixed> {
    (0..=MAX_SHIFT).rev().find_map(|shift| at(pipeline, shift))
}

fn at(pipeline: &Pipeline, shift: u32) -> Option<Fixed> {
    let (black, white) = (pipeline.black_level(), pipeline.white_level());
    let scale = f64::from(1u32 << shift);
    let gain = 1.0 / (white - black);
    let whole = black.round();
    let largest = (65535.0 - whole).abs().max(whole.abs());
    let taps = pipeline.axes().taps();
    let kernels = pipeline.kernels();
    let mut out = Fixed { black: whole as i32, shift, weights: Vec::new(), offsets: Vec::new() };
    for (weights, &offset) in kernels.weights.chunks_exact(taps).zip(&kernels.offsets) {
        let rounded = weights.iter().map(|&w| (f64::from(w) * gain * scale).round());
        let size: f64 = rounded.clone().map(f64::abs).sum();
        // What the black level has after its point goes into the offset.
        let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        let offset = ((f64::from(offset) - total * gain * (black - whole)) * scale).round();
        let fits = size <= MAX_SUM
            && rounded.clone().all(|k| k.abs() <= f64::from(i16::MAX))
            && size * largest + offset.abs() <= f64::from(i32::MAX);
        if !fits {
            return None;
        }
        out.weights.extend(rounded.map(|k| k as i16));
        out.offsets.push(offset as i32);
    }
    Some(out)
}
