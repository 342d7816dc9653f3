//! The products alone, on allocations without spare memory, so that Miri and the address sanitizer detect every access beyond their end.

use super::super::inputs::{COUNT, OUTPUTS, SIDE_XZ, SIDE_Y};
use super::super::layout::{INPUTS_COARSE, INPUTS_FINE, Kernels, RowInputs, arranged};
use super::super::products::products;
use super::super::roots::ROOTS;
use crate::l3::vectors::PIXELS;
use crate::numeric::philox::Stream;
use crate::numeric::simd::{Set, with_widest};

/// Inputs of whole blocks of pixels.
fn inputs(cols: usize, mut exact: impl FnMut(usize) -> Vec<f32>) -> RowInputs {
    let mut inputs = RowInputs::default();
    inputs.y = exact((cols + SIDE_Y - 1) * SIDE_Y);
    inputs.xz = exact((cols + SIDE_XZ - 1) * 2 * SIDE_XZ);
    inputs.roots = exact(cols * ROOTS);
    inputs.fine = exact(cols * INPUTS_FINE);
    inputs.coarse = exact(cols / 2 * INPUTS_COARSE);
    inputs
}

#[test]
fn products_read_and_write_within_their_memory() {
    let mut random = Stream::new(7, 8, 10);
    // From a range of known length, so that no vector has more room than elements.
    let mut exact = |n: usize| -> Vec<f32> { (0..n).map(|_| random.uniform() as f32 - 0.5).collect() };
    let kernels: Vec<Kernels> = (0..5).map(|_| arranged(&exact(OUTPUTS * COUNT), &exact(OUTPUTS))).collect();
    for count in [1usize, 15, 16, 37] {
        let cols = count.next_multiple_of(PIXELS);
        let inputs = inputs(cols, &mut exact);
        let classes: Vec<u32> = (0..cols as u32).map(|x| (3 * x + 4) % 5).collect();
        let refined = |set: Set| {
            let mut out = [0; OUTPUTS].map(|_| vec![f32::NAN; count].into_boxed_slice());
            with_widest(set, || {
                products(&kernels, &classes, &inputs, out.each_mut().map(|plane| &mut **plane))
            });
            out
        };
        let expected = refined(Set::Plain);
        assert!(expected.iter().all(|plane| plane.iter().all(|v| v.is_finite())));
        for set in [Set::Avx2, Set::Avx512] {
            assert_eq!(refined(set), expected, "{count} pixels, {set:?}");
        }
    }
}

/// Vectors read no list that is one element short; the element exists in memory.
#[cfg(target_arch = "x86_64")]
#[test]
fn vectors_refuse_lists_that_are_too_short() {
    use crate::l3::vectors::Avx512;

    let cols = 2 * PIXELS;
    let kernels = [arranged(&[1.0; OUTPUTS * COUNT], &[0.0; OUTPUTS])];
    let classes = vec![0; cols];
    let lists: [fn(&mut RowInputs) -> &mut Vec<f32>; 5] =
        [|i| &mut i.y, |i| &mut i.xz, |i| &mut i.roots, |i| &mut i.fine, |i| &mut i.coarse];
    with_widest(Set::Avx512, || {
        let Some(set) = Avx512::detect() else { return };
        let written = |inputs: &RowInputs| {
            let mut out = [0; OUTPUTS].map(|_| vec![f32::NAN; cols]);
            let planes = out.each_mut().map(|plane| &mut **plane);
            super::super::x86::products(set, &kernels, &classes, inputs, planes);
            out.concat()
        };
        let ones = || inputs(cols, |n| vec![1.0; n]);
        assert!(written(&ones()).iter().all(|v| *v == COUNT as f32));
        for (i, list) in lists.into_iter().enumerate() {
            let mut short = ones();
            list(&mut short).pop();
            assert!(written(&short).iter().all(|v| v.is_nan()), "list {i}");
        }
    });
}
