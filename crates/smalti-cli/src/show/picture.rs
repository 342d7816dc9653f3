//! Pictures as characters, each of which shows two pixels, one above the other.

use anyhow::Context;
use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;
use smalti_report::Rgb;

use crate::terminal::Screen;

/// Characters from dark to bright, for terminals without colours.
const RAMP: &[u8] = b" .:-=+*#%@";
/// The largest width of a picture without colours.
const LETTER_COLUMNS: usize = 72;
/// Rows left for the text above.
const ROWS_ABOVE: usize = 8;

/// A picture, 8-bit sRGB.
pub(super) struct Pixels {
    pub(super) width: usize,
    pub(super) height: usize,
    /// `width * height` pixels, row by row.
    pub(super) rgb: Vec<[u8; 3]>,
}

impl Pixels {
    /// From a picture in any colour space.
    pub(super) fn of(image: &Image) -> anyhow::Result<Self> {
        let image = image.converted(ColorSpace::Srgb)?;
        let rgb = image.rgb8().as_chunks::<3>().0.to_vec();
        Ok(Self { width: image.cols(), height: image.rows(), rgb })
    }

    /// From the PNG of a figure.
    pub(super) fn from_png(png: &[u8]) -> anyhow::Result<Self> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info()?;
        let mut bytes = vec![0; reader.output_buffer_size().context("the figure has no size")?];
        let info = reader.next_frame(&mut bytes)?;
        let rgb = bytes.as_chunks::<3>().0.to_vec();
        Ok(Self { width: info.width as usize, height: info.height as usize, rgb })
    }

    pub(super) fn png(&self) -> anyhow::Result<Vec<u8>> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header()?.write_image_data(self.rgb.as_flattened())?;
        Ok(out)
    }

    /// Scaled down to a width with the aspect ratio kept; unchanged when not wider.
    pub(super) fn at_most(&self, width: usize) -> Self {
        if self.width <= width {
            return Self { width: self.width, height: self.height, rgb: self.rgb.clone() };
        }
        let height = (self.height * width).div_ceil(self.width.max(1)).max(1);
        self.resized(width, height)
    }

    /// Resampled by the mean of the pixels that fall into each, or the nearest pixel.
    fn resized(&self, width: usize, height: usize) -> Self {
        let from = |i: usize, old: usize, new: usize| (i * old / new, ((i + 1) * old).div_ceil(new));
        let mut rgb = Vec::with_capacity(width * height);
        for y in 0..height {
            let (top, bottom) = from(y, self.height, height);
            for x in 0..width {
                let (left, right) = from(x, self.width, width);
                let (mut sum, mut count) = ([0u32; 3], 0u32);
                for row in self.rgb.chunks_exact(self.width.max(1)).take(bottom).skip(top) {
                    for pixel in row.iter().take(right).skip(left) {
                        sum.iter_mut().zip(pixel).for_each(|(s, &v)| *s += u32::from(v));
                        count += 1;
                    }
                }
                rgb.push(sum.map(|s| ((s + count / 2) / count.max(1)) as u8));
            }
        }
        Self { width, height, rgb }
    }

    /// The columns that the picture fills: at most its own, such that all of its rows are visible.
    pub(super) fn columns_on(&self, screen: &Screen) -> usize {
        let by_height = most_rows(screen).saturating_mul(2).saturating_mul(self.width) / self.height.max(1);
        screen.columns.min(by_height).min(self.width).max(1)
    }

    /// Half blocks where there are colours, else characters whose density shows the brightness.
    pub(super) fn lines(&self, screen: &Screen) -> String {
        let columns = self.columns_on(screen);
        if screen.depth.is_none() {
            let columns = columns.min(LETTER_COLUMNS);
            // A picture that is higher than the screen at a width of one column is squeezed.
            let rows = (self.height * columns / self.width.max(1) / 2).clamp(1, most_rows(screen));
            let line = |row: &[[u8; 3]]| {
                row.iter().map(|p| shade(*p)).collect::<String>().trim_end().to_owned() + "\n"
            };
            return self.resized(columns, rows).rgb.chunks(columns).map(line).collect();
        }
        let rows = (self.height * columns / self.width.max(1)).clamp(1, most_rows(screen).saturating_mul(2));
        let small = self.resized(columns, rows);
        let rows: Vec<&[[u8; 3]]> = small.rgb.chunks_exact(columns).collect();
        let line = |pair: &[&[[u8; 3]]]| {
            let [above, rest @ ..] = pair else { return String::new() };
            let (mut out, mut before) = (String::new(), String::new());
            for (x, &[r, g, b]) in above.iter().enumerate() {
                let below = rest.first().and_then(|row| row.get(x)).map(|&[r, g, b]| Rgb(r, g, b));
                let colors = screen.colors(Rgb(r, g, b), below);
                // Neighbours often have equal colours; omitting these codes halves the output.
                if colors != before {
                    out += &colors;
                    before = colors;
                }
                out.push('▀');
            }
            out + "\x1b[0m\n"
        };
        rows.chunks(2).map(line).collect()
    }
}

