//! The patches of a colour chart, each split into the reference above and the rendered colour below.

use smalti::color::srgb8_from_lab;

use crate::color::Rgb;
use crate::figure::setters;
use crate::svg::{Anchor, Area, GRID, INK, Paint, SOFT, Svg};
use crate::text::{Font, bold, clean, plain, wrap};
use crate::{Figure, FigureError};

/// The side of a patch and the space between two, pixels.
const SIDE: f64 = 84.0;
const GAP: f64 = 6.0;
const MARGIN: f64 = 12.0;
const TITLE: Font = bold(19.0);
const NOTE: Font = plain(15.0);
const VALUE: Font = bold(17.0);

impl Rgb {
    /// The colour of CIELAB on a display, whose white stands for the white of CIELAB. What the display cannot show is clipped.
    #[must_use]
    pub fn of_lab(lab: [f64; 3]) -> Self {
        let [r, g, b] = srgb8_from_lab(lab);
        Self(r, g, b)
    }
}

/// A patch: CIELAB of the reference and of the rendering, and their difference.
#[derive(Debug, Clone, PartialEq)]
struct Patch {
    name: String,
    reference_lab: [f64; 3],
    rendered_lab: [f64; 3],
    difference: f64,
}

/// A drawing of the patches of a colour chart: the upper half of each has the reference colour, the lower half the rendered one, with
/// their difference as a number.
///
/// ```
/// use smalti_report::SplitPatches;
///
/// let figure = SplitPatches::new(1).patch("red", [42.0, 55.0, 28.0], [44.0, 50.0, 30.0], 3.1).draw()?;
/// assert!(figure.svg().contains("red: 3.1"));
/// # Ok::<(), smalti_report::FigureError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SplitPatches {
    columns: usize,
    title: String,
    note: String,
    patches: Vec<Patch>,
}

impl SplitPatches {
    /// A drawing without patches, with `columns` patches in a row.
    #[must_use]
    pub fn new(columns: usize) -> Self {
        Self { columns: columns.max(1), title: String::new(), note: String::new(), patches: Vec::new() }
    }

    setters! {
        /// Sets the title above the patches.
        title(title: impl Into<String>) { title = title.into() }
        /// Sets a note in small print below.
        note(note: impl Into<String>) { note = note.into() }
    }

    /// Adds a patch with its name, CIELAB of the reference and of the rendering, and the difference of the two.
    #[must_use]
    pub fn patch(
        mut self,
        name: impl Into<String>,
        reference_lab: [f64; 3],
        rendered_lab: [f64; 3],
        difference: f64,
    ) -> Self {
        self.patches.push(Patch { name: name.into(), reference_lab, rendered_lab, difference });
        self
    }

    /// The figure.
    ///
    /// # Errors
    /// [`FigureError::Nothing`] without a patch, and [`FigureError::Size`].
    pub fn draw(&self) -> Result<Figure, FigureError> {
        if self.patches.is_empty() {
            return Err(FigureError::Nothing { what: "patch" });
        }
        let columns = self.columns.min(self.patches.len());
        let width = 2.0 * MARGIN + columns as f64 * (SIDE + GAP) - GAP;
        let mut svg = Svg::default();
        let mut top = MARGIN;
        for line in wrap(&self.title, TITLE, width - 2.0 * MARGIN, 2) {
            top += 1.25 * TITLE.size;
            svg.text((MARGIN, top - 8.0), Anchor::Start, TITLE, INK, &line);
        }
        for (i, patch) in self.patches.iter().enumerate() {
            let x = MARGIN + (i % columns) as f64 * (SIDE + GAP);
            let y = top + (i / columns) as f64 * (SIDE + GAP);
            draw_patch(&mut svg, patch, (x, y));
        }
        let mut bottom = top + self.patches.len().div_ceil(columns) as f64 * (SIDE + GAP);
        for line in wrap(&self.note, NOTE, width - 2.0 * MARGIN, 4) {
            bottom += 1.3 * NOTE.size;
            svg.text((MARGIN, bottom - 2.0), Anchor::Start, NOTE, SOFT, &line);
        }
        let title = if self.title.is_empty() { "Patches of a colour chart" } else { &self.title };
        let all: Vec<String> = self.patches.iter().map(described).collect();
        let description =
            format!("Difference of each patch from the reference: {}. {}", all.join("; "), self.note);
        Figure::new(svg, width, (bottom + MARGIN).ceil(), title, &description)
    }
}

fn described(patch: &Patch) -> String {
    format!("{}: {:.1}", clean(&patch.name), patch.difference)
}

fn draw_patch(svg: &mut Svg, patch: &Patch, (x, y): (f64, f64)) {
    svg.open("", &described(patch));
    let half = Area { x, y, width: SIDE, height: 0.5 * SIDE };
    svg.rect(half, Paint::fill(Rgb::of_lab(patch.reference_lab), 1.0));
    let rendered = Rgb::of_lab(patch.rendered_lab);
    svg.rect(Area { y: y + 0.5 * SIDE, ..half }, Paint::fill(rendered, 1.0));
    // White patches need an outline on white.
    svg.rect(Area { height: SIDE, ..half }, Paint::stroke(GRID, 1.0));
    let value = format!("{:.1}", patch.difference);
    svg.text((x + 0.5 * SIDE, y + SIDE - 9.0), Anchor::Middle, VALUE, rendered.ink(), &value);
    svg.close();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_shows_the_reference_above_the_rendering() {
        let figure =
            SplitPatches::new(2).patch("a", [100.0, 0.0, 0.0], [0.0, 0.0, 0.0], 99.5).draw().unwrap();
        let svg = figure.svg();
        let (white, black) =
            (svg.rfind("#ffffff\"/>").unwrap(), svg.rfind("height=\"42\" fill=\"#000000\"").unwrap());
        assert!(white < black && svg.contains(">99.5</text>") && svg.contains("a: 99.5"), "{svg}");
        assert!(matches!(SplitPatches::new(2).draw(), Err(FigureError::Nothing { what: "patch" })));
    }
}
