//! The inner loops of each number type for the instruction sets of this machine.

use super::super::window::Window;
use super::fixed::Digital;
use super::portable;
use super::table::{Place, Run, Sample};
use crate::numeric::simd::dispatch;

/// An instruction set of this machine, with the code for it. All give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Simd {
    /// The baseline of the architecture.
    #[cfg(test)]
    Plain,
    /// Portable code, compiled for the widest vectors of this machine.
    Compiled,
    /// Intrinsics. Only [`Simd::all`] and [`Simd::best`] construct this variant.
    #[cfg(target_arch = "x86_64")]
    Avx512(super::x86::Avx512),
}

impl Simd {
    /// The fastest.
    pub(super) fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(set) = super::x86::Avx512::detect() {
            return Self::Avx512(set);
        }
        Self::Compiled
    }

    #[cfg(test)]
    pub(super) fn all() -> Vec<Self> {
        let mut sets = vec![Self::Plain, Self::Compiled];
        if Self::best() != Self::Compiled {
            sets.push(Self::best());
        }
        sets
    }
}

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
    fn interleave(simd: Simd, lines: &[&[Self]], columns: usize, out: &mut Vec<Self>);

    /// Computes every output at every pixel of a run.
    fn products(simd: Simd, run: &Run<'_, Self>, planes: &mut [&mut [f32]]);
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

    fn interleave(simd: Simd, lines: &[&[Self]], columns: usize, out: &mut Vec<Self>) {
        match simd {
            #[cfg(target_arch = "x86_64")]
            Simd::Avx512(set) => set.interleave_f32(lines, columns, out),
            _ => portable::interleave(lines, columns, out),
        }
    }

    fn products(simd: Simd, run: &Run<'_, Self>, planes: &mut [&mut [f32]]) {
        match simd {
            #[cfg(test)]
            Simd::Plain => portable::Float(run, planes).plain(),
            Simd::Compiled => dispatch(portable::Float(run, planes)),
            #[cfg(target_arch = "x86_64")]
            Simd::Avx512(set) => set.products_f32(run, planes),
        }
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

    fn interleave(simd: Simd, lines: &[&[Self]], columns: usize, out: &mut Vec<Self>) {
        match simd {
            #[cfg(target_arch = "x86_64")]
            Simd::Avx512(set) => set.interleave_i16(lines, columns, out),
            _ => portable::interleave(lines, columns, out),
        }
    }

    fn products(simd: Simd, run: &Run<'_, Self>, planes: &mut [&mut [f32]]) {
        match simd {
            #[cfg(test)]
            Simd::Plain => portable::Fixed(run, planes).plain(),
            Simd::Compiled => dispatch(portable::Fixed(run, planes)),
            #[cfg(target_arch = "x86_64")]
            Simd::Avx512(set) => set.products_i16(run, planes),
        }
    }
}
