//! A grey step wedge, for tone curves and dynamic range.

use super::compose::{check_size, grey};
use super::{Scene, SceneError, Setting};
use crate::numeric::require;

/// Grey bars from bright (left) to dark, in equal steps of optical density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GreySteps {
    /// Number of bars, 2 to 4096.
    pub steps: usize,
    /// Columns of each bar, 1 to 4096.
    pub step_px: usize,
    /// Rows, 1 to 32768.
    pub rows: usize,
    /// Density of the darkest bar (the brightest has 0), more than 0 and at most 8: luminance spans 10^density.
    pub density: f64,
}

/// Draws the wedge.
///
/// # Errors
/// When a parameter or the setting is out of range.
pub fn grey_steps(wedge: &GreySteps, setting: &Setting) -> Result<Scene, SceneError> {
    let GreySteps { steps, step_px, rows, density } = *wedge;
    require((2..=4096).contains(&steps), "steps", steps as f64, "2 to 4096")?;
    require((1..=4096).contains(&step_px), "step_px", step_px as f64, "1 to 4096")?;
    require((1..=32768).contains(&rows), "rows", rows as f64, "1 to 32768")?;
    require(density > 0.0 && density <= 8.0, "density", density, "more than 0 and at most 8")?;
    let cols = steps * step_px;
    check_size(rows, cols, setting.grid)?;
    let value = |col: usize| {
        let share = (col / step_px) as f64 / (steps - 1) as f64;
        10f64.powf(-density * share) as f32
    };
    let row: Vec<f32> = (0..cols).map(value).collect();
    grey("grey-steps", rows, cols, &row.repeat(rows), setting)
}
