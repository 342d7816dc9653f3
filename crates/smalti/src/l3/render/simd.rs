//! The inner loops of each number type for the instruction sets of this machine.

#[cfg(target_arch = "x86_64")]
use super::super::vectors::Avx512;
use super::super::vectors::{interleave_f32, interleave_i16};
use super::super::window::Window;
use super::fixed::Digital;
use super::portable;
use super::table::{Place, Run, Sample};
#[cfg(target_arch = "x86_64")]
use super::x86;
use crate::numeric::simd::dispatch;

/// A number type with its inner loops.
pub(super) trait Rendering: Sample {
    /// The source of rows other than the window that is classified.
    type Reader<'a>: Sync;

    /// The window from which patches are taken: `window`, or `own` after it is filled.
    fn window<'w>(
        reader: &Self::Reader<'_>,
        window: &'w Window,
        own: &'w mut Window<Self>,
        place: &Place,
    ) -> &'w Window<Self>;

    /// `out[x * lines + i] = lines[i][x]` for at least `columns` columns. Lines extend a register beyond the
    /// last column.
    fn interleave(lines: &[&[Self]], columns: usize, out: &mut Vec<Self>);

    /// Computes every output at every pixel of a run.
    fn products(run: &Run<'_, Self>, planes: &mut [&mut [f32]]);
}

impl Rendering for f32 {
    type Reader<'a> = ();

    fn window<'w>(
        (): &Self::Reader<'_>,
        window: &'w Window,
        _: &'w mut Window<Self>,
        _: &Place,
    ) -> &'w Window<Self> {
        window
    }

    fn interleave(lines: &[&[Self]], columns: usize, out: &mut Vec<Self>) {
        interleave_f32(lines, columns, out);
    }

    fn products(run: &Run<'_, Self>, planes: &mut [&mut [f32]]) {
        #[cfg(target_arch = "x86_64")]
        if let Some(set) = Avx512::detect() {
            return x86::products_f32(set, run, planes);
        }
        dispatch(portable::Float(run, planes));
    }
}

impl Rendering for i16 {
    type Reader<'a> = Digital<'a>;

    fn window<'w>(
        reader: &Self::Reader<'_>,
        _: &'w Window,
        own: &'w mut Window<Self>,
        place: &Place,
    ) -> &'w Window<Self> {
        reader.fill(own, place);
        own
    }

    fn interleave(lines: &[&[Self]], columns: usize, out: &mut Vec<Self>) {
        interleave_i16(lines, columns, out);
    }

    fn products(run: &Run<'_, Self>, planes: &mut [&mut [f32]]) {
        #[cfg(target_arch = "x86_64")]
        if let Some(set) = Avx512::detect() {
            return x86::products_i16(set, run, planes);
        }
        dispatch(portable::Fixed(run, planes));
    }
}
