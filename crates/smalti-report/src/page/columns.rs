//! Columns of numbers for a page: as few bytes as their values need, so that a page of many designs stays small.

use std::collections::HashMap;
use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde_json::{Value, json};

/// Most different values of a column that are kept in a table beside it.
const DISTINCT: usize = 1 << 16;

/// A column of numbers, packed: single precision, little-endian, in base64. Where values repeat it holds the number of each in
/// a table of them, of one byte or two; where all are equal, only that value. NaN says that there is no value.
///
/// `data.js` reads it.
#[must_use]
pub fn packed(values: &[f64]) -> Value {
    let mut places: HashMap<u32, u16> = HashMap::new();
    let mut table: Vec<f32> = Vec::new();
    let mut codes: Vec<u16> = Vec::with_capacity(values.len());
    for &value in values {
        let single = if value.is_nan() { f32::NAN } else { value as f32 };
        let next = table.len();
        let code = places.entry(single.to_bits()).or_insert(next as u16);
        codes.push(*code);
        if places.len() > next {
            table.push(single);
        }
        // A table that is longer than half of the column saves next to nothing.
        if table.len() == DISTINCT || table.len() > 256 && table.len() > values.len() / 2 {
            let bytes = values.iter().flat_map(|v| (*v as f32).to_le_bytes());
            return json!({"n": values.len(), "f32": base64(bytes)});
        }
    }
    let mut packed = json!({"n": values.len(), "table": base64(table.iter().flat_map(|v| v.to_le_bytes()))});
    match table.len() {
        0 | 1 => {}
        2..=256 => packed["u8"] = base64(codes.iter().map(|c| *c as u8)),
        _ => packed["u16"] = base64(codes.iter().flat_map(|c| c.to_le_bytes())),
    }
    packed
}

fn base64(bytes: impl Iterator<Item = u8>) -> Value {
    STANDARD.encode(bytes.collect::<Vec<u8>>()).into()
}

/// A column of whole numbers that may be beyond single precision, as runs of consecutive ones: `[first, length, …]`.
#[must_use]
pub fn runs(numbers: &[u64]) -> Value {
    let mut runs: Vec<u64> = Vec::new();
    for &number in numbers {
        match runs.as_mut_slice() {
            [.., first, length] if *first + *length == number => *length += 1,
            _ => runs.extend([number, 1]),
        }
    }
    json!(runs)
}

/// A column of words: the words in the order they first come, and the place of each row's among them.
#[must_use]
pub fn words<'a>(texts: impl Iterator<Item = &'a str>) -> Value {
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut words: Vec<&str> = Vec::new();
    let codes: Vec<f64> = texts
        .map(|text| {
            let next = words.len();
            let place = *places.entry(text).or_insert(next);
            if place == next {
                words.push(text);
            }
            place as f64
        })
        .collect();
    json!({"words": words, "codes": packed(&codes)})
}

/// Pictures of whole numbers for a script to calculate with: each number less what its neighbours to the left and above let
/// expect (the median predictor of [weinberger2000], exact), then deflated.
///
/// Numbers beyond 16 bits are cut off. `data.js` reads it.
///
/// [weinberger2000]: https://doi.org/10.1109/83.855427
#[must_use]
pub fn whole_pictures<'a>(pictures: impl Iterator<Item = &'a [i32]>, cols: usize) -> Value {
    let (mut low, mut high, mut count) = (Vec::new(), Vec::new(), 0);
    for picture in pictures {
        count += 1;
        let at =
            |row: usize, col: usize| picture.get(row * cols + col).map_or(0, |v| (*v).clamp(-32768, 32767));
        for i in 0..picture.len() {
            let (row, col) = (i / cols.max(1), i % cols.max(1));
            let expected = match (row, col) {
                (0, 0) => 0,
                (0, _) => at(0, col - 1),
                (_, 0) => at(row - 1, 0),
                _ => {
                    let (left, above, corner) = (at(row, col - 1), at(row - 1, col), at(row - 1, col - 1));
                    let (least, most) = (left.min(above), left.max(above));
                    (left + above - corner).clamp(least, most)
                }
            };
            // Small numbers of either sign have a high byte of 0.
            let off = at(row, col) - expected;
            let code = ((off << 1) ^ (off >> 31)) as u32;
            low.push(code as u8);
            high.extend([(code >> 8) as u8, (code >> 16) as u8]);
        }
    }
    // The codes are 17 bits; the upper bytes, nearly all 0, are for rare jumps.
    low.extend(high);
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    let deflated = encoder.write_all(&low).and_then(|()| encoder.finish()).unwrap_or_default();
    json!({"count": count, "deflated": STANDARD.encode(deflated)})
}
