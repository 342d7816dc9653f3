//! The slanted edge for measuring the spatial frequency response (ISO 12233).

use super::compose::{check_size, grey};
use super::raster::Canvas;
use super::{PatternSampling, Scene, SceneError, Setting};
use crate::numeric::require;

/// A straight edge through the centre. With a positive slope, the half to its left is bright.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlantedBar {
    /// Size, 1 to 32768. The scene has `2 * round(size / 2) + 1` rows and columns, so that the edge passes
    /// through the centre of a pixel.
    pub size: usize,
    /// Slope of the edge, rows per column, not 0; the edge is `atan(1 / slope)` from the vertical.
    pub slope: f64,
    /// Luminance ratio of the bright half to the dark half, more than 1.
    pub contrast_ratio: f64,
    /// `Isetcam`: a pixel is bright when its centre is strictly on the bright side. `Area`: a pixel contains
    /// the mean.
    pub sampling: PatternSampling,
}

impl Default for SlantedBar {
    /// As ISETCam's `sceneCreate('slantedBar', 512)`: 513 × 513, slope 7/3 (23.2° from the vertical), contrast 10⁶.
    fn default() -> Self {
        Self { size: 512, slope: 7.0 / 3.0, contrast_ratio: 1e6, sampling: PatternSampling::Isetcam }
    }
}

impl SlantedBar {
    /// The slope of an edge at an angle of `angle_deg` degrees from the vertical.
    #[must_use]
    pub fn slope_of_angle(angle_deg: f64) -> f64 {
        1.0 / angle_deg.to_radians().tan()
    }
}

/// Draws the edge.
///
/// [`PatternSampling::Isetcam`] applies ISETCam's rule in exact arithmetic: with the row Y and the column X
/// counted from the central pixel, a pixel is bright where Y > slope·X. ISETCam compares in single precision,
/// so a few pixels whose centres lie on the edge itself differ.
///
/// # Errors
/// When a parameter or the setting is out of range.
pub fn slanted_bar(bar: &SlantedBar, setting: &Setting) -> Result<Scene, SceneError> {
    let SlantedBar { size, slope, contrast_ratio, sampling } = *bar;
    require((1..=32768).contains(&size), "size", size as f64, "1 to 32768")?;
    require(slope != 0.0, "slope", slope, "a finite number, not 0")?;
    require(contrast_ratio > 1.0, "contrast_ratio", contrast_ratio, "more than 1")?;
    let half = size.div_ceil(2);
    let n = 2 * half + 1;
    check_size(n, n, setting.grid)?;
    let dark = (1.0 / contrast_ratio) as f32;
    let reflectance = match sampling {
        PatternSampling::Isetcam => {
            let from_centre = |i: usize| i as f64 - half as f64;
            let value = |i: usize| if from_centre(i / n) > slope * from_centre(i % n) { 1.0 } else { dark };
            (0..n * n).map(value).collect()
        }
        PatternSampling::Area => {
            let mut canvas = Canvas::new(n, n, dark);
            // The edge and a box beyond the image bound the bright half-plane.
            let (middle, reach) = (n as f64 / 2.0, 2.0 * n as f64);
            let length = slope.hypot(1.0);
            let along = [reach / length, reach * slope / length];
            // The normal points towards larger Y - slope * X.
            let across = [-along[1], along[0]];
            let corner = |u: f64, v: f64| {
                [middle + u * along[0] + v * across[0], middle + u * along[1] + v * across[1]]
            };
            canvas
                .fill(&[vec![corner(-1.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(-1.0, 1.0)]], 1.0);
            canvas.values().to_vec()
        }
    };
    grey("slanted-bar", n, n, &reflectance, setting)
}
