//! Mosaics as coloured tiles, side by side.

use crate::color::Rgb;
use crate::figure::{check_size, setters};
use crate::svg::{Anchor, Area, INK, Paint, SOFT, Svg};
use crate::text::{Font, bold, clean, plain, wrap};
use crate::{Figure, FigureError};

/// Mosaics per row.
const COLUMNS: usize = 5;
/// The width of a mosaic in pixels.
const SIDE: f64 = 220.0;
/// The most cells of one mosaic; more cells would be too small to distinguish.
const CELLS_LIMIT: usize = 64 * 64;
const MARGIN: f64 = 20.0;
const GAP: f64 = 32.0;
const TITLE: Font = bold(22.0);
const CAPTION: Font = bold(17.0);
const NOTE: Font = plain(14.0);

/// One cell of a mosaic: the letter of its filter and its colour.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cell {
    /// The letter in the cell; may be empty.
    pub letter: String,
    /// Its colour; [`Rgb::of_transmittance`] returns the approximate colour of a filter.
    pub color: Rgb,
}

#[derive(Debug, Clone, PartialEq)]
struct Tile {
    caption: String,
    cols: usize,
    cells: Vec<Cell>,
}

/// Mosaics side by side, each with its caption. The tile is repeated around itself in paler colours, as on the
/// sensor; a frame marks one period.
///
/// ```
/// use smalti_report::{Cell, Mosaics, Rgb};
///
/// let cell = |letter: &str, color| Cell { letter: letter.into(), color };
/// let (r, g, b) = (cell("R", Rgb(200, 40, 40)), cell("G", Rgb(40, 150, 60)), cell("B", Rgb(40, 70, 190)));
/// let figure = Mosaics::new().mosaic("Bayer", 2, &[r, g.clone(), g, b]).draw()?;
/// assert!(figure.svg().contains("Bayer"));
/// # Ok::<(), smalti_report::FigureError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mosaics {
    title: String,
    note: String,
    side: Option<f64>,
    tiles: Vec<Tile>,
}

impl Mosaics {
    /// A figure without mosaics, with five mosaics per row, each 220 pixels wide.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    setters! {
        /// Sets the title above all mosaics.
        title(title: impl Into<String>) { title = title.into() }
        /// Sets a note in small print below.
        note(note: impl Into<String>) { note = note.into() }
        /// Sets the width of each mosaic in pixels.
        side(side: f64) { side = Some(side) }
    }

    /// Adds a mosaic from the cells of one tile by rows, with `cols` cells per row.
    #[must_use]
    pub fn mosaic(mut self, caption: impl Into<String>, cols: usize, cells: &[Cell]) -> Self {
        self.tiles.push(Tile { caption: caption.into(), cols, cells: cells.to_vec() });
        self
    }

    /// The figure.
    ///
    /// # Errors
    /// [`FigureError::Nothing`] without a mosaic, [`FigureError::Mosaic`] for one whose cells do not fill its rows, and
    /// [`FigureError::Size`].
    pub fn draw(&self) -> Result<Figure, FigureError> {
        if self.tiles.is_empty() {
            return Err(FigureError::Nothing { what: "mosaic" });
        }
        for tile in &self.tiles {
            let cells = tile.cells.len();
            if cells == 0 || cells > CELLS_LIMIT || tile.cols == 0 || !cells.is_multiple_of(tile.cols) {
                let caption = clean(&tile.caption);
                return Err(FigureError::Mosaic { caption, cells, cols: tile.cols, limit: CELLS_LIMIT });
            }
        }
        let columns = COLUMNS.min(self.tiles.len());
        let side = self.side.unwrap_or(SIDE);
        check_size(side, side)?;
        let width = 2.0 * MARGIN + columns as f64 * (side + GAP) - GAP;
        let captions: Vec<Vec<String>> =
            self.tiles.iter().map(|t| wrap(&t.caption, CAPTION, side, 3)).collect();
        let caption_height =
            captions.iter().map(Vec::len).max().unwrap_or(0) as f64 * CAPTION.size * 1.25 + 12.0;
        let mut svg = Svg::default();
        let mut top = MARGIN;
        for line in wrap(&self.title, TITLE, width - 2.0 * MARGIN, 3) {
            top += TITLE.size * 1.25;
            svg.text((MARGIN, top - 6.0), Anchor::Start, TITLE, INK, &line);
        }
        if top > MARGIN {
            top += 12.0;
        }
        for ((row, tiles), captions) in self.tiles.chunks(columns).enumerate().zip(captions.chunks(columns)) {
            let y = top + row as f64 * (side + caption_height + 16.0);
            for ((column, tile), caption) in tiles.iter().enumerate().zip(captions) {
                let x = MARGIN + column as f64 * (side + GAP);
                draw_tile(&mut svg, tile, Area { x, y, width: side, height: side });
                for (i, line) in caption.iter().enumerate() {
                    let base = y + side + 24.0 + i as f64 * CAPTION.size * 1.25;
                    svg.text((x + 0.5 * side, base), Anchor::Middle, CAPTION, INK, line);
                }
            }
        }
        let mut bottom = top + self.tiles.chunks(columns).count() as f64 * (side + caption_height + 16.0);
        for line in wrap(&self.note, NOTE, width - 2.0 * MARGIN, 4) {
            bottom += NOTE.size * 1.3;
            svg.text((MARGIN, bottom - 4.0), Anchor::Start, NOTE, SOFT, &line);
        }
        let names: Vec<String> = self.tiles.iter().map(described).collect();
        let title = if self.title.is_empty() { "Mosaics" } else { self.title.as_str() };
        Figure::new(
            svg,
            width,
            (bottom + MARGIN - 8.0).ceil(),
            title,
            &format!("{} {}", names.join(" "), self.note),
        )
    }
}

