//! Registers and what is done with them on any processor.

/// 64 bytes aligned to a cache line: reading a register that spans two lines takes twice as long.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(in super::super) struct Register<T, const LANES: usize>(pub(in super::super) [T; LANES]);

impl<T, const LANES: usize> Register<T, LANES> {
    /// The lanes of consecutive registers.
    #[inline(always)]
    pub(in super::super) fn flat(registers: &[Self]) -> &[T] {
        const { assert!(size_of::<Self>() == LANES * size_of::<T>()) }
        // SAFETY: a register is its lanes and nothing else.
        unsafe { std::slice::from_raw_parts(registers.as_ptr().cast(), registers.len() * LANES) }
    }

    /// Like [`Register::flat`], but mutable.
    #[inline(always)]
    pub(in super::super) fn flat_mut(registers: &mut [Self]) -> &mut [T] {
        const { assert!(size_of::<Self>() == LANES * size_of::<T>()) }
        // SAFETY: as above.
        unsafe { std::slice::from_raw_parts_mut(registers.as_mut_ptr().cast(), registers.len() * LANES) }
    }
}

/// Pixels per iteration of the inner loops.
pub(in super::super) const PIXELS: usize = 16;

/// `out[x * lines + i] = lines[i][x]` for `columns` columns; zero beyond the end of a line.
pub(super) fn interleave<S: Copy + Default>(lines: &[&[S]], columns: usize, out: &mut Vec<S>) {
    out.clear();
    out.resize(columns * lines.len(), S::default());
    for (i, line) in lines.iter().enumerate() {
        let places = out.iter_mut().skip(i).step_by(lines.len());
        places.zip(*line).for_each(|(o, &v)| *o = v);
    }
}

/// The sum of sixteen partial sums by a fixed binary tree, which vectors of pixels can evaluate together.
#[inline(always)]
pub(in super::super) fn tree(p: &[f32; 16]) -> f32 {
    let four = |i: usize| (p[i] + p[i + 2]) + (p[i + 1] + p[i + 3]);
    (four(0) + four(4)) + (four(8) + four(12))
}
