//! The tile of a colour filter array: coloured cells with letters, and the legend of the letters.

use serde_json::{Value, json};
use smalti::names::{in_one_line, steers};
use smalti::sensor::{Cfa, Channel};
use smalti::spectrum::Spectrum;
use smalti_report::{Cell, Figure, Mosaics, Rgb, filter_color};

use crate::terminal::Screen;

/// Widths and heights of a cell in characters, largest first. Two columns are about as wide as a row is high.
const CELLS: [(usize, usize); 4] = [(7, 3), (3, 1), (2, 1), (1, 1)];
/// Tiles of more rows have smaller cells.
const ROWS_OF_LARGE_CELLS: usize = 6;
/// Columns that the legend needs beside the tile.
const LEGEND_COLUMNS: usize = 44;
/// The range of luma of curves: others would vanish on a white or a black background.
const LUMA: (f64, f64) = (80.0, 165.0);

/// A tile and its channels.
pub(super) struct Tile {
    pub(super) cols: usize,
    /// The channel of each cell, row by row.
    pub(super) cells: Vec<u8>,
    pub(super) channels: Vec<Entry>,
}

/// A channel in the legend.
pub(super) struct Entry {
    pub(super) letter: char,
    /// The name of its filter; empty where there is none but the letter.
    pub(super) name: String,
    /// The colour of its filter in daylight.
    pub(super) color: Rgb,
    pub(super) curve: Spectrum,
    cells: usize,
    share: f64,
}

impl Tile {
    /// `named` returns the name of a filter that has a single letter.
    pub(super) fn of(cfa: &Cfa, named: impl Fn(char) -> Option<String>) -> anyhow::Result<Self> {
        let mosaic = cfa.mosaic();
        let cells = mosaic.cells().to_vec();
        let letters = letters(cfa.channels());
        let entry = |(i, (channel, letter)): (usize, (&Channel, char))| {
            let count = cells.iter().filter(|&&c| usize::from(c) == i).count();
            let name =
                if channel.name.chars().count() > 1 { Some(channel.name.clone()) } else { named(letter) };
            anyhow::Ok(Entry {
                letter,
                name: name.unwrap_or_default(),
                color: looks(&channel.transmittance)?,
                curve: channel.transmittance.clone(),
                cells: count,
                share: count as f64 / cells.len().max(1) as f64,
            })
        };
        let channels = cfa.channels().iter().zip(letters).enumerate().map(entry).collect::<Result<_, _>>()?;
        Ok(Self { cols: mosaic.cols(), cells, channels })
    }

    fn rows(&self) -> usize {
        self.cells.len() / self.cols.max(1)
    }

    fn entry(&self, cell: u8) -> Option<&Entry> {
        self.channels.get(usize::from(cell))
    }

    /// The pattern in letters, in the form of the key `pattern` of a camera file.
    pub(super) fn pattern(&self) -> Vec<String> {
        let letter = |&c: &u8| self.entry(c).map_or('?', |e| e.letter);
        self.cells.chunks(self.cols.max(1)).map(|row| row.iter().map(letter).collect()).collect()
    }

    /// The cells as characters, with the legend beside them where there is room, else below.
    pub(super) fn lines(&self, screen: &Screen) -> String {
        let fits = |&(width, height): &(usize, usize)| {
            width * self.cols <= screen.columns && (height == 1 || self.rows() <= ROWS_OF_LARGE_CELLS)
        };
        // Without colours, only the letter is visible.
        let sizes = if screen.depth.is_some() { &CELLS[..] } else { &CELLS[2..] };
        let (width, height) = sizes.iter().copied().find(fits).unwrap_or((1, 1));
        let shown = self.cols.min(screen.columns / width);
        let mut lines = Vec::new();
        for row in self.cells.chunks(self.cols.max(1)) {
            for l in 0..height {
                let cell = |c: &u8| {
                    let Some(entry) = self.entry(*c) else { return " ".repeat(width) };
                    let letter = if l == height / 2 { entry.letter } else { ' ' };
                    let before = (width - 1) / 2;
                    let text = format!("{}{letter}{}", " ".repeat(before), " ".repeat(width - 1 - before));
                    screen.on_color(entry.color, &text)
                };
                lines.push(row.iter().take(shown).map(cell).collect::<String>());
            }
        }
        let legend = self.legend(screen);
        if width * shown + 3 + LEGEND_COLUMNS > screen.columns {
            return lines.join("\n") + "\n\n" + &legend;
        }
        let mut beside = legend.lines();
        let blank = " ".repeat(width * shown);
        let rows = lines.len().max(legend.lines().count());
        let joined = (0..rows).map(|i| {
            let left = lines.get(i).map_or(blank.as_str(), String::as_str);
            match beside.next() {
                Some(text) => format!("{left}   {text}\n"),
                None => format!("{}\n", left.trim_end()),
            }
        });
        joined.collect()
    }

