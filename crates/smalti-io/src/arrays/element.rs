//! Types of the numbers in a file.

/// A number as the library holds it.
pub(crate) trait Sample: Copy + Default + Send + Sync {
    fn of_f32(value: f32) -> Self;
    fn of_f64(value: f64) -> Self;
}

impl Sample for f32 {
    fn of_f32(value: f32) -> Self {
        value
    }
    fn of_f64(value: f64) -> Self {
        value as Self
    }
}

impl Sample for f64 {
    fn of_f32(value: f32) -> Self {
        Self::from(value)
    }
    fn of_f64(value: f64) -> Self {
        value
    }
}

/// A type of number and its byte order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Element {
    pub(crate) kind: Kind,
    pub(crate) big_endian: bool,
}

/// A type of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Element {
    /// Bytes of one number.
    pub(crate) fn size(self) -> usize {
        match self.kind {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::I64 | Kind::U64 | Kind::F64 => 8,
        }
    }

    /// All whole numbers in `bytes`.
    pub(crate) fn numbers<S: Sample>(self, bytes: &[u8]) -> Vec<S> {
        let mut numbers = vec![S::default(); bytes.len() / self.size()];
        let count = numbers.len();
        let strided = Strided { start: 0, strides: [1, 0], extents: [count, 1], to: [1, 0] };
        self.copy(bytes, strided, &mut numbers);
        numbers
    }

    /// Copies a rectangle of numbers, converting them. What lies outside either buffer is left out.
    pub(crate) fn copy<S: Sample>(self, bytes: &[u8], from: Strided, into: &mut [S]) {
        macro_rules! convert {
            ($($kind:ident $t:ty => $of:ident as $via:ty),*) => {
                match (self.kind, self.big_endian) {$(
                    (Kind::$kind, false) =>
                        copy(bytes.as_chunks().0, from, into, |b| S::$of(<$t>::from_le_bytes(b) as $via)),
                    (Kind::$kind, true) =>
                        copy(bytes.as_chunks().0, from, into, |b| S::$of(<$t>::from_be_bytes(b) as $via)),
                )*}
            };
        }
        // What f32 cannot hold goes by way of f64, so that either kind of sample is rounded once.
        convert!(
            I8 i8 => of_f32 as f32, U8 u8 => of_f32 as f32, I16 i16 => of_f32 as f32, U16 u16 => of_f32 as f32,
            I32 i32 => of_f64 as f64, U32 u32 => of_f64 as f64, I64 i64 => of_f64 as f64, U64 u64 => of_f64 as f64,
            F32 f32 => of_f32 as f32, F64 f64 => of_f64 as f64
        );
    }
}

/// A rectangle of numbers in a buffer, and where it goes in another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strided {
    /// Place of the first number.
    pub(crate) start: usize,
    /// Distances between neighbours in the buffer, along either axis.
    pub(crate) strides: [usize; 2],
    /// Numbers along either axis.
    pub(crate) extents: [usize; 2],
    /// Distances between neighbours in the other buffer, whose first place is taken by the first number.
    pub(crate) to: [usize; 2],
}

// Numbers that are transposed together: a square of them fits into the fastest cache, read and written.
const TILE: usize = 16;

