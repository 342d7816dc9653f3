//! Clouds of points, drawn as shapes, or as an embedded picture where there are many.

use resvg::tiny_skia::{Color, FillRule, Paint, PathBuilder, Pixmap, Transform};

use crate::FigureError;
use crate::color::Rgb;
use crate::figure::{Compression, encode};
use crate::layers::Symbol;
use crate::svg::{Area, Svg, number, path_of};

/// The most pixels of an embedded picture, which limits time and memory.
const PIXELS_LIMIT: f64 = 2e7;

pub(crate) struct Dot {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) radius: f64,
    pub(crate) color: Rgb,
    pub(crate) symbol: Symbol,
    pub(crate) series: usize,
    pub(crate) index: usize,
}

/// Draws dots in a reproducible shuffled order, so that no series and no part of a file hides the others.
pub(crate) fn draw_cloud(
    svg: &mut Svg,
    area: Area,
    mut dots: Vec<Dot>,
    opacity: f64,
    picture_bytes: Option<usize>,
) -> Result<(), FigureError> {
    let margin = |d: &Dot| 2.0 * d.radius;
    dots.retain(|d| {
        (area.x - margin(d)..=area.x + area.width + margin(d)).contains(&d.x)
            && (area.y - margin(d)..=area.y + area.height + margin(d)).contains(&d.y)
    });
    if dots.is_empty() {
        return Ok(());
    }
    dots.sort_by_cached_key(|d| (mixed((d.series as u64) << 40 ^ d.index as u64), d.series, d.index));
    if let Some(limit) = picture_bytes {
        return draw_picture(svg, area, &dots, opacity, limit);
    }
    svg.open(&format!(" fill-opacity=\"{}\"", number(opacity)), "");
    for dot in &dots {
        let fill = format!(" fill=\"{}\"", dot.color);
        match dot.symbol.outline((dot.x, dot.y), dot.radius) {
            None => svg.circle((dot.x, dot.y), dot.radius, &fill),
            Some(corners) => svg.raw_path(&path_of(&corners, true), &fill),
        }
    }
    svg.close();
    Ok(())
}

/// A hash of a number: the finaliser of SplitMix64.
fn mixed(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ z >> 31
}

/// Embeds a picture with two pixels per pixel of the figure, or fewer where it would exceed the limit of bytes.
fn draw_picture(
    svg: &mut Svg,
    area: Area,
    dots: &[Dot],
    opacity: f64,
    limit: usize,
) -> Result<(), FigureError> {
    let mut scale = (PIXELS_LIMIT / (area.width * area.height)).sqrt().min(2.0);
    let mut png = picture(area, dots, opacity, scale)?;
    while png.len() > limit && scale > 0.25 {
        // The number of bytes is about proportional to that of pixels.
        scale = (scale * 0.95 * (limit as f64 / png.len() as f64).sqrt()).max(0.25);
        png = picture(area, dots, opacity, scale)?;
    }
    svg.open("", &format!("{} points, drawn as a picture", dots.len()));
    svg.image(area, &png, false);
    svg.close();
    Ok(())
}

fn picture(area: Area, dots: &[Dot], opacity: f64, scale: f64) -> Result<Vec<u8>, FigureError> {
    let (width, height) = ((area.width * scale).round(), (area.height * scale).round());
    let too_large = || FigureError::Size { width, height, reason: "no memory for its pixels".to_owned() };
    let mut pixels = Pixmap::new(width as u32, height as u32).ok_or_else(too_large)?;
    pixels.fill(Color::TRANSPARENT);
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    for dot in dots {
        paint.set_color_rgba8(dot.color.0, dot.color.1, dot.color.2, (opacity * 255.0).round() as u8);
        let scaled = |(x, y): (f64, f64)| ((x * scale) as f32, (y * scale) as f32);
        let center = (dot.x - area.x, dot.y - area.y);
        let mut path = PathBuilder::new();
        match dot.symbol.outline(center, dot.radius) {
            None => {
                let (x, y) = scaled(center);
                path.push_circle(x, y, (dot.radius * scale) as f32);
            }
            Some(corners) => {
                for (i, (x, y)) in corners.into_iter().map(scaled).enumerate() {
                    if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
                }
                path.close();
            }
        }
        if let Some(path) = path.finish() {
            pixels.fill_path(&path, &paint, FillRule::Winding, Transform::identity(), None);
        }
    }
    let rgba: Vec<u8> = pixels
        .pixels()
        .iter()
        .map(|p| p.demultiply())
        .flat_map(|p| [p.red(), p.green(), p.blue(), p.alpha()])
        .collect();
    encode(&rgba, [width as u32, height as u32], png::ColorType::Rgba, Compression::Small)
}
