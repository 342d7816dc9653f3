//! Lossless JPEG: ITU-T T.81, process 14 of Annex H (Huffman coding, SOF3), as DNG uses it.
//!
//! DNG packs the samples of a strip or tile into the frame in their order in the file; a mosaic is often stored as
//! two components of half the columns, so that each sample is predicted from one of its own colour.

mod bits;
mod decode;
mod encode;
mod huffman;

pub(super) use decode::decode;
pub(super) use encode::encode;

/// Number of components of a frame; DNG allows up to four.
const MAX_COMPONENTS: usize = 4;

/// Predicted value of sample `i` of a row of pixels of `n` components, from its neighbours: left, above, above left (T.81, table H.1).
/// The first row, which has a `middle`, is predicted from left neighbours only, the first column from those above only.
#[inline]
fn predict(selection: u8, (row, above): (&[u16], &[u16]), i: usize, n: usize, middle: Option<i32>) -> i32 {
    let of = |line: &[u16], i: usize| i32::from(line.get(i).copied().unwrap_or(0));
    let (left, above, corner) = match (middle, i.checked_sub(n)) {
        (Some(middle), None) => return middle,
        (Some(_), Some(before)) => return of(row, before),
        (None, None) => return of(above, i),
        (None, Some(before)) => (of(row, before), of(above, i), of(above, before)),
    };
    match selection {
        1 => left,
        2 => above,
        3 => corner,
        4 => left + above - corner,
        5 => left + ((above - corner) >> 1),
        6 => above + ((left - corner) >> 1),
        _ => (left + above) >> 1,
    }
}

#[cfg(test)]
mod tests;
