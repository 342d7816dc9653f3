//! What the plotting crate draws, as our SVG: numbers rounded, texts escaped and set in our font.

use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;

use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{FontFamily, FontStyle, FontTransform, RGBAColor, ShapeStyle, TextStyle};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use crate::color::Rgb;
use crate::svg::{Anchor, Area, INK, Paint, Svg, path_of};
use crate::text::{Font, width};

/// A drawing that several write to.
pub(crate) type Canvas = Rc<RefCell<Svg>>;
pub(crate) type DrawError = DrawingErrorKind<Infallible>;

/// The plotting crate knows whole pixels only: what it takes for one is a hundredth.
const UNITS: f64 = 100.0;

pub(crate) fn units(pixels: f64) -> i32 {
    (pixels * UNITS).round() as i32
}

pub(crate) fn pixels((x, y): BackendCoord) -> (f64, f64) {
    (f64::from(x) / UNITS, f64::from(y) / UNITS)
}

/// A style of the plotting crate.
pub(crate) fn style(color: Rgb, opacity: f64, width: f64) -> ShapeStyle {
    let color = RGBAColor(color.0, color.1, color.2, opacity);
    ShapeStyle { color, filled: false, stroke_width: units(width).unsigned_abs() }
}

pub(crate) fn text_style(font: Font) -> TextStyle<'static> {
    let weight = if font.bold { FontStyle::Bold } else { FontStyle::Normal };
    let color = BackendColor { alpha: 1.0, rgb: (INK.0, INK.1, INK.2) };
    TextStyle { color, ..TextStyle::from((FontFamily::SansSerif, font.size * UNITS, weight)) }
}

/// A part of a drawing: where it begins, pixels, and its size.
pub(crate) struct Backend {
    pub(crate) svg: Canvas,
    pub(crate) origin: (f64, f64),
    pub(crate) size: (f64, f64),
}

impl Backend {
    fn at(&self, coord: BackendCoord) -> (f64, f64) {
        let (x, y) = pixels(coord);
        (self.origin.0 + x, self.origin.1 + y)
    }
}

fn rgb(color: BackendColor) -> Rgb {
    Rgb(color.rgb.0, color.rgb.1, color.rgb.2)
}

fn paint<S: BackendStyle>(style: &S, fill: bool) -> Paint {
    let color = style.color();
    if fill {
        return Paint { fill: Some((rgb(color), color.alpha)), stroke: None, dashed: false };
    }
    Paint::stroke(rgb(color), f64::from(style.stroke_width()) / UNITS)
}

impl DrawingBackend for Backend {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (units(self.size.0).unsigned_abs(), units(self.size.1).unsigned_abs())
    }

    fn ensure_prepared(&mut self) -> Result<(), DrawError> {
        Ok(())
    }

    fn present(&mut self) -> Result<(), DrawError> {
        Ok(())
    }

    fn draw_pixel(&mut self, at: BackendCoord, color: BackendColor) -> Result<(), DrawError> {
        self.draw_circle(at, 50, &color, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Result<(), DrawError> {
        let width = f64::from(style.stroke_width()) / UNITS;
        if style.color().alpha > 0.0 {
            self.svg.borrow_mut().line(self.at(from), self.at(to), rgb(style.color()), width);
        }
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Result<(), DrawError> {
        let ((x, y), (right, bottom)) = (self.at(from), self.at(to));
        self.svg.borrow_mut().rect(Area { x, y, width: right - x, height: bottom - y }, paint(style, fill));
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Result<(), DrawError> {
        let path: Vec<_> = path.into_iter().collect();
        if let [from, to] = path[..] {
            return self.draw_line(from, to, style);
        }
        if style.color().alpha > 0.0 {
            let points: Vec<_> = path.into_iter().map(|p| self.at(p)).collect();
            self.svg.borrow_mut().path(&path_of(&points, false), paint(style, false));
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Result<(), DrawError> {
        let radius = f64::from(radius) / UNITS;
        self.svg.borrow_mut().circle(self.at(center), radius, &Svg::paint(paint(style, fill)));
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Result<(), DrawError> {
        let points: Vec<_> = corners.into_iter().map(|p| self.at(p)).collect();
        self.svg.borrow_mut().raw_path(&path_of(&points, true), &Svg::paint(paint(style, true)));
        Ok(())
    }

    fn draw_text<T: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &T,
        at: BackendCoord,
    ) -> Result<(), DrawError> {
        if text.is_empty() {
            return Ok(());
        }
        let font = font(style);
        let anchor = match style.anchor().h_pos {
            HPos::Left => Anchor::Start,
            HPos::Center => Anchor::Middle,
            HPos::Right => Anchor::End,
        };
        let down = match style.anchor().v_pos {
            VPos::Top => 0.94,
            VPos::Center => 0.36,
            VPos::Bottom => -0.22,
        };
        let (x, y) = self.at(at);
        let color = rgb(style.color());
        let mut svg = self.svg.borrow_mut();
        match style.transform() {
            FontTransform::None => svg.text((x, y + down * font.size), anchor, font, color, text),
            _ => svg.text_up((x + down * font.size, y), font, color, text),
        }
        Ok(())
    }

    fn estimate_text_size<T: BackendTextStyle>(
        &self,
        text: &str,
        style: &T,
    ) -> Result<(u32, u32), DrawError> {
        let font = font(style);
        Ok((units(width(text, font)).unsigned_abs(), units(font.size * 1.2).unsigned_abs()))
    }
}

fn font<T: BackendTextStyle>(style: &T) -> Font {
    Font { size: style.size() / UNITS, bold: matches!(style.style(), FontStyle::Bold) }
}
