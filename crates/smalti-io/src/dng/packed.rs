//! Samples in bytes: packed bits, floating point of DNG's sizes, and the differences that Deflate is given.

use crate::raster::{add_differences, restore_floats};

/// Sample `i` of a row. Sizes below 16 bits are packed, the most significant bit first, in either byte order.
pub(super) fn integer(bytes: &[u8], i: usize, bits: usize, big_endian: bool) -> u16 {
    let byte = |at: usize| u32::from(bytes.get(at).copied().unwrap_or(0));
    match bits {
        8 => byte(i) as u16,
        16 => {
            let (a, b) = (byte(2 * i) as u16, byte(2 * i + 1) as u16);
            if big_endian { a << 8 | b } else { b << 8 | a }
        }
        _ => {
            let at = i * bits / 8;
            let three = byte(at) << 16 | byte(at + 1) << 8 | byte(at + 2);
            let shift = 24 - bits - i * bits % 8;
            (three >> shift & ((1 << bits) - 1)) as u16
        }
    }
}

/// Sample `i` of a row of floating point of 16, 24 or 32 bits (DNG 1.4, chapter 3: floating point image data).
pub(super) fn float(bytes: &[u8], i: usize, bits: usize, big_endian: bool) -> f32 {
    let size = bits / 8;
    let byte = |k: usize| {
        let at = if big_endian { k } else { size - 1 - k };
        u32::from(bytes.get(i * size + at).copied().unwrap_or(0))
    };
    let whole = (0..size).fold(0u32, |v, k| v << 8 | byte(k));
    match size {
        2 => small_float(whole, 5, 10),
        3 => small_float(whole, 7, 16),
        _ => f32::from_bits(whole),
    }
}

/// A number of one sign bit, `exponent` and `fraction` bits, with the conventions of IEEE 754.
fn small_float(bits: u32, exponent: u32, fraction: u32) -> f32 {
    let bias = (1i32 << (exponent - 1)) - 1;
    let e = (bits >> fraction & ((1 << exponent) - 1)) as i32;
    let f = f64::from(bits & ((1 << fraction) - 1)) / f64::from(1u32 << fraction);
    let size = match e {
        0 => f * libm::exp2(f64::from(1 - bias)),
        e if e == (1 << exponent) - 1 && f > 0.0 => f64::NAN,
        e if e == (1 << exponent) - 1 => f64::INFINITY,
        e => (1.0 + f) * libm::exp2(f64::from(e - bias)),
    };
    (if bits >> (exponent + fraction) & 1 == 1 { -size } else { size }) as f32
}

/// What was done to samples before they were deflated (`Predictor`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Predictor {
    None,
    /// Each sample as the difference to that so many samples before it.
    Difference(usize),
    /// The bytes of a row's floating point numbers, sorted from the most significant, then as differences to those so many
    /// before (Adobe Photoshop TIFF technical note 3).
    FloatingPoint(usize),
}

impl Predictor {
    /// By its code, for pixels of `planes` samples. `None` for an unknown one.
    pub(super) fn of(code: usize, planes: usize) -> Option<Self> {
        Some(match code {
            1 => Self::None,
            2 => Self::Difference(planes),
            3 => Self::FloatingPoint(planes),
            // DNG 1.4: to the sample two or four pixels before, for mosaics.
            34892 => Self::Difference(planes.checked_mul(2)?),
            34893 => Self::Difference(planes.checked_mul(4)?),
            34894 => Self::FloatingPoint(planes.checked_mul(2)?),
            34895 => Self::FloatingPoint(planes.checked_mul(4)?),
            _ => return None,
        })
    }

    /// Undoes it in a row of samples of `size` bytes. Floating point comes out most significant byte first.
    pub(super) fn undo(self, row: &mut [u8], size: usize, big_endian: bool) {
        match self {
            Self::None => {}
            Self::Difference(step) => add_differences(row, step, size, big_endian),
            Self::FloatingPoint(step) => restore_floats(row, step, size),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_samples_begin_with_the_highest_bit() {
        let bytes = [0xab, 0xcd, 0xef, 0x12];
        assert_eq!(integer(&bytes, 0, 12, false), 0xabc);
        assert_eq!(integer(&bytes, 1, 12, true), 0xdef);
        assert_eq!(integer(&bytes, 0, 14, false), 0xabcd >> 2);
        assert_eq!(integer(&bytes, 1, 14, false), ((0xabcd_ef12u32 >> 4) & 0x3fff) as u16);
        assert_eq!(integer(&bytes, 2, 10, false), ((0xabcd_ef12u32 >> 2) & 0x3ff) as u16);
        assert_eq!(integer(&bytes, 1, 15, false), ((0xabcd_ef12u32 >> 2) & 0x7fff) as u16);
        assert_eq!(integer(&bytes, 1, 16, true), 0xef12);
        assert_eq!(integer(&bytes, 1, 16, false), 0x12ef);
    }

    #[test]
    fn floating_point_of_every_size() {
        assert_eq!(float(&[0, 0, 0x3c, 0], 1, 16, true), 1.0);
        assert_eq!(float(&[0, 0xc5], 0, 16, false), -5.0);
        assert_eq!(float(&[0, 1], 0, 16, true), libm::exp2f(-24.0));
        assert!(float(&[0x7c, 0], 0, 16, true).is_infinite());
        assert!(float(&[0x7c, 1], 0, 16, true).is_nan());
        // 24 bits: seven of exponent, sixteen of fraction.
        assert_eq!(float(&[0x3f, 0x80, 0], 0, 24, true), 1.5);
        assert_eq!(float(&[0, 0, 0xc0], 0, 24, false), -2.0);
        assert_eq!(float(&0.3f32.to_le_bytes(), 0, 32, false), 0.3);
    }

    #[test]
    fn differences_are_summed() {
        let mut row = [1, 2, 3, 250, 10];
        Predictor::Difference(2).undo(&mut row, 1, false);
        assert_eq!(row, [1, 2, 4, 252, 14]);
        let mut row = [0x01, 0xff, 0x00, 0x02];
        Predictor::Difference(1).undo(&mut row, 2, true);
        assert_eq!(row, [0x01, 0xff, 0x02, 0x01]);
        // Two numbers of 16 bits, 0x1122 and 0x3344, sorted: 11 33 22 44.
        let mut row = [0x11, 0x22, 0xefu8, 0x22];
        Predictor::FloatingPoint(1).undo(&mut row, 2, false);
        assert_eq!(row, [0x11, 0x22, 0x33, 0x44]);
    }
}
