//! Samples copied from where they lie in memory to planes: converted, and transposed where planes lie otherwise.

use super::kind::{Kind, Sample, half};

/// Samples in memory: where the first is, and the distances, in samples, from one band, row, column to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strides {
    pub(crate) first: usize,
    pub(crate) band: usize,
    pub(crate) row: usize,
    pub(crate) col: usize,
}

/// Parts of planes that are written: for each band, rows of `width` samples that are filled from `col` on.
pub(crate) struct Target<'a, 'b, S> {
    pub(crate) bands: &'a mut [&'b mut [S]],
    pub(crate) width: usize,
    pub(crate) col: usize,
}

impl Kind {
    /// All whole samples in `bytes`, one after another.
    pub(crate) fn numbers<S: Sample>(self, big_endian: bool, bytes: &[u8]) -> Vec<S> {
        let mut numbers = vec![S::default(); bytes.len() / self.size()];
        let count = numbers.len();
        let strides = Strides { first: 0, band: 0, row: 0, col: 1 };
        let mut target = Target { bands: &mut [&mut numbers[..]], width: count, col: 0 };
        // As many as there are bytes for.
        let _ = gather(bytes, (self, big_endian), strides, (&[0], 1, count), &mut target);
        numbers
    }
}

/// Copies `rows` × `cols` samples of the bands at `places` to the target. `None` where the bytes end before.
pub(crate) fn gather<S: Sample>(
    bytes: &[u8],
    (kind, big_endian): (Kind, bool),
    strides: Strides,
    (places, rows, cols): (&[usize], usize, usize),
    target: &mut Target<'_, '_, S>,
) -> Option<()> {
    macro_rules! of {
        ($t:ty) => {{
            let samples = bytes.as_chunks().0;
            if big_endian {
                moved(samples, strides, (places, rows, cols), target, |b| S::of(<$t>::from_be_bytes(b)))
            } else {
                moved(samples, strides, (places, rows, cols), target, |b| S::of(<$t>::from_le_bytes(b)))
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
            moved(samples, strides, (places, rows, cols), target, |b| S::of(half(load(b))))
        }
    }
}

fn moved<const N: usize, S: Sample>(
    samples: &[[u8; N]],
    strides: Strides,
    (places, rows, cols): (&[usize], usize, usize),
    target: &mut Target<'_, '_, S>,
    load: impl Fn([u8; N]) -> S + Copy,
) -> Option<()> {
    let (width, left) = (target.width, target.col);
    if strides.col == 1 {
        for (place, band) in places.iter().zip(&mut *target.bands) {
            for row in 0..rows {
                let from = strides.first + place * strides.band + row * strides.row;
                let from = samples.get(from..from + cols)?;
                let to = row * width + left;
                let to = band.get_mut(to..to + cols)?;
                to.iter_mut().zip(from).for_each(|(t, s)| *t = load(*s));
            }
        }
        return Some(());
    }
    if strides.row == 1 {
        for (place, band) in places.iter().zip(&mut *target.bands) {
            let first = strides.first + place * strides.band;
            transposed(samples, (first, strides.col), (rows, cols), load, |row, col, line| {
                let to = row * width + left + col;
                band.get_mut(to..to + line.len())?.copy_from_slice(line);
                Some(())
            })?;
        }
        return Some(());
    }
    // Bands lie side by side: those that follow one another are turned together.
    let (mut places, mut bands) = (places, &mut *target.bands);
    while let Some(first) = places.first() {
        let count = places.iter().enumerate().take_while(|(i, p)| **p == first + i).count();
        let count = if strides.band == 1 { count } else { 1 };
        let (now, later) = std::mem::take(&mut bands).split_at_mut_checked(count)?;
        for row in 0..rows {
            let from = strides.first + first * strides.band + row * strides.row;
            transposed(samples, (from, strides.col), (count, cols), load, |band, col, line| {
                let to = row * width + left + col;
                now.get_mut(band)?.get_mut(to..to + line.len())?.copy_from_slice(line);
                Some(())
            })?;
        }
        (places, bands) = (places.get(count..)?, later);
    }
    Some(())
}

// Samples that are turned together: a square of them fits into the fastest cache, as it is and turned.
const TILE: usize = 16;

/// Turns `fast` samples that lie side by side, in each of `cols` lines at a distance: `put` is given pieces of columns, by
/// the place among the fast ones and the first line.
fn transposed<const N: usize, S: Sample>(
    samples: &[[u8; N]],
    (first, distance): (usize, usize),
    (fast, cols): (usize, usize),
    load: impl Fn([u8; N]) -> S + Copy,
    mut put: impl FnMut(usize, usize, &[S]) -> Option<()>,
) -> Option<()> {
    let mut tile = [[S::default(); TILE]; TILE];
    for col in (0..cols).step_by(TILE) {
        let wide = TILE.min(cols - col);
        for begin in (0..fast).step_by(TILE) {
            let high = TILE.min(fast - begin);
            let lines = samples.get(first + col * distance + begin..)?;
            if (high, wide) == (TILE, TILE) {
                // All lengths are known here, and no place is compared with them.
                for i in 0..TILE {
                    let line = lines.get(i * distance..)?.first_chunk::<TILE>()?;
                    for (row, number) in tile.iter_mut().zip(line) {
                        row[i] = load(*number);
                    }
                }
                for (i, line) in tile.iter().enumerate() {
                    put(begin + i, col, line)?;
                }
                continue;
            }
            for i in 0..wide {
                let from = i * distance;
                for (row, number) in tile.iter_mut().zip(lines.get(from..from + high)?) {
                    row[i] = load(*number);
                }
            }
            for (i, line) in tile.iter().take(high).enumerate() {
                put(begin + i, col, line.get(..wide)?)?;
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_and_byte_order() {
        let one = |kind: Kind, bytes: &[u8]| {
            let swapped: Vec<u8> = bytes.iter().rev().copied().collect();
            let little: Vec<f64> = kind.numbers(false, bytes);
            assert_eq!(little, kind.numbers::<f64>(true, &swapped));
            // Rounded once.
            assert_eq!(kind.numbers::<f32>(false, bytes)[0], little[0] as f32);
            little[0]
        };
        assert_eq!(one(Kind::I8, &(-3i8).to_le_bytes()), -3.0);
        assert_eq!(one(Kind::U8, &[200]), 200.0);
        assert_eq!(one(Kind::I16, &(-300i16).to_le_bytes()), -300.0);
        assert_eq!(one(Kind::U16, &40000u16.to_le_bytes()), 40000.0);
        assert_eq!(one(Kind::I32, &(-70000i32).to_le_bytes()), -70000.0);
        assert_eq!(one(Kind::U32, &4_000_000_001u32.to_le_bytes()), 4_000_000_001.0);
        assert_eq!(one(Kind::I64, &(-(1i64 << 40)).to_le_bytes()), -((1i64 << 40) as f64));
        assert_eq!(one(Kind::U64, &(1u64 << 63).to_le_bytes()), (1u64 << 63) as f64);
        assert_eq!(one(Kind::F16, &0x3c00u16.to_le_bytes()), 1.0);
        assert_eq!(one(Kind::F32, &1.5f32.to_le_bytes()), 1.5);
        assert_eq!(one(Kind::F64, &1e-300f64.to_le_bytes()), 1e-300);
        assert_eq!(Kind::U16.numbers::<f64>(false, &[1, 0, 2, 0, 3]), [1.0, 2.0]);
    }
}
