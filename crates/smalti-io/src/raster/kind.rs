//! Types of samples in files, and the numbers that they become.

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

/// A number of one type as one of another, rounded once.
pub(crate) trait Of<T> {
    fn of(value: T) -> Self;
}

/// What samples become: single precision in planes, double precision in lists and coefficients.
pub(crate) trait Sample:
    bytemuck::Pod
    + Default
    + Send
    + Sync
    + Of<u8>
    + Of<i8>
    + Of<u16>
    + Of<i16>
    + Of<u32>
    + Of<i32>
    + Of<u64>
    + Of<i64>
    + Of<f32>
    + Of<f64>
{
    /// How it is stored where nothing needs to be converted.
    const KIND: Kind;
}

impl Sample for f32 {
    const KIND: Kind = Kind::F32;
}

impl Sample for f64 {
    const KIND: Kind = Kind::F64;
}

macro_rules! of {
    ($($from:ty)*) => {$(
        impl Of<$from> for f32 {
            fn of(value: $from) -> Self {
                value as Self
            }
        }
        impl Of<$from> for f64 {
            fn of(value: $from) -> Self {
                value as Self
            }
        }
    )*};
}
of!(u8 i8 u16 i16 u32 i32 u64 i64 f32 f64);

/// IEEE 754 binary16; every value of it is one of `f32`.
pub(super) fn half(bits: u16) -> f32 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let size = match exponent {
        0 => fraction * 2f32.powi(-24),
        31 if fraction == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        e => (1.0 + fraction / 1024.0) * 2f32.powi(e - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
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
