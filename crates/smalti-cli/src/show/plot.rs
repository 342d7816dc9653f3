//! Curves over wavelength in characters.

use smalti::names::in_one_line;
use smalti::spectrum::Spectrum;
use smalti_report::{Figure, Line, Rgb};

use crate::terminal::Screen;

/// Characters across and down the field of a plot.
pub(super) const COLUMNS: usize = 72;
const ROWS: usize = 11;
/// Smaller values are not drawn, because curves would hide each other at zero.
const MIN_VALUE: f64 = 0.01;
/// Columns left of the field, for numbers and the axis.
pub(super) const MARGIN: usize = 5;
/// Dots of a character: columns, rows.
const DOTS: (usize, usize) = (2, 4);
/// The dots of a Braille character (Unicode, block 2800), by rows.
const BRAILLE: [[u8; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];

/// Curves over wavelength, from 0 to 1.
pub(super) struct Plot {
    pub(super) title: String,
    /// The quantity of the vertical axis.
    pub(super) quantity: &'static str,
    pub(super) curves: Vec<Curve>,
}

pub(super) struct Curve {
    pub(super) letter: char,
    pub(super) color: Rgb,
    pub(super) values: Spectrum,
}

/// A character of the field: which dots are set, and by which curve last.
#[derive(Clone, Copy, Default)]
struct Mark {
    dots: u8,
    curve: usize,
}

impl Plot {
    /// The range of wavelengths, nm.
    fn range(&self) -> (f64, f64) {
        let ends = self.curves.iter().map(|c| (c.values.grid().start_nm(), c.values.grid().end_nm()));
        ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (a, b)| (low.min(a), high.max(b)))
    }

    /// Braille dots where colours distinguish the curves, else their letters.
    pub(super) fn lines(&self, screen: &Screen) -> String {
        let columns = COLUMNS.min(screen.columns - MARGIN);
        let (across, down) = if screen.depth.is_some() { DOTS } else { (1, 1) };
        let mut field = vec![vec![Mark::default(); columns]; ROWS];
        let (low, high) = self.range();
        for (index, curve) in self.curves.iter().enumerate() {
            let (width, height) = (columns * across, ROWS * down);
            let mut before: Option<usize> = None;
            for x in 0..width {
                let nm = low + (high - low) * x as f64 / (width - 1).max(1) as f64;
                let Some(value) = curve.values.at(nm) else { continue };
                if value < MIN_VALUE {
                    before = None;
                    continue;
                }
                let y = ((1.0 - value.clamp(0.0, 1.0)) * (height - 1) as f64).round() as usize;
                // A steep edge is drawn without gaps, from the height of the previous dot.
                let from = before.map_or(y, |b| if b < y { b + 1 } else { b.saturating_sub(1).max(y) });
                for dot in from.min(y)..=from.max(y) {
                    if let Some(mark) = field.get_mut(dot / down).and_then(|row| row.get_mut(x / across)) {
                        let bits = BRAILLE[dot % down][x % across];
                        *mark = Mark { dots: mark.dots | bits, curve: index };
                    }
                }
                before = Some(y);
            }
        }
        let mut out = format!("{}\n", in_one_line(&self.title));
        for (r, row) in field.iter().enumerate() {
            let label = match r {
                0 => "1.0",
                r if r == ROWS / 2 => "0.5",
                r if r == ROWS - 1 => "0.0",
                _ => "",
            };
            let tick = if label.is_empty() { '│' } else { '┤' };
            let marks: Vec<String> = row.iter().map(|m| self.mark(*m, screen)).collect();
            out += &format!("{label:>3} {tick}{}\n", marks.concat().trim_end());
        }
        out + &axis(low, high, columns)
    }

    fn mark(&self, mark: Mark, screen: &Screen) -> String {
        let Some(curve) = self.curves.get(mark.curve).filter(|_| mark.dots != 0) else { return " ".into() };
        match screen.depth {
            Some(_) => {
                let braille = char::from_u32(0x2800 + u32::from(mark.dots)).unwrap_or('·');
                screen.colored(curve.color, &braille.to_string())
            }
            None => curve.letter.to_string(),
        }
    }

    /// The plot as a figure.
    pub(super) fn figure(&self) -> anyhow::Result<Figure> {
        let (low, high) = self.range();
        let mut plot = smalti_report::Plot::spectra(self.quantity).title(&self.title);
        plot = plot.size(900.0, 420.0).y_range(0.0, 1.02);
        if low < high {
            plot = plot.x_range(low, high);
        }
        for curve in &self.curves {
            let grid = curve.values.grid();
            let nm: Vec<f64> = grid.wavelengths_nm().collect();
            let line = Line::new(curve.letter.to_string(), &nm, curve.values.values());
            plot = plot.line(line.color(curve.color).width(2.5));
        }
        Ok(plot.draw()?)
    }
}