    /// A line for each channel: letter, share of the cells, peak.
    pub(super) fn legend(&self, screen: &Screen) -> String {
        let line = |e: &Entry| {
            let (nm, peak) = peak(&e.curve);
            let flat = e.curve.values().iter().all(|v| peak - v < 0.005);
            let peak = if flat { format!("flat {peak:.2}") } else { format!("peak {peak:.2} at {nm:.0} nm") };
            let letter = match screen.depth {
                Some(_) => screen.on_color(e.color, &format!(" {} ", e.letter)),
                None => e.letter.to_string(),
            };
            let text = format!("{:>5.1} %  {peak:<19}  {}", 100.0 * e.share, in_one_line(&e.name));
            format!("{letter} {}\n", text.trim_end())
        };
        self.channels.iter().map(line).collect()
    }

    /// The tile as a figure, repeated around itself.
    pub(super) fn figure(&self) -> anyhow::Result<Figure> {
        let cell = |c: &u8| match self.entry(*c) {
            Some(e) => Cell { letter: e.letter.to_string(), color: e.color },
            None => Cell { letter: String::new(), color: Rgb(128, 128, 128) },
        };
        let cells: Vec<Cell> = self.cells.iter().map(cell).collect();
        Ok(Mosaics::new().side(360.0).mosaic("", self.cols, &cells).draw()?)
    }

    /// How wide the figure is shown.
    pub(super) fn figure_columns(&self) -> usize {
        (14 + 2 * self.cols.max(self.rows())).min(40)
    }

    pub(super) fn json(&self) -> Value {
        let channel = |e: &Entry| {
            let (peak_nm, peak) = peak(&e.curve);
            json!({
                "letter": e.letter.to_string(), "name": e.name, "color": e.color.to_string(), "cells": e.cells, "share": e.share,
                "peak_nm": peak_nm, "peak": peak, "transmittance": e.curve.values(),
            })
        };
        json!({
            "rows": self.rows(), "cols": self.cols, "pattern": self.pattern(),
            "channels": self.channels.iter().map(channel).collect::<Vec<_>>(),
        })
    }
}

/// The letters of channels: their names, and from `a` on where those are longer, as patterns of mixtures have them.
fn letters(channels: &[Channel]) -> Vec<char> {
    let mut names = channels.iter().map(|c| (c.name.chars().next().unwrap_or('?'), c.name.chars().count()));
    if names.clone().all(|(letter, count)| count == 1 && !steers(letter)) {
        return names.map(|(letter, _)| letter).collect();
    }
    let others = ('a'..='z').chain('A'..='Z').chain(std::iter::repeat('?'));
    others.take(names.by_ref().count()).collect()
}

/// The colour of a filter in daylight.
pub(super) fn looks(filter: &Spectrum) -> anyhow::Result<Rgb> {
    let [r, g, b] = filter_color(filter)?.map(|v| (v * 255.0).round() as u8);
    Ok(Rgb(r, g, b))
}

/// A colour for lines that is visible on black and on white.
pub(super) fn for_lines(color: Rgb) -> Rgb {
    let luma = |Rgb(r, g, b): Rgb| 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b);
    let own = luma(color);
    if own < LUMA.0 {
        return color.mix(Rgb(255, 255, 255), (LUMA.0 - own) / (255.0 - own));
    }
    color.mix(Rgb(0, 0, 0), (1.0 - LUMA.1 / own).max(0.0))
}

/// Wavelength and value of the largest sample.
pub(super) fn peak(curve: &Spectrum) -> (f64, f64) {
    let samples = curve.grid();
    let samples = samples.wavelengths_nm().zip(curve.values().iter().copied());
    samples.fold((0.0, f64::NEG_INFINITY), |best, s| if s.1 > best.1 { s } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use smalti::sensor::cfa;
    use smalti::spectrum::WavelengthGrid;

    #[test]
    fn every_tile_of_the_catalogue_is_drawn_as_its_pattern() {
        let screen = Screen { columns: 100, rows: None, protocol: None, depth: None };
        for info in cfa::names() {
            let cfa = cfa::builtin(info.name, WavelengthGrid::VISIBLE).unwrap();
            let tile = Tile::of(&cfa, |_| None).unwrap();
            assert_eq!(tile.pattern(), info.pattern().unwrap(), "{}", info.name);
            let shares: f64 = tile.channels.iter().map(|c| c.share).sum();
            assert!(
                (shares - 1.0).abs() < 1e-12 && tile.channels.iter().all(|c| c.cells > 0),
                "{}",
                info.name
            );
            let letters: String = tile.lines(&screen).lines().take(1).collect();
            let row: String = letters.chars().filter(|c| *c != ' ').take(info.cols()).collect();
            assert_eq!(row, info.pattern().unwrap()[0], "{}", info.name);
        }
    }

    #[test]
    fn lines_are_seen_on_black_and_on_white() {
        for color in [Rgb(0, 0, 0), Rgb(255, 255, 255), Rgb(64, 64, 230), Rgb(255, 255, 0)] {
            let Rgb(r, g, b) = for_lines(color);
            let luma = 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b);
            assert!((LUMA.0 - 2.0..=LUMA.1 + 2.0).contains(&luma), "{color} {luma}");
        }
    }
}