fn copy<const N: usize, S: Sample>(
    from: &[[u8; N]],
    Strided { start, strides, extents, to }: Strided,
    into: &mut [S],
    convert: impl Fn([u8; N]) -> S,
) {
    // The axis along which the numbers are written one after another comes first.
    let (a, b) = if to[0] <= to[1] || extents[1] <= 1 { (0, 1) } else { (1, 0) };
    if to[a] == 1 && strides[a] == 1 {
        for j in 0..extents[b] {
            let (Some(from), Some(into)) = (from.get(start + j * strides[b]..), into.get_mut(j * to[b]..))
            else {
                continue;
            };
            for (value, number) in into.iter_mut().zip(from).take(extents[a]) {
                *value = convert(*number);
            }
        }
        return;
    }
    let across = strides[b] == 1 && to[a] == 1;
    for tile_b in (0..extents[b]).step_by(TILE) {
        for tile_a in (0..extents[a]).step_by(TILE) {
            let whole = tile_a + TILE <= extents[a] && tile_b + TILE <= extents[b];
            if across && whole {
                let from = from.get(start + tile_a * strides[a] + tile_b..).unwrap_or_default();
                let into = into.get_mut(tile_a + tile_b * to[b]..).unwrap_or_default();
                transpose(from, strides[a], into, to[b], &convert);
                continue;
            }
            for j in tile_b..(tile_b + TILE).min(extents[b]) {
                let count = TILE.min(extents[a] - tile_a);
                let from = from.get(start + tile_a * strides[a] + j * strides[b]..).unwrap_or_default();
                let into = into.get_mut(tile_a * to[a] + j * to[b]..).unwrap_or_default();
                let numbers = from.iter().step_by(strides[a].max(1));
                for (value, number) in into.iter_mut().step_by(to[a].max(1)).zip(numbers).take(count) {
                    *value = convert(*number);
                }
            }
        }
    }
}

/// Turns one whole tile, held in registers and the fastest cache in between.
fn transpose<const N: usize, S: Sample>(
    from: &[[u8; N]],
    stride: usize,
    into: &mut [S],
    to: usize,
    convert: impl Fn([u8; N]) -> S,
) {
    let mut tile = [[S::default(); TILE]; TILE];
    for (i, line) in from.chunks(stride.max(1)).take(TILE).enumerate() {
        let Some(line) = line.first_chunk::<TILE>() else { continue };
        for (row, number) in tile.iter_mut().zip(line) {
            if let Some(value) = row.get_mut(i) {
                *value = convert(*number);
            }
        }
    }
    for (line, row) in into.chunks_mut(to.max(1)).zip(&tile) {
        if let Some(line) = line.first_chunk_mut::<TILE>() {
            *line = *row;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_and_byte_order() {
        let two = |kind, bytes: &[u8]| {
            let swapped: Vec<u8> = bytes.iter().rev().copied().collect();
            let little: Vec<f64> = Element { kind, big_endian: false }.numbers(bytes);
            assert_eq!(little, Element { kind, big_endian: true }.numbers::<f64>(&swapped));
            little[0]
        };
        assert_eq!(two(Kind::I8, &(-3i8).to_le_bytes()), -3.0);
        assert_eq!(two(Kind::U8, &[200]), 200.0);
        assert_eq!(two(Kind::I16, &(-300i16).to_le_bytes()), -300.0);
        assert_eq!(two(Kind::U16, &40000u16.to_le_bytes()), 40000.0);
        assert_eq!(two(Kind::I32, &(-70000i32).to_le_bytes()), -70000.0);
        assert_eq!(two(Kind::U32, &4_000_000_001u32.to_le_bytes()), 4_000_000_001.0);
        assert_eq!(two(Kind::I64, &(-(1i64 << 40)).to_le_bytes()), -((1i64 << 40) as f64));
        assert_eq!(two(Kind::U64, &(1u64 << 63).to_le_bytes()), (1u64 << 63) as f64);
        assert_eq!(two(Kind::F32, &1.5f32.to_le_bytes()), 1.5);
        assert_eq!(two(Kind::F64, &1e-300f64.to_le_bytes()), 1e-300);
    }

    #[test]
    fn transposed_in_tiles_that_do_not_divide_it() {
        let (rows, cols) = (TILE * 2 + 3, TILE + 5);
        let bytes: Vec<u8> = (0..rows * cols).flat_map(|i| (i as u16).to_le_bytes()).collect();
        let mut out = vec![0f32; rows * cols];
        let strided = Strided { start: 0, strides: [1, rows], extents: [rows, cols], to: [cols, 1] };
        Element { kind: Kind::U16, big_endian: false }.copy(&bytes, strided, &mut out);
        for r in 0..rows {
            for c in 0..cols {
                assert_eq!(out[r * cols + c], (c * rows + r) as f32);
            }
        }
    }
}
