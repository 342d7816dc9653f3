//! The Siemens star: its frequency increases towards the centre in every direction.

use std::f64::consts::TAU;

use super::compose::{check_size, grey};
use super::raster::{Canvas, disc, sector};
use super::{Scene, SceneError, Setting};
use crate::numeric::require;

/// Dark spokes on white. At a radius r (pixels) the frequency is `cycles / (2π r)` cycles per pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SiemensStar {
    /// Rows and columns, 8 to 32768.
    pub size: usize,
    /// Dark spokes, 2 to 1024.
    pub cycles: usize,
    /// Luminance ratio of white to the spokes, more than 1.
    pub contrast_ratio: f64,
}

/// Draws the star; every pixel contains its exact mean. The radius of the star is 0.47 of the size. A white
/// disc of a fiftieth of that radius, with a dark dot, marks the centre.
///
/// # Errors
/// When a parameter or the setting is out of range.
pub fn siemens_star(star: &SiemensStar, setting: &Setting) -> Result<Scene, SceneError> {
    let SiemensStar { size, cycles, contrast_ratio } = *star;
    require((8..=32768).contains(&size), "size", size as f64, "8 to 32768")?;
    require((2..=1024).contains(&cycles), "cycles", cycles as f64, "2 to 1024")?;
    require(contrast_ratio > 1.0, "contrast_ratio", contrast_ratio, "more than 1")?;
    check_size(size, size, setting.grid)?;
    let dark = (1.0 / contrast_ratio) as f32;
    let centre = [size as f64 / 2.0; 2];
    let outer = 0.47 * size as f64;
    let inner = outer / 50.0;
    let turn = TAU / cycles as f64;
    let spoke = |i: usize| {
        let from = turn * (i as f64 - 0.25);
        sector(centre, [inner, outer], [from, from + turn / 2.0])
    };
    let spokes: Vec<_> = (0..cycles).map(spoke).collect();
    let mut canvas = Canvas::new(size, size, 1.0);
    canvas.fill(&spokes, dark);
    canvas.fill(&[disc(centre, inner / 3.0)], dark);
    grey("siemens-star", size, size, canvas.values(), setting)
}
