//! A grating whose frequency increases to the right and whose contrast increases downwards ([campbell1968]).
//!
//! [campbell1968]: https://doi.org/10.1113/jphysiol.1968.sp008574

use std::f64::consts::TAU;

use super::compose::{check_size, grey};
use super::quadrature::mean_over_pixel;
use super::{Scene, SceneError, Setting};
use crate::numeric::require;

/// A chirp whose frequency and contrast change geometrically from pixel to pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencySweep {
    /// Rows, 1 to 32768.
    pub rows: usize,
    /// Columns, 2 to 32768.
    pub cols: usize,
    /// Frequency at the left border, cycles per pixel, more than 0.
    pub lowest: f64,
    /// Frequency at the right border, cycles per pixel, more than `lowest` and at most 2.
    pub highest: f64,
    /// Contrast at the top, more than 0 and at most 1; the contrast at the bottom is 1.
    pub least_contrast: f64,
}

/// Draws the sweep; every pixel contains the mean over its width.
///
/// # Errors
/// When a parameter or the setting is out of range.
pub fn frequency_sweep(sweep: &FrequencySweep, setting: &Setting) -> Result<Scene, SceneError> {
    let FrequencySweep { rows, cols, lowest, highest, least_contrast } = *sweep;
    require((1..=32768).contains(&rows), "rows", rows as f64, "1 to 32768")?;
    require((2..=32768).contains(&cols), "cols", cols as f64, "2 to 32768")?;
    require(lowest > 0.0, "lowest", lowest, "more than 0")?;
    require(highest > lowest && highest <= 2.0, "highest", highest, "more than lowest and at most 2")?;
    let contrast_ok = least_contrast > 0.0 && least_contrast <= 1.0;
    require(contrast_ok, "least_contrast", least_contrast, "more than 0 and at most 1")?;
    check_size(rows, cols, setting.grid)?;
    // f(x) = lowest · exp(x · growth); the phase is 2π times its integral.
    let growth = (highest / lowest).ln() / cols as f64;
    let phase = |x: f64| TAU * lowest * (x * growth).exp_m1() / growth;
    let wave: Vec<f64> = (0..cols).map(|i| mean_over_pixel(i, |x| phase(x).sin())).collect();
    let last = (rows - 1).max(1) as f64;
    let mut reflectance = Vec::with_capacity(rows * cols);
    for row in 0..rows {
        let contrast = least_contrast.powf(1.0 - row as f64 / last);
        reflectance.extend(wave.iter().map(|w| (0.5 * (1.0 + contrast * w)).max(0.0) as f32));
    }
    grey("frequency-sweep", rows, cols, &reflectance, setting)
}
