//! A chart after ISO 12233:2000: slanted squares, hyperbolic wedges, line bursts, rings, greys and text.
//!
//! Frequencies are in line widths per picture height (LW/PH), as in the standard. A line pair is two line
//! widths, so a chart of `rows` rows can represent frequencies up to `rows` LW/PH. Labels are in hundreds of
//! LW/PH.

mod letters;

use super::compose::{check_size, grey};
use super::raster::{Canvas, Contour, disc, rectangle, ring};
use super::{Scene, SceneError, Setting};
use crate::numeric::require;

/// The chart, 4:3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResolutionChart {
    /// Rows, 60 to 16384; the chart has 4/3 as many columns.
    pub rows: usize,
    /// Luminance ratio of white to black, more than 1. The standard requires at least 40.
    pub contrast_ratio: f64,
}

/// Draws the chart; every pixel contains its exact mean.
///
/// # Errors
/// When a parameter or the setting is out of range.
pub fn resolution_chart(chart: &ResolutionChart, setting: &Setting) -> Result<Scene, SceneError> {
    let ResolutionChart { rows, contrast_ratio } = *chart;
    require((60..=16384).contains(&rows), "rows", rows as f64, "60 to 16384")?;
    require(contrast_ratio > 1.0, "contrast_ratio", contrast_ratio, "more than 1")?;
    let cols = rows * 4 / 3;
    check_size(rows, cols, setting.grid)?;
    let mut sheet = Sheet {
        canvas: Canvas::new(rows, cols, 1.0),
        unit: rows as f64 / 100.0,
        width: 100.0 * cols as f64 / rows as f64,
        black: (1.0 / contrast_ratio) as f32,
    };
    sheet.draw();
    grey("resolution-chart", rows, cols, sheet.canvas.values(), setting)
}

/// The chart during drawing, in units of a hundredth of its height. A line width of 1 is 100 LW/PH.
struct Sheet {
    canvas: Canvas,
    unit: f64,
    width: f64,
    black: f32,
}

/// Direction of the lines of a wedge or a burst.
#[derive(Clone, Copy, PartialEq)]
enum Lines {
    Upright,
    Level,
    Slanting,
}

const PANGRAM: &str = "SPHINX OF BLACK QUARTZ, JUDGE MY VOW";
const PANGRAM_DIGITS: &str = "SPHINX OF BLACK QUARTZ, JUDGE MY VOW 0123456789";

impl Sheet {
    fn draw(&mut self) {
        let middle = [self.width / 2.0, 50.0];
        self.frame();
        self.fill(&ring(middle, 39.8, 40.2), self.black);

        self.text("SMALTI RESOLUTION CHART", [middle[0], 5.2], 2.6);
        self.text("LABELS X 100 LINE WIDTHS PER PICTURE HEIGHT", [middle[0], 91.6], 1.3);

        for side in [-1.0, 1.0] {
            // The lower half is filled with lines and text, so the arc is omitted there.
            self.clear([middle[0] + side * 28.5, 70.5], 41.0, 35.0);
            for y in [14.0, 86.0] {
                self.rings([middle[0] + side * 54.5, y], 6.2);
            }
            self.slanted_square([middle[0] + side * 26.0, 29.0], 17.0, 5.0 * side);
        }
        for row in 0..4 {
            self.greys([middle[0] - 57.4, 23.0 + 5.2 * f64::from(row)], row);
            self.greys([middle[0] + 44.4, 23.0 + 5.2 * f64::from(row)], row);
        }

        // Coarse wedges are above and to the left of the centre, fine ones below and to the right.
        // Frequencies increase towards the centre.
        self.wedge([middle[0], 12.5], 30.0, [1.0, 6.0], Lines::Upright, 1.0);
        self.wedge([middle[0], 87.5], 30.0, [5.0, 10.0], Lines::Upright, -1.0);
        self.wedge([middle[0] - 48.0, 50.0], 40.0, [1.0, 6.0], Lines::Level, 1.0);
        self.wedge([middle[0] + 48.0, 50.0], 40.0, [5.0, 10.0], Lines::Level, -1.0);
        self.rings(middle, 5.0);

        for i in 0..5 {
            let step = f64::from(i);
            let x = middle[0] + 11.5 + 8.2 * step;
            self.burst([x, 63.0], step + 1.0, Lines::Upright);
            self.burst([x, 73.0], step + 6.0, Lines::Upright);
            self.burst([x, 83.0], 2.0 * step + 2.0, Lines::Slanting);
            self.burst([middle[0] - 45.5 + 8.2 * step, 63.0], step + 1.0, Lines::Level);
        }
        self.text_block([middle[0] - 47.5, 72.5]);
    }

