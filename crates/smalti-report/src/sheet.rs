//! Pictures side by side.

use crate::figure::{Compression, SIDE_LIMIT, check_size, encode, setters};
use crate::svg::{Anchor, Area, GRID, INK, Paint, SOFT, Svg};
use crate::text::{Font, bold, clean, plain, wrap};
use crate::{Figure, FigureError};

const MARGIN: f64 = 20.0;
const GAP: f64 = 20.0;
const TITLE: Font = bold(22.0);
const CAPTION: Font = plain(17.0);
const NOTE: Font = plain(14.0);

#[derive(Debug, Clone, PartialEq)]
struct Picture {
    caption: String,
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

/// Pictures side by side, each with its caption. At scale 1, a PNG contains their unchanged pixels. Small pictures can be enlarged by
/// integers without blur.
///
/// ```
/// use smalti_report::Sheet;
///
/// let grey = vec![128; 3 * 160 * 100];
/// let figure = Sheet::new(2).picture("best", 160, 100, &grey).picture("worst", 160, 100, &grey).draw()?;
/// assert!(figure.svg().contains("worst"));
/// # Ok::<(), smalti_report::FigureError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    title: String,
    note: String,
    columns: usize,
    enlarge: u32,
    pictures: Vec<Picture>,
}

impl Sheet {
    /// A sheet without pictures, with `columns` pictures per row.
    #[must_use]
    pub fn new(columns: usize) -> Self {
        Self {
            title: String::new(),
            note: String::new(),
            columns: columns.max(1),
            enlarge: 1,
            pictures: Vec::new(),
        }
    }

    setters! {
        /// Sets the title above all pictures.
        title(title: impl Into<String>) { title = title.into() }
        /// Sets a note in small print below.
        note(note: impl Into<String>) { note = note.into() }
        /// Draws each pixel as a square of `times` × `times` pixels.
        enlarge(times: u32) { enlarge = times.max(1) }
    }

    /// Adds a picture in 8-bit sRGB by rows, with three bytes per pixel.
    #[must_use]
    pub fn picture(mut self, caption: impl Into<String>, width: usize, height: usize, rgb: &[u8]) -> Self {
        self.pictures.push(Picture { caption: caption.into(), width, height, rgb: rgb.to_vec() });
        self
    }

    /// The figure.
    ///
    /// # Errors
    /// [`FigureError::Nothing`] without a picture, [`FigureError::Picture`] for a buffer whose length does not
    /// match its size, and [`FigureError::Size`] for a sheet that is too large.
    pub fn draw(&self) -> Result<Figure, FigureError> {
        Ok(self.laid_out(true)?.0)
    }

    /// The PNG of the [figure](Self::draw) at scale 1, with the same bytes, in less time: pictures are copied into it instead of
    /// being compressed for an SVG first.
    ///
    /// # Errors
    /// As [`draw`](Self::draw) and [`Figure::png`].
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let (figure, areas) = self.laid_out(false)?;
        let (mut rgb, size) = figure.pixels(1.0)?;
        let (across, times) = (3 * size[0] as usize, self.enlarge as usize);
        for (picture, area) in self.pictures.iter().zip(areas) {
            let (top, left) = (area.y as usize, 3 * area.x as usize);
            let rows = picture.rgb.chunks_exact(3 * picture.width);
            let rows = rows.flat_map(|row| std::iter::repeat_n(row, times));
            for (row, line) in rows.zip(rgb.chunks_exact_mut(across).skip(top)) {
                let places = line[left..].chunks_exact_mut(3 * times);
                for (pixel, place) in row.as_chunks::<3>().0.iter().zip(places) {
                    place.as_chunks_mut().0.fill(*pixel);
                }
            }
        }
        figure.encoded(&rgb, size)
    }

    /// The figure, with the pictures or only with room for them, and their areas, which begin at whole pixels.
    fn laid_out(&self, with_pictures: bool) -> Result<(Figure, Vec<Area>), FigureError> {
        if self.pictures.is_empty() {
            return Err(FigureError::Nothing { what: "picture" });
        }
        let times = f64::from(self.enlarge);
        for picture in &self.pictures {
            check_size(picture.width as f64 * times, picture.height as f64 * times)?;
            let expected = 3 * picture.width * picture.height;
            if picture.rgb.len() != expected {
                return Err(FigureError::Picture {
                    caption: clean(&picture.caption),
                    width: picture.width,
                    height: picture.height,
                    expected,
                    got: picture.rgb.len(),
                });
            }
        }
        let columns = self.columns.min(self.pictures.len());
        let cell = self.pictures.iter().map(|p| p.width as f64 * times).fold(0.0, f64::max).max(120.0);
        let width = 2.0 * MARGIN + columns as f64 * (cell + GAP) - GAP;
        let (mut svg, mut areas) = (Svg::default(), Vec::with_capacity(self.pictures.len()));
        let mut y = MARGIN;
        for line in wrap(&self.title, TITLE, width - 2.0 * MARGIN, 3) {
            y += (TITLE.size * 1.25).round();
            svg.text((MARGIN, y - 6.0), Anchor::Start, TITLE, INK, &line);
        }
        if y > MARGIN {
            y += 10.0;
        }
        for row in self.pictures.chunks(columns) {
            let height = row.iter().map(|p| p.height as f64 * times).fold(0.0, f64::max);
            let captions: Vec<Vec<String>> = row.iter().map(|p| wrap(&p.caption, CAPTION, cell, 3)).collect();
            for ((column, picture), caption) in row.iter().enumerate().zip(&captions) {
                let (w, h) = (picture.width as f64 * times, picture.height as f64 * times);
                let left = MARGIN + column as f64 * (cell + GAP);
                // Pictures begin at whole pixels to avoid blur.
                let area =
                    Area { x: (left + 0.5 * (cell - w)).floor(), y: y + (height - h), width: w, height: h };
                svg.open("", &picture.caption);
                let edge = Area { x: area.x - 0.5, y: area.y - 0.5, width: w + 1.0, height: h + 1.0 };
                svg.rect(edge, Paint::stroke(GRID, 1.0));
                if with_pictures {
                    let size = [picture.width as u32, picture.height as u32];
                    let png = encode(&picture.rgb, size, png::ColorType::Rgb, Compression::Fast)?;
                    svg.image(area, &png, true);
                }
                areas.push(area);
                svg.close();
                for (i, line) in caption.iter().enumerate() {
                    let base = y + height + 22.0 + i as f64 * (CAPTION.size * 1.25).round();
                    svg.text((left + 0.5 * cell, base), Anchor::Middle, CAPTION, INK, line);
                }
            }
            let lines = captions.iter().map(Vec::len).max().unwrap_or(0) as f64;
            y += height + 12.0 + lines * (CAPTION.size * 1.25).round() + 14.0;
            if y > SIDE_LIMIT {
                check_size(width, y)?;
            }
        }
        for line in wrap(&self.note, NOTE, width - 2.0 * MARGIN, 4) {
            y += (NOTE.size * 1.3).round();
            svg.text((MARGIN, y - 6.0), Anchor::Start, NOTE, SOFT, &line);
        }
        let names: Vec<&str> = self.pictures.iter().map(|p| p.caption.as_str()).collect();
        let title = if self.title.is_empty() { "Pictures" } else { self.title.as_str() };
        let description = format!("{} pictures: {}. {}", names.len(), names.join("; "), self.note);
        let figure = Figure::new(svg, width, y + MARGIN - 12.0, title, &description)?;
        Ok((figure.of_pictures(), areas))
    }
}
