//! Planes of integers as differences from what their neighbours predict, which deflate well.

use smalti::design::QuantizedPlanes;

/// The prediction of a number from those to the left, above, and above to the left: the median edge detector of [LOCO-I] (JPEG-LS).
///
/// [LOCO-I]: https://doi.org/10.1109/83.855427
fn predicted(left: i32, above: i32, corner: i32) -> i32 {
    let (low, high) = (left.min(above), left.max(above));
    if corner >= high {
        low
    } else if corner <= low {
        high
    } else {
        left.wrapping_add(above).wrapping_sub(corner)
    }
}

/// The prediction at a place of a plane whose earlier numbers are known; numbers outside the plane are those beside them, and 0 before the first.
fn prediction(plane: &[i32], cols: usize, at: usize) -> i32 {
    let (row, col) = (at / cols, at % cols);
    match (row, col) {
        (0, 0) => 0,
        (0, _) => plane[at - 1],
        (_, 0) => plane[at - cols],
        _ => predicted(plane[at - 1], plane[at - cols], plane[at - cols - 1]),
    }
}

/// The differences of all planes, the low bytes of all of them before the high ones; `None` for a difference beyond 16 bits.
pub(super) fn packed<'a>(all: impl Iterator<Item = &'a QuantizedPlanes>) -> Option<Vec<u8>> {
    let (mut low, mut high) = (Vec::new(), Vec::new());
    for planes in all {
        for plane in planes.codes.chunks_exact((planes.rows * planes.cols).max(1)) {
            for (at, code) in plane.iter().enumerate() {
                let difference = code.wrapping_sub(prediction(plane, planes.cols, at));
                // Signs alternate: 0, −1, 1, −2, …
                let folded = u16::try_from((difference << 1 ^ difference >> 31) as u32).ok()?;
                let [l, h] = folded.to_le_bytes();
                low.push(l);
                high.push(h);
            }
        }
    }
    low.append(&mut high);
    Some(low)
}

/// The numbers of planes of the given sizes (rows, columns, planes), or `None` unless there are exactly as many differences.
pub(super) fn unpacked(bytes: &[u8], sizes: &[[usize; 3]]) -> Option<Vec<Vec<i32>>> {
    let count = |[rows, cols, planes]: &[usize; 3]| rows.checked_mul(*cols)?.checked_mul(*planes);
    let counts = sizes.iter().map(count).collect::<Option<Vec<usize>>>()?;
    let total = counts.iter().try_fold(0usize, |sum, n| sum.checked_add(*n))?;
    if bytes.len() != total.checked_mul(2)? {
        return None;
    }
    let (low, high) = bytes.split_at(total);
    let mut folded = low.iter().zip(high).map(|(l, h)| u16::from_le_bytes([*l, *h]));
    let mut all = Vec::with_capacity(sizes.len());
    for (&[rows, cols, _], count) in sizes.iter().zip(counts) {
        let mut codes = vec![0i32; count];
        for plane in codes.chunks_exact_mut((rows * cols).max(1)) {
            for at in 0..plane.len() {
                let folded = i32::from(folded.next()?);
                let difference = folded >> 1 ^ -(folded & 1);
                plane[at] = prediction(plane, cols, at).wrapping_add(difference);
            }
        }
        all.push(codes);
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::sync::Arc;

    use super::*;

    #[test]
    fn planes_read_back() {
        let codes: Vec<i32> = (0..60).map(|i: i32| (i * i * 7919 % 4001) - 2000).collect();
        let planes = |rows, cols, count| QuantizedPlanes {
            rows,
            cols,
            count,
            step: 1.0,
            codes: Arc::new(codes[..rows * cols * count].to_vec()),
        };
        let both = [planes(3, 5, 4), planes(2, 7, 1)];
        let bytes = packed(both.iter()).unwrap();
        let sizes = [[3, 5, 4], [2, 7, 1]];
        let found = unpacked(&bytes, &sizes).unwrap();
        assert_eq!(found, both.map(|p| p.codes.to_vec()));
        assert!(unpacked(&bytes[1..], &sizes).is_none() && unpacked(&bytes, &sizes[..1]).is_none());
        assert!(unpacked(&bytes, &[[usize::MAX, 2, 2]]).is_none() && unpacked(&[], &[]).unwrap().is_empty());
    }

    #[test]
    fn a_difference_beyond_sixteen_bits_is_refused() {
        let planes = |codes: Vec<i32>| QuantizedPlanes {
            rows: 1,
            cols: codes.len(),
            count: 1,
            step: 1.0,
            codes: Arc::new(codes),
        };
        assert!(packed([planes(vec![0, 32_767])].iter()).is_some());
        assert!(packed([planes(vec![0, 32_768])].iter()).is_none());
        assert!(packed([planes(vec![i32::MIN, i32::MAX])].iter()).is_none());
    }
}
