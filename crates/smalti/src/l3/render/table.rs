//! Kernels in the layout of the inner loops: the taps of a patch column by column, padded to whole registers.

use std::collections::HashMap;

use super::super::vectors::Register;

/// An offset enters the sum as two 16-bit weights; one is multiplied by this value, the other by 1.
pub(super) const HIGH_PART: i32 = 1 << 14;

/// The number type of a rendering path: `f32`, or `i16` in fixed point.
pub(super) trait Sample: Copy + Default + Send + Sync + std::fmt::Debug + 'static {
    /// Numbers per register.
    const LANES: usize;
    /// Constants after the last tap of the patch, which multiply the offsets.
    const CONSTANTS: &'static [Self];
    /// An aligned register.
    type Register: Copy + Send + Sync + std::fmt::Debug;
    fn register(lanes: &[Self]) -> Self::Register;
    /// Equal for equal numbers.
    fn bits(self) -> u32;
}

/// The rows of an image that a window holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) size: [usize; 2],
    pub(super) first: usize,
    pub(super) rows: usize,
    pub(super) half: usize,
    pub(super) tile: [usize; 2],
}

/// Consecutive pixels of a row.
#[derive(Debug)]
pub(super) struct Run<'a, S: Sample> {
    pub(super) table: &'a Table<S>,
    /// Concatenated columns of patches, starting with those of the first pixel.
    pub(super) patches: &'a [S],
    /// The first register of the kernels of each pixel (in fixed point an [`Entry`](super::fixed::Entry)),
    /// padded with arbitrary kernels to whole vectors of [`PIXELS`](super::super::vectors::PIXELS).
    pub(super) kernels: &'a [u32],
    /// Index of the first pixel in the planes.
    pub(super) at: usize,
    /// Number of pixels.
    pub(super) count: usize,
}

/// The distinct kernels.
#[derive(Debug, Clone)]
pub(super) struct Table<S: Sample> {
    /// Ordered kernel, output, register.
    pub(super) registers: Vec<S::Register>,
    /// Side of the patch.
    pub(super) side: usize,
    /// The last register of a patch, with only the constants after its last tap.
    pub(super) beyond: S::Register,
    /// In fixed point, the factor from sums to values for kernels without fractional bits.
    pub(super) scale: f32,
}

impl<S: Sample> Table<S> {
    /// Builds the table from `weights`, ordered class, output, tap (row order), and `offsets` of
    /// `class · outputs + output`, which [`Sample::CONSTANTS`] multiply. Also returns the first register of the kernels of
    /// each class. Equal kernels are stored once.
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
        // Classes with their first register, by a digest of their kernels.
        let mut places: HashMap<u64, Vec<(usize, u32)>> = HashMap::new();
        let tails_of =
            |class: usize| (0..outputs).map(move |o| (class, o)).map(|(c, o)| offsets(c * outputs + o));
        let size = (outputs * taps).max(1);
        let mut lanes = vec![S::default(); per_output * S::LANES];
        let mut of_class = Vec::new();
        for (class, own) in weights.chunks_exact(size).enumerate() {
            let tails: Vec<Vec<S>> = tails_of(class).collect();
            let bits = || own.iter().chain(tails.iter().flatten()).map(|v| v.bits());
            let alike = places.entry(bits().fold(0, digest)).or_default();
            let equal = |(other, _): &&(usize, u32)| {
                let tails: Vec<Vec<S>> = tails_of(*other).collect();
                let kernels = weights[other * size..(other + 1) * size].iter();
                kernels.chain(tails.iter().flatten()).map(|v| v.bits()).eq(bits())
            };
            if let Some(&(_, place)) = alike.iter().find(equal) {
                of_class.push(place);
                continue;
            }
            let next = registers.len() as u32;
            alike.push((class, next));
            of_class.push(next);
            for (weights, tail) in own.chunks_exact(taps).zip(tails) {
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

/// Adds a number to a digest. Kernels are compared where digests are equal, so that it need only be fast.
fn digest(sum: u64, bits: u32) -> u64 {
    (sum.rotate_left(5) ^ u64::from(bits)).wrapping_mul(0x517c_c1b7_2722_0a95)
}

/// Registers for a patch and the constants after it.
pub(super) const fn registers_of<S: Sample>(side: usize) -> usize {
    (side * side + S::CONSTANTS.len()).div_ceil(S::LANES)
}

impl Sample for f32 {
    const LANES: usize = 16;
    const CONSTANTS: &'static [Self] = &[1.0];
    type Register = Register<Self, 16>;

    fn register(lanes: &[Self]) -> Self::Register {
        Register(lanes.first_chunk().copied().unwrap_or_default())
    }

    fn bits(self) -> u32 {
        self.to_bits()
    }
}

impl Sample for i16 {
    const LANES: usize = 32;
    const CONSTANTS: &'static [Self] = &[HIGH_PART as Self, 1];
    type Register = Register<Self, 32>;

    fn register(lanes: &[Self]) -> Self::Register {
        Register(lanes.first_chunk().copied().unwrap_or([0; 32]))
    }

    fn bits(self) -> u32 {
        u32::from(self.cast_unsigned())
    }
}
