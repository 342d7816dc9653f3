//! Sums of products of the light on patches of pixels.

use crate::numeric::products::add_products;
use crate::numeric::simd::Kernel;

/// The light on the pixels of a scene as coefficients.
#[derive(Clone, Copy)]
pub(super) struct PatchSource<'a> {
    /// Coefficients of each pixel, pixel after pixel.
    pub(super) values: &'a [f32],
    /// Number of coefficients of a pixel.
    pub(super) count: usize,
    /// Columns of the scene.
    pub(super) cols: usize,
    /// Side of a patch.
    pub(super) side: usize,
    /// Planes whose value at the middle pixel completes z.
    pub(super) targets: &'a [&'a [f32]],
}

/// Adds Σ z zᵀ of some patches to `sums`, z = (1, coefficients of every pixel, targets of the middle pixel).
pub(super) struct AddPatches<'a> {
    pub(super) source: PatchSource<'a>,
    /// The middle pixels.
    pub(super) pixels: &'a [u32],
    /// Room for as many z.
    pub(super) batch: &'a mut [f64],
    /// Length of z with its padding.
    pub(super) stride: usize,
    pub(super) sums: &'a mut [f64],
}

impl Kernel for AddPatches<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { source: PatchSource { values, count, cols, side, targets }, .. } = self;
        let Self { pixels, batch, stride, sums, .. } = self;
        let (half, width) = (side / 2, side * count);
        for (z, &pixel) in batch.chunks_exact_mut(stride).zip(pixels) {
            let (row, col) = (pixel as usize / cols, pixel as usize % cols);
            z.fill(0.0);
            z[0] = 1.0;
            for (r, out) in z[1..].chunks_exact_mut(width).take(side).enumerate() {
                let first = ((row + r - half) * cols + col - half) * count;
                out.iter_mut().zip(&values[first..first + width]).for_each(|(o, v)| *o = f64::from(*v));
            }
            for (o, plane) in z[1 + side * width..].iter_mut().zip(targets) {
                *o = f64::from(plane[pixel as usize]);
            }
        }
        add_products(batch, stride, sums);
    }
}
