//! Huffman tables of differences: the symbol is the number of bits that the difference takes, 0 to 16.

use super::bits::{BitReader, BitWriter};

/// Number of symbols.
const SYMBOLS: usize = 17;

/// A table to decode with.
#[derive(Debug, Clone)]
pub(super) struct Decoder {
    /// Length and symbol by the next eight bits; length 0 where the code is longer.
    short: [(u8, u8); 256],
    /// For each length: the code after the last of it, aligned to 16 bits, and what a code's place among all is
    /// found with. 0 where there is none.
    ends: [u32; 17],
    offsets: [i32; 17],
    symbols: Vec<u8>,
}

impl Decoder {
    /// From the number of codes of each length 1 to 16, and the symbols in the order of their codes.
    pub(super) fn new(counts: &[u8; 16], symbols: &[u8]) -> Result<Self, String> {
        if symbols.iter().any(|s| usize::from(*s) >= SYMBOLS) {
            return Err("a Huffman table has a symbol above 16".into());
        }
        let mut table =
            Self { short: [(0, 0); 256], ends: [0; 17], offsets: [0; 17], symbols: symbols.to_vec() };
        let (mut code, mut place) = (0u32, 0usize);
        for (length, count) in (1u32..).zip(counts) {
            code <<= 1;
            let (first, count) = (code, u32::from(*count));
            code += count;
            if code > 1 << length {
                return Err("a Huffman table has more codes than their lengths leave room for".into());
            }
            if let (Some(end), Some(offset)) =
                (table.ends.get_mut(length as usize), table.offsets.get_mut(length as usize))
            {
                *end = if count > 0 { code << (16 - length) } else { 0 };
                *offset = place as i32 - first as i32;
            }
            if length <= 8 {
                let symbols = symbols.iter().skip(place);
                for (c, symbol) in (first..code).zip(symbols) {
                    let from = (c << (8 - length)) as usize;
                    let many = 1usize << (8 - length);
                    table.short.iter_mut().skip(from).take(many).for_each(|s| *s = (length as u8, *symbol));
                }
            }
            place += count as usize;
        }
        Ok(table)
    }

    /// The next difference, 0 to ±32768. `None` where no code fits.
    #[inline]
    pub(super) fn difference(&self, bits: &mut BitReader<'_>) -> Option<i32> {
        let next = bits.peek16();
        let (length, symbol) = match self.short.get(usize::from(next >> 8))? {
            (0, _) => self.long(next)?,
            &found => found,
        };
        bits.take(u32::from(length));
        Some(match symbol {
            0 => 0,
            16 => 32768,
            n => {
                let value = i32::from(bits.take(u32::from(n)));
                // Values whose first bit is 0 stand for the negative ones (T.81, F.2.2.1).
                if value < 1 << (n - 1) { value - (1 << n) + 1 } else { value }
            }
        })
    }

    fn long(&self, next: u16) -> Option<(u8, u8)> {
        let length = (9..=16u8).find(|&l| u32::from(next) < self.ends[usize::from(l)])?;
        let place = i32::from(next >> (16 - length)) + self.offsets[usize::from(length)];
        Some((length, *self.symbols.get(usize::try_from(place).ok()?)?))
    }
}

/// A table to encode with.
#[derive(Debug, Clone)]
pub(super) struct Encoder {
    /// Code and length of every symbol.
    codes: [(u32, u32); SYMBOLS],
    counts: [u8; 16],
    symbols: Vec<u8>,
}

impl Encoder {
    /// The shortest codes for symbols that occur as often as stated.
    pub(super) fn new(occurrences: [u64; SYMBOLS]) -> Self {
        let mut lengths = lengths(&occurrences);
        // Codes above 16 bits are for symbols so rare that coarser counts cost nothing.
        let mut coarse = occurrences;
        while lengths.iter().any(|l| *l > 16) {
            coarse.iter_mut().filter(|c| **c > 0).for_each(|c| *c = c.div_ceil(2));
            lengths = self::lengths(&coarse);
        }
        let mut table = Self { codes: [(0, 0); SYMBOLS], counts: [0; 16], symbols: Vec::new() };
        let mut code = 0;
        for (length, count) in (1u32..).zip(&mut table.counts) {
            code <<= 1;
            for (symbol, (l, entry)) in lengths.iter().zip(&mut table.codes).enumerate() {
                if *l == length {
                    *entry = (code, length);
                    table.symbols.push(symbol as u8);
                    *count += 1;
                    code += 1;
                }
            }
        }
        table
    }

    /// The content of the table in a DHT segment.
    pub(super) fn segment(&self) -> Vec<u8> {
        [&self.counts[..], &self.symbols].concat()
    }

    pub(super) fn put(&self, bits: &mut BitWriter, difference: i32) {
        let symbol = size(difference);
        let Some(&(code, length)) = self.codes.get(symbol) else { return };
        bits.put(code, length);
        if (1..16).contains(&symbol) {
            let value = if difference < 0 { difference + (1 << symbol) - 1 } else { difference };
            bits.put(value as u32, symbol as u32);
        }
    }
}

/// The symbol of a difference.
pub(super) fn size(difference: i32) -> usize {
    (32 - difference.unsigned_abs().leading_zeros()) as usize
}

/// Huffman's code lengths. One code more than there are symbols is made and left out: none may be all ones.
fn lengths(occurrences: &[u64; SYMBOLS]) -> [u32; SYMBOLS] {
    let mut lengths = [0; SYMBOLS + 1];
    let used = occurrences.iter().enumerate().filter(|(_, c)| **c > 0);
    let mut trees: Vec<(u64, Vec<usize>)> = used.map(|(s, c)| (*c, vec![s])).collect();
    // The rarest of all, so that its code is the last of the longest.
    trees.push((0, vec![SYMBOLS]));
    while trees.len() > 1 {
        trees.sort_by(|a, b| b.cmp(a));
        let (Some(a), Some(b)) = (trees.pop(), trees.pop()) else { break };
        let both = [a.1, b.1].concat();
        both.iter().for_each(|&s| lengths[s] += 1);
        trees.push((a.0 + b.0, both));
    }
    let mut known = [0; SYMBOLS];
    known.copy_from_slice(&lengths[..SYMBOLS]);
    known
}