/// The mosaic in words: its rows of letters.
fn described(tile: &Tile) -> String {
    let rows: Vec<String> = tile
        .cells
        .chunks(tile.cols.max(1))
        .map(|row| row.iter().map(|c| c.letter.as_str()).collect::<Vec<_>>().join(" "))
        .collect();
    format!("{}: {}.", tile.caption, rows.join(" / "))
}

fn draw_tile(svg: &mut Svg, tile: &Tile, area: Area) {
    let (cols, rows) = (tile.cols, tile.cells.len() / tile.cols.max(1));
    // Half a period, at least one cell, surrounds the tile; a large tile is not repeated.
    let around = if cols.max(rows) > 8 { 0 } else { (cols.max(rows) / 2).max(1) };
    let (shown_cols, shown_rows) = (cols + 2 * around, rows + 2 * around);
    let pitch = area.width / shown_cols.max(shown_rows) as f64;
    let x0 = area.x + 0.5 * (area.width - pitch * shown_cols as f64);
    let y0 = area.y + 0.5 * (area.height - pitch * shown_rows as f64);
    let size = (pitch * 0.42).min(26.0);
    svg.open("", &tile.caption);
    for row in 0..shown_rows {
        for col in 0..shown_cols {
            let (r, c) = ((row + rows * around - around) % rows, (col + cols * around - around) % cols);
            let Some(cell) = tile.cells.get(r * cols + c) else { continue };
            let inside = (around..around + rows).contains(&row) && (around..around + cols).contains(&col);
            let color = if inside { cell.color } else { cell.color.mix(Rgb(255, 255, 255), 0.62) };
            let (x, y) = (x0 + pitch * col as f64, y0 + pitch * row as f64);
            let stroke = Some((Rgb(255, 255, 255), (pitch * 0.04).min(2.0)));
            let area = Area { x, y, width: pitch, height: pitch };
            svg.rect(area, Paint { stroke, ..Paint::fill(color, 1.0) });
            if inside && size >= 7.0 {
                let at = (x + 0.5 * pitch, y + 0.5 * pitch + size * 0.36);
                svg.text(at, Anchor::Middle, bold(size), cell.color.ink(), &cell.letter);
            }
        }
    }
    if around > 0 {
        let frame = Area {
            x: x0 + pitch * around as f64,
            y: y0 + pitch * around as f64,
            width: pitch * cols as f64,
            height: pitch * rows as f64,
        };
        svg.rect(frame, Paint::stroke(INK, 2.4));
    }
    svg.close();
}
