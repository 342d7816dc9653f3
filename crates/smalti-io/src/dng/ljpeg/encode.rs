//! Encoding.

use super::bits::BitWriter;
use super::huffman::{Encoder, size};
use super::predict;

/// A frame of 16-bit samples, row by row, `components` side by side, each predicted with `predictor` (1 to 7); after
/// every `restart_rows` rows (0: never) the prediction restarts.
///
/// `None` when the samples are no such frame: rows and columns go up to 65535, components to 4.
pub(in crate::dng) fn encode(
    samples: &[u16],
    cols: usize,
    components: usize,
    predictor: u8,
    restart_rows: usize,
) -> Option<Vec<u8>> {
    let row_len = cols.checked_mul(components)?;
    let rows = samples.len().checked_div(row_len)?;
    let (high, wide) = (u16::try_from(rows).ok()?, u16::try_from(cols).ok()?);
    let interval = u16::try_from(restart_rows.checked_mul(cols)?).ok()?;
    if rows * row_len != samples.len() || rows == 0 || !(1..=super::MAX_COMPONENTS).contains(&components) {
        return None;
    }
    let differences = |r: usize| {
        let row = samples.get(r * row_len..).unwrap_or_default();
        let above = samples.get((r.max(1) - 1) * row_len..).unwrap_or_default();
        let first = r == 0 || restart_rows > 0 && r.is_multiple_of(restart_rows);
        let middle = first.then_some(1 << 15);
        row.iter().take(row_len).enumerate().map(move |(i, sample)| {
            let predicted = predict(predictor, (row, above), i, components, middle);
            // Modulo 2¹⁶; 32768 is its own negative and written as the positive one.
            match i32::from((i32::from(*sample) - predicted) as i16) {
                -32768 => 32768,
                d => d,
            }
        })
    };
    let mut occurrences = [0; 17];
    for d in (0..rows).flat_map(differences) {
        if let Some(n) = occurrences.get_mut(size(d)) {
            *n += 1;
        }
    }
    let table = Encoder::new(occurrences);

    let mut out = vec![0xff, 0xd8];
    let mut segment = |marker: u8, content: &[u8]| {
        out.extend([0xff, marker]);
        out.extend((content.len() as u16 + 2).to_be_bytes());
        out.extend(content);
    };
    let [h1, h0] = high.to_be_bytes();
    let [w1, w0] = wide.to_be_bytes();
    let n = components as u8;
    let per_component = |of: fn(u8) -> Vec<u8>| (1..=n).flat_map(of).collect::<Vec<u8>>();
    segment(0xc3, &[&[16, h1, h0, w1, w0, n][..], &per_component(|c| vec![c, 0x11, 0])].concat());
    segment(0xc4, &[&[0][..], &table.segment()].concat());
    if interval > 0 {
        segment(0xdd, &interval.to_be_bytes());
    }
    segment(0xda, &[&[n][..], &per_component(|c| vec![c, 0]), &[predictor, 0, 0]].concat());
    let mut bits = BitWriter::after(out);
    for r in 0..rows {
        if restart_rows > 0 && r > 0 && r.is_multiple_of(restart_rows) {
            bits.flush();
            bits.bytes.extend([0xff, 0xd0 + ((r / restart_rows - 1) % 8) as u8]);
        }
        differences(r).for_each(|d| table.put(&mut bits, d));
    }
    bits.flush();
    bits.bytes.extend([0xff, 0xd9]);
    Some(bits.bytes)
}