/// The axis of wavelengths with its numbers.
fn axis(low: f64, high: f64, columns: usize) -> String {
    let steps = [10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0];
    // Eight characters for each number and the space after it.
    let few = |step: &f64| (high - low) / step * 8.0 <= columns as f64;
    let step = steps.into_iter().find(few).unwrap_or(1e4);
    let at = |nm: f64| ((nm - low) / (high - low).max(1e-9) * (columns - 1) as f64).round() as usize;
    let (mut line, mut numbers) = (vec!['─'; columns], vec![' '; columns + 8]);
    let mut nm = (low / step - 1e-9).ceil() * step;
    while nm <= high + 1e-9 {
        if let Some(tick) = line.get_mut(at(nm)) {
            *tick = '┬';
        }
        let text = format!("{nm:.0}");
        let start = at(nm).saturating_sub(text.len() / 2);
        numbers.iter_mut().skip(start).zip(text.chars()).for_each(|(place, c)| *place = c);
        nm += step;
    }
    let line: String = line.into_iter().collect();
    let numbers: String = numbers.into_iter().collect();
    format!("    └{line}\n     {}{}\n", numbers.trim_end(), " nm")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terminal::Depth;
    use smalti::spectrum::WavelengthGrid;

    fn plot(curves: Vec<(char, Spectrum)>) -> Plot {
        let curve = |(letter, values)| Curve { letter, color: Rgb(200, 0, 0), values };
        Plot {
            title: "Filters".into(),
            quantity: "Transmittance",
            curves: curves.into_iter().map(curve).collect(),
        }
    }

    fn screen(columns: usize, depth: Option<Depth>) -> Screen {
        Screen { columns, rows: None, protocol: None, depth }
    }

    #[test]
    fn values_stand_at_their_height() {
        let grid = WavelengthGrid::VISIBLE;
        let text = plot(vec![
            ('T', Spectrum::constant(grid, 1.0).unwrap()),
            ('B', Spectrum::constant(grid, 0.02).unwrap()),
            ('Z', Spectrum::constant(grid, 0.0).unwrap()),
            ('M', Spectrum::constant(grid, 0.5).unwrap()),
        ])
        .lines(&screen(80, None));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], format!("1.0 ┤{}", "T".repeat(COLUMNS)));
        assert_eq!(lines[6], format!("0.5 ┤{}", "M".repeat(COLUMNS)));
        assert_eq!(lines[ROWS], format!("0.0 ┤{}", "B".repeat(COLUMNS)));
        assert!(lines[ROWS + 2].contains("400") && lines[ROWS + 2].contains("700"), "{text}");
        // Beyond 0 to 1 a curve runs along the edge.
        let text = plot(vec![('T', Spectrum::constant(grid, 7.0).unwrap())]).lines(&screen(80, None));
        assert!(text.lines().nth(1).unwrap().ends_with("TTT"), "{text}");
    }

    #[test]
    fn an_edge_is_drawn_without_gaps() {
        let step =
            Spectrum::from_fn(WavelengthGrid::VISIBLE, |nm| if nm < 550.0 { 0.02 } else { 1.0 }).unwrap();
        let text = plot(vec![('S', step)]).lines(&screen(80, None));
        assert!(text.lines().skip(1).take(ROWS).all(|l| l.contains('S')), "{text}");
    }

    #[test]
    fn every_width_and_range_is_drawn() {
        for (start, step, count) in [(400.0, 10.0, 31), (550.0, 10.0, 1), (400.0, 100.0, 40), (380.0, 1.0, 2)]
        {
            let grid = WavelengthGrid::new(start, step, count).unwrap();
            for columns in [20, 21, 40, 80, 200] {
                for depth in [None, Some(Depth::True)] {
                    let text = plot(vec![('a', Spectrum::constant(grid, 0.3).unwrap())])
                        .lines(&screen(columns, depth));
                    assert_eq!(text.lines().count(), ROWS + 3, "{text}");
                    assert!(
                        text.contains(if depth.is_some() { "\x1b[38;2;200;0;0m" } else { "a" }),
                        "{text}"
                    );
                }
            }
        }
        let none = plot(vec![]).lines(&screen(80, None));
        assert!(none.starts_with("Filters"), "{none}");
    }
}
