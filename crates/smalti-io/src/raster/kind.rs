//! Types of samples, and how they become `f32` planes.

/// How a sample is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F16,
    F32,
    F64,
}

impl Kind {
    /// Bytes of a sample.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The largest value of an unsigned integer: what pictures call 1.
    pub(crate) fn largest(self) -> Option<f64> {
        match self {
            Self::U8 => Some(f64::from(u8::MAX)),
            Self::U16 => Some(f64::from(u16::MAX)),
            Self::U32 => Some(f64::from(u32::MAX)),
            _ => None,
        }
    }
}

/// Samples in memory: the distance, in samples, from one band, row, column to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strides {
    pub(crate) band: usize,
    pub(crate) row: usize,
    pub(crate) col: usize,
}

/// Parts of planes that are written: for each band rows of `width` samples, of which those from `col` on are filled.
pub(crate) struct Target<'a, 'b> {
    pub(crate) bands: &'a mut [&'b mut [f32]],
    pub(crate) width: usize,
    pub(crate) col: usize,
}

/// Copies `rows` × `cols` samples of the bands at `places` to the target. `None` where the bytes end before.
pub(crate) fn gather(
    bytes: &[u8],
    (kind, big_endian): (Kind, bool),
    strides: Strides,
    (places, rows, cols): (&[usize], usize, usize),
    target: &mut Target<'_, '_>,
) -> Option<()> {
    macro_rules! of {
        ($t:ty) => {{
            let samples = bytes.as_chunks().0;
            if big_endian {
                moved(samples, strides, (places, rows, cols), target, |b| <$t>::from_be_bytes(b) as f32)
            } else {
                moved(samples, strides, (places, rows, cols), target, |b| <$t>::from_le_bytes(b) as f32)
            }
        }};
    }
    match kind {
        Kind::U8 => of!(u8),
        Kind::I8 => of!(i8),
        Kind::U16 => of!(u16),
        Kind::I16 => of!(i16),
        Kind::U32 => of!(u32),
        Kind::I32 => of!(i32),
        Kind::U64 => of!(u64),
        Kind::I64 => of!(i64),
        Kind::F32 => of!(f32),
        Kind::F64 => of!(f64),
        Kind::F16 => {
            let samples = bytes.as_chunks().0;
            let load = |b: [u8; 2]| if big_endian { u16::from_be_bytes(b) } else { u16::from_le_bytes(b) };
            moved(samples, strides, (places, rows, cols), target, |b| half(load(b)))
        }
    }
}

/// IEEE 754 binary16; every value of it is one of `f32`.
fn half(bits: u16) -> f32 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let size = match exponent {
        0 => fraction * 2f32.powi(-24),
        31 if fraction == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        e => (1.0 + fraction / 1024.0) * 2f32.powi(e - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}

/// Rows and columns of a block that is transposed at once: source and target of it lie in the first cache.
const BLOCK_COLS: usize = 32;
const BLOCK_ROWS: usize = 16;

fn moved<const N: usize>(
    samples: &[[u8; N]],
    strides: Strides,
    (places, rows, cols): (&[usize], usize, usize),
    target: &mut Target<'_, '_>,
    load: impl Fn([u8; N]) -> f32 + Copy,
) -> Option<()> {
    let width = target.width;
    if strides.col == 1 {
        for (place, band) in places.iter().zip(&mut *target.bands) {
            for row in 0..rows {
                let from = place * strides.band + row * strides.row;
                let from = samples.get(from..from + cols)?;
                let to = row * width + target.col;
                let to = band.get_mut(to..to + cols)?;
                to.iter_mut().zip(from).for_each(|(t, s)| *t = load(*s));
            }
        }
        return Some(());
    }
    let block_rows = if strides.row == 1 { BLOCK_ROWS } else { 1 };
    for first_row in (0..rows).step_by(block_rows) {
        for first_col in (0..cols).step_by(BLOCK_COLS) {
            let count = BLOCK_COLS.min(cols - first_col);
            for (place, band) in places.iter().zip(&mut *target.bands) {
                for row in first_row..rows.min(first_row + block_rows) {
                    let from = place * strides.band + row * strides.row + first_col * strides.col;
                    let from = samples.get(from..)?.iter().step_by(strides.col.max(1));
                    let to = row * width + target.col + first_col;
                    let to = band.get_mut(to..to + count)?;
                    let mut missing = count;
                    for (t, s) in to.iter_mut().zip(from) {
                        *t = load(*s);
                        missing -= 1;
                    }
                    if missing > 0 {
                        return None;
                    }
                }
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_floats_are_exact() {
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x3555, 0.333_251_95),
            (0x0001, 5.960_464_5e-8),
            (0x7bff, 65504.0),
            (0x0400, 6.103_515_6e-5),
        ] {
            assert_eq!(half(bits), value, "{bits:x}");
        }
        assert!(
            half(0x7c01).is_nan() && half(0xfc00) == f32::NEG_INFINITY && half(0x8000).to_bits() == 1 << 31
        );
    }
}
