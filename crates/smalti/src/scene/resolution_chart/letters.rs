//! Capital letters and digits as strokes.

use crate::scene::raster::{Canvas, Contour, disc};

/// Strokes on a grid of 4 × 6 steps: `xy` per corner, y from the top, with `|` between strokes.
fn strokes(letter: char) -> &'static str {
    match letter {
        'A' => "06 20 46|14 34",
        'B' => "00 30 41 42 33 03|33 44 45 36 06 00",
        'C' => "41 30 10 01 05 16 36 45",
        'D' => "00 20 42 44 26 06 00",
        'E' => "40 00 06 46|03 33",
        'F' => "40 00 06|03 33",
        'G' => "41 30 10 01 05 16 36 45 43 23",
        'H' => "00 06|40 46|03 43",
        'I' => "10 30|20 26|16 36",
        'J' => "40 45 36 16 05",
        'K' => "00 06|40 03 46",
        'L' => "00 06 46",
        'M' => "06 00 23 40 46",
        'N' => "06 00 46 40",
        'O' => "10 30 41 45 36 16 05 01 10",
        'P' => "06 00 30 41 42 33 03",
        'Q' => "10 30 41 45 36 16 05 01 10|24 46",
        'R' => "06 00 30 41 42 33 03|23 46",
        'S' => "41 30 10 01 02 13 33 44 45 36 16 05",
        'T' => "00 40|20 26",
        'U' => "00 05 16 36 45 40",
        'V' => "00 26 40",
        'W' => "00 16 23 36 40",
        'X' => "00 46|40 06",
        'Y' => "00 23 40|23 26",
        'Z' => "00 40 06 46",
        '0' => "10 30 41 45 36 16 05 01 10|14 32",
        '1' => "11 20 26|16 36",
        '2' => "01 10 30 41 42 06 46",
        '3' => "01 10 30 41 42 33 13|33 44 45 36 16 05",
        '4' => "36 30 04 44",
        '5' => "40 00 02 32 43 45 36 06",
        '6' => "40 20 02 05 16 36 45 44 33 03",
        '7' => "00 40 16",
        '8' => "10 30 41 42 33 13 02 01 10|13 04 05 16 36 45 44 33",
        '9' => "43 13 02 01 10 30 41 44 26 06",
        '.' => "16 16",
        ',' => "15 06",
        '-' => "13 33",
        '/' => "06 40",
        _ => "",
    }
}

/// Width of a text in units of its height; each letter advances by six grid steps.
pub(super) fn width(text: &str) -> f64 {
    (text.chars().count() as f64 - 1.0 / 3.0).max(0.0)
}

/// Draws a text with its top left corner at (x, y) and letters of `height`, all in pixels. Letters that are
/// not in the font are skipped.
pub(super) fn write(canvas: &mut Canvas, text: &str, [x, y]: [f64; 2], height: f64, value: f32) {
    let step = height / 6.0;
    let half = 0.42 * step;
    for (i, letter) in text.chars().enumerate() {
        let left = x + i as f64 * height;
        let point = |token: &str| {
            let mut digits = token.chars().filter_map(|c| c.to_digit(10)).map(f64::from);
            let (u, v) = (digits.next().unwrap_or(0.0), digits.next().unwrap_or(0.0));
            [left + u * step, y + v * step]
        };
        for stroke in strokes(letter).split('|') {
            let points: Vec<[f64; 2]> = stroke.split_whitespace().map(point).collect();
            for pair in points.windows(2) {
                canvas.fill(&[line(pair[0], pair[1], half)], value);
            }
            points.iter().for_each(|&p| canvas.fill(&[disc(p, half)], value));
        }
    }
}

/// A straight line as a rectangle that extends `half` to either side.
fn line(a: [f64; 2], b: [f64; 2], half: f64) -> Contour {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
    let (nx, ny) = (-dy / length * half, dx / length * half);
    vec![[a[0] + nx, a[1] + ny], [b[0] + nx, b[1] + ny], [b[0] - nx, b[1] - ny], [a[0] - nx, a[1] - ny]]
}