/// The most rows of a picture.
fn most_rows(screen: &Screen) -> usize {
    screen.rows.map_or(usize::MAX, |rows| rows.saturating_sub(ROWS_ABOVE).max(4))
}

/// The character of a brightness.
fn shade([r, g, b]: [u8; 3]) -> char {
    let luma = 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b);
    let index = (luma / 256.0 * RAMP.len() as f64) as usize;
    RAMP.get(index).map_or(' ', |&c| char::from(c))
}

/// A picture reduced in linear light to at most `most` columns, since scenes are large.
pub(super) fn reduced(image: &Image, most: usize) -> anyhow::Result<Image> {
    let step = image.cols().div_ceil(most).max(1);
    let (rows, cols) = (image.rows().div_ceil(step), image.cols().div_ceil(step));
    let mut out = Planes::zeros(rows, cols, 3);
    for (plane, out) in image.channels().into_iter().zip(out.planes_mut()) {
        for (y, line) in out.chunks_exact_mut(cols).enumerate() {
            for (x, value) in line.iter_mut().enumerate() {
                let block = plane.chunks_exact(image.cols()).skip(y * step).take(step);
                let block = block.flat_map(|row| row.iter().skip(x * step).take(step));
                let (sum, count) = block.fold((0.0, 0u32), |(sum, n), &v| (sum + f64::from(v), n + 1));
                *value = (sum / f64::from(count.max(1))) as f32;
            }
        }
    }
    Ok(Image::new(image.space(), out)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terminal::Depth;

    fn screen(columns: usize, depth: Option<Depth>) -> Screen {
        Screen { columns, rows: None, protocol: None, depth }
    }

    fn picture(width: usize, height: usize, color: impl Fn(usize, usize) -> [u8; 3]) -> Pixels {
        let rgb =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| color(x, y)).collect();
        Pixels { width, height, rgb }
    }

    #[test]
    fn a_half_block_has_two_pixels() {
        let two = picture(1, 2, |_, y| if y == 0 { [1, 2, 3] } else { [4, 5, 6] });
        assert_eq!(two.lines(&screen(80, Some(Depth::True))), "\x1b[38;2;1;2;3;48;2;4;5;6m▀\x1b[0m\n");
        let odd = picture(1, 1, |_, _| [1, 2, 3]);
        assert_eq!(odd.lines(&screen(80, Some(Depth::True))), "\x1b[0;38;2;1;2;3m▀\x1b[0m\n");
    }

    #[test]
    fn the_mean_stays() {
        let board = picture(64, 48, |x, y| if (x + y) % 2 == 0 { [255, 0, 100] } else { [1, 0, 100] });
        for width in [1, 3, 16, 32] {
            let small = board.at_most(width);
            assert_eq!((small.width, small.rgb.len()), (width, small.width * small.height));
            assert!(small.rgb.iter().all(|p| p[0].abs_diff(128) < 45 && p[1] == 0 && p[2] == 100), "{width}");
        }
        assert_eq!(board.at_most(100).rgb, board.rgb);
    }

    #[test]
    fn every_shape_is_drawn_within_the_screen() {
        for (width, height) in [(1, 1), (1, 1000), (1000, 1), (640, 480), (7, 5)] {
            let grey = picture(width, height, |_, _| [128, 128, 128]);
            for columns in [20, 80] {
                let screen = Screen { rows: Some(24), ..screen(columns, None) };
                let text = grey.lines(&screen);
                assert!(
                    text.lines().all(|l| l.chars().count() <= columns) && text.lines().count() <= 16,
                    "{text}"
                );
                assert!(!grey.lines(&Screen { depth: Some(Depth::Indexed), ..screen }).is_empty());
            }
        }
    }

    #[test]
    fn a_png_holds_the_picture() {
        let some = picture(5, 3, |x, y| [x as u8 * 50, y as u8 * 80, 7]);
        let again = Pixels::from_png(&some.png().unwrap()).unwrap();
        assert_eq!((again.width, again.height, again.rgb), (5, 3, some.rgb));
    }
}
