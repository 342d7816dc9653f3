//! Pictures as sixels, the graphics of DEC's VT340 (VT330/VT340 Programmer Reference Manual, vol. 2, chapter 14): a palette,
//! then bands of six rows, in which each colour has a line of its own.

use std::collections::BTreeMap;

use super::picture::Pixels;

/// Pixels of a column, as terminals are usually set: sixels cannot ask for columns.
pub(super) const COLUMN_PX: usize = 8;
/// Colours of a palette that all terminals have.
const COLORS: usize = 256;
/// Bits of a channel that colours are told apart by.
const BITS: u32 = 6;

type Color = [u8; 3];

/// A picture in a palette of its own.
pub(super) fn encode(picture: &Pixels) -> String {
    let (palette, index_of) = palette(&picture.rgb);
    let mut out = format!("\x1bP0;1;0q\"1;1;{};{}", picture.width, picture.height);
    for (i, color) in palette.iter().enumerate() {
        let [r, g, b] = color.map(|v| (u32::from(v) * 100 + 127) / 255);
        out += &format!("#{i};2;{r};{g};{b}");
    }
    let rows: Vec<&[Color]> = picture.rgb.chunks_exact(picture.width.max(1)).collect();
    for band in rows.chunks(6) {
        // For each colour, six bits for each column: the rows that have it.
        let mut lines: BTreeMap<usize, Vec<u8>> = BTreeMap::new();
        for (bit, row) in band.iter().enumerate() {
            for (x, pixel) in row.iter().enumerate() {
                let index = index_of.get(&coarse(*pixel)).copied().unwrap_or(0);
                let line = lines.entry(index).or_insert_with(|| vec![0; picture.width]);
                if let Some(bits) = line.get_mut(x) {
                    *bits |= 1 << bit;
                }
            }
        }
        let lines = lines.iter().map(|(index, bits)| format!("#{index}{}", runs(bits)));
        out += &lines.collect::<Vec<_>>().join("$");
        out.push('-');
    }
    out + "\x1b\\\n"
}

/// A line of sixels, repeated ones counted.
fn runs(bits: &[u8]) -> String {
    let mut out = String::new();
    for run in bits.chunk_by(|a, b| a == b) {
        let sixel = char::from(63 + run.first().copied().unwrap_or(0));
        match run.len() {
            n if n > 3 => out += &format!("!{n}{sixel}"),
            n => out.extend(std::iter::repeat_n(sixel, n)),
        }
    }
    out
}

fn coarse(color: Color) -> Color {
    color.map(|v| v >> (8 - BITS))
}

/// At most [`COLORS`] colours by median cut (Heckbert 1982), and which of them each coarse colour is.
fn palette(pixels: &[Color]) -> (Vec<Color>, BTreeMap<Color, usize>) {
    // Sum and number of the pixels of each coarse colour.
    let mut bins: BTreeMap<Color, ([u64; 3], u64)> = BTreeMap::new();
    for pixel in pixels {
        let (sum, count) = bins.entry(coarse(*pixel)).or_default();
        sum.iter_mut().zip(pixel).for_each(|(s, &v)| *s += u64::from(v));
        *count += 1;
    }
    let weight = |bin: &Color| bins.get(bin).map_or(0, |(_, count)| *count);
    let mut boxes: Vec<Vec<Color>> = vec![bins.keys().copied().collect()];
    while boxes.len() < COLORS {
        let spread = |colors: &[Color]| (0..3).map(|c| (extent(colors, c), c)).max().unwrap_or((0, 0));
        let largest = boxes.iter().enumerate().map(|(i, b)| (spread(b), i));
        let Some(((extent, axis), at)) = largest.max().filter(|((extent, _), _)| *extent > 0) else { break };
        debug_assert!(extent > 0);
        let mut colors = boxes.swap_remove(at);
        colors.sort_unstable_by_key(|color| color[axis]);
        let half = colors.iter().map(weight).sum::<u64>() / 2;
        let mut seen = 0;
        let below = colors.iter().take_while(|c| {
            seen += weight(c);
            seen <= half
        });
        let cut = below.count().clamp(1, colors.len() - 1);
        let upper = colors.split_off(cut);
        boxes.extend([colors, upper]);
    }
    let mut index_of = BTreeMap::new();
    let mut palette = Vec::new();
    for (i, colors) in boxes.iter().filter(|b| !b.is_empty()).enumerate() {
        let parts = colors.iter().filter_map(|c| bins.get(c));
        let (sum, count) = parts.fold(([0; 3], 0), |(mut sum, n), (s, k)| {
            sum.iter_mut().zip(s).for_each(|(a, b)| *a += b);
            (sum, n + k)
        });
        palette.push(sum.map(|s| ((s + count / 2) / count.max(1)) as u8));
        colors.iter().for_each(|c| {
            index_of.insert(*c, i);
        });
    }
    (palette, index_of)
}

/// How far colours lie apart in a channel.
fn extent(colors: &[Color], channel: usize) -> u8 {
    let values = || colors.iter().filter_map(|c| c.get(channel).copied());
    values().max().unwrap_or(0) - values().min().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sixel_is_as_the_manual_has_it() {
        // Two columns of red, one of blue, seven rows: two bands.
        let rgb = (0..21).map(|i| if i % 3 < 2 { [255, 0, 0] } else { [0, 0, 255] }).collect();
        let text = encode(&Pixels { width: 3, height: 7, rgb });
        assert!(text.starts_with("\x1bP0;1;0q\"1;1;3;7#0;2;"), "{text:?}");
        assert!(text.contains("~~?") && text.contains("??~") && text.contains("@@?"), "{text:?}");
        assert!(text.ends_with("-\x1b\\\n"));
        assert_eq!(runs(&[63, 63, 63, 63, 0]), "!4~?");
    }

    #[test]
    fn many_colours_become_few_and_near() {
        let pixels: Vec<Color> = (0..60_000u32).map(|i| [i as u8, (i / 256) as u8, (i / 7) as u8]).collect();
        let (palette, index_of) = palette(&pixels);
        assert_eq!(palette.len(), COLORS);
        let far = |p: &Color| {
            let own = palette[index_of[&coarse(*p)]];
            (0..3).map(|c| f64::from(p[c].abs_diff(own[c]))).sum::<f64>() / 3.0
        };
        let mean = pixels.iter().map(far).sum::<f64>() / pixels.len() as f64;
        assert!(mean < 12.0, "{mean}");
        assert_eq!(super::palette(&[]).0, Vec::<Color>::new());
    }
}
