//! What the inner loops of both stages share: aligned registers, inputs laid out for them, and the order in which lanes are summed.

#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(target_arch = "x86_64")]
pub(super) use x86::{Avx512, for_side, quarters_f32, quarters_i32, store, whole_f32, whole_i32};

/// 64 bytes aligned to a cache line: reading a register that spans two lines takes twice as long.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Register<T, const LANES: usize>(pub(super) [T; LANES]);

impl<T, const LANES: usize> Register<T, LANES> {
    /// The lanes of consecutive registers.
    #[inline(always)]
    pub(super) fn flat(registers: &[Self]) -> &[T] {
        const { assert!(size_of::<Self>() == LANES * size_of::<T>()) }
        // SAFETY: a register is its lanes and nothing else.
        unsafe { std::slice::from_raw_parts(registers.as_ptr().cast(), registers.len() * LANES) }
    }

    /// Like [`Register::flat`], but mutable.
    #[inline(always)]
    pub(super) fn flat_mut(registers: &mut [Self]) -> &mut [T] {
        const { assert!(size_of::<Self>() == LANES * size_of::<T>()) }
        // SAFETY: as above.
        unsafe { std::slice::from_raw_parts_mut(registers.as_mut_ptr().cast(), registers.len() * LANES) }
    }
}

/// Pixels per iteration of the inner loops.
pub(super) const PIXELS: usize = 16;

/// `out[x * lines + i] = lines[i][x]` for at least `columns` columns. Lines extend a register beyond the last column.
pub(super) fn interleave_f32(lines: &[&[f32]], columns: usize, out: &mut Vec<f32>) {
    #[cfg(target_arch = "x86_64")]
    if let Some(set) = Avx512::detect() {
        return set.interleave_f32(lines, columns, out);
    }
    interleave(lines, columns, out);
}

/// As [`interleave_f32`].
pub(super) fn interleave_i16(lines: &[&[i16]], columns: usize, out: &mut Vec<i16>) {
    #[cfg(target_arch = "x86_64")]
    if let Some(set) = Avx512::detect() {
        return set.interleave_i16(lines, columns, out);
    }
    interleave(lines, columns, out);
}

/// The same for any number type and processor; zero beyond the end of a line.
fn interleave<S: Copy + Default>(lines: &[&[S]], columns: usize, out: &mut Vec<S>) {
    out.clear();
    out.resize(columns * lines.len(), S::default());
    for (i, line) in lines.iter().enumerate() {
        let places = out.iter_mut().skip(i).step_by(lines.len());
        places.zip(*line).for_each(|(o, &v)| *o = v);
    }
}

/// The sum of sixteen partial sums by a fixed binary tree, which vectors of pixels can evaluate together.
#[inline(always)]
pub(super) fn tree(p: &[f32; 16]) -> f32 {
    let four = |i: usize| (p[i] + p[i + 2]) + (p[i + 1] + p[i + 3]);
    (four(0) + four(4)) + (four(8) + four(12))
}