    fn px(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x * self.unit, y * self.unit]
    }

    /// Fills contours, in units of the sheet.
    fn fill(&mut self, contours: &[Contour], value: f32) {
        let scaled = |c: &Contour| c.iter().map(|&p| self.px(p)).collect();
        let contours: Vec<Contour> = contours.iter().map(scaled).collect();
        self.canvas.fill(&contours, value);
    }

    /// Clears an area before something is drawn there.
    fn clear(&mut self, centre: [f64; 2], width: f64, height: f64) {
        self.fill(&[rectangle(centre, width, height, 0.0)], 1.0);
    }

    /// A border, and triangles whose tips touch the edges of the image.
    fn frame(&mut self) {
        let (w, black) = (self.width, self.black);
        let inset = |d: f64| rectangle([w / 2.0, 50.0], w - 2.0 * d, 100.0 - 2.0 * d, 0.0);
        let mut hole = inset(3.0);
        hole.reverse();
        self.fill(&[inset(2.6), hole], black);
        for x in [w * 0.25, w * 0.5, w * 0.75] {
            self.fill(&[vec![[x, 0.0], [x + 1.5, 2.6], [x - 1.5, 2.6]]], black);
            self.fill(&[vec![[x, 100.0], [x + 1.5, 97.4], [x - 1.5, 97.4]]], black);
        }
        for y in [25.0, 50.0, 75.0] {
            self.fill(&[vec![[0.0, y], [2.6, y + 1.5], [2.6, y - 1.5]]], black);
            self.fill(&[vec![[w, y], [w - 2.6, y + 1.5], [w - 2.6, y - 1.5]]], black);
        }
    }

    /// Rings whose frequency increases outwards from 100 to 500 LW/PH.
    fn rings(&mut self, centre: [f64; 2], radius: f64) {
        self.fill(&[disc(centre, radius + 1.0)], 1.0);
        self.fill(&[disc(centre, 0.5)], self.black);
        let mut inner = 1.5;
        while inner < radius {
            // The line width shrinks linearly with the radius.
            let line = 1.0 - 0.8 * inner / radius;
            self.fill(&ring(centre, inner, (inner + line).min(radius)), self.black);
            inner += 2.0 * line;
        }
    }

    fn slanted_square(&mut self, centre: [f64; 2], side: f64, angle_deg: f64) {
        self.clear(centre, 1.2 * side, 1.2 * side);
        self.fill(&[rectangle(centre, side, side, angle_deg.to_radians())], self.black);
    }

    /// Three of the twelve patches from white to black in equal steps of density.
    fn greys(&mut self, [x, y]: [f64; 2], row: u32) {
        for col in 0..3 {
            let share = (3 * row + col) as f32 / 11.0;
            let x = x + 2.2 + 4.3 * f64::from(col);
            self.fill(&[rectangle([x, y], 4.3, 5.2, 0.0)], self.black);
            self.fill(&[rectangle([x, y], 4.1, 5.0, 0.0)], self.black.powf(share));
        }
    }

    /// Five dark lines that taper together. The frequency (in hundreds of LW/PH) is linear along the wedge,
    /// so the line width is hyperbolic. The wedge begins at `start` and extends right or down; with a `sign`
    /// of -1, left or up.
    fn wedge(&mut self, start: [f64; 2], length: f64, frequency: [f64; 2], lines: Lines, sign: f64) {
        const PIECES: usize = 256;
        let upright = lines == Lines::Upright;
        let place = |along: f64, across: f64| {
            let along = sign * along;
            if upright {
                [start[0] + across, start[1] + along]
            } else {
                [start[0] + along, start[1] + across]
            }
        };
        let at = |share: f64| frequency[0] + (frequency[1] - frequency[0]) * share;
        let widest = 4.5 / frequency[0];
        let centre = place(length / 2.0, 0.0);
        let (long, broad) = (length + 2.0, 2.0 * widest + 7.0);
        self.clear(centre, if upright { broad } else { long }, if upright { long } else { broad });
        for line in -2..=2 {
            let edge = |side: f64, i: usize| {
                let share = i as f64 / PIECES as f64;
                place(share * length, (2.0 * f64::from(line) + side / 2.0) / at(share))
            };
            let there = (0..=PIECES).map(|i| edge(-1.0, i));
            let back = (0..=PIECES).rev().map(|i| edge(1.0, i));
            self.fill(&[there.chain(back).collect()], self.black);
        }
        for label in 0..=5 {
            let share = f64::from(label) / 5.0;
            let text = format!("{}", at(share));
            let along = share * length;
            self.fill(
                &[rectangle(
                    place(along, widest + 0.9),
                    0.25 + 0.75 * f64::from(upright),
                    1.0 - 0.75 * f64::from(upright),
                    0.0,
                )],
                self.black,
            );
            self.text_from(&text, place(along, widest + 2.3), 1.4, upright);
        }
    }

    /// Five dark lines of one frequency (in hundreds of LW/PH) about a centre, with a label below.
    fn burst(&mut self, centre: [f64; 2], frequency: f64, lines: Lines) {
        let angle = match lines {
            Lines::Upright => 0.0f64,
            Lines::Level => std::f64::consts::FRAC_PI_2,
            Lines::Slanting => std::f64::consts::FRAC_PI_4,
        };
        let side = 6.0;
        let line = 1.0 / frequency;
        // As many lines as fit; an odd number, so that one passes through the centre.
        let half = ((side / line - 1.0) / 4.0).floor().clamp(0.0, 4.0) as i32;
        self.clear([centre[0], centre[1] + 1.0], side + 1.5, side + 3.5);
        let (s, c) = angle.sin_cos();
        for i in -half..=half {
            let offset = 2.0 * f64::from(i) * line;
            let at = [centre[0] + c * offset, centre[1] + s * offset];
            self.fill(
                &[rectangle(at, line, if lines == Lines::Slanting { 4.5 } else { side }, angle)],
                self.black,
            );
        }
        self.text(&format!("{frequency}"), [centre[0], centre[1] + 4.2], 1.4);
    }

    /// A pangram in letters of shrinking size.
    fn text_block(&mut self, [x, y]: [f64; 2]) {
        let lines = [
            ("SPHINX OF BLACK", 2.4),
            ("QUARTZ, JUDGE MY VOW", 1.8),
            (PANGRAM, 1.05),
            (PANGRAM_DIGITS, 0.8),
            (PANGRAM_DIGITS, 0.6),
            (PANGRAM_DIGITS, 0.45),
        ];
        let mut top = y;
        for (text, height) in lines {
            letters::write(
                &mut self.canvas,
                text,
                [x * self.unit, top * self.unit],
                height * self.unit,
                self.black,
            );
            top += 1.75 * height;
        }
    }

    /// A text on a white background, centred below a point.
    fn text(&mut self, text: &str, [x, y]: [f64; 2], height: f64) {
        let width = letters::width(text) * height;
        self.clear([x, y + height / 2.0], width + height, 1.6 * height);
        let at = self.px([x - width / 2.0, y]);
        letters::write(&mut self.canvas, text, at, height * self.unit, self.black);
    }

    /// A text to the right of a point, or centred below it.
    fn text_from(&mut self, text: &str, [x, y]: [f64; 2], height: f64, right: bool) {
        let width = letters::width(text) * height;
        let corner = if right { [x, y - height / 2.0] } else { [x - width / 2.0, y] };
        let at = self.px(corner);
        letters::write(&mut self.canvas, text, at, height * self.unit, self.black);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bursts_have_the_frequency_of_their_label() {
        // With 1000 rows, lines of 100 LW/PH are ten pixels wide.
        let chart = ResolutionChart { rows: 1000, contrast_ratio: 50.0 };
        let grid = crate::spectrum::WavelengthGrid::new(550.0, 10.0, 1).unwrap();
        let scene = resolution_chart(&chart, &Setting { grid, ..Setting::default() }).unwrap();
        let plane = scene.radiance().planes().plane(0).unwrap();
        let white = scene.illuminant().values()[0] as f32;
        assert!(plane.iter().all(|&v| v <= white * 1.000_001 && v >= white / 50.000_1));
        // The vertical burst of 200 LW/PH has dark lines of five pixels with a period of ten.
        let (row, middle) = (630, (100.0 * 1333.0 / 1000.0 / 2.0 + 11.5 + 8.2) * 10.0);
        let line = &plane[row * 1333..(row + 1) * 1333];
        let dark = |x: f64| line[x as usize] < white / 2.0;
        for i in -2..=2 {
            let x = middle + 10.0 * f64::from(i);
            assert!(dark(x) && dark(x - 1.9) && dark(x + 1.9) && !dark(x + 4.0) && !dark(x - 4.0));
        }
    }

    #[test]
    fn letters_have_strokes_inside_their_box() {
        for letter in ('A'..='Z').chain('0'..='9') {
            let mut canvas = Canvas::new(20, 20, 1.0);
            letters::write(&mut canvas, &letter.to_string(), [4.0, 4.0], 12.0, 0.0);
            let dark = (0..400).filter(|&i| canvas.values()[i] < 0.5);
            let inside = |i: usize| (2..18).contains(&(i / 20)) && (2..14).contains(&(i % 20));
            assert!(dark.clone().count() > 10 && dark.clone().all(inside), "{letter}");
        }
    }
}
