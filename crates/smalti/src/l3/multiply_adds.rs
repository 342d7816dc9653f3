//! What a pixel costs in multiply-adds.

use super::refine::multiply_adds;
use super::{Pipeline, Textures};

/// The multiply-adds of a step of rendering.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MultiplyAdds {
    /// The step.
    pub step: &'static str,
    /// Multiplications per pixel; each is followed by at most one addition.
    pub per_pixel: f64,
}

impl Pipeline {
    /// The multiplications per pixel of every step in single precision, as the portable loops are written: sums that neighbouring patches share
    /// count once. Steps that pad their inputs to whole vectors multiply by zeros as well, which do not count.
    #[must_use]
    pub fn multiply_adds(&self) -> Vec<MultiplyAdds> {
        let axes = self.axes();
        // The normalised sample, and the mean of the patch.
        let mut classes = 2;
        if axes.textures() != Textures::None {
            // The square of the contrast, and what it is compared with.
            classes += 3;
        }
        if axes.textures() == Textures::Oriented {
            // In each row of the patch two gradients and three products; then the coherence and the orientation.
            classes += 7 * axes.side() + 5;
        }
        let kernels = axes.taps() * self.outputs().len();
        let first = [("classes", classes as f64), ("kernels", kernels as f64)];
        let second = self.refinement().map(|refinement| {
            let [smooth, classes, kernels, contrast] = multiply_adds(refinement.axes());
            [
                ("smooth pictures", smooth),
                ("classes of the second stage", classes),
                ("kernels of the second stage", kernels),
                ("contrast of highlights", contrast),
            ]
        });
        let steps = first.into_iter().chain(second.into_iter().flatten());
        steps.map(|(step, per_pixel)| MultiplyAdds { step, per_pixel }).collect()
    }
}
