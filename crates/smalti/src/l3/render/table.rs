//! Kernels as the inner loops read them: the taps of a patch column by column, padded to whole registers.

use std::collections::HashMap;

use super::super::window::Window;
use super::portable;

/// An instruction set that this machine has, and the code for it. All give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Simd {
    /// What any processor of the architecture runs.
    #[cfg(test)]
    Plain,
    /// The same code, compiled for the widest vectors that this machine has.
    Compiled,
    /// Intrinsics. Only [`Simd::all`] and [`Simd::best`] make one.
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

/// 64 bytes that begin where a line of the cache does: a register read across two lines takes twice as long.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Register<T, const LANES: usize>(pub(super) [T; LANES]);

/// Numbers that a path multiplies: `f32`, or `i16` in fixed point.
pub(super) trait Sample: Copy + Default + Send + Sync + std::fmt::Debug + 'static {
    /// How many fill a register.
    const LANES: usize;
    /// What stands in the patch beyond its last tap, for offsets to be multiplied with.
    const CONSTANTS: &'static [Self];
    /// Lanes on the boundary of a register.
    type Register: Copy + Send + Sync + std::fmt::Debug;
    /// Where rows are read besides the window that is classified.
    type Reader<'a>: Sync;

    fn register(lanes: &[Self]) -> Self::Register;
    /// Equal for equal numbers.
    fn bits(self) -> u32;

    /// The window that patches are taken from, `window` or `own`, which is filled then.
    fn window<'w>(
        reader: &Self::Reader<'_>,
        window: &'w Window,
        own: &'w mut Window<Self>,
        place: &Place,
    ) -> &'w Window<Self>;

    /// `out[x * lines + i] = lines[i][x]` for `columns` columns at least. Lines reach a register beyond the last column.
    fn interleave(simd: Simd, lines: &[&[Self]], columns: usize, out: &mut Vec<Self>);

    /// Value of every output at every pixel of a run.
    fn products(simd: Simd, run: &Run<'_, Self>, planes: &mut [&mut [f32]]);
}

/// Which rows of an image a window holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) size: [usize; 2],
    pub(super) first: usize,
    pub(super) rows: usize,
    pub(super) half: usize,
    pub(super) tile: [usize; 2],
}

/// Pixels beside each other.
#[derive(Debug)]
pub(super) struct Run<'a, S: Sample> {
    pub(super) table: &'a Table<S>,
    /// Columns of patches one after another, those of the first pixel first.
    pub(super) patches: &'a [S],
    /// The first register of the kernels of each pixel, in fixed point an [`Entry`](super::fixed::Entry); filled up to whole vectors
    /// of [`portable::PIXELS`] with any kernels.
    pub(super) kernels: &'a [u32],
    /// Where in the planes the first pixel lies.
    pub(super) at: usize,
    /// Number of pixels.
    pub(super) count: usize,
}

/// Distinct kernels.
#[derive(Debug, Clone)]
pub(super) struct Table<S: Sample> {
    /// Ordered kernel, output, register.
    pub(super) registers: Vec<S::Register>,
    /// Side of the patch.
    pub(super) side: usize,
    /// The last register of a patch with nothing but what stands beyond its last tap.
    pub(super) beyond: S::Register,
    /// In fixed point, factor from sums to values of kernels without binary places.
    pub(super) scale: f32,
}

impl<S: Sample> Table<S> {
    /// From `weights` ordered class, output, tap (row order), and `offsets(class · outputs + output)`, which are multiplied with
    /// [`Sample::CONSTANTS`]. Returns as well at which register the kernels of each class begin: those that are equal are kept
    /// once.
    pub(super) fn new(
        weights: &[S],
        offsets: impl Fn(usize) -> Vec<S>,
        side: usize,
        outputs: usize,
        scale: f32,
    ) -> (Self, Vec<u32>) {
        let taps = side * side;
        let per_output = registers_of::<S>(side);
        let mut registers = Vec::new();
        let mut places: HashMap<Vec<u32>, u32> = HashMap::new();
        let mut lanes = vec![S::default(); per_output * S::LANES];
        let mut of_class = Vec::new();
        for (class, weights) in weights.chunks_exact((outputs * taps).max(1)).enumerate() {
            let tails: Vec<Vec<S>> = (0..outputs).map(|o| offsets(class * outputs + o)).collect();
            let key = weights.iter().chain(tails.iter().flatten()).map(|v| v.bits()).collect();
            let next = registers.len() as u32;
            let place = *places.entry(key).or_insert(next);
            of_class.push(place);
            if place < next {
                continue;
            }
            for (weights, tail) in weights.chunks_exact(taps).zip(tails) {
                lanes.fill(S::default());
                for (tap, &w) in weights.iter().enumerate() {
                    lanes[tap % side * side + tap / side] = w;
                }
                lanes[taps..].iter_mut().zip(tail).for_each(|(lane, v)| *lane = v);
                registers.extend(lanes.chunks_exact(S::LANES).map(S::register));
            }
        }
        let mut beyond = vec![S::default(); S::LANES];
        beyond[taps % S::LANES..].iter_mut().zip(S::CONSTANTS).for_each(|(lane, &v)| *lane = v);
        (Self { registers, side, beyond: S::register(&beyond), scale }, of_class)
    }
}

/// Registers that hold a patch and the constants beyond it.
pub(super) const fn registers_of<S: Sample>(side: usize) -> usize {
    (side * side + S::CONSTANTS.len()).div_ceil(S::LANES)
}

impl Sample for f32 {
    const LANES: usize = 16;
    const CONSTANTS: &'static [Self] = &[1.0];
    type Register = Register<Self, 16>;
    type Reader<'a> = ();

    fn register(lanes: &[Self]) -> Self::Register {
        Register(lanes.first_chunk().copied().unwrap_or_default())
    }

    fn bits(self) -> u32 {
        self.to_bits()
    }

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
            Simd::Compiled => crate::numeric::simd::dispatch(portable::Float(run, planes)),
            #[cfg(target_arch = "x86_64")]
            Simd::Avx512(set) => set.products_f32(run, planes),
        }
    }
}

impl Sample for i16 {
    const LANES: usize = 32;
    const CONSTANTS: &'static [Self] = &[super::fixed::HIGH_PART as Self, 1];
    type Register = Register<Self, 32>;
    type Reader<'a> = super::fixed::Digital<'a>;

    fn register(lanes: &[Self]) -> Self::Register {
        Register(lanes.first_chunk().copied().unwrap_or([0; 32]))
    }

    fn bits(self) -> u32 {
        u32::from(self.cast_unsigned())
    }

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
            Simd::Compiled => crate::numeric::simd::dispatch(portable::Fixed(run, planes)),
            #[cfg(target_arch = "x86_64")]
            Simd::Avx512(set) => set.products_i16(run, planes),
        }
    }
}
