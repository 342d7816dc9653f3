//! Bright points on black, which show the point spread function over the field.

use super::compose::{check_size, grey};
use super::raster::{Canvas, disc};
use super::{Scene, SceneError, Setting};
use crate::numeric::require;

/// A square grid of bright discs on black, symmetric about the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointGrid {
    /// Points in each direction, 1 to 1024.
    pub points: usize,
    /// Distance between neighbouring points in pixels, 2 to 4096.
    pub spacing_px: usize,
    /// Diameter of a point in pixels, more than 0 and less than the spacing.
    pub diameter_px: f64,
}

/// Draws the grid; the scene has `points * spacing_px` rows and columns.
///
/// # Errors
/// When a parameter or the setting is out of range.
pub fn point_grid(grid: &PointGrid, setting: &Setting) -> Result<Scene, SceneError> {
    let PointGrid { points, spacing_px, diameter_px } = *grid;
    require((1..=1024).contains(&points), "points", points as f64, "1 to 1024")?;
    require((2..=4096).contains(&spacing_px), "spacing_px", spacing_px as f64, "2 to 4096")?;
    let diameter_ok = diameter_px >= 0.1 && diameter_px < spacing_px as f64;
    require(diameter_ok, "diameter_px", diameter_px, "at least 0.1 and less than the spacing")?;
    let n = points * spacing_px;
    check_size(n, n, setting.grid)?;
    let mut canvas = Canvas::new(n, n, 0.0);
    let at = |i: usize| (i as f64 + 0.5) * spacing_px as f64;
    for i in 0..points * points {
        canvas.fill(&[disc([at(i % points), at(i / points)], diameter_px / 2.0)], 1.0);
    }
    grey("point-grid", n, n, canvas.values(), setting)
}
