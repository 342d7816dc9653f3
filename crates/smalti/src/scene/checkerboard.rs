//! A checkerboard.

use super::compose::{check_size, grey};
use super::{Scene, SceneError, Setting};
use crate::numeric::require;

/// Alternating white and dark squares, with white at the top left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checkerboard {
    /// Squares in each direction, 1 to 4096.
    pub squares: usize,
    /// Rows and columns of a square in pixels, 1 to 4096.
    pub square_px: usize,
    /// Ratio of the luminances of white and dark squares, more than 1.
    pub contrast_ratio: f64,
}

/// Draws the checkerboard. Its edges coincide with pixel borders, so no antialiasing is needed.
///
/// # Errors
/// When a parameter or the setting is out of range.
pub fn checkerboard(board: &Checkerboard, setting: &Setting) -> Result<Scene, SceneError> {
    let Checkerboard { squares, square_px, contrast_ratio } = *board;
    require((1..=4096).contains(&squares), "squares", squares as f64, "1 to 4096")?;
    require((1..=4096).contains(&square_px), "square_px", square_px as f64, "1 to 4096")?;
    require(contrast_ratio > 1.0, "contrast_ratio", contrast_ratio, "more than 1")?;
    let n = squares * square_px;
    check_size(n, n, setting.grid)?;
    let dark = (1.0 / contrast_ratio) as f32;
    let value = |i: usize| if (i / n / square_px + i % n / square_px).is_multiple_of(2) { 1.0 } else { dark };
    let reflectance: Vec<f32> = (0..n * n).map(value).collect();
    grey("checkerboard", n, n, &reflectance, setting)
}
